"""Bearing loads in the report: highest and mean load of each bearing, where they stand."""

from vibecalc.bearings.results import CrankPin, MainLoad, SideThrust, WristPin
from vibecalc.core.report.rows import Cells, Rows, rows_of
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
        axis, origin = group.WORDS["bearing"], "from throw" if group is CrankPin else ""
        columns = [
            Cells("peak", "peak\nkN", "kN"),
            Cells("peak_angle", "at crank\nangle deg", "deg"),
            Cells("peak_direction", f"direction\n{origin} deg".replace("\n ", "\n"), "deg"),
            Cells("mean", "mean\nkN", "kN"),
            Cells("peak_pressure", "peak\npressure MPa", "MPa"),
            Cells("mean_pressure", "mean\npressure MPa", "MPa"),
        ]
        title = group.WORDS["load"] + " of" * (axis == "cylinder")
        of = Rows(axis, title, columns, group.ROOT, digits=5, merge=True)
        blocks.append(rows_of(record, of))
    thrust = (Cells("peak", "side thrust kN", "kN"),
              Cells("peak_angle", "at crank angle deg", "deg"))  # fmt: skip
    of = Rows("cylinder", "piston of", thrust, SideThrust.ROOT, digits=5, merge=True)
    blocks.append(rows_of(record, of))
    words = paragraph(
        "main bearings: each crankshaft bay simply supported at its two bearings, without "
        "clearances; directions in the sense of rotation from the stroke axis, for crank pins from "
        "the throw; pressure: load / (diameter x length)"
    )
    return section("Loads on bearings", [together(*blocks, words)], shown=shown)
