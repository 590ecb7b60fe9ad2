"""Bearing loads in the report: highest and mean load of each bearing, where they stand."""

import math

from vibecalc.bearings.results import CrankPin, MainLoad, SideThrust, WristPin
from vibecalc.core.report.rows import Cells, Rows, rows_of
from vibecalc.core.report.sections import Section, section, together
from vibecalc.core.report.writing import paragraph
from vibecalc.core.results.record import Result


def _degrees(angle: float, _error: float) -> str:
    return f"{round(math.degrees(angle), 1) + 0.0:.1f}"


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
            Cells("peak_angle", "at crank\nangle deg", _degrees, right=True),
            Cells(
                "peak_direction",
                f"direction\n{origin} deg".replace("\n ", "\n"),
                _degrees,
                right=True,
            ),
            Cells("mean", "mean\nkN", "kN"),
            Cells("peak_pressure", "peak\npressure MPa", "MPa"),
            Cells("mean_pressure", "mean\npressure MPa", "MPa"),
        ]
        title = group.WORDS["load"] + ",\ncylinder" * (axis == "cylinder")
        of = Rows(axis, title, columns, group.ROOT, merge=True)
        blocks.append(rows_of(record, of))
    thrust = (Cells("peak", "side thrust kN", "kN"),
              Cells("peak_angle", "at crank angle deg", _degrees, right=True))  # fmt: skip
    of = Rows("cylinder", "piston,\ncylinder", thrust, SideThrust.ROOT, merge=True)
    blocks.append(rows_of(record, of))
    words = paragraph(
        "Main bearings: each bay of the crankshaft simply supported, no continuous bending and no "
        "clearances. Directions: positive in the sense of rotation, from the stroke or, for crank "
        "pins, from the throw. Pressure: load / (diameter x length)."
    )
    return section("Loads on bearings", [together(*blocks, words)], shown=shown)
