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
    Readings,
    map_readings,
    reading_error,
    readings,
    rivals,
    table,
)
from vibecalc.torsion.line import with_ring
from vibecalc.torsion.poles import all_poles

# ----------------------------------------------------------------------------
# One peak over speed, followed to where its slope vanishes on its own crest and trough.
# ----------------------------------------------------------------------------

_STEPS = 60
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
        return DamperPeaks._make(part[which] for part in self)

    def joined(self, other: "DamperPeaks") -> "DamperPeaks":
        """These and others."""
        return DamperPeaks._make(np.concatenate(pair) for pair in zip(self, other, strict=True))


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

    Brackets move uphill until they hold a peak; then regula falsi with halved ends (Illinois), with
    a bisection where it stalls, all in one batch. A reading that rises to an end of the range has
    its maximum there. It ends where slope times bracket falls below `tolerance` of the value. With
    phases `near` (p, 2) the crest and the trough next to them are followed, otherwise the highest
    and the lowest are taken at each speed.
    """
    range_ = system.problem.speed

    def read(speed: FloatArray, row: IntArray, phase: FloatArray, slopes: bool = False) -> Readings:
        return readings(system, damper, speed, row, None if near is None else phase, slopes)

    both = np.zeros((2 * row.size, 2)) if near is None else np.tile(near, (2, 1))
    ends = read(np.append(low, high), np.tile(row, 2), both)
    # of both ends of each bracket
    place, slope = np.stack([low, high]), ends.by_speed.reshape(2, -1).copy()
    phase = ends.phase.reshape(2, -1, 2)
    speed, inside = np.empty(row.size), np.zeros(row.size, dtype=bool)
    side, tries, open_ = np.full(row.size, -1), np.zeros(row.size, dtype=int), np.arange(row.size)
    for _ in range(_STEPS):
        (a, b), (left, right) = place[:, open_], slope[:, open_]
        up = (right >= 0.0) & (b < range_[1])
        down = (right < 0.0) & (left <= 0.0) & (a > range_[0])
        holds = (left > 0.0) & (right < 0.0)
        inside[open_] = holds
        speed[open_] = np.where(holds, 0.5 * (a + b), np.where(right >= 0.0, b, a))
        moves = up | down | holds
        open_, a, b, left, right, up, down, holds = (
            one[moves] for one in (open_, a, b, left, right, up, down, holds)
        )
        if open_.size == 0:
            break
        # the middle first: on the grid it is the highest of the three
        middle = tries[open_] % 8 == 0
        tries[open_] += holds
        share = np.where(middle | ~holds, 0.5, left / np.where(holds, left - right, 1.0))
        share = np.where(up, 2.5, np.where(down, -1.5, share))
        guess = np.clip(a + share * (b - a), *range_)
        nearer = np.where(share > 0.5, 1, 0)
        now = read(guess, row[open_], phase[nearer, open_])
        rising = now.by_speed > 0.0
        for moved, ahead in ((up, 1), (down, 0)):
            some = open_[moved]
            for each in (place, slope, phase):
                each[1 - ahead, some] = each[ahead, some]
        end = np.where(up, 1, np.where(down, 0, np.where(rising, 0, 1)))
        stays = open_[holds & (end == side[open_])]
        slope[1 - side[stays], stays] *= 0.5
        side[open_] = np.where(holds, end, -1)
        place[end, open_], slope[end, open_], phase[end, open_] = guess, now.by_speed, now.phase
        speed[open_] = np.where(holds, guess, speed[open_])
        done = np.abs(now.by_speed) * (b - a) <= tolerance * np.abs(now.value)
        done |= np.diff(place[:, open_], axis=0)[0] <= 4e-16 * guess
        open_ = open_[~(done & holds)]
    first = speed - place[0] < place[1] - speed
    final = read(speed, row, np.where(first[:, None], phase[0], phase[1]), slopes=True)
    bend = np.zeros(row.size)
    if np.any(inside):
        shift = 1e-6 * speed[inside]
        around = np.append(speed[inside] - shift, speed[inside] + shift)
        at, wave = np.tile(row[inside], 2), np.tile(final.phase[inside], (2, 1))
        shifted = readings(system, damper, around, at, wave, by_damper=False).by_speed
        bend[inside] = np.diff(shifted.reshape(2, -1), axis=0)[0] / (2.0 * shift)
    return DamperPeaks(row, speed, final.value, final.by_damper, bend, final.phase)


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
    noise = reading_error(system, damper, tops.speed, tops.row, tops.phase)
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

    def enough(row: IntArray, level: FloatArray, share: float) -> BoolArray:
        """Which levels reach a share of the worst section, or of the limit of heat and travel."""
        section = row < scale.size - 3
        return np.asarray(level >= share * np.where(section, np.max(level[section]), 1.0))

    def highest(tops: DamperPeaks) -> DamperPeaks:
        return _single(system, tops.some(enough(tops.row, tops.value / scale[tops.row], share)))

    # a reading on the grid may lie below its peak: a wide net first, the exact share after
    wide = enough(row, value, 0.85 * share)
    result = highest(follow(system, damper, row[wide], low[wide], high[wide], tolerance))
    which, phase = rivals(system, damper, result.speed, result.row, result.phase)
    if which.size == 0:
        return result
    low, high = about(result, system.problem.speed, grid[1] - grid[0])
    nearby = follow(system, damper, result.row[which], low[which], high[which], tolerance, phase)
    return highest(result.joined(nearby))


def narrow_resonances(system: System, damper: Damper, grid: FloatArray) -> FloatArray:
    """Speeds (r, 2) in rad/s, with half widths, of resonances narrower than two steps of the grid.

    From the poles p of the line with its damper: an order q meets one at Im p / q, its half width
    is |Re p| / q.
    """
    problem = system.problem
    pole = all_poles(with_ring(problem.line, problem.station, *damper)).pole
    order = np.asarray(problem.order, dtype=float)
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

    def levels(self, tops: DamperPeaks) -> tuple[BoolArray, FloatArray, float]:
        """Which peaks (p,) are of sections, what all are compared with (p,), the worst section.

        That is the worst one for sections, the limit for heat and travel.
        """
        section = tops.row < self.system.twist.shape[0]
        worst = float(np.max(tops.value[section], initial=-np.inf))
        return section, np.where(section, worst, self.scale[tops.row]), worst

    @property
    def step(self) -> float:
        """That of the grid of speeds."""
        return float(self.grid[1] - self.grid[0])

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
