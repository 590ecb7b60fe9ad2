"""The largest readings over the range of speeds, at speeds found continuously."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, BoolArray, FloatArray, IntArray
from vibecalc.torsion.damper_design.problem import (
    Damper,
    DamperProblem,
    Limits,
    System,
    check,
    system_of,
)
from vibecalc.torsion.damper_design.readings import (
    NominalTable,
    map_readings,
    reading_error,
    readings,
    rivals,
    table,
)

# ----------------------------------------------------------------------------
# One peak over speed, followed to where its slope vanishes on its own crest and trough.
# ----------------------------------------------------------------------------

_STEPS = 40
_MOST_MOVES = 30
#: slope times bracket, over the value, below which a maximum is found to rounding
LEVEL = 1e-15
#: crests closer than this share of a radian of the highest harmonic are one
_SAME_CREST = 0.3


class DamperPeaks(NamedTuple):
    """Local maxima over speed: reading number, speed in rad/s, value, slopes by ln J, k, c.

    `bend` (p,) second derivative by speed; 0 at an end of the range. `phase` (p, 2) of the crest
    and the trough that are read: each pair of them is a peak of its own.
    """

    row: IntArray
    speed: FloatArray
    value: FloatArray
    slope: FloatArray
    bend: FloatArray
    phase: FloatArray

    def some(self, which: BoolArray | IntArray) -> "DamperPeaks":
        """The peaks that an index names."""
        return DamperPeaks(
            self.row[which], self.speed[which], self.value[which], self.slope[which],
            self.bend[which], self.phase[which],
        )  # fmt: skip

    def joined(self, other: "DamperPeaks") -> "DamperPeaks":
        """These and others."""
        return DamperPeaks(
            np.append(self.row, other.row), np.append(self.speed, other.speed),
            np.append(self.value, other.value), np.append(self.slope, other.slope, axis=0),
            np.append(self.bend, other.bend), np.append(self.phase, other.phase, axis=0),
        )  # fmt: skip


def about(
    tops: DamperPeaks, speed: tuple[float, float], step: float
) -> tuple[FloatArray, FloatArray]:
    """Speeds (p,), (p,) close on both sides of peaks, where they have fallen by a thousandth."""
    bend = np.maximum(np.abs(tops.bend), 1e-300)
    width = np.where(tops.bend < 0.0, np.sqrt(1e-3 * np.abs(tops.value) / bend), 1e-3 * speed[1])
    width = np.minimum(width, 0.5 * step)
    return np.maximum(tops.speed - width, speed[0]), np.minimum(tops.speed + width, speed[1])


def same_branch(system: System, first: FloatArray, second: FloatArray) -> BoolArray:
    """Whether phases (..., 2) are those of the same crest and trough."""
    away = np.abs(np.angle(np.exp(1j * (first - second))))
    same: BoolArray = np.all(away < _SAME_CREST / int(system.harmonic.max()), axis=-1)
    return same


def follow(
    system: System, damper: Damper, row: IntArray, low: FloatArray, high: FloatArray,
    tolerance: float = LEVEL, near: FloatArray | None = None,
) -> DamperPeaks:  # fmt: skip
    """The maximum of row[i] in or uphill of speeds low[i] to high[i], where the slope is zero.

    Regula falsi with halved ends (Illinois), with a bisection where it stalls, all brackets in one
    batch. A reading that rises to an end of the range has its maximum there. It ends where slope
    times bracket falls below `tolerance` of the value. With phases `near` (p, 2) the crest and the
    trough next to them are followed, otherwise the highest and the lowest are taken at each speed.
    """
    given_phase = near is not None
    low, high, left, right, nearby = _uphill(system, damper, row, low, high, near)
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
        first, last = nearby[0, open_], nearby[1, open_]
        close = np.where((guess - a < b - guess)[:, None], first, last)
        now = readings(
            system, damper, guess, row[open_], close if given_phase else None, by_damper=False
        )
        rising = now.by_speed > 0.0
        nearby[0, open_] = np.where(rising[:, None], now.phase, first)
        nearby[1, open_] = np.where(rising[:, None], last, now.phase)
        again = np.where(rising, 1.0, -1.0)
        same = again == side[open_]
        low[open_], high[open_] = np.where(rising, guess, a), np.where(rising, b, guess)
        left[open_] = np.where(rising, now.by_speed, np.where(same, 0.5 * p, p))
        right[open_] = np.where(rising, np.where(same, 0.5 * q, q), now.by_speed)
        side[open_], speed[open_] = again, guess
        done = np.abs(now.by_speed) * (b - a) <= tolerance * np.abs(now.value)
        done |= (high[open_] - low[open_]) <= 4e-16 * guess
        open_ = open_[~done]
    close = np.where((speed - low < high - speed)[:, None], nearby[0], nearby[1])
    final = readings(system, damper, speed, row, close if given_phase else None)
    shift = 1e-6 * speed[inside]
    bend = np.zeros(row.size)
    if np.any(inside):
        shifted = readings(
            system, damper, np.append(speed[inside] - shift, speed[inside] + shift),
            np.append(row[inside], row[inside]), np.tile(final.phase[inside], (2, 1)),
            by_damper=False,
        ).by_speed  # fmt: skip
        before, after = np.split(shifted, 2)
        bend[inside] = (after - before) / (2.0 * shift)
    return DamperPeaks(row, speed, final.value, final.by_damper, bend, final.phase)


def _uphill(
    system: System, damper: Damper, row: IntArray, low: FloatArray, high: FloatArray,
    near: FloatArray | None,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:  # fmt: skip
    """Brackets (p,), (p,) moved until they hold a peak or an end of the range; slopes and phases
    (2, p, 2) there."""
    slowest, fastest = system.problem.speed
    low, high = low.copy(), high.copy()
    given_phase = near is not None
    both = None if near is None else np.tile(near, (2, 1))
    ends = readings(
        system, damper, np.append(low, high), np.append(row, row), both, by_damper=False
    )
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
        ahead = readings(
            system, damper, beyond, row[moved], close if given_phase else None, by_damper=False
        )
        new = ahead.by_speed
        phase[0, moved] = np.where(rising[:, None], last, ahead.phase)
        phase[1, moved] = np.where(rising[:, None], ahead.phase, first)
        low[moved], high[moved], left[moved], right[moved] = (
            np.where(rising, high[moved], beyond), np.where(rising, beyond, low[moved]),
            np.where(rising, right[moved], new), np.where(rising, new, left[moved]),
        )  # fmt: skip
    return low, high, left, right, phase


# ----------------------------------------------------------------------------
# How well the speed of a peak is known, though the peak itself is flat.
# ----------------------------------------------------------------------------

#: change of a logarithm over which the drift of peaks is examined
_MOVED = 1e-4


def place_error(system: System, damper: Damper, tops: DamperPeaks) -> FloatArray:
    """Error (p,) of the speeds of peaks of this damper, in rad/s.

    The slope that is left over the curvature, and the round-off of the slope: that of the value
    over the width of the peak. At an end of the range the speed is that end.
    """
    left = readings(system, damper, tops.speed, tops.row, tops.phase, by_damper=False).by_speed
    noise = reading_error(system, damper, tops.speed, tops.row)
    bend = np.abs(tops.bend)
    inside = (tops.bend < 0.0) & (tops.value > 0.0)
    safe = np.where(inside, bend, 1.0)
    moved = np.abs(left) / safe + noise / np.sqrt(np.where(inside, tops.value, 1.0) * safe)
    error: FloatArray = np.where(inside, moved, 0.0) + 2.0 * EPSILON * tops.speed
    return error


def drift(system: System, damper: Damper, tops: DamperPeaks, step: float) -> FloatArray:
    """What the speeds of peaks move (p, 3) by the logarithms of J, k and c, in rad/s.

    `step` is that of the grid of speeds on which they were found.
    """
    low, high = about(tops, system.problem.speed, step)
    moved = np.zeros((tops.row.size, 3))
    for column in range(3):
        pair = []
        for side in (_MOVED, -_MOVED):
            factor = np.ones(3)
            factor[column] += side
            nearby = Damper(*(float(value) for value in factor * np.array(damper)))
            pair.append(follow(system, nearby, tops.row, low, high, near=tops.phase).speed)
        moved[:, column] = (pair[0] - pair[1]) / (2.0 * _MOVED)
    return moved


# ----------------------------------------------------------------------------
# The largest readings over the range of speeds, at speeds found continuously.
#
# A coarse grid of speeds only says where to search. Each local maximum is followed to where its
# slope by speed vanishes, and narrow resonances, which a grid may miss, are computed from the
# damped poles of the line with this damper.
# ----------------------------------------------------------------------------

#: half width over speed of a resonance without damping, and how far it stands out
_UNDAMPED, _UNBOUNDED = 1e-9, 1e6


def peaks(
    system: System, responses: NominalTable, damper: Damper, scale: FloatArray, share: float,
    tolerance: float = LEVEL,
) -> DamperPeaks:  # fmt: skip
    """All maxima over speed: sections that reach `share` of the worst one, heat and travel.

    Readings are compared over `scale` (e + 3,); rows of infinite scale are left out. Heat and
    travel count from `share` of their scale, the limit. `tolerance` as in `follow`. The ring
    inertia is that of the table.
    """
    coarse = map_readings(
        system, responses, np.array([damper.stiffness]), np.array([damper.damping])
    )[0] / scale  # fmt: skip
    grid = responses.speed
    padded = np.pad(coarse, ((1, 1), (0, 0)), constant_values=-np.inf)
    local = (coarse >= padded[:-2]) & (coarse > padded[2:])
    place, row = np.nonzero(local & np.isfinite(scale))
    last = grid.size - 1
    low, high = grid[np.maximum(place - 1, 0)], grid[np.minimum(place + 1, last)]
    value = coarse[place, row]
    narrow = narrow_resonances(system, damper, grid)
    if narrow.size:
        rows = np.flatnonzero(np.isfinite(scale))
        speed, width = np.repeat(narrow[:, 0], rows.size), np.repeat(narrow[:, 1], rows.size)
        added = np.tile(rows, len(narrow))
        undamped_values = map_readings(
            system, table(system, damper, narrow[:, 0]),
            np.array([damper.stiffness]), np.array([damper.damping]),
        )[0]  # fmt: skip
        levels = (undamped_values[:, rows] / scale[rows]).ravel()
        undamped = (width <= _UNDAMPED * speed) & (added < scale.size - 3)
        if np.any(levels[undamped] > _UNBOUNDED * np.max(coarse[:, :-3])):
            first = speed[undamped][int(np.argmax(levels[undamped]))]
            raise NumericalFailure(
                f"a mode that the damper does not reach is excited without damping at "
                f"{first:.6g} rad/s: no tuning bounds it"
            )
        low = np.append(low, np.maximum(speed - 3.0 * width, grid[0]))
        high = np.append(high, np.minimum(speed + 3.0 * width, grid[-1]))
        row, value = np.append(row, added), np.append(value, levels)
    # a reading on the grid may lie below its peak: a wide net first, the exact share after
    high_enough = _high_enough(system, row, value, 0.85 * share)
    result = follow(
        system, damper, row[high_enough], low[high_enough], high[high_enough], tolerance
    )
    level = result.value / scale[result.row]
    result = _single(system, result.some(_high_enough(system, result.row, level, share)))
    which, phase = rivals(system, damper, result.speed, result.row, result.phase)
    if which.size == 0:
        return result
    low, high = about(result, system.problem.speed, grid[1] - grid[0])
    nearby = follow(system, damper, result.row[which], low[which], high[which], tolerance, phase)
    result = result.joined(nearby)
    level = result.value / scale[result.row]
    return _single(system, result.some(_high_enough(system, result.row, level, share)))


def _high_enough(system: System, row: IntArray, level: FloatArray, share: float) -> BoolArray:
    """Which levels reach a share of the worst section, or of the limit of heat and travel."""
    section = row < system.twist.shape[0]
    enough: BoolArray = level >= share * np.where(section, np.max(level[section]), 1.0)
    return enough


def narrow_resonances(system: System, damper: Damper, grid: FloatArray) -> FloatArray:
    """Speeds (r, 2) in rad/s, with half widths, of resonances narrower than two steps of the grid.

    From the poles p of the line with its damper: an order q meets one at Im p / q, its half width
    is |Re p| / q.
    """
    mass = system.mass + damper.inertia * np.outer(system.ring, system.ring)
    spring, loss = system.spring.copy(), system.loss.copy()
    spring[-1, -1] += damper.stiffness
    loss[-1, -1] += damper.damping
    n = mass.shape[0]
    top = np.hstack([np.zeros((n, n)), np.eye(n)])
    low = np.hstack([-np.linalg.solve(mass, spring), -np.linalg.solve(mass, loss)])
    pole = np.linalg.eigvals(np.vstack([top, low]))
    pole = pole[pole.imag > 1e-6 * np.max(np.abs(pole))]
    order = np.asarray(system.problem.order, dtype=float)
    speed = (pole.imag[:, None] / order).ravel()
    width = (np.abs(pole.real)[:, None] / order).ravel()
    width = np.maximum(width, _UNDAMPED * speed)
    step = np.interp(speed, grid[1:], np.diff(grid))
    narrow = (speed > grid[0]) & (speed < grid[-1]) & (width < 2.0 * step)
    return np.stack([speed[narrow], width[narrow]], axis=-1)


def _single(system: System, tops: DamperPeaks) -> DamperPeaks:
    """Without what two brackets found twice."""
    single: list[int] = []
    for i in np.argsort(-tops.value, kind="stable"):
        twin = (
            (tops.row[single] == tops.row[i])
            & (np.abs(tops.speed[single] / tops.speed[i] - 1.0) < 1e-7)
            & same_branch(system, tops.phase[single], tops.phase[i])
        )
        if not np.any(twin):
            single.append(int(i))
    return tops.some(np.array(single, dtype=np.int64))


# ----------------------------------------------------------------------------
# A design problem made ready for search: its variables are logarithms of what may move.
# ----------------------------------------------------------------------------

#: tables kept, one for each ring inertia
_CACHED = 8


class Survey(NamedTuple):
    """`bounds` (3, 2) of J, k, c; `moving` (v,) which of them are searched; `grid` (s,) of speeds;
    `scale` (e + 3,) of the readings: 1 for sections, the limits for heat and travel, infinite for
    what is not asked."""

    system: System
    limits: Limits
    bounds: FloatArray
    moving: IntArray
    grid: FloatArray
    scale: FloatArray
    tables: dict[float, NominalTable]

    def damper(self, variables: FloatArray) -> Damper:
        """From logarithms (v,) of the moving values; the others stand at their bounds."""
        values = self.bounds[:, 0].copy()
        values[self.moving] = np.exp(variables)
        # a variable on its bound gives the bound itself, not the exponential of its logarithm
        for side in (0, 1):
            at_bound = np.abs(variables - self.logarithms[:, side]) < 1e-14
            values[self.moving[at_bound]] = self.bounds[self.moving[at_bound], side]
        values = np.clip(values, self.bounds[:, 0], self.bounds[:, 1])
        return Damper(*(float(value) for value in values))

    def table(self, inertia: float) -> NominalTable:
        """Of this ring inertia, solved once."""
        if inertia not in self.tables:
            if len(self.tables) >= _CACHED:
                self.tables.pop(next(iter(self.tables)))
            middle = np.sqrt(self.bounds[1:, 0] * self.bounds[1:, 1])
            nominal = Damper(inertia, float(middle[0]), float(middle[1]))
            self.tables[inertia] = table(self.system, nominal, self.grid)
        return self.tables[inertia]

    def peaks(self, damper: Damper, share: float, tolerance: float = LEVEL) -> DamperPeaks:
        """See `worst.peaks`."""
        found = self.table(damper.inertia)
        return peaks(self.system, found, damper, self.scale, share, tolerance)

    @property
    def logarithms(self) -> FloatArray:
        """Bounds (v, 2) of the variables."""
        return np.log(self.bounds[self.moving])


def survey(problem: DamperProblem, limits: Limits, speeds: int = 161) -> Survey:
    """Raises NumericalFailure for a problem without meaning; `speeds` only guides the search."""
    check(problem, limits)
    system = system_of(problem)
    bounds = limits.bounds
    weight = np.asarray(problem.weight, dtype=float)
    scale = np.append(
        np.where(weight > 0.0, 1.0, np.inf), [limits.heat, limits.travel, limits.travel]
    )
    return Survey(
        system, limits, bounds, np.flatnonzero(bounds[:, 1] > bounds[:, 0]),
        np.linspace(*problem.speed, speeds), scale, {},
    )  # fmt: skip


def worst_section(tops: DamperPeaks, sections: int) -> float:
    """Largest weighted half range among peaks."""
    return float(np.max(tops.value[tops.row < sections]))
