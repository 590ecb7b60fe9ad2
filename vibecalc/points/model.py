"""What is read at the points of a case: places, directions and names of the readings."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from vibecalc.errors import Problem
from vibecalc.kinds import gas_turns
from vibecalc.numerics.rounding import FloatArray
from vibecalc.parts.body import DIRECTIONS
from vibecalc.parts.firing import driven_machine, has_gas, table_that_moves, with_torque
from vibecalc.parts.matrices import displacement_at
from vibecalc.parts.mount_needs import moves_with_machine
from vibecalc.points.results import UNITS
from vibecalc.points.severity import grade
from vibecalc.points.tables import BAND, GRADES, MeasuringPoint, VibrationSeverity, zoned
from vibecalc.schema import Case

#: cosine of the angle between two axes above which they are not square to each other
_SQUARE = 1e-6
_DIRECTION = ("direction", "a direction of length zero", "[0, 0, 1], e.g.")
_AXES = (
    "axes",
    "the axes of a point must be at right angles, none of length zero",
    "[[1, 0, 0], [0, 1, 0], [0, 0, 1]], e.g., or a direction for one sensor alone",
)
QUANTITIES = tuple(UNITS)


class Readings(NamedTuple):
    """Readings (r,) by name.

    `row` (r, 6) takes translation and rotation of the body, x y z rx ry rz about its reference
    point, to the displacement along the direction of the reading.
    """

    names: tuple[str, ...]
    row: FloatArray


def directions_of(point: MeasuringPoint) -> dict[str, FloatArray]:
    """Unit vectors (3,) of the readings of a point, by the name of each."""
    if point.direction is not None:
        return {point.name: _unit(np.array(point.direction))}
    if point.axes is not None:
        return {f"{point.name} {i + 1}": _unit(axis) for i, axis in enumerate(np.array(point.axes))}
    return {f"{point.name} {name}": np.eye(3)[i] for i, name in enumerate(DIRECTIONS)}


def _unit(vector: FloatArray) -> FloatArray:
    """Of length 1; a vector of length zero stays."""
    scaled = vector / max(np.max(np.abs(vector)), np.finfo(float).tiny)
    return np.asarray(scaled / max(np.linalg.norm(scaled), np.finfo(float).tiny))


def readings_of(case: Case) -> Readings:
    """The readings of all points, in the order of the case."""
    every = [
        (name, direction @ displacement_at(np.array(point.position, dtype=float)))
        for point in case.point
        for name, direction in directions_of(point).items()
    ]
    names, rows = tuple(name for name, _ in every), [row for _, row in every]
    return Readings(names, np.reshape(rows, (-1, 6)))


def band_of(case: Case) -> tuple[float, float]:
    """Frequencies in rad/s between which orders count in r.m.s. values, both included."""
    return BAND if case.vibration_severity is None else case.vibration_severity.band


def boundaries_of(severity: VibrationSeverity) -> dict[str, FloatArray]:
    """Boundaries of the zones by quantity, r.m.s. in SI; none without zones."""
    grades = [grade(GRADES.index(one)) for one in severity.grades or ()]
    return {
        name: np.array([one[name] for one in grades] or getattr(severity, name))
        for name in zoned(severity)
    }


# ----------------------------------------------------------------------------
# Can the points of this case be read?
# ----------------------------------------------------------------------------


def points_problems(case: Case) -> Iterator[Problem]:
    """Problems of what the points need, and of names that two readings share."""
    machine = case.machine
    if not case.point:
        yield Problem(
            path=("vibration_severity",),
            message="[vibration_severity] needs points",
            allowed="[[point]] with name and position",
        )
    elif machine.body is None or machine.mounts is None:
        yield Problem(
            path=("point",),
            message="[[point]] needs a body on mounts",
            allowed="[machine.body], [machine.mounts] and [isolation]",
        )
    elif case.isolation is None and case.response is None:
        yield Problem(
            path=("point",),
            message="[[point]] needs the motion of the body",
            allowed='[isolation] with model = "rigid_body", "planar" or "pitch", or [response]',
        )
    taken: dict[str, int] = {}
    for number, point in enumerate(case.point):
        directions = directions_of(point)
        rows = np.array([*directions.values()])
        if np.any(np.abs(rows @ rows.T - np.eye(len(rows))) > _SQUARE):
            key, message, allowed = _AXES if point.direction is None else _DIRECTION
            yield Problem(path=("point", number, key), message=message, allowed=allowed)
        for name in directions:
            if taken.setdefault(name, number) != number:
                yield Problem(
                    path=("point", number, "name"),
                    message="two sensors have the same name",
                    found=repr(name),
                    allowed="names of points that do not end in the axis of another one",
                    also=("point", taken[name], "name"),
                )


def points_cautions(case: Case) -> list[str]:
    """What the motion of the points lacks."""
    texts = {
        "the vibration at points is computed without the torque of the gas on the body: "
        "[isolation] with model = 'rigid_body' or 'planar' includes it, where the case says when "
        "the cylinders fire": _without_torque(case),
        "the vibration at points is that of the machine on a rigid foundation: a [foundation] of "
        "one mass moves up and down only, one with a body or flexibilities moves the points too": (
            case.foundation is not None and not moves_with_machine(case)
        ),
        "points/ has the vibration by the running machine alone: that of the same points by the "
        "motion of the base is in base_motion/": case.base_motion is not None,
    }
    return [text for text, holds in texts.items() if holds]


def _without_torque(case: Case) -> bool:
    if not gas_turns(case.machine) or not has_gas(case):
        return False
    if table_that_moves(case) in with_torque(case):
        return False
    return driven_machine(case) != "cancels_torque"
