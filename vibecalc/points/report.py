"""Vibration at points in the report: peaks and r.m.s. values, zones, the run-up, orders."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from vibecalc.core.report.rows import Cells, Made, Rows, part_of, rows_of
from vibecalc.core.report.sections import (
    Section,
    having,
    labels,
    magnitudes,
    section,
    speed_of,
    table_of,
)
from vibecalc.core.report.writing import hertz, paragraph, show
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.points.readings import in_band
from vibecalc.points.results import RUN_UP, UNITS, AtPoints, Boundaries
from vibecalc.points.severity import grade_number, zone_names
from vibecalc.points.tables import GRADED, GRADES
from vibecalc.units import convert

_SEVERITY, _ZONE = "points/severity", "points/zone"

# ----------------------------------------------------------------------------
# The zone of a reading, and the boundaries that were given.
# ----------------------------------------------------------------------------


def zone_words(record: Record, place: int) -> str:
    """`zone C` of a reading, or nothing where the case has no zones."""
    zone, count = having(record, _ZONE, "sensor"), _boundaries(record)
    return f"zone {zone_names(count)[int(zone.values[place])]}" if zone is not None else ""


def _boundaries(record: Record) -> int:
    """How many boundaries the zones have."""
    found = (having(record, f"{Boundaries.ROOT}/{name}", "zone_limit") for name in UNITS)
    return max((one.values.size for one in found if one is not None), default=0)


def band_in_hertz(result: Result) -> tuple[float, float]:
    """Ends of the band of the r.m.s. values."""
    given: Any = table_of(result.case, "vibration_severity").get("band")
    if given is None:
        return 2.0, 1000.0
    low, high = given
    return hertz(float(low)), hertz(float(high))


def band_words(result: Result) -> str:
    """`2 to 1000 Hz`."""
    return " to ".join(f"{one:.6g}" for one in band_in_hertz(result)) + " Hz"


def standard_of(result: Result) -> str:
    """Standard and edition of the zones."""
    return str(table_of(result.case, "vibration_severity").get("standard") or GRADED)


def _severity_words(result: Result) -> list[str]:
    record = result.record
    if _SEVERITY not in record:
        return []
    lines, count = [], _boundaries(record)
    if count:
        names = zone_names(count)
        pairs = [f"{one} and {two}" for one, two in pairwise(names)]
        bounds = []
        for name, (si, read) in UNITS.items():
            found = having(record, f"{Boundaries.ROOT}/{name}", "zone_limit")
            if found is not None:
                each = (show(convert(float(one), si, read), digits=4) for one in found.values)
                bounds.append(f"{name} {', '.join(each)} {read}")
        lines += paragraph(
            f"Zones by {standard_of(result)} (informative), r.m.s. values between "
            f"{', '.join(pairs)}: {'; '.join(bounds)}. The worst of the three counts."
        )
    worst = float(np.max(magnitudes(record[_SEVERITY])))
    number = grade_number(worst)
    named = f"grade {GRADES[number]:g}" if number < len(GRADES) else "beyond all grades"
    return lines + paragraph(
        f"Severity at the worst sensor: {named} of {GRADED} (informative): "
        f"{show(convert(worst, 'm/s', 'mm/s'))} mm/s between 10 and 250 Hz, or the displacement "
        "below and the acceleration above that go with it."
    )


# ----------------------------------------------------------------------------
# Tables: every reading at the speed, and the largest of its run-up.
# ----------------------------------------------------------------------------

_SHORT = {"displacement": "s", "velocity": "v", "acceleration": "a"}


def _zones(record: Record) -> Quantity | None:
    zone = having(record, _ZONE, "sensor")
    if zone is None:
        return None
    words = [zone_words(record, i).removeprefix("zone ") for i in range(zone.values.size)]
    return part_of(zone, np.array(words), *zone.axes)


_AT_SPEED = Rows(
    "sensor",
    "sensor",
    (
        *(
            Cells(f"{name}_{kind}", f"{_SHORT[name]} {words}\n{read}", read)
            for name, (_, read) in UNITS.items()
            for kind, words in (("peak", "peak"), ("rms", "r.m.s."))
        ),
        Cells(_zones, "zone", ""),
    ),
    root=AtPoints.ROOT,
)
_IN_RUN_UP = Rows(
    "sensor",
    "largest of the run-up",
    [
        cells
        for name, (_, read) in UNITS.items()
        for cells in (
            Cells(f"{name}_rms_largest", f"{_SHORT[name]} r.m.s.\n{read}", read),
            Cells(f"{name}_rms_largest_speed", "at\nrpm", "rpm"),
        )
    ],
    root=RUN_UP,
)


# ----------------------------------------------------------------------------
# Orders of the worst reading, with their frequencies, and which of them count.
# ----------------------------------------------------------------------------


def _left_out(result: Result, found: Quantity) -> list[str]:
    """Orders that are outside the band at the speed, in words."""
    order, counts = _counted(result, found)
    outside = [f"{one:g}" for one in order[~counts]]
    if not outside:
        return []
    shown = outside if len(outside) < 9 else [*outside[:3], "...", *outside[-2:]]
    few = "Order" if len(outside) == 1 else "Orders"
    return paragraph(
        f"{few} {', '.join(shown)} outside the band: in the peaks, not in the r.m.s. values."
    )


def _counted(result: Result, found: Quantity) -> tuple[np.ndarray, np.ndarray]:
    order = np.asarray(found.axes[1].values, dtype=float)
    frequency = order * hertz(speed_of(result) or 0.0)
    return order, in_band(frequency, band_in_hertz(result))


def _by_order(result: Result) -> list[str]:
    found = having(result.record, f"{AtPoints.ROOT}/velocity", "sensor", "order")
    if found is None:
        return []
    axis, (order, counts) = found.axes[1], _counted(result, found)
    worst = int(np.argmax(np.sqrt(np.square(magnitudes(found) * counts).sum(axis=1))))
    hertz_of = part_of(found, order * hertz(speed_of(result) or 0.0), axis)
    counting = part_of(found, np.where(counts, "counts", "outside"), axis)

    def of_worst(name: str) -> Made:
        def made(record: Record) -> Quantity | None:
            every = having(record, f"{AtPoints.ROOT}/{name}", "sensor", "order")
            return None if every is None else part_of(every, magnitudes(every)[worst], axis)

        return made

    rows = Rows(
        "order",
        "order",
        (
            Cells(lambda _: hertz_of, "Hz", lambda value, _: show(value, digits=4)),
            *(Cells(of_worst(name), f"{name} {read}", read) for name, (_, read) in UNITS.items()),
            Cells(lambda _: counting, "r.m.s.", ""),
        ),
        label="{:g}",
        right=True,
        places=_moving,
    )
    title = f"{labels(found.axes[0])[worst]}, 0 to peak by order"
    return [*paragraph(title), *rows_of(result.record, rows)[0]]


def _moving(found: Sequence[Quantity]) -> np.ndarray:
    """Orders that are not zero, as the columns but the first and last say."""
    return np.flatnonzero(~np.all([one.zero for one in found[1:-1]], axis=0))[:48]


def points(result: Result) -> Section | None:
    """Readings at the points, their zones, the run-up; by order in a full report."""
    record = result.record
    table_lines, shown = rows_of(record, _AT_SPEED)
    up_lines, _ = rows_of(record, _IN_RUN_UP)
    further = {path for path in record if path.startswith((RUN_UP, Boundaries.ROOT))}
    velocity = having(record, f"{AtPoints.ROOT}/velocity", "sensor", "order")
    moves = table_of(result.case, "foundation").get("kind") in ("body", "impedance")
    on_what = ", with the motion of the foundation at the speed" if moves else ""
    words = paragraph(
        f"Displacement s, velocity v and acceleration a along each sensor{on_what}; peak over the "
        f"cycle of all orders, r.m.s. of those from {band_words(result)}."
    )
    if not table_lines and not up_lines:
        return None
    if velocity is not None:
        words += _left_out(result, velocity)
    words += _severity_words(result)
    return section(
        "Vibration at points",
        ([*words, "", *table_lines] if table_lines else words, up_lines),
        {"readings by order": _by_order(result)},
        {*shown, *further, _SEVERITY},
    )
