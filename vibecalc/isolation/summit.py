"""The highest points of rows over crank speed and crank angle, by Newton in both at once."""

from typing import NamedTuple

import numpy as np

from vibecalc.isolation.rows import HarmonicsAt, Jet
from vibecalc.numerics.rounding import UNIT_ROUNDOFF

_MOST_STEPS = 60
_NONE = np.zeros(0)
#: promised relative gain below which a start has arrived, and below which heights tell nothing
_ARRIVED, _FLAT = 1e-18, 1e-12
#: relative difference of heights that is none
_ALIKE = 2e-13
#: of the trusted step, how near a summit a start has merged with it
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


class Summits(NamedTuple):
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
    value_doubt: np.ndarray
    v_doubt: np.ndarray
    a_doubt: np.ndarray


def climb(
    harmonics_at: HarmonicsAt,
    orders: np.ndarray,
    starts: Starts,
    start: float,
    stop: float,
    known: np.ndarray,
    beside: Summits | None = None,
) -> Summits:
    """Maximise |f(speed, angle)| of rows from their starts within [start, stop].

    Only summits above those `known` (rows,) count. A start that comes close to that of its row in
    `beside` stays there.

    A maximum over speed of the peak over the cycle is a smooth point of one branch (an upper
    envelope has kinks only in its valleys), where both slopes vanish, or an end of the range. The
    step is Newton's where the height is concave, turned upwards where it is not, kept within a
    trusted distance, and taken only if it leads up; so no summit is below its start. All starts
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
        if beside is not None:
            moving &= ~_merged(speed, angle, starts, beside, top_order)
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
    own, step_v, gain = starts.row[best], step_v[best], gain[best]
    speed, angle = speed[best], angle[best]
    speed = np.where(arrived, np.clip(speed + step_v, start, stop), speed)
    angle = np.where(arrived, angle + step_a[best], angle)
    angle = np.remainder(angle + np.pi, 2.0 * np.pi) - np.pi
    rows, shape = len(known), jet.value.shape[1:]
    none = [np.zeros(rows) for _ in range(6)]
    found = Summits._make([*none, np.zeros((rows, *shape), dtype=complex)])
    found.speed[:] = start
    if not len(best):
        return found
    jet = _jets(harmonics_at, speed, own, errors=True)
    here = _height(jet, order, angle)
    value = np.sqrt(2.0 * here.h)
    inside = (speed > start) & (speed < stop)
    drift = np.where(inside, _speed_doubt(here, stop - start) + 1e-3 * np.abs(step_v), 0.0)
    found.value[own], found.error[own] = value, here.value_doubt + np.abs(gain) * value
    found.speed[own], found.angle[own], found.gain[own] = speed, angle, gain
    found.speed_error[own] = drift + 2.0 * UNIT_ROUNDOFF * speed
    found.harmonics[own] = jet.value
    return found


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

    A step that promises little says how much is left: the summit is above by what it promises.
    """
    best = floor.copy()
    np.maximum.at(best, row, height)
    may: np.ndarray = (gain > _NEAR) | (height * (1.0 + _MARGIN * gain) >= best[row])
    return may


def _merged(
    speed: np.ndarray, angle: np.ndarray, starts: Starts, beside: Summits, top_order: float
) -> np.ndarray:
    """Which starts have come close to the summit that their row has already."""
    turn = angle - beside.angle[starts.row]
    away = np.abs(np.remainder(turn + np.pi, 2.0 * np.pi) - np.pi)
    near = np.abs(speed - beside.speed[starts.row]) <= _SAME * starts.reach
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
    """Heights (starts,) of jets at crank angles; with doubts where the jets have errors."""
    value, slope = jet.value, jet.slope
    turn = np.exp(1j * angle[:, None] * order)[:, None, :]
    around, around_slope = value * turn, slope * turn
    f = around.real.sum(axis=-1)
    f_v = around_slope.real.sum(axis=-1)
    f_a = -(around.imag @ order)
    f_vv = (jet.curvature * turn).real.sum(axis=-1)
    f_va = -(around_slope.imag @ order)
    f_aa = -(around.real @ np.square(order))
    doubts = (_NONE, _NONE, _NONE)
    if jet.error.size:
        # the angle is rounded, and each order turns by a multiple of it
        rounding = (len(order) + 6.0 + 4.0 * np.pi * order) * UNIT_ROUNDOFF
        doubt = jet.error + rounding * np.abs(value)
        doubt_v = jet.slope_error + rounding * np.abs(slope)
        df, df_v = _length(doubt.sum(axis=-1)), _length(doubt_v.sum(axis=-1))
        df_a, size = _length(doubt @ order), _length(f)
        doubts = (df, size * df_v + df * _length(f_v), size * df_a + df * _length(f_a))
    return _Height(
        0.5 * _dot(f, f), _dot(f, f_v), _dot(f, f_a), _dot(f_v, f_v) + _dot(f, f_vv),
        _dot(f_v, f_a) + _dot(f, f_va), _dot(f_a, f_a) + _dot(f, f_aa), *doubts,
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


def _speed_doubt(at: _Height, span: float) -> np.ndarray:
    """What the doubts of the two slopes make of the speed of the summit; at most the range."""
    determinant = np.abs(at.vv * at.aa - at.va * at.va)
    doubt = np.abs(at.aa) * at.v_doubt + np.abs(at.va) * at.a_doubt
    return np.where(doubt < span * determinant, doubt / np.maximum(determinant, 1e-300), span)
