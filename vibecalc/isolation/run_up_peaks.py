"""The highest peaks of a run-up over crank speed and crank angle, by Newton in both."""

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from vibecalc.isolation.rows import HarmonicsAt, Jet
from vibecalc.isolation.run_up_grid import squares
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.maxima import SURE, top_errors
from vibecalc.numerics.rounding import UNIT_ROUNDOFF

# ----------------------------------------------------------------------------
# The highest points of rows over crank speed and crank angle, by Newton in both at once.
# ----------------------------------------------------------------------------

_MOST_STEPS = 60
_NONE = np.zeros(0)
#: promised relative gain below which a start has arrived, and below which heights tell nothing
_ARRIVED, _FLAT = 1e-18, 1e-12
#: relative difference of heights that is none
_ALIKE = 2e-13
#: the same by a quick look, which is good to some 1e-9: what is so close is climbed exactly as well
_ARRIVED_BY_LOOK, _ALIKE_BY_LOOK = 1e-14, 1e-6
#: of the trusted step, and of a wave of the highest order, how near two such starts are one
_SAME_BY_LOOK = 1e-5
#: promised relative gain below which Newton's step is trusted to tell what is left, which is at
#: most so many times what it promises
_NEAR, _MARGIN = 0.01, 4.0


class JetsAt(Protocol):
    """Rows (n,) at speeds (n,): jets (n, components, orders) with slopes, and with errors."""

    def __call__(self, speed: np.ndarray, row: np.ndarray, errors: bool = False) -> Jet: ...


def jets_of(harmonics_at: HarmonicsAt) -> JetsAt:
    """Those of one machine."""

    def jets_at(speed: np.ndarray, row: np.ndarray, errors: bool = False) -> Jet:
        which, shown = np.zeros(len(speed), dtype=int), speed
        if len(speed) > 1:
            # branches of one row start from the same speed, and rows that are alike share them all
            shown, which = np.unique(speed, return_inverse=True)
        jet = harmonics_at(shown, slopes=True, errors=errors)
        return Jet(*(part[which, row] if part.size else part for part in jet))

    return jets_at


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


class Ground(NamedTuple):
    """What is climbed: rows over their ranges of speed, each (rows,) or one for all.

    `look` is a quick way to the same jets, for all steps but the last ones.
    """

    jets_at: JetsAt
    orders: np.ndarray
    start: np.ndarray
    stop: np.ndarray
    look: JetsAt | None = None

    @property
    def highest(self) -> float:
        """The highest order."""
        return float(np.max(self.orders))


class Ends(NamedTuple):
    """Where starts (starts,) of rows have led to: speed, what may be left to it, and height."""

    row: np.ndarray
    speed: np.ndarray
    left: np.ndarray
    value: np.ndarray


def climb(ground: Ground, starts: Starts, known: np.ndarray) -> tuple[RunUpPeaks, Ends]:
    """Maximise |f(speed, angle)| of rows from their starts within their ranges.

    Only peaks above those `known` (rows,) count; the ends are of all starts.

    A maximum over speed of the peak over the cycle is a smooth point of one branch (an upper
    envelope has kinks only in its valleys), where both slopes vanish, or an end of the range. The
    step is Newton's where the height is concave, turned upwards where it is not, kept within a
    trusted distance, and taken only if it leads up; so no peak is below its start. All starts
    climb together, each of them as if the other rows were not there; those that Newton's steps no
    longer carry above the best of their row stay.
    """
    rows, floor = len(known), 0.5 * np.square(known)
    found = _ascend(ground, ground.look or ground.jets_at, starts, floor)
    low, high = (np.broadcast_to(end, rows) for end in (ground.start, ground.stop))
    there = np.clip(found.speed + found.step_v, low[starts.row], high[starts.row])
    top = np.sqrt(2.0 * found.here.h * (1.0 + found.gain))
    ends = Ends(starts.row, there, np.abs(found.step_v), top)
    none = [np.zeros(rows) for _ in range(6)]
    peaks = RunUpPeaks._make([*none, np.zeros((rows, *found.shape), dtype=complex)])
    peaks.speed[:] = low
    if ground.look is not None:
        starts = _contenders(found, starts, floor)
        if not len(starts.row):
            return peaks, ends
        found = _ascend(ground, ground.jets_at, starts, floor)
    best = _best(found.here.h, starts.row, floor)
    if not len(best):
        return peaks, ends
    # the last step is below what the height can tell apart, and above what the slopes can
    row, step_v, gain = starts.row[best], found.step_v[best], found.gain[best]
    arrived, low, high = gain <= _ARRIVED, low[row], high[row]
    speed, angle = found.speed[best], found.angle[best]
    speed = np.where(arrived, np.clip(speed + step_v, low, high), speed)
    angle = np.where(arrived, angle + found.step_a[best], angle)
    angle = np.remainder(angle + np.pi, 2.0 * np.pi) - np.pi
    jet = ground.jets_at(speed, row, errors=True)
    here = _height(jet, np.asarray(ground.orders, dtype=float), angle)
    value = np.sqrt(2.0 * here.h)
    inside = ((speed > low) & (speed < high)) | (np.abs(here.v) <= here.v_uncertainty)
    # what another step would move it by
    left = _step(here, speed, starts.reach[best], ground.highest, np.ones(len(best)), low, high)[0]
    drift = np.where(inside, _speed_uncertainty(here, high - low) + np.abs(left), 0.0)
    peaks.value[row], peaks.error[row] = value, here.value_uncertainty + np.abs(gain) * value
    peaks.speed[row], peaks.angle[row], peaks.gain[row] = speed, angle, gain
    peaks.speed_error[row] = drift + 2.0 * UNIT_ROUNDOFF * speed
    peaks.harmonics[row] = jet.value
    return peaks, ends


