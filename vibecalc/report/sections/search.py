"""How an optimum was found: what holds it, distinct optima, one line for each search."""

import math

from vibecalc.report.lookup import along, labels
from vibecalc.report.numbers import show
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Quantity, Record

_PREFIX = "optimisation/"
_ROWS = 12
_SIDES = {-1: "at lower", 0: "", 1: "at upper"}


def holding(record: Record) -> list[str]:
    """Limits with their margin at the optimum; active ones have a multiplier."""
    margin = along(record, _PREFIX + "margin", "limit")
    multiplier = along(record, _PREFIX + "multiplier", "limit")
    if margin is None or multiplier is None:
        return []
    rows = []
    for i, name in enumerate(labels(margin[0].axes[0])):
        rise = float(multiplier[0].values[i])
        rows.append(
            [
                name,
                show(float(margin[0].values[i]), margin[0].error_estimate),
                show(rise, multiplier[0].error_estimate),
                multiplier[0].unit,
                "active" if rise else "",
            ]
        )
    columns = (
        Column("limit", 46),
        number("margin / limit", 14),
        number("multiplier", 13),
        Column("unit", 8),
        Column("", 8),
    )
    return ["", *table(columns, rows)]


def side_of(record: Record, key: str) -> str:
    """`at lower` or `at upper` for a variable on a bound, else nothing."""
    quantity = record.quantities.get(f"{_PREFIX}active_bound/{key}")
    return _SIDES.get(int(quantity.values), "") if quantity is not None else ""


def optima(record: Record) -> list[str]:
    """Distinct optima, best first, with the number of searches that ended there."""
    objective = along(record, _PREFIX + "optima/objective", "optimum")
    found_by = along(record, _PREFIX + "optima/found_by", "optimum")
    if objective is None or found_by is None:
        return []
    rows = [
        [str(int(label)), _objective(objective[0], i), str(int(found_by[0].values[i]))]
        for i, label in enumerate(objective[1][:_ROWS])
    ]
    columns = (
        Column("optimum", 8),
        number(f"objective {objective[0].unit}".rstrip(), 20),
        number("searches", 10),
    )
    return ["", *table(columns, rows), *_rest(len(objective[1]), "optima")]


def searches(record: Record) -> list[str]:
    """One line for each search: where its objective ended, whether the limits were kept."""
    objective = along(record, _PREFIX + "history/objective", "search")
    feasible = along(record, _PREFIX + "history/feasible", "search")
    evaluations = along(record, _PREFIX + "history/evaluations", "search")
    if objective is None or feasible is None or evaluations is None:
        return []
    rows = [
        [
            str(int(label)),
            _objective(objective[0], i),
            "yes" if feasible[0].values[i] else "no",
            str(int(evaluations[0].values[i])),
        ]
        for i, label in enumerate(objective[1][:_ROWS])
    ]
    columns = (
        Column("search", 8),
        number(f"objective {objective[0].unit}".rstrip(), 20),
        number("limits kept", 12),
        number("evaluations", 12),
    )
    return ["", *table(columns, rows), *_rest(len(objective[1]), "searches")]


def _objective(quantity: Quantity, i: int) -> str:
    value = float(quantity.values[i])
    return "failed" if math.isinf(value) else show(value, quantity.error_estimate)


def _rest(count: int, noun: str) -> list[str]:
    if count <= _ROWS:
        return []
    return paragraph(f"{count - _ROWS} further {noun} are in the result file")
