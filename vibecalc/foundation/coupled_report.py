"""Machine and foundation in six freedoms: the section of the report, and the picture."""

from collections.abc import Callable
from dataclasses import replace

from vibecalc.core.report.curves import Curve, Curves, Panel, entry_of, level
from vibecalc.core.report.rows import Cells, Made, Rows, by_axis, loud, percent, reduced, rows_of
from vibecalc.core.report.sections import (
    Section,
    scalar_of,
    section,
    stacked,
)
from vibecalc.core.report.writing import Column, number, paragraph, show, table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.parts.body import COORDINATES

COUPLED = "foundation/coupled"
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
            cells += [
                f"{show(float(total.values), total.error_estimate)} {unit}",
                "-" if share is None else f"{100.0 * share:.2f} %",
            ]
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
    """Length of the force of the orders that matter, as whole or half numbers."""

    def made(result: Result) -> Quantity | None:
        found, rigid = of(result.record), _RIGID(result.record)
        if found is None or rigid is None:
            return None
        large = _LARGE([rigid])
        axis = replace(found.axes[0], values=found.axes[0].values[large])
        return replace(found, path="", values=found.values[large], axes=(axis,))

    return made


def _panel(coordinate: str) -> Panel:
    return Panel(
        "transmissibility",
        (
            Curve(
                entry_of(f"{COUPLED}/ground/transmissibility", COORDINATES.index(coordinate)),
                "as it is",
            ),
            Curve(
                entry_of(f"{COUPLED}/rigid/transmissibility", COORDINATES.index(coordinate)),
                "on a rigid foundation",
                {"linestyle": "--"},
            ),
            level(lambda _: 1.0),
        ),
        f"load on the ground over a load on the machine, {coordinate}",
        log="xy",
    )


FOUNDATION = Curves(
    "machine on its foundation",
    (
        *(_panel(one) for one in ("y", "z", "rx")),
        Panel(
            "force",
            (
                Curve(_length(_FORCE), "as it is", bars=True),
                Curve(_length(_RIGID), "on a rigid foundation", bars=True),
            ),
            "force on the ground by order",
            log="y",
        ),
    ),
    high=2.3,
)
