"""Impacts in the joints with play: statistics for each clearance, and what they rest on."""

import math
from dataclasses import replace

import numpy as np

from vibecalc.core.report.rows import Cells, Rows, part_of, rows_of
from vibecalc.core.report.sections import Part, Section, having, section, table_of
from vibecalc.core.report.writing import Column, number, paragraph, show, show_error, table
from vibecalc.core.results.record import Quantity, Record, Result

_ROOT = "response/impact"
_CONTACTS, _MOST_RANGES = 7, 4
_LEADERS = ("inertia of the piston", "added by impacts", "motor")
_JOINTS = (("crank_pin", "crank pin"), ("bore", "cylinder wall"))
#: a column of the tables, and what it is
_NOTES = (
    ("average_amplitude", "mean harmonic: amplitude of the joint force, mean over its orders"),
    ("mean_force", "+-: standard error of the mean, from the scatter of the runs"),
    ("dominant_from",
     "dominant from: order from which the force added by impacts is the largest on "
     "the body"),
    ("parting",
     "turns to diverge: two nearly equal starts (>: longer than the run); "
     "Lyapunov exponent: per turn; the motion is chaotic, so only statistics are results"),
    ("energy_residual", "energy error: imbalance / energy exchanged"),
)  # fmt: skip


def impact(result: Result) -> Section | None:
    """The section, None if the result has no impacts."""
    record = result.record
    if having(record, f"{_ROOT}/mean_force", "clearance") is None:
        return None
    shown = frozenset(path for path in record if path.startswith(f"{_ROOT}/"))
    words = "; ".join(words for path, words in _NOTES if f"{_ROOT}/{path}" in record)
    counts = rows_of(record, Rows("clearance", "", _counts(result), _ROOT, note=words))
    blocks: list[Part] = [rows_of(record, _FORCES), counts, _method(result)]
    details: dict[str, Part] = {
        "dominant force by order": _leaders(record),
        "other joints": _other_joints(record),
        "first contacts": rows_of(record, _FIRST),
    }
    return section("Impacts in joints with clearance", blocks, details, shown)


def _play(record: Record) -> Quantity:
    """Clearances in mm as names of rows."""
    found = record[f"{_ROOT}/mean_force"]
    return part_of(found, np.array(_clearances(found)), *found.axes)


def _clearances(quantity: Quantity) -> list[str]:
    return [f"{1e3 * float(value):.5g}" for value in quantity.axes[0].values]


def standard_error(record: Record) -> Quantity | None:
    """Of the mean force: that of each clearance, or the one number that all share."""
    stored = having(record, f"{_ROOT}/mean_force_standard_error", "clearance")
    force = having(record, f"{_ROOT}/mean_force", "clearance")
    if stored is not None or force is None or force.standard_error is None:
        return stored
    return part_of(force, np.full(force.values.shape, force.standard_error), *force.axes)


def _spread(error: float, _error: float) -> str:
    return show(error, digits=2)


_FORCES = Rows("clearance", "", (
    Cells(_play, "wrist pin\nclearance mm"),
    Cells("mean_force", "mean force N"),
    Cells(standard_error, "+-", _spread),
    Cells("mean_force_low", "5 %\nquantile"),
    Cells("mean_force_high", "95 %\nquantile"),
    Cells("average_amplitude", "mean\nharmonic N"),
    Cells("peak_force", "mean peak N"),
    Cells("peak_force_high", "95 %\nquantile"),
), _ROOT)  # fmt: skip


def _counts(result: Result) -> tuple[Cells, ...]:
    """What is counted in a turn, and how far runs are the same."""
    options = table_of(result.case, "response", "impact")
    watched = [options.get(key) for key in ("discard", "revolutions")]

    def until(value: float, _error: float) -> str:
        if math.isfinite(value):
            return f"{value:.3g}"
        # a longer run might part
        return "none seen" if None in watched else f"> {sum(map(int, map(str, watched)))}"

    return (
        Cells(_play, "wrist pin\nclearance mm"),
        Cells("impacts", "impacts/turn"),
        Cells("contact_share", "in contact %", "%"),
        Cells("dissipated", "loss/turn J"),
        Cells("parting", "turns to diverge", until, right=True),
        Cells("divergence", "Lyapunov exponent"),
        Cells("dominant_from", "dominant from", _from_order, right=True),
        Cells("energy_residual", "energy error", _residual),
    )


