"""The highest peaks of a run-up over crank speed and crank angle, by Newton in both."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.isolation.rows import HarmonicsAt, Jet
from vibecalc.isolation.run_up_grid import CachedFunction, squares
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.response.resonances import MaskedSpeeds

# ----------------------------------------------------------------------------
# The highest points of rows over crank speed and crank angle, by Newton in both at once.
# ----------------------------------------------------------------------------

_MOST_STEPS = 60
_NONE = np.zeros(0)
#: promised relative gain below which a start has arrived, and below which heights tell nothing
_ARRIVED, _FLAT = 1e-18, 1e-12
#: relative difference of heights that is none
_ALIKE = 2e-13
#: of the trusted step, how near a peak a start has merged with it
_SAME = 0.05
#: promised relative gain below which Newton's step is trusted to tell what is left, which is at
#: most so many times what it promises
_NEAR, _MARGIN = 0.01, 4.0


class Starts(NamedTuple):
    """Where to climb from, each (starts,): speed, crank angle, row, and the speed step to trust."""

    speed: np.ndarray
    angle: np.ndarray
    row: np.ndarray
    reach: np.ndarray


class RunUpPeaks(NamedTuple):
    """The highest maximum (rows,) of each row's length, with its speed; errors absolute.

    Rows from which nothing starts are zero, at the start of the range. `angle` is the crank angle,
    `harmonics` (rows, components, orders) what the rows have at the speed, `gain` what another
    Newton step would still promise, relative.
    """

    value: np.ndarray
    error: np.ndarray
    speed: np.ndarray
    speed_error: np.ndarray
    angle: np.ndarray
    gain: np.ndarray
    harmonics: np.ndarray


class _Height(NamedTuple):
    """Half the squared length h, its slopes and second derivatives by speed (v) and angle (a)."""

    h: np.ndarray
    v: np.ndarray
    a: np.ndarray
    vv: np.ndarray
    va: np.ndarray
    aa: np.ndarray
    value_uncertainty: np.ndarray
    v_uncertainty: np.ndarray
    a_uncertainty: np.ndarray


def climb(
    harmonics_at: HarmonicsAt,
    orders: np.ndarray,
    starts: Starts,
    start: float,
    stop: float,
    known: np.ndarray,
    nearby: RunUpPeaks | None = None,
) -> RunUpPeaks:
    """Maximise |f(speed, angle)| of rows from their starts within [start, stop].

    Only peaks above those `known` (rows,) count. A start that comes close to that of its row in
    `nearby` stays there.

    A maximum over speed of the peak over the cycle is a smooth point of one branch (an upper
    envelope has kinks only in its valleys), where both slopes vanish, or an end of the range. The
    step is Newton's where the height is concave, turned upwards where it is not, kept within a
    trusted distance, and taken only if it leads up; so no peak is below its start. All starts
    climb together; those that Newton's steps no longer carry above the best of their row stay.
    """
    order = np.asarray(orders, dtype=float)
    top_order = float(np.max(order))
    speed, angle = starts.speed.copy(), starts.angle.copy()
    radius = np.ones(len(speed))
    floor = 0.5 * np.square(known)
    jet = _jets(harmonics_at, speed, starts.row)
    here = _height(jet, order, angle)
    step_v, step_a, gain, concave = _step(here, speed, starts.reach, top_order, radius, start, stop)
    for _ in range(_MOST_STEPS):
        moving = (
            (gain > _ARRIVED)
            & (radius > 1e-9)
            & (~concave | _may_win(here.h, gain, starts.row, floor))
        )
        if nearby is not None:
            moving &= ~_merged(speed, angle, starts, nearby, top_order)
        if not np.any(moving):
            break
        at = np.flatnonzero(moving)
        trial_v = np.clip(speed[at] + step_v[at], start, stop)
        trial_a = angle[at] + step_a[at]
        jet = _jets(harmonics_at, trial_v, starts.row[at])
        there = _height(jet, order, trial_a)
        # so near the top heights differ by rounding only, and Newton's step is the better judge
        better = (there.h >= here.h[at]) | (gain[at] < _FLAT)
        radius[at] = np.where(better, np.minimum(2.0 * radius[at], 1.0), 0.25 * radius[at])
        taken = at[better]
        speed[taken], angle[taken] = trial_v[better], trial_a[better]
        for old, new in zip(here[:6], there[:6], strict=True):
            old[taken] = new[better]
        step_v, step_a, gain, concave = _step(
            here, speed, starts.reach, top_order, radius, start, stop
        )
    best = _best(here.h, starts.row, floor)
    # the last step is below what the height can tell apart, and above what the slopes can
    arrived = gain[best] <= _ARRIVED
    row, step_v, gain = starts.row[best], step_v[best], gain[best]
    speed, angle = speed[best], angle[best]
    speed = np.where(arrived, np.clip(speed + step_v, start, stop), speed)
    angle = np.where(arrived, angle + step_a[best], angle)
    angle = np.remainder(angle + np.pi, 2.0 * np.pi) - np.pi
    rows, shape = len(known), jet.value.shape[1:]
    none = [np.zeros(rows) for _ in range(6)]
    peaks = RunUpPeaks._make([*none, np.zeros((rows, *shape), dtype=complex)])
    peaks.speed[:] = start
    if not len(best):
        return peaks
    jet = _jets(harmonics_at, speed, row, errors=True)
    here = _height(jet, order, angle)
    value = np.sqrt(2.0 * here.h)
    inside = (speed > start) & (speed < stop)
    drift = np.where(inside, _speed_uncertainty(here, stop - start) + 1e-3 * np.abs(step_v), 0.0)
    peaks.value[row], peaks.error[row] = value, here.value_uncertainty + np.abs(gain) * value
    peaks.speed[row], peaks.angle[row], peaks.gain[row] = speed, angle, gain
    peaks.speed_error[row] = drift + 2.0 * UNIT_ROUNDOFF * speed
    peaks.harmonics[row] = jet.value
    return peaks


def _jets(
    harmonics_at: HarmonicsAt, speed: np.ndarray, row: np.ndarray, errors: bool = False
) -> Jet:
    """One row each of the jets at speeds (starts,): parts (starts, components, orders)."""
    which = np.zeros(len(speed), dtype=int)
    shown = speed
    if len(speed) > 1:
        # branches of one row start from the same speed, and rows that are alike share all speeds
        shown, which = np.unique(speed, return_inverse=True)
    jet = harmonics_at(shown, slopes=True, errors=errors)
    return Jet(*(part[which, row] if part.size else part for part in jet))


def _may_win(
    height: np.ndarray, gain: np.ndarray, row: np.ndarray, floor: np.ndarray
) -> np.ndarray:
    """Which starts may still become the highest of their row.

    A step that promises little says how much is left: the peak is above by what it promises.
    """
    best = floor.copy()
    np.maximum.at(best, row, height)
    may: np.ndarray = (gain > _NEAR) | (height * (1.0 + _MARGIN * gain) >= best[row])
    return may


def _merged(
    speed: np.ndarray, angle: np.ndarray, starts: Starts, nearby: RunUpPeaks, top_order: float
) -> np.ndarray:
    """Which starts have come close to the peak that their row has already."""
    turn = angle - nearby.angle[starts.row]
    away = np.abs(np.remainder(turn + np.pi, 2.0 * np.pi) - np.pi)
    near = np.abs(speed - nearby.speed[starts.row]) <= _SAME * starts.reach
    merged: np.ndarray = near & (away <= 0.5 / top_order)
    return merged


def _best(height: np.ndarray, row: np.ndarray, floor: np.ndarray) -> np.ndarray:
    """The highest start of each row that has one above its floor; of several equals the first."""
    highest = floor.copy()
    np.maximum.at(highest, row, height)
    first = np.full(len(floor), len(row))
    at = np.flatnonzero((height >= highest[row]) & (height > floor[row] * (1.0 + _ALIKE)))
    np.minimum.at(first, row[at], at)
    return first[first < len(row)]


def _height(jet: Jet, order: np.ndarray, angle: np.ndarray) -> _Height:
    """Heights (starts,) of jets at crank angles; with uncertainties where the jets have errors."""
    value, slope = jet.value, jet.slope
    turn = np.exp(1j * angle[:, None] * order)[:, None, :]
    around, around_slope = value * turn, slope * turn
    f = around.real.sum(axis=-1)
    f_v = around_slope.real.sum(axis=-1)
    f_a = -(around.imag @ order)
    f_vv = (jet.curvature * turn).real.sum(axis=-1)
    f_va = -(around_slope.imag @ order)
    f_aa = -(around.real @ np.square(order))
    uncertainties = (_NONE, _NONE, _NONE)
    if jet.error.size:
        # the angle is rounded, and each order turns by a multiple of it
        rounding = (len(order) + 6.0 + 4.0 * np.pi * order) * UNIT_ROUNDOFF
        uncertainty = jet.error + rounding * np.abs(value)
        uncertainty_v = jet.slope_error + rounding * np.abs(slope)
        df, df_v = _length(uncertainty.sum(axis=-1)), _length(uncertainty_v.sum(axis=-1))
        df_a, size = _length(uncertainty @ order), _length(f)
        uncertainties = (df, size * df_v + df * _length(f_v), size * df_a + df * _length(f_a))
    return _Height(
        0.5 * _dot(f, f), _dot(f, f_v), _dot(f, f_a), _dot(f_v, f_v) + _dot(f, f_vv),
        _dot(f_v, f_a) + _dot(f, f_va), _dot(f_a, f_a) + _dot(f, f_aa), *uncertainties,
    )  # fmt: skip


def _dot(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    total: np.ndarray = (left * right).sum(axis=-1)
    return total


def _length(vector: np.ndarray) -> np.ndarray:
    size: np.ndarray = np.sqrt(_dot(vector, vector))
    return size


def _step(
    at: _Height,
    speed: np.ndarray,
    reach: np.ndarray,
    top_order: float,
    radius: np.ndarray,
    start: float,
    stop: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Step in speed and angle, the relative gain in height that it promises, and if concave."""
    scale = 1.0 / np.where(at.h > 0.0, at.h, 1.0)
    v, a = at.v * reach * scale, at.a / top_order * scale
    vv = at.vv * np.square(reach) * scale
    va = at.va * reach / top_order * scale
    aa = at.aa / top_order**2 * scale
    held = ((speed <= start) & (v <= 0.0)) | ((speed >= stop) & (v >= 0.0))
    v, va, vv = np.where(held, 0.0, v), np.where(held, 0.0, va), np.where(held, -1.0, vv)
    # along the axes of the curvature: up where Newton's step would lead to a saddle or down
    middle, spread = 0.5 * (vv + aa), np.hypot(0.5 * (vv - aa), va)
    size = np.abs(middle) + spread + 1e-300
    lean = 0.5 * np.arctan2(2.0 * va, vv - aa)
    cosine, sine = np.cos(lean), np.sin(lean)
    along = (cosine * v + sine * a) / np.maximum(np.abs(middle + spread), 1e-6 * size)
    across = (cosine * a - sine * v) / np.maximum(np.abs(middle - spread), 1e-6 * size)
    step_v, step_a = cosine * along - sine * across, sine * along + cosine * across
    gain = 0.5 * (v * step_v + a * step_a)
    longest = np.maximum(np.abs(step_v), 2.0 * np.abs(step_a)) / radius
    shorter = 1.0 / np.maximum(longest, 1.0)
    # a height of zero (a row at rest) has nowhere to climb
    gain = np.where(at.h > 0.0, np.abs(gain), 0.0)
    concave = middle + spread < -1e-6 * size
    return step_v * shorter * reach, step_a * shorter / top_order, gain, concave


