"""A clutch that takes one part of a shaft line along until both turn together."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import BoolArray, FloatArray
from vibecalc.torsion.line import Line
from vibecalc.torsion.transient.march import (
    StepBlock,
    TransientRun,
    TransientSystem,
    driven,
    propagator,
    steady_start,
    transient,
    transient_system,
)
from vibecalc.torsion.transient.motion import Stretch, TorqueInTime, course_of
from vibecalc.torsion.transient.trace import inside

# ----------------------------------------------------------------------------
# The line with its clutch slipping or holding, each a linear system of the same states.
#
# The clutch is an elastic element in line with a pair of plates without mass. While these slip, the
# element carries the friction torque T(t), against the slip; its own twist theta follows
# k theta + c theta' = T, and the plates slip at (velocity of the first end less that of the second)
# less theta'. They hold once that is zero, and the element twists with its ends; where its torque
# would exceed T they slip again. The torque goes over without a jump each time.
#
# Two states come on top of those of the line: the friction torque that there is and one that is
# constant, which lets it grow along a straight line; both in units of sqrt(k), as energies are.
# ----------------------------------------------------------------------------


class Clutch(NamedTuple):
    """`element` is a place among those of the line; `friction_torque` in N m, full.

    It takes `engaging_time` s to grow from zero along a straight line. `driven` (n,) marks the
    freedoms that it takes along; `driven_speed` in rad/s is theirs before. All referred.
    """

    element: int
    friction_torque: float
    engaging_time: float
    driven: BoolArray
    driven_speed: float


#: the plates do not touch
OPEN = 2


def clutch_system(line: Line, clutch: Clutch, slip: int, growth: float) -> TransientSystem:
    """The line with its clutch slipping, `slip` = 1 or -1 (first end faster or slower), 0 or OPEN.

    With 0 the plates hold. `growth` in N m/s is that of the friction torque. Mean torques are not
    balanced. Raises NumericalFailure as `transient_system` does.
    """
    line_system = transient_system(line)
    size, n = line_system.state_matrix.shape[0], line.inertia.size
    torque, constant, own = size, size + 1, clutch.element
    stiffness, damping = float(line.stiffness[own]), float(line.damping[own])
    matrix = np.zeros((size + 2, size + 2))
    matrix[:size, :size] = line_system.state_matrix
    matrix[torque, constant] = growth / clutch.friction_torque
    inputs = np.concatenate([line_system.input_matrix, np.zeros((2, n))])
    read = np.pad(line_system.torque, ((0, 0), (0, 2)))
    if slip:
        sign = 0.0 if slip == OPEN else float(slip)
        friction = np.zeros(size + 2)
        friction[torque] = sign * np.sqrt(stiffness)
        # what the element did to its two ends, replaced
        ends = np.zeros(size + 2)
        first, second = line.first[own], line.second[own]
        ends[size - n + first] = -1.0 / np.sqrt(line.inertia[first])
        ends[size - n + second] = 1.0 / np.sqrt(line.inertia[second])
        matrix += np.outer(ends, friction - read[own])
        read[own] = friction
        matrix[own] = 0.0
        if damping > 0.0:
            matrix[own, own] = -stiffness / damping
            matrix[own, torque] = sign * stiffness / damping
        elif sign:
            matrix[own, constant] = sign * growth / clutch.friction_torque
    return replace(
        line_system,
        state_matrix=matrix,
        input_matrix=inputs,
        torque=read,
        balance=np.eye(n),
        idle=np.append(line_system.idle, [True, True]),
        tools={},
    )


def slip_view(system: TransientSystem, line: Line, clutch: Clutch) -> FloatArray:
    """What reads the slip of the plates (s,) in rad/s from the state of a slipping line."""
    size, n = system.state_matrix.shape[0] - 2, line.inertia.size
    first, second = line.first[clutch.element], line.second[clutch.element]
    rate = system.state_matrix[clutch.element]
    view: FloatArray = -rate / np.sqrt(line.stiffness[clutch.element])
    view[size - n + first] += 1.0 / np.sqrt(line.inertia[first])
    view[size - n + second] -= 1.0 / np.sqrt(line.inertia[second])
    return view


# ----------------------------------------------------------------------------
# From two speeds to one: stretches that end where the plates begin to hold or to slip.
# ----------------------------------------------------------------------------

#: more changes between slipping and holding than this are refused
MOST_CHANGES = 400
#: steps are this many times finer than those of a run, in search of the ends of stretches
_FINER = 4.0
#: share of the friction torque, or of the speed, that is rounding; halvings of a first step
ROUNDED, _HALVINGS = 1e-12, 40
#: steps that are marched before ends of a stretch are looked for among them
_LOOK = 64
#: share of a cycle by which a stretch of slipping goes beyond where the mean speeds meet
_SHARE = 0.02
#: points of a step over which power is summed: closed Newton-Cotes rules
_POWERS = 8


class Engagement(NamedTuple):
    """A run in which a clutch engages.

    `slip` belongs to the stretches of the run: 1, -1, 0 (it holds) or OPEN. `held` is the first
    time in s at which it holds, infinite if it never does, `common_speed` in rad/s then the mean
    one of the line by the momentum of both parts (before that: of the crank's part at the end).
    `slip_time` in s and `heat` in J are of all its slipping, `heat_error` in J. `engagements` says
    how often it begins to hold, `use` the largest torque over the friction torque while it holds.
    """

    run: TransientRun
    slip: tuple[int, ...]
    held: float
    common_speed: float
    slip_time: float
    heat: float
    heat_error: float
    engagements: int
    use: float


def engage(
    line: Line,
    order: FloatArray,
    clutch: Clutch,
    torques: Callable[[float], Stretch],
    speed: float,
    before: float,
    after: float,
    cycle: float,
    rtol: float = 1e-7,
) -> Engagement:
    """March a line whose clutch is open for `before` s and then engaged for `after` s.

    The crank turns at `speed` (rad/s) at first; `torques` gives a stretch of any duration with
    those at a crank speed, their means zero. The prescribed motion of the crank is the mean one of
    its part by the balance of momentum; where the plates begin to hold it goes over to that of the
    whole line within a `cycle` (rad). Absolute damping acts against the mean motion of each part.

    Raises NumericalFailure if the clutch changes between slipping and holding without end, or as
    `transient` does.
    """
    driving = ~clutch.driven
    first_drives = bool(driving[line.first[clutch.element]])
    inertia = np.array([line.inertia[driving].sum(), line.inertia[clutch.driven].sum()])
    full, total = clutch.friction_torque, before + after
    growth = full / clutch.engaging_time if clutch.engaging_time > 0.0 else 0.0
    root = float(np.sqrt(line.stiffness[clutch.element]))
    mean = np.array([speed, clutch.driven_speed])

    @cache
    def system_of(slip: int, grows: bool) -> TransientSystem:
        return clutch_system(line, clutch, slip, growth if grows else 0.0)

    def damped(slip: int, *gap: FloatArray) -> TorqueInTime:
        """What absolute damping leaves out: means less the prescribed speed, with their rates."""
        share = line.absolute_damping * (1.0 if slip == 0 else clutch.driven)
        none = np.zeros(0, dtype=complex)
        return TorqueInTime(share, none, none, *(float(one[1]) for one in gap))

    start = steady_start(system_of(OPEN, False), order, torques(speed), speed)
    velocity = slice(start.size - 2 - line.inertia.size, start.size - 2)
    start[velocity] += np.sqrt(line.inertia) * np.where(clutch.driven, mean[1] - mean[0], 0.0)
    start[-2:] = (0.0 if growth else full) / root, full / root
    state, crank, angle, time = start, speed, 0.0, 0.0
    parts, systems, slips = list[Stretch](), list[TransientSystem](), list[int]()
    if before > 0.0:
        part = torques(speed)._replace(duration=before, in_time=damped(OPEN, mean - speed))
        parts, systems, slips = [part], [system_of(OPEN, False)], [OPEN]
        _, state, _ = marched_until(systems[0], order, part, crank, angle, state, None)
        angle, time = speed * before, before
    # the side on which the plates begin to slip; without a dashpot the element is wound up at once
    relative = float(slip_view(system_of(OPEN, False), line, clutch) @ state)
    slip = int(np.sign(relative)) or 1
    if line.damping[clutch.element] == 0.0:
        start[clutch.element] = state[clutch.element] = slip * start[-2]
    held, common, engagements, use = np.inf, np.nan, 0, 0.0
    while total - time > ROUNDED * total:
        friction, left = root * float(state[-2]), total - time
        grows = friction < full * (1.0 - 1e-9) and growth > 0.0
        duration = min(left, (full - friction) / growth) if grows else left
        # torque of the clutch on the part of the crank, which it brakes where that is faster
        sign = float(slip if first_drives else -slip)
        rate = np.zeros(2)
        if slip:
            rate = sign * np.array([-1.0, 1.0]) / inertia
        acceleration, bend = rate * friction, rate * (growth if grows else 0.0)
        if slip:  # not far beyond where the mean speeds meet: the crank would turn backwards
            gap, slope, curve = sign * ((mean, acceleration, bend) @ np.array([1.0, -1.0]))
            meeting = _meeting(gap, slope, curve) if gap > ROUNDED * speed else 0.0
            duration = min(duration, max(meeting, _SHARE * cycle / crank))
        behind = float(mean[0] - crank)
        pull, twist = float(acceleration[0]), float(bend[0])
        if abs(behind) > ROUNDED * speed:
            lasts = min(duration, cycle / crank)
            pushed = pull + behind / lasts
            if pushed * (pushed + twist * lasts) >= 0.0:
                pull, duration = pushed, lasts
        part = torques(crank)._replace(
            duration=duration, acceleration=pull, acceleration_rate=twist,
            in_time=damped(slip, mean - crank, acceleration - pull, bend - twist),
        )  # fmt: skip
        system = system_of(slip, grows)
        if slip:
            watched = slip * slip_view(system, line, clutch)[None]
            allowed = ROUNDED * speed
        else:
            reserve = np.zeros(start.size)
            reserve[-2] = root
            own = system.torque[clutch.element]
            watched = np.stack([reserve - own, reserve + own])
            allowed = ROUNDED * full
        passed, state, changes = marched_until(
            system, order, part, crank, angle, state, watched, allowed
        )
        if passed > ROUNDED * total:
            parts.append(part._replace(duration=passed))
            systems.append(system)
            slips.append(slip)
            angle += (crank + (pull + twist * passed / 3.0) * passed / 2.0) * passed
            crank += (pull + 0.5 * twist * passed) * passed
            mean = mean + (acceleration + 0.5 * bend * passed) * passed
            time += passed
        if not changes:
            continue
        if slip:
            slip, engagements = 0, engagements + 1
            mean = np.full(2, float(inertia @ mean / inertia.sum()))
            if not np.isfinite(held):
                held, common = time, float(mean[0])
        else:
            slip = 1 if system.torque[clutch.element] @ state > 0.0 else -1
        if len(parts) > MOST_CHANGES:
            raise NumericalFailure(
                f"the clutch changes between slipping and holding more than {MOST_CHANGES} times "
                f"before {time:.6g} s: a larger friction torque, or a shorter time watched after"
            )
    run = transient(line, order, parts, speed, start=start, rtol=rtol, systems=systems)
    slipped = [one.duration for one, way in zip(parts, slips, strict=True) if way in (1, -1)]
    heat, heat_error = slip_heat(run, line, clutch, slips)
    for block, states in zip(run.blocks, run.states, strict=True):
        if slips[block.stretch] == 0:
            carried = states @ run.drive.systems[block.stretch].torque[clutch.element]
            use = max(use, float(np.max(np.abs(carried))) / full)
    return Engagement(
        run, tuple(slips), held, common if np.isfinite(held) else float(mean[0]),
        float(sum(slipped)), heat, heat_error, engagements, use,
    )  # fmt: skip


def _meeting(gap: float, slope: float, bend: float) -> float:
    """First time in s at which gap + slope t + bend t^2 / 2 is zero, infinite if it never is."""
    roots = np.roots(np.trim_zeros(np.array([0.5 * bend, slope, gap]), "f"))
    ahead = [float(one.real) for one in roots if abs(one.imag) == 0.0 and one.real > 0.0]
    return min(ahead, default=np.inf)


def marched_until(
    system: TransientSystem,
    order: FloatArray,
    part: Stretch,
    speed: float,
    angle: float,
    state: FloatArray,
    watched: FloatArray | None,
    allowed: float = 0.0,
    longest: float = np.inf,
) -> tuple[float, FloatArray, bool]:
    """A stretch to its end, or to where one of the `watched` views (v, s) falls below zero.

    They are looked at after steps of `longest` s at most.

    The time in s and the state (s,) there, and whether a view fell. Views that begin at zero,
    within `allowed`, count once they have been above it.
    """
    from scipy.optimize import brentq

    drive = driven(order, course_of([part], speed, angle), [system])
    for block in _looks(drive.cut(_FINER), longest):
        states = drive.march([block], state)[0]
        state = states[-1]
        if watched is None:
            continue
        below = np.flatnonzero(np.min(states[1:] @ watched.T, axis=1) < -allowed)
        if not below.size:
            continue
        since, begin = block.offset + int(below[0]) * block.step, states[below[0]]

        def after(time: float, since: float = since, begin: FloatArray = begin) -> FloatArray:
            one = [StepBlock(0, since, time, 1)]
            return drive.march(one, begin)[0][-1] if time > 0.0 else begin

        def least(time: float) -> float:
            return float(np.min(watched @ after(time)))

        low = 0.0
        if least(0.0) <= 0.0:
            tries = (block.step * 0.5 ** np.arange(1.0, _HALVINGS)).tolist()
            low = next((one for one in tries if least(one) > 0.0), tries[-1])
        time = low if least(low) <= 0.0 else brentq(least, low, block.step, xtol=1e-16, rtol=1e-15)
        return since + float(time), after(float(time)), True
    return part.duration, state, False


def _looks(blocks: Sequence[StepBlock], longest: float) -> Iterator[StepBlock]:
    """Blocks of `_LOOK` steps at most: what follows an end would be marched in vain."""
    for block in blocks:
        parts = max(1, int(np.ceil(block.step / longest)))
        step, steps = block.step / parts, block.steps * parts
        for first in range(0, steps, _LOOK):
            left = min(_LOOK, steps - first)
            yield StepBlock(block.stretch, block.offset + first * step, step, left)


def slip_heat(
    run: TransientRun, line: Line, clutch: Clutch, slips: list[int]
) -> tuple[float, float]:
    """What the plates turn into heat in J, friction torque times slip, with its error.

    The slip is the relative velocity v of the ends less theta', which a stiff dashpot makes jump:
    by parts, int T (v - theta') dt = int (T v + T' theta) dt - T theta between the ends.
    """
    from scipy.integrate import newton_cotes

    sums, own = np.zeros(2), clutch.element
    for number, block in enumerate(run.blocks):
        slip = slips[block.stretch]
        if slip not in (1, -1):
            continue
        system = run.drive.systems[block.stretch]
        size = system.state_matrix.shape[0]
        relative, growth = np.zeros((2, size))
        velocity = slip_view(system, line, clutch)[size - 2 - line.inertia.size : -2]
        relative[size - 2 - line.inertia.size : -2] = velocity
        growth[-1] = slip * np.sqrt(line.stiffness[own]) * system.state_matrix[-2, -1]
        twist = np.zeros(size)
        twist[own] = 1.0 / np.sqrt(line.stiffness[own])
        view = np.stack([system.torque[own], relative, growth, twist])
        tool = propagator(system, block.step, _POWERS, view)
        values = inside(run, number, tool, np.arange(block.steps))
        begin = (run.states[number][:-1] @ view.T)[:, None]
        values = np.concatenate([begin, values], axis=1)
        power = values[..., 0] * values[..., 1] + values[..., 2] * values[..., 3]
        wound = run.states[number][[0, -1]] @ view[[0, 3]].T
        sums -= np.diff(wound.prod(axis=1))[0]
        for row, every in enumerate((1, 2)):
            weight = newton_cotes(_POWERS // every, 1)[0] * every / _POWERS
            sums[row] += block.step * float(np.sum(power[:, ::every] @ weight))
    return float(sums[0]), float(abs(sums[0] - sums[1]) + 1e-12 * abs(sums[0]))
