"""One summit over speed, followed to where its slope vanishes on its own crest and trough."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import BoolArray, FloatArray, IntArray
from vibecalc.optimisation.damper.problem import Damper
from vibecalc.optimisation.damper.readings import readings
from vibecalc.optimisation.damper.relative import System

_STEPS = 40
_MOST_MOVES = 30
#: slope times bracket, over the value, below which a maximum is found to rounding
LEVEL = 1e-15
#: crests closer than this share of a radian of the highest harmonic are one
_SAME_CREST = 0.3


class Summits(NamedTuple):
    """Local maxima over speed: reading number, speed in rad/s, value, slopes by ln J, k, c.

    `bend` (p,) second derivative by speed; 0 at an end of the range. `phase` (p, 2) of the crest
    and the trough that are read: each pair of them is a summit of its own.
    """

    row: IntArray
    speed: FloatArray
    value: FloatArray
    slope: FloatArray
    bend: FloatArray
    phase: FloatArray

    def some(self, which: BoolArray | IntArray) -> "Summits":
        """The summits that an index names."""
        return Summits(
            self.row[which], self.speed[which], self.value[which], self.slope[which],
            self.bend[which], self.phase[which],
        )  # fmt: skip

    def joined(self, other: "Summits") -> "Summits":
        """These and others."""
        return Summits(
            np.append(self.row, other.row), np.append(self.speed, other.speed),
            np.append(self.value, other.value), np.append(self.slope, other.slope, axis=0),
            np.append(self.bend, other.bend), np.append(self.phase, other.phase, axis=0),
        )  # fmt: skip


def about(seen: Summits, speed: tuple[float, float], step: float) -> tuple[FloatArray, FloatArray]:
    """Speeds (p,), (p,) close on both sides of summits, where they have fallen by a thousandth."""
    bend = np.maximum(np.abs(seen.bend), 1e-300)
    width = np.where(seen.bend < 0.0, np.sqrt(1e-3 * np.abs(seen.value) / bend), 1e-3 * speed[1])
    width = np.minimum(width, 0.5 * step)
    return np.maximum(seen.speed - width, speed[0]), np.minimum(seen.speed + width, speed[1])


def same_branch(system: System, first: FloatArray, second: FloatArray) -> BoolArray:
    """Whether phases (..., 2) are those of the same crest and trough."""
    away = np.abs(np.angle(np.exp(1j * (first - second))))
    same: BoolArray = np.all(away < _SAME_CREST / int(system.harmonic.max()), axis=-1)
    return same


def follow(
    system: System, damper: Damper, row: IntArray, low: FloatArray, high: FloatArray,
    tolerance: float = LEVEL, near: FloatArray | None = None,
) -> Summits:  # fmt: skip
    """The maximum of row[i] in or uphill of speeds low[i] to high[i], where the slope is zero.

    Regula falsi with halved ends (Illinois), with a bisection where it stalls, all brackets in one
    batch. A reading that rises to an end of the range has its maximum there. It ends where slope
    times bracket falls below `tolerance` of the value. With phases `near` (p, 2) the crest and the
    trough next to them are followed, otherwise the highest and the lowest are taken at each speed.
    """
    own = near is not None
    low, high, left, right, beside = _uphill(system, damper, row, low, high, near)
    inside = (left > 0.0) & (right < 0.0)
    speed = np.where(inside, 0.5 * (low + high), np.where(right >= 0.0, high, low))
    side = np.zeros(row.size)
    open_ = np.flatnonzero(inside)
    for step in range(_STEPS):
        if open_.size == 0:
            break
        a, b, p, q = low[open_], high[open_], left[open_], right[open_]
        guess = a + (b - a) * p / (p - q)
        # the middle first: on the grid it is the highest of the three
        guess = np.where(step % 8 == 0, 0.5 * (a + b), guess)
        first, last = beside[0, open_], beside[1, open_]
        close = np.where((guess - a < b - guess)[:, None], first, last)
        now = readings(system, damper, guess, row[open_], close if own else None)
        rising = now.by_speed > 0.0
        beside[0, open_] = np.where(rising[:, None], now.phase, first)
        beside[1, open_] = np.where(rising[:, None], last, now.phase)
        again = np.where(rising, 1.0, -1.0)
        same = again == side[open_]
        low[open_], high[open_] = np.where(rising, guess, a), np.where(rising, b, guess)
        left[open_] = np.where(rising, now.by_speed, np.where(same, 0.5 * p, p))
        right[open_] = np.where(rising, np.where(same, 0.5 * q, q), now.by_speed)
        side[open_], speed[open_] = again, guess
        done = np.abs(now.by_speed) * (b - a) <= tolerance * np.abs(now.value)
        done |= (high[open_] - low[open_]) <= 4e-16 * guess
        open_ = open_[~done]
    close = np.where((speed - low < high - speed)[:, None], beside[0], beside[1])
    final = readings(system, damper, speed, row, close if own else None)
    shift = 1e-6 * speed[inside]
    bend = np.zeros(row.size)
    if np.any(inside):
        shifted = readings(
            system, damper, np.append(speed[inside] - shift, speed[inside] + shift),
            np.append(row[inside], row[inside]), np.tile(final.phase[inside], (2, 1)),
        ).by_speed  # fmt: skip
        before, after = np.split(shifted, 2)
        bend[inside] = (after - before) / (2.0 * shift)
    return Summits(row, speed, final.value, final.by_damper, bend, final.phase)


def _uphill(
    system: System, damper: Damper, row: IntArray, low: FloatArray, high: FloatArray,
    near: FloatArray | None,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:  # fmt: skip
    """Brackets (p,), (p,) moved until they hold a summit or an end of the range; slopes and phases
    (2, p, 2) there."""
    slowest, fastest = system.problem.speed
    low, high = low.copy(), high.copy()
    own = near is not None
    both = None if near is None else np.tile(near, (2, 1))
    ends = readings(system, damper, np.append(low, high), np.append(row, row), both)
    left, right = np.split(ends.by_speed, 2)
    phase = ends.phase.reshape(2, -1, 2)
    for _ in range(_MOST_MOVES):
        up = (right >= 0.0) & (high < fastest)
        down = (right < 0.0) & (left <= 0.0) & (low > slowest)
        moved = np.flatnonzero(up | down)
        if moved.size == 0:
            break
        rising, width = up[moved], (high - low)[moved]
        beyond = np.where(rising, high[moved] + 1.5 * width, low[moved] - 1.5 * width)
        beyond = np.clip(beyond, slowest, fastest)
        first, last = phase[0, moved], phase[1, moved]
        close = np.where(rising[:, None], last, first)
        found = readings(system, damper, beyond, row[moved], close if own else None)
        new = found.by_speed
        phase[0, moved] = np.where(rising[:, None], last, found.phase)
        phase[1, moved] = np.where(rising[:, None], found.phase, first)
        low[moved], high[moved], left[moved], right[moved] = (
            np.where(rising, high[moved], beyond), np.where(rising, beyond, low[moved]),
            np.where(rising, right[moved], new), np.where(rising, new, left[moved]),
        )  # fmt: skip
    return low, high, left, right, phase
