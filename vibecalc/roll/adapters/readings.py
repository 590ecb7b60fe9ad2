"""What is read off one turn of a roll machine: spectra, numbers, time histories, peaks."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.level import level_of
from vibecalc.numerics.rounding import EPSILON, FloatArray
from vibecalc.roll.mechanism import RollDrive, RollMachine
from vibecalc.roll.rates import demand
from vibecalc.roll.results import FORCES, ROLL, VARIABLES
from vibecalc.roll.running import TurnMotion, motion_of_state, speed_of_state, torque_of_state
from vibecalc.roll.steady import SteadyTurn
from vibecalc.roll.turn import (
    Turn,
    balance,
    mean,
    peak,
    readings,
    rounding_left,
    shell_harmonics,
    spectrum,
)

#: crank angles of the time histories of a turn, both ends included
_SHOWN = 361
#: points on a panel that show its peaks without further samples
_RESOLVED = 4
#: of what a step of the setting leaves of a difference, over what the step before left
_SLACK = 10.0
_LEAST_LEFT = 5e-3
#: of the difference of the coarser settings, where that of the finer ones may be small by luck
_PART = 1e-3
#: of an angular momentum; a few roundings of the sums that it comes from
_STILL = 16.0 * EPSILON
#: share of the work moved in a turn up to which that of the motor is rounding
_IDLE = 64.0 * EPSILON

#: what a reading of a turn may be
_Read = TypeVar("_Read")


class MachineTurn(NamedTuple):
    """One machine (B = 1) with its turn, and its motion at any angle.

    `speed` is the crank speed alone at any angle, where the points of the turn show its peaks, and
    `torque` that of the motor; without, they are read off the motion.
    """

    machine: RollMachine
    drive: RollDrive
    turn: Turn
    motion: TurnMotion
    speed: Callable[[FloatArray], FloatArray] | None = None
    torque: Callable[[FloatArray], FloatArray] | None = None


def machine_turn(machine: RollMachine, drive: RollDrive, state: SteadyTurn) -> MachineTurn:
    """What is seen of a state found by collocation."""
    motion = motion_of_state(machine, drive, state)
    speed = speed_of_state(state) if state.points >= _RESOLVED else None
    torque = torque_of_state(machine, drive, state)
    return MachineTurn(machine, drive, state.turn, motion, speed, torque)


class Value(NamedTuple):
    """A number with the size that its rounding is relative to, and an error of its own."""

    value: float
    size: float
    error: float = 0.0


def spectra_of(
    solved: MachineTurn, orders: int, names: Sequence[str]
) -> dict[str, tuple[np.ndarray, float]]:
    """Harmonics (orders,) or (cylinders, orders) by name, each with the rounding in them."""
    read, numbers = readings(solved.machine, solved.drive, solved.turn), np.arange(1.0, orders + 1)
    return {
        name: (
            spectrum(solved.turn, read, name, numbers)[0],
            rounding_left(solved.machine, read, name),
        )
        for name in names
    }


def shell_levels(turns: Sequence[MachineTurn], orders: int) -> Bounded:
    """Levels (orders,) of the shell's acceleration; the second of two turns tells the error."""
    value, other = (shell_harmonics(*one[:3], orders)[0] for one in turns)
    read = readings(*turns[0][:3], pistons=False)
    rounding = rounding_left(turns[0].machine, read, "shell_acceleration")
    return level_of(Bounded(value, np.abs(value - other) + rounding), reference=1.0)


def emit_spectra(scene: Scene, spectra: Mapping[str, Bounded], axes: Mapping[str, Any]) -> None:
    """Harmonics (..., orders) of variables and forces, with their levels and lags."""
    for name, values in spectra.items():
        level = level_of(values, reference=1.0)
        lag = Bounded(*lags_of(values.value, values.error))
        for path, quantity in zip(spectrum_paths(name), (values, level, lag), strict=True):
            scene.emit(path, quantity.value, quantity.error, axes)


def spectrum_paths(name: str) -> tuple[str, ...]:
    """Where the spectrum of a variable stands in a result."""
    return tuple(f"{ROLL}/{kind}{name}" for kind in ("", "level/", "phase_lag/"))


