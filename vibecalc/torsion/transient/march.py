"""A shaft line through a whole run, marched by exact steps of a linear system."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import SINGULAR, UNIT_ROUNDOFF, BoolArray, FloatArray, IntArray
from vibecalc.torsion.line import Line, damping_matrix, free_parts, spring_twists
from vibecalc.torsion.transient.motion import (
    CYCLE,
    Course,
    Stretch,
    TorqueLaw,
    course_of,
    repeats,
    speed_after,
    time_of_speed,
    torque_law,
    turned_after,
)

# ----------------------------------------------------------------------------
# The shaft line as a first-order system whose state has the size of an energy.
#
# The state is (sqrt(k) twist of each element and ground spring, sqrt(J) velocity of each freedom):
# its squared length is twice the energy, so that free motion never lengthens it, whether the
# eigenvalues are simple, multiple or defective. Angles are not in it, so a line without a ground
# spring has no angle that could drift: its rigid mode has a velocity only.
# ----------------------------------------------------------------------------


#: propagators of one system that are held at once
MOST_TOOLS = 400


@dataclass(frozen=True, eq=False)
class TransientSystem:
    """x' = state_matrix x + input_matrix torque, s states, n freedoms, e elements, SI units.

    `torque` (e, s) reads an element's torque (stiffness and damping part) from the state. `balance`
    (n, n) turns mean torques into those that leave every part without a ground spring on its
    prescribed motion. `idle` (s,) marks twists that act on nothing (elements of dashpots only).
    `fastest` in rad/s bounds the frequency of every mode.
    """

    state_matrix: FloatArray
    input_matrix: FloatArray
    torque: FloatArray
    balance: FloatArray
    idle: BoolArray
    inertia: FloatArray
    fastest: float
    tools: "dict[tuple[float, int], Propagator]" = field(default_factory=dict, repr=False)

    def tool(self, step: float, parts: int = 0) -> "Propagator":
        """The propagator to the torques at parts of a step in s; without parts to its end."""
        key = step, parts
        if key not in self.tools:
            if len(self.tools) >= MOST_TOOLS:
                self.tools.clear()
            view = self.torque if parts else None
            self.tools[key] = propagator(self, step, max(parts, 1), view)
        return self.tools[key]


def balance_matrix(line: Line, reaction: FloatArray | None) -> FloatArray:
    """I - reaction (sum over the part): mean torques (n,) to those without resultant.

    `reaction` (n,) are the shares by which the stations take what holds the prescribed motion (the
    driven machine, say); None: by their inertias, as if the whole line were slowed down evenly.
    """
    member = free_parts(line, (line.stiffness > 0.0) | (line.damping > 0.0))
    share = member * (line.inertia if reaction is None else np.asarray(reaction, dtype=float))
    total = share.sum(axis=1, keepdims=True)
    if (total <= 0.0).any():
        raise NumericalFailure(
            "a piece of the shaft line that no ground spring holds has no station which takes the "
            "mean torque"
        )
    matrix: FloatArray = np.eye(line.inertia.size) - (share / total).T @ member
    return matrix


def transient_system(line: Line, reaction: FloatArray | None = None) -> TransientSystem:
    """The system of one line (no leading axes); `reaction` as in `balance_matrix`.

    Raises NumericalFailure for loss factors (damping by hysteresis is defined at one frequency
    only) and for freedoms without inertia.
    """
    if np.any(line.loss_factor != 0.0):
        raise NumericalFailure(
            "a loss factor has no time domain: it is defined for steady vibration only; give the "
            "element a viscous damping for transients"
        )
    if not np.all(line.inertia > 0.0):
        raise NumericalFailure(
            "a transient needs an inertia at every freedom; condense the massless ones first"
        )
    n, e = line.inertia.size, line.stiffness.size
    root = np.sqrt(line.inertia)
    difference, stiffness = spring_twists(line)
    springs = stiffness.size
    # a dashpot alone still has a twist, counted in the middle of the other scales
    positive = stiffness[stiffness > 0.0]
    middle = float(np.sqrt(np.median(positive))) if positive.size else 1.0
    scale = np.where(stiffness > 0.0, np.sqrt(stiffness), middle)

    matrix = np.zeros((springs + n, springs + n))
    matrix[:springs, springs:] = scale[:, None] * difference / root
    matrix[springs:, :springs] = -(difference * (stiffness / scale)[:, None]).T / root[:, None]
    matrix[springs:, springs:] = -damping_matrix(line) / root / root[:, None]
    torque = np.zeros((e, springs + n))
    torque[np.arange(e), np.arange(e)] = line.stiffness / scale[:e]
    torque[:, springs:] = line.damping[:, None] * difference[:e] / root
    inputs = np.zeros((springs + n, n))
    inputs[springs + np.arange(n), np.arange(n)] = 1.0 / root
    coupling = scale[:, None] * difference / root
    active = coupling[stiffness > 0.0]
    fastest = float(np.linalg.norm(active, 2)) if active.size else 0.0
    return TransientSystem(
        matrix, inputs, torque,
        balance_matrix(line, reaction),
        np.concatenate([stiffness == 0.0, np.zeros(n, dtype=bool)]),
        line.inertia, fastest,
    )  # fmt: skip


# ----------------------------------------------------------------------------
# One step of the linear system under a polynomial torque, exactly.
#
# Over a step of length h the torque is the polynomial through its values at p Gauss points, written
# in Legendre polynomials P_l. With I_l = int_0^h exp(A (h - t)) B P_l dt the state at the end is
# exp(A h) x + sum_l I_l u_l: the phi functions of an exponential integrator in an orthogonal basis,
# where they neither cancel nor need an inverse of A. They are found on a step so short that
# |A h| <= 1, where the series of the exponential neither cancels nor lasts, and doubled.
# ----------------------------------------------------------------------------

#: Gauss points of a step; the torque is represented to this order
POINTS = 10

#: terms of the series of the exponential of a matrix whose norm is at most 1
TERMS = 20


class Propagator(NamedTuple):
    """What leads from the start of a step to its j-th part, j = 1 ... parts; the last is its end.

    `transition` (parts, s, s) and `weight` (parts, s, p, n): x_j = transition x + weight torques at
    the p Gauss points; `place` (p,) of these as shares of the step.
    """

    transition: FloatArray
    weight: FloatArray
    place: FloatArray


def legendre_values(x: FloatArray) -> FloatArray:
    """P_l(x), (..., p) for l = 0 ... p - 1."""
    return np.polynomial.legendre.legvander(np.asarray(x, dtype=float), POINTS - 1)


@lru_cache(maxsize=4)
def rule(points: int) -> tuple[FloatArray, FloatArray]:
    """Gauss points in -1 ... 1 and their weights, read-only."""
    x, weight = np.polynomial.legendre.leggauss(points)
    x.flags.writeable = weight.flags.writeable = False
    return x, weight


@lru_cache(maxsize=1)
def to_legendre() -> FloatArray:
    """(p, p): what a value at each Gauss point adds to the share of each P_l."""
    x, weight = rule(POINTS)
    share: FloatArray = weight[:, None] * legendre_values(x) * (np.arange(POINTS) + 0.5)
    return share


@lru_cache(maxsize=64)
def restrictions(parts: int) -> FloatArray:
    """(parts, p, p): [j, l, k] the share of P_k of the j-th part in P_l of the whole step.

    Shared by all callers, hence read-only.
    """
    x, _ = rule(POINTS)
    first = np.arange(parts)[:, None] / parts
    inside = 2.0 * (first + (x + 1.0) / (2.0 * parts)) - 1.0
    matrices: FloatArray = np.swapaxes(legendre_values(inside), 1, 2) @ to_legendre()
    matrices.flags.writeable = False
    return matrices


def short_step(system: TransientSystem, step: float) -> tuple[FloatArray, FloatArray]:
    """exp(A h) (s, s) and I_l (p, s, n) of one step: a series on h / 2^d, then d doublings."""
    a = system.state_matrix * step
    size = float(np.linalg.norm(a, 1))
    doublings = max(0, int(np.ceil(np.log2(max(size, 1e-300)))))
    small = a * 0.5**doublings
    x, weight = rule(POINTS + TERMS)
    basis = weight[:, None] * legendre_values(x) / 2.0
    transition = np.eye(a.shape[0])
    power, column = transition, 0.5**doublings * step * system.input_matrix
    moment = np.zeros((POINTS, *column.shape))
    for k in range(TERMS):
        share = ((1.0 - x) / 2.0) ** k @ basis
        moment += share[:, None, None] * column
        power, column = small @ power / (k + 1.0), small @ column / (k + 1.0)
        transition = transition + power
    first, second = restrictions(2)
    for _ in range(doublings):
        early = np.tensordot(first, moment, 1)
        moment = np.matmul(transition, early) + np.tensordot(second, moment, 1)
        transition = transition @ transition
    return transition, moment


def propagator(
    system: TransientSystem, step: float, parts: int = 1, view: FloatArray | None = None
) -> Propagator:
    """Propagator of a step in s to `parts` equal parts of it.

    With a `view` (e, s) it leads from the state to what that reads, e instead of s values.
    """
    transition, moment = short_step(system, step / parts)
    transitions, moments = [], []
    power, total = np.eye(transition.shape[0]), np.zeros_like(moment)
    for border in restrictions(parts):
        power = transition @ power
        total = np.matmul(transition, total) + np.tensordot(border, moment, 1)
        transitions.append(power if view is None else view @ power)
        moments.append(total if view is None else np.matmul(view, total))
    weights = np.moveaxis(np.tensordot(to_legendre(), np.array(moments), (1, 1)), 0, 2)
    place = (rule(POINTS)[0] + 1.0) / 2.0
    return Propagator(np.array(transitions), np.ascontiguousarray(weights), place)


def scan(transition: FloatArray, start: FloatArray, gain: FloatArray) -> FloatArray:
    """x_0 = start, x_{k+1} = transition x_k + gain_k: states (N + 1, s) for gains (N, s).

    The steps lie in about sqrt(N) blocks that are marched side by side from zero; what each block
    hands to the next is then carried along, and the blocks are marched again from there.
    """
    count, size = gain.shape
    length = max(1, int(np.sqrt(count)))
    blocks = -(-count // length)
    padded = np.zeros((blocks * length, size))
    padded[:count] = gain
    inner = padded.reshape(blocks, length, size)
    local = np.zeros((blocks, size))
    for place in range(length):
        local = local @ transition.T + inner[:, place]
    across = np.linalg.matrix_power(transition, length)
    begin = np.empty((blocks, size))
    carried = np.asarray(start, dtype=float)
    for block in range(blocks):
        begin[block] = carried
        carried = across @ carried + local[block]
    states = np.empty((blocks, length, size))
    for place in range(length):
        begin = begin @ transition.T + inner[:, place]
        states[:, place] = begin
    return np.concatenate([[start], states.reshape(-1, size)[:count]])


# ----------------------------------------------------------------------------
# Blocks of equal steps: a stretch is cut where the speed halves, each block has its step.
# ----------------------------------------------------------------------------

#: radians of the highest order in one step, and of the highest mode that is followed in detail
ORDER_STEP, MODE_STEP = 2.0, 12.0

#: modes faster than this many times the fastest torque are not resolved by the step
FOLLOWED = 10.0

#: more steps than this are refused
MOST_STEPS = 4_000_000

#: least number of steps in a stretch
FEWEST = 16


class StepBlock(NamedTuple):
    """`steps` steps of `step` s in stretch number `stretch`, from `offset` s after its start."""

    stretch: int
    offset: float
    step: float
    steps: int


#: values of torques that are held at once
CHUNK = 2_000_000


class Drive(NamedTuple):
    """A course, with the line as it is in each of its stretches, and the law of the torques."""

    course: Course
    systems: tuple[TransientSystem, ...]
    laws: tuple[TorqueLaw, ...]

    @property
    def highest(self) -> float:
        """The highest order."""
        return float(self.laws[0].power.max(initial=0.0)) / 2.0

    def cut(self, finer: float) -> list[StepBlock]:
        """Blocks with an even number of steps; `finer` divides every step.

        Raises NumericalFailure beyond MOST_STEPS.
        """
        highest, course = self.highest, self.course
        jolts = [part.in_time.fastest for part in course.parts if part.in_time is not None]
        excited = max(highest * float(course.speed.max()), *jolts, 0.0)
        fastest = max(one.fastest for one in self.systems)
        followed = min(fastest, FOLLOWED * excited) if excited > 0.0 else fastest
        # the slowest block is that of 2^-12 of the highest speed, whatever the modes
        floor = max(followed * ORDER_STEP / MODE_STEP, excited * 2.0**-12)
        blocks: list[StepBlock] = []
        for number, part in enumerate(course.parts):
            start, end = course.speed[number : number + 2].tolist()
            level, cuts = max(start, end), [0.0, part.duration]
            # going down in halves from the higher speed, as far as the orders set the step
            while start != end and highest * level > max(floor, highest * min(start, end)):
                level /= 2.0
                if level > min(start, end):
                    cuts.append(time_of_speed(part, start, level))
            for left, right in pairwise(sorted(cuts)):
                speeds = speed_after(part, start, np.array([left, right]))
                rate = max(floor, highest * float(speeds.max()), 1e-300)
                # the pieces of a table are short, and straight lines need no step of their own
                fewest = FEWEST if part.in_time is None or part.in_time.fastest else 2
                length = min(ORDER_STEP / rate, part.duration / fewest) / finer
                count = 2 * max(1, int(np.ceil((right - left) / length / 2.0)))
                blocks.append(StepBlock(number, left, (right - left) / count, count))
        if sum(block.steps for block in blocks) > MOST_STEPS:
            raise NumericalFailure(
                f"the transient needs more than {MOST_STEPS} steps: shorten it or drop high orders"
            )
        return blocks

    def gain(self, block: StepBlock, tool: Propagator, steps: IntArray) -> FloatArray:
        """What the torque adds to the state at the parts of some steps of a block, (k, parts, s).

        The steps are counted from 0. The angle at the start of each is formed in the widest float
        and reduced to two turns, where these are a period of all orders.
        """
        part, law = self.course.parts[block.stretch], self.laws[block.stretch]
        begin = block.offset + steps * np.longdouble(block.step)
        speed = float(self.course.speed[block.stretch])
        turned = self.course.angle[block.stretch] + turned_after(part, speed, begin)
        if repeats(law.power):
            turned = turned % CYCLE
        reduced = np.asarray(turned, dtype=float)[:, None]
        since = np.asarray(begin, dtype=float)[:, None]
        ahead = tool.place * block.step
        rate = speed_after(part, speed, since)
        growth = part.acceleration + part.acceleration_rate * since
        bend = part.acceleration_rate * ahead
        angle = reduced + (rate + (growth + bend / 3.0) * ahead / 2.0) * ahead
        torque = law.at(
            angle, rate + (growth + bend / 2.0) * ahead, (since + ahead) / part.duration
        )
        parts, size, points, n = tool.weight.shape
        gain: FloatArray = np.einsum(
            "ij,kj->ik",
            torque.transpose(1, 2, 0).reshape(-1, points * n),
            tool.weight.reshape(parts * size, -1),
            optimize=True,
        )
        return gain.reshape(-1, parts, size)

    def march(self, blocks: Sequence[StepBlock], begin: FloatArray) -> list[FloatArray]:
        """States (steps + 1, s) of every block, each beginning where the one before ends."""
        states, current = [], begin
        for block in blocks:
            tool = self.systems[block.stretch].tool(block.step)
            _, size, points, n = tool.weight.shape
            batch = max(1, CHUNK // (2 * points * max(self.laws[0].power.size, n)))
            gain = np.empty((block.steps, size))
            for first in range(0, block.steps, batch):
                steps = np.arange(first, min(block.steps, first + batch))
                gain[steps] = self.gain(block, tool, steps)[:, 0]
            states.append(scan(tool.transition[-1], current, gain))
            current = states[-1][-1]
        return states


def driven(order: FloatArray, course: Course, systems: Sequence[TransientSystem]) -> Drive:
    """A course driven by the torques of its stretches at orders (m,), 0 being the mean."""
    laws = tuple(
        torque_law(order, part, one.balance, one.inertia, course.speed[k : k + 2])
        for k, (part, one) in enumerate(zip(course.parts, systems, strict=True))
    )
    return Drive(course, tuple(systems), laws)


# ----------------------------------------------------------------------------
# States to start from: everything at rest, or the steady vibration at the first speed.
# ----------------------------------------------------------------------------


def steady_start(
    system: TransientSystem, order: FloatArray, part: Stretch, speed: float, angle: float = 0.0
) -> FloatArray:
    """State (s,) of the steady vibration at a speed in rad/s and a crank angle in rad.

    Torques and loads are those at the beginning of `part`, its acceleration is left out; at speed
    zero it is the static twist under the torque of that angle. Twists of elements of dashpots only
    start from zero. Raises NumericalFailure if an order meets an undamped natural frequency.
    """
    law = torque_law(
        order,
        part._replace(acceleration=0.0, acceleration_rate=0.0),
        system.balance,
        system.inertia,
        np.array([speed, speed]),
    )
    m = law.power.size
    both = law.harmonic[0] + speed**2 * law.harmonic[2]
    torque = part.scale_start * (both[:, :m] - 1j * both[:, m:])
    moving = (law.power > 0.0) & (speed > 0.0) & np.any(torque != 0.0, axis=0)
    phase = np.exp(0.5j * law.power * angle)

    still = ~moving
    mean = law.loads(np.array(speed)) + (torque[:, still] * phase[still]).real.sum(axis=1)
    state = static_state(system, mean)
    if not moving.any():
        return state
    size = system.state_matrix.shape[0]
    frequency = 0.5 * law.power[moving] * speed
    matrix = 1j * frequency[:, None, None] * np.eye(size) - system.state_matrix
    lost = UNIT_ROUNDOFF * np.linalg.cond(matrix)
    if np.any(lost > SINGULAR):
        worst = 0.5 * law.power[moving][np.argmax(lost)]
        raise NumericalFailure(
            f"no steady vibration to start from: order {worst:g} meets an undamped natural "
            f"frequency at {speed:.6g} rad/s"
        )
    source = (system.input_matrix @ torque[:, moving]).T[..., None]
    amplitude = np.linalg.solve(matrix, source)[..., 0]
    together: FloatArray = state + (amplitude * phase[moving, None]).real.sum(axis=0)
    return together


def static_state(system: TransientSystem, torque: FloatArray) -> FloatArray:
    """State (s,) held by constant balanced torques (n,): the least energy among all solutions."""
    state = np.zeros(len(system.state_matrix))
    if not np.any(torque):
        return state
    used = ~system.idle
    source = system.input_matrix @ torque
    matrix = system.state_matrix[np.ix_(used, used)]
    state[used] = np.linalg.lstsq(matrix, -source[used], rcond=None)[0]
    left = matrix @ state[used] + source[used]
    if np.linalg.norm(left) > 1e-8 * np.linalg.norm(source):
        raise NumericalFailure("the mean torque has nothing that holds it: no static twist exists")
    return state


# ----------------------------------------------------------------------------
# The line through a whole run, marched exactly but for the representation of the torque.
# ----------------------------------------------------------------------------

#: halving the step divides the error by 2^POINTS at least; half of that is counted on
GAIN_OF_HALVING = 2.0 ** (POINTS - 1)

#: a section with less than this share of the largest torque is held to that share
SMALL_SECTION = 1e-3

#: roundings of a step, each of which is taken to last and to add up
ROUNDINGS = 4.0


class TransientRun(NamedTuple):
    """A run that was marched: per block the states (count + 1, s) at the ends of its steps.

    `torque_error` (e,) bounds the errors of section torques in N m at every time, absolute.
    """

    drive: Drive
    blocks: tuple[StepBlock, ...]
    states: tuple[FloatArray, ...]
    torque_error: FloatArray

    @property
    def course(self) -> Course:
        """The motion of the crank."""
        return self.drive.course

    @property
    def system(self) -> TransientSystem:
        """That of the first stretch."""
        return self.drive.systems[0]

    @property
    def longest(self) -> float:
        """The longest step in s."""
        return max(block.step for block in self.blocks)


def transient(
    line: Line,
    order: FloatArray,
    stretches: Sequence[Stretch],
    speed: float,
    angle: float = 0.0,
    start: str | FloatArray = "rest",
    reaction: FloatArray | None = None,
    rtol: float = 1e-7,
    systems: Sequence[TransientSystem] = (),
) -> TransientRun:
    """March a line from a crank speed in rad/s and angle in rad through the stretches.

    `order` (m,) may hold 0, the mean. `start` is "rest" (no twist, no relative velocity), "steady"
    (the steady vibration at the first speed) or a state (s,). `reaction` (n,) are the shares by
    which the stations take what the mean torques and the prescribed acceleration leave over (None:
    shares of inertia). `systems` are those of the stretches, of one size, where a line changes on
    the way; they take the place of `line` and `reaction`. Steps are halved until the error of
    every section torque is below rtol of the largest torque of that section (or of a thousandth of
    the largest of all, where that is more).

    Raises NumericalFailure for loss factors, freedoms without inertia, orders below zero, a crank
    that would turn backwards, a start on an undamped critical, or if rtol cannot be reached.
    """
    each = systems or (transient_system(line, reaction),) * len(stretches)
    drive = driven(order, course_of(stretches, speed, angle), each)
    if not isinstance(start, str):
        begin = np.asarray(start, dtype=float)
    elif start == "steady":
        begin = steady_start(each[0], order, stretches[0], speed, angle)
    else:
        begin = np.zeros(len(each[0].state_matrix))
    missed = ""
    for finer in (1.0, 2.0, 4.0, 8.0):
        blocks = drive.cut(finer)
        fine = drive.march(blocks, begin)
        error, largest = _run_error(drive, blocks, fine, begin)
        largest = np.maximum(largest, SMALL_SECTION * largest.max(initial=0.0))
        if np.all(error <= rtol * largest):
            return TransientRun(drive, tuple(blocks), tuple(fine), error)
        worst = int(np.argmax(error - rtol * largest))
        missed = f"section {worst + 1}: {error[worst]:.3g} of {largest[worst]:.3g} N m"
    raise NumericalFailure(f"the transient does not reach the tolerance {rtol:g} ({missed})")


def _run_error(
    drive: Drive, blocks: list[StepBlock], fine: list[FloatArray], begin: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Absolute error (e,) of section torques: half steps against whole, and rounding; the largest.

    Rounded crank angles turn the highest order by some of the phase.
    """
    coarse = [block._replace(step=2.0 * block.step, steps=block.steps // 2) for block in blocks]
    gap, lasting, largest = np.zeros((3, len(drive.systems[0].torque)))
    steps, size = sum(block.steps for block in blocks), 0.0
    known: dict[tuple[TransientSystem, float], FloatArray] = {}
    for block, one, other in zip(blocks, fine, drive.march(coarse, begin), strict=True):
        system = drive.systems[block.stretch]
        largest = np.maximum(largest, np.abs(one @ system.torque.T).max(axis=0))
        gap = np.maximum(gap, np.abs((one[::2] - other) @ system.torque.T).max(axis=0))
        size = max(size, float(np.sqrt((one**2).sum(axis=1).max())))
        key = system, block.step
        if key not in known:
            known[key] = rounding_sum(system, block.step, steps)
        lasting = np.maximum(lasting, known[key])
    kind = np.longdouble if repeats(drive.laws[0].power) else float
    turned = float(abs(drive.course.angle).max() * np.finfo(kind).eps)
    phase = drive.highest * (turned + 8.0 * np.pi * UNIT_ROUNDOFF)
    error = gap / GAIN_OF_HALVING + UNIT_ROUNDOFF * size * lasting + phase * largest
    return error, largest


def rounding_sum(system: TransientSystem, step: float, steps: int) -> FloatArray:
    """What unit errors of the state in all steps add up to in the torques (e,), in roundings.

    sum_k |torque E^k| over the steps, taken at k = 0, 1, 2, 4, ...: damped parts forget. The
    transition itself is off by its squarings, as many roundings as |A h| is large. States that
    follow from constant ones alone (a friction torque that grows evenly) are off by roundings of
    their own size only and do not count.
    """
    power = system.tool(step).transition[-1]
    each = ROUNDINGS + float(np.linalg.norm(system.state_matrix * step, 1))
    pushed = np.any(system.input_matrix, axis=1)
    changes = np.any(system.state_matrix, axis=1) | pushed
    moved = np.any(system.state_matrix[:, changes], axis=1) | pushed
    total, reach = np.linalg.norm(system.torque[:, moved], axis=1), 1
    while reach < steps:
        count = min(reach, steps - reach)
        total = total + count * np.linalg.norm((system.torque @ power)[:, moved], axis=1)
        power, reach = power @ power, 2 * reach
    summed: FloatArray = each * total
    return summed
