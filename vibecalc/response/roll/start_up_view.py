"""What a recorded start-up shows: quantities over time, envelopes, peaks and turns."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from vibecalc.excitation.gas_tables import TURN
from vibecalc.numerics.runge_kutta_march import Record, fine
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.roll.inertia import accelerations, inertia
from vibecalc.response.roll.start_up_states import ANGLE, SHELL_ANGLE, SHELL_SPEED, SPEED, WAY
from vibecalc.response.roll.start_up_system import StartUpSystem

#: rows of `Seen.value`, with their units in SI
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

#: parts of each step that are looked at
_PARTS = 6

#: turns over which the decay of the shaking is judged, against as many before
_WINDOW = 12


class Seen(NamedTuple):
    """Quantities (q, m) at times (m,) that ascend; at an event both sides of it are there."""

    time: FloatArray
    value: FloatArray


def seen(system: StartUpSystem, record: Record, member: int) -> Seen:
    """All of QUANTITIES at even parts of every step of a member."""
    time, sampled = fine(record, member, _PARTS)
    state, piece = sampled.state, record.piece[sampled.step]
    moved = inertia(system.machine, state[:, ANGLE])
    acting = system.torques(moved, state, piece)
    speed, shell = state[:, SPEED], state[:, SHELL_SPEED]
    driving = acting.motor + acting.gas + acting.viscous + acting.dry
    found = accelerations(moved, speed, shell, acting.mounts, driving)
    held = (piece[:, WAY] == 0) & system.dry
    together = acting.mounts / moved.shell
    shell_rate = np.where(held, together, found.shell)
    crank_rate = np.where(held, 0.0, found.crank)
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
    return Seen(time, np.stack(rows))


class Envelope(NamedTuple):
    """Least and largest values (q, k) of QUANTITIES between k + 1 even times (k + 1,)."""

    time: FloatArray
    low: FloatArray
    high: FloatArray


def envelope(shown: Seen, count: int) -> Envelope:
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
    """Largest magnitudes (q,) of QUANTITIES, their times in s, and what looking leaves open."""

    value: FloatArray
    time: FloatArray
    error: FloatArray
    time_error: FloatArray


def peaks(shown: Seen) -> Peak:
    """Peaks of a history by the parabola through the three highest looks of one step.

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
    # a summit of the parabola outside its three points: the value at the end of the step it is
    inner = (np.abs(place) < 1.0) & (bend < 0.0)
    top = np.where(inner, mid + 0.5 * tilt * place, size[rows, best])
    value = np.maximum(top, size[rows, best])
    apart = shown.time[centre + 1] - shown.time[centre]
    time = np.where(inner, shown.time[centre] + place * apart, shown.time[best])
    return Peak(value, time, value - size[rows, best], apart)


def steps_between(shown: Seen, begin: float, end: float) -> Seen:
    """The part of a history whose steps begin in [begin, end); the march ends a step on both."""
    start = shown.time[:: _PARTS + 1]
    low, high = np.searchsorted(start, [begin, end]) * (_PARTS + 1)
    return Seen(shown.time[low:high], shown.value[:, low:high])


class Turns(NamedTuple):
    """Each of n whole turns forward: its begin in s, mean speed, and size of the shell's shaking.

    `amplitude` is half the range of the shell's acceleration over the turn, rad/s^2.
    """

    begin: FloatArray
    period: FloatArray
    amplitude: FloatArray


def turns(system: StartUpSystem, shown: Seen, member: int) -> Turns:
    """Turns between neighbouring forward passages of crank angle zero."""
    passed = [
        (int(turn), float(time))
        for section in system.sections
        for who, turn, time in zip(section.member, section.turn, section.time, strict=True)
        if who == member
    ]
    acceleration = shown.value[QUANTITIES.index("shell_acceleration")]
    rows = []
    for (first, begin), (second, end) in pairwise(passed):
        if second == first + 1:
            low, high = np.searchsorted(shown.time, [begin, end])
            part = acceleration[low : max(high, low + 1)]
            rows.append((begin, end - begin, 0.5 * float(np.max(part) - np.min(part))))
    table = np.array(rows).reshape(-1, 3)
    return Turns(table[:, 0], table[:, 1], table[:, 2])


def settled_turn(found: Turns, share: float) -> int | None:
    """The first turn from which on the shaking keeps to `share` of where it is going, or None.

    From there every turn differs by less than that share from the next and from the last; and
    what the last turns still change, carried on as a geometric series, is less than it too.
    """
    amplitude = found.amplitude
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


def mean_speed(found: Turns) -> FloatArray:
    """Mean crank speed (n,) of each turn, rad/s."""
    return np.asarray(TURN / found.period)


def time_of_speed(shown: Seen, speed: float) -> float | None:
    """When the crank first runs at `speed`, by the cubic between two looks; or None."""
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
