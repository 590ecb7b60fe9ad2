"""What a result file holds: its head and a row for each quantity."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from vibecalc.core.report.sections import largest_of, magnitudes
from vibecalc.core.report.text import identity
from vibecalc.core.report.writing import finite, heading, number, pairs, show, table, text_of
from vibecalc.core.results.record import Quantity, Result


def render_contents(result: Result) -> str:
    """Case, program, stages; under each group the quantities, with unit, axes and size."""
    lines = heading(str(result.case.get("title") or result.name), 1) + pairs(_head(result))
    groups: dict[str, list[Quantity]] = {}
    for path, quantity in result.items():
        groups.setdefault(path.rpartition("/")[0], []).append(quantity)
    columns = "quantity", number("value or largest"), "unit", "axes"
    for group, members in groups.items():
        rows = [[one.path.rpartition("/")[2], _size(one), one.unit, _axes(one)] for one in members]
        lines += ["", group, *table(columns, rows)]
    return text_of(lines)


def contents_object(result: Result) -> dict[str, Any]:
    """What `info --json` prints."""
    head = {name.replace(" ", "_"): words for name, words in _head(result)}
    quantities = {
        path: {
            "unit": one.unit,
            "long_name": one.long_name,
            "amplitude": one.amplitude,
            "error": finite(float(one.error_estimate)),
            "axes": {axis.name: len(axis.values) for axis in one.axes},
        }
        for path, one in result.items()
    }
    return {**head, "warnings": list(result.record.warnings), "quantities": quantities}


def _head(result: Result) -> list[tuple[str, str]]:
    given: Mapping[str, Any] = result.provenance
    rows = [
        *identity(result),
        ("stages", ", ".join(stage["stage"] for stage in result.plan)),
        ("written", f"{given.get('time', '')} by vibecalc {result.version}".strip()),
        ("command", str(given.get("command", ""))),
        ("sha256 of the case", result.case_sha256),
    ]
    return [(name, words) for name, words in rows if words]


def _size(quantity: Quantity) -> str:
    values = np.asarray(quantity.values)
    if values.dtype.kind not in "biufc":
        return str(values.item()) if values.ndim == 0 else ""
    if values.ndim == 0:
        return show(values.item(), quantity.error_estimate)
    known = magnitudes(quantity)[np.isfinite(values)]
    return show(largest_of(known), quantity.error_estimate) if known.size else "none"


def _axes(quantity: Quantity) -> str:
    return ", ".join(f"{axis.name} ({len(axis.values)})" for axis in quantity.axes)
