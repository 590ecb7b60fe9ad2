"""Search methods side by side: where each ended on its own, and what it cost."""

import math

import numpy as np

from vibecalc.report.lookup import along, labels
from vibecalc.report.numbers import show
from vibecalc.report.tables import Column, number, table
from vibecalc.results.record import Record, Result

_PREFIX = "optimisation/methods/"
_ROOM = 13


def methods(result: Result) -> list[str]:
    """One line for each compared method; seconds from the timings, `-` where there are none."""
    record = result.record
    objective = along(record, _PREFIX + "objective", "method")
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
    return float(np.asarray(record[_PREFIX + name].values)[i])


def _cell(record: Record, name: str, i: int) -> str:
    quantity = record[_PREFIX + name]
    return show(quantity.values[i], quantity.error_estimate, digits=3)
