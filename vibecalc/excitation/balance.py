"""The balance table of a crank train: sums of sin, cos, z sin and z cos over the cylinders."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.excitation.sums import Real
from vibecalc.numerics.rounding import EPSILON


class BalanceTable(NamedTuple):
    """Entries (..., n, c) and totals (..., n) for n orders and c cylinders, with their errors.

    Sines and cosines have no unit, those times the position are in m. A total whose magnitude is
    below its error is zero as far as the angles, as stored, can tell.
    """

    sine: Real
    cosine: Real
    position_sine: Real
    position_cosine: Real
    total_sine: Real
    total_cosine: Real
    total_position_sine: Real
    total_position_cosine: Real
    sine_error: Real
    cosine_error: Real
    position_sine_error: Real
    position_cosine_error: Real
    total_sine_error: Real
    total_cosine_error: Real
    total_position_sine_error: Real
    total_position_cosine_error: Real


def balance_table(
    orders: ArrayLike, *, crank_phase: ArrayLike, bank_angle: ArrayLike, position: ArrayLike
) -> BalanceTable:
    """Sums that say what of order n is balanced (Biezeno and Grammel, Technische Dynamik).

    Parameters
    ----------
    orders
        (n,) whole numbers.
    crank_phase, bank_angle, position
        (..., c) in rad, rad and m along the crankshaft. A cylinder counts with the angle
        n (crank_phase - bank_angle); masses are not in the table.
    """
    angle = np.asarray(crank_phase, dtype=float) - np.asarray(bank_angle, dtype=float)
    turn = np.asarray(orders)[:, None] * angle[..., None, :]
    slip = EPSILON * np.abs(turn)
    sine, cosine = np.sin(turn), np.cos(turn)
    # The angle's own rounding moves a sine by the cosine and the other way round.
    sine_error = EPSILON * np.abs(sine) + slip * (np.abs(cosine) + slip)
    cosine_error = EPSILON * np.abs(cosine) + slip * (np.abs(sine) + slip)
    place = np.asarray(position, dtype=float)[..., None, :]
    entries = (sine, cosine, place * sine, place * cosine)
    reach = np.abs(place)
    errors = (
        sine_error,
        cosine_error,
        reach * (sine_error + EPSILON * np.abs(sine)),
        reach * (cosine_error + EPSILON * np.abs(cosine)),
    )
    totals = [entry.sum(-1) for entry in entries]
    totals_error = [
        (error + EPSILON * np.abs(entry)).sum(-1)
        for entry, error in zip(entries, errors, strict=True)
    ]
    return BalanceTable._make((*entries, *totals, *errors, *totals_error))
