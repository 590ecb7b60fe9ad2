"""A case as plain tables, before any schema: read, looked up and changed by a key as `a.b[0].c`."""

import difflib
import re
import tomllib
from collections.abc import Collection, Iterator, Mapping, MutableMapping, Sequence
from pathlib import Path
from typing import Any

from vibecalc.core.case.locate import Overridden
from vibecalc.core.results.renamed import renamed
from vibecalc.core.results.visible import fits_a_line
from vibecalc.errors import KeyPath, Problem, UnitError, UsageError, dotted
from vibecalc.units import parse_quantity

# ----------------------------------------------------------------------------
# A case as tomllib reads it: what can be read of it, while anything may stand anywhere.
# ----------------------------------------------------------------------------

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


#: in a path: every entry of the list
EACH = "*"


def entries_at(data: Data, place: KeyPath) -> Iterator[tuple[KeyPath, Any]]:
    """The place with what stands there, or every entry of a list that has it."""
    rows: list[tuple[KeyPath, Data]] = [(place[:-1], table_at(data, *place[:-1]))]
    if EACH in place:
        above = place[: place.index(EACH)]
        rows = [((*above, n), row) for n, row in tables_at(data, *map(str, above))]
    for path, row in rows:
        if place[-1] in row:
            yield (*path, place[-1]), row[place[-1]]


def is_value(value: Any) -> bool:
    """Tell whether something is a number or a text, and so may be read as a number."""
    return isinstance(value, str | int | float) and not isinstance(value, bool)


def read_number(value: Any, unit: str, *, difference: bool = False) -> float | None:
    """Return a value in an SI unit, or None if it is no such number."""
    try:
        return parse_quantity(value, unit, difference=difference) if is_value(value) else None
    except UnitError:
        return None


def misspelt(table: Data, path: KeyPath, *wanted: str) -> bool:
    """Tell whether a key that the schema does not know may be one of these with a slip in it."""
    from vibecalc.core.case.walk import keys_of, shape_at

    shape = shape_at(path)
    known = keys_of(shape.table) if shape is not None and shape.table is not None else {}
    return any(
        difflib.get_close_matches(str(key).lower()[:60], wanted, n=1)
        for key in table
        if key not in known
    )


def nearest(name: str, known: Sequence[str]) -> str:
    """Return a hint at the name that may have been meant, capitals apart, or nothing."""
    lower = {each.lower(): each for each in reversed(known)}
    near = difflib.get_close_matches(name[:80].lower(), lower, n=1, cutoff=0.55)
    return f"did you mean {lower[near[0]]!r}?" if near else ""


def similar(path: Path, like: str) -> str:
    """The same of a file at this place: at a name next to it, of those `like` it."""
    try:
        return nearest(path.name, sorted(one.name for one in path.parent.glob(like)))
    except OSError:
        return ""


def listed(names: list[str]) -> str:
    """Return up to a dozen names in quotes, for what is allowed."""
    shown = ", ".join(repr(name) for name in names[:12])
    return f"{shown} and {len(names) - 12} more" if len(names) > 12 else shown


# ----------------------------------------------------------------------------
# Keys set from the command line, and access to a case by a key such as `a.b[0].c`.
# ----------------------------------------------------------------------------

#: `key=value` as a command line has it, or a key and its value
Setting = str | tuple[str, Any]

_PART = re.compile(r"([A-Za-z0-9_-]+)|\[(\d{1,6})\]")
_KEY = re.compile(r"[A-Za-z0-9_-]*(?:(?<=.)\.[A-Za-z0-9_-]+|\[\d{1,6}\])*\Z")
_BARE_TEXT = re.compile(r"[^\"'\[\]{}=#\n\r]+\Z")
_LONGEST = 20_000


def parse_key(key: str) -> KeyPath:
    """Read `machine.crank_train.cylinders[0].position` as a key path; UsageError if it is none."""
    path = tuple(int(number) if number else name for name, number in _PART.findall(key))
    if not _KEY.match(key) or len(path) > 32:
        raise UsageError(
            f"not a key: {_short(key)!r}; keys look like machine.speed or "
            "machine.crank_train.cylinders[0].position"
        )
    if not path or isinstance(path[0], int):
        raise UsageError(f"a key has to start with the name of a table: {_short(key)!r}")
    return path


def parse_override(text: str) -> tuple[Overridden, Any]:
    """Split `key=value` and read the value as TOML; nothing is ever evaluated.

    A value that is not TOML and holds no quotes, brackets, braces, `=` or `#` is taken as a text,
    since a shell eats quotes: `machine.speed=4900 rpm` is `machine.speed="4900 rpm"`.
    """
    key, sign, written = text.partition("=")
    if not sign or len(text) > _LONGEST:
        raise UsageError(f"--set needs key=value, found {_short(text)!r}")
    if not fits_a_line(text):
        raise UsageError(f"--set has an unprintable character: {_short(text)!r}")
    from vibecalc.core.case.walk import shape_at, with_names

    path = parse_key(key.strip())
    value = with_names(shape_at(path), _read_value(written.strip(), text))
    return Overridden(path, _short(f"--set {text}")), value


