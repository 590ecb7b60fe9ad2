"""Checks of what a search may change: a number of this case, between two readable bounds."""

import difflib
from collections.abc import Generator, Iterator
from typing import Any

from vibecalc.case.overrides import get_key, key_text, parse_key
from vibecalc.case.raw import read_number
from vibecalc.case.walk import Shape, bound_words, keys_of, shape_at, words
from vibecalc.errors import KeyPath, Problem, UnitError, UsageError
from vibecalc.units import parse_quantity

_CHANGEABLE = ("machine", "excitation", "isolation")


def check_variables(data: dict[str, Any]) -> Iterator[Problem]:
    """Yield the problems of [optimisation] variables: keys, bounds, units, doubled keys, ties."""
    variables = data["optimisation"].get("variables")
    seen: dict[str, KeyPath] = {}
    for position, variable in enumerate(variables if isinstance(variables, list) else ()):
        path: KeyPath = ("optimisation", "variables", position)
        key = variable.get("key") if isinstance(variable, dict) else None
        if not isinstance(key, str) or not key:
            continue
        shape = yield from _shape(data, key, (*path, "key"), seen)
        if shape is None:
            continue
        yield from bound_problems(variable, path, shape)
        ties = variable.get("with")
        for place, tie in enumerate(ties if isinstance(ties, list) else ()):
            if isinstance(tie, dict) and isinstance(tie.get("key"), str) and tie["key"]:
                yield from _tie(data, variable, shape, tie, (*path, "with", place), seen)


def _shape(
    data: dict[str, Any], key: str, path: KeyPath, seen: dict[str, KeyPath]
) -> Generator[Problem, None, Shape | None]:
    """Yield the problems of a key that is changed; returns its shape, None where it has none."""
    try:
        shape = changeable(data, key, _CHANGEABLE)
    except UsageError as error:
        yield Problem(
            path=path,
            message="the optimiser cannot change this key",
            found=key[:80],
            allowed="the key of a number of this case, as in machine.mounts.each.stiffness",
            hint=str(error),
        )
        return None
    if key in seen:
        yield Problem(path=path, message=f"two variables change {key}", also=seen[key])
    seen.setdefault(key, path)
    return shape


def _tie(
    data: dict[str, Any],
    variable: dict[str, Any],
    leads: Shape,
    tie: dict[str, Any],
    path: KeyPath,
    seen: dict[str, KeyPath],
) -> Iterator[Problem]:
    """Problems of a key that follows a variable: its unit, and values it would take."""
    shape = yield from _shape(data, tie["key"], (*path, "key"), seen)
    if shape is None:
        return
    unit = shape.unit or ""
    if unit != (leads.unit or ""):
        yield Problem(
            path=(*path, "key"),
            message=f"{tie['key']} cannot follow {variable['key']}: they have other units",
            found=f"{unit or 'no unit'} and {leads.unit or 'no unit'}",
        )
        return
    factor, offset = tie.get("factor", 1.0), read_number(tie.get("offset", 0.0), unit)
    if offset is None:
        yield Problem(
            path=(*path, "offset"),
            message="no offset in the unit of the key",
            found=str(tie["offset"])[:60],
            allowed=unit or "a number",
        )
    elif isinstance(factor, int | float) and not isinstance(factor, bool):
        bounds = (read_number(variable.get(side), unit) for side in ("lower", "upper"))
        taken = [factor * bound + offset for bound in bounds if bound is not None]
        wrong = [value for value in taken if not inside(value, shape)]
        if wrong:
            yield Problem(
                path=path,
                message=f"between the bounds {tie['key']} would take a value that it must not have",
                found=f"{wrong[0]:.6g} {unit}".rstrip(),
                allowed=bound_words(shape),
            )


def changeable(data: dict[str, Any], key: str, tables: tuple[str, ...]) -> Shape:
    """Shape of a key of this case that a search may set; UsageError, with a hint, if it may not.

    The key has to be a number below one of `tables`; a key that may be left out need not be there.
    """
    target = parse_key(key)
    shape = _number_at(target, tables)
    if not _has_default(data, target):
        get_key(data, target)
    return shape


def _number_at(target: KeyPath, tables: tuple[str, ...]) -> Shape:
    shape = shape_at(target)
    if target[0] not in tables:
        raise UsageError(f"only keys below {', '.join(tables)} can be changed")
    if shape is None:
        raise UsageError(_nearest(target))
    if shape.kind != "number":
        raise UsageError(f"{key_text(target)} is not a continuous number, but {words(shape)}")
    return shape


def _nearest(target: KeyPath) -> str:
    for size in range(len(target)):
        shape = shape_at(target[: size + 1])
        if shape is None:
            parent = shape_at(target[:size])
            keys = list(keys_of(parent.table)) if parent and parent.table else []
            near = difflib.get_close_matches(str(target[size]), keys, n=1)
            hint = f"; did you mean {near[0]!r}?" if near else ""
            return f"{key_text(target[:size]) or 'a case'} has no key {target[size]!r}{hint}"
    return ""


def _has_default(data: dict[str, Any], target: KeyPath) -> bool:
    """Tell whether the table is written, so that its key may be left out: it need not be there."""
    last = target[-1]
    table = get_key(data, target[:-1])
    parent = shape_at(target[:-1])
    if isinstance(last, int) or not isinstance(table, dict) or parent is None:
        return False
    field = keys_of(parent.table).get(last) if parent.table else None
    return field is not None and not field.is_required()


def bound_problems(variable: dict[str, Any], path: KeyPath, shape: Shape) -> Iterator[Problem]:
    """Problems of `lower` and `upper` of a table that changes `key`: unit, range, order."""
    values: dict[str, float] = {}
    for side in ("lower", "upper"):
        written = variable.get(side)
        if isinstance(written, bool) or not isinstance(written, str | int | float):
            continue
        try:
            values[side] = parse_quantity(written, shape.unit or "")
        except (UnitError, OverflowError) as error:
            unit_error = error if isinstance(error, UnitError) else UnitError("too large")
            yield Problem(
                path=(*path, side),
                message=f"{side}: {unit_error.message}",
                found=unit_error.found,
                allowed=unit_error.allowed,
                hint=unit_error.hint,
            )
            continue
        if not inside(values[side], shape):
            yield Problem(
                path=(*path, side),
                message=f"{side} is a value that {variable['key']} must not have",
                found=str(written)[:60],
                allowed=bound_words(shape),
            )
    if len(values) == 2 and not values["lower"] < values["upper"]:
        yield Problem(
            path=(*path, "lower"),
            message="the lower bound has to be below the upper one",
            found=f"lower {variable['lower']} and upper {variable['upper']}",
            allowed="lower < upper",
            also=(*path, "upper"),
        )


def inside(value: float, shape: Shape) -> bool:
    """Tell whether a number keeps the bounds of its key."""
    tests = {
        "gt": lambda bound: value > bound,
        "ge": lambda bound: value >= bound,
        "lt": lambda bound: value < bound,
        "le": lambda bound: value <= bound,
    }
    return all(tests[name](bound) for name, bound in shape.bounds)
