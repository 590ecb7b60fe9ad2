"""The table [bearing_loads] of a case: main bearings, sizes, what else loads the crankshaft."""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from vibecalc.core.case.fields import AngularSpeed, Force, Length, Mass, Name, RunUp, Table
from vibecalc.core.case.raw import table_at
from vibecalc.core.case.rules import Row, needs, one_of, ordered, refuse, unique
from vibecalc.errors import Problem


class BearingSize(Table):
    """Size of a bearing, for its mean specific pressure."""

    diameter: Length = Field(gt=0, description="of the journal")
    length: Length = Field(gt=0, description="that carries")


class MainBearing(Table):
    """A main bearing of the crankshaft."""

    name: Name = Field(description="label used in tables and in `where`")
    position: Length = Field(description="of its middle along the crankshaft, as of the cylinders")
    diameter: Length | None = Field(None, gt=0, description="of the journal")
    length: Length | None = Field(None, gt=0, description="that carries")
    RULES = (needs("diameter", "length"), needs("length", "diameter"))


class ShaftLoad(Table):
    """What loads the crankshaft at rest as it does in motion: a weight, the pull of a belt."""

    name: Name = Field(description="label")
    position: Length = Field(description="along the crankshaft, as of the cylinders")
    mass: Mass | None = Field(None, gt=0, description="of a flywheel, a pulley: its weight")
    force: tuple[Force, Force, Force] | None = Field(
        None, description="on the crankshaft along x, y, z, none along the shaft"
    )
    RULES = (one_of("mass", "force"),)


class BearingSpeeds(RunUp):
    """Crank speeds at which the highest loads of a cycle are wanted."""

    start: AngularSpeed = Field(alias="from", gt=0, description="lowest speed")
    points: Annotated[int, Field(strict=True, ge=2, le=401)] = Field(
        41, description="evenly spaced, both ends included"
    )
    RULES = (ordered("from", "to", "speeds go from a lower one to a higher one"),)


def _sizes(row: Row) -> Iterator[Problem]:
    """Sizes of all main bearings or of none."""
    bearings = row.each("main_bearings")
    sized = [one for one in bearings if "diameter" in one]
    for one in bearings if sized else ():
        if "diameter" not in one and "length" not in one:
            yield one.problem(
                "",
                "this main bearing has no diameter and length, and others have",
                allowed="both for each main bearing, or for none",
                also=(*sized[0].path, "diameter"),
            )


class BearingLoads(Table):
    """Loads on the bearings of the crank train over a cycle, at the operating speed."""

    main_bearings: tuple[MainBearing, ...] = Field(
        min_length=2, max_length=65, description="of the crankshaft, each with its place"
    )
    crank_pin: BearingSize | None = Field(None, description="of each rod's big end")
    wrist_pin: BearingSize | None = Field(None, description="of each rod's small end")
    shaft_loads: Annotated[tuple[ShaftLoad, ...], Field(max_length=64)] = Field(
        (), description="constant loads on the crankshaft, such as the weight of the flywheel"
    )
    up: Literal["x", "-x", "y", "-y", "z", "-z"] | None = Field(
        None,
        description="direction against which weights act; default: as in [isolation], or without "
        "it that of the stroke",
    )
    crank_angles: Annotated[int, Field(strict=True, ge=73, le=7201)] = Field(
        361, description="at which the forces over a cycle are written, both ends included"
    )
    speeds: BearingSpeeds | None = Field(
        None, description="highest loads over a range of speeds as well"
    )
    RULES = (
        unique("main_bearings"),
        unique("shaft_loads"),
        unique("main_bearings", "main bearings", "position"),
        _sizes,
        "vibecalc.parts.rules:gas_of_bearings",
        refuse(
            "",
            "bearings bear the whole force of the rod, and tangential_effort has only its torque",
            lambda t: "tangential_effort" in table_at(t.machine, "crank_train"),
            "gas_pressure, gas_cards or gas_cycle in [machine.crank_train]",
            also=("machine", "crank_train", "tangential_effort"),
        ),
        refuse(
            ("kinematics", "series"),
            "bearing loads follow from the exact motion of piston and rod",
            lambda t: table_at(t.case, "kinematics").get("series") == "truncated",
            "series = 'exact', or no [bearing_loads]",
            found="series = 'truncated'",
            also="",
        ),
    )
