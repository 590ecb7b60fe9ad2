"""Intervals of the grid in which a reading may have its peak."""

from typing import NamedTuple

import numpy as np

from vibecalc.response.switching.course import Segment, motion_on_grid
from vibecalc.response.switching.readings import Jet, read
from vibecalc.response.switching.system import ModalLoads, ModalSystem

_BLOCK = 1 << 13


class Candidates(NamedTuple):
    """Intervals (any,): highest possible value, column, segment, both ends and a first guess.

    Times count from the segment's start.
    """

    upper: np.ndarray
    column: np.ndarray
    segment: np.ndarray
    left: np.ndarray
    right: np.ndarray
    guess: np.ndarray

    def take(self, which: np.ndarray) -> "Candidates":
        """Some of them, by mask or number."""
        return Candidates(*(part[which] for part in self))


def candidates(
    system: ModalSystem, loads: ModalLoads, segments: list[Segment]
) -> tuple[np.ndarray, Candidates]:
    """Largest samples (columns,), and all intervals that may reach beyond them.

    On every interval the cubic through values and slopes at its ends is compared with the second
    derivatives there, which tells how far it may be off.
    """
    best = np.zeros(2 * len(system.shape) + 3)
    kept = []
    for number, segment in enumerate(segments):
        grid = segment.grid
        for start in range(0, len(grid) - 1, _BLOCK):
            part = slice(start, start + _BLOCK + 1)
            times = grid[part]
            jet = read(system, motion_on_grid(system, loads, segment, part))
            best = np.maximum(best, np.max(np.abs(jet.value), axis=0))
            upper, guess = _cubic(jet, np.diff(times))
            at, column = np.nonzero(upper >= best)
            left, right = times[at], times[at + 1]
            inside = left + guess[at, column] * (right - left)
            owner = np.full(len(at), number)
            kept.append(Candidates(upper[at, column], column, owner, left, right, inside))
    joined = Candidates(*(np.concatenate(part) for part in zip(*kept, strict=True)))
    return best, joined.take(joined.upper >= best[joined.column])


def _cubic(jet: Jet, length: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Upper estimate of the magnitude on each interval (intervals, columns), and where it is."""
    h = length[:, None]
    low, high = jet.value[:-1], jet.value[1:]
    slope, end_slope = h * jet.rate[:-1], h * jet.rate[1:]
    square = 3.0 * (high - low) - 2.0 * slope - end_slope
    cube = 2.0 * (low - high) + slope + end_slope
    root = np.sqrt(np.maximum(square**2 - 3.0 * cube * slope, 0.0))
    pivot = -(square + np.copysign(root, square))
    top = np.maximum(np.abs(low), np.abs(high))
    guess = np.where(np.abs(high) > np.abs(low), 1.0, 0.0)
    for above, below in ((pivot, 3.0 * cube), (slope, pivot)):
        inside = np.abs(above) < np.abs(below)
        place = np.divide(above, below, out=np.zeros_like(above), where=inside)
        place = np.maximum(place, 0.0)
        there = np.abs(low + place * (slope + place * (square + place * cube)))
        guess = np.where(there > top, place, guess)
        top = np.maximum(top, there)
    off = np.maximum(
        np.abs(h**2 * jet.bend[:-1] - 2.0 * square),
        np.abs(h**2 * jet.bend[1:] - 2.0 * square - 6.0 * cube),
    )
    # for a quartic remainder the distance is a 32nd of what the second derivative is off
    return top + off / 16.0, guess
