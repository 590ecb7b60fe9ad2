"""Half ranges of many sums over orders, of which only the largest count: bounds tell which."""

import math

import numpy as np

from vibecalc.numerics.rounding import ComplexArray, FloatArray, IntArray
from vibecalc.numerics.synthesis import BLOCK, SINGLE, Cycles, cycle_of, sampled_roughly, synthesis
from vibecalc.torsion.critical_speeds import RIVAL

# ----------------------------------------------------------------------------
# Of sums over a cycle of which only the largest count, the bounds tell which these can be.
#
# Between two samples a signal exceeds both by no more than its largest curvature times an eighth of
# the square of their distance; a sum x(t) = Re sum X_q exp(i q t) has the curvature sum q^2 |X_q|.
# ----------------------------------------------------------------------------


def rough_range(order: FloatArray, amplitude: ComplexArray) -> tuple[FloatArray, FloatArray]:
    """Bounds (...) below and above the half ranges of sums over the cycle.

    Parameters
    ----------
    order : array (m,)
        Orders above 0; those that are no multiples of 1/2 leave nothing but 0 and infinity.
    amplitude : complex array (..., m)
        0-to-peak, finite.
    """
    shape = amplitude.shape[:-1]
    doubled = np.rint(2.0 * order).astype(np.int64)
    if np.any(doubled != 2.0 * order) or np.any(doubled < 1):
        return np.zeros(shape), np.full(shape, np.inf)
    number = doubled if np.any(doubled % 2) else doubled // 2
    rows = amplitude.reshape(-1, len(order))
    cycle = cycle_of(tuple(number.tolist()))
    low, high = np.empty((2, len(rows)))
    step = math.pi / cycle.samples  # half of one
    block = max(1, BLOCK // cycle.samples)
    for start in range(0, len(rows), block):
        part = slice(start, start + block)
        size = np.abs(rows[part])
        most = size.sum(axis=1)
        unit = np.where(most > 0.0, most, 1.0)
        scaled = rows[part] / unit[:, None]
        sampled = sampled_roughly(scaled, cycle)
        half = 0.5 * (sampled.max(axis=1).astype(float) - sampled.min(axis=1))
        bend = 0.5 * step**2 * (size @ np.square(number.astype(float)))
        low[part] = np.maximum(half - SINGLE, 0.0) * most
        high[part] = (half + SINGLE) * most + bend
    return low.reshape(shape), high.reshape(shape)


def near_the_largest(
    cycles: Cycles,
    amplitude: ComplexArray,
    group: IntArray,
    best: FloatArray,
    seeds: int = 0,
) -> FloatArray:
    """Half ranges (r,) of sums (r, m): of what is not near the largest of its `group` (r,),
    something that is not below it and less than `RIVAL` of that.

    `best` (g,) is what the largest of each group is not below; it is raised here. The so many
    `seeds` with the largest magnitudes of each, as long as the others, are bounded first.
    """
    high: FloatArray = np.abs(amplitude) @ np.ones(amplitude.shape[1])

    def bounded(chosen: IntArray) -> None:
        low, high[chosen] = rough_range(cycles.own, amplitude[chosen])
        np.maximum.at(best, group[chosen], low)

    if seeds:
        each = len(high) // len(best)
        few = min(each, seeds)
        most = np.argpartition(high.reshape(-1, each), each - few, axis=1)[:, each - few :]
        bounded((most + each * np.arange(len(most))[:, None]).ravel())
    bounded(np.flatnonzero(high >= RIVAL * best[group]))
    chosen = np.flatnonzero(high >= RIVAL * best[group])
    high[chosen] = synthesis(cycles, amplitude[chosen]).half_range
    np.maximum.at(best, group[chosen], high[chosen])
    return high
