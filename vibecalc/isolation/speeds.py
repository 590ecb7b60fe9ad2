"""At which speeds of a run-up to look first: a coarse grid, and clusters at order resonances."""

import numpy as np

from vibecalc.response.resonance import Resonances
from vibecalc.response.singular import Masked, outside

#: first offset of a cluster in half bandwidths, growth of the offsets, largest relative offset
_FIRST, _GROWTH, _FARTHEST = 0.6, 2.4, 0.75

#: the same where only the highest place is sought, and the steps between speeds there
_SPARSE_FIRST, _SPARSE_GROWTH, _SPARSE_FARTHEST, _SPARSE_STEP = 0.5, 2.0, 0.5, 1.4


def base_speeds(
    resonances: Resonances, orders: np.ndarray, start: float, stop: float, count: int
) -> np.ndarray:
    """Uniform speeds, as many again in geometric steps from below the lowest order resonance."""
    uniform = np.linspace(start, stop, count)
    lowest = np.min(resonances.frequency) / np.max(orders) / 3.0
    floor = max(start, lowest, stop * 1e-6)
    if floor >= stop:
        return uniform
    return np.concatenate([uniform, np.geomspace(floor, stop, count // 2)[1:-1]])


def resonant_speeds(resonances: Resonances, orders: np.ndarray) -> np.ndarray:
    """Crank speed (orders, modes) at which an order meets a natural frequency, rad/s."""
    speed: np.ndarray = resonances.frequency / np.asarray(orders, dtype=float)[:, None]
    return speed


def sparse_speeds(
    resonances: Resonances, orders: np.ndarray, start: float, stop: float
) -> np.ndarray:
    """Both ends and geometric steps from below the lowest order resonance.

    Between resonances, which have speeds of their own, a curve bends on the scale of the speed.
    """
    lowest = np.min(resonances.frequency) / np.max(orders) / 1.5
    floor = max(start, lowest, stop * 1e-6)
    if floor >= stop:
        return np.array([start, 0.5 * (start + stop), stop])
    count = max(int(np.ceil(np.log(stop / floor) / np.log(_SPARSE_STEP))), 3)
    return np.concatenate([[start], np.geomspace(floor, stop, count + 1)[:-1], [stop]])


def clusters(resonances: Resonances, orders: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Speeds in geometric steps away from chosen (orders, modes) resonances, on either side.

    The first step is less than the half bandwidth, so that no resonance is too narrow to be
    seen; beside a masked interval it starts at the interval's edge.
    """
    return _spread(resonances, orders, chosen, _FIRST, _GROWTH, _FARTHEST)


def sparse_clusters(resonances: Resonances, orders: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """The same with few speeds: enough that a climb from the best of them finds the summit."""
    return _spread(resonances, orders, chosen, _SPARSE_FIRST, _SPARSE_GROWTH, _SPARSE_FARTHEST)


def _spread(
    resonances: Resonances,
    orders: np.ndarray,
    chosen: np.ndarray,
    first: float,
    growth: float,
    farthest: float,
) -> np.ndarray:
    centre = resonant_speeds(resonances, orders)
    exposed = resonances.exposed()
    found = [np.zeros(0)]
    for mode in np.flatnonzero(np.any(chosen, axis=0)):
        width = max(first * resonances.damping_ratio[mode], exposed[mode], 1e-13)
        steps = max(int(np.ceil(np.log(farthest / width) / np.log(growth))), 0)
        offset = width * growth ** np.arange(steps + 1)
        near = centre[chosen[:, mode], mode][:, None]
        found += [(near * (1.0 - offset)).ravel(), (near * (1.0 + offset)).ravel()]
    return np.concatenate(found)


def admitted(speed: np.ndarray, masked: Masked, start: float, stop: float) -> np.ndarray:
    """Ascending speeds within the range, without doubles, none inside a masked interval."""
    edges = np.concatenate([masked.low, masked.high])
    ascending: np.ndarray = np.sort(np.concatenate([speed, edges]))
    # np.unique does the same, but imports the masked arrays of numpy
    ascending = ascending[np.concatenate([[True], np.diff(ascending) > 0.0])]
    ascending = ascending[(ascending >= start) & (ascending <= stop)]
    if len(masked.low):
        ascending = ascending[outside(masked, ascending)]
    return ascending
