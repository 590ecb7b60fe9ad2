"""Machine and foundation in six freedoms: the section of the report, and the picture."""

from collections.abc import Callable
from dataclasses import replace

from vibecalc.core.report.curves import Curve, Curves, Look, Panel, Source, entry_of, level
from vibecalc.core.report.rows import Cells, Made, Rows, by_axis, loud, percent, reduced, rows_of
from vibecalc.core.report.sections import (
    Section,
    scalar_of,
    section,
    stacked,
)
from vibecalc.core.report.writing import Column, number, paragraph, show_in, table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.foundation.results import COUPLED
from vibecalc.isolation.efficiency_report import of_loud
from vibecalc.parts.body import COORDINATES

#: orders below this share of the largest stay in the result file, as those beyond so many
_LARGE = loud(1e-3, 12)

_MODES = Rows(
    "coupled_mode",
    "mode",
    (
        Cells("natural_frequency", "Hz", "Hz"),
        Cells("damping_ratio", "damping ratio", ""),
        Cells("machine_share", "machine %", percent(1)),
        Cells(
            "machine_share",
            "foundation %",
            lambda share, _: f"{100.0 - 100.0 * share:.1f}",
            note="%: share of the energy of the mode",
        ),
    ),
    root=f"{COUPLED}/modes",
)


_FORCE, _RIGID = (reduced(f"{COUPLED}/{name}/force") for name in ("ground", "rigid"))


_BY_ORDER = Rows(
    "half_order",
    "order",
    (
        Cells(_FORCE, "on the ground N", ""),
        Cells(_RIGID, "rigid N"),
        Cells("ground/force_by_order", "efficiency %", percent(2)),
        Cells("rigid/force_by_order", "rigid %", percent(2)),
        Cells("power", "power W"),
    ),
    root=COUPLED,
    label="{:g}",
    places=lambda found: _LARGE(found[1:]),
)


def coupled(result: Result) -> Section | None:
    """Modes, loads on the ground against a rigid foundation, motion of the feet; None without."""
    record = result.record
    if f"{COUPLED}/ground/force" not in record:
        return None
    shown = {path for path in record if path.startswith(f"{COUPLED}/")}
    feet = by_axis(
        record, "mount", "below the mount", ((f"{COUPLED}/foot_velocity_rms", "r.m.s.", "mm/s"),)
    )
    lines = stacked(rows_of(record, _MODES)[0], _loads(record), feet)
    details = {"force on the ground by order": rows_of(record, _BY_ORDER)}
    return section("Machine and foundation", [(lines, shown)], details)


def _loads(record: Record) -> list[str]:
    """R.m.s. of force and couple on the ground, and what a rigid foundation would get."""
    rows = []
    for what, unit in (("force", "N"), ("couple", "N m")):
        cells = []
        for name in ("ground", "rigid"):
            total = record[f"{COUPLED}/{name}/{what}_rms"]
            share = scalar_of(record, f"{COUPLED}/{name}/{what}_efficiency")
            cells.append(show_in(float(total.values), unit, total.error_estimate))
            cells.append("-" if share is None else f"{100.0 * share:.2f} %")
        rows.append([f"{what}, r.m.s.", *cells])
    heads = (
        Column("on the ground"), number("as it is"), number("efficiency"),
        number("rigid foundation"), number("efficiency")
    )  # fmt: skip
    words = "efficiency: 1 less the ratio to what the machine held still would send"
    if f"{COUPLED}/modes/natural_frequency" not in record:
        words += (
            "; with flexibilities, the ground is all that their tables stand for, its mass included"
        )
    return table(heads, rows) + paragraph(words)


# ----------------------------------------------------------------------------
# Transmissibility with and without the foundation; force by order.
# ----------------------------------------------------------------------------


def _length(of: Made) -> Callable[[Result], Quantity | None]:
    """Of the orders that matter, without the path: references of the case are of components."""
    source = of_loud(of, _RIGID)

    def made(result: Result) -> Quantity | None:
        found = source(result)
        return found and replace(found, path="")

    return made


def _both(ground: Source, rigid: Source, look: Look, bars: bool = False) -> tuple[Curve, Curve]:
    rigidly = Curve(rigid, "on a rigid foundation", look, bars=bars)
    return Curve(ground, "as it is", bars=bars), rigidly


def _panel(coordinate: str) -> Panel:
    place = COORDINATES.index(coordinate)
    ground, rigid = (
        entry_of(f"{COUPLED}/{name}/transmissibility", place) for name in ("ground", "rigid")
    )
    curves = _both(ground, rigid, {"linestyle": "--"})
    words = f"load on the ground over a load on the machine, {coordinate}"
    return Panel("transmissibility", (*curves, level(lambda _: 1.0)), words, log="xy")


_LENGTHS = _both(_length(_FORCE), _length(_RIGID), {}, bars=True)
FOUNDATION = Curves(
    "machine on its foundation",
    (
        *(_panel(one) for one in ("y", "z", "rx")),
        Panel("force", _LENGTHS, "force on the ground by order", log="y"),
    ),
    high=2.3,
)
