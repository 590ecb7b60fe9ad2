"""Checks of [[find]]: names, keys of this case, bounds, and one thing that is wanted."""

import math
import re
from collections.abc import Generator, Iterator
from typing import Any

from vibecalc.case.overrides import get_key, parse_key
from vibecalc.case.raw import Data, read_number, tables_at
from vibecalc.case.variable_checks import bound_problems, changeable, inside
from vibecalc.case.walk import Shape, bound_words, keys_of, shape_at
from vibecalc.errors import KeyPath, Problem, UsageError

_CHANGEABLE = ("machine", "excitation", "response", "isolation")
_WANTED = ("target", "change", "seek")
_NAME = re.compile(r"[A-Za-z0-9_]+\Z")


def check_find(data: Data) -> Iterator[Problem]:
    """Yield the problems of all [[find]] tables; what cannot be read is left to the schema."""
    rows = tables_at(data, "find")
    if rows and "optimisation" in data:
        yield Problem(
            path=("find", rows[0][0]),
            message="a case with [optimisation] cannot have [[find]], too",
            allowed="one or the other",
            hint="search in a case of its own, with the optimum written into it",
            also=("optimisation",),
        )
    seen: dict[str, int] = {}
    for position, row in rows:
        path: KeyPath = ("find", position)
        yield from _name(row, path, seen)
        yield from _wanted(row, path)
        yield from _keys(data, row, path)


def _name(row: Data, path: KeyPath, seen: dict[str, int]) -> Iterator[Problem]:
    name = row.get("name")
    if not isinstance(name, str) or not name:
        return
    if not _NAME.match(name):
        yield Problem(
            path=(*path, "name"),
            message="a name that cannot stand in a result path",
            found=repr(name[:60]),
            allowed="letters, digits and _, as in rod_length_6_db",
        )
    if name in seen:
        yield Problem(
            path=(*path, "name"),
            message=f"two searches are named {name[:60]!r}",
            hint="give each its own name",
            also=("find", seen[name], "name"),
        )
    seen.setdefault(name, int(path[1]))


def _wanted(row: Data, path: KeyPath) -> Iterator[Problem]:
    given = [key for key in _WANTED if key in row]
    ways = "target (a value), change (from the case as written) or seek (an extreme)"
    if not given:
        yield Problem(path=path, message="this [[find]] does not say what is wanted", allowed=ways)
    for further in given[1:]:
        yield Problem(
            path=(*path, further),
            message=f"{further} and {given[0]} exclude each other",
            allowed=f"one of {ways}",
            also=(*path, given[0]),
        )


def _keys(data: Data, row: Data, path: KeyPath) -> Iterator[Problem]:
    """Problems of key, bounds, and of the keys that follow it."""
    key, also = row.get("key"), row.get("also")
    found = yield from _number(data, key, (*path, "key"))
    if found is not None and math.isnan(found[1]) and also:
        yield Problem(
            path=(*path, "also"),
            message=f"keys cannot change in the ratio of {key}, which the case leaves out",
            hint=f"write {key} into the case",
        )
    ratios: list[float] = []
    if found is not None:
        shape, written = found
        yield from bound_problems(row, path, shape)
        bounds = [read_number(row.get(side), shape.unit or "") for side in ("lower", "upper")]
        if also and written == 0.0:
            yield Problem(
                path=(*path, "key"),
                message="keys cannot change in the ratio of one that is zero as written",
                found=f"{key} = 0",
                also=(*path, "also"),
            )
        elif written and not math.isnan(written):
            ratios = [bound / written for bound in bounds if bound is not None]
    taken = [key]
    for position, other in enumerate(also if isinstance(also, list) else ()):
        place = (*path, "also", position)
        if isinstance(other, str) and other in taken:
            yield Problem(path=place, message=f"{other} is changed twice by this [[find]]")
            continue
        taken.append(other)
        found = yield from _number(data, other, place)
        if found is not None:
            yield from _followed(str(other), *found, ratios, place)


def _number(
    data: Data, key: Any, place: KeyPath
) -> Generator[Problem, None, tuple[Shape, float] | None]:
    """Yield the problems of a key; returns its shape and its value in SI, nan if left out."""
    if not isinstance(key, str) or not key:
        return None
    try:
        shape = changeable(data, key, _CHANGEABLE)
        written = _written(data, key)
    except UsageError as error:
        yield Problem(
            path=place,
            message="a search cannot change this key",
            found=key[:80],
            allowed="the key of a number of this case, as in machine.crank_train.rod_length",
            hint=str(error),
        )
        return None
    if isinstance(written, list):
        yield Problem(
            path=place,
            message=f"{key} is a list here",
            found=f"a list of {len(written)} numbers",
            allowed=f"one of them, as {key}[0]",
        )
        return None
    if written is None:
        return shape, math.nan
    number = read_number(written, shape.unit or "")
    return None if number is None else (shape, number)


def _written(data: Data, key: str) -> Any:
    """What stands at a key, or its default."""
    path = parse_key(key)
    table = get_key(data, path[:-1])
    if isinstance(table, dict) and path[-1] not in table:
        parent = shape_at(path[:-1])
        assert parent is not None and parent.table is not None
        return keys_of(parent.table)[str(path[-1])].default
    return get_key(data, path)


def _followed(
    key: str, shape: Shape, written: float, ratios: list[float], place: KeyPath
) -> Iterator[Problem]:
    if written == 0.0:
        yield Problem(
            path=place,
            message="a key that is zero does not change in any ratio",
            found=f"{key} = 0",
        )
    wrong = [ratio * written for ratio in ratios if not inside(ratio * written, shape)]
    if wrong:
        unit = f" {shape.unit}" if shape.unit else ""
        yield Problem(
            path=place,
            message=f"between the bounds {key} would take a value that it must not have",
            found=f"{wrong[0]:.6g}{unit}",
            allowed=bound_words(shape),
        )
