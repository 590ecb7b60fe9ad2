"""Forces in the rods and on the walls, and what the textbook's assumptions cost in them."""

import numpy as np

from vibecalc.report.levels import ROLL
from vibecalc.report.lookup import having, labels
from vibecalc.report.numbers import show
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Quantity, Record

_FORCES = (("rod_force", "rod"), ("wall_force", "wall"))
_PLACES = {"rod_force": "in the rods", "wall_force": "on the walls"}
_DIGITS = 5


def forces(record: Record) -> list[str]:
    """Largest forces of each cylinder, beside those at constant speed, and what these miss."""
    peaks = [having(record, f"{ROLL}{name}_peak", "cylinder") for name, _ in _FORCES]
    first = next((peak for peak in peaks if peak is not None), None)
    if first is None:
        return []
    columns = [Column("largest force", 14)]
    rows = [[name] for name in labels(first.axes[0])]
    errors = []
    for (name, words), peak in zip(_FORCES, peaks, strict=True):
        held = having(record, f"{ROLL}classical/{name}_peak", "cylinder")
        error = having(record, f"{ROLL}classical/{name}_error", "cylinder")
        for quantity, title in ((peak, f"{words} N"), (held, "at constant speed N")):
            if quantity is not None:
                columns.append(number(title, 13))
                for row, value in zip(rows, quantity.values, strict=True):
                    row.append(show(value, quantity.error_estimate, _DIGITS))
        if error is not None:
            columns.append(number("off by up to %", 12))
            for row, value in zip(rows, error.values, strict=True):
                row.append(f"{100.0 * float(value):.3g}")
            errors.append(f"the force {_PLACES[name]} by {_worst(error)}" + _at(record, name))
    lines = table(columns, rows)
    if errors:
        lines += paragraph(
            "what constant speed and a fixed shell cost: they miss " + ", ".join(errors)
            + " (largest error over a turn, over the largest force)"
        )  # fmt: skip
    return lines + shaking(record)


def shaking(record: Record) -> list[str]:
    """What the textbook has for the whole body: its force and couple, and no roll."""
    words = []
    for name, way in (("force", "along"), ("couple", "about")):
        peak = having(record, f"{ROLL}shaking/{name}_peak", "direction")
        if peak is None:
            return []
        shown = [
            f"{show(value, peak.error_estimate, _DIGITS)} {peak.unit} {way} {label}"
            for label, value in zip(labels(peak.axes[0]), peak.values, strict=True)
            if float(value) > peak.error_estimate
        ]
        words.append(", ".join(shown) if shown else f"no {name}")
    level = having(record, f"{ROLL}level/shell_acceleration", "order")
    rolls = level is not None and bool(np.any(np.isfinite(level.values)))
    balanced = all(word.startswith("no ") for word in words)
    text = f"at constant speed the masses shake the body with {' and '.join(words)}"
    if balanced:
        text += ": balanced perfectly by the textbook" + (", and it rolls" if rolls else "")
    return paragraph(text + "; largest over a turn, about the reference point")


def _worst(error: Quantity) -> str:
    place = int(np.argmax(error.values))
    return f"up to {100.0 * float(error.values[place]):.3g} % ({labels(error.axes[0])[place]})"


def _at(record: Record, name: str) -> str:
    """The order at which the force is missed most."""
    by_order = having(record, f"{ROLL}classical/{name}_error_by_order", "cylinder", "order")
    if by_order is None:
        return ""
    size = np.abs(by_order.values)
    place = np.unravel_index(int(np.argmax(size)), size.shape)
    if size[place] <= by_order.error_estimate:
        return ""
    order = int(by_order.axes[1].values[place[1]])
    return f", {show(size[place], digits=3)} {by_order.unit} of it at order {order}"