class _Found(NamedTuple):
    """Where starts (starts,) have got to, the step that is left, and `shape` of one jet."""

    speed: np.ndarray
    angle: np.ndarray
    here: "_Height"
    step_v: np.ndarray
    step_a: np.ndarray
    gain: np.ndarray
    shape: tuple[int, ...]


def _ascend(ground: Ground, jets_at: JetsAt, starts: Starts, floor: np.ndarray) -> _Found:
    """Climb from all starts, by one of the two ways to the jets."""
    order, top_order = np.asarray(ground.orders, dtype=float), ground.highest
    enough = _ARRIVED
    if jets_at is ground.look:
        enough, floor = _ARRIVED_BY_LOOK, floor * (1.0 - _ALIKE_BY_LOOK)
    low, high = (np.broadcast_to(end, len(floor))[starts.row] for end in ground[2:4])
    speed, angle = starts.speed.copy(), starts.angle.copy()
    radius = np.ones(len(speed))
    jet = jets_at(speed, starts.row)
    here = _height(jet, order, angle)
    steps = list(_step(here, speed, starts.reach, top_order, radius, low, high))
    for _ in range(_MOST_STEPS):
        step_v, step_a, gain, concave = steps
        moving = (
            (gain > enough)
            & (radius > 1e-9)
            & (~concave | _may_win(here.h, gain, starts.row, floor))
        )
        if not np.any(moving):
            break
        at = np.flatnonzero(moving)
        trial_v = np.clip(speed[at] + step_v[at], low[at], high[at])
        trial_a = angle[at] + step_a[at]
        there = _height(jets_at(trial_v, starts.row[at]), order, trial_a)
        # so near the top heights differ by rounding only, and Newton's step is the better judge
        better = (there.h >= here.h[at]) | (gain[at] < _FLAT)
        radius[at] = np.where(better, np.minimum(2.0 * radius[at], 1.0), 0.25 * radius[at])
        taken = at[better]
        speed[taken], angle[taken] = trial_v[better], trial_a[better]
        for old, new in zip(here[:6], there[:6], strict=True):
            old[taken] = new[better]
        stood = _Height._make([*(part[at] for part in here[:6]), _NONE, _NONE, _NONE])
        moved = _step(stood, speed[at], starts.reach[at], top_order, radius[at], low[at], high[at])
        for part, new in zip(steps, moved, strict=True):
            part[at] = new
    step_v, step_a, gain, _ = steps
    return _Found(speed, angle, here, step_v, step_a, gain, jet.value.shape[1:])


def _contenders(found: _Found, starts: Starts, floor: np.ndarray) -> Starts:
    """Where those have got to that may be the highest of their row, one for each such place."""
    height, row = found.here.h, starts.row
    best = floor * (1.0 - _ALIKE_BY_LOOK)
    np.maximum.at(best, row, height)
    chosen = np.flatnonzero((height >= best[row] * (1.0 - _ALIKE_BY_LOOK)) & (height > 0.0))
    reach, turn = starts.reach[chosen], found.angle[chosen]
    order = np.lexsort((found.speed[chosen], row[chosen]))
    chosen, reach, turn = chosen[order], reach[order], turn[order]
    near = np.diff(found.speed[chosen]) <= _SAME_BY_LOOK * reach[1:]
    twice = np.remainder(np.diff(turn) + np.pi, 2.0 * np.pi) - np.pi
    near &= np.abs(twice) <= _SAME_BY_LOOK
    near &= np.diff(row[chosen]) == 0
    chosen = chosen[np.concatenate([np.ones(min(len(chosen), 1), bool), ~near])]
    return Starts(found.speed[chosen], found.angle[chosen], row[chosen], starts.reach[chosen])


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
        turned = uncertainty @ order + (jet.turn_error if jet.turn_error.size else 0.0)
        df_a, size = _length(turned), _length(f)
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
    start: np.ndarray,
    stop: np.ndarray,
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


