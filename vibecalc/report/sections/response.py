"""The body on its suspension: modes, motion over one turn, force on the ground, energies."""

import numpy as np

from vibecalc.report.lookup import along, having, labels, magnitudes
from vibecalc.report.numbers import hertz, show, show_percent
from vibecalc.report.sections.response_energies import energies
from vibecalc.report.sections.section import Section
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Quantity, Record, Result

_MODES = "response/modes/"
_PEAKS = (
    ("translation_peak", "reference point"),
    ("rotation_peak", "rotation"),
    ("ground_force_peak", "force on the ground"),
    ("ground_couple_peak", "couple on the ground"),
)
#: coordinates are named until they hold so much of the energy of a mode together
_ENOUGH = 0.9
#: what pictures and the file keep
_ARRAYS = (
    "translation_harmonics",
    "rotation_harmonics",
    "ground_force",
    "ground_couple",
    "modes/shape",
    "modes/assurance",
    "run_up/kinetic_energy",
    "run_up/potential_energy",
)


def response(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    lines: list[str] = []
    shown: set[str] = set()
    for block, paths in (_modes(record), _motion(record), energies(record), _run_up(record)):
        if block:
            lines += ["", *block] if lines else block
        shown |= paths
    shown |= {path for name in _ARRAYS if (path := f"response/{name}") in record}
    title = "Response: body on its suspension"
    return Section(title, lines, frozenset(shown)) if lines else None


def _modes(record: Record) -> tuple[list[str], set[str]]:
    frequency = having(record, _MODES + "natural_frequency", "mode")
    if frequency is None:
        return [], set()
    damping = having(record, _MODES + "damping_ratio", "mode")
    share = having(record, _MODES + "energy_fraction", "mode", "coordinate")
    nearest = having(record, _MODES + "nearest_order", "mode")
    distance = having(record, _MODES + "distance", "mode")
    error = frequency.error_estimate
    rows = [
        [
            mode,
            show(hertz(float(value)), hertz(error)),
            show(float(value), error),
            _entry(damping, i),
            main_coordinates(share, i),
            "" if nearest is None else str(int(nearest.values[i])),
            "" if distance is None else show_percent(float(distance.values[i])),
        ]
        for i, (mode, value) in enumerate(
            zip(labels(frequency.axes[0]), frequency.values, strict=True)
        )
    ]
    columns = (
        Column("mode", 5),
        number("Hz", 11),
        number("rad/s", 11),
        number("damping ratio", 14),
        Column("  moves most (share of energy)", 32),
        number("nearest", 8),
        number("it is off", 11),
    )
    for row in rows:
        row[4] = f"  {row[4]}"
    lines = table(columns, rows)
    if nearest is not None:
        lines += paragraph(
            "nearest: the excited order that comes closest at operating speed; off: its frequency "
            "over the natural frequency, less 1"
        )
    found = (frequency, damping, share, nearest, distance)
    return lines, {quantity.path for quantity in found if quantity is not None}


def main_coordinates(share: Quantity | None, mode: int) -> str:
    """`y 87 %, rz 12 %`: coordinates with most of the energy of a mode, the largest first."""
    if share is None:
        return ""
    names, row = labels(share.axes[1]), np.asarray(share.values[mode], dtype=float)
    words, held = [], 0.0
    for j in np.argsort(-row, kind="stable"):
        words.append(f"{names[j]} {100.0 * row[j]:.0f} %")
        held += float(row[j])
        if held >= _ENOUGH or len(words) == 3:
            break
    return ", ".join(words)


def _motion(record: Record) -> tuple[list[str], set[str]]:
    rows, shown = [], set()
    head: list[str] = []
    for name, words in _PEAKS:
        quantity = having(record, f"response/{name}", "direction")
        if quantity is None:
            continue
        shown.add(quantity.path)
        head = labels(quantity.axes[0])
        cells = [show(value, quantity.error_estimate) for value in magnitudes(quantity)]
        rows.append([words, *cells, quantity.unit])
    if not rows:
        return [], shown
    columns = (
        Column("largest over a turn", 24),
        *(number(name, 14) for name in head),
        Column("unit", 8),
    )
    return table(columns, rows), shown


def _run_up(record: Record) -> tuple[list[str], set[str]]:
    """Where over the speeds the energy is largest, and the speeds left out.

    A driven resonance without damping among the speeds leaves no largest value: what was computed
    at the edge of the speeds left out is not one.
    """
    rows: list[list[str]] = []
    shown: set[str] = set()
    masked = {path for path in record if path.startswith("response/masked/")}
    centre = having(record, "response/masked/centre", "masked")
    for kind in ("kinetic", "potential"):
        hit = along(record, f"response/run_up/{kind}_energy", "speed")
        if hit is None or not hit[1].size:
            continue
        quantity, speed = hit
        top = int(np.argmax(quantity.values))
        value, unit = show(float(quantity.values[top]), quantity.error_estimate), quantity.unit
        at = float(speed[top])
        if centre is not None and centre.values.size:
            value, unit, at = "without bound", "", float(centre.values[0])
        rows.append([f"{kind}, mean over a turn", value, unit, show(at)])
    if not rows:
        return [], masked
    columns = (
        Column("largest energy of the run-up, as sampled", 42),
        number("value", 14),
        Column("unit", 6),
        number("at rad/s", 14),
    )
    lines = table(columns, rows)
    if centre is not None:
        order, mode = (record.quantities.get(f"response/masked/{n}") for n in ("order", "mode"))
        words = []
        for i, speed_out in enumerate(centre.values):
            which = ""
            if order is not None and mode is not None:
                which = f" (order {int(order.values[i])}, mode {int(mode.values[i])})"
            words.append(f"{show(float(speed_out))} rad/s{which}")
        lines += paragraph("left out, an undamped resonance without bound: " + ", ".join(words))
    return lines, shown | masked


def _entry(quantity: Quantity | None, i: int) -> str:
    return "" if quantity is None else show(quantity.values[i], quantity.error_estimate)
