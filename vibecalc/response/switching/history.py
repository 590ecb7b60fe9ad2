"""A course thinned out for pictures, so that every swing survives."""

from typing import NamedTuple

import numpy as np

from vibecalc.response.switching.course import Segment, motion_on_grid
from vibecalc.response.switching.readings import read
from vibecalc.response.switching.system import ModalLoads, ModalSystem

_BLOCK = 1 << 13


class History(NamedTuple):
    """Lowest and highest sample of each reading, `low` and `high` (buckets, columns).

    `time` and `speed` (buckets + 1,) at the edges of the buckets, in s and rad/s. Between samples
    the fastest part of the motion turns by a radian at most; true peaks are found elsewhere.
    """

    time: np.ndarray
    speed: np.ndarray
    low: np.ndarray
    high: np.ndarray


def history(
    system: ModalSystem, loads: ModalLoads, segments: list[Segment], buckets: int
) -> History:
    """Extremes in equal spans of time; the grid must have a time in each of them."""
    last = segments[-1].run
    total = last.start + last.duration
    edges = np.linspace(0.0, total, buckets + 1)
    low = np.full((buckets, 2 * len(system.shape) + 3), np.inf)
    high = -low
    for segment in segments:
        for start in range(0, len(segment.grid), _BLOCK):
            part = slice(start, start + _BLOCK)
            value = read(system, motion_on_grid(system, loads, segment, part)).value
            time = segment.run.start + segment.grid[part]
            bucket = np.clip(np.searchsorted(edges, time, side="right") - 1, 0, buckets - 1)
            first = np.flatnonzero(np.diff(bucket, prepend=-1))
            own = bucket[first]
            low[own] = np.minimum(low[own], np.minimum.reduceat(value, first))
            high[own] = np.maximum(high[own], np.maximum.reduceat(value, first))
    runs = [segment.run for segment in segments]
    ends = np.array([run.start + run.duration for run in runs])
    owner = np.minimum(np.searchsorted(ends, edges, side="left"), len(runs) - 1)
    speed = [runs[n].speed_at(t - runs[n].start) for n, t in zip(owner, edges, strict=True)]
    return History(edges, np.array(speed), low, high)
