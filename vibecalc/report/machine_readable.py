"""The object that `--json` prints. Its keys are a contract with scripts of others."""

import math
from pathlib import Path
from typing import Any

import numpy as np

from vibecalc.report.limits import LimitRow, judge_limits
from vibecalc.report.lookup import magnitudes
from vibecalc.report.references import ReferenceRow, judge_references
from vibecalc.results.record import ROUNDING, Quantity, Result

#: lists of numbers that a reader acts on, beside the scalars
_LISTS = ("response/torsion/barred/from", "response/torsion/barred/to")


def as_json(
    result: Result, path: Path | str | None = None, *, full: bool = False
) -> dict[str, Any]:
    """The result as a plain object that `json.dumps(..., allow_nan=False)` takes.

    `result` is the path of the result file. `quantities` has the scalars, a complex one as its
    magnitude, and the barred ranges of a shaft line, with `full` all arrays: `value` as lists along
    the `axes`, of what is complex `real` and `imaginary`. What is zero to rounding of its terms is
    0; what is no larger than its `error` for another reason is not `resolved`. What is undefined is
    None, and so is what is infinite, since JSON has no word for it; an infinite limit entry still
    says `kept: false`. An undecided one has `kept: null` and says what would decide it.
    """
    return {
        "case": result.name,
        "result": None if path is None else str(path),
        "quantities": {
            quantity.path: _array(quantity) if quantity.axes else _number(quantity)
            for quantity in result.record.values()
            if full or not quantity.axes or quantity.path in _LISTS
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
        "error": _finite(row.error_estimate),
        "resolved": row.resolved,
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
        "error": _finite(row.error_estimate),
        "margin": _finite(row.margin),
        "kept": row.kept,
        "verdict": row.state,
        "decided_by": row.decided_by or None,
    }


def _number(quantity: Quantity) -> dict[str, Any]:
    value = magnitudes(quantity)[()]
    shown: float | int | str | None
    if value.dtype.kind in "biu":
        shown = int(value)
    else:
        shown = _finite(float(value)) if value.dtype.kind == "f" else str(value)
    known = not isinstance(shown, int | float)
    if not known and quantity.estimate.is_zero(float(value)):
        shown = 0.0 if isinstance(shown, float) else shown
    return {
        "value": shown,
        "unit": quantity.unit,
        "error": _finite(quantity.error_estimate),
        "resolved": known or not quantity.estimate.unresolved(float(value)),
    }


def _array(quantity: Quantity) -> dict[str, Any]:
    values, error = np.asarray(quantity.values), quantity.estimate
    if values.dtype.kind in "fc" and error <= ROUNDING * error.terms:
        values = np.where(np.abs(values) <= error, 0.0, values)
    parts = {"value": values}
    if values.dtype.kind == "c":
        parts = {"real": values.real, "imaginary": values.imag}
    return {
        **{name: _list(part) for name, part in parts.items()},
        "unit": quantity.unit,
        "error": _finite(quantity.error_estimate),
        "axes": [
            {"name": axis.name, "unit": axis.unit, "values": _list(axis.values)}
            for axis in quantity.axes
        ],
    }


def _list(values: np.ndarray) -> list[Any]:
    """Nested lists of plain numbers and texts, None for what is not finite."""
    if values.dtype.kind == "f" and not np.isfinite(values).all():
        plain = values.astype(object)
        plain[~np.isfinite(values)] = None
        values = plain
    elif values.dtype.kind not in "biuf":
        values = np.vectorize(str, otypes=[object])(values) if values.size else values
    return list(values.tolist())


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