def _speed_uncertainty(at: _Height, span: np.ndarray) -> np.ndarray:
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
#: relative distance of speeds up to which two tops are one
_SAME_TOP = 1e-7


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
    # another part whose errors reach above leaves the value open so far, and the speed
    above = np.max([np.where(p.error > 0.0, p.value + p.error, 0.0) for p in peaks], axis=0)
    finite = np.isfinite(best.value)
    higher = np.where(finite, above - best.value, 0.0)
    unsure, level = finite & (best.error > SURE * best.value), best.value - best.error
    away = [
        (unsure & (p.value + p.error >= level)) * (np.abs(p.speed - best.speed) + p.speed_error)
        for p in peaks
    ]
    return best._replace(
        error=np.maximum(best.error, higher),
        speed_error=np.maximum(best.speed_error, np.max(away, axis=0)),
    )


class Samples(NamedTuple):
    """Speeds that were examined, of one machine after the other, each at least at two.

    `machine`, `speed` (n,), ascending; `value` (n, rows) are peaks over a grid of crank angles, or
    what they cannot reach where that is no candidate; `harmonics` (n, rows, components, orders).
    """

    machine: np.ndarray
    speed: np.ndarray
    value: np.ndarray
    harmonics: np.ndarray


class Search(NamedTuple):
    """Where the highest peaks of rows are sought: those of each machine follow each other.

    `ground` has the rows (machines * rows,), `angle` is the grid of crank angles, `infinite` tells
    rows that have no bound. `harmonics_at` gives all rows (n, rows, components, orders) of machines
    (n,) at speeds (n,).
    """

    ground: Ground
    angle: np.ndarray
    infinite: np.ndarray
    harmonics_at: Callable[[np.ndarray, np.ndarray], np.ndarray]


def highest(search: Search, samples: Samples, threshold: float, sparse: bool = False) -> RunUpPeak:
    """Polish every local maximum that may be the highest, and keep the best of each row.

    Among `sparse` speeds a kink may part two peaks within a step, or one may hide next to the
    maximum: then the speeds next to it are starts as well. Rows without bound stay zero.
    """
    machine, speed, value, harmonics = samples
    total, rows = len(search.infinite), value.shape[1]
    first = np.diff(machine, prepend=-1) > 0
    last = np.append(first[1:], True)
    before = np.where(first[:, None], -1.0, np.roll(value, 1, axis=0))
    after = np.where(last[:, None], -1.0, np.roll(value, -1, axis=0))
    local = (value >= before) & (value >= after)
    top = np.maximum.reduceat(value, np.flatnonzero(first))[machine]
    high = (value >= threshold * top) & (value > 0.0) & ~search.infinite.reshape(-1, rows)[machine]
    reach = np.where(last, speed, np.roll(speed, -1)) - np.where(first, speed, np.roll(speed, 1))

    if not np.any(local & high):
        start = np.broadcast_to(search.ground.start, total).copy()
        return RunUpPeak(np.zeros(total), np.zeros(total), start, np.zeros(total))
    lower = np.roll(local & high, 1, axis=0) & ~first[:, None]
    upper = np.roll(local & high, -1, axis=0) & ~last[:, None]
    around = (lower | upper) & high & sparse
    at, row = np.nonzero((local & high) | around)
    places = Starts(speed[at], np.zeros(len(at)), machine[at] * rows + row, reach[at])
    starts = _branches(search, places, harmonics[at, row], threshold)
    return RunUpPeak(*_climbed(search, starts, rows, threshold)[:4])


