"""Gas torque of a cylinder from harmonics of tangential pressure over the load."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.gas_tables import card_weights
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray, distinct

# ----------------------------------------------------------------------------
# Tangential pressure t on the piston area A at the crank radius R turns the crank with A R t:
#
#     T(phi) = A R (t_mean + sum_n a_n cos(n phi) + b_n sin(n phi)),   a_n, b_n over the load,
#
# phi from the firing dead centre. The load is the mean indicated pressure p, whose work over a
# cycle of the angle P is p times the swept volume V, so that the mean torque is p V / P.
# ----------------------------------------------------------------------------


class EffortTable(NamedTuple):
    """Harmonics a - i b (p, m) in Pa at loads (p,) in Pa, ascending, for orders (m,), ascending."""

    load: FloatArray
    order: FloatArray
    pressure: ComplexArray


class GasOverSpeed(NamedTuple):
    """Harmonics (c, m) and mean (c,) in N m at speeds (c,) in rad/s; none for all speeds."""

    speed: FloatArray
    gas: Bounded
    mean: Bounded


def effort_table(
    load: ArrayLike, order: ArrayLike, cosine: ArrayLike, sine: ArrayLike
) -> EffortTable:
    """From rows (r,) in any sequence, each order once at each load."""
    loads, orders = np.asarray(load, dtype=float), np.asarray(order, dtype=float)
    every, numbers = distinct(loads), distinct(orders)
    pressure = np.zeros((len(every), len(numbers)), dtype=complex)
    place = np.searchsorted(every, loads), np.searchsorted(numbers, orders)
    pressure[place] = np.asarray(cosine, dtype=float) - 1j * np.asarray(sine, dtype=float)
    return EffortTable(every, numbers, pressure)


def effort_torque(
    table: EffortTable,
    speed: ArrayLike,
    load: ArrayLike,
    order: ArrayLike,
    *,
    lever: float,
    swept_volume: float,
    cycle: float,
) -> GasOverSpeed:
    """Gas torque at orders (m,) for loads (s,) in Pa at speeds (s,), both straight in between.

    `lever` is piston area times crank radius in m^3, `cycle` in rad. One load and no speed holds at
    every speed. Between the speeds that are given back the torque is straight, too: speeds at
    which the load passes a row of the table are among them. Orders that the table lacks are zero.

    Raises
    ------
    NumericalFailure
        A load is outside the table: nothing is extrapolated.
    """
    at, p = np.asarray(speed, dtype=float), np.asarray(load, dtype=float)
    low, high = table.load[0], table.load[-1]
    if np.min(p) < low or np.max(p) > high:
        raise NumericalFailure(
            f"tangential effort: a mean indicated pressure of {1e-5 * np.min(p):.4g} to "
            f"{1e-5 * np.max(p):.4g} bar is not inside the table, {1e-5 * low:.4g} to "
            f"{1e-5 * high:.4g} bar"
        )
    if len(at) > 1:
        at, p = _with_rows(at, p, table.load)
    share, orders = card_weights(table.load, p), np.asarray(order, dtype=float)
    column = np.minimum(np.searchsorted(table.order, orders), len(table.order) - 1)
    rows = table.pressure[:, column] * (table.order[column] == orders)
    value, size = share @ rows, share @ np.abs(rows)
    gas, mean = lever * value, p * swept_volume / cycle
    off = 8.0 * EPSILON * (lever * size + _moved(at, gas))
    return GasOverSpeed(
        at,
        Bounded(gas, off),
        Bounded(mean, 8.0 * EPSILON * (np.abs(mean) + _moved(at, mean))),
    )


def _with_rows(
    speed: FloatArray, load: FloatArray, rows: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Speeds and loads with those at which the load passes one of the `rows`."""
    found = dict(zip(speed.tolist(), load.tolist(), strict=True))
    first, last = load[:-1], load[1:]
    for row in rows.tolist():
        passes = (np.minimum(first, last) < row) & (row < np.maximum(first, last))
        share = (row - first[passes]) / (last - first)[passes]
        for at in (speed[:-1][passes] + share * np.diff(speed)[passes]).tolist():
            found.setdefault(at, row)
    every = np.array(sorted(found.items()))
    return every[:, 0], every[:, 1]


def _moved(speed: FloatArray, value: FloatArray | ComplexArray) -> FloatArray:
    """Change of values (s, ...) over the steeper neighbour, per relative change of their speed."""
    if len(speed) < 2:
        return np.zeros(np.shape(value))
    width = np.diff(speed).reshape(-1, *[1] * (np.ndim(value) - 1))
    slope = np.abs(np.diff(value, axis=0)) / width
    steeper = np.maximum(np.concatenate([slope[:1], slope]), np.concatenate([slope, slope[-1:]]))
    return np.asarray(steeper * speed.reshape(-1, *[1] * (np.ndim(value) - 1)))
