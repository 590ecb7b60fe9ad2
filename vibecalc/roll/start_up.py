"""A start-up or a change of load in the time domain, and the crank angles a start succeeds from."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.gas_tables import TURN
from vibecalc.numerics.rounding import EPSILON, BoolArray, FloatArray
from vibecalc.numerics.runge_kutta_march import march
from vibecalc.roll.mechanism import RollDrive, RollMachine, inertia
from vibecalc.roll.start_up_readings import (
    Envelope,
    Peak,
    Stretches,
    Turns,
    envelope,
    mean_speed,
    peaks,
    rounding_of,
    running_branch,
    settled_turn,
    stretches,
    time_history,
    time_of_speed,
    turns,
    verdict_of,
    without_rounding,
)
from vibecalc.roll.start_up_system import (
    ANGLE,
    FRICTION_WORK,
    FULL_LOAD,
    GAS_WORK,
    MOTOR_WORK,
    MOUNT_WORK,
    MOVING,
    SHELL_ANGLE,
    SHELL_SPEED,
    SPEED,
    STATES,
    LoadSteps,
    StartUpSystem,
)

# ----------------------------------------------------------------------------
# A start-up or a change of load in the time domain: from rest through breakdown to running.
#
# The march is run twice, the second time to an eighth of the tolerance and with at least two steps
# between neighbouring kinks; the second is given, and half of the difference is its error.
# ----------------------------------------------------------------------------

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
    settled; None where that is not reached. `stretches` are those between changes of the load.
    `error` has the absolute errors of the numbers by name; `history_error` (q,) those of the
    envelope, `stretch_speed_error` (k,) and `turn_error` those of the speeds and of the turns.
    """

    verdict: str
    reason: str
    speed: float | None
    time_to_speed: float | None
    time_to_steady: float | None
    turns: Turns
    peaks: Peak
    history: Envelope
    energies: Energies
    final: FloatArray
    stretches: Stretches
    error: dict[str, float]
    history_error: FloatArray
    final_error: FloatArray
    stretch_speed_error: FloatArray
    turn_error: Turns


def start_up(
    machine: RollMachine,
    drive: RollDrive,
    *,
    duration: float,
    crank_angle: float = 0.0,
    speed: float = 0.0,
    load: LoadSteps = FULL_LOAD,
    running_speed: float | None = None,
    settled: float = 0.01,
    tolerance: float = 1e-7,
    buckets: int = 600,
) -> StartUp:
    """Follow one machine for `duration` s from the given angle and speed, the shell at rest.

    `load` is a factor on the gas forces that is constant between its times. `running_speed` is the
    mean speed that counts as reached (rad/s); without it, that of the last turn. `settled` is the
    share by which the shaking of the shell may still differ. `tolerance` is that of one step, over
    a radian and the synchronous speed. The history has `buckets` envelopes.

    Raises NumericalFailure where the slip leaves a table that is not continued, and where the
    verdict differs between both marches, so that rounding would decide it.
    """
    first = np.zeros((1, STATES))
    first[0, [ANGLE, SPEED]] = crank_angle, speed

    def follow(tolerance: float, parts: int) -> StartUp:
        system = StartUpSystem(machine, drive, load, tolerance)
        ended = march(
            system, np.zeros(1), first, system.first_intervals(first, 0.0), np.array([duration]),
            absolute=tolerance * system.scale, stops=load.time[None, :], parts=parts,
        )  # fmt: skip
        assert ended.record is not None
        shown, final = time_history(system, ended.record, 0), ended.state[0]
        each_turn = turns(system, shown, 0)
        place, mean = settled_turn(each_turn, settled), mean_speed(each_turn)
        last = float(mean[-1]) if len(mean) else None
        verdict, reason = verdict_of(system, ended, shown, each_turn, place is not None)
        goal = last if running_speed is None else running_speed
        ran = verdict in ("settled", "running")
        return StartUp(
            verdict, reason, last, time_of_speed(shown, goal) if ran and goal else None,
            None if place is None else float(each_turn.begin[place]), each_turn, peaks(shown),
            envelope(shown, buckets), _energies(machine, first[0], final), final,
            stretches(shown, each_turn, load), {}, final, final, final, each_turn,
        )  # fmt: skip

    coarse, finest = follow(tolerance, 1), follow(tolerance * _FINER, 2)
    if coarse.verdict != finest.verdict:
        raise NumericalFailure(
            f"whether the machine starts cannot be decided: one march ends {coarse.verdict}, "
            f"one of an eighth of its tolerance {finest.verdict}"
        )
    scale = np.max(np.abs(finest.history.high - finest.history.low), axis=1)
    apart = [np.abs(one - two) for one, two in zip(finest.history, coarse.history, strict=True)]
    floor = rounding_of(StartUpSystem(machine, drive, load, tolerance))
    peak, steps = (
        without_rounding(_with_errors(fine, rough, tolerance), floor)
        for fine, rough in (
            (finest.peaks, coarse.peaks), (finest.stretches.peaks, coarse.stretches.peaks)
        )
    )  # fmt: skip
    return finest._replace(
        peaks=peak,
        stretches=finest.stretches._replace(peaks=steps),
        error=_errors(finest, coarse, duration),
        history_error=np.max(np.maximum(*apart[1:]), axis=1) / _GAIN + 64.0 * EPSILON * scale,
        final_error=np.abs(finest.final - coarse.final) / _GAIN
        + 64.0 * EPSILON * np.abs(finest.final),
        stretch_speed_error=_apart(finest.stretches.speed, coarse.stretches.speed),
        turn_error=Turns(*map(_apart, finest.turns, coarse.turns)),
    )


