"""Impacts in the joints with play: statistics for each clearance, and what they rest on."""

import math
from collections.abc import Sequence

import numpy as np

from vibecalc.core.report.sections import (
    Section,
    having,
    section,
    table_of,
)
from vibecalc.core.report.writing import Column, number, paragraph, show, show_error, table
from vibecalc.core.results.record import Quantity, Record, Result

_STEM = "response/impact/"
#: of a statistic
_DIGITS = 4
_CONTACTS = 7
#: names, title and width of the columns of the two tables over clearances
_FORCES = (
    ("mean_force", "mean force N"),
    ("+-", "+-"),
    ("mean_force_low", "quantile 5 %"),
    ("mean_force_high", "quantile 95 %"),
    ("average_amplitude", "spectrum mean"),
    ("peak_force", "mean peak N"),
    ("peak_force_high", "quantile 95 %"),
)
_COUNTS = (
    ("impacts", "impacts/turn"),
    ("contact_share", "in contact %"),
    ("dissipated", "lost/turn J"),
    ("parting", "turns to diverge"),
    ("divergence", "Lyapunov exponent"),
    ("dominant_from", "dominant from"),
    ("energy_residual", "energy error"),
)
_LEADERS = ("inertia of the piston", "added by impacts", "motor")
_MOST_RANGES = 4
_JOINTS = (("crank_pin", "crank pin"), ("bore", "cylinder wall"))


def impact(result: Result) -> Section | None:
    """The section, None if the result has no impacts."""
    record = result.record
    first = having(record, _STEM + "mean_force", "clearance")
    turns = _turns(result)
    if first is None:
        return None
    shown = frozenset(path for path in record if path.startswith(_STEM))
    clearances = [f"{1e3 * float(value):.5g}" for value in first.axes[0].values]
    counts = _over_clearances(record, clearances, _COUNTS, turns) + _notes(record, first)
    blocks = [_over_clearances(record, clearances, _FORCES, turns), counts, _method(result)]
    details = {
        "largest force by order": _leaders(record, clearances),
        "other joints": _other_joints(record, clearances),
        "first contacts": _first_contacts(record, clearances),
    }
    return section("Impacts in joints with play", blocks, details, shown)


def _over_clearances(
    record: Record,
    clearances: Sequence[str],
    fields: Sequence[tuple[str, str]],
    turns: int | None,
) -> list[str]:
    columns = [Column("wrist pin play mm")]
    cells: list[list[str]] = [[clearance] for clearance in clearances]
    for name, words in fields:
        if name == "+-":
            spread = standard_errors(record, "mean_force")
            texts = None if spread is None else [show_error(float(value)) for value in spread]
        else:
            quantity = having(record, _STEM + name, "clearance")
            count = range(len(clearances))
            texts = None if quantity is None else [_cell(quantity, name, i, turns) for i in count]
        if texts is None:
            continue
        columns.append(number(words))
        for row, text in zip(cells, texts, strict=True):
            row.append(text)
    return table(columns, cells)


def standard_errors(record: Record, name: str) -> np.ndarray | None:
    """Standard error at each clearance: its own, else the one number that all share, else None."""
    stored = having(record, f"{_STEM}{name}_standard_error", "clearance")
    if stored is not None:
        return np.asarray(stored.values, dtype=float)
    quantity = having(record, _STEM + name, "clearance")
    if quantity is None or quantity.standard_error is None:
        return None
    return np.full(quantity.values.shape, quantity.standard_error)


def _turns(result: Result) -> int | None:
    """Turns that each run was watched for, None where the case does not say."""
    options = table_of(result.case, "response", "impact")
    parts = [options.get(key) for key in ("discard", "revolutions")] if options else [None]
    return None if None in parts else sum(int(str(part)) for part in parts)


def _cell(quantity: Quantity, name: str, i: int, turns: int | None = None) -> str:
    value = float(quantity.values[i])
    if name == "contact_share":
        return show(100.0 * value, 100.0 * quantity.error_estimate, _DIGITS)
    if name == "dominant_from":
        return f"order {int(value)}" if value > 0 else "nowhere"
    if name == "parting":
        if math.isfinite(value):
            return f"{value:.3g}"
        # a longer run might part
        return "none seen" if turns is None else f"> {turns}"
    if name == "energy_residual":
        return show_error(value) if value else "0"
    return show(value, quantity.error_estimate, _DIGITS)


