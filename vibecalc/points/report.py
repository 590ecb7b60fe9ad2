"""Vibration at points in the report: peaks and r.m.s. values, zones, the run-up, orders."""

from collections.abc import Sequence
from itertools import pairwise

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
from vibecalc.points.results import BOUNDARY, KINDS, ROOT, RUN_UP, UNITS
from vibecalc.points.severity import grade_number, zone_names
from vibecalc.points.tables import BAND, GRADED, GRADES
from vibecalc.units import convert

_SEVERITY, _ZONE = f"{ROOT}/severity", f"{ROOT}/zone"

# ----------------------------------------------------------------------------
# The zone of a reading, and the boundaries that were given.
# ----------------------------------------------------------------------------


def zone_words(record: Record, place: int, _path: str) -> str | None:
    """`sensor base, zone C` of a reading, or nothing where the case has no zones."""
    zones = _zones(record)
    if zones is None:
        return None
    return f"sensor {labels(zones.axes[0])[place]}, zone {zones.values[place]}"


def _zones(record: Record) -> Quantity | None:
    """Names of the zones of all readings."""
    zone = having(record, _ZONE, "sensor")
    if zone is None:
        return None
    names = zone_names(max(one.values.size for one in boundaries(record).values()))
    return part_of(zone, np.array(names)[zone.values.astype(int)], *zone.axes)


def boundaries(record: Record) -> dict[str, Quantity]:
    """Boundaries of the zones, of those quantities that have any."""
    found = {name: having(record, f"{BOUNDARY}/{name}", "zone_limit") for name in UNITS}
    return {name: one for name, one in found.items() if one is not None}


def band_in_hertz(result: Result) -> tuple[float, float]:
    """Ends of the band of the r.m.s. values."""
    low, high = table_of(result.case, "vibration_severity").get("band") or BAND
    return hertz(low), hertz(high)


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
    lines, bounds, between = [], [], boundaries(record)
    for name, found in between.items():
        si, read = UNITS[name]
        each = (show(convert(float(one), si, read), digits=4) for one in found.values)
        bounds.append(f"{name} {', '.join(each)} {read}")
    if between:
        names = pairwise(zone_names(max(one.values.size for one in between.values())))
        pairs = ", ".join(f"{one} and {two}" for one, two in names)
        lines += paragraph(
            f"Zones by {standard_of(result)} (informative), r.m.s. values between {pairs}: "
            f"{'; '.join(bounds)}. The worst of the three decides."
        )
    worst = float(np.max(magnitudes(record[_SEVERITY])))
    number = grade_number(worst)
    named = f"grade {GRADES[number]:g}" if number < len(GRADES) else "beyond all grades"
    return lines + paragraph(
        f"Severity at the worst sensor: {named} of {GRADED} (informative): "
        f"{show(convert(worst, 'm/s', 'mm/s'))} mm/s from 10 to 250 Hz, with constant displacement "
        "below and constant acceleration above."
    )


# ----------------------------------------------------------------------------
# Tables: every reading at the speed, and the largest of its run-up.
# ----------------------------------------------------------------------------

_SHORT = {"displacement": "s", "velocity": "v", "acceleration": "a"}


_readings, _largest = list[Cells](), list[Cells]()
for _name, (_, _read) in UNITS.items():
    _readings += (Cells(f"{_name}_{kind}", f"{_SHORT[_name]} {words}\n{_read}", _read)
                  for kind, (words, _) in KINDS.items())  # fmt: skip
    _largest.append(Cells(f"{_name}_rms_largest", f"{_SHORT[_name]} r.m.s.\n{_read}", _read))
    _largest.append(Cells(f"{_name}_rms_largest_speed", "at\nrpm", "rpm"))
_AT_SPEED = Rows("sensor", "sensor", (*_readings, Cells(_zones, "zone", "")), ROOT)
_IN_RUN_UP = Rows("sensor", "maximum in the run-up", _largest, RUN_UP)


# ----------------------------------------------------------------------------
# Orders of the worst reading, with their frequencies, and which of them count.
# ----------------------------------------------------------------------------


def _orders(result: Result, found: Quantity) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Orders of a quantity by sensor, their frequencies in Hz, and which of them count."""
    order = np.asarray(found.axes[1].values, dtype=float)
    frequency = order * hertz(speed_of(result) or 0.0)
    return order, frequency, in_band(frequency, band_in_hertz(result))


def _left_out(result: Result, velocity: Quantity) -> list[str]:
    """Orders that are outside the band at the speed, in words."""
    order, _, counts = _orders(result, velocity)
    outside = [f"{one:g}" for one in order[~counts]]
    if not outside:
        return []
    shown = outside if len(outside) < 9 else [*outside[:3], "...", *outside[-2:]]
    few = "Order" if len(outside) == 1 else "Orders"
    return paragraph(f"{few} {', '.join(shown)} outside the band: counted in the peaks only.")


def _by_order(result: Result, velocity: Quantity) -> list[str]:
    (sensor, axis), (_, frequency, counts) = velocity.axes, _orders(result, velocity)
    worst = int(np.argmax(np.linalg.norm(magnitudes(velocity) * counts, axis=1)))

    def known(values: np.ndarray) -> Made:
        return lambda _: part_of(velocity, values, axis)

    def of_worst(name: str) -> Made:
        def made(record: Record) -> Quantity | None:
            every = having(record, f"{ROOT}/{name}", "sensor", "order")
            return None if every is None else part_of(every, magnitudes(every)[worst], axis)

        return made

    columns = (
        Cells(known(frequency), "Hz", lambda value, _: show(value, digits=4)),
        *(Cells(of_worst(name), f"{name} {read}", read) for name, (_, read) in UNITS.items()),
        Cells(known(np.where(counts, "in band", "outside")), "r.m.s.", ""),
    )
    rows = Rows("order", "order", columns, label="{:g}", right=True, places=_moving)
    title = f"{labels(sensor)[worst]}, amplitude (0-to-peak) by order"
    return [*paragraph(title), *rows_of(result.record, rows)[0]]


def _moving(found: Sequence[Quantity]) -> np.ndarray:
    """Orders that are not zero, as the columns but the first and last say."""
    return np.flatnonzero(~np.all([one.zero for one in found[1:-1]], axis=0))[:48]


def points(result: Result) -> Section | None:
    """Readings at the points, their zones, the run-up; by order in a full report."""
    record = result.record
    velocity = having(record, f"{ROOT}/velocity", "sensor", "order")
    table_lines, shown = rows_of(record, _AT_SPEED)
    up_lines, _ = rows_of(record, _IN_RUN_UP)
    if not table_lines and not up_lines:
        return None
    pitches = table_of(result.case, "isolation").get("model") == "pitch"
    moves = bool(table_of(result.case, "foundation")) and not pitches
    on_what = ", including the motion of the foundation" if moves else ""
    words = paragraph(
        f"Displacement s, velocity v and acceleration a along a sensor{on_what}; peak of all "
        f"orders over the cycle, r.m.s. of orders from {band_words(result)}."
    )
    words += (_left_out(result, velocity) if velocity else []) + _severity_words(result)
    return section(
        "Vibration at points",
        (table_lines, words, up_lines),
        {"readings by order": _by_order(result, velocity) if velocity else []},
        {*shown, *(path for path in record if path.startswith((RUN_UP, BOUNDARY))), _SEVERITY},
    )
