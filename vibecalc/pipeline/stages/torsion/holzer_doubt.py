"""Errors of Holzer tables at natural frequencies, from what moves the shapes."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import BoolArray, FloatArray
from vibecalc.response.torsion.holzer import HolzerRows
from vibecalc.response.torsion.line import Line
from vibecalc.response.torsion.modes_doubt import ROUNDINGS, ShapeDoubt, spread


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


def measured(table: Angles, doubt: ShapeDoubt) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Errors (m, r) of angles, torques of the inertias and their sums, as far as moves are known.

    Each move of the shapes is carried down the table, so that what is common to the angles of a
    part in which a mode fades stays so.
    """
    line, rows, angle = table.line, table.rows, table.angle
    place, freedom, count = np.arange(len(rows.freedom)), rows.freedom, len(line.inertia)
    once = ROUNDINGS * EPSILON
    with np.errstate(invalid="ignore"):  # infinite moves tell nothing, and are no bound
        moved = doubt.moved[:, freedom] / table.unit[..., None]
        first = np.where(table.still[..., None], 0.0, moved[:, :1])
        moved = moved - angle[..., None] * first
        frequency = doubt.moved[:, -1:]
        own = table.inertia_w2[..., None] * (moved + angle[..., None] * frequency)
        torque = table.inertia_w2 * angle
        own[:, place, 1 + freedom] += once * torque
        held = line.ground_stiffness[freedom] * angle
        total = own - line.ground_stiffness[freedom][:, None] * moved
        total[:, place, 1 + count + len(line.first) + freedom] -= once * held
        size = torque - held
        for row, below in enumerate(rows.below[:-1].tolist()):
            total[:, below] += total[:, row]
            size[:, below] += size[:, row]
        sums = np.abs(size)
        for row, below in enumerate(rows.below[:-1].tolist()):
            sums[:, below] += sums[:, row]
        errors = spread(moved), spread(own), spread(total)
    rounding = np.abs(angle), np.abs(torque), sums
    moving = doubt.moving[:, None]
    return tuple(  # type: ignore[return-value]
        np.where(moving > 0.0, one + 2.0 * EPSILON * size, np.inf)
        for one, size in zip(errors, rounding, strict=True)
    )
