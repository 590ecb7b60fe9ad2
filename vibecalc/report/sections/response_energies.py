"""Energies of the moving body: order by order until they no longer count, then altogether."""

import numpy as np

from vibecalc.report.lookup import having, scalar_of
from vibecalc.report.numbers import show
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Quantity, Record

_FIELDS = (
    ("kinetic", "mean"),
    ("kinetic", "peak"),
    ("potential", "mean"),
    ("potential", "peak"),
)
#: orders below this share of the largest are counted instead of shown
FAINT = 1e-6
_ROWS = 16
#: energies that end below this end because smaller numbers do not exist
_NEAR_UNDERFLOW = 1e-280
#: the smallest double with all its digits
SMALLEST = float(np.finfo(float).tiny)


def energies(record: Record) -> tuple[list[str], set[str]]:
    """Table of mean and peak energies by order with their totals, and the paths shown."""
    by_order = {
        field: quantity
        for field in _FIELDS
        if (quantity := having(record, _path(field) + "_by_order", "order")) is not None
    }
    totals = {field: path for field in _FIELDS if (path := _path(field)) in record}
    if not by_order and not totals:
        return [], set()
    columns = (
        Column("energy in J", 14),
        *(number(f"{kind} {what}", 18) for kind, what in _FIELDS),
    )
    orders, lines = np.array([], dtype=int), []
    if by_order:
        orders = np.asarray(next(iter(by_order.values())).axes[0].values)
    chosen, more = _chosen(list(by_order.values()))
    rows = [
        [f"order {int(orders[i])}", *(_cell(by_order.get(field), i) for field in _FIELDS)]
        for i in chosen
    ]
    below = []
    if any(scalar_of(record, path) is not None for path in totals.values()):
        below = [["all orders", *(_total(record, _path(field)) for field in _FIELDS)]]
    lines += table(columns, rows, below)
    if more:
        lines += paragraph(_rest(by_order, orders, chosen, more))
    lines += paragraph(
        "mean: over one turn; peak of all orders: the largest at any moment, phases counted, "
        "which is not the sum of the peaks of the orders"
    )
    return lines, {quantity.path for quantity in by_order.values()} | set(totals.values())


def last_normal(values: np.ndarray) -> tuple[int, bool]:
    """Place of the last entry that is a full double (-1: none); whether underflow ends them."""
    above = np.flatnonzero(values >= SMALLEST)
    if not above.size:
        return -1, False
    last = int(above[-1])
    return last, last + 1 < values.size and bool(values[last] < _NEAR_UNDERFLOW)


def _path(field: tuple[str, str]) -> str:
    kind, what = field
    return f"response/{kind}_energy/{what}"


def _chosen(quantities: list[Quantity]) -> tuple[list[int], int]:
    """Places of the orders to show, and how many further ones have an energy at all."""
    if not quantities:
        return [], 0
    rows = np.array([np.asarray(quantity.values, dtype=float) for quantity in quantities])
    largest = rows.max(axis=1, keepdims=True, initial=0.0)
    acting = np.any(rows >= SMALLEST, axis=0)
    loud = np.any((rows > FAINT * largest) & (rows > 0.0), axis=0)
    chosen = np.flatnonzero(loud)[:_ROWS]
    return [int(i) for i in chosen], int(acting.sum() - chosen.size)


def _rest(
    by_order: dict[tuple[str, str], Quantity], orders: np.ndarray, chosen: list[int], more: int
) -> str:
    """How many orders are not shown, how small they get, and where they underflow."""
    (kind, what), quantity = next(iter(by_order.items()))
    values = np.asarray(quantity.values, dtype=float)
    last, underflows = last_normal(values)
    noun = "order" if more == 1 else "orders"
    limit = f"each below {FAINT:.0e} of the largest" if len(chosen) < _ROWS else "smaller ones too"
    words = f"{more} further {noun} up to {int(orders[last])}, {limit}; the {what} {kind} energy "
    words += f"of the last is {show(float(values[last]))} {quantity.unit}"
    if underflows:
        return words + ", and beyond it they are below the smallest double"
    return words + ", still above the smallest double"


def _cell(quantity: Quantity | None, i: int) -> str:
    return "" if quantity is None else show(quantity.values[i], quantity.error_estimate)


def _total(record: Record, path: str) -> str:
    value = scalar_of(record, path)
    return "" if value is None else show(value, record[path].error_estimate)