def _speed_uncertainty(at: _Height, span: float) -> np.ndarray:
    """What the uncertainties of the two slopes make of the speed of the peak; at most the range."""
    determinant = np.abs(at.vv * at.aa - at.va * at.va)
    uncertainty = np.abs(at.aa) * at.v_uncertainty + np.abs(at.va) * at.a_uncertainty
    return np.where(
        uncertainty < span * determinant, uncertainty / np.maximum(determinant, 1e-300), span
    )


# ----------------------------------------------------------------------------
# The highest peaks of the rows of a run-up, polished from speeds that were examined.
# ----------------------------------------------------------------------------

#: how often other branches are searched where a peak was found
_MOST_CLIMBS = 4


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
    """What a search of speeds examines: rows, grid of crank angles, range, what is masked there.

    `sampled` gives the peak over the grid (speeds, rows) and the harmonics, and perhaps more.
    `shown` (intervals, rows) and `infinite` (rows,) tell which rows have no bound in an interval
    and anywhere.
    """

    harmonics_at: HarmonicsAt
    sampled: CachedFunction
    orders: np.ndarray
    angle: np.ndarray
    masked: MaskedSpeeds
    shown: np.ndarray
    infinite: np.ndarray
    start: float
    stop: float


def highest(search: Search, speed: np.ndarray, threshold: float, sparse: bool = False) -> RunUpPeak:
    """Polish every local maximum that may be the highest, and keep the best of each row.

    Among `sparse` speeds a kink may part two peaks within a step, or one may hide next to the
    maximum: then the speeds next to it are starts as well.
    """
    value, harmonics = search.sampled(speed)[:2]
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
        nearby = np.pad(local & high, ((1, 1), (0, 0)))
        around = (nearby[:-2] | nearby[2:]) & ~local & high & sparse
        more = starts_at(around) if np.any(around) else None
        peaks = _climbed(search, starts_at(local & high), more, rows, threshold)
        peak = RunUpPeak(*peaks[:4])
    for number in range(rows):
        if not search.infinite[number]:
            continue
        first = int(np.argmax(search.shown[:, number]))
        peak.value[number], peak.speed[number] = np.inf, search.masked.centre[first]
        peak.speed_error[number] = search.masked.centre_error[first]
    return peak


