"""Holzer's table of a line at any frequency, branch by branch, with the torque left at the end."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.response.torsion.graph import pieces, walk
from vibecalc.response.torsion.line import Line


class HolzerRows(NamedTuple):
    """Order of the n rows of a table: `freedom` (n,) of the line, `below` (n,) the row that each
    one's shaft leads to (-1 for the last), `stiffness` (n - 1,) of that shaft in N m/rad.

    From the first end along the main row; before the row of a junction stand those of the
    branches on it, each from its own end on. In a plain row `below` is always the next row.
    """

    freedom: IntArray
    below: IntArray
    stiffness: FloatArray


class HolzerTable(NamedTuple):
    """One row for each of n stations in the order of `rows`, leading axes those of the frequency.

    `inertia` (n,) in kg m^2, `inertia_w2` (..., n) in N m/rad, `angle` (..., n) in rad, 1 in the
    first row, `torque_of_inertia` = J w^2 angle and `sum_torque` (..., n) in N m, that with the
    sums of the rows whose shafts lead here, less what springs to ground take; `twist` (..., n - 1)
    of the shaft that leads on. `residual` (...) is the last sum: the torque that keeps the motion
    going, zero at a natural frequency; `residual_error` (...) its rounding.
    """

    rows: HolzerRows
    inertia: FloatArray
    inertia_w2: FloatArray
    angle: FloatArray
    torque_of_inertia: FloatArray
    sum_torque: FloatArray
    twist: FloatArray
    residual: FloatArray
    residual_error: FloatArray


def holzer_rows(line: Line) -> HolzerRows:
    """Rows of the piece with most stations, from its end nearest to the first station.

    The main row leads to the end that is farthest from it. Parallel shafts count as one. Raises
    `NumericalFailure` for closed loops and for a piece without any inertia.
    """
    piece = max(pieces(line), key=lambda one: len(one.spring))
    if not piece.is_tree:
        raise NumericalFailure("a Holzer table is of a line without closed loops of shafts")
    start = next(s for s, others in piece.spring.items() if len(others) < 2)
    towards = walk(piece.spring, start)
    end = list(towards)[-1]
    parent = walk(piece.spring, end)
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
        np.array([piece.spring[station][parent[station]] for station in order[:-1]]),
    )


def holzer_table(line: Line, frequency: ArrayLike) -> HolzerTable:
    """The table at frequencies (...) in rad/s; a branch takes the angle of the junction it is on.

    Far from a natural frequency of a long row the angles grow from station to station; this is a
    table to be read, frequencies are found by counting (`count.py`). Raises `NumericalFailure` as
    `holzer_rows`, for angles beyond the range of numbers, and where a junction that a branch hangs
    on stands still.
    """
    rows = holzer_rows(line)
    inertia, ground = line.inertia[rows.freedom], line.ground_stiffness[rows.freedom]
    inertia_w2 = np.asarray(frequency, dtype=float)[..., None] ** 2 * inertia
    count = len(inertia)
    angle, total = np.ones(inertia_w2.shape), np.zeros(inertia_w2.shape)
    angle_error, error = np.zeros_like(angle), np.zeros_like(angle)
    rate = np.abs(inertia_w2 - ground)
    above: list[list[int]] = [[] for _ in range(count)]  # rows that lead here
    branch: list[list[int]] = []  # rows that move with each one, itself included
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        for i in range(count):
            branch.append([i])
            for place, j in enumerate(above[i]):
                twist = total[..., j] / rows.stiffness[j]
                reached = angle[..., j] - twist
                doubt = angle_error[..., j] + error[..., j] / rows.stiffness[j]
                doubt = doubt + EPSILON * (np.abs(twist) + np.abs(reached))
                if place == 0:
                    angle[..., i], angle_error[..., i] = reached, doubt
                else:
                    if np.any(np.abs(reached) <= doubt):
                        raise NumericalFailure(
                            "a branch swings against a junction that stands still: its Holzer "
                            "table cannot be joined to that of the line"
                        )
                    factor = angle[..., i] / reached
                    off = (angle_error[..., i] + np.abs(factor) * doubt) / np.abs(reached)
                    for row in branch[j]:
                        error[..., row] = np.abs(factor) * error[..., row]
                        error[..., row] += off * np.abs(total[..., row])
                        angle[..., row] *= factor
                        total[..., row] *= factor
                total[..., i] += total[..., j]
                error[..., i] += error[..., j]
                branch[i] += branch[j]
            own, to_ground = inertia_w2[..., i] * angle[..., i], ground[i] * angle[..., i]
            total[..., i] += own - to_ground
            size = np.abs(own) + np.abs(to_ground) + np.abs(total[..., i])
            error[..., i] += rate[..., i] * angle_error[..., i]
            error[..., i] += (2.0 + len(above[i])) * EPSILON * size
            if i < count - 1:
                above[rows.below[i]].append(i)
    if not np.all(np.isfinite(total)):
        raise NumericalFailure("the angles of the Holzer table leave the range of numbers")
    twist = total[..., :-1] / rows.stiffness
    own = inertia_w2 * angle
    last = total[..., -1]
    return HolzerTable(rows, inertia, inertia_w2, angle, own, total, twist, last, error[..., -1])