def _errors(finest: StartUp, coarse: StartUp, duration: float) -> dict[str, float]:
    """Errors of speed, times and works by name."""
    names = ("speed", "time_to_speed", "time_to_steady")
    new, old = (
        {name: getattr(one, name) for name in names} | one.energies._asdict()
        for one in (finest, coarse)
    )
    rounding, works = 1e3 * EPSILON, finest.energies
    error = {
        name: abs(value - old[name]) / _GAIN
        + rounding * max(abs(value), duration if "time" in name else 0.0)
        for name, value in new.items()
        if value is not None and old[name] is not None
    }
    size = abs(works.motor) + abs(works.gas) + abs(works.gain)
    return error | {"residual": abs(works.residual) + rounding * size}


def _with_errors(fine: Peak, coarse: Peak, tolerance: float) -> Peak:
    """The peaks with errors that count the difference of both marches too."""
    interpolated = np.abs(fine.value - coarse.value) / _GAIN + fine.error + coarse.error
    # at a corner of a curve a step may end a little beyond it
    return fine._replace(
        error=interpolated + (0.02 * tolerance + 64.0 * EPSILON) * fine.value,
        time_error=np.abs(fine.time - coarse.time) + fine.time_error,
    )


def _apart(fine: FloatArray, coarse: FloatArray) -> FloatArray:
    """Differences of both marches; one of them may have seen one more turn at its end."""
    common = min(len(fine), len(coarse))
    off = np.abs(fine[:common] - coarse[:common]) + 64.0 * EPSILON * np.abs(fine[:common])
    return np.append(off, np.full(len(fine) - common, np.max(off, initial=0.0)))


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


# ----------------------------------------------------------------------------
# From which crank angles a machine at rest starts at all: intervals with refined boundaries.
# ----------------------------------------------------------------------------

#: parts into which every bracket is cut: two would not show that a bracket has several borders
_PARTS = 3

#: brackets beyond which the set counts as without structure
_MOST = 100


class StartAngles(NamedTuple):
    """Where the machine starts.

    `angle`, `starts` (k,): the angles examined first, rad, and what came of them. `interval`
    (n, 2): where it starts, from and to, in rad, the second one up to a turn beyond 2 pi; `error`
    is that of each end. `fraction` is the share of the turn from which it starts, with
    `fraction_error`. Intervals or gaps narrower than the step of `angle` may be missed; `islands`
    says that the search for the ends has met such, so that there are probably more.
    """

    angle: FloatArray
    starts: BoolArray
    interval: FloatArray
    error: float
    fraction: float
    fraction_error: float
    islands: bool