def lags_of(values: np.ndarray, error: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angles by which harmonics lag, in [0, 2 pi), and their errors; zero for what is zero."""
    size = np.abs(values)
    there = size > error
    share = np.where(there, error / np.where(there, size, 1.0), 0.0)
    return np.where(there, np.mod(-np.angle(values), 2.0 * np.pi), 0.0), np.arcsin(share)


class TurnSolutions(NamedTuple):
    """The motion by the method of a case, and what tells how far it is off.

    `other` is from another setting; `order` that of the method, 0 if not known, and `safety` what a
    difference of settings then counts. `best` are two turns by collocation, where another method
    has found the motion: no estimate is below what it differs from these. `coarse`, from a setting
    before the other one, tells how much of a difference a step of the setting leaves; `steps` is
    how long the last step is over the one before.
    """

    solution: MachineTurn
    other: MachineTurn
    order: int = 0
    safety: float = 1.0
    best: tuple[MachineTurn, MachineTurn] | None = None
    coarse: MachineTurn | None = None
    steps: float = 1.0

    def read(self, reading: Callable[[MachineTurn], _Read]) -> tuple[_Read, ...]:
        """The same reading of every turn, that of the method first."""
        nearby = self.best or (() if self.coarse is None else (self.coarse,))
        return tuple(reading(one) for one in (self.solution, self.other, *nearby))

    def error(self, *values: ArrayLike, single: bool = False) -> FloatArray:
        """Error of the first of values that came from `read`.

        A `single` one, such as a peak, may agree by luck: of such nothing is extrapolated.
        """
        solution, other, *best = (np.asarray(value) for value in values)
        if self.coarse is not None and single:
            return np.asarray(np.maximum(np.abs(solution - other), _PART * np.abs(other - best[0])))
        if self.coarse is not None:
            return left_over(solution, other, best[0], self.steps)
        # two runs with fixed steps may differ by less than both are off
        power = 2.0**self.order
        factor = 2.0 * power / (power - 1.0) if self.order else self.safety
        estimate = factor * np.abs(solution - other)
        if best:
            estimate = np.maximum(estimate, np.abs(solution - best[0]) + np.abs(best[0] - best[1]))
        return np.asarray(estimate)


def left_over(
    solution: FloatArray, other: FloatArray, coarse: FloatArray, steps: float = 1.0
) -> FloatArray:
    """Error of what the finest of three settings gives, by how fast their differences fall.

    The difference of the finer two is the error of the second. What the last step leaves of it is
    taken as ten times what the step before has left, to the power of how much longer the last one
    is, and never as more than all. `steps` is that power. Weak high harmonics fall later than
    strong low ones: each entry has its own share, none less than the largest entry's, and none less
    than a two-hundredth, as nobody has seen the last step but one repeat itself.
    """
    last, before = np.abs(solution - other), np.abs(other - coarse)
    tiny = np.finfo(float).tiny
    most = float(np.max(last, initial=0.0)) / max(float(np.max(before, initial=0.0)), tiny)
    share = np.divide(last, before, out=np.ones_like(last), where=before > 0.0)
    left = np.clip(np.maximum(share, most), 0.0, 1.0)
    return np.asarray(last * np.clip(_SLACK * left**steps, _LEAST_LEFT, 1.0))


def numbers_of(solved: MachineTurn) -> dict[str, Value]:
    """Speed, slip, torque, balances."""
    machine, drive, turn = solved.machine, solved.drive, solved.turn
    read = readings(machine, drive, turn)
    work = balance(machine, turn, read)
    need = demand(machine, drive)
    speed = 2.0 * np.pi / float(turn.period[0])
    motor = float(work.motor[0])
    torque = motor / (2.0 * np.pi)
    momentum = float(work.momentum[0])
    # works and impulses are what large ones of both signs leave
    rate = turn.weight / turn.crank_speed
    parts = (read.motor_torque, read.gas_torque, read.friction_torque)
    moved = float(sum(np.sum(turn.weight * np.abs(part)) for part in parts))
    yielded = float(np.sum(rate * np.abs(read.mount_torque * turn.shell_speed)))
    moved += yielded
    shaken = float(mean(turn, np.abs(turn.shell_speed))[0])
    # the momentum that keeps a shell in place is known to about this share
    still = _STILL * abs(momentum) / float(machine.shell_inertia[0])
    pushed = abs(momentum) + float(np.sum(rate * np.abs(read.mount_torque)))
    # a torque that is rounding of what moves the machine is none
    margin = float(need.breakdown[0]) / torque - 1.0 if motor > _IDLE * moved else np.inf
    # a margin is as sure as the torque that it is over
    lean = max(moved / motor, 1.0) if motor > 0.0 else 1.0
    values = {
        "speed": Value(speed, speed),
        "mean_slip": Value(float(mean(turn, read.slip)[0]), speed),
        "mean_torque": Value(torque, moved / (2.0 * np.pi)),
        "breakdown_margin": Value(margin, (1.0 + margin) * lean if np.isfinite(margin) else 1.0),
        "shell_drift": Value(float(mean(turn, turn.shell_speed)[0]), shaken, still),
        "angular_momentum": Value(momentum, abs(momentum)),
        "momentum_residual": Value(float(work.momentum_residual[0]), pushed),
        "energy/motor": Value(motor, moved),
    }
    for name, size in (
        ("gas", moved), ("friction", moved), ("mounts", yielded), ("residual", moved)
    ):  # fmt: skip
        values[f"energy/{name}"] = Value(float(getattr(work, name)[0]), size)
    return values


def leak_of(solved: MachineTurn) -> float:
    """Work that is left over in a turn, over all that is moved; zero for the exact motion.

    It tells of what all settings have in common, such as a kink that lies a little off its panel
    end.
    """
    residual = numbers_of(solved)["energy/residual"]
    return abs(residual.value) / residual.size if residual.size > 0.0 else 0.0


def extremes_of(solved: MachineTurn) -> dict[str, Value]:
    """Largest slip and motor torque, variation of the speed, found between the points."""
    at = solved.speed or (lambda angles: np.asarray(solved.motion(angles).crank_speed[0]))
    angles, known = solved.turn.crank_angle[0], solved.turn.crank_speed[0]
    slow, one = peak(lambda x: -at(x), (angles, -known) if solved.speed else None)
    fast, other = peak(at, (angles, known) if solved.speed else None)
    speed = 2.0 * np.pi / float(solved.turn.period[0])
    sync = float(np.max(solved.drive.synchronous_speed))

    def torque(angles: FloatArray) -> FloatArray:
        read = readings(solved.machine, solved.drive, solved.motion(angles))
        return np.asarray(read.motor_torque[0])

    most, left = peak(solved.torque or torque)
    return {
        "largest_torque": Value(most, abs(most), left),
        "speed_variation": Value((fast + slow) / speed, 1.0, (one + other) / speed),
        "largest_slip": Value(sync + slow, sync, one),
    }


def time_history(solved: MachineTurn) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Crank angles (k,) and variables over the turn (k,), forces (cylinders, k)."""
    angles = np.linspace(0.0, 2.0 * np.pi, _SHOWN)
    at = solved.motion(angles)
    read = readings(solved.machine, solved.drive, at)
    histories = {name: np.asarray(getattr(read, name))[0] for name in VARIABLES}
    for name in (*FORCES, "gas_force"):
        histories[name] = np.asarray(getattr(read, name))[0].T
    histories["time"] = at.time[0]
    return angles, histories


def peaks_of(solved: MachineTurn) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Largest magnitude of each force (cylinders,), and what the search for it leaves open."""

    def top(name: str, place: int) -> tuple[float, float]:
        def size(angles: FloatArray) -> FloatArray:
            read = readings(solved.machine, solved.drive, solved.motion(angles))
            return np.asarray(np.abs(np.asarray(getattr(read, name))[0, :, place]))

        return peak(size)

    places = range(solved.machine.reciprocating_mass.shape[-1])
    tops = {name: np.array([top(name, place) for place in places]) for name in FORCES}
    return {name: (each[:, 0], each[:, 1]) for name, each in tops.items()}


def less(one: Bounded, other: Bounded) -> Bounded:
    """Difference of two levels; zero where both are infinite alike."""
    with np.errstate(invalid="ignore"):
        value = one.value - other.value
    value = np.where(np.isnan(value), 0.0, value)
    return Bounded(value, np.where(np.isfinite(value), one.error + other.error, 0.0))
