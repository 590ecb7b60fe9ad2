"""Keys set from the command line, and access to a case by a key such as `a.b[0].c`."""

import re
import tomllib
from collections.abc import Mapping, MutableMapping, Sequence
from typing import Any

from vibecalc.case.locate import Overridden
from vibecalc.errors import KeyPath, UsageError

_PART = re.compile(r"\.?([A-Za-z0-9_-]+)|\[(\d{1,6})\]")
_BARE_TEXT = re.compile(r"[^\"'\[\]{}=#\n\r]+\Z")
_LONGEST = 2000


def parse_key(key: str) -> KeyPath:
    """Read `machine.crank_train.cylinders[0].position` as a key path; UsageError if it is none."""
    path: list[str | int] = []
    place = 0
    while place < len(key):
        match = _PART.match(key, place)
        dotted = key.startswith(".", place)
        if match is None or (match[1] is not None and dotted != bool(path)) or len(path) >= 32:
            raise UsageError(
                f"not a key: {_short(key)!r}; keys look like machine.speed or "
                "machine.crank_train.cylinders[0].position"
            )
        path.append(match[1] if match[1] is not None else int(match[2]))
        place = match.end()
    if not path or isinstance(path[0], int):
        raise UsageError(f"a key has to start with the name of a table: {_short(key)!r}")
    return tuple(path)


def key_text(path: KeyPath) -> str:
    """Write a key path the way `parse_key` reads it."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return text.removeprefix(".")


def parse_override(text: str) -> tuple[Overridden, Any]:
    """Split `key=value` and read the value as TOML; nothing is ever evaluated.

    A value that is not TOML and holds no quotes, brackets, braces, `=` or `#` is taken as a text,
    since a shell eats quotes: `machine.speed=4900 rpm` is `machine.speed="4900 rpm"`.
    """
    key, sign, written = text.partition("=")
    if not sign or len(text) > _LONGEST or not text.isprintable():
        raise UsageError(f"--set needs key=value, found {_short(text)!r}")
    path = parse_key(key.strip())
    return Overridden(path, _short(f"--set {text}")), _read_value(written.strip(), text)


def apply_overrides(
    data: MutableMapping[str, Any], texts: Sequence[str], unset: Sequence[str] = ()
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
    for text in texts:
        override, value = parse_override(text)
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
    """The number at a key of a resolved case, `otherwise` where the case leaves the key out."""
    path = parse_key(key)
    table = get_key(data, path[:-1])
    if isinstance(table, dict) and path[-1] not in table:
        return otherwise
    return float(get_key(data, path))


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
    from vibecalc.case.walk import shape_at

    path = parse_key(key) if isinstance(key, str) else key
    shape = shape_at(path)
    if shape is None or shape.kind not in ("number", "whole"):
        raise UsageError(f"a case has no number at {key_text(path)}")
    return shape.unit or ""


def _step(place: Any, part: str | int, above: KeyPath, create: bool) -> Any:
    here = key_text(above) or "the case"
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
        import difflib

        near = difflib.get_close_matches(part, place, n=1)
        hint = f", did you mean {near[0]!r}?" if near else ""
        raise UsageError(f"{here} has no key {part!r}{hint}")
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
