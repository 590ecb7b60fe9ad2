"""What physics and plan find wrong with a case whose form is still wrong.

They work on the case as tomllib reads it: what they cannot read they leave to the schema.
"""

from collections.abc import Iterator
from typing import Any

from vibecalc.errors import KeyPath, Problem, UnitError
from vibecalc.units import parse_quantity

#: result paths that a study adds, known once the whole case can be read
_OF_STUDIES = ("optimisation/", "find/")


def early_problems(data: dict[str, Any]) -> list[Problem]:
    """A rod that is too short, and quantities that no case computes; never raises on nonsense."""
    return [*_rod(data), *_quantities(data)]


def _rod(data: dict[str, Any]) -> list[Problem]:
    from vibecalc.parts.crank_train import rod_problems

    train = _table(_table(data, "machine"), "crank_train")
    radius, rod_length = _length(train, "crank_radius"), _length(train, "rod_length")
    offset = _length(train, "wrist_pin_offset") if "wrist_pin_offset" in train else 0.0
    if radius is None or rod_length is None or offset is None or min(radius, rod_length) <= 0.0:
        return []
    return rod_problems(radius, rod_length, abs(offset))


def _quantities(data: dict[str, Any]) -> Iterator[Problem]:
    from vibecalc.pipeline.catalogue import CATALOGUE
    from vibecalc.pipeline.targets import unknown_quantity

    for path, quantity in _named(data):
        if quantity and quantity not in CATALOGUE and not quantity.startswith(_OF_STUDIES):
            yield unknown_quantity(path, quantity, CATALOGUE)


def _named(data: dict[str, Any]) -> Iterator[tuple[KeyPath, str]]:
    for name in ("reference", "limit", "find"):
        rows = data.get(name)
        for index, row in enumerate(rows if isinstance(rows, list) else ()):
            if isinstance(row, dict) and isinstance(row.get("quantity"), str):
                yield (name, index), row["quantity"]
    for name in ("objective", "second_objective"):
        goal = _table(_table(data, "optimisation"), name).get("quantity")
        if isinstance(goal, str):
            yield ("optimisation", name), goal


def _table(data: dict[str, Any], key: str) -> dict[str, Any]:
    found = data.get(key)
    return found if isinstance(found, dict) else {}


def _length(table: dict[str, Any], key: str) -> float | None:
    value = table.get(key)
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        return None
    try:
        return parse_quantity(value, "m")
    except (UnitError, OverflowError):
        return None
