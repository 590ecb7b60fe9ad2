"""The highest points of rows over crank speed and crank angle, by Newton in both at once."""

from typing import NamedTuple

import numpy as np

from vibecalc.isolation.rows import HarmonicsAt
from vibecalc.numerics.rounding import UNIT_ROUNDOFF

_MOST_STEPS = 60
_NONE = np.zeros(0)
#: promised relative gain below which a start has arrived, and below which heights tell nothing
_ARRIVED, _FLAT = 1e-18, 1e-12


class Starts(NamedTuple):
    """Where to climb from, each (starts,): speed, crank angle, row, and the speed step to trust."""

    speed: np.ndarray
    angle: np.ndarray
    row: np.ndarray
    reach: np.ndarray


class Summits(NamedTuple):
    """Local maxima (starts,) of the rows' lengths, with their speeds; errors absolute.

    `gain` is what another Newton step would still promise, relative.
    """

    value: np.ndarray
    error: np.ndarray
    speed: np.ndarray
    speed_error: np.ndarray
    gain: np.ndarray


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
    harmonics_at: HarmonicsAt, orders: np.ndarray, starts: Starts, start: float, stop: float
) -> Summits:
    """Maximise |f(speed, angle)| from each start within [start, stop], all starts together.

    A maximum over speed of the peak over the cycle is a smooth point of one branch (an upper
    envelope has kinks only in its valleys), where both slopes vanish, or an end of the range. The
    step is Newton's where the height is concave, shifted to be so where it is not, kept within a
    trusted distance, and taken only if it leads up; so no summit is below its start.
    """
    order = np.asarray(orders, dtype=float)
    top_order = float(np.max(order))
    speed, angle = starts.speed.copy(), starts.angle.copy()
    radius = np.ones(len(speed))
    here = _height(harmonics_at, order, starts.row, speed, angle)
    step_v, step_a, gain = _step(here, speed, starts.reach, top_order, radius, start, stop)
    for _ in range(_MOST_STEPS):
        moving = (gain > _ARRIVED) & (radius > 1e-9)
        if not np.any(moving):
            break
        trial_v = np.where(moving, np.clip(speed + step_v, start, stop), speed)
        trial_a = np.where(moving, angle + step_a, angle)
        there = _height(harmonics_at, order, starts.row, trial_v, trial_a)
        # so near the top heights differ by rounding only, and Newton's step is the better judge
        better = moving & ((there.h >= here.h) | (gain < _FLAT))
        radius = np.where(better, np.minimum(2.0 * radius, 1.0), 0.25 * radius)
        speed, angle = np.where(better, trial_v, speed), np.where(better, trial_a, angle)
        here = _choose(better, there, here)
        step_v, step_a, gain = _step(here, speed, starts.reach, top_order, radius, start, stop)
    # the last step is below what the height can tell apart, and above what the slopes can
    arrived = gain <= _ARRIVED
    speed = np.where(arrived, np.clip(speed + step_v, start, stop), speed)
    angle = np.where(arrived, angle + step_a, angle)
    angle = np.remainder(angle + np.pi, 2.0 * np.pi) - np.pi
    here = _height(harmonics_at, order, starts.row, speed, angle, errors=True)
    value = np.sqrt(2.0 * here.h)
    inside = (speed > start) & (speed < stop)
    drift = np.where(inside, _speed_doubt(here, stop - start) + 1e-3 * np.abs(step_v), 0.0)
    return Summits(
        value,
        here.value_doubt + np.abs(gain) * value,
        speed,
        drift + 2.0 * UNIT_ROUNDOFF * speed,
        gain,
    )


def _height(
    harmonics_at: HarmonicsAt,
    order: np.ndarray,
    row: np.ndarray,
    speed: np.ndarray,
    angle: np.ndarray,
    errors: bool = False,
) -> _Height:
    jet = harmonics_at(speed, slopes=True, errors=errors)
    each = np.arange(len(speed))
    turn = np.exp(1j * angle[:, None] * order)[:, None, :]
    value, slope = jet.value[each, row], jet.slope[each, row]
    around, around_slope = value * turn, slope * turn
    f = around.real.sum(axis=-1)
    f_v = around_slope.real.sum(axis=-1)
    f_a = -(around.imag @ order)
    f_vv = (jet.curvature[each, row] * turn).real.sum(axis=-1)
    f_va = -(around_slope.imag @ order)
    f_aa = -(around.real @ np.square(order))
    doubts = (_NONE, _NONE, _NONE)
    if errors:
        # the angle is rounded, and each order turns by a multiple of it
        rounding = (len(order) + 6.0 + 4.0 * np.pi * order) * UNIT_ROUNDOFF
        doubt = jet.error[each, row] + rounding * np.abs(value)
        doubt_v = jet.slope_error[each, row] + rounding * np.abs(slope)
        df, df_v = _length(doubt.sum(axis=-1)), _length(doubt_v.sum(axis=-1))
        df_a, size = _length(doubt @ order), _length(f)
        doubts = (df, size * df_v + df * _length(f_v), size * df_a + df * _length(f_a))
    return _Height(
        0.5 * _dot(f, f), _dot(f, f_v), _dot(f, f_a), _dot(f_v, f_v) + _dot(f, f_vv),
        _dot(f_v, f_a) + _dot(f, f_va), _dot(f_a, f_a) + _dot(f, f_aa), *doubts,
    )  # fmt: skip


def _choose(better: np.ndarray, there: _Height, here: _Height) -> _Height:
    """Heights of the new places where they are better; without doubts, which the end supplies."""
    places = zip(there[:6], here[:6], strict=True)
    chosen = [np.where(better, new, old) for new, old in places]
    return _Height._make([*chosen, _NONE, _NONE, _NONE])


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
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Step in speed and angle, and the relative gain in height that it promises."""
    scale = 1.0 / np.where(at.h > 0.0, at.h, 1.0)
    v, a = at.v * reach * scale, at.a / top_order * scale
    vv = at.vv * np.square(reach) * scale
    va = at.va * reach / top_order * scale
    aa = at.aa / top_order**2 * scale
    held = ((speed <= start) & (v <= 0.0)) | ((speed >= stop) & (v >= 0.0))
    v, va, vv = np.where(held, 0.0, v), np.where(held, 0.0, va), np.where(held, -1.0, vv)
    highest = 0.5 * (vv + aa) + np.hypot(0.5 * (vv - aa), va)
    size = np.abs(vv) + np.abs(aa) + np.abs(va) + 1e-300
    shift = np.where(highest < -1e-6 * size, 0.0, highest + 0.1 * size)
    vv, aa = vv - shift, aa - shift
    determinant = vv * aa - va * va
    step_v, step_a = (va * a - aa * v) / determinant, (va * v - vv * a) / determinant
    gain = 0.5 * (v * step_v + a * step_a)
    longest = np.maximum(np.abs(step_v), 2.0 * np.abs(step_a)) / radius
    shorter = 1.0 / np.maximum(longest, 1.0)
    # a height of zero (a row at rest) has nowhere to climb
    gain = np.where(at.h > 0.0, np.abs(gain), 0.0)
    return step_v * shorter * reach, step_a * shorter / top_order, gain


def _speed_doubt(at: _Height, span: float) -> np.ndarray:
    """What the doubts of the two slopes make of the speed of the summit; at most the range."""
    determinant = np.abs(at.vv * at.aa - at.va * at.va)
    doubt = np.abs(at.aa) * at.v_doubt + np.abs(at.va) * at.a_doubt
    return np.where(doubt < span * determinant, doubt / np.maximum(determinant, 1e-300), span)
