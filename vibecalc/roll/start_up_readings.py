"""What a recorded start-up shows: quantities over time, peaks, and what has become of the start."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from vibecalc.excitation.gas_tables import TURN
from vibecalc.excitation.slip_torque import breakdown
from vibecalc.numerics.rounding import FloatArray
from vibecalc.numerics.runge_kutta_march import MarchEnd, Record, fine
from vibecalc.roll.mechanism import RollDrive, accelerations, inertia
from vibecalc.roll.start_up_system import (
    ANGLE,
    DIRECTION,
    SHELL_ANGLE,
    SHELL_SPEED,
    SPEED,
    LoadSteps,
    StartUpSystem,
)

# ----------------------------------------------------------------------------
# What a recorded start-up shows: quantities over time, envelopes, peaks and turns.
# ----------------------------------------------------------------------------

#: rows of `TimeHistory.value`, with their units in SI
QUANTITIES = (
    "crank_angle",
    "crank_speed",
    "shell_angle",
    "shell_speed",
    "shell_acceleration",
    "rotor_acceleration",
    "motor_torque",
    "gas_torque",
    "mount_torque",
    "slip",
)

#: parts of each step that are examined
_PARTS = 6

#: turns over which the decay of the shaking is judged, against as many before
_WINDOW = 12


class TimeHistory(NamedTuple):
    """Quantities (q, m) at times (m,) that ascend; at an event both sides of it are there."""

    time: FloatArray
    value: FloatArray


def time_history(system: StartUpSystem, record: Record, member: int) -> TimeHistory:
    """All of QUANTITIES at even parts of every step of a member."""
    time, sampled = fine(record, member, _PARTS)
    state, interval = sampled.state, record.interval[sampled.step]
    moved = inertia(system.machine, state[:, ANGLE])
    acting = system.torques(moved, state, interval)
    speed, shell = state[:, SPEED], state[:, SHELL_SPEED]
    driving = acting.motor + acting.gas + acting.viscous + acting.dry
    accelerated = accelerations(moved, speed, shell, acting.mounts, driving)
    held = (interval[:, DIRECTION] == 0) & system.dry
    together = acting.mounts / moved.shell
    shell_rate = np.where(held, together, accelerated.shell)
    crank_rate = np.where(held, 0.0, accelerated.crank)
    rows = (
        state[:, ANGLE],
        speed,
        state[:, SHELL_ANGLE],
        shell,
        shell_rate,
        shell_rate + crank_rate,
        acting.motor,
        acting.gas,
        acting.mounts,
        system.synchronous - speed,
    )
    return TimeHistory(time, np.stack(rows))


class Envelope(NamedTuple):
    """Least and largest values (q, k) of QUANTITIES between k + 1 even times (k + 1,)."""

    time: FloatArray
    low: FloatArray
    high: FloatArray


def envelope(shown: TimeHistory, count: int) -> Envelope:
    """Buckets of a history; an empty one takes the value at its middle."""
    time = np.linspace(shown.time[0], shown.time[-1], count + 1)
    start = np.searchsorted(shown.time, time[:-1], side="left")
    middle = 0.5 * (time[1:] + time[:-1])
    low = np.stack([np.interp(middle, shown.time, row) for row in shown.value])
    high = low.copy()
    filled = np.diff(np.append(start, len(shown.time))) > 0
    where = start[filled]
    low[:, filled] = np.minimum(low[:, filled], np.minimum.reduceat(shown.value, where, axis=1))
    high[:, filled] = np.maximum(high[:, filled], np.maximum.reduceat(shown.value, where, axis=1))
    return Envelope(time, low, high)


class Peak(NamedTuple):
    """Largest magnitudes (q,) of QUANTITIES, their times in s, and what sampling leaves open."""

    value: FloatArray
    time: FloatArray
    error: FloatArray
    time_error: FloatArray


def peaks(shown: TimeHistory) -> Peak:
    """Peaks of a history by the parabola through the three highest samples of one step.

    The history has to begin and end with whole steps.
    """
    size = np.abs(shown.value)
    rows = np.arange(len(size))
    best = np.argmax(size, axis=1)
    within = best % (_PARTS + 1)
    centre = best + np.where(within == 0, 1, np.where(within == _PARTS, -1, 0))
    left, mid, right = (size[rows, centre + k] for k in (-1, 0, 1))
    bend, tilt = left - 2.0 * mid + right, 0.5 * (right - left)
    with np.errstate(divide="ignore", invalid="ignore"):
        place = np.where(bend < 0.0, -tilt / bend, 0.0)
    # a peak of the parabola outside its three points: the value at the end of the step it is
    inner = (np.abs(place) < 1.0) & (bend < 0.0)
    top = np.where(inner, mid + 0.5 * tilt * place, size[rows, best])
    value = np.maximum(top, size[rows, best])
    apart = shown.time[centre + 1] - shown.time[centre]
    time = np.where(inner, shown.time[centre] + place * apart, shown.time[best])
    return Peak(value, time, value - size[rows, best], apart)


def steps_between(shown: TimeHistory, begin: float, end: float) -> TimeHistory:
    """The part of a history whose steps begin in [begin, end); the march ends a step on both."""
    start = shown.time[:: _PARTS + 1]
    low, high = np.searchsorted(start, [begin, end]) * (_PARTS + 1)
    return TimeHistory(shown.time[low:high], shown.value[:, low:high])


class Turns(NamedTuple):
    """Each of n whole turns forward: its begin in s, mean speed, and size of the shell's shaking.

    `amplitude` is half the range of the shell's acceleration over the turn, rad/s^2.
    """

    begin: FloatArray
    period: FloatArray
    amplitude: FloatArray


def turns(system: StartUpSystem, shown: TimeHistory, member: int) -> Turns:
    """Turns between neighbouring forward passages of crank angle zero."""
    passed = [(turn, time) for who, turn, time in system.sections if who == member]
    acceleration = shown.value[QUANTITIES.index("shell_acceleration")]
    rows = []
    for (first, begin), (second, end) in pairwise(passed):
        if second == first + 1:
            low, high = np.searchsorted(shown.time, [begin, end])
            part = acceleration[low : max(high, low + 1)]
            rows.append((begin, end - begin, 0.5 * float(np.max(part) - np.min(part))))
    table = np.array(rows).reshape(-1, 3)
    return Turns(table[:, 0], table[:, 1], table[:, 2])


def settled_turn(each_turn: Turns, share: float) -> int | None:
    """The first turn from which on the shaking keeps to `share` of where it is going, or None.

    From there every turn differs by less than that share from the next and from the last; and
    what the last turns still change, carried on as a geometric series, is less than it too.
    """
    amplitude = each_turn.amplitude
    if len(amplitude) < 6:
        return None
    last, change = amplitude[-1], np.abs(np.diff(amplitude))
    near = np.append(change, 0.0) < share * last
    near &= np.abs(amplitude - last) < share * last
    # by ranges, since changes that alternate in sign do not add up; over many turns, since a shell
    # that swings on its mounts beats with the turns
    window = min(_WINDOW, len(change) // 2)
    recent = float(np.ptp(amplitude[-window - 1 :]))
    before = float(np.ptp(amplitude[-2 * window - 1 : -window]))
    if recent > 1e-3 * share * last:
        ratio = min(recent / before, 0.999**window) if before > 0.0 else 0.999**window
        if recent * ratio / (1.0 - ratio) > share * last:
            return None
    first = len(near) - int(np.argmin(near[::-1])) if not np.all(near) else 0
    return first if first < len(near) - 2 else None


def mean_speed(each_turn: Turns) -> FloatArray:
    """Mean crank speed (n,) of each turn, rad/s."""
    return np.asarray(TURN / each_turn.period)


def time_of_speed(shown: TimeHistory, speed: float) -> float | None:
    """When the crank first runs at `speed`, by the cubic between two samples; or None."""
    row = shown.value[QUANTITIES.index("crank_speed")]
    above = np.nonzero(row >= speed)[0]
    if not len(above):
        return None
    place = int(above[0])
    if place == 0:
        return float(shown.time[0])
    turning = QUANTITIES.index("rotor_acceleration"), QUANTITIES.index("shell_acceleration")
    rates = shown.value[turning[0]] - shown.value[turning[1]]
    begin, length = shown.time[place - 1], shown.time[place] - shown.time[place - 1]
    y, z = row[place - 1], row[place]
    u, v = length * rates[place - 1], length * rates[place]
    low, high = 0.0, 1.0
    for _ in range(60):
        s = 0.5 * (low + high)
        there = y + s * (u + s * (3.0 * (z - y) - 2.0 * u - v + s * (u + v - 2.0 * (z - y))))
        low, high = (s, high) if there < speed else (low, s)
    return float(begin + high * length)


# ----------------------------------------------------------------------------
# What rounding leaves of a machine that stands still: zero in its peaks.
# ----------------------------------------------------------------------------

#: share of what a machine reaches in size that rounding may leave in one that stands still
_STILL = 1e-12


def rounding_of(system: StartUpSystem) -> FloatArray:
    """What rounding may leave in each of QUANTITIES of a machine that stands still (q,)."""
    turn, fast, angle, rate = (float(size) for size in system.scale[:4])
    torque, shell = system.torque_scale, float(np.min(system.machine.shell_inertia))
    size = {
        "crank_angle": turn,
        "shell_angle": angle,
        "shell_speed": rate,
        "shell_acceleration": torque / shell,
        "rotor_acceleration": fast * fast,
    }
    speeds = dict.fromkeys(("crank_speed", "slip"), fast)
    return _STILL * np.array([(size | speeds).get(name, torque) for name in QUANTITIES])


def without_rounding(peak: Peak, floor: FloatArray) -> Peak:
    """Peaks (..., q) with zero, at time zero, for what is no more than rounding."""
    there = peak.value > floor
    return peak._replace(
        value=np.where(there, peak.value, 0.0),
        time=np.where(there, peak.time, 0.0),
        error=np.where(there, peak.error, np.maximum(peak.error, floor)),
    )


# ----------------------------------------------------------------------------
# What happens between one change of load and the next.
# ----------------------------------------------------------------------------


class Stretches(NamedTuple):
    """The k stretches of constant load that a start-up has come to.

    `begin` (k,) in s and `factor` (k,) are rows of the load's table. `speed` (k,) is the mean of
    the last whole turn within each, rad/s, 0 without one; `peaks` has the fields of `Peak`, (k, q).
    """

    begin: FloatArray
    factor: FloatArray
    speed: FloatArray
    peaks: Peak


def stretches(shown: TimeHistory, each_turn: Turns, load: LoadSteps) -> Stretches:
    """Peaks and speeds of a history between the changes of its load."""
    last = float(shown.time[-1])
    count = int(np.sum(load.time < last))
    ends = np.append(load.time[1:count], np.inf)
    done, mean = each_turn.begin + each_turn.period, mean_speed(each_turn)
    speeds, tops = [], []
    for begin, end in zip(load.time[:count], ends, strict=True):
        within = np.nonzero((each_turn.begin >= begin) & (done <= end))[0]
        speeds.append(float(mean[within[-1]]) if len(within) else 0.0)
        tops.append(peaks(steps_between(shown, float(begin), float(end))))
    rows = Peak(*(np.stack(column) for column in zip(*tops, strict=True))) if tops else _none()
    return Stretches(load.time[:count], load.factor[:count], np.array(speeds), rows)


def _none() -> Peak:
    return Peak(*(np.zeros((0, len(QUANTITIES))) for _ in Peak._fields))


# ----------------------------------------------------------------------------
# What has become of a start: does it run, crawl, rock or stand?
# ----------------------------------------------------------------------------

_MOTOR, _GAS = QUANTITIES.index("motor_torque"), QUANTITIES.index("gas_torque")
#: share of the torques of a running machine, and rad, that are nothing but rounding
_SMALL, _STANDS = 1e-12, 1e-9


def running_branch(drive: RollDrive) -> float:
    """Crank speed above which the motor runs short of its breakdown torque, rad/s.

    For a motor without breakdown torque, half the synchronous speed.
    """
    synchronous = float(drive.synchronous_speed)
    slip, _ = breakdown(drive.motor)
    return synchronous - slip if np.isfinite(slip) else 0.5 * synchronous


def _rounded(torque: float, system: StartUpSystem) -> float:
    """A torque without what is only rounding."""
    return torque if abs(torque) > _SMALL * system.torque_scale else 0.0


def _lacking(system: StartUpSystem, shown: TimeHistory) -> str:
    """What the motor lacks in torque at a start from rest; empty where it moves the crank."""
    motor, gas = (_rounded(float(shown.value[row, 0]), system) for row in (_MOTOR, _GAS))
    if shown.value[1, 0] != 0.0:
        return ""
    if motor <= 0.0:
        return "; the motor gives no torque at standstill" if motor == 0.0 else (
            f"; at standstill the motor turns backward, with {-motor:.4g} N*m"
        )  # fmt: skip
    if motor + gas <= 0.0:
        return (
            f"; the motor's {motor:.4g} N*m at standstill are no more than the {-gas:.4g} N*m with "
            "which the gas pushes back at the start angle"
        )
    return ""


def verdict_of(
    system: StartUpSystem, ended: MarchEnd, shown: TimeHistory, each_turn: Turns, settles: bool
) -> tuple[str, str]:
    """The verdict of `StartUp` and its reason; `settles` is whether the shaking has settled."""
    angle, speed = shown.value[0], shown.value[1]
    here, time = float(angle[-1]), float(shown.time[-1])
    degrees = round(float(np.degrees(np.mod(here, 2.0 * np.pi))), 9)
    if system.dry and ended.interval[0, DIRECTION] == 0:
        motor, gas = (float(shown.value[row, -1]) for row in (_MOTOR, _GAS))
        return "stalled", (
            f"held by friction at crank angle {degrees:.4g} degrees, where the motor gives "
            f"{_rounded(motor, system):.4g} N*m at standstill and the gas "
            f"{_rounded(gas, system):.4g} N*m"
        )
    recent = shown.time >= 0.5 * time
    low, high = float(np.min(angle[recent])), float(np.max(angle[recent]))
    if not len(each_turn.period) or each_turn.begin[-1] + 2.5 * each_turn.period[-1] < time:
        if high - low <= _STANDS:
            words = f"it stands still at crank angle {degrees:.4g} degrees"
            return "stalled", words + _lacking(system, shown)
        if np.min(speed[recent]) < 0.0:
            return "rocking", (
                f"the motor does not turn it over the compression: it rocks between crank angles "
                f"of {np.degrees(low):.4g} and {np.degrees(high):.4g} degrees"
                + _lacking(system, shown)
            )
        return "stalled", (
            f"no turn is completed; it has come to {degrees:.4g} degrees{_lacking(system, shown)}"
        )
    mean, branch = float(mean_speed(each_turn)[-1]), running_branch(system.drive)
    if mean < branch:
        return "crawling", (
            f"it turns at {mean:.4g} rad/s and does not pass the breakdown torque at "
            f"{branch:.4g} rad/s"
        )
    words = f"it runs at {mean:.6g} rad/s"
    return ("settled", words) if settles else ("running", words + ", not yet settled")
