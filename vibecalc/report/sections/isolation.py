"""The body on its mounts: natural frequencies, transmissibility, response over one turn."""

import numpy as np

from vibecalc.report.lookup import along, labels
from vibecalc.report.numbers import hertz, rpm, show, show_phase
from vibecalc.report.sections.run_up import run_up
from vibecalc.report.sections.section import Section, scalars
from vibecalc.report.sections.supports import supports
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Record, Result

_PITCH = tuple(
    f"isolation/pitch/{name}"
    for name in (
        "inertia",
        "stiffness",
        "damping",
        "natural_frequency",
        "damping_ratio",
        "angle_peak",
    )
)
_LEVER = tuple(f"isolation/lever_force/{name}" for name in ("rigid_peak", "steady_peak"))


def isolation(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    blocks = [
        scalars(record, _PITCH, "isolation/"),
        _transmissibility(record),
        _modes(record),
        _energy(record),
        _lever(record),
        supports(record),
        run_up(record),
    ]
    lines: list[str] = []
    shown: set[str] = set()
    for block, paths in blocks:
        if block:
            lines += ["", *block] if lines else block
        shown |= paths
    # Arrays that belong to pictures rather than to a page of words.
    shown |= {
        path
        for path in record
        if path.startswith("isolation/") and path.endswith(("_harmonics", "/run_up", "_curve"))
    }
    return Section("Isolation: body on its mounts", lines, frozenset(shown)) if lines else None


def _lever(record: Record) -> tuple[list[str], set[str]]:
    lines, shown = scalars(record, _LEVER, "isolation/")
    if lines:
        lines += paragraph(
            "lever_force is the couple over the lever as a single force: rigid with the body held "
            "still, steady through the mounts; support_force is what one mount puts on the ground"
        )
    return lines, shown


def _transmissibility(record: Record) -> tuple[list[str], set[str]]:
    hit = along(record, "isolation/pitch/transmissibility", "order")
    if hit is None:
        return [], set()
    quantity, orders = hit
    columns = (
        Column("order", 6),
        number("transmissibility", 18),
        number("dB", 10),
        number("isolated", 12),
        number("phase deg", 10),
    )
    rows = []
    for order, value in zip(orders, quantity.values, strict=True):
        size = abs(complex(value))
        rows.append(
            [
                str(int(order)),
                show(size, quantity.error_estimate),
                f"{20.0 * np.log10(size):.2f}" if 0.0 < size < np.inf else "-",
                f"{100.0 * (1.0 - size):.2f} %",
                show_phase(complex(value), quantity.error_estimate),
            ]
        )
    return table(columns, rows), {quantity.path}


def _modes(record: Record) -> tuple[list[str], set[str]]:
    hit = along(record, "isolation/modes/natural_frequency", "mode")
    if hit is None:
        return [], set()
    quantity, modes = hit
    damping = along(record, "isolation/modes/damping_ratio", "mode")
    error = quantity.error_estimate
    columns = (
        Column("mode", 6),
        number("natural frequency rad/s", 24),
        number("Hz"),
        number("rpm"),
        number("damping ratio", 14),
    )
    rows = [
        [
            str(int(mode)),
            show(value, error),
            show(hertz(float(value)), hertz(error)),
            show(rpm(float(value)), rpm(error)),
            show(damping[0].values[i], damping[0].error_estimate) if damping else "",
        ]
        for i, (mode, value) in enumerate(zip(modes, quantity.values, strict=True))
    ]
    shown = {quantity.path} | ({damping[0].path} if damping else set())
    # The shapes carry no scale; the energy table says what moves in a mode.
    return table(columns, rows), shown | {"isolation/modes/shape"}


def _energy(record: Record) -> tuple[list[str], set[str]]:
    quantity = record.quantities.get("isolation/modes/energy_fraction")
    if quantity is None or [axis.name for axis in quantity.axes] != ["mode", "coordinate"]:
        return [], set()
    modes, coordinates = (labels(axis) for axis in quantity.axes)
    columns = [Column("energy %", 9), *(number(name, 10) for name in coordinates)]
    rows = [
        [mode, *(f"{round(100.0 * float(value), 2) + 0.0:.2f}" for value in line)]
        for mode, line in zip(modes, quantity.values, strict=True)
    ]
    return table(columns, rows), {quantity.path}
