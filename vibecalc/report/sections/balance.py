"""The balance table, as an engineer lays it out: a line for each cylinder and a total."""

import math

import numpy as np

from vibecalc.report.lookup import START, along, labels
from vibecalc.report.numbers import show
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Quantity, Record, Result

_ENTRIES = ("sine", "cosine", "position_sine", "position_cosine")
_HEADS = ("sin", "cos", "z sin m", "z cos m")
_PREFIX = "excitation/balance/"
_NOTHING = 1e-12
_BANKS = (
    *("sum", "position_sum", "rotating", "counter_rotating"),
    *("position_rotating", "position_counter_rotating"),
)
_KINDS = ("force", "couple m")
_WORDS_OF_BANKS = (
    "force: 1 is that of one cylinder at the order, 0-pk; couple: the same times z; rotating with "
    "the crank, counter-rotating against it, both the order times as fast: the largest is their sum"
)


def balance(result: Result) -> tuple[list[str], set[str]]:
    """Lines and the paths shown; nothing if the result has no balance table.

    At an optimum the table of the start follows: how they differ is what was asked.
    """
    notes = "z: position along the crankshaft; the angle is that of the order"
    lines, shown = _table(result.record, _PREFIX, f"Balance table ({notes})")
    before, begun = _table(result.record, START + _PREFIX, "Balance table at the start")
    return lines + before, shown | begun


def _table(record: Record, prefix: str, title: str) -> tuple[list[str], set[str]]:
    found = [quantity for name in _ENTRIES if (quantity := _entry(record, prefix + name))]
    if len(found) != len(_ENTRIES):
        return [], set()
    order_axis, cylinder_axis = found[0].axes
    totals = [along(record, f"{prefix}total_{name}", "order") for name in _ENTRIES]
    shown = {quantity.path for quantity in found}
    shown |= {total[0].path for total in totals if total}
    lines = ["", f"  {title}"]
    for row, order in enumerate(order_axis.values):
        columns = [Column(f"order {int(order)}", 14), number("angle deg", 11), number("z m")]
        columns += [number(head) for head in _HEADS]
        cells = []
        for i, name in enumerate(labels(cylinder_axis)):
            entries = [float(quantity.values[row, i]) for quantity in found]
            errors = [_doubt(quantity) for quantity in found]
            cells.append(
                [
                    name,
                    f"{_angle(entries):.2f}",
                    show(_position(entries), errors[2] + errors[3]),
                    *(show(entry, error) for entry, error in zip(entries, errors, strict=True)),
                ]
            )
        sums = [show(total[0].values[row], _doubt(total[0])) if total else "" for total in totals]
        below = [["total", "", "", *sums]] if any(totals) else []
        lines += ["", *table(columns, cells, below)]
    sums_of_banks, more = _banks(record, prefix)
    return lines + sums_of_banks, shown | more


def _banks(record: Record, prefix: str) -> tuple[list[str], set[str]]:
    """Sums of several banks: along two directions, and turning with the crank and against it."""
    found = [record.quantities.get(f"{prefix}banks/{name}") for name in _BANKS]
    vectors = [quantity for quantity in found[:2] if quantity is not None]
    circles = [quantity for quantity in found[2:] if quantity is not None]
    if len(vectors) != 2 or len(circles) != 4:
        return [], set()
    names = labels(vectors[0].axes[1])
    size = np.max([np.abs(one.values).max(0) for one in vectors], axis=0)
    shown = [place for place in range(len(names)) if size[place] > 0.0]
    heads = [f"along {names[place]}" for place in shown]
    columns = [number("order", 8), Column("of", 10)]
    columns += [number(head, 16) for head in (*heads, "rotating", "counter-rotating")]
    rows = []
    for row, order in enumerate(vectors[0].axes[0].values):
        for of, vector, pair in zip(_KINDS, vectors, (circles[:2], circles[2:]), strict=True):
            lengths = [abs(complex(vector.values[row, place])) for place in shown]
            cells = [show(one, vector.error_estimate) for one in lengths]
            cells += [show(float(one.values[row]), one.error_estimate) for one in pair]
            rows.append([str(int(order)), of, *cells])
    title = "Sums over the banks: vectors, each cylinder along its own axis"
    lines = ["", f"  {title}", "", *table(columns, rows), *paragraph(_WORDS_OF_BANKS)]
    return lines, {quantity.path for quantity in (*vectors, *circles)}


def _entry(record: Record, path: str) -> Quantity | None:
    quantity = record.quantities.get(path)
    if quantity is None or [axis.name for axis in quantity.axes] != ["order", "cylinder"]:
        return None
    return quantity


def _doubt(quantity: Quantity) -> float:
    """What prints as 0: a search leaves the last digits of an angle open, which no table wants."""
    largest = float(np.max(np.abs(quantity.values), initial=0.0))
    return float(max(quantity.error_estimate, _NOTHING * largest))


def _angle(entries: list[float]) -> float:
    """Degrees in [0, 360) from sine and cosine, so that they belong together at an optimum too."""
    turned = round(math.degrees(math.atan2(entries[0], entries[1])) % 360.0, 2)
    return 0.0 if turned == 360.0 else turned


def _position(entries: list[float]) -> float:
    """z from z sin and z cos."""
    sine, cosine, position_sine, position_cosine = entries
    return position_sine * sine + position_cosine * cosine
