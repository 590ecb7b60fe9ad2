"""The motion of all modes over a course of crank speeds, run by run."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.response.switching.system import (
    Loads,
    ModalLoads,
    ModalSystem,
    SpeedSegment,
    decay_bound,
    fastest_rate,
    memory,
    modal_loads,
    modal_size,
    order_waves,
    propagator,
    real_rows,
    steady_motion,
    steady_state,
)

# ----------------------------------------------------------------------------
# A run: a stretch of time in which the crank accelerates evenly, its load and its panels.
# ----------------------------------------------------------------------------

#: phase in rad that the fastest part of the motion may turn within a panel
PANEL_PHASE = 2.0
#: more panels than this are refused
MOST_PANELS = 1_000_000
_PANEL_BLOCK = 1 << 21


class Run(NamedTuple):
    """`start` and `duration` in s, crank `angle` and `speed` at its start, even `acceleration`."""

    start: float
    duration: float
    angle: float
    speed: float
    acceleration: float
    operation: int
    segment: int

    def angle_at(self, time: np.ndarray) -> np.ndarray:
        """Crank angle at times after the run's start."""
        return self.angle + time * (self.speed + 0.5 * self.acceleration * time)

    def speed_at(self, time: np.ndarray) -> np.ndarray:
        """Crank speed at times after the run's start."""
        return self.speed + self.acceleration * time

    @property
    def end_speed(self) -> float:
        """Crank speed at its end."""
        return self.speed + self.acceleration * self.duration


def runs_of(profile: Sequence[SpeedSegment], angle: float) -> list[Run]:
    """The segments one after the other; one that passes a standstill gives two runs.

    Raises ValueError where a segment does not begin at the speed at which the one before it ends.
    """
    runs: list[Run] = []
    start, speed = 0.0, profile[0].start_speed
    for number, segment in enumerate(profile):
        if segment.start_speed != speed:
            raise ValueError(f"segment {number} begins at {segment.start_speed}, not at {speed}")
        acceleration = (segment.end_speed - speed) / segment.duration
        ends = [segment.duration]
        # next to nothing before or after the standstill is no run of its own
        standstill = -speed / acceleration if acceleration else 0.0
        if speed * segment.end_speed < 0.0 and 0.0 < standstill < segment.duration:
            ends = [standstill, segment.duration]
        begin = 0.0
        for end in ends:
            at = 0.0 if begin > 0.0 else speed
            run = Run(
                start + begin, end - begin, angle, at, acceleration, segment.operation, number
            )
            runs.append(run)
            angle = float(np.mod(run.angle_at(np.array(end - begin)), 2.0 * np.pi))
            begin = end
        start, speed = start + segment.duration, segment.end_speed
    return runs


def panel_grid(
    system: ModalSystem, loads: ModalLoads, run: Run, longest: float, phase: float = PANEL_PHASE
) -> np.ndarray:
    """Times (panels + 1,) from 0 to the run's duration, closer where the crank is faster.

    Over a panel the highest order, the fastest pole and the change of speed together turn by
    `phase` at most, and it is not longer than `longest`. Raises NumericalFailure if that takes
    more than a million panels.
    """
    driven = ModalSystem(
        system.shape[:, loads.driven],
        system.frequency[loads.driven],
        system.damping_ratio[loads.driven],
    )
    highest = float(np.max(loads.orders, initial=0))
    sense = 1.0 if run.speed + run.end_speed >= 0.0 else -1.0
    chirp = sense * highest * run.acceleration
    base = fastest_rate(driven) + np.sqrt(abs(chirp)) + phase / longest
    first = base + highest * abs(run.speed)
    total = run.duration * (first + 0.5 * chirp * run.duration)
    count = np.ceil(total / phase)
    require_panels(count, run.start, run.start + run.duration)
    share = np.linspace(0.0, total, int(count) + 1)
    root = np.sqrt(np.maximum(first**2 + 2.0 * chirp * share, 0.0))
    grid: np.ndarray = 2.0 * share / (first + root)
    grid[-1] = run.duration
    return grid


