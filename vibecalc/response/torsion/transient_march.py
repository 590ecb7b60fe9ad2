"""The line through a whole run, marched exactly but for the representation of the torque."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.torsion.line import Line
from vibecalc.response.torsion.transient_motion import Course, Stretch, course
from vibecalc.response.torsion.transient_pieces import Piece, cut, piece_gain
from vibecalc.response.torsion.transient_start import rest, steady_start
from vibecalc.response.torsion.transient_step import POINTS, propagator, scan, short_step
from vibecalc.response.torsion.transient_system import TransientSystem, transient_system
from vibecalc.response.torsion.transient_torque import TorqueLaw, torque_law

#: values of torques that are held at once
CHUNK = 2_000_000

#: halving the step divides the error by 2^POINTS at least; half of that is counted on
GAIN_OF_HALVING = 2.0 ** (POINTS - 1)

#: a section with less than this share of the largest torque is held to that share
SMALL_SECTION = 1e-3

#: roundings of a step, each of which is taken to last and to add up
ROUNDINGS = 4.0


class TransientRun(NamedTuple):
    """A run that was marched: per piece the states (count + 1, s) at the ends of its steps.

    `torque_error` and `twist_error` (e,) bound the errors of section torques in N m and twists in
    rad at every time, absolute.
    """

    system: TransientSystem
    stretches: tuple[Stretch, ...]
    borders: Course
    laws: tuple[TorqueLaw, ...]
    pieces: tuple[Piece, ...]
    states: tuple[FloatArray, ...]
    torque_error: FloatArray
    twist_error: FloatArray


def transient(
    line: Line,
    order: FloatArray,
    stretches: Sequence[Stretch],
    speed: float,
    angle: float = 0.0,
    start: str = "rest",
    reaction: FloatArray | None = None,
    rtol: float = 1e-7,
) -> TransientRun:
    """March a line from crank speed `speed` (rad/s) at crank angle `angle` through the stretches.

    `order` (m,) are multiples of 1/2 and may hold 0, the mean. `start` is "rest" (no twist, no
    relative velocity) or "steady" (the steady vibration at the first speed). `reaction` (n,) are
    the shares by which the stations take what the mean torques and the prescribed acceleration
    leave over (None: shares of inertia). Steps are halved until the error of every section torque
    is below rtol of the largest torque of that section (or of a thousandth of the largest of all,
    where that is more).

    Raises NumericalFailure for loss factors, freedoms without inertia, other orders, a crank that
    would turn backwards, a start on an undamped critical, or if rtol cannot be reached.
    """
    system = transient_system(line, reaction)
    borders = course(stretches, speed, angle)
    laws = tuple(
        torque_law(order, part, system.balance, system.inertia, borders.speed[k : k + 2])
        for k, part in enumerate(stretches)
    )
    if start == "steady":
        begin = steady_start(system, order, stretches[0], speed, angle)
    else:
        begin = rest(system)
    highest = float(laws[0].power.max(initial=0.0)) / 2.0
    turned = float(abs(borders.angle).max() * np.finfo(np.longdouble).eps)
    phase = highest * (turned + 8.0 * np.pi * UNIT_ROUNDOFF)
    missed = ""
    for finer in (1.0, 2.0, 4.0, 8.0):
        parts = cut(stretches, borders, highest, system.fastest, finer)
        fine = march(system, stretches, borders, laws, parts, begin)
        coarse = [piece._replace(step=2.0 * piece.step, steps=piece.steps // 2) for piece in parts]
        rough = march(system, stretches, borders, laws, coarse, begin)
        errors = [
            run_error(view, system, parts, fine, rough, phase)
            for view in (system.torque, system.twist)
        ]
        largest = np.max([np.abs(x @ system.torque.T).max(axis=0) for x in fine], axis=0)
        largest = np.maximum(largest, SMALL_SECTION * largest.max(initial=0.0))
        if np.all(errors[0] <= rtol * largest):
            return TransientRun(
                system, tuple(stretches), borders, laws, tuple(parts), tuple(fine), *errors
            )
        worst = int(np.argmax(errors[0] - rtol * largest))
        missed = f"section {worst + 1}: {errors[0][worst]:.3g} of {largest[worst]:.3g} N m"
    raise NumericalFailure(f"the transient does not reach the tolerance {rtol:g} ({missed})")


def march(
    system: TransientSystem, stretches: Sequence[Stretch], borders: Course,
    laws: Sequence[TorqueLaw], parts: Sequence[Piece], begin: FloatArray,
) -> list[FloatArray]:  # fmt: skip
    """States (count + 1, s) of every piece, each beginning where the one before ends."""
    states, current, known = [], begin, {}
    for piece in parts:
        if piece.step not in known:
            known[piece.step] = propagator(system, piece.step)
        tool, part, law = known[piece.step], stretches[piece.stretch], laws[piece.stretch]
        size = system.state_matrix.shape[0]
        batch = max(1, CHUNK // (2 * POINTS * max(law.power.size, system.inertia.size)))
        gain = np.empty((piece.steps, size))
        for first in range(0, piece.steps, batch):
            steps = np.arange(first, min(piece.steps, first + batch))
            gain[steps] = piece_gain(piece, law, part, borders, tool.weight[-1], tool.place, steps)
        states.append(scan(tool.transition[-1], current, gain))
        current = states[-1][-1]
    return states


def run_error(
    view: FloatArray, system: TransientSystem, parts: Sequence[Piece],
    fine: list[FloatArray], rough: list[FloatArray], phase: float,
) -> FloatArray:  # fmt: skip
    """Absolute error (e,) of what `view` (e, s) reads: half steps against whole, and rounding.

    `phase` in rad is what rounded crank angles turn the highest order by.
    """
    gap, lasting, largest = np.zeros((3, view.shape[0]))
    steps, size = sum(piece.steps for piece in parts), 0.0
    for piece, one, other in zip(parts, fine, rough, strict=True):
        largest = np.maximum(largest, np.abs(one @ view.T).max(axis=0))
        gap = np.maximum(gap, np.abs((one[::2] - other) @ view.T).max(axis=0))
        size = max(size, float(np.sqrt((one**2).sum(axis=1).max())))
        lasting = np.maximum(lasting, rounding_sum(view, system, piece.step, steps))
    error: FloatArray = gap / GAIN_OF_HALVING + UNIT_ROUNDOFF * size * lasting + phase * largest
    return error


def rounding_sum(view: FloatArray, system: TransientSystem, step: float, steps: int) -> FloatArray:
    """What unit errors of the state in all steps add up to in the views (e,), in roundings.

    sum_k |view E^k| over the steps, taken at k = 0, 1, 2, 4, ...: damped parts forget. The
    transition itself is off by its squarings, as many roundings as |A h| is large.
    """
    power = short_step(system, step)[0]
    each = ROUNDINGS + float(np.linalg.norm(system.state_matrix * step, 1))
    total, reach = np.linalg.norm(view, axis=1), 1
    while reach < steps:
        count = min(reach, steps - reach)
        total = total + count * np.linalg.norm(view @ power, axis=1)
        power, reach = power @ power, 2 * reach
    summed: FloatArray = each * total
    return summed
