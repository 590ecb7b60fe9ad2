"""Distances between points of a sweep: which one is nearest to the case as it is written."""

from typing import Any

import numpy as np

from vibecalc.case.overrides import parse_key
from vibecalc.report.sweep.view import SweepView

_BLOCK = 1 << 18


def case_values(sweep: SweepView) -> np.ndarray | None:
    """What the varied keys are in the case itself, (keys,); None if one of them is not there."""
    found = []
    for key in sweep.keys:
        value = _at(sweep.case, parse_key(key.key))
        if key.names and str(value) in key.names:
            found.append(float(key.names.index(str(value))))
        elif isinstance(value, int | float) and not isinstance(value, bool) and not key.names:
            found.append(float(value))
        else:
            return None
    return np.array(found)


def nearest(sweep: SweepView, among: np.ndarray) -> int | None:
    """The point of `among` (points,) nearest to the case, None if there is none or no case.

    Each key counts in shares of its range (of the range of its logarithm on a logarithmic axis); a
    choice is as far from another as the whole range.
    """
    here = case_values(sweep)
    points = np.flatnonzero(among)
    if here is None or not points.size:
        return None
    logarithmic, low, width = _scales(sweep)
    centre = _scaled(here[None, :], logarithmic, low, width)[0]
    choice = np.array([bool(key.names) for key in sweep.keys])
    smallest, found = np.inf, int(points[0])
    for start in range(0, points.size, _BLOCK):
        block = points[start : start + _BLOCK]
        apart = np.abs(_scaled(sweep.values_of(block), logarithmic, low, width) - centre)
        apart = np.where(choice, apart > 0.0, apart)
        # round-off must not choose between two neighbours at one distance
        distance = np.round(np.sum(apart**2, axis=1), 12)
        place = int(np.argmin(distance))
        if distance[place] < smallest:
            smallest, found = float(distance[place]), int(block[place])
    return found


def ranges(sweep: SweepView, among: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Smallest and largest value of each key over the points of `among`, (keys,) each, in SI."""
    points = np.flatnonzero(among)
    low = np.full(len(sweep.keys), np.inf)
    high = -low
    for start in range(0, points.size, _BLOCK):
        values = sweep.values_of(points[start : start + _BLOCK])
        low, high = np.minimum(low, values.min(axis=0)), np.maximum(high, values.max(axis=0))
    return low, high


def _scales(sweep: SweepView) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    flags = [axis.logarithmic for axis in sweep.grid for _ in axis.keys]
    logarithmic = np.array(flags or [False] * len(sweep.keys))
    low, high = ranges(sweep, np.ones(sweep.count, dtype=bool))
    logarithmic &= low > 0.0
    low = np.where(logarithmic, np.log(np.where(logarithmic, low, 1.0)), low)
    high = np.where(logarithmic, np.log(np.where(logarithmic, high, 1.0)), high)
    width = np.where(high > low, high - low, 1.0)
    return logarithmic, low, width


def _scaled(
    values: np.ndarray, logarithmic: np.ndarray, low: np.ndarray, width: np.ndarray
) -> np.ndarray:
    usable = logarithmic & (values > 0.0)
    logs = np.log(np.where(usable, values, 1.0))
    # a value that has no logarithm is further off than any point
    shown = np.where(logarithmic, np.where(usable, logs, low - width), values)
    return np.asarray((shown - low) / width)


def _at(place: Any, path: tuple[str | int, ...]) -> Any:
    for step in path:
        try:
            place = place[step]
        except (KeyError, IndexError, TypeError):
            return None
    return place