def _notes(record: Record, first: Quantity) -> list[str]:
    words = []
    if having(record, _STEM + "average_amplitude", "clearance") is not None:
        words.append("spectrum mean: amplitude of the joint force, mean over the orders")
    if standard_errors(record, "mean_force") is not None:
        words.append("+-: standard error of the mean, from the scatter of the runs")
    if having(record, _STEM + "dominant_from", "clearance") is not None:
        words.append(
            "dominant from: from that order to the last, what impacts add to the inertia force on "
            "the body is the largest"
        )
    if having(record, _STEM + "parting", "clearance") is not None:
        words.append(
            "turns to diverge: of two runs that start almost alike (>: longer than the run); "
            "Lyapunov exponent: growth of the logarithm of their distance in a turn; so only "
            "statistics are results"
        )
    if having(record, _STEM + "energy_residual", "clearance") is not None:
        words.append("energy error: imbalance over the energy exchanged")
    return paragraph("; ".join(words)) if words else []


def _leaders(record: Record, clearances: Sequence[str]) -> list[str]:
    """At which orders which force is the largest."""
    quantity = having(record, _STEM + "dominant", "clearance", "order")
    if quantity is None:
        return []
    orders = np.asarray(quantity.axes[1].values)
    names = _LEADERS if _STEM + "motor" in record else _LEADERS[:2]
    rows = []
    for clearance, row in zip(clearances, np.asarray(quantity.values), strict=True):
        rows.append([clearance, *(ranges(orders, row == i) for i in range(len(names)))])
    columns = [Column("largest at orders, play mm"), *(Column(name) for name in names)]
    return table(columns, rows)


def ranges(orders: np.ndarray, chosen: np.ndarray) -> str:
    """`1, 4 to 9`: the chosen orders, neighbours joined; `-` for none."""
    places = np.flatnonzero(chosen)
    if not places.size:
        return "-"
    groups = np.split(places, np.flatnonzero(np.diff(places) > 1) + 1)
    words = [
        f"{orders[group[0]]}" + (f" to {orders[group[-1]]}" if group.size > 1 else "")
        for group in groups
    ]
    more = len(words) - _MOST_RANGES
    return ", ".join(words[:_MOST_RANGES]) + (f" and {more} more" if more > 0 else "")


def _other_joints(record: Record, clearances: Sequence[str]) -> list[str]:
    rows = []
    for name, words in _JOINTS:
        force, count = (
            having(record, f"{_STEM}{name}/{what}", "clearance")
            for what in ("mean_force", "impacts")
        )
        errors = standard_errors(record, f"{name}/mean_force")
        for i, clearance in enumerate(clearances):
            if force is None and count is None:
                continue
            cells = ["" if q is None else _cell(q, "", i) for q in (force, count)]
            spread = "" if errors is None else show_error(float(errors[i]))
            rows.append([words, clearance, cells[0], spread, cells[1]])
    if not rows:
        return []
    columns = (
        Column("also at the"),
        number("wrist pin play mm"),
        number("mean force N"),
        number("+-"),
        number("impacts per turn"),
    )
    return table(columns, rows)


def _first_contacts(record: Record, clearances: Sequence[str]) -> list[str]:
    """From rest in the joint; these come before chaos, so that others can reproduce them."""
    quantity = having(record, _STEM + "first_contacts", "clearance", "contact")
    if quantity is None:
        return []
    count = min(quantity.values.shape[1], _CONTACTS)
    error = math.degrees(quantity.error_estimate)
    rows = []
    for clearance, angles in zip(clearances, np.asarray(quantity.values, dtype=float), strict=True):
        cells = [
            show(math.degrees(angle), error) if math.isfinite(angle) else "-"
            for angle in angles[:count]
        ]
        rows.append([clearance, *cells])
    columns = (
        Column("first contacts at deg, play mm"),
        *(number(f"{i + 1}") for i in range(count)),
    )
    return table(columns, rows)


def _method(result: Result) -> list[str]:
    options = table_of(result.case, "response", "impact")
    if not options:
        return []
    method = str(options.get("method", "event_exact"))
    words = "closed form between exact contacts"
    if method != "event_exact":
        words = f"{method.replace('_', ' ')}, {options.get('steps')} steps per turn"
    runs, turns, before = (options.get(key) for key in ("members", "revolutions", "discard"))
    if None not in (runs, turns, before):
        words += f"; {runs} runs of {turns} turns that count, after {before} to forget the start"
    if options.get("pressure"):
        words += f"; gas pushes the piston {str(options['pressure']).replace('_', ' ')}"
    words += f"; {_mass_words(result)}"
    return paragraph(f"method: {words}")


def _mass_words(result: Result) -> str:
    """Which mass the play sets free."""
    if not table_of(result.case, "machine", "crank_train", "rod"):
        return "beyond the wrist pin's play is all the reciprocating mass of the case"
    crank_pin = table_of(result.case, "machine", "joints", "crank_pin")
    rod = "is a mass between two gaps" if crank_pin else "moves with the crank"
    return f"beyond the wrist pin's play are piston and pin, the rod's reciprocating share {rod}"