def require_panels(count: float, start: float, end: float) -> None:
    """Raise NumericalFailure where a span of time needs more than a million panels."""
    if not count <= MOST_PANELS:
        raise NumericalFailure(
            f"the transient between {start:.6g} and {end:.6g} s would take {count:.3g} steps, more "
            f"than can be followed ({MOST_PANELS}): the fastest order or mode turns too often; "
            f"shorten it, keep fewer orders, or see whether a mode is meant to be so stiff or so "
            f"strongly damped"
        )


def load_at(
    loads: ModalLoads, run: Run, time: np.ndarray, with_rate: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """Modal load (times, modes) and its rate of change at times after the run's start.

    With S_k = sum p_n (i n)^k exp(i n theta) the load is Re(w^2 S_0 + w' S_-1) and, w' being
    constant, its rate is Re(w^3 S_1 + 3 w w' S_0). Without the rate, the load stands twice.
    """
    amplitude, factor = loads.amplitude[run.operation], 1j * loads.orders[:, None]
    parts = [amplitude, amplitude / factor]
    if with_rate:
        parts.append(amplitude * factor)
    rows = real_rows(np.concatenate(parts, axis=1))
    modes = amplitude.shape[1]
    speed = run.speed_at(time)[:, None]
    push = loads.push[run.operation] * run.acceleration
    value, rate = np.empty((2, len(time), modes))
    step = max(1, _PANEL_BLOCK // (int(np.max(loads.orders, initial=0)) + 1))
    for start in range(0, len(time), step):
        part = slice(start, start + step)
        sums = order_waves(run.angle_at(time[part]), loads.orders) @ rows
        plain, w = sums[:, :modes], speed[part]
        value[part] = w**2 * plain + run.acceleration * sums[:, modes : 2 * modes] + push
        if with_rate:
            rate[part] = w**3 * sums[:, 2 * modes :] + 3.0 * run.acceleration * w * plain
    return value, rate if with_rate else value


# ----------------------------------------------------------------------------
# Modes under a load of changing speed: exact free motion, Gauss quadrature of the load.
#
# Over a panel y(h) = E(h) y(0) + integral of E(h - t) (0, f(t)) dt, with E the free motion in
# closed form. The integral is taken by Gauss-Legendre rules with 7 points, and with 6 for the
# error: on panels in which everything turns by two radians at most, the first misses less than
# 3e-15 of what the fastest part adds, the second less than 2e-12. Slower parts miss far less.
# ----------------------------------------------------------------------------

_POINTS = 7
_MARCH_BLOCK = 1 << 14


def march(
    system: ModalSystem, loads: ModalLoads, run: Run, grid: np.ndarray, state: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """States (times, modes, 2) on the grid from that (modes, 2) at its start.

    Also the error (modes,) that the run adds to the size sqrt(q'^2 + w^2 q^2) of a state, at any
    of its times: quadrature, rounding of angles and sums, and what `loads` leaves out.
    """
    count, modes = len(grid) - 1, len(system.frequency)
    gained, uncertainty = np.empty((count, modes, 2)), np.empty((count, modes))
    length = np.diff(grid)
    for start in range(0, count, _MARCH_BLOCK):
        part = slice(start, start + _MARCH_BLOCK)
        begin, step = grid[:-1][part], length[part]
        gained[part] = driven_part(system, loads, run, begin, step, _POINTS)
        check = driven_part(system, loads, run, begin, step, _POINTS - 1)
        uncertainty[part] = modal_size(system, gained[part] - check)
    states, rounds = _scan(system, grid, gained, state)

    factor, _ = decay_bound(system)
    window = memory(system, run.duration)
    quadrature = np.minimum(
        np.sum(uncertainty, axis=0),
        factor * np.max(uncertainty, axis=0)
        + np.max(uncertainty / length[:, None], axis=0) * window,
    )
    largest = np.max(modal_size(system, states), axis=0)
    fastest = max(abs(run.speed), abs(run.end_speed))
    turned = np.abs(run.angle) + np.max(np.abs(run.angle_at(grid) - run.angle))
    highest = float(np.max(loads.orders, initial=0))
    rounding = EPSILON * (2.0 * rounds + 2.0 * system.frequency * window + highest * turned)
    # the angle is rounded anew at every point, so that its errors add up like a random walk
    force = np.sum(np.abs(loads.amplitude[run.operation]) * loads.orders[:, None], axis=0)
    force = force * (fastest**2 + abs(run.acceleration)) * EPSILON * (1.0 + turned)
    points = 1.0 + _POINTS * count * window / run.duration
    error = quadrature + rounding * largest + 4.0 * force * window / np.sqrt(points)
    uncertainty_of_load = loads.left_out[run.operation] + np.sum(loads.noise[run.operation], axis=0)
    error = error + uncertainty_of_load * fastest**2 * window
    return states, error + _size_of_dropped(system, loads, run, grid)


def _size_of_dropped(
    system: ModalSystem, loads: ModalLoads, run: Run, grid: np.ndarray
) -> np.ndarray:
    """Size (modes,) that the dropped orders alone reach from rest, doubled for between the times.

    What they have done before the run is in its first error, and free motion does not grow.
    """
    if not np.any(loads.dropped):
        return np.zeros(len(system.frequency))
    alone = loads._replace(
        orders=loads.dropped_orders, amplitude=loads.dropped, push=np.zeros_like(loads.push)
    )
    gained = np.concatenate(
        [
            driven_part(system, alone, run, grid[:-1][part], np.diff(grid)[part])
            for part in (
                slice(at, at + _MARCH_BLOCK) for at in range(0, len(grid) - 1, _MARCH_BLOCK)
            )
        ]
    )
    states, _ = _scan(system, grid, gained, np.zeros((len(system.frequency), 2)))
    reached: np.ndarray = 2.0 * np.max(modal_size(system, states), axis=0)
    return reached


def driven_part(
    system: ModalSystem,
    loads: ModalLoads,
    run: Run,
    begin: np.ndarray,
    step: np.ndarray,
    points: int = _POINTS,
) -> np.ndarray:
    """What the load adds to the states (panels, modes, 2) from `begin` over `step` (panels,)."""
    place, weight = np.polynomial.legendre.leggauss(points)
    place, weight = 0.5 * (1.0 + place), 0.5 * weight
    time = begin[:, None] + step[:, None] * place
    force, _ = load_at(loads, run, time.ravel(), with_rate=False)
    force = force.reshape(*time.shape, -1) * (step[:, None] * weight)[..., None]
    remaining = propagator(system, step[:, None] * (1.0 - place))
    return np.stack(
        [
            np.sum(remaining.from_velocity * force, axis=1),
            np.sum(remaining.rate_from_velocity * force, axis=1),
        ],
        axis=-1,
    )


def _scan(
    system: ModalSystem, grid: np.ndarray, gained: np.ndarray, state: np.ndarray
) -> tuple[np.ndarray, int]:
    """Add up the panels in blocks that advance together; also how many additions follow another.

    Within a block the sum starts from rest; the state at the block's start comes on top through
    the free motion over the whole time, in one step. Nothing is ever amplified.
    """
    count, modes = gained.shape[:2]
    length = max(1, int(np.sqrt(count)))
    blocks = -(-count // length)
    padded = np.concatenate([gained, np.zeros((blocks * length - count, modes, 2))])
    step = np.concatenate([np.diff(grid), np.zeros(blocks * length - count)])
    padded, step = padded.reshape(blocks, length, modes, 2), step.reshape(blocks, length)
    local = np.empty_like(padded)
    total = np.zeros((blocks, modes, 2))
    for number in range(length):
        total = propagator(system, step[:, number])(total) + padded[:, number]
        local[:, number] = total
    elapsed = np.cumsum(step, axis=1)
    starts = np.empty((blocks, modes, 2))
    over = propagator(system, elapsed[:, -1])
    for number in range(blocks):
        starts[number] = state
        state = type(over)(*(entry[number] for entry in over))(state) + total[number]
    carried = propagator(system, elapsed)(starts[:, None]) + local
    states = np.concatenate([starts[:1], carried.reshape(-1, modes, 2)[:count]])
    return states, length + blocks


# ----------------------------------------------------------------------------
# The motion of all modes over a whole course, run by run, and at any time between.
# ----------------------------------------------------------------------------

_GRID_BLOCK = 1 << 15


class Segment(NamedTuple):
    """A run that has been followed: `state` (times, modes, 2) at `grid` (times,) after its start.

    `error` (modes,) bounds the error of the size sqrt(q'^2 + w^2 q^2) throughout; `largest`
    (modes,) is the largest such size on the grid.
    """

    run: Run
    grid: np.ndarray
    state: np.ndarray
    error: np.ndarray
    largest: np.ndarray


class ModalMotion(NamedTuple):
    """Modal displacement and its three derivatives by time, each (times, modes)."""

    displacement: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    jerk: np.ndarray


def follow_profile(
    system: ModalSystem,
    loads: ModalLoads,
    profile: Sequence[SpeedSegment],
    *,
    angle: float,
    before: int,
    longest: float,
) -> list[Segment]:
    """Segments of a speed profile that begins in the steady motion of the operation `before`.

    At a constant speed the motion is the steady one plus free motion, in closed form; else it is
    marched. `longest` in s bounds the distance of the times. Raises NumericalFailure if there
    would be too many of them.
    """
    runs = runs_of(profile, angle)
    grids = [panel_grid(system, loads, run, longest) for run in runs]
    require_panels(sum(map(len, grids)), 0.0, runs[-1].start + runs[-1].duration)
    first = profile[0].start_speed
    begin = steady_motion(system, loads, before, first)
    state = steady_state(begin, loads.orders, first, np.asarray(angle))
    segments, error = [], begin.error
    for run, grid in zip(runs, grids, strict=True):
        if run.acceleration == 0.0:
            states, added = _constant_speed(system, loads, run, grid, state)
        else:
            states, added = march(system, loads, run, grid, state)
        error, state = error + added, states[-1]
        largest = np.max(modal_size(system, states), axis=0)
        segments.append(Segment(run, grid, states, error, largest))
    return segments


def _constant_speed(
    system: ModalSystem, loads: ModalLoads, run: Run, time: np.ndarray, state: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """States (times, modes, 2) of steady motion plus the free motion that makes up the start."""
    steady = steady_motion(system, loads, run.operation, run.speed)
    at_start = steady_state(steady, loads.orders, run.speed, np.asarray(run.angle))
    states = np.empty((len(time), *state.shape))
    for start in range(0, len(time), _GRID_BLOCK):
        part = time[start : start + _GRID_BLOCK]
        forced = steady_state(steady, loads.orders, run.speed, run.angle_at(part))
        states[start : start + _GRID_BLOCK] = forced + propagator(system, part)(state - at_start)
    rates = np.abs(loads.orders * run.speed)[:, None]
    size = np.abs(steady.amplitude) * np.maximum(system.frequency, rates)
    turned = abs(run.angle) + abs(run.speed) * run.duration
    window = memory(system, run.duration)
    free = modal_size(system, state - at_start)
    total = np.sum(size, axis=0)
    added = 2.0 * steady.error + EPSILON * (
        (turned + 2.0) * (loads.orders @ size)
        + 4.0 * total
        + (4.0 + 2.0 * system.frequency * window) * free
    )
    return states, added


def motion_on_grid(
    system: ModalSystem, loads: ModalLoads, segment: Segment, part: slice
) -> ModalMotion:
    """The motion at some of the segment's own times."""
    force, rate = load_at(loads, segment.run, segment.grid[part])
    return _derived(system, segment.state[part], force, rate)


def motion_at(
    system: ModalSystem, loads: ModalLoads, segment: Segment, time: np.ndarray
) -> ModalMotion:
    """The motion at any times (times,) after the segment's start, as exactly as on the grid."""
    run, grid = segment.run, segment.grid
    if run.acceleration == 0.0:
        state, _ = _constant_speed(system, loads, run, time, segment.state[0])
    else:
        panel = np.clip(np.searchsorted(grid, time, side="right") - 1, 0, len(grid) - 2)
        step = time - grid[panel]
        gained = driven_part(system, loads, run, grid[panel], step)
        state = propagator(system, step)(segment.state[panel]) + gained
    force, rate = load_at(loads, run, time)
    return _derived(system, state, force, rate)


def _derived(
    system: ModalSystem, state: np.ndarray, force: np.ndarray, rate: np.ndarray
) -> ModalMotion:
    """Acceleration and jerk from the equation of motion."""
    damping, stiffness = 2.0 * system.damping_ratio * system.frequency, system.frequency**2
    displacement, velocity = state[..., 0], state[..., 1]
    acceleration = force - damping * velocity - stiffness * displacement
    jerk = rate - damping * acceleration - stiffness * velocity
    return ModalMotion(displacement, velocity, acceleration, jerk)


# ----------------------------------------------------------------------------
# Which resonances a speed profile runs through, when, and how fast.
# ----------------------------------------------------------------------------


class Passage(NamedTuple):
    """Order `order` meets mode `mode` (from 1) at the crank `speed` (rad/s) and `time` (s).

    `slow_energy` in J is the peak energy of the mode if the crank stayed there. `haste` is
    n |w'| / (zeta w_j)^2: well below 1 the motion follows as if it stayed, above 1 the resonance
    has no time to build up.
    """

    mode: int
    order: int
    speed: float
    time: float
    segment: int
    slow_energy: float
    haste: float


def passages(system: ModalSystem, loads: Loads, profile: Sequence[SpeedSegment]) -> list[Passage]:
    """All passages of driven modes in order of time; a constant speed passes none.

    An order n passes a mode where n |w| is its undamped natural frequency; there
    Q = p_n W^2 / (2 i zeta w_j n W) at W = w_j / n, which is a peak energy of
    w_j^2 |p_n|^2 / (8 zeta^2 n^4).
    Modes damped critically or more have no resonance. Orders whose modal load is zero to rounding
    are not listed. Raises NumericalFailure as `modal_loads` does.
    """
    modal = modal_loads(system, loads)
    listed = []
    for run in runs_of(profile, 0.0):
        if run.acceleration == 0.0:
            continue
        for number, order in enumerate(modal.orders.tolist()):
            speed = system.frequency / order * np.sign(run.speed + run.end_speed)
            time = (speed - run.speed) / run.acceleration
            force = np.abs(modal.amplitude[run.operation, number])
            met = (time >= 0.0) & (time < run.duration) & (force > 0.0)
            for mode in np.flatnonzero(met & (system.damping_ratio < 1.0)).tolist():
                ratio, frequency = system.damping_ratio[mode], system.frequency[mode]
                size = frequency * float(force[mode]) / (2.0 * ratio * order**2)
                haste = order * abs(run.acceleration) / (ratio * frequency) ** 2
                listed.append(
                    Passage(
                        mode + 1,
                        order,
                        float(speed[mode]),
                        run.start + float(time[mode]),
                        run.segment,
                        float(0.5 * size**2),
                        float(haste),
                    )
                )
    return sorted(listed, key=lambda passage: (passage.time, passage.mode))
