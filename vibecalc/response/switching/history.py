"""A course thinned out for pictures, so that every swing survives."""

from typing import NamedTuple

import numpy as np

from vibecalc.response.switching.course import Segment, motion_at
from vibecalc.response.switching.readings import read
from vibecalc.response.switching.system import ModalLoads, ModalSystem

_BLOCK = 1 << 13
#: samples in a turn of the crank at its fastest, and in a period of the fastest mode
_PER_TURN, _PER_PERIOD = 64, 16
#: no more than this in a span: of a longer one only the outline is seen
_MOST = 256


class History(NamedTuple):
    """Lowest and highest sample of each reading, `low` and `high` (buckets, columns).

    `time` and `speed` (buckets + 1,) at the edges of the buckets, in s and rad/s. The samples of
    a bucket are evenly spaced from edge to edge, both included, `samples` distances apart: where
    they stand follows from course and machine alone. True peaks are found elsewhere.
    """

    time: np.ndarray
    speed: np.ndarray
    low: np.ndarray
    high: np.ndarray
    samples: int


def history(
    system: ModalSystem, loads: ModalLoads, segments: list[Segment], buckets: int
) -> History:
    """Extremes of samples in equal spans of time."""
    runs = [segment.run for segment in segments]
    total = runs[-1].start + runs[-1].duration
    edges = np.linspace(0.0, total, buckets + 1)
    samples = _samples(system, segments, total / buckets)
    every = np.linspace(0.0, total, buckets * samples + 1)
    ends = np.array([run.start + run.duration for run in runs])
    owner = np.minimum(np.searchsorted(ends, every, side="left"), len(runs) - 1)
    value = np.empty((len(every), 2 * len(system.shape) + 3))
    for number, segment in enumerate(segments):
        mine = np.flatnonzero(owner == number)
        for start in range(0, len(mine), _BLOCK):
            part = mine[start : start + _BLOCK]
            time = np.clip(every[part] - segment.run.start, 0.0, segment.run.duration)
            value[part] = read(system, motion_at(system, loads, segment, time)).value
    first = np.arange(buckets) * samples
    # the sample on an edge belongs to the buckets on both sides
    closing = value[first + samples]
    low = np.minimum(np.minimum.reduceat(value[:-1], first), closing)
    high = np.maximum(np.maximum.reduceat(value[:-1], first), closing)
    held = owner[::samples]
    speed = [runs[n].speed_at(t - runs[n].start) for n, t in zip(held, edges, strict=True)]
    return History(edges, np.array(speed), low, high, samples)


def _samples(system: ModalSystem, segments: list[Segment], span: float) -> int:
    """Distances between samples in a bucket of `span` s."""
    fastest = max(max(abs(s.run.speed), abs(s.run.end_speed)) for s in segments)
    highest = float(np.max(system.frequency, initial=0.0))
    rate = max(_PER_TURN * fastest, _PER_PERIOD * highest) / (2.0 * np.pi)
    return int(np.clip(np.ceil(rate * span), 1, _MOST))
