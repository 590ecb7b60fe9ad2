"""Holzer's tables of a shaft line at any frequency."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, FloatArray, IntArray
from vibecalc.torsion.line import Line, connected_parts, lines_of, walk

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
