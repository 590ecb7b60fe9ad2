"""Results of bearing loads: crank pins, wrist pins, cylinder walls, main bearings."""

from collections.abc import Iterator

from vibecalc.core.results.record import CYCLE, PLACE, TURN, Entry, Headline, entry

ROOT = "bearing_loads"
AXES = {
    "main_bearing": ("", "main bearing"),
    "of_throw": ("", "axis that turns with the throw"),
}
#: axis of a crank pin's own load: away from the crank axis, and a quarter of a turn ahead of that
NAMES = {"of_throw": ("outward", "ahead")}


def _loads(part: str, axis: str, what: str, name: str) -> Iterator[Entry]:
    """Force over the cycle, its highest and its mean, of one kind of bearing."""
    path = f"{ROOT}/{part}"
    turning = part == "crank_pin"
    reference = "the throw" if turning else "the stroke"
    yield entry(f"{path}/force", f"{axis} direction crank_angle", "N", what)
    if turning:
        yield entry(
            f"{path}/force_of_throw", f"{axis} of_throw crank_angle", "N",
            "the same in axes that turn with the throw",
        )  # fmt: skip
    yield entry(
        f"{path}/peak", axis, "N", f"highest over the cycle, {what}",
        headline=Headline(name, "kN"),
    )  # fmt: skip
    yield entry(
        f"{path}/peak_angle", axis, "rad", "crank angle of the highest", exempt=PLACE, circle=CYCLE
    )
    yield entry(
        f"{path}/peak_direction", axis, "rad",
        f"of the highest, from {reference} in the sense of rotation", exempt=PLACE, circle=TURN,
    )  # fmt: skip
    yield entry(f"{path}/mean", axis, "N", "mean magnitude over the cycle")
    yield entry(f"{path}/mean_force", f"{axis} direction", "N", "mean over the cycle, as a vector")
    yield entry(f"{path}/peak_pressure", axis, "Pa", "highest load over diameter times length")
    yield entry(f"{path}/mean_pressure", axis, "Pa", "mean load over diameter times length")


ENTRIES = (
    *_loads("main", "main_bearing", "force of the shaft on the main bearing",
            "main bearing load, peak"),
    *_loads("crank_pin", "cylinder", "force of the rod on the crank pin", "crank pin load, peak"),
    *_loads("wrist_pin", "cylinder", "force of the piston on the rod", "wrist pin load, peak"),
    entry(
        f"{ROOT}/side_thrust/force", "cylinder crank_angle", "N",
        "of the piston on the cylinder, positive ahead in the sense of rotation",
        curve="side_thrust", name="side thrust",
    ),
    entry(
        f"{ROOT}/side_thrust/peak", "cylinder", "N", "largest side thrust over the cycle",
        headline=Headline("side thrust of a piston, peak", "kN"),
    ),
    entry(f"{ROOT}/side_thrust/peak_angle", "cylinder", "rad", "crank angle of it", exempt=PLACE,
          circle=CYCLE),
    entry(
        f"{ROOT}/speeds/main_peak", "main_bearing speed", "N",
        "highest load of a main bearing over the cycle", curve="bearing_loads_over_speed",
        name="main bearings",
    ),
    entry(
        f"{ROOT}/speeds/crank_pin_peak", "cylinder speed", "N",
        "highest load of a crank pin over the cycle", curve="bearing_loads_over_speed",
        name="crank pins",
    ),
)  # fmt: skip
