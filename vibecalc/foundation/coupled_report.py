"""Machine and foundation in six freedoms: the section of the report, and the picture."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from vibecalc.core.report.curves import Curve, Curves, Panel, level, sourced
from vibecalc.core.report.rows import by_axis
from vibecalc.core.report.sections import (
    Section,
    along,
    having,
    magnitudes,
    scalar_of,
    section,
    stacked,
)
from vibecalc.core.report.writing import Column, hertz, number, paragraph, show, table
from vibecalc.core.results.record import Axis, Quantity, Record, Result
from vibecalc.foundation.coupled_results import COUPLED

#: orders below this share of the largest stay in the result file
_SMALL = 1e-3
_MOST = 12
_LOADS = (("force", "N"), ("couple", "N m"))


def coupled(result: Result) -> Section | None:
    """Modes, loads on the ground against a rigid foundation, motion of the feet; None without."""
    record = result.record
    if f"{COUPLED}/ground/force" not in record:
        return None
    shown = {path for path in record if path.startswith(f"{COUPLED}/")}
    feet = by_axis(
        record, "mount", "below the mount", ((f"{COUPLED}/foot_velocity_rms", "r.m.s.", "mm/s"),)
    )
    lines = stacked(_modes(record), _loads(record), feet)
    details = {"force on the ground by order": _by_order(record)}
    return section("Machine and foundation", [(lines, shown)], details)


def _modes(record: Record) -> list[str]:
    hit = along(record, f"{COUPLED}/modes/natural_frequency", "coupled_mode")
    ratio = along(record, f"{COUPLED}/modes/damping_ratio", "coupled_mode")
    share = along(record, f"{COUPLED}/modes/machine_share", "coupled_mode")
    if hit is None or ratio is None or share is None:
        return []
    error = hertz(hit[0].error_estimate)
    rows = [
        [
            str(int(mode)),
            show(hertz(float(hit[0].values[i])), error),
            show(float(ratio[0].values[i]), ratio[0].error_estimate),
            f"{100.0 * float(share[0].values[i]):.1f}",
            f"{100.0 - 100.0 * float(share[0].values[i]):.1f}",
        ]
        for i, mode in enumerate(hit[1])
    ]
    heads = (
        Column("mode", 4), number("Hz", 10), number("damping ratio", 13),
        number("machine %", 10), number("foundation %", 12),
    )  # fmt: skip
    return table(heads, rows) + paragraph("%: share of the energy of the mode")


def _loads(record: Record) -> list[str]:
    """R.m.s. of force and couple on the ground, and what a rigid foundation would get."""
    rows = []
    for what, unit in _LOADS:
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
        Column("on the ground", 16), number("as it is", 14), number("efficiency", 11),
        number("rigid foundation", 17), number("efficiency", 11),
    )  # fmt: skip
    words = "efficiency: 1 less the ratio to what the machine held still would send"
    if f"{COUPLED}/modes/natural_frequency" not in record:
        words += (
            "; with flexibilities, the ground is all that their tables stand for, its mass included"
        )
    return table(heads, rows) + paragraph(words)


def _by_order(record: Record) -> list[str]:
    ground, rigid = (
        having(record, f"{COUPLED}/{name}/force", "half_order", "direction")
        for name in ("ground", "rigid")
    )
    power = having(record, f"{COUPLED}/power", "half_order")
    if ground is None or rigid is None or power is None:
        return []
    sizes = [np.linalg.norm(magnitudes(one), axis=1) for one in (ground, rigid)]
    shares = [record[f"{COUPLED}/{name}/force_by_order"].values for name in ("ground", "rigid")]
    large = np.flatnonzero(sizes[1] > _SMALL * np.max(sizes[1], initial=0.0))[:_MOST]
    rows = [
        [
            f"{ground.axes[0].values[i]:g}",
            show(sizes[0][i], ground.error_estimate),
            show(sizes[1][i], rigid.error_estimate),
            *(f"{100.0 * one[i]:.2f}" if np.isfinite(one[i]) else "-" for one in shares),
            show(float(power.values[i]), power.error_estimate),
        ]
        for i in large
    ]
    heads = (
        Column("order", 6), number("on the ground N", 15), number("rigid N", 12),
        number("efficiency %", 12), number("rigid %", 10), number("power W", 12),
    )  # fmt: skip
    return table(heads, rows) if rows else []


# ----------------------------------------------------------------------------
# Transmissibility with and without the foundation; force by order.
# ----------------------------------------------------------------------------


def _one(name: str, coordinate: str) -> Callable[[Result], Quantity | None]:
    """Transmissibility in one direction."""

    def made(result: Result) -> Quantity | None:
        found = sourced(f"{COUPLED}/{name}/transmissibility", result)
        if found is None:
            return None
        place = [*found.axes[0].values].index(coordinate)
        return replace(found, values=found.values[place], axes=found.axes[1:])

    return made


def _length(name: str) -> Callable[[Result], Quantity | None]:
    """Length of the force of the orders that matter, as whole or half numbers."""

    def made(result: Result) -> Quantity | None:
        found = sourced(f"{COUPLED}/{name}/force", result)
        other = sourced(f"{COUPLED}/rigid/force", result)
        if found is None or other is None:
            return None
        size, rigid = (np.linalg.norm(np.abs(one.values), axis=1) for one in (found, other))
        large = np.flatnonzero(rigid > _SMALL * np.max(rigid, initial=0.0))[:_MOST]
        axis: Axis = replace(found.axes[0], values=found.axes[0].values[large])
        return replace(found, path="", values=size[large], axes=(axis,))

    return made


def _panel(coordinate: str) -> Panel:
    return Panel(
        "transmissibility",
        (
            Curve(_one("ground", coordinate), "as it is"),
            Curve(_one("rigid", coordinate), "on a rigid foundation", {"linestyle": "--"}),
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
                Curve(_length("ground"), "as it is", bars=True),
                Curve(_length("rigid"), "on a rigid foundation", bars=True),
            ),
            "force on the ground by order",
            log="y",
        ),
    ),
    high=2.3,
)
