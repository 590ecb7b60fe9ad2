"""A start-up or a change of load in the time domain: from rest through breakdown to running.

The march is run twice, the second time to an eighth of the tolerance and with at least two steps
between neighbouring kinks; the second is given, and half of the difference is its error.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.runge_kutta_march import march
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.roll.inertia import inertia
from vibecalc.response.roll.machine import RollDrive, RollMachine
from vibecalc.response.roll.start_up_states import (
    ANGLE,
    FRICTION_WORK,
    FULL_LOAD,
    GAS_WORK,
    MOTOR_WORK,
    MOUNT_WORK,
    SHELL_ANGLE,
    SHELL_SPEED,
    SPEED,
    STATES,
    Load,
)
from vibecalc.response.roll.start_up_still import rounding_of, without_rounding
from vibecalc.response.roll.start_up_stretches import Stretches, stretches
from vibecalc.response.roll.start_up_system import StartUpSystem
from vibecalc.response.roll.start_up_verdict import verdict_of
from vibecalc.response.roll.start_up_view import (
    Envelope,
    Peak,
    Seen,
    Turns,
    envelope,
    mean_speed,
    peaks,
    seen,
    settled_turn,
    time_of_speed,
    turns,
)

#: the second march to this share of the tolerance
_FINER = 0.125

#: the difference of both marches over this is granted as the error of the finer one
_GAIN = 2.0


class Energies(NamedTuple):
    """Work in J over the whole time; positive what goes into the machine.

    `gain` is by how much the kinetic energy and that of the mounts have grown; `residual` is the
    sum of the works less the gain, zero but for rounding and truncation.
    """

    motor: float
    gas: float
    friction: float
    mounts: float
    gain: float
    residual: float


class StartUp(NamedTuple):
    """A start-up; times in s from its begin.

    `verdict` is "settled", "running" (on the running side of the motor's breakdown, not settled),
    "crawling", "rocking" or "stalled", and `reason` says it in words. `speed` is the mean of the
    last turn (None without a whole turn). `time_to_speed` is when the crank first runs at the
    running speed, `time_to_steady` the begin of the first turn from which on the shaking stays
    settled; None where that is not reached. `error` has the absolute errors of the numbers by name
    and of the peaks by quantity; `history_error` (q,) those of the envelope. `stretches` are those
    between changes of the load, `stretch_speed_error` (k,) and `turn_error` the errors of their
    speeds and of the turns.
    """

    verdict: str
    reason: str
    speed: float | None
    time_to_speed: float | None
    time_to_steady: float | None
    turns: Turns
    peaks: Peak
    history: Envelope
    history_error: FloatArray
    energies: Energies
    final: FloatArray
    final_error: FloatArray
    error: dict[str, float]
    stretches: Stretches
    stretch_speed_error: FloatArray
    turn_error: Turns


class _Once(NamedTuple):
    shown: Seen
    turns: Turns
    peaks: Peak
    stretches: Stretches
    history: Envelope
    verdict: tuple[str, str]
    speed: float | None
    to_speed: float | None
    to_steady: float | None
    energies: Energies
    final: FloatArray


def start_up(
    machine: RollMachine,
    drive: RollDrive,
    *,
    duration: float,
    crank_angle: float = 0.0,
    speed: float = 0.0,
    shell_angle: float = 0.0,
    shell_speed: float = 0.0,
    load: Load = FULL_LOAD,
    running_speed: float | None = None,
    settled: float = 0.01,
    tolerance: float = 1e-7,
    buckets: int = 600,
) -> StartUp:
    """Follow one machine for `duration` s from the given angles and speeds.

    `load` is a factor on the gas forces that is constant between its times. `running_speed` is the
    mean speed that counts as reached (rad/s); without it, that of the last turn. `settled` is the
    share by which the shaking of the shell may still differ. `tolerance` is that of one step, over
    a radian and the synchronous speed. The history has `buckets` envelopes.

    Raises NumericalFailure where the slip leaves a table that is not continued, and where the
    verdict differs between both marches, so that rounding would decide it.
    """
    first = np.zeros(STATES)
    first[[ANGLE, SPEED, SHELL_ANGLE, SHELL_SPEED]] = crank_angle, speed, shell_angle, shell_speed
    settings = (machine, drive, first, duration, load, running_speed, settled, buckets)
    coarse = _follow(*settings, tolerance, 1)
    finest = _follow(*settings, tolerance * _FINER, 2)
    if coarse.verdict[0] != finest.verdict[0]:
        raise NumericalFailure(
            f"whether the machine starts is on a knife's edge: one march ends {coarse.verdict[0]}, "
            f"one of an eighth of its tolerance {finest.verdict[0]}"
        )
    off = np.abs(finest.final - coarse.final) / _GAIN
    scale = np.max(np.abs(finest.history.high - finest.history.low), axis=1)
    apart = np.maximum(
        np.abs(finest.history.high - coarse.history.high),
        np.abs(finest.history.low - coarse.history.low),
    )
    history_error = np.max(apart, axis=1) / _GAIN + 64.0 * EPSILON * scale
    floor = rounding_of(StartUpSystem(machine, drive, load, tolerance))
    peak = without_rounding(_with_errors(finest.peaks, coarse.peaks, tolerance), floor)
    stretch = finest.stretches
    apart_peaks = _with_errors(stretch.peaks, coarse.stretches.peaks, tolerance)
    stretch = stretch._replace(peaks=without_rounding(apart_peaks, floor))
    pairs = {
        "speed": (finest.speed, coarse.speed),
        "time_to_speed": (finest.to_speed, coarse.to_speed),
        "time_to_steady": (finest.to_steady, coarse.to_steady),
        **{
            name: (getattr(finest.energies, name), getattr(coarse.energies, name))
            for name in Energies._fields
        },
    }
    rounding = 1e3 * EPSILON
    error = {
        name: abs(new - old) / _GAIN + rounding * max(abs(new), duration if "time" in name else 0.0)
        for name, (new, old) in pairs.items()
        if new is not None and old is not None
    }
    works = abs(finest.energies.motor) + abs(finest.energies.gas) + abs(finest.energies.gain)
    error["residual"] = abs(finest.energies.residual) + rounding * works
    return StartUp(
        *finest.verdict,
        finest.speed,
        finest.to_speed,
        finest.to_steady,
        finest.turns,
        peak,
        finest.history,
        history_error,
        finest.energies,
        finest.final,
        off + 64.0 * EPSILON * np.abs(finest.final),
        error,
        stretch,
        _apart(finest.stretches.speed, coarse.stretches.speed),
        Turns(*(_apart(*both) for both in zip(finest.turns, coarse.turns, strict=True))),
    )


def _with_errors(fine: Peak, coarse: Peak, tolerance: float) -> Peak:
    """The peaks with errors that count the difference of both marches too."""
    looked = np.abs(fine.value - coarse.value) / _GAIN + fine.error + coarse.error
    # at a corner of a curve a step may end a little beyond it
    return fine._replace(
        error=looked + (0.02 * tolerance + 64.0 * EPSILON) * fine.value,
        time_error=np.abs(fine.time - coarse.time) + fine.time_error,
    )


def _apart(fine: FloatArray, coarse: FloatArray) -> FloatArray:
    """Differences of both marches; one of them may have seen one more turn at its end."""
    common = min(len(fine), len(coarse))
    off = np.abs(fine[:common] - coarse[:common]) + 64.0 * EPSILON * np.abs(fine[:common])
    return np.append(off, np.full(len(fine) - common, np.max(off, initial=0.0)))


def _follow(
    machine: RollMachine,
    drive: RollDrive,
    first: FloatArray,
    duration: float,
    load: Load,
    running_speed: float | None,
    settled: float,
    buckets: int,
    tolerance: float,
    parts: int,
) -> _Once:
    system = StartUpSystem(machine, drive, load, tolerance)
    state = first[None, :]
    ended = march(
        system,
        np.zeros(1),
        state,
        system.first_piece(state, 0.0),
        np.array([duration]),
        absolute=tolerance * system.scale,
        stops=load.time[None, :],
        parts=parts,
    )
    assert ended.record is not None
    shown = seen(system, ended.record, 0)
    found = turns(system, shown, 0)
    place = settled_turn(found, settled)
    mean = mean_speed(found)
    last = float(mean[-1]) if len(mean) else None
    verdict = verdict_of(system, ended, shown, found, place is not None)
    ran = verdict[0] in ("settled", "running")
    goal = running_speed if running_speed is not None else last
    return _Once(
        shown,
        found,
        peaks(shown),
        stretches(shown, found, load),
        envelope(shown, buckets),
        verdict,
        last,
        time_of_speed(shown, goal) if ran and goal is not None else None,
        float(found.begin[place]) if place is not None else None,
        _energies(machine, first, ended.state[0]),
        ended.state[0],
    )


def _energies(machine: RollMachine, first: FloatArray, last: FloatArray) -> Energies:
    def stored(state: FloatArray) -> float:
        moved = inertia(machine, state[[ANGLE]])
        w, s = state[SPEED], state[SHELL_SPEED]
        kinetic = moved.shell[0] * s * s + 2.0 * moved.coupling[0] * s * w + moved.crank[0] * w * w
        return float(0.5 * kinetic + 0.5 * machine.shell_stiffness * state[SHELL_ANGLE] ** 2)

    gain = stored(last) - stored(first)
    motor, gas, friction, mounts = (
        float(last[k]) for k in (MOTOR_WORK, GAS_WORK, FRICTION_WORK, MOUNT_WORK)
    )
    return Energies(motor, gas, friction, mounts, gain, motor + gas + friction + mounts - gain)