def _climbed(
    search: Search, starts: Starts, around: Starts | None, rows: int, threshold: float
) -> RunUpPeaks:
    """Peaks of all rows; where another branch over the angle is high there, it is climbed too.

    Of two branches that cross between two speeds one may be too low at either to be a start. From
    `around` only what does not lead to the same peak is climbed to the end.
    """
    given = (search.harmonics_at, search.orders)
    ends = (search.start, search.stop)
    peaks = climb(*given, starts, *ends, np.zeros(rows))
    if around is not None:
        _keep(peaks, climb(*given, around, *ends, peaks.value, peaks))
    period = len(search.angle) * search.angle[1]
    reach = np.zeros(rows)
    np.maximum.at(reach, starts.row, starts.reach)
    row, climbed = np.flatnonzero(peaks.value > 0.0), starts
    # next to an end of the range that is high a peak may hide before the next speed
    at_end = (peaks.speed == search.start) | (peaks.speed == search.stop)
    edge = row[at_end[row]]
    if len(edge):
        inwards = np.where(peaks.speed[edge] == search.stop, -reach[edge], reach[edge])
        inner = (peaks.speed[edge] + np.array([[0.25], [0.5]]) * inwards).ravel()
        shown, which = np.unique(inner, return_inverse=True)
        places = Starts(inner, np.zeros(len(inner)), np.tile(edge, 2), np.tile(reach[edge], 2))
        values = search.sampled(shown)[1][which, places.row]
        near = _branches(search, places, values, threshold)
        _keep(peaks, climb(*given, near, *ends, peaks.value))
    for _ in range(_MOST_CLIMBS):
        tops = Starts(peaks.speed[row], peaks.angle[row], row, reach[row])
        there = _branches(search, tops, peaks.harmonics[row], threshold)
        # a branch is known by its angle, to a quarter of a wave of the highest order
        away = there.angle[:, None] - climbed.angle + 0.5 * period
        away = np.abs(np.remainder(away, period) - 0.5 * period)
        known = (away < 4.5 * search.angle[1]) & (there.row[:, None] == climbed.row)
        other = ~np.any(known, axis=1)
        if not np.any(other):
            break
        there = Starts(*(part[other] for part in there))
        again = climb(*given, there, *ends, peaks.value)
        climbed = Starts(*(np.concatenate(pair) for pair in zip(climbed, there, strict=True)))
        row = _keep(peaks, again)
        if not len(row):
            break
    return peaks


def _keep(peaks: RunUpPeaks, again: RunUpPeaks) -> np.ndarray:
    """Put what was found again in its place, and tell the rows of which that is so."""
    row = np.flatnonzero(again.value)
    for old, new in zip(peaks, again, strict=True):
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
