"""The methods to a running state, by name, each with one setting of its accuracy."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.explicit_steps import METHODS, explicit_step
from vibecalc.numerics.periodic.other_methods import solve_fourier
from vibecalc.numerics.rounding import FloatArray
from vibecalc.roll.march import march_to_repeat
from vibecalc.roll.mechanism import (
    AngleTerms,
    Inertia,
    RollDrive,
    RollMachine,
    is_mounted,
    member,
    place_at,
    smooth_angles,
)
from vibecalc.roll.rates import RollRates, demand, shell_speed
from vibecalc.roll.steady import started_momentum
from vibecalc.roll.turn import Turn, trapezoids

# ----------------------------------------------------------------------------
# The running state by Fourier collocation: evenly spaced crank angles, kinks or no kinks.
# ----------------------------------------------------------------------------


class TurnFound(NamedTuple):
    """Turn of one machine (B = 1) at the points, and evaluations of the right-hand side."""

    turn: Turn
    evaluations: int


def fourier_state(
    machine: RollMachine, drive: RollDrive, points: int, momentum: FloatArray
) -> TurnFound:
    """Running state with an odd number of points; `momentum` (1,) counts for a free machine.

    Kinks leave an error that falls with a power of the number of points only. Raises
    NumericalFailure where Newton's method does not converge.
    """
    free = not is_mounted(machine)
    need = demand(machine, drive)
    speed = drive.synchronous_speed - np.where(need.possible, need.slip, 0.0)
    rates = RollRates(machine, drive, momentum if free else None)
    guess = np.zeros((1, 1 if free else 3))
    guess[:, 0] = speed
    solution = solve_fourier(rates, points, guess)
    if not solution.converged[0]:
        raise NumericalFailure(
            f"roll: Fourier collocation with {points} points finds no running state; "
            'the default method = "collocation" says whether there is one'
        )
    crank = solution.values[..., 0]
    if free:
        place = rates.place(solution.x[None, None, :])
        shell = shell_speed(place, momentum, crank)
        angle = np.zeros_like(shell)
    else:
        shell, angle = solution.values[..., 2], solution.values[..., 1]
    time, period = _time(solution.x, 1.0 / crank)
    weight = np.full_like(crank, 2.0 * np.pi / points)
    turn = Turn(solution.x[None], weight, time, crank, shell, angle, period)
    return TurnFound(turn, rates.evaluations)


def _time(x: FloatArray, slowness: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Integral of the trigonometric interpolant of 1/w (1, N) from 0, and over the turn (1,)."""
    points = len(x)
    share = np.fft.rfft(slowness, axis=-1) / points
    order = np.arange(1, share.shape[-1])
    wave = np.zeros_like(share)
    wave[..., 1:] = share[..., 1:] / (1j * order)
    swing = np.fft.irfft(wave * points, n=points, axis=-1)
    mean = share[..., :1].real
    return mean * x + swing - swing[..., :1], 2.0 * np.pi * mean[..., 0]


# ----------------------------------------------------------------------------
# The running state by shooting: one turn integrated with its derivatives, Newton on its start.
# ----------------------------------------------------------------------------

_MOST = 20
_CLOSE = 1e-12


def shooting_state(
    machine: RollMachine, drive: RollDrive, steps: int, momentum: FloatArray
) -> TurnFound:
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
    equations = RollRates(machine, drive, momentum if free else None)
    evaluations, last = 0, np.inf

    def rates(place: AngleTerms, state: FloatArray) -> tuple[FloatArray, FloatArray]:
        if not state[0] > 0.0:
            raise NumericalFailure("roll: shooting stalls within a turn from where it starts")
        value, jacobian = equations.at(place, state[None, None])
        return value[0, 0], jacobian[0, 0]

    for _ in range(_MOST):
        path, change = _turn_over(rates, x, places[0], places[1], start)
        evaluations += 4 * (len(x) - 1)
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
    return TurnFound(_as_turn(x, crank, shell, angle), evaluations)


