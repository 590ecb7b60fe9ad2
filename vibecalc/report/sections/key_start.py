"""Where a variable of an optimisation started."""

from typing import Any

from vibecalc.report.lookup import START, scalar_of
from vibecalc.results.record import Result

VARIABLE = "optimisation/variable/"


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
