"""A case as tomllib reads it: what can be read of it, while anything may stand anywhere."""

import difflib
from collections.abc import Iterator
from typing import Any

from vibecalc.errors import KeyPath, Problem, UnitError
from vibecalc.units import parse_quantity

Data = dict[str, Any]


def table_at(data: Any, *path: str | int) -> Any:
    """Return the table at a path, or an empty one if there is none."""
    for part in path:
        if isinstance(part, str):
            data = data.get(part) if isinstance(data, dict) else None
        else:
            data = data[part] if isinstance(data, list) and part < len(data) else None
    return data if isinstance(data, dict) else {}


def tables_at(data: Any, *path: str) -> list[tuple[int, Data]]:
    """Return the tables in the list at a path, each with its position."""
    entries = table_at(data, *path[:-1]).get(path[-1])
    if not isinstance(entries, list):
        return []
    return [(position, entry) for position, entry in enumerate(entries) if isinstance(entry, dict)]


def read_number(value: Any, unit: str) -> float | None:
    """Return a value in an SI unit, or None if it is no such number."""
    if value is None or isinstance(value, bool) or not isinstance(value, str | int | float):
        return None
    try:
        return parse_quantity(value, unit)
    except (UnitError, OverflowError):
        return None


def either(
    table: Data, path: KeyPath, one: str, others: tuple[str, ...], needed: bool = True
) -> Iterator[Problem]:
    """`one`, or some of `others`: not both, and, if `needed`, not none of them."""
    given = [key for key in others if key in table]
    listed = " and ".join(filter(None, (", ".join(others[:-1]), others[-1])))
    if one in table and given:
        yield Problem(
            path=(*path, given[0]),
            message=f"{given[0]} and {one} exclude each other",
            allowed=f"{one}, or {listed}: one way or the other",
            also=(*path, one),
        )
    elif needed and one not in table and not given and not misspelt(table, path, one, *others):
        yield Problem(
            path=path,
            message=f"[{'.'.join(map(str, path))}] has neither {one} nor {listed}",
            allowed=f"{one}, or {listed}",
        )


def misspelt(table: Data, path: KeyPath, *wanted: str) -> bool:
    """Tell whether a key that the schema does not know may be one of these with a slip in it."""
    from vibecalc.case.walk import keys_of, shape_at

    shape = shape_at(path)
    known = keys_of(shape.table) if shape is not None and shape.table is not None else {}
    return any(
        difflib.get_close_matches(str(key).lower()[:60], wanted, n=1)
        for key in table
        if key not in known
    )


def nearest(name: str, known: list[str]) -> str:
    """Return a hint at the name that may have been meant, capitals apart, or nothing."""
    lower = {each.lower(): each for each in reversed(known)}
    near = difflib.get_close_matches(name[:80].lower(), lower, n=1)
    return f"did you mean {lower[near[0]]!r}?" if near else ""


def listed(names: list[str]) -> str:
    """Return up to a dozen names in quotes, for what is allowed."""
    shown = ", ".join(repr(name) for name in names[:12])
    return f"{shown} and {len(names) - 12} more" if len(names) > 12 else shown
