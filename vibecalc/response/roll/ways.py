"""The ways to a running state, by name, each with one dial; all give a `Turn` of one machine."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import FloatArray
from vibecalc.response.roll.demand import demand
from vibecalc.response.roll.fourier_state import fourier_state
from vibecalc.response.roll.machine import RollDrive, RollMachine, is_mounted, member
from vibecalc.response.roll.march import march_to_repeat
from vibecalc.response.roll.shooting_state import shooting_state
from vibecalc.response.roll.steady import started_momentum
from vibecalc.response.roll.turn import Turn

#: s, as the source's program has it
STEP = 0.5e-3
#: Fourier points without a wish, and steps of shooting between two nodes of the gas tables
_FOURIER, _SHOOTING = 361, 4
#: DOP853's tolerance, and that of the march which it is held against: how much of a kink a step of
#: the same tolerance sees hangs on the last bits
_PLAIN, _TIGHT = 1e-8, 1e-10
#: what a step over a kink leaves of any order
_PAST_KINKS = 2
_MOST_TURNS = 2000
#: a multiplier from which on the turns are counted, what shall be left at their end, and the most
_SLOW, _FADED, _MOST_TURNS = 0.05, 1e-9, 4000


class Asked(NamedTuple):
    """What a way may be told: points (fourier), step in s (euler, rk4), else the default.

    `started_at` is the crank speed that fixes the momentum of a free machine, rad/s; None lets its
    shell stand still on average, with the momentum `momentum` (1,) found by collocation. `fading`
    is what is left of a disturbance after a turn, the largest multiplier.
    """

    points: int | None
    step: float | None
    started_at: float | None
    momentum: FloatArray
    fading: float = 0.0


class Found(NamedTuple):
    """A turn and the same from a finer dial, the order of the method (0: take the difference)."""

    turn: Turn
    finer: Turn
    order: int
    work: int


def find(method: str, machine: RollMachine, drive: RollDrive, asked: Asked) -> Found:
    """The running state of one machine (B = 1) by a named method, twice; NumericalFailure."""
    return WAYS[method](machine, drive, asked)


def _fourier(machine: RollMachine, drive: RollDrive, asked: Asked) -> Found:
    points = asked.points or _FOURIER
    points += 1 - points % 2
    momentum = _momentum(machine, asked)
    plain = fourier_state(machine, drive, points, momentum)
    finer = fourier_state(machine, drive, 2 * points + 1, momentum)
    return Found(plain.turn, finer.turn, _PAST_KINKS, plain.evaluations)


def _shooting(machine: RollMachine, drive: RollDrive, asked: Asked) -> Found:
    momentum = _momentum(machine, asked)
    plain = shooting_state(machine, drive, _SHOOTING, momentum)
    finer = shooting_state(machine, drive, 2 * _SHOOTING, momentum)
    return Found(plain.turn, finer.turn, _PAST_KINKS, plain.evaluations)


def _fixed(method: str, order: int) -> Callable[[RollMachine, RollDrive, Asked], Found]:
    def way(machine: RollMachine, drive: RollDrive, asked: Asked) -> Found:
        step = asked.step or STEP
        plain = _march(machine, drive, asked, method, step)
        finer = _march(machine, drive, asked, method, 0.5 * step)
        return Found(plain[0], finer[0], order, plain[1])

    return way


def _dop853(machine: RollMachine, drive: RollDrive, asked: Asked) -> Found:
    # at its tolerance turns repeat to some millionths at best
    plain = _march(machine, drive, asked, "dop853", 0.0, 3e-5, tolerance=_PLAIN)
    finer = _march(machine, drive, asked, "dop853", 0.0, 1e-5, points=1440, tolerance=_TIGHT)
    return Found(plain[0], finer[0], _PAST_KINKS, plain[1])


def _march(
    machine: RollMachine,
    drive: RollDrive,
    asked: Asked,
    method: str,
    step: float,
    repeats: float = 1e-5,
    points: int = 720,
    tolerance: float = _PLAIN,
) -> tuple[Turn, int]:
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
    found = march_to_repeat(
        alone,
        drive,
        method,
        started_at=speed,
        shell_speed=shell,
        step=step or STEP,
        most=_MOST_TURNS if step else _MOST_TURNS // 4,
        repeats=max(repeats, 2.0 * (step * speed / (2.0 * np.pi)) ** 2),
        turns=turns,
        points=points,
        tolerance=tolerance,
    )
    fields = found.turn._asdict().items()
    there = {name: np.asarray(field)[None] for name, field in fields if field is not None}
    return Turn(**there), found.evaluations


def _momentum(machine: RollMachine, asked: Asked) -> FloatArray:
    if asked.started_at is None:
        return asked.momentum
    return started_momentum(machine, asked.started_at)


WAYS: dict[str, Callable[[RollMachine, RollDrive, Asked], Found]] = {
    "fourier": _fourier,
    "shooting": _shooting,
    "dop853": _dop853,
    "rk4": _fixed("rk4", 4),
    "euler": _fixed("euler", 1),
}
