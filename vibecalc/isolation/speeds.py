"""At which speeds of a run-up to look first: a coarse grid, and clusters at order resonances."""

import numpy as np

from vibecalc.response.resonance import Resonances
from vibecalc.response.singular import Masked, outside

#: first offset of a cluster in half bandwidths, growth of the offsets, largest relative offset
_FIRST, _GROWTH, _FARTHEST = 0.35, 1.7, 0.75


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


def clusters(resonances: Resonances, orders: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Speeds in geometric steps away from chosen (orders, modes) resonances, on either side.

    The first step is a third of the half bandwidth, so that no resonance is too narrow to be
    seen; beside a masked interval it starts at the interval's edge.
    """
    centre = resonant_speeds(resonances, orders)
    exposed = resonances.exposed()
    found = [np.zeros(0)]
    for mode in np.flatnonzero(np.any(chosen, axis=0)):
        width = max(_FIRST * resonances.damping_ratio[mode], exposed[mode], 1e-13)
        steps = max(int(np.ceil(np.log(_FARTHEST / width) / np.log(_GROWTH))), 0)
        offset = width * _GROWTH ** np.arange(steps + 1)
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
