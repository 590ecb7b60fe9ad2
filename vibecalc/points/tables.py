"""The tables [[point]] and [vibration_severity] of a case."""

import math
from typing import Annotated

from pydantic import Field

from vibecalc.core.case.fields import Frequency, Name, Number, Point, Table, Unit, key
from vibecalc.core.case.rules import Row, ascending, at_most_one, pair_ordered, refuse, same_length
from vibecalc.points.results import UNITS

# ----------------------------------------------------------------------------
# Where vibration is measured.
# ----------------------------------------------------------------------------

Velocity = Annotated[float, Field(gt=0), Unit("m/s")]
Displacement = Annotated[float, Field(gt=0), Unit("m")]
Acceleration = Annotated[float, Field(gt=0), Unit("m/s^2")]
Few = Field(min_length=2, max_length=3)
Vector = tuple[Number, Number, Number]


class MeasuringPoint(Table):
    """A measuring point on the body, read along x, y and z."""

    name: Name = key("label in tables and `where`")
    position: Point = key("from the body's reference point")
    direction: Vector | None = key(
        "of a single sensor, of any length; default: three sensors along x, y and z", None
    )
    axes: tuple[Vector, Vector, Vector] | None = key(
        "of three sensors 1, 2 and 3, at right angles; default: x, y and z", None
    )
    RULES = (at_most_one("direction", "axes"),)


Points = Annotated[tuple[MeasuringPoint, ...], Field(max_length=200)]

# ----------------------------------------------------------------------------
# How severe a vibration is.
# ----------------------------------------------------------------------------

_QUANTITIES = "velocity displacement acceleration"
#: 2 to 1000 Hz, rad/s
BAND = (2.0 * math.pi * 2.0, 2.0 * math.pi * 1000.0)
#: the edition whose grades are built in, and their names: mm/s, rounded
GRADED = "ISO 10816-6:1995"
GRADES = (1.1, 1.8, 2.8, 4.5, 7.1, 11.0, 18.0, 28.0, 45.0, 71.0, 112.0, 180.0)


def _unknown_grade(row: Row) -> bool:
    return any(isinstance(one, int | float) and one not in GRADES for one in row.entries("grades"))


class VibrationSeverity(Table):
    """Band of the r.m.s. values, and evaluation zones; informative."""

    standard: Name = key("standard and edition of the zones", GRADED)
    band: tuple[Frequency, Frequency] = key(
        "frequency band of the r.m.s. values; default: 2 to 1000 Hz", BAND
    )
    grades: Annotated[tuple[Number, ...], Few] | None = key(
        "severity grades at the limits of zones A, B, C and D, or A/B, C and D", None
    )
    velocity: Annotated[tuple[Velocity, ...], Few] | None = key(
        "instead, r.m.s. values at the zone limits, two or three", None
    )
    displacement: Annotated[tuple[Displacement, ...], Few] | None = key(
        "r.m.s. values at the zone limits", None
    )
    acceleration: Annotated[tuple[Acceleration, ...], Few] | None = key(
        "r.m.s. values at the zone limits", None
    )
    RULES = (
        at_most_one("grades", _QUANTITIES),
        pair_ordered("band", equal=False),
        *(ascending(key) for key in ("grades", *_QUANTITIES.split())),
        same_length(*_QUANTITIES.split(), what="vibration_severity"),
        refuse(
            "grades",
            "no such severity grade",
            _unknown_grade,
            ", ".join(f"{one:g}" for one in GRADES),
            found="{grades}",
            hint="other boundaries are velocity, displacement and acceleration, r.m.s.",
        ),
        refuse(
            "grades",
            "the grades are those of another standard",
            lambda t: "grades" in t and t["standard"] not in (None, GRADED),
            f"standard = '{GRADED}', or velocity, displacement and acceleration",
            found="standard = {standard!r}",
            also="standard",
        ),
    )


def zoned(severity: VibrationSeverity | None) -> list[str]:
    """Quantities that have boundaries between zones."""
    if severity is None:
        return []
    return [name for name in UNITS if severity.grades or getattr(severity, name)]
