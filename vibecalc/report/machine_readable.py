"""The object that `--json` prints. Its keys are a contract with scripts of others."""

import math
from pathlib import Path
from typing import Any

from vibecalc.report.limits import LimitRow, judge_limits
from vibecalc.report.lookup import magnitudes
from vibecalc.report.references import ReferenceRow, judge_references
from vibecalc.results.record import Quantity, Result

#: lists of numbers that a reader acts on, beside the scalars
_LISTS = ("response/torsion/barred/from", "response/torsion/barred/to")


def as_json(result: Result, path: Path | str | None = None) -> dict[str, Any]:
    """The result as a plain object that `json.dumps(..., allow_nan=False)` takes.

    `result` is the path of the result file. `quantities` has the scalars, a complex one as its
    magnitude, and the barred ranges of a shaft line as lists. What is undefined is None, and so is
    what is infinite, since JSON has no word for it; an infinite limit entry still says `kept:
    false`.
    """
    return {
        "case": result.name,
        "result": None if path is None else str(path),
        "quantities": {
            quantity.path: {"value": _scalar(quantity), "unit": quantity.unit}
            for quantity in result.record.values()
            if not quantity.axes or quantity.path in _LISTS
        },
        "references": [_reference(row) for row in judge_references(result)],
        "limits": [_limit(row) for row in judge_limits(result)],
        "timings": {stage: float(seconds) for stage, seconds in result.timings.items()},
    }


def _reference(row: ReferenceRow) -> dict[str, Any]:
    return {
        "quantity": row.quantity,
        "where": dict(row.where),
        "source": row.source,
        "value": row.value,
        "computed": _finite(row.computed),
        "unit": row.unit,
        "relative_difference": row.relative_difference,
        "within": row.within,
        "kind": row.kind,
        "known_difference": row.known_difference or None,
    }


def _limit(row: LimitRow) -> dict[str, Any]:
    return {
        "quantity": row.quantity,
        "where": dict(row.where),
        "min": row.min,
        "max": row.max,
        "unit": row.unit,
        "computed": _finite(row.computed),
        "margin": _finite(row.margin),
        "kept": row.kept,
    }


def _scalar(quantity: Quantity) -> float | int | str | list[float] | None:
    if quantity.axes:
        return [float(one) for one in quantity.values]
    value = magnitudes(quantity)[()]
    if value.dtype.kind in "biu":
        return int(value)
    return _finite(float(value)) if value.dtype.kind == "f" else str(value)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
