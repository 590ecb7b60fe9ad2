"""The motion of all modes over a whole course, run by run, and at any time between."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.response.switching.free_motion import memory, modal_size, propagator
from vibecalc.response.switching.march import driven_part, march
from vibecalc.response.switching.run import Run, load_at, panel_grid, require_panels, runs_of
from vibecalc.response.switching.steady import steady_motion, steady_state
from vibecalc.response.switching.system import ModalLoads, ModalSystem, Piece

_BLOCK = 1 << 15


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


class Motion(NamedTuple):
    """Modal displacement and its three derivatives by time, each (times, modes)."""

    displacement: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    jerk: np.ndarray


def follow_course(
    system: ModalSystem,
    loads: ModalLoads,
    pieces: Sequence[Piece],
    *,
    angle: float,
    before: int,
    longest: float,
) -> list[Segment]:
    """Segments of a course that begins in the steady motion of the operation `before`.

    At a constant speed the motion is the steady one plus free motion, in closed form; else it is
    marched. `longest` in s bounds the distance of the times. Raises NumericalFailure if there
    would be too many of them.
    """
    runs = runs_of(pieces, angle)
    grids = [panel_grid(system, loads, run, longest) for run in runs]
    require_panels(sum(map(len, grids)), 0.0, runs[-1].start + runs[-1].duration)
    first = pieces[0].start_speed
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
    for start in range(0, len(time), _BLOCK):
        part = time[start : start + _BLOCK]
        forced = steady_state(steady, loads.orders, run.speed, run.angle_at(part))
        states[start : start + _BLOCK] = forced + propagator(system, part)(state - at_start)
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


def motion_on_grid(system: ModalSystem, loads: ModalLoads, segment: Segment, part: slice) -> Motion:
    """The motion at some of the segment's own times."""
    force, rate = load_at(loads, segment.run, segment.grid[part])
    return _derived(system, segment.state[part], force, rate)


def motion_at(system: ModalSystem, loads: ModalLoads, segment: Segment, time: np.ndarray) -> Motion:
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


def _derived(system: ModalSystem, state: np.ndarray, force: np.ndarray, rate: np.ndarray) -> Motion:
    """Acceleration and jerk from the equation of motion."""
    damping, stiffness = 2.0 * system.damping_ratio * system.frequency, system.frequency**2
    displacement, velocity = state[..., 0], state[..., 1]
    acceleration = force - damping * velocity - stiffness * displacement
    jerk = rate - damping * acceleration - stiffness * velocity
    return Motion(displacement, velocity, acceleration, jerk)
