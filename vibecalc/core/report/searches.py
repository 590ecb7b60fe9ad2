"""How an optimum was found: what holds it; searches, methods and points of a front in rows."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from vibecalc.core.report.sections import along, labels, table_of
from vibecalc.core.report.writing import Column, number, paragraph, show, table
from vibecalc.core.results.record import Quantity, Record, Result

# ----------------------------------------------------------------------------
# How an optimum was found: what holds it, distinct optima, one line for each search.
# ----------------------------------------------------------------------------

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


# ----------------------------------------------------------------------------
# Search methods side by side: where each ended on its own, and what it cost.
# ----------------------------------------------------------------------------

_METHODS_PREFIX = "optimisation/methods/"
_ROOM = 13


def search_methods(result: Result) -> list[str]:
    """One line for each compared method; seconds from the timings, `-` where there are none."""
    record = result.record
    objective = along(record, _METHODS_PREFIX + "objective", "method")
    if objective is None:
        return []
    names = labels(objective[0].axes[0])
    rows = []
    for i, name in enumerate(names):
        seconds = result.timings.get(f"method {name}")
        residual = _value(record, "kkt_residual", i)
        rows.append(
            [
                name,
                show(objective[0].values[i], objective[0].error_estimate),
                _cell(record, "shortfall", i),
                _cell(record, "distance", i),
                "kink" if math.isinf(residual) else f"{residual:.1e}",
                show(int(_value(record, "evaluations", i))),
                "-" if seconds is None else f"{seconds:.2f}",
                "yes" if _value(record, "converged", i) else "NO",
            ]
        )
    unit = objective[0].unit
    columns = (
        Column("methods side by side", 22),
        number(f"objective {unit}".rstrip(), _ROOM),
        number(f"too high by {unit}".rstrip(), 11),
        number("distance", 9),
        number("residual", 9),
        number("points", 7),
        number("s", 7),
        Column("converged", 9),
    )
    return ["", *table(columns, rows)]


def _value(record: Record, name: str, i: int) -> float:
    return float(np.asarray(record[_METHODS_PREFIX + name].values)[i])


def _cell(record: Record, name: str, i: int) -> str:
    quantity = record[_METHODS_PREFIX + name]
    return show(quantity.values[i], quantity.error_estimate, digits=3)


# ----------------------------------------------------------------------------
# The front between two objectives: one line for each of its points.
# ----------------------------------------------------------------------------

FRONT_PREFIX = "optimisation/front/"
#: variables that fit beside the objectives
_MOST = 4
_FRONT_ROOM = 14


def front(result: Result) -> list[str]:
    """Objectives and the first variables along the front, all numbers of the result."""
    one = along(result.record, FRONT_PREFIX + "objective", "front_point")
    two = along(result.record, FRONT_PREFIX + "second_objective", "front_point")
    if one is None or two is None:
        return []
    study: Mapping[str, Any] = table_of(result.case, "optimisation")
    keys = [str(variable["key"]) for variable in study.get("variables") or ()]
    variables = [result.record.quantities.get(f"{FRONT_PREFIX}variable/{key}") for key in keys]
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
    return number(f"{title} {quantity.unit}".rstrip(), _FRONT_ROOM)


def _last(key: str) -> str:
    """The end of a key, with its table where the end alone says little."""
    return ".".join(key.rsplit(".", 2)[-2:])
