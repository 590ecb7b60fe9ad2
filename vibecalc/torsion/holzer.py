"""Holzer's tables of a shaft line, with the errors of the mode shapes that stand in them."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, BoolArray, ComplexArray, FloatArray, IntArray
from vibecalc.torsion.damped_modes import LineModes
from vibecalc.torsion.line import (
    Line,
    connected_parts,
    lines_of,
    network_matrix,
    walk,
)
from vibecalc.torsion.modes import Modes

# ----------------------------------------------------------------------------
# Holzer's table of a line at any frequency, branch by branch, with the torque left at the end.
# ----------------------------------------------------------------------------


class HolzerRows(NamedTuple):
    """Order of the n rows of a table: `freedom` (n,) of the line, `below` (n,) the row that each
    one's shaft leads to (-1 for the last), `stiffness` (..., n - 1) of that shaft in N m/rad.

    From the first end along the main row; before the row of a junction stand those of the
    branches on it, each from its own end on. In a plain row `below` is always the next row.
    """

    freedom: IntArray
    below: IntArray
    stiffness: FloatArray


class HolzerTable(NamedTuple):
    """One row for each of n stations in the order of `rows`, leading axes those of the frequency.

    `angle` (..., n) in rad, 1 in the first row; `sum_torque` (..., n) in N m are the torques of the
    inertias J w^2 angle, with the sums of the rows whose shafts lead here, less what springs to
    ground take. The last one keeps the motion going: it is zero at a natural frequency.
    """

    rows: HolzerRows
    angle: FloatArray
    sum_torque: FloatArray


def holzer_rows(line: Line) -> HolzerRows:
    """Rows of the part with most stations, from its end nearest to the first station.

    The main row leads to the end that is farthest from it. Parallel shafts count as one. The line
    may have one leading axis of its stiffness. Raises `NumericalFailure` for closed loops and for a
    part without any inertia.
    """
    if line.stiffness.ndim > 1:
        each = [holzer_rows(one) for one in lines_of(line)]
        return each[0]._replace(stiffness=np.stack([one.stiffness for one in each]))
    part = max(connected_parts(line), key=lambda one: len(one.spring))
    if not part.is_tree:
        raise NumericalFailure("a Holzer table is of a line without closed loops of shafts")
    start = next(s for s, others in part.spring.items() if len(others) < 2)
    towards = walk(part.spring, start)
    end = list(towards)[-1]
    parent = walk(part.spring, end)
    children: dict[int, list[int]] = {station: [] for station in parent}
    size = dict.fromkeys(parent, 1)
    for station in reversed(parent):
        if parent[station] >= 0:
            children[parent[station]].append(station)
            size[parent[station]] += size[station]
    main, station = {start}, start
    while station != end:
        station = parent[station]
        main.add(station)
    # the walk from the end takes the main row last, so that backwards it comes first
    waiting, order = [end], []
    while waiting:
        order.append(waiting.pop())
        waiting += sorted(children[order[-1]], key=lambda s: (s not in main, -size[s]))
    order.reverse()
    place = {station: row for row, station in enumerate(order)}
    return HolzerRows(
        np.array(order),
        np.array([place.get(parent[station], -1) for station in order]),
        np.array([part.spring[station][parent[station]] for station in order[:-1]]),
    )


def holzer_table(line: Line, frequency: ArrayLike) -> HolzerTable:
    """The table at frequencies (...) in rad/s; a branch takes the angle of the junction it is on.

    The line may have the frequencies as a leading axis of its stiffness.

    Far from a natural frequency of a long row the angles grow from station to station; this is a
    table to be read, frequencies are found by counting (`count.py`). Raises `NumericalFailure` as
    `holzer_rows`, for angles beyond the range of numbers, and where a junction that a branch hangs
    on stands still.
    """
    rows = holzer_rows(line)
    inertia, ground = line.inertia[rows.freedom], line.ground_stiffness[rows.freedom]
    rate = np.asarray(frequency, dtype=float)[..., None] ** 2 * inertia - ground
    count = len(inertia)
    angle, total = np.ones(rate.shape), np.zeros(rate.shape)
    above: list[list[int]] = [[] for _ in range(count)]  # rows that lead here
    branch: list[list[int]] = []  # rows that move with each one, itself included
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        for i in range(count):
            branch.append([i])
            for place, j in enumerate(above[i]):
                twist = total[..., j] / rows.stiffness[..., j]
                reached = angle[..., j] - twist
                if place == 0:
                    angle[..., i] = reached
                else:
                    lost = count * EPSILON * (np.abs(twist) + np.abs(angle[..., j]))
                    if np.any(np.abs(reached) <= lost):
                        raise NumericalFailure(
                            "a branch swings against a junction that stands still: its Holzer "
                            "table cannot be joined to that of the line"
                        )
                    factor = angle[..., i] / reached
                    for row in branch[j]:
                        angle[..., row] *= factor
                        total[..., row] *= factor
                total[..., i] += total[..., j]
                branch[i] += branch[j]
            total[..., i] += rate[..., i] * angle[..., i]
            if i < count - 1:
                above[rows.below[i]].append(i)
    if not np.all(np.isfinite(total)):
        raise NumericalFailure("the angles of the Holzer table leave the range of numbers")
    return HolzerTable(rows, angle, total)


def relative_residual(line: Line, frequency: ArrayLike) -> FloatArray:
    """What the last row leaves over the sum of the magnitudes of all inertia torques, (...).

    1 towards frequency zero, where the line turns as a whole, and 0 at a natural frequency: sigma_3
    of eq. 4.12 of Baca (2007), which grows with the frequency over all bounds, as a share. At
    frequencies (...) above 0 in rad/s; raises `NumericalFailure` as `holzer_table`.
    """
    table, square = holzer_table(line, frequency), np.square(frequency)[..., None]
    torque = square * line.inertia[table.rows.freedom] * table.angle
    return np.asarray(table.sum_torque[..., -1] / np.abs(torque).sum(axis=-1))


# ----------------------------------------------------------------------------
# Errors of the shapes of a shaft line, measured: what one more step would correct, and what a
# rounding of each inertia and stiffness moves.
#
# A bound on all angles of a shape alike is far too large for angles in which a mode fades, and for
# what has them in common. Here any weighted sum of angles has an error of its own.
# ----------------------------------------------------------------------------

#: roundings of an inertia or a stiffness on its way from a case into a line, and times a correction
ROUNDINGS, CORRECTIONS = 4.0, 2.0
#: freedoms up to which the answers to all of them are formed: they cost the fourth power
FREEDOMS = 48


class ShapeUncertainty(NamedTuple):
    """Of m modes of n freedoms, with the largest angle of each held.

    `bound` (m,) is what holds for each angle; `moved` (m, n + 1, p) are p moves of the angles and,
    last, of the squared frequency as a share of itself: first what is corrected, then those that
    have no common sign. p is 0 where they are not known: where modes lie closer than a correction
    tells, or for a long line. `moving` (m,) is 0 for rigid modes, which have no errors, else 1.
    """

    bound: FloatArray
    moved: FloatArray | ComplexArray
    moving: FloatArray

    def of(self, modes: slice) -> "ShapeUncertainty":
        """Those of some modes."""
        return ShapeUncertainty(self.bound[modes], self.moved[modes], self.moving[modes])


def shape_uncertainty(
    line: Line, modes: Modes | LineModes, stations: int | None = None
) -> ShapeUncertainty:
    """From the equations of motion of the shapes as they are, by twists, which do not cancel.

    Of poles the largest angle of the first `stations` freedoms is held. The moves have the order:
    correction, inertias (n,), stiffnesses of elements (e,) and to ground (n,), dashpots of elements
    and to ground. `line` may have the modes as a leading axis of its stiffness and loss factor.
    """
    moving = modes.frequency > 0.0
    counted, count = np.where(moving, 1.0, 0.0), len(line.inertia)
    if count > FREEDOMS or not np.any(moving):
        return ShapeUncertainty(modes.shape_error, np.zeros((len(moving), count + 1, 0)), counted)
    stiffness, loss = (
        one[moving] if one.ndim > 1 else one for one in (line.stiffness, line.loss_factor)
    )
    first, second, shape = line.first, line.second, modes.shape[moving]
    twist = shape[:, first] - shape[:, second]
    square: Any = -(modes.frequency[moving, None] ** 2)
    braked, damped = np.zeros_like(shape), np.zeros_like(twist)
    if isinstance(modes, LineModes):
        pole = modes.pole[moving, None]
        square, braked = pole**2, pole * line.absolute_damping
        damped = pole * (line.damping + loss * stiffness / np.abs(pole))
    inertial = square * line.inertia
    dynamic = network_matrix(line, stiffness + damped, inertial + braked + line.ground_stiffness)
    # a share of the squared frequency: half of the pole times its derivative
    slope = network_matrix(line, 0.5 * damped, inertial + 0.5 * braked)
    matrix = np.zeros((len(shape), count + 1, count + 1), dtype=dynamic.dtype)
    place = np.arange(count)
    # rows and columns of one size
    scale = 1.0 / np.sqrt(np.abs(dynamic[:, place, place]) + np.abs(inertial) + 1e-300)
    matrix[:, :count, :count] = dynamic * scale[:, :, None] * scale[:, None, :]
    matrix[:, :count, count] = np.einsum("mij,mj->mi", slope, shape) * scale
    top = np.argmax(np.abs(shape[:, :stations]), axis=1)
    matrix[np.arange(len(shape)), count, top] = 1.0
    moved = np.zeros((len(moving), count + 1, 1 + 3 * count + 2 * len(first)), dynamic.dtype)
    try:
        answer = np.linalg.inv(matrix)[..., :count]
    except np.linalg.LinAlgError:  # equal frequencies: their shapes are any of a space
        moved[moving] = np.inf
        return ShapeUncertainty(modes.shape_error, moved, counted)
    answer[:, :count] *= scale[:, :, None]
    answer = answer * scale[:, None, :]
    of_element = answer[..., first] - answer[..., second]
    torques = (
        (answer, -inertial * shape), (of_element, stiffness * twist),
        (answer, line.ground_stiffness * shape), (of_element, damped * twist),
        (answer, braked * shape),
    )  # fmt: skip
    parts = np.concatenate([moves * torque[:, None, :] for moves, torque in torques], axis=-1)
    left = parts[..., :count].sum(axis=-1) - parts[..., count:].sum(axis=-1)
    errors = np.concatenate([CORRECTIONS * left[..., None], ROUNDINGS * EPSILON * parts], axis=-1)
    moved[moving] = np.where(np.isfinite(errors), errors, np.inf)
    return ShapeUncertainty(modes.shape_error, moved, counted)


def uncertainty_of(uncertainty: ShapeUncertainty, weight: FloatArray | ComplexArray) -> FloatArray:
    """Errors (m, q) of sums of the angles with weights (m, q, n) or (q, n) of no common sign."""
    size = np.abs(weight)
    bound = uncertainty.bound[:, None] * np.sqrt(np.sum(np.square(size), axis=-1))
    if uncertainty.moved.shape[-1]:
        measured = spread(weight @ uncertainty.moved[:, :-1])
        bound = np.minimum(bound, measured)
    return np.asarray(bound * uncertainty.moving[:, None])


def angle_uncertainty(uncertainty: ShapeUncertainty) -> FloatArray:
    """Errors (m, n) of the angles."""
    bound = np.broadcast_to(
        uncertainty.bound[:, None], (len(uncertainty.bound), uncertainty.moved.shape[1] - 1)
    )
    if uncertainty.moved.shape[-1]:
        bound = np.minimum(bound, spread(uncertainty.moved[:, :-1]))
    return np.asarray(bound * uncertainty.moving[:, None])


def spread(moved: FloatArray | ComplexArray) -> FloatArray:
    """Size of moves (..., p): the first in full, the others as what has no common sign."""
    rounding = np.sqrt(np.sum(np.square(np.abs(moved[..., 1:])), axis=-1))
    total = np.abs(moved[..., 0]) + rounding
    return np.asarray(np.where(np.isfinite(total), total, np.inf))


# ----------------------------------------------------------------------------
# Errors of Holzer tables at natural frequencies, from what moves the shapes.
# ----------------------------------------------------------------------------


class Angles(NamedTuple):
    """A table of m modes and r rows: `angle` and `inertia_w2` (m, r), angles by `unit` (m, 1).

    `unit` is the angle of the first row, or 1 where that is `still` (m, 1).
    """

    line: Line
    rows: HolzerRows
    unit: FloatArray
    still: BoolArray
    angle: FloatArray
    inertia_w2: FloatArray


def measured(
    table: Angles, uncertainty: ShapeUncertainty
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Errors (m, r) of angles, torques of the inertias and their sums, as far as moves are known.

    Each move of the shapes is carried down the table, so that what is common to the angles of a
    part in which a mode fades stays so.
    """
    line, rows, angle = table.line, table.rows, table.angle
    place, freedom, count = np.arange(len(rows.freedom)), rows.freedom, len(line.inertia)
    once = ROUNDINGS * EPSILON
    with np.errstate(invalid="ignore"):  # infinite moves tell nothing, and are no bound
        moved = uncertainty.moved[:, freedom] / table.unit[..., None]
        first = np.where(table.still[..., None], 0.0, moved[:, :1])
        moved = moved - angle[..., None] * first
        frequency = uncertainty.moved[:, -1:]
        inertial = table.inertia_w2[..., None] * (moved + angle[..., None] * frequency)
        torque = table.inertia_w2 * angle
        inertial[:, place, 1 + freedom] += once * torque
        held = line.ground_stiffness[freedom] * angle
        total = inertial - line.ground_stiffness[freedom][:, None] * moved
        total[:, place, 1 + count + len(line.first) + freedom] -= once * held
        size = torque - held
        for row, below in enumerate(rows.below[:-1].tolist()):
            total[:, below] += total[:, row]
            size[:, below] += size[:, row]
        sums = np.abs(size)
        for row, below in enumerate(rows.below[:-1].tolist()):
            sums[:, below] += sums[:, row]
        errors = spread(moved), spread(inertial), spread(total)
    rounding = np.abs(angle), np.abs(torque), sums
    moving = uncertainty.moving[:, None]
    return tuple(  # type: ignore[return-value]
        np.where(moving > 0.0, one + 2.0 * EPSILON * size, np.inf)
        for one, size in zip(errors, rounding, strict=True)
    )
