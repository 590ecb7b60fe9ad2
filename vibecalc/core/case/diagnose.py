"""What pydantic found wrong, in an engineer's words."""

import datetime
import difflib
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from typing import Any

from vibecalc.core.case.fields import UNION_TAGS, Table
from vibecalc.core.case.raw import nearest
from vibecalc.core.case.walk import (
    Shape,
    bound_words,
    keys_of,
    shape_at,
    shape_of,
    unit_problem,
    words,
)
from vibecalc.core.results.named import named
from vibecalc.core.results.renamed import GONE, current_name, renamed, renamed_choice
from vibecalc.errors import KeyPath, Problem, UnitError, dotted

Error = Mapping[str, Any]
Explainer = Callable[[KeyPath, Error], Problem]

#: pydantic's word for a key that the table does not have
_UNKNOWN = "extra_forbidden"
_MOST_SUGGESTED = 10


def explain(errors: Iterable[Error]) -> list[Problem]:
    """Turn the errors of a pydantic validation into problems, one for each place.

    A key that is missing because it is misspelt is reported once, and a list that pydantic calls
    too short because of its faulty entries is not reported. The nearest known key is looked for
    where the first few keys are unknown: thousands of them are no slips of the keyboard.
    """
    by_path = [(_path(error["loc"]), error) for error in errors]
    broken = {path[:size] for path, _ in by_path for size in range(len(path))}
    unknown = [path for path, error in by_path if error["type"] == _UNKNOWN]
    near = {path: current_name(path) or _nearest_key(path) for path in unknown[:_MOST_SUGGESTED]}
    misspelt = {(*path[:-1], key) for path, key in near.items() if key}
    problems: dict[KeyPath, Problem] = {}
    for path, error in by_path:
        kind = error["type"]
        above = {path[:size] for size in range(1, len(path) + 1)}
        swallowed = kind == "missing" and not misspelt.isdisjoint(above)
        follows = kind == "too_short" and path in broken
        if not (swallowed or follows):
            if kind == _UNKNOWN:
                problem = _unknown(path, near.get(path, ""))
            else:
                problem = _EXPLAINERS.get(kind, _other)(path, error)
            problems.setdefault(problem.path, problem)
    return list(problems.values())


def shown(value: Any) -> str:
    """Return a value of a case in a few words."""
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list | tuple):
        return f"a list of {len(value)} entries" if len(value) != 1 else "a list of one entry"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int) and abs(value) >= 10**24:
        return "a very large whole number"
    text = repr(value) if isinstance(value, str) else str(value).removesuffix(".0")
    return text if len(text) <= 60 else text[:57] + "..."


def name_of(path: KeyPath) -> str:
    """Return the last key of a path with the position in its list: `cylinders[1]`."""
    text = ""
    for part in reversed(path):
        if isinstance(part, str):
            return part + text
        text = f"[{part}]" + text
    return text or "the case"


def _path(location: tuple[str | int, ...]) -> KeyPath:
    return tuple(part for part in location if part not in UNION_TAGS)


def _said(
    path: KeyPath,
    message: str,
    found: str = "",
    allowed: str | None = None,
    hint: str = "",
) -> Problem:
    """What is wrong with the value at a place; what is allowed is what the schema has there."""
    if allowed is None:
        shape = shape_at(path)
        allowed = words(shape) if shape else ""
    return Problem(path, message, found, allowed, hint)


def _missing(path: KeyPath, error: Error) -> Problem:
    if path and isinstance(path[-1], int):
        whole = shape_at(path[:-1])
        allowed = "three numbers" if whole is None or whole.or_three else words(whole)
        found = shown(error["input"])
        return _said(path[:-1], f"{name_of(path[:-1])} is too short", found, allowed)
    return missing_key(path)


def missing_key(path: KeyPath) -> Problem:
    """The problem of a key that has to be there and is not."""
    return _said(path, f"missing key {path[-1]!r}{_in_table(path)}", hint=_description(path))


def _in_table(path: KeyPath) -> str:
    return f" in [{dotted(path[:-1])}]" if len(path) > 1 else ""


def _unknown(path: KeyPath, near: str) -> Problem:
    key, parent = str(path[-1]), shape_at(path[:-1])
    elsewhere = [] if near else _tables_with(key)
    hint = GONE.get(path, "") or renamed(path)
    if near and not hint:
        hint = f"did you mean {near!r}?"
    elif elsewhere and not hint:
        hint = f"{key} belongs to {', '.join(f'[{name}]' for name in elsewhere[:3])}"
    keys = ", ".join(keys_of(parent.table)) if parent and parent.table and not near else ""
    return _said(path, f"unknown key {shown(key)}{_in_table(path)}", "", keys, hint)


