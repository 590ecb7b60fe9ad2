"""Modes under a load of changing speed: exact free motion, Gauss quadrature of the load.

Over a panel y(h) = E(h) y(0) + integral of E(h - t) (0, f(t)) dt, with E the free motion in closed
form. The integral is taken by Gauss-Legendre rules with 7 points, and with 6 for the error: on
panels in which everything turns by two radians at most, the first misses less than 3e-15 of what
the fastest part adds, the second less than 2e-12. Slower parts miss far less.
"""

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.response.switching.free_motion import (
    decay_bound,
    memory,
    modal_size,
    propagator,
)
from vibecalc.response.switching.run import Run, load_at
from vibecalc.response.switching.system import ModalLoads, ModalSystem

_POINTS = 7
_BLOCK = 1 << 14


def march(
    system: ModalSystem, loads: ModalLoads, run: Run, grid: np.ndarray, state: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """States (times, modes, 2) on the grid from that (modes, 2) at its start.

    Also the error (modes,) that the run adds to the size sqrt(q'^2 + w^2 q^2) of a state, at any
    of its times: quadrature, rounding of angles and sums, and what `loads` leaves out.
    """
    count, modes = len(grid) - 1, len(system.frequency)
    gained, doubt = np.empty((count, modes, 2)), np.empty((count, modes))
    length = np.diff(grid)
    for start in range(0, count, _BLOCK):
        part = slice(start, start + _BLOCK)
        begin, step = grid[:-1][part], length[part]
        gained[part] = driven_part(system, loads, run, begin, step, _POINTS)
        check = driven_part(system, loads, run, begin, step, _POINTS - 1)
        doubt[part] = modal_size(system, gained[part] - check)
    states, rounds = _scan(system, grid, gained, state)

    factor, _ = decay_bound(system)
    window = memory(system, run.duration)
    quadrature = np.minimum(
        np.sum(doubt, axis=0),
        factor * np.max(doubt, axis=0) + np.max(doubt / length[:, None], axis=0) * window,
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
    doubt_of_load = loads.left_out[run.operation] + np.sum(loads.noise[run.operation], axis=0)
    error = error + doubt_of_load * fastest**2 * window
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
            for part in (slice(at, at + _BLOCK) for at in range(0, len(grid) - 1, _BLOCK))
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
    rest = propagator(system, step[:, None] * (1.0 - place))
    return np.stack(
        [
            np.sum(rest.from_velocity * force, axis=1),
            np.sum(rest.rate_from_velocity * force, axis=1),
        ],
        axis=-1,
    )


def _scan(
    system: ModalSystem, grid: np.ndarray, gained: np.ndarray, state: np.ndarray
) -> tuple[np.ndarray, int]:
    """Add up the panels in blocks that advance together; also how many additions follow another.

    Within a block the sum starts from rest; the state at the block's start comes on top through
    the free motion over the whole way, in one step. Nothing is ever amplified.
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
    way = np.cumsum(step, axis=1)
    starts = np.empty((blocks, modes, 2))
    over = propagator(system, way[:, -1])
    for number in range(blocks):
        starts[number] = state
        state = type(over)(*(entry[number] for entry in over))(state) + total[number]
    carried = propagator(system, way)(starts[:, None]) + local
    states = np.concatenate([starts[:1], carried.reshape(-1, modes, 2)[:count]])
    return states, length + blocks