def apply_overrides(
    data: MutableMapping[str, Any], settings: Sequence[Setting], unset: Sequence[str] = ()
) -> tuple[Overridden, ...]:
    """Take the keys `unset` out of `data`, then set the others, in the order given.

    A missing table is made. UsageError as above, and for a key to take out that is not there.
    """
    overrides = []
    for key in unset:
        path = parse_key(key.strip())
        get_key(data, path)
        del get_key(data, path[:-1])[path[-1]]
        overrides.append(Overridden(path, _short(f"--unset {key}")))
    for setting in settings:
        if isinstance(setting, str):
            override, value = parse_override(setting)
        else:
            key, value = setting
            override = Overridden(parse_key(key.strip()), _short(f"{key} = {value!r}"))
        set_key(data, override.path, value)
        overrides.append(override)
    return tuple(overrides)


def get_key(data: Mapping[str, Any], key: str | KeyPath) -> Any:
    """Return the value at a key; UsageError if it is not there."""
    path = parse_key(key) if isinstance(key, str) else key
    place: Any = data
    for position, part in enumerate(path):
        place = _step(place, part, path[:position], create=False)
    return place


def number_at(data: Mapping[str, Any], key: str, otherwise: float) -> float:
    """The number at a key of a resolved case, `otherwise` where the case leaves the key out.

    UsageError where the case has a list there.
    """
    path = parse_key(key)
    table = get_key(data, path[:-1])
    if isinstance(table, dict) and path[-1] not in table:
        return otherwise
    found = get_key(data, path)
    if isinstance(found, list):
        raise UsageError(f"{key} is a list in this case: a search wants one number, as {key}[0]")
    return float(found)


def set_key(data: MutableMapping[str, Any], key: str | KeyPath, value: Any) -> None:
    """Set the value at a key in place; tables on the way are made, list entries are not."""
    path = parse_key(key) if isinstance(key, str) else key
    place: Any = data
    for position, part in enumerate(path[:-1]):
        place = _step(place, part, path[:position], create=isinstance(path[position + 1], str))
    last = path[-1]
    if isinstance(last, int) or not isinstance(place, dict):
        _step(place, last, path[:-1], create=False)
    place[last] = value


def field_unit(key: str | KeyPath) -> str:
    """SI unit of a key of the schema ("N/m"); UsageError if there is no number at that key."""
    from vibecalc.core.case.walk import shape_at

    path = parse_key(key) if isinstance(key, str) else key
    shape = shape_at(path)
    if shape is None or shape.kind not in ("number", "whole"):
        raise UsageError(f"a case has no number at {dotted(path)}")
    return shape.unit or ""


def _step(place: Any, part: str | int, above: KeyPath, create: bool) -> Any:
    here = dotted(above) or "the case"
    if isinstance(part, int):
        if not isinstance(place, list):
            raise UsageError(f"{here} is no list, so it has no entry [{part}]")
        if part >= len(place):
            entries = f"{len(place)} entries, [0] to [{len(place) - 1}]" if place else "no entries"
            entries = "one entry, [0]" if len(place) == 1 else entries
            raise UsageError(f"{here} has {entries}, so no [{part}]")
        return place[part]
    if isinstance(place, list):
        raise UsageError(f"{here} is a list: say which entry, as in {here}[0].{part}")
    if not isinstance(place, dict):
        raise UsageError(f"{here} is {_short(repr(place))}, no table, so it has no key {part!r}")
    if part not in place and create:
        place[part] = {}
    if part not in place:
        hint = renamed((*above, part)) or nearest(part, list(place))
        said = (f"{here} has no key {part!r}", hint)
        raise UsageError(", ".join(filter(None, said)))
    return place[part]


def _read_value(written: str, text: str) -> Any:
    try:
        table = tomllib.loads(f"x = {written}")
        if table.keys() == {"x"}:
            return table["x"]
    except (ValueError, RecursionError):
        if _BARE_TEXT.match(written):
            return written
    raise UsageError(f"the value of {_short('--set ' + text)!r} is not TOML: {_short(written)!r}")


def _short(text: str) -> str:
    return text if len(text) <= 80 else text[:77] + "..."


# ----------------------------------------------------------------------------
# The case at one point of a sweep, as plain tables in SI.
# ----------------------------------------------------------------------------

#: tables that a run of one point does not read
NOT_COMPUTED = ("sweep", "optimisation", "find", "fit", "reference", "reference_table", "limit")


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
    first, further = path[0], path[1:]
    if isinstance(first, int):
        entries = list(place)  # a list that the case leaves out begins as an empty table
        old = entries[first] if first < len(entries) else {}
        entries[first : first + 1] = [_replaced(old, further, value)]
        return entries
    return {**place, first: _replaced(place.get(first, {}), further, value)}


def unknown(path: KeyPath, what: str, name: str, known: Sequence[str]) -> Problem:
    """The problem of a name at `path` that no `what` (a station, a cylinder) has."""
    names = list(known)
    message = f"no {what} is named {name[:60]!r}"
    return Problem(path, message, allowed=listed(names), hint=nearest(name, names))


def strangers(
    path: KeyPath, what: str, names: Sequence[str], known: Sequence[str]
) -> Iterator[Problem]:
    """The problems of those names in a list at `path` that no `what` has."""
    for place, name in enumerate(names):
        if name not in known:
            yield unknown((*path, place), what, name, known)