def start_angles(
    machine: RollMachine,
    drive: RollDrive,
    *,
    duration: float,
    angles: int = 72,
    load: LoadSteps = FULL_LOAD,
    started_speed: float | None = None,
    width: float = 1e-6,
    tolerance: float = 1e-7,
) -> StartAngles:
    """Start one machine from rest at `angles` even crank angles, and find the borders between.

    It counts as started once its mean speed over a turn reaches `started_speed` (rad/s; the speed
    of the breakdown torque, if not given) within `duration` s. Each border is enclosed to within
    `width` rad.

    Raises NumericalFailure where the slip leaves a table that is not continued (any machine that
    rocks turns backward: a table to locked rotor needs to be continued), and where the borders
    multiply as they are refined.
    """
    goal = running_branch(drive) if started_speed is None else started_speed

    def outcome(angle: FloatArray) -> BoolArray:
        return starts_from(machine, drive, angle, duration, load, goal, tolerance)

    first = TURN * np.arange(angles) / angles
    starts = outcome(first)
    low, high, risen, islands = first, np.append(first[1:], TURN), starts, False
    falls = starts != np.roll(starts, -1)
    low, high, risen = low[falls], high[falls], ~starts[falls]
    while len(low) and float(np.max(high - low)) > width:
        inner = low[:, None] + (high - low)[:, None] * np.arange(1, _PARTS) / _PARTS
        reached = outcome(np.mod(inner.ravel(), TURN)).reshape(inner.shape)
        edges = np.concatenate([low[:, None], inner, high[:, None]], axis=1)
        values = np.concatenate([~risen[:, None], reached, risen[:, None]], axis=1)
        row, place = np.nonzero(values[:, :-1] != values[:, 1:])
        islands = islands or len(row) > len(low)
        if len(row) > _MOST:
            raise NumericalFailure(
                f"the angles from which the machine starts have no clear borders: {len(row)} were "
                f"found and more come up; friction or a longer run makes them clear"
            )
        low, high, risen = edges[row, place], edges[row, place + 1], values[row, place + 1]
    middle = 0.5 * (low + high)
    error = 0.5 * float(np.max(high - low)) if len(low) else 0.0
    interval = _intervals(middle, risen, bool(starts[0]))
    # the sum of the lengths, each with the errors of two ends
    fraction = float(np.sum(interval[:, 1] - interval[:, 0])) / TURN
    return StartAngles(
        first, starts, interval, error, fraction, len(middle) * error / TURN, islands
    )


def starts_from(
    machine: RollMachine,
    drive: RollDrive,
    angle: FloatArray,
    duration: float,
    load: LoadSteps,
    goal: float,
    tolerance: float = 1e-7,
) -> BoolArray:
    """Whether the machine, from rest at the crank angles (b,), runs a turn at a mean of `goal`."""
    system = StartUpSystem(machine, drive, load, tolerance, until_speed=goal)
    count = len(angle)
    state = np.zeros((count, MOVING))
    state[:, ANGLE] = angle
    march(
        system,
        np.zeros(count),
        state,
        system.first_intervals(state, 0.0),
        np.full(count, duration),
        absolute=tolerance * system.scale[:MOVING],
        stops=np.broadcast_to(load.time, (count, len(load.time))),
        keep=False,
    )
    return system.started(count)


def _intervals(border: FloatArray, risen: BoolArray, all_or_none: bool) -> FloatArray:
    """Intervals (n, 2) between borders where the machine begins (`risen`) and ceases to start."""
    if not len(border):
        return np.array([[0.0, TURN]]) if all_or_none else np.zeros((0, 2))
    begins, ends = border[risen], border[~risen]
    place = np.searchsorted(ends, begins)
    closed = np.append(ends, ends[:1] + TURN)
    return np.stack([begins, closed[place]], axis=1)
