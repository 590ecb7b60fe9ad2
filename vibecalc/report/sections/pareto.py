"""The front between two objectives: one line for each of its points."""

from collections.abc import Mapping
from typing import Any

from vibecalc.report.lookup import along, table_of
from vibecalc.report.numbers import show
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Quantity, Result

PREFIX = "optimisation/front/"
#: variables that fit beside the objectives
_MOST = 4
_ROOM = 14


def front(result: Result) -> list[str]:
    """Objectives and the first variables along the front, all numbers of the result."""
    one = along(result.record, PREFIX + "objective", "front_point")
    two = along(result.record, PREFIX + "second_objective", "front_point")
    if one is None or two is None:
        return []
    study: Mapping[str, Any] = table_of(result.case, "optimisation")
    keys = [str(variable["key"]) for variable in study.get("variables") or ()]
    variables = [result.record.quantities.get(f"{PREFIX}variable/{key}") for key in keys]
    shown = [(key, q) for key, q in zip(keys, variables, strict=True) if q is not None]
    columns = [Column("front", 5), _column("objective", one[0]), _column("second", two[0])]
    columns += [_column(_last(key), quantity) for key, quantity in shown[:_MOST]]
    parts = [one[0], two[0], *(quantity for _, quantity in shown[:_MOST])]
    rows = [
        [str(i + 1), *(show(part.values[i], part.error_estimate) for part in parts)]
        for i in range(len(one[1]))
    ]
    second = table_of(study, "second_objective")
    words = f"front: the best objective for each {second.get('quantity')}"
    if len(shown) > _MOST:
        words += f"; {len(shown) - _MOST} further variables are in the result file"
    return ["", *paragraph(words), *table(columns, rows)]


def _column(title: str, quantity: Quantity) -> Column:
    return number(f"{title} {quantity.unit}".rstrip(), _ROOM)


def _last(key: str) -> str:
    """The end of a key, with its table where the end alone says little."""
    return ".".join(key.rsplit(".", 2)[-2:])
