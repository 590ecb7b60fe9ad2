"""Every local maximum of a run-up, with the order that makes most of it and the mode next to it."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.isolation.rows import HarmonicsAt, Jet
from vibecalc.isolation.run_up import RunUp
from vibecalc.isolation.run_up_grid import angle_grid, squares
from vibecalc.isolation.run_up_peaks import Ground, RunUpPeaks, Starts, climb, jets_of, open_between
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.maxima import top_errors
from vibecalc.response.resonances import Resonances

# ----------------------------------------------------------------------------
# A local maximum of the curve lies between the neighbours of a speed whose value is no lower than
# theirs: the curve has a speed wherever it bends. From each the highest branch over the crank angle
# is climbed, as for the highest of them all. An envelope has its kinks in valleys, so that a
# maximum is a smooth point of a branch, the end of the range, or a speed at which a gas table has
# its own kink.
# ----------------------------------------------------------------------------

#: candidates climbed at once
_MOST = 24
#: a sample is lower than the maximum next to it by no more than the curve's tolerance
_SAMPLED = 0.97
#: relative: closer ones are one maximum
_ONE = 1e-7
_TINY = np.finfo(float).tiny


class Range(NamedTuple):
    """A part of a run-up: rows at its speeds, orders as whole numbers, what orders may meet."""

    harmonics_at: HarmonicsAt
    orders: np.ndarray
    resonances: Resonances
    start: float
    stop: float
    shows: np.ndarray


class Maxima(NamedTuple):
    """Maxima (n,) by row, then by speed; errors absolute, an infinite one stands for no bound.

    `order` is the whole number of the order that is largest there, `share` its size over the peak
    of all, 1 of an infinite one; `bending` the one that bends the curve downwards most, which is
    the one in resonance where there is one, and at an end of the range the largest. `mode` (from
    1) is the nearest to the frequency of that order, of the modes that the row shows, and `ratio`
    that frequency over that of the mode. `at_end` is 1 at an end of the range.
    """

    row: np.ndarray
    value: np.ndarray
    error: np.ndarray
    speed: np.ndarray
    speed_error: np.ndarray
    order: np.ndarray
    share: np.ndarray
    bending: np.ndarray
    mode: np.ndarray
    ratio: np.ndarray
    at_end: np.ndarray


def local_maxima(parts: Sequence[Range], run: RunUp, share: float) -> Maxima:
    """All local maxima of the rows of `run` from `share` of the highest of each row on.

    `parts` are those of the run-up, one after the other. Speeds next to an interval that is left
    out are none; the unbounded maximum in it is one for the rows that show its mode.
    """
    found: list[tuple[float, ...]] = []
    for row in range(run.curve.value.shape[1]):
        places = _candidates(run, parts, row, share)
        rows = [one for place in places for one in _climbed(parts, run, row, place)]
        top = max((one[1] for one in rows), default=0.0)
        rows = [one for one in rows if one[1] >= share * top]
        rows = [_uncertain(run, row, one) for one in rows]
        rows.sort(key=lambda one: one[3])
        apart: list[tuple[float, ...]] = []
        for one in rows:
            if apart and one[3] - apart[-1][3] <= _ONE * one[3]:
                apart[-1] = max(apart[-1], one, key=lambda each: each[1])
            else:
                apart.append(one)
        found += sorted([*apart, *_unbounded(run, parts[0], row)], key=lambda one: one[3])
    columns = np.array(found, dtype=float).reshape(-1, len(Maxima._fields)).T
    return Maxima(*columns)


def _uncertain(run: RunUp, row: int, one: tuple[float, ...]) -> tuple[float, ...]:
    """The same with the error of its speed where that of the curve moves it on its hill."""
    _, value, error, speed, speed_error, *others = one
    top, height = (
        Bounded(np.array(speed), np.array(speed_error)),
        Bounded(np.array(value), np.array(error)),
    )
    off, _ = top_errors(top, height, run.speed, run.curve[:, row], alone=True)
    return (row, value, error, speed, off, *others)


def _candidates(run: RunUp, parts: Sequence[Range], row: int, share: float) -> list[int]:
    """Places among the speeds that are no lower than their neighbours and high enough."""
    value = run.curve.value[:, row]
    padded = np.concatenate([[-1.0], value, [-1.0]])
    local = (value > padded[:-2]) & (value >= padded[2:]) & (value > 0.0)
    masked = run.masked
    for place in range(len(masked.low)):
        if parts[0].shows[int(masked.mode[place]) - 1, row]:
            local &= (run.speed < masked.low[place]) | (run.speed > masked.high[place])
    top = float(np.max(value, where=local, initial=0.0))
    return [int(place) for place in np.flatnonzero(local & (value >= _SAMPLED * share * top))]


def _climbed(parts: Sequence[Range], run: RunUp, row: int, place: int) -> list[tuple[float, ...]]:
    """The maximum between the neighbours of a speed; none where a next one is it."""
    low = float(run.speed[max(place - 1, 0)])
    high = float(run.speed[min(place + 1, len(run.speed) - 1)])
    here = float(run.speed[place])
    best: tuple[float, ...] | None = None
    for part in parts:
        start, stop = max(low, part.start), min(high, part.stop)
        if not start < stop:
            continue
        peaks = _highest(part, row, min(max(here, start), stop), start, stop)
        if peaks.value[0] > 0.0 and (best is None or peaks.value[0] > best[1]):
            best = _described(part, peaks, row, parts[0].start, parts[-1].stop)
    if best is None:
        return []
    # at a neighbour the curve goes on upwards, unless the range ends there or has a kink
    inner = [part.start for part in parts[1:]]
    ends = [parts[0].start, parts[-1].stop, *inner]
    inside = low < best[3] < high or any(abs(best[3] - end) <= _ONE * end for end in ends)
    return [best] if inside else []


def _one_row(part: Range, row: int) -> HarmonicsAt:
    def harmonics_at(speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Jet:
        jet = part.harmonics_at(speed, slopes, errors)
        return Jet(*(each[:, row : row + 1] if each.size else each for each in jet))

    return harmonics_at


def _highest(part: Range, row: int, here: float, start: float, stop: float) -> RunUpPeaks:
    """The highest point of one row between two speeds, from all high branches at a third."""

    one_row = _one_row(part, row)
    order = np.asarray(part.orders, dtype=int)
    angle = angle_grid(order)
    height = squares(one_row(np.array([here])).value, order, angle)[0, 0]
    around = np.maximum(np.roll(height, 1), np.roll(height, -1))
    high = np.flatnonzero((height >= around) & (height >= 0.8 * height.max()))[:_MOST]
    reach = max(stop - start, 1e-12 * here)
    starts = Starts(
        np.full(len(high), here), angle[high], np.zeros(len(high), int),
        np.full(len(high), reach),
    )  # fmt: skip
    ends = np.array([start]), np.array([stop])
    peaks, all_ends = climb(Ground(jets_of(one_row), order, *ends), starts, np.zeros(1))
    return open_between(peaks, [all_ends])


def _described(
    part: Range, peaks: RunUpPeaks, row: int, first: float, last: float
) -> tuple[float, ...]:
    """A row of `Maxima`."""
    speed, value = float(peaks.speed[0]), float(peaks.value[0])
    size = np.linalg.norm(peaks.harmonics[0], axis=0)
    largest = int(np.argmax(size))
    order, share = float(part.orders[largest]), float(size[largest] / value)
    at_end = speed in (first, last)
    bending = order if at_end else _bending(part, row, speed, float(peaks.angle[0]))
    mode, ratio = _nearest(part, row, bending * speed)
    errors = float(peaks.error[0]), float(peaks.speed_error[0])
    return (
        row, value, errors[0], speed, errors[1], order, share, bending, mode, ratio, float(at_end)
    )  # fmt: skip


def _bending(part: Range, row: int, speed: float, angle: float) -> float:
    """The order whose part of the second derivative of the squared length is the most negative."""
    jet = _one_row(part, row)(np.array([speed]), slopes=True)
    turn = np.exp(1j * angle * np.asarray(part.orders, dtype=float))
    length = (jet.value[0, 0] * turn).real.sum(axis=-1)
    parts = length @ (jet.curvature[0, 0] * turn).real
    return float(part.orders[int(np.argmin(parts))])


def _nearest(part: Range, row: int, frequency: float) -> tuple[float, float]:
    """Number of the mode whose frequency is nearest by ratio, of those shown, and the ratio."""
    natural = part.resonances.frequency
    away = np.abs(np.log(np.maximum(frequency, _TINY) / np.maximum(natural, _TINY)))
    away = np.where(part.shows[: len(natural), row], away, np.inf)
    place = int(np.argmin(away))
    return float(place + 1), frequency / float(natural[place])


def _unbounded(run: RunUp, part: Range, row: int) -> list[tuple[float, ...]]:
    masked = run.masked
    return [
        (row, np.inf, 0.0, masked.centre[i], masked.centre_error[i], masked.order[i], 1.0,
         masked.order[i], masked.mode[i], 1.0, 0.0)
        for i in range(len(masked.low))
        if part.shows[int(masked.mode[i]) - 1, row]
    ]  # fmt: skip