def _quantity(path: KeyPath, error: Error) -> Problem:
    cause = error.get("ctx", {}).get("error")
    if not isinstance(cause, UnitError):
        return _other(path, error)
    return unit_problem(cause, path, shape_at(path), f"{name_of(path)}: ")


def _bound(path: KeyPath, error: Error) -> Problem:
    shape, value = shape_at(path) or Shape(kind="number"), error["input"]
    found = shown(value) + (f" {shape.unit}" if shape.unit and not isinstance(value, str) else "")
    message = f"{name_of(path)} is out of range"
    return _said(path, message, found, bound_words(shape), _description(path))


def _wrong_type(path: KeyPath, error: Error) -> Problem:
    value = error["input"]
    return _said(path, f"{name_of(path)} cannot be {_type_words(value)}", shown(value))


def _choice(path: KeyPath, error: Error) -> Problem:
    shape, found = shape_at(path), shown(error["input"])
    choices = [str(choice) for choice in shape.choices] if shape else []
    said = str(error["input"])
    hint = renamed_choice(path, said) or nearest(said, choices)
    if path == ("schema",):
        hint = "this version of vibecalc reads cases of schema 1"
    return _said(path, f"unknown {name_of(path)} {found}", found, hint=hint)


def _size(path: KeyPath, error: Error) -> Problem:
    shape, value = shape_at(path), error["input"]
    size = "too long" if error["type"].endswith("too_long") else "too short" if value else "empty"
    allowed = "one number, or a list of three" if shape and shape.or_three else None
    message = f"{name_of(path)} is {size}"
    return _said(path, message, shown(value), allowed, _description(path))


def _what(words: str) -> Explainer:
    return lambda path, error: _said(path, f"{name_of(path)} {words}", shown(error["input"]))


_other = _what("cannot be read")
_EXPLAINERS: dict[str, Explainer] = {
    "missing": _missing,
    "value_error": _quantity,
    "finite_number": _what("is not finite"),
    "literal_error": _choice,
    **dict.fromkeys(("greater_than", "greater_than_equal", "less_than", "less_than_equal"), _bound),
    **dict.fromkeys(("too_short", "too_long", "string_too_short", "string_too_long"), _size),
    **dict.fromkeys(("float_type", "bool_type", "int_type", "int_from_float"), _wrong_type),
    **dict.fromkeys(("string_type", "tuple_type", "dict_type", "model_type"), _wrong_type),
}


def _nearest_key(path: KeyPath) -> str:
    parent = shape_at(path[:-1])
    if parent is None or parent.table is None:
        return ""
    keys = {key.lower(): key for key in keys_of(parent.table)}
    # A key that is right in another table is only taken for misspelt if it is nearly the same.
    cutoff = 0.85 if _tables_with(str(path[-1])) else 0.6
    near = difflib.get_close_matches(str(path[-1]).lower()[:60], keys, n=1, cutoff=cutoff)
    return keys[near[0]] if near else ""


def _tables_with(key: str) -> list[str]:
    return _tables_by_key().get(key, [])


@cache
def _tables_by_key() -> dict[str, list[str]]:
    """Key -> every table below the root of a case that has it."""
    tables: dict[str, list[str]] = {}

    def search(table: type[Table], above: str) -> None:
        for name, field in keys_of(table).items():
            if above:
                tables.setdefault(name, []).append(above)
            shape = shape_of(field)
            below = shape.table or (shape.item.table if shape.item else None)
            if below is not None:
                search(below, f"{above}.{name}" if above else name)

    search(named("vibecalc.schema:Case"), "")
    return tables


def _description(path: KeyPath) -> str:
    """The key and what the schema says it is; of an entry of a list, its list."""
    path = path[:-1] if path and isinstance(path[-1], int) else path
    parent = shape_at(path[:-1]) if path else None
    if parent is None or parent.table is None:
        return ""
    field = keys_of(parent.table).get(str(path[-1]))
    return f"{path[-1]}: {field.description}" if field and field.description else ""


def _type_words(value: Any) -> str:
    if isinstance(value, dict | list):
        return "a table" if isinstance(value, dict) else "a list"
    if isinstance(value, bool):
        return "true or false"
    if isinstance(value, int | float):
        return "a number"
    if isinstance(value, datetime.date | datetime.time):
        return "a date"
    return "a text" if isinstance(value, str) else f"a {type(value).__name__}"
