"""Bearing loads in the report: highest and mean load of each bearing, where they stand."""

from vibecalc.bearings.results import CrankPin, MainLoad, SideThrust, WristPin
from vibecalc.core.report.rows import by_axis
from vibecalc.core.report.sections import Section, section, together
from vibecalc.core.report.writing import paragraph
from vibecalc.core.results.record import Result


def bearing_loads(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    blocks, shown = [], {path for path in record if path.startswith("bearing_loads/")}
    if not shown:
        return None
    for group in (MainLoad, CrankPin, WristPin):
        path, axis = group.ROOT, group.WORDS["bearing"]
        origin = "from throw" if group is CrankPin else ""
        names = [
            (f"{path}/peak", "peak\n", "kN"),
            (f"{path}/peak_angle", "at crank\nangle", "deg"),
            (f"{path}/peak_direction", f"direction\n{origin}", "deg"),
            (f"{path}/mean", "mean\n", "kN"),
            (f"{path}/peak_pressure", "peak\npressure", "MPa"),
            (f"{path}/mean_pressure", "mean\npressure", "MPa"),
        ]
        title = group.WORDS["load"] + " of" * (axis == "cylinder")
        blocks.append(by_axis(record, axis, title, names, digits=5))
    names = [
        (f"{SideThrust.ROOT}/peak", "side thrust", "kN"),
        (f"{SideThrust.ROOT}/peak_angle", "at crank angle", "deg"),
    ]
    blocks.append(by_axis(record, "cylinder", "piston of", names, digits=5))
    words = paragraph(
        "main bearings: each bay of the crankshaft on two supports, bending over several bearings "
        "and clearances left out; directions count in the sense of rotation, from the stroke or, "
        "of crank pins, from the throw; pressures are loads over diameter times length"
    )
    return section("Loads on bearings", [together(*blocks, words)], shown=shown)
