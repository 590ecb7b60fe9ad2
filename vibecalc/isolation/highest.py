"""The highest peaks of the rows of a run-up, polished from speeds that were looked at."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.isolation.envelope import squares
from vibecalc.isolation.looked import Looked
from vibecalc.isolation.rows import HarmonicsAt
from vibecalc.isolation.summit import Starts, Summits, climb
from vibecalc.response.singular import Masked

#: how often other branches are looked for where a summit was found
_MOST_LOOKS = 4


class RunUpPeak(NamedTuple):
    """Highest peak of each row (rows,) and its speed in rad/s, with absolute errors.

    The value is infinite, with the speed of the first such resonance, where a driven undamped
    natural frequency lies in the range and shows in the row.
    """

    value: np.ndarray
    error: np.ndarray
    speed: np.ndarray
    speed_error: np.ndarray


def highest_of(peaks: Sequence[RunUpPeak]) -> RunUpPeak:
    """The highest of several parts of a run-up, row by row; of equals the first."""
    if len(peaks) == 1:
        return peaks[0]
    first = np.argmax([peak.value for peak in peaks], axis=0)
    rows = np.arange(len(first))
    best = RunUpPeak(*(np.stack(part)[first, rows] for part in zip(*peaks, strict=True)))
    # another part whose errors reach above leaves the value open so far
    above = np.max([np.where(p.error > 0.0, p.value + p.error, 0.0) for p in peaks], axis=0)
    higher = np.where(np.isfinite(best.value), above - best.value, 0.0)
    return best._replace(error=np.maximum(best.error, higher))


class Search(NamedTuple):
    """What a search of speeds looks at: rows, grid of crank angles, range, what is masked there.

    `looked` gives the peak over the grid (speeds, rows) and the harmonics, and perhaps more.
    `shown` (intervals, rows) and `infinite` (rows,) tell which rows have no bound in an interval
    and anywhere.
    """

    harmonics_at: HarmonicsAt
    looked: Looked
    orders: np.ndarray
    angle: np.ndarray
    masked: Masked
    shown: np.ndarray
    infinite: np.ndarray
    start: float
    stop: float


def highest(search: Search, speed: np.ndarray, threshold: float, sparse: bool = False) -> RunUpPeak:
    """Polish every local maximum that may be the highest, and keep the best of each row.

    Among `sparse` speeds a kink may part two summits within a step, or one may hide beside the
    maximum: then the speeds next to it are starts as well.
    """
    value, harmonics = search.looked(speed)[:2]
    rows = value.shape[1]
    padded = np.pad(value, ((1, 1), (0, 0)), constant_values=-1.0)
    local = (value >= padded[:-2]) & (value >= padded[2:])
    top = np.max(value, axis=0)
    high = (value >= threshold * top) & (value > 0.0) & ~search.infinite
    reach = np.concatenate([speed[1:], speed[-1:]]) - np.concatenate([speed[:1], speed[:-1]])

    def starts_at(chosen: np.ndarray) -> Starts:
        at, row = np.nonzero(chosen)
        places = Starts(speed[at], np.zeros(len(at)), row, reach[at])
        return _branches(search, places, harmonics[at, row], threshold)

    peak = RunUpPeak(np.zeros(rows), np.zeros(rows), np.full(rows, search.start), np.zeros(rows))
    if np.any(local & high):
        beside = np.pad(local & high, ((1, 1), (0, 0)))
        around = (beside[:-2] | beside[2:]) & ~local & high & sparse
        more = starts_at(around) if np.any(around) else None
        found = _climbed(search, starts_at(local & high), more, rows, threshold)
        peak = RunUpPeak(*found[:4])
    for number in range(rows):
        if not search.infinite[number]:
            continue
        first = int(np.argmax(search.shown[:, number]))
        peak.value[number], peak.speed[number] = np.inf, search.masked.centre[first]
        peak.speed_error[number] = search.masked.centre_error[first]
    return peak


def _climbed(
    search: Search, starts: Starts, around: Starts | None, rows: int, threshold: float
) -> Summits:
    """Summits of all rows; where another branch over the angle is high there, it is climbed too.

    Of two branches that cross between two speeds one may be too low at either to be a start. From
    `around` only what does not lead to the same summit is climbed to the end.
    """
    given = (search.harmonics_at, search.orders)
    ends = (search.start, search.stop)
    found = climb(*given, starts, *ends, np.zeros(rows))
    if around is not None:
        _keep(found, climb(*given, around, *ends, found.value, found))
    period = len(search.angle) * search.angle[1]
    reach = np.zeros(rows)
    np.maximum.at(reach, starts.row, starts.reach)
    row, climbed = np.flatnonzero(found.value > 0.0), starts
    # beside an end of the range that is high a summit may hide before the next speed
    at_end = (found.speed == search.start) | (found.speed == search.stop)
    edge = row[at_end[row]]
    if len(edge):
        inwards = np.where(found.speed[edge] == search.stop, -reach[edge], reach[edge])
        inner = (found.speed[edge] + np.array([[0.25], [0.5]]) * inwards).ravel()
        shown, which = np.unique(inner, return_inverse=True)
        places = Starts(inner, np.zeros(len(inner)), np.tile(edge, 2), np.tile(reach[edge], 2))
        values = search.looked(shown)[1][which, places.row]
        near = _branches(search, places, values, threshold)
        _keep(found, climb(*given, near, *ends, found.value))
    for _ in range(_MOST_LOOKS):
        tops = Starts(found.speed[row], found.angle[row], row, reach[row])
        there = _branches(search, tops, found.harmonics[row], threshold)
        # a branch is known by its angle, to a quarter of a wave of the highest order
        away = there.angle[:, None] - climbed.angle + 0.5 * period
        away = np.abs(np.remainder(away, period) - 0.5 * period)
        known = (away < 4.5 * search.angle[1]) & (there.row[:, None] == climbed.row)
        other = ~np.any(known, axis=1)
        if not np.any(other):
            break
        there = Starts(*(part[other] for part in there))
        again = climb(*given, there, *ends, found.value)
        climbed = Starts(*(np.concatenate(pair) for pair in zip(climbed, there, strict=True)))
        row = _keep(found, again)
        if not len(row):
            break
    return found


def _keep(found: Summits, again: Summits) -> np.ndarray:
    """Put what was found again in its place, and tell the rows of which that is so."""
    row = np.flatnonzero(again.value)
    for old, new in zip(found, again, strict=True):
        old[row] = new[row]
    return row


def _branches(search: Search, places: Starts, harmonics: np.ndarray, threshold: float) -> Starts:
    """A start for each high branch over the crank angle, whatever the angle of the places.

    `harmonics` (places, components, orders) are those of the rows there.
    """
    height = squares(harmonics, search.orders, search.angle)
    around = np.maximum(np.roll(height, 1, axis=-1), np.roll(height, -1, axis=-1))
    # the grid itself may miss two per cent of a peak
    floor = np.square(0.96 * threshold) * np.max(height, axis=-1, keepdims=True)
    each, column = np.nonzero((height >= around) & (height >= floor))
    reach = np.maximum(places.reach, 1e-12 * places.speed)
    return Starts(places.speed[each], search.angle[column], places.row[each], reach[each])