def _turn_over(
    rates: Callable[[AngleTerms, FloatArray], tuple[FloatArray, FloatArray]],
    x: FloatArray,
    ends: list[AngleTerms],
    middles: list[AngleTerms],
    start: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """States at the points x of one turn, and the derivative of the last by the first."""
    path, change = [start], np.eye(len(start))
    for place, length in enumerate(np.diff(x)):
        stages = (ends[place], middles[place], middles[place], ends[place + 1])

        def both(stage: int, now: list[FloatArray], at: Sequence[AngleTerms] = stages) -> Any:
            value, jacobian = rates(at[stage], now[0])
            return value, jacobian @ now[1]

        state, change = explicit_step(METHODS["rk4"], both, (path[-1], change), length)
        path.append(state)
    return np.array(path), change


def _pick(place: AngleTerms, count: int) -> list[AngleTerms]:
    """The same at every single angle."""
    moved = place.moved
    return [
        AngleTerms(
            Inertia(*(np.asarray(part)[:, k : k + 1] for part in moved)),
            place.gas_force[:, k : k + 1],
            place.load[:, k : k + 1],
            place.drag,
        )
        for k in range(count)
    ]


def _as_turn(x: FloatArray, crank: FloatArray, shell: FloatArray, angle: FloatArray) -> Turn:
    """Time and integrals by the rule of trapezoids, of second order at kinks as the path is."""
    slowness = 1.0 / crank
    parts = 0.5 * np.diff(x) * (slowness[:, 1:] + slowness[:, :-1])
    time = np.concatenate([np.zeros((1, 1)), np.cumsum(parts, axis=1)], axis=1)
    return Turn(x[None], trapezoids(x)[None], time, crank, shell, angle, time[:, -1])


# ----------------------------------------------------------------------------
# The ways to a running state, by name, each with one setting; all give a `Turn` of one machine.
# ----------------------------------------------------------------------------

#: s, as the source's program has it
STEP = 0.5e-3
#: Fourier points without a wish, and steps of shooting between two nodes of the gas tables
_FOURIER, _SHOOTING = 361, 4
#: how closely turns of DOP853 repeat, its tolerance, and those of the march which it is held
#: against: how much of a kink a step of the same tolerance sees hangs on the last bits
_PLAIN = {"repeats": 3e-5, "points": 720, "tolerance": 1e-8}
_TIGHT = {"repeats": 1e-5, "points": 1440, "tolerance": 1e-10}
#: what a step over a kink leaves of any order
_PAST_KINKS = 2
#: a multiplier from which on the turns are counted, what shall be left at their end, and the most
_SLOW, _FADED, _MOST_TURNS = 0.05, 1e-9, 4000


class Settings(NamedTuple):
    """What a method may be given: points (fourier), step in s (euler, rk4), else the default.

    `started_at` is the crank speed that fixes the momentum of a free machine, rad/s; None lets its
    shell stand still on average, with the momentum `momentum` (1,) found by collocation. `fading`
    is what is left of a disturbance after a turn, the largest multiplier.
    """

    points: int | None
    step: float | None
    started_at: float | None
    momentum: FloatArray
    fading: float = 0.0


class MethodResult(NamedTuple):
    """A turn and the same from a finer setting, order of the method (0: take the difference)."""

    turn: Turn
    finer: Turn
    order: int
    work: int


def find(method: str, machine: RollMachine, drive: RollDrive, asked: Settings) -> MethodResult:
    """The running state of one machine (B = 1) by a named method, twice; NumericalFailure."""
    step = asked.step or STEP
    order = {"euler": 1, "rk4": 4}.get(method, _PAST_KINKS)
    if method in ("fourier", "shooting"):
        momentum, points = asked.momentum, asked.points or _FOURIER
        if asked.started_at is not None:
            momentum = started_momentum(machine, asked.started_at)
        points += 1 - points % 2
        settings = (points, 2 * points + 1) if method == "fourier" else (_SHOOTING, 2 * _SHOOTING)
        solve = {"fourier": fourier_state, "shooting": shooting_state}[method]
        plain, finer = (solve(machine, drive, one, momentum) for one in settings)
    elif method == "dop853":
        plain, finer = (_march(machine, drive, asked, method, 0.0, **c) for c in (_PLAIN, _TIGHT))
    else:
        plain, finer = (_march(machine, drive, asked, method, h) for h in (step, 0.5 * step))
    return MethodResult(plain.turn, finer.turn, order, plain.evaluations)


def _march(
    machine: RollMachine,
    drive: RollDrive,
    asked: Settings,
    method: str,
    step: float,
    repeats: float = 1e-5,
    **further: Any,
) -> TurnFound:
    alone = RollMachine(*(field[0] for field in member(machine, 0)))
    turns = None
    if asked.fading > _SLOW:
        # turns that differ little from each other may still be far from where they lead
        turns = min(_MOST_TURNS, 4 + int(np.ceil(np.log(_FADED) / np.log(asked.fading))))
    need = demand(machine, drive)
    speed, shell = float(np.max(drive.synchronous_speed) - np.max(need.slip)), 0.0
    if not is_mounted(machine):
        # a start that has the angular momentum which the march then keeps
        if asked.started_at is not None:
            speed = asked.started_at
        else:
            still = float(started_momentum(machine, speed)[0])
            inertia = float(machine.shell_inertia[0] + machine.rotor_inertia[0])
            shell = (float(asked.momentum[0]) - still) / inertia
    repeating = march_to_repeat(
        alone, drive, method, started_at=speed, shell_speed=shell, step=step or STEP, turns=turns,
        most=_MOST_TURNS if step else _MOST_TURNS // 4,
        repeats=max(repeats, 2.0 * (step * speed / (2.0 * np.pi)) ** 2), **further,
    )  # fmt: skip
    fields = repeating.turn._asdict().items()
    there = {name: np.asarray(part)[None] for name, part in fields if part is not None}
    return TurnFound(Turn(**there), repeating.evaluations)
