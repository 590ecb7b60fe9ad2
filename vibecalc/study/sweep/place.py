"""The case at one point of a sweep, as plain tables in SI."""

from collections.abc import Collection, Mapping
from typing import Any

from vibecalc.case.overrides import parse_key
from vibecalc.errors import KeyPath

#: tables that a run of one point does not read
NOT_COMPUTED = ("sweep", "optimisation", "find", "reference", "reference_table", "limit")


def case_at(
    resolved: Mapping[str, Any],
    settings: Mapping[str, Any],
    without: Collection[str] = NOT_COMPUTED,
) -> dict[str, Any]:
    """Set some keys of a case in SI and leave out the tables `without`.

    Nothing that is passed in changes; what is not on the way to a key is shared, not copied.
    """
    changed: Any = {name: table for name, table in resolved.items() if name not in without}
    for key, value in settings.items():
        changed = _replaced(changed, parse_key(key), value)
    return dict(changed)


def _replaced(place: Any, path: KeyPath, value: Any) -> Any:
    if not path:
        return value
    first, rest = path[0], path[1:]
    if isinstance(first, int):
        entries = list(place)  # a list that the case leaves out begins as an empty table
        old = entries[first] if first < len(entries) else {}
        entries[first : first + 1] = [_replaced(old, rest, value)]
        return entries
    return {**place, first: _replaced(place.get(first, {}), rest, value)}
