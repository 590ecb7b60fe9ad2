"""The table [bearing_loads] of a case: main bearings, sizes, what else loads the crankshaft."""

from collections.abc import Iterator
from typing import Literal

from vibecalc.core.case.fields import AngularSpeed, Force, Length, Mass, Name, RunUp, Table, key
from vibecalc.core.case.raw import table_at
from vibecalc.core.case.rules import Row, needs, one_of, ordered, refuse, unique
from vibecalc.errors import Problem


class BearingSize(Table):
    """Size of a bearing, for its mean specific pressure."""

    diameter: Length = key("of the journal", gt=0)
    length: Length = key("bearing length", gt=0)


class MainBearing(Table):
    """A main bearing of the crankshaft."""

    name: Name = key("label in tables and `where`")
    position: Length = key("of its centre along the crankshaft, as for the cylinders")
    diameter: Length | None = key("of the journal", None, gt=0)
    length: Length | None = key("that carries", None, gt=0)
    RULES = (needs("diameter", "length"), needs("length", "diameter"))


class ShaftLoad(Table):
    """Constant load on the crankshaft, such as a weight or a belt pull."""

    name: Name = key("label")
    position: Length = key("along the crankshaft, as for the cylinders")
    mass: Mass | None = key("of a flywheel or pulley, for its weight", None, gt=0)
    force: tuple[Force, Force, Force] | None = key(
        "on the crankshaft along x, y, z, none along the shaft", None
    )
    RULES = (one_of("mass", "force"),)


class BearingSpeeds(RunUp):
    """Crank speeds for the maximum loads of a cycle."""

    start: AngularSpeed = key("lowest speed", alias="from", gt=0)
    points: int = key(
        "number of points, evenly spaced, ends included", 41, strict=True, ge=2, le=401
    )
    RULES = (ordered("from", "to", "speeds must go from a lower to a higher one"),)


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

    main_bearings: tuple[MainBearing, ...] = key(
        "main bearings with their positions", min_length=2, max_length=65
    )
    crank_pin: BearingSize | None = key("size of the big-end bearings", None)
    wrist_pin: BearingSize | None = key("size of the small-end bearings", None)
    shaft_loads: tuple[ShaftLoad, ...] = key(
        "constant loads on the crankshaft, such as the weight of the flywheel", (), max_length=64
    )
    up: Literal["x", "-x", "y", "-y", "z", "-z"] | None = key(
        "vertical direction, upwards; default: as in [isolation], otherwise the stroke",
        None,
    )
    crank_angles: int = key(
        "number of crank angles of the loads over a cycle, ends included",
        361,
        strict=True,
        ge=73,
        le=7201,
    )
    speeds: BearingSpeeds | None = key("also maximum loads over a speed range", None)
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