def _climbed(search: Search, starts: Starts, rows: int, threshold: float) -> RunUpPeaks:
    """Peaks of all rows; where another branch over the angle is high there, it is climbed too.

    Of two branches that cross between two speeds one may be too low at either to be a start.
    """
    ground, total = search.ground, len(search.infinite)
    peaks, ends = climb(ground, starts, np.zeros(total))
    every = [ends]
    period = len(search.angle) * search.angle[1]
    reach = np.zeros(total)
    np.maximum.at(reach, starts.row, starts.reach)
    row, climbed = np.flatnonzero(peaks.value > 0.0), starts
    # next to an end of the range that is high a peak may hide before the next speed
    at_stop = peaks.speed == ground.stop
    edge = row[((peaks.speed == ground.start) | at_stop)[row]]
    if len(edge):
        inwards = np.where(at_stop[edge], -reach[edge], reach[edge])
        inner = (peaks.speed[edge] + np.array([[0.25], [0.5]]) * inwards).ravel()
        places = Starts(inner, np.zeros(len(inner)), np.tile(edge, 2), np.tile(reach[edge], 2))
        machine, place = np.divmod(places.row, rows)
        values = search.harmonics_at(machine, inner)[np.arange(len(inner)), place]
        near = _branches(search, places, values, threshold)
        again, ends = climb(ground, near, peaks.value)
        _keep(peaks, again)
        every.append(ends)
    for _ in range(_MOST_CLIMBS):
        tops = Starts(peaks.speed[row], peaks.angle[row], row, reach[row])
        there = _branches(search, tops, peaks.harmonics[row], threshold)
        known = _are_known(there, climbed, period, 4.5 * search.angle[1])
        if np.all(known):
            break
        there = Starts(*(part[~known] for part in there))
        again, ends = climb(ground, there, peaks.value)
        every.append(ends)
        climbed = Starts(*(np.concatenate(pair) for pair in zip(climbed, there, strict=True)))
        row = _keep(peaks, again)
        if not len(row):
            break
    return open_between(peaks, every)


def open_between(peaks: RunUpPeaks, every: Sequence[Ends]) -> RunUpPeaks:
    """The same, with the speeds of other tops that errors of the harmonics do not exclude."""
    row, speed, left, value = (np.concatenate(part) for part in zip(*every, strict=True))
    away, error = np.abs(speed - peaks.speed[row]), peaks.error[row]
    # about as uncertain as the highest one
    left = left + peaks.speed_error[row]
    # both heights are off
    rival = (value >= peaks.value[row] - 2.0 * error) & (error > SURE * peaks.value[row])
    rival &= away > _SAME_TOP * peaks.speed[row]
    speed_error = peaks.speed_error.copy()
    np.maximum.at(speed_error, row[rival], (away + left)[rival])
    return peaks._replace(speed_error=speed_error)


def _are_known(there: Starts, climbed: Starts, period: float, near: float) -> np.ndarray:
    """Which branches are among those `climbed`: by angle, to a quarter of the highest wave."""
    order = np.argsort(climbed.row, kind="stable")
    first = np.searchsorted(climbed.row[order], there.row)
    count = np.searchsorted(climbed.row[order], there.row, side="right") - first
    each = np.repeat(np.arange(len(there.row)), count)
    other = order[np.arange(len(each)) - np.repeat(np.cumsum(count) - count - first, count)]
    away = np.remainder(there.angle[each] - climbed.angle[other] + 0.5 * period, period)
    found = np.zeros(len(there.row), dtype=bool)
    found[each[np.abs(away - 0.5 * period) < near]] = True
    return found


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
    height = squares(harmonics, search.ground.orders, search.angle)
    around = np.maximum(np.roll(height, 1, axis=-1), np.roll(height, -1, axis=-1))
    # the grid itself may miss two per cent of a peak
    floor = np.square(0.96 * threshold) * np.max(height, axis=-1, keepdims=True)
    each, column = np.nonzero((height >= around) & (height >= floor))
    reach = np.maximum(places.reach, 1e-12 * places.speed)
    return Starts(places.speed[each], search.angle[column], places.row[each], reach[each])


# ----------------------------------------------------------------------------
# What errors of the harmonics leave open of the highest peaks: they may lift a row anywhere.
# ----------------------------------------------------------------------------

#: orders above the highest one whose resonances are looked at for what is left out
_BEYOND = 24

#: some of the rows (k,) -> of each its number, speeds (n,), rising, and its curve (n,)
CurvesOf = Callable[[np.ndarray], Iterable[tuple[int, np.ndarray, Bounded]]]


def over_all(peak: RunUpPeak, curves_of: CurvesOf) -> RunUpPeak:
    """The same with errors that count the whole curve of each row that is not known to rounding."""
    error, speed_error = peak.error.copy(), peak.speed_error.copy()
    unsure = np.flatnonzero(peak.error > SURE * peak.value)
    for row, speed, curve in curves_of(unsure) if len(unsure) else ():
        top = Bounded(peak.speed[row], peak.speed_error[row])
        height = Bounded(peak.value[row], peak.error[row])
        speed_error[row], error[row] = top_errors(top, height, speed, curve)
    return peak._replace(error=error, speed_error=speed_error)


def beyond_speeds(frequency: np.ndarray, exposed: np.ndarray, highest: float) -> np.ndarray:
    """Speeds (..., k) at which orders above the highest one meet modes (..., modes) with damping.

    NaN for those of modes without.
    """
    damped = np.where(exposed > 0.0, np.nan, frequency)[..., None]
    met = damped / (highest + np.arange(1.0, _BEYOND + 1.0))
    return np.asarray(met.reshape(*met.shape[:-2], -1))
