"""Where a variable of an optimisation started, and in which unit a case thinks of it."""

from collections.abc import Mapping
from typing import Any

from vibecalc.report.lookup import START, scalar_of, table_of
from vibecalc.results.record import Quantity, Result
from vibecalc.units import convert, split_number

VARIABLE = "optimisation/variable/"


def bound_unit(table: Mapping[str, Any], unit: str) -> str:
    """Unit of the bounds of a variable or a search, as the case writes it; `unit` without one."""
    for side in ("upper", "lower"):
        bound = table.get(side)
        written = split_number(bound)[1] if isinstance(bound, str) else ""
        if written:
            return written
    return unit


def bound_units(case: Mapping[str, Any]) -> dict[str, str]:
    """Paths of variables and of values found, with the unit of their bounds if these have one."""
    study: Any = table_of(case, "optimisation").get("variables") or ()
    found = {VARIABLE + str(one["key"]): bound_unit(one, "") for one in study}
    searches: Any = case.get("find") or ()
    found |= {f"find/{one['name']}/value": bound_unit(one, "") for one in searches}
    return {path: unit for path, unit in found.items() if unit}


def in_unit(quantity: Quantity, unit: str) -> tuple[float, float]:
    """A scalar and its error in another unit."""
    value = float(quantity.values)
    return convert(value, quantity.unit, unit), convert(
        quantity.error_estimate, quantity.unit, unit
    )


def start_of(result: Result, key: str) -> float | None:
    """The start value of a variable: from the record, else as the case has it; None if neither."""
    kept = scalar_of(result.record, START + VARIABLE + key)
    if kept is not None:
        return kept
    found: Any = result.case
    for name in key.replace("[", ".").replace("]", "").split("."):
        try:
            found = found[int(name)] if name.isdigit() else found[name]
        except (KeyError, IndexError, TypeError):
            return None
    return float(found) if isinstance(found, int | float) else None
