"""The balance table of a crank train, and one number for what it leaves unbalanced."""

from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vibecalc.excitation.inertia_forces import Complex, Excitation, Real
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON

# ----------------------------------------------------------------------------
# The balance table of a crank train: sums of sin, cos, z sin and z cos over the cylinders.
#
# Cylinders of one bank push along one line, so that numbers add. Those of several banks do not:
# their sums are vectors across the crankshaft.
# ----------------------------------------------------------------------------


class PlacedTrain(Protocol):
    """What the sums read of a crank train, or of the trains of many points."""

    @property
    def crank_phase(self) -> Any: ...
    @property
    def bank_angle(self) -> Any: ...
    @property
    def position(self) -> Any: ...
    @property
    def stroke(self) -> Any: ...
    @property
    def across(self) -> Any: ...


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


class BankSums(NamedTuple):
    """Sums over cylinders in several banks of vectors exp(i n a) along each cylinder's axis.

    `sum` (..., n, 3) is complex; `rotating` and `counter_rotating` (..., n) are the lengths of the
    two circular parts, the first of which turns with the crank, n times as fast: the end of the
    vector moves on an ellipse whose half axes are their sum and difference. Those with `position_`
    are weighted with the position along the crankshaft, in m. One cylinder alone has 1, and halves.
    """

    sum: Complex
    position_sum: Complex
    rotating: Real
    counter_rotating: Real
    position_rotating: Real
    position_counter_rotating: Real
    sum_error: Real
    position_sum_error: Real
    rotating_error: Real
    counter_rotating_error: Real
    position_rotating_error: Real
    position_counter_rotating_error: Real


def bank_sums(
    orders: ArrayLike,
    *,
    crank_phase: ArrayLike,
    bank_angle: ArrayLike,
    position: ArrayLike,
    stroke: ArrayLike,
    across: ArrayLike,
) -> BankSums:
    """Vector sums of order n over the cylinders; arrays as in `balance_table`.

    `stroke` and `across` are (3,) unit vectors. With a = crank_phase - bank_angle and the axis
    stroke cos b - across sin b of a cylinder, a vector in the sense of rotation is
    exp(i (n a + b)) / 2, one against it exp(i (n a - b)) / 2.
    """
    bank = np.asarray(bank_angle, dtype=float)[..., None, :]
    angle = np.asarray(crank_phase, dtype=float)[..., None, :] - bank
    turn = np.asarray(orders)[:, None] * angle
    place = np.asarray(position, dtype=float)[..., None, :]
    slip = EPSILON * (2.0 + np.abs(turn) + np.abs(bank))

    def summed(weight: Real) -> tuple[Complex, Real, Real, Real]:
        error = (np.abs(weight) * (3.0 * slip + EPSILON * turn.shape[-1])).sum(-1)
        phasor = weight * np.exp(1j * turn)
        along, sideways = (phasor * np.cos(bank)).sum(-1), -(phasor * np.sin(bank)).sum(-1)
        vector = along[..., None] * np.asarray(stroke) + sideways[..., None] * np.asarray(across)
        # across points against the sense of rotation
        ahead, back = (0.5 * np.abs(along - 1j * sign * sideways) for sign in (1.0, -1.0))
        return vector, ahead, back, error

    force, ahead, back, error = summed(np.ones_like(place))
    couple, couple_ahead, couple_back, couple_error = summed(place)
    wide, couple_wide = np.ones(3) * error[..., None], np.ones(3) * couple_error[..., None]
    return BankSums(
        force, couple, ahead, back, couple_ahead, couple_back,
        wide, couple_wide, error, error, couple_error, couple_error,
    )  # fmt: skip


def balance_columns(
    orders: ArrayLike, train: PlacedTrain
) -> tuple[dict[str, Bounded], dict[str, Bounded]]:
    """Every column of the table by name, with its sums as numbers; and the sums as vectors."""
    angles = {"crank_phase": train.crank_phase, "bank_angle": train.bank_angle}
    table = balance_table(orders, **angles, position=train.position)
    sums = bank_sums(
        orders, **angles, position=train.position, stroke=train.stroke, across=train.across
    )
    columns = zip(BalanceTable._fields[:8], map(Bounded, table[:8], table[8:]), strict=True)
    vectors = zip(BankSums._fields[:6], map(Bounded, sums[:6], sums[6:]), strict=True)
    return dict(columns), dict(vectors)


# ----------------------------------------------------------------------------
# One number for what a crank train leaves unbalanced.
# ----------------------------------------------------------------------------


def _norm(parts: NDArray[np.float64]) -> Real:
    """Euclidean norm over the last three axes, free of overflow."""
    largest = parts.max(axis=(-3, -2, -1), keepdims=True, initial=0.0)
    scale = np.where(largest > 0.0, largest, 1.0)
    root = np.sqrt(((parts / scale) ** 2).sum(axis=(-3, -2, -1)))
    return np.asarray(scale[..., 0, 0, 0] * root)


def residual(
    excitation: Excitation,
    *,
    force_weight: ArrayLike = 1.0,
    couple_weight: ArrayLike = 1.0,
    reference_length: ArrayLike,
) -> Bounded:
    """Size (...) of all forces and couples as one number, and its error:

    sqrt(sum over orders of wf^2 |F_n|^2 + wc^2 |M_n|^2 / l^2), in N, at the speed of the input.

    All orders of the excitation count, each vector with its three complex components. The value is
    a norm: it is smooth in angles and masses except where it is zero, as a cone is smooth except
    at its tip. A search that ends in full balance had better work with its square, which is smooth
    everywhere. The error is the same norm of the errors (triangle inequality) plus rounding.
    """
    wf = np.asarray(force_weight, dtype=float)[..., None, None]
    wc = (np.asarray(couple_weight, dtype=float) / np.asarray(reference_length, dtype=float))[
        ..., None, None
    ]

    def stack(force: Real, couple: Real) -> Real:
        return np.stack(np.broadcast_arrays(wf * force, wc * couple), axis=-3)

    value = _norm(stack(np.abs(excitation.force), np.abs(excitation.couple)))
    error = _norm(stack(excitation.force_error, excitation.couple_error))
    return Bounded(value, error + 3.0 * EPSILON * value)