def _from_order(value: float, _error: float) -> str:
    return f"order {int(value)}" if value > 0 else "nowhere"


def _residual(value: float, _error: float) -> str:
    return show_error(value) if value else "0"


def _leaders(record: Record) -> list[str]:
    """At which orders which force is the largest."""
    quantity = having(record, f"{_ROOT}/dominant", "clearance", "order")
    if quantity is None:
        return []
    orders = np.asarray(quantity.axes[1].values)
    names = _LEADERS if f"{_ROOT}/motor" in record else _LEADERS[:2]
    rows = [
        [clearance, *(ranges(orders, row == i) for i in range(len(names)))]
        for clearance, row in zip(_clearances(quantity), quantity.values, strict=True)
    ]
    return table([Column("dominant at orders, clearance mm"), *map(Column, names)], rows)


def ranges(orders: np.ndarray, chosen: np.ndarray) -> str:
    """`1, 4 to 9`: the chosen orders, neighbours joined; `-` for none."""
    places = np.flatnonzero(chosen)
    groups = np.split(places, np.flatnonzero(np.diff(places) > 1) + 1) if places.size else []
    words = [
        f"{orders[group[0]]}" + f" to {orders[group[-1]]}" * (group.size > 1) for group in groups
    ]
    more = len(words) - _MOST_RANGES
    return (", ".join(words[:_MOST_RANGES]) or "-") + f" and {more} more" * (more > 0)


def _other_joints(record: Record) -> list[str]:
    rows = []
    for name, words in _JOINTS:
        force, count = (
            having(record, f"{_ROOT}/{name}/{what}", "clearance")
            for what in ("mean_force", "impacts")
        )
        if force is None or count is None:
            continue
        spread = "" if force.standard_error is None else show(force.standard_error, digits=2)
        for i, clearance in enumerate(_clearances(force)):
            size, contacts = (show(float(one.values[i]), one.error_estimate)
                              for one in (force, count))  # fmt: skip
            rows.append([words, clearance, size, spread, contacts])
    heads = ("wrist pin\nclearance mm", "mean force N", "+-", "impacts per turn")
    return table([Column("other joint"), *map(number, heads)], rows)


def _contacts(record: Record) -> Quantity | None:
    """From rest in the joint; these come before chaos, so that others can reproduce them."""
    found = having(record, f"{_ROOT}/first_contacts", "clearance", "contact")
    if found is None:
        return None
    axis = replace(found.axes[1], values=found.axes[1].values[:_CONTACTS])
    return part_of(found, found.values[:, :_CONTACTS], found.axes[0], axis)


_FIRST = Rows("clearance", "", (
    Cells(_play, "first contacts at deg, clearance mm"),
    Cells(_contacts, "{}", "deg", blank=True),
), _ROOT)  # fmt: skip


def _method(result: Result) -> list[str]:
    options = table_of(result.case, "response", "impact")
    if not options:
        return []
    method = str(options.get("method", "event_exact"))
    words = "event-exact, closed form between contacts"
    if method != "event_exact":
        words = f"{method.replace('_', ' ')}, {options.get('steps')} steps per turn"
    if {"members", "revolutions", "discard"} <= options.keys():
        words += f"; {options['members']} runs of {options['revolutions']} turns evaluated, after "
        words += f"{options['discard']} discarded"
    if options.get("pressure"):
        towards = str(options["pressure"]).replace("_", " the ")
        words += f"; gas pushes the piston {towards}"
    return paragraph(f"method: {words}; {_mass_words(result)}")


def _mass_words(result: Result) -> str:
    """Which mass the play sets free."""
    if not table_of(result.case, "machine", "crank_train", "rod"):
        return "free mass: all the reciprocating mass of the case"
    crank_pin = table_of(result.case, "machine", "joints", "crank_pin")
    rod = "is a mass between two gaps" if crank_pin else "moves with the crank"
    return f"free mass: piston and pin; the rod's reciprocating share {rod}"
