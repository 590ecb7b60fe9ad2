"""The running state by shooting: one turn integrated with its derivatives, Newton on its start."""

from typing import Protocol

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.roll.demand import demand
from vibecalc.response.roll.fourier_state import FourierState
from vibecalc.response.roll.inertia import Inertia
from vibecalc.response.roll.machine import RollDrive, RollMachine, is_mounted
from vibecalc.response.roll.rates import (
    Place,
    free_rates,
    mounted_rates,
    place_at,
    shell_speed,
)
from vibecalc.response.roll.torques import smooth_angles
from vibecalc.response.roll.turn import Turn

_MOST = 20
_CLOSE = 1e-12


def shooting_state(
    machine: RollMachine, drive: RollDrive, steps: int, momentum: FloatArray
) -> FourierState:
    """Running state of one machine (B = 1) with the classical Runge-Kutta method over the angle.

    Every panel between nodes of the gas tables has `steps` steps; kinks of the motor's curve are
    passed over, which leaves an error of second order in the step. Raises NumericalFailure where
    Newton's method does not converge or the crank stalls.
    """
    edges = smooth_angles(machine, drive)
    x = np.append((edges[:-1, None] + np.diff(edges)[:, None] / steps * np.arange(steps)).ravel(),
                  edges[-1])  # fmt: skip
    middle = 0.5 * (x[1:] + x[:-1])
    places = [_pick(place_at(machine, drive, at[None]), len(at)) for at in (x, middle)]
    free = not is_mounted(machine)
    need = demand(machine, drive)
    start = np.zeros(1 if free else 3)
    start[0] = float(np.max(drive.synchronous_speed)) - float(np.nan_to_num(need.slip[0]))
    size = np.array([start[0]] if free else [start[0], 1e-3, 1e-1])
    evaluations, last = 0, np.inf

    def rates(place: Place, state: FloatArray) -> tuple[FloatArray, FloatArray]:
        if not state[0] > 0.0:
            raise NumericalFailure("roll: shooting stalls within a turn from where it starts")
        if free:
            value, slope = free_rates(machine, drive, place, momentum, state[None])
            return value[0], slope
        found = mounted_rates(machine, drive, place, state[None, None])
        return found.value[0, 0], found.jacobian[0, 0]

    for _ in range(_MOST):
        states = _turn_over(rates, x, places[0], places[1], start)
        evaluations += 4 * (len(x) - 1)
        path, change = states
        step = np.linalg.solve(np.eye(len(start)) - change, path[-1] - start)
        start = start + step
        moved = float(np.max(np.abs(step) / size))
        if moved <= _CLOSE or (moved < 1e-6 and moved >= 0.5 * last):
            break
        last = moved
    else:
        raise NumericalFailure(f"roll: shooting does not converge in {_MOST} turns")
    crank = path[None, :, 0]
    at = place_at(machine, drive, x[None])
    shell = shell_speed(at, momentum, crank) if free else path[None, :, 2]
    angle = np.zeros_like(shell) if free else path[None, :, 1]
    return FourierState(_as_turn(x, crank, shell, angle), evaluations)


def _turn_over(
    rates: "_Rates", x: FloatArray, ends: list[Place], middles: list[Place], start: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """States at the points x of one turn, and the derivative of the last by the first."""
    state, change = start, np.eye(len(start))
    path = [state]
    for place, h in enumerate(np.diff(x)):
        here, between, there = ends[place], middles[place], ends[place + 1]
        k1, j1 = rates(here, state)
        k2, j2 = rates(between, state + 0.5 * h * k1)
        k3, j3 = rates(between, state + 0.5 * h * k2)
        k4, j4 = rates(there, state + h * k3)
        d1 = j1 @ change
        d2 = j2 @ (change + 0.5 * h * d1)
        d3 = j3 @ (change + 0.5 * h * d2)
        d4 = j4 @ (change + h * d3)
        state = state + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
        change = change + h / 6.0 * (d1 + 2.0 * (d2 + d3) + d4)
        path.append(state)
    return np.array(path), change


class _Rates(Protocol):
    """Gives dy/db and its derivatives at a place."""

    def __call__(self, place: Place, state: FloatArray) -> tuple[FloatArray, FloatArray]: ...


def _pick(place: Place, count: int) -> list[Place]:
    """The same at every single angle."""
    moved = place.moved
    return [
        Place(
            Inertia(*(np.asarray(part)[:, k : k + 1] for part in moved)),
            place.load[:, k : k + 1],
            place.drag,
        )
        for k in range(count)
    ]


def _as_turn(x: FloatArray, crank: FloatArray, shell: FloatArray, angle: FloatArray) -> Turn:
    """Time and integrals by the rule of trapezoids, of second order at kinks as the path is."""
    step = np.diff(x)
    slowness = 1.0 / crank
    parts = 0.5 * step * (slowness[:, 1:] + slowness[:, :-1])
    ends = np.concatenate([np.zeros((1, 1)), np.cumsum(parts, axis=1)], axis=1)
    weight = np.zeros_like(crank)
    weight[:, :-1] += 0.5 * step
    weight[:, 1:] += 0.5 * step
    return Turn(x[None], weight, ends, crank, shell, angle, ends[:, -1])
