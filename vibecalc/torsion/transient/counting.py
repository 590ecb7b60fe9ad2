"""Cycles of the torque in a section over a run by rainflow, and the fatigue they use up."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import FloatArray

# ----------------------------------------------------------------------------
# Cycles of reversals by the rainflow method of ASTM E1049-85, 5.4.4, and their table.
# ----------------------------------------------------------------------------


class Cycles(NamedTuple):
    """c cycles: `range` and `mean` (c,) in N m, `number` (c,) 1 or 1/2, `error` (c,) of the range.

    A range is crest less trough, twice the amplitude.
    """

    range: FloatArray
    mean: FloatArray
    number: FloatArray
    error: FloatArray


def rainflow_cycles(value: FloatArray, error: FloatArray, ignore: float = 0.0) -> Cycles:
    """Cycles of a trace (r,); those below the share `ignore` of the largest range are left out."""
    from rainflow import extract_cycles

    rows = np.array(list(extract_cycles(value)), dtype=float).reshape(-1, 5)
    ends = rows[:, 3:].astype(np.int64)
    off = error[ends].sum(axis=1)
    kept = rows[:, 0] >= ignore * np.max(rows[:, 0], initial=0.0)
    kept &= rows[:, 0] > 0.0
    return Cycles(rows[kept, 0], rows[kept, 1], rows[kept, 2], off[kept])


class RangeTable(NamedTuple):
    """b equal bins up to the largest range: upper `range` (b,) and `mean` (b,) in N m, `number`.

    The mean is that of the cycles of a bin, weighted by their numbers, 0 where there are none;
    `number` (b,) has the `error` (b,) of the cycles that are as near to a border as they are
    uncertain; `mean_error` is in N m.
    """

    range: FloatArray
    mean: FloatArray
    number: FloatArray
    error: FloatArray
    mean_error: float


def range_table(cycles: Cycles, bins: int) -> RangeTable:
    """Numbers and means of cycles by their ranges."""
    top = float(np.max(cycles.range, initial=0.0))
    if top == 0.0:
        none = np.zeros(bins)
        return RangeTable(none, none, none, none, 0.0)
    edges = np.append(top * np.arange(1, bins) / bins, top)
    place = np.searchsorted(edges[:-1], cycles.range, side="left")
    number = np.bincount(place, cycles.number, bins).astype(float)
    total = np.bincount(place, cycles.number * cycles.mean, bins)
    mean = total / np.where(number > 0.0, number, 1.0)
    # the largest defines the borders, and moves them all by its own error
    slack = cycles.error + float(cycles.error[np.argmax(cycles.range)])
    near = np.abs(cycles.range[:, None] - edges[:-1]) <= slack[:, None]
    unsure = near.T @ cycles.number
    error = np.append(unsure, 0.0) + np.append(0.0, unsure)
    moved = np.abs(cycles.mean).max() if np.any(unsure) else 0.0
    return RangeTable(edges, mean, number, error, float(moved + np.max(cycles.error)))


# ----------------------------------------------------------------------------
# Fatigue: the share of a life that cycles use up.
# ----------------------------------------------------------------------------


class Strength(NamedTuple):
    """An S-N line: N = cycles (amplitude / a)^slope for amplitudes a from `amplitude` on.

    Below it the exponent is `slope_below`, infinite for no damage at all.
    """

    amplitude: float
    cycles: float
    slope: float
    slope_below: float


def slope_below(slope: float, rule: str) -> float:
    """Exponent below the knee: "elementary", "haibach" (Haibach 1970: 2 k - 1) or "original"."""
    return {"elementary": slope, "haibach": 2.0 * slope - 1.0, "original": np.inf}[rule]


def miner_sum(cycles: Cycles, strength: Strength) -> tuple[float, float]:
    """Sum of n / N over cycles with its error, both absolute (Palmgren 1924, Miner 1945).

    Amplitudes are half of the ranges, in the unit of the line; means do not count.
    """
    amplitude = 0.5 * cycles.range
    share = amplitude / strength.amplitude
    above = share >= 1.0
    exponent = np.where(above, strength.slope, strength.slope_below)
    lasting = np.isfinite(exponent)
    power = np.where(lasting, share ** np.where(lasting, exponent, 1.0), 0.0)
    damage = cycles.number * power / strength.cycles
    doubt = 0.5 * cycles.error / np.where(amplitude > 0.0, amplitude, 1.0)
    steepest = np.where(lasting, exponent, 0.0)
    error = damage * (np.expm1(steepest * np.log1p(doubt)))
    # a cycle at the knee, on either side of it
    close = np.abs(share - 1.0) <= doubt
    error = error + np.where(close & ~lasting, cycles.number / strength.cycles, 0.0)
    return float(damage.sum()), float(error.sum() + 1e-13 * damage.sum())


def equivalent_number(cycles: Cycles, strength: Strength) -> tuple[float, float]:
    """Cycles of the largest range that use up as much as all together, with its error.

    Zero where the largest does no damage.
    """
    if not np.any(cycles.range > 0.0):
        return 0.0, 0.0
    top = [int(np.argmax(cycles.range))]
    largest = Cycles(*(part[top] for part in cycles))._replace(number=np.ones(1))
    (damage, error), (of_one, off) = (miner_sum(one, strength) for one in (cycles, largest))
    if of_one == 0.0:
        return 0.0, 0.0
    number = damage / of_one
    return number, (error + number * off) / of_one
