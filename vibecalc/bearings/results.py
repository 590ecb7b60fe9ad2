"""Results of bearing loads: crank pins, wrist pins, cylinder walls, main bearings."""

from typing import Any, ClassVar

from vibecalc.core.results.described import Group, entries_of, lead, q
from vibecalc.core.results.record import CYCLE, PLACE, TURN

# ----------------------------------------------------------------------------
# Force over the cycle, its highest and its mean, of each kind of bearing.
# ----------------------------------------------------------------------------


def _words(
    load: str, what: str, bearing: str = "cylinder", reference: str = "the stroke"
) -> dict[str, str]:
    return {"load": load, "what": what, "bearing": bearing, "reference": reference}


class BearingLoad(Group):
    """Of one kind of bearing, the `load`, whose axis is `bearing`; directions count from the
    `reference`.
    """

    WORDS: ClassVar[dict[str, str]]
    force: Any = q("{bearing} direction crank_angle", "N", "{what}")
    peak: Any = lead("{bearing}", "N", "{load} load, peak", read="kN", about="{what}")
    peak_angle: Any = q(
        "{bearing}", "rad", "crank angle of the peak load", exempt=PLACE, circle=CYCLE
    )
    peak_direction: Any = q(
        "{bearing}", "rad", "direction of the peak load, from {reference} in the sense of rotation",
        exempt=PLACE, circle=TURN,
    )  # fmt: skip
    mean: Any = q("{bearing}", "N", "mean magnitude over the cycle")
    mean_force: Any = q("{bearing} direction", "N", "mean force vector over the cycle")
    peak_pressure: Any = q(
        "{bearing}", "Pa", "peak load / (diameter x length)", name="peak pressure, {load}"
    )
    mean_pressure: Any = q("{bearing}", "Pa", "mean load / (diameter x length)")


class MainLoad(BearingLoad):
    """Of the bearings of the crankshaft."""

    ROOT = "bearing_loads/main"
    WORDS = _words("main bearing", "force of the shaft on the main bearing", "main_bearing")


class CrankPin(BearingLoad):
    """Of the big ends of the rods."""

    ROOT: ClassVar[str] = "bearing_loads/crank_pin"
    WORDS = _words("crank pin", "force of the rod on the crank pin", reference="the throw")
    force_of_throw: Any = q(
        "cylinder of_throw crank_angle", "N", "the same in axes that turn with the throw"
    )


class WristPin(BearingLoad):
    """Of the small ends of the rods."""

    ROOT = "bearing_loads/wrist_pin"
    WORDS = _words("wrist pin", "force of the piston on the rod")


# ----------------------------------------------------------------------------
# Cylinder walls; bearings over the speed.
# ----------------------------------------------------------------------------


class SideThrust(Group):
    """Of the pistons on the walls."""

    ROOT: ClassVar[str] = "bearing_loads/side_thrust"
    force: Any = q(
        "cylinder crank_angle", "N",
        "force of the piston on the cylinder, positive in the sense of rotation",
        curve="side_thrust", name="side thrust",
    )  # fmt: skip
    peak: Any = lead("cylinder", "N", "side thrust of a piston, peak", read="kN")
    peak_angle: Any = q("cylinder", "rad", "crank angle of the peak", exempt=PLACE, circle=CYCLE)


class OverSpeeds(Group):
    """Highest loads of bearings at each speed."""

    ROOT: ClassVar[str] = "bearing_loads/speeds"
    main_peak: Any = q(
        "main_bearing speed", "N", "peak load of a main bearing over the cycle",
        curve="bearing_loads_over_speed", name="main bearings",
    )  # fmt: skip
    crank_pin_peak: Any = q(
        "cylinder speed", "N", "peak load of a crank pin over the cycle",
        curve="bearing_loads_over_speed", name="crank pins",
    )  # fmt: skip


AXES = {
    "main_bearing": ("", "main bearing"),
    "of_throw": ("", "axis that turns with the throw"),
}
#: axis of a crank pin's own load: away from the crank axis, and a quarter of a turn ahead of that
NAMES = {"of_throw": ("outward", "ahead")}
ENTRIES = tuple(entries_of(MainLoad, CrankPin, WristPin, SideThrust, OverSpeeds))
