"""Checks of form of what a search may change and of what it looks for."""

import copy
import difflib
import math
from collections.abc import Generator, Iterator
from typing import Any

from vibecalc.core.case.raw import Data, get_key, key_text, parse_key, read_number, tables_at
from vibecalc.core.case.rules import OneOf, Row
from vibecalc.core.case.walk import Shape, allowed_of, bound_words, keys_of, shape_at, words
from vibecalc.errors import KeyPath, Problem, UnitError, UsageError

# ----------------------------------------------------------------------------
# Checks of what a search may change: a number of this case, between two readable bounds.
# ----------------------------------------------------------------------------

CHANGEABLE = ("machine", "excitation", "isolation")
#: kinds of keys that a search may move, and those that it may pick from a list
_CONTINUOUS, PICKED = ("number",), ("number", "whole", "choice")
_WHO: dict[str | int, str] = {"optimisation": "the optimiser", "fit": "a fit"}


def check_variables(row: Row) -> Iterator[Problem]:
    """Yield the problems of the variables of a search: keys, bounds, units, doubled keys, ties."""
    data = row.case
    seen: dict[str, KeyPath] = {}
    for position, variable in tables_at(row.data, "variables"):
        path: KeyPath = (*row.path, "variables", position)
        key = variable.get("key")
        if not isinstance(key, str) or not key:
            continue
        picked = variable.get("choices") or variable.get("integer") is True
        kinds = PICKED if picked else _CONTINUOUS
        shape = yield from _shape(data, key, (*path, "key"), seen, kinds)
        if shape is None:
            continue
        if not variable.get("choices"):
            yield from bound_problems(variable, path, shape)
        ties = variable.get("with")
        for place, tie in enumerate(ties if isinstance(ties, list) else ()):
            if isinstance(tie, dict) and isinstance(tie.get("key"), str) and tie["key"]:
                yield from _tie(data, variable, shape, tie, (*path, "with", place), seen)


def _shape(
    data: dict[str, Any],
    key: str,
    path: KeyPath,
    seen: dict[str, KeyPath],
    kinds: tuple[str, ...] = _CONTINUOUS,
) -> Generator[Problem, None, Shape | None]:
    """Yield the problems of a key that is changed; returns its shape, None where it has none."""
    try:
        shape = changeable(data, key, CHANGEABLE, kinds)
    except UsageError as error:
        yield Problem(
            path=path,
            message=f"{_WHO.get(path[0], 'a search')} cannot change this key",
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
    factor, added = tie.get("factor", 1.0), tie.get("offset", 0.0)
    offset = read_number(added, unit, difference=True)
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


def changeable(
    data: dict[str, Any], key: str, tables: tuple[str, ...], kinds: tuple[str, ...] = _CONTINUOUS
) -> Shape:
    """Shape of a key of this case that a search may set; UsageError, with a hint, if it may not.

    The key has to be one of these kinds below one of `tables`, a number as a rule; a key that may
    be left out need not be there, unless one stands there that excludes it.
    """
    target = parse_key(key)
    shape = _number_at(target, tables, kinds)
    if _has_default(data, target):
        _fits_beside(data, target)
    else:
        get_key(data, target)
    return shape


def _fits_beside(data: dict[str, Any], target: KeyPath) -> None:
    """Raises UsageError where a key that is left out excludes one that the case has beside it."""
    table, parent = get_key(data, target[:-1]), shape_at(target[:-1])
    if parent is None or parent.table is None or target[-1] in table:
        return
    whole = copy.deepcopy(data)
    get_key(whole, target[:-1])[target[-1]] = math.nan
    with_key = Row(get_key(whole, target[:-1]), target[:-1], whole, parent.table)
    for rule in parent.table.RULES:
        for problem in rule(with_key) if isinstance(rule, OneOf) else ():
            if problem.also:
                raise UsageError(problem.message)


def _number_at(target: KeyPath, tables: tuple[str, ...], kinds: tuple[str, ...]) -> Shape:
    shape = shape_at(target)
    if target[0] not in tables:
        raise UsageError(f"only keys below {', '.join(tables)} can be changed")
    if shape is None:
        raise UsageError(_nearest(target))
    if shape.kind not in kinds:
        what = "a continuous number" if kinds == _CONTINUOUS else "a number or a name"
        raise UsageError(f"{key_text(target)} is not {what}, but {words(shape)}")
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
            values[side] = shape.number(written)
        except (UnitError, OverflowError) as error:
            unit_error = error if isinstance(error, UnitError) else UnitError("too large")
            yield Problem(
                path=(*path, side),
                message=f"{side}: {unit_error.message}",
                found=unit_error.found,
                allowed=allowed_of(unit_error, shape),
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


# ----------------------------------------------------------------------------
# Checks of [[find]]: keys of this case, bounds.
# ----------------------------------------------------------------------------

_SEARCHABLE = ("machine", "excitation", "response", "isolation")


def check_find(row: Row) -> Iterator[Problem]:
    """Yield the problems of key, bounds, and of the keys that follow it, of one [[find]]."""
    yield from _keys(row.case, row.data, row.path)


def _keys(data: Data, row: Data, path: KeyPath) -> Iterator[Problem]:
    """Problems of key, bounds, and of the keys that follow it."""
    key, also = row.get("key"), row.get("also")
    number = yield from _number(data, key, (*path, "key"))
    if number is not None and math.isnan(number[1]) and also:
        yield Problem(
            path=(*path, "also"),
            message=f"keys cannot change in the ratio of {key}, which the case leaves out",
            hint=f"write {key} into the case",
        )
    ratios: list[float] = []
    if number is not None:
        shape, written = number
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
        number = yield from _number(data, other, place)
        if number is not None:
            yield from _followed(str(other), *number, ratios, place)


def _number(
    data: Data, key: Any, place: KeyPath
) -> Generator[Problem, None, tuple[Shape, float] | None]:
    """Yield the problems of a key; returns its shape and its value in SI, nan if left out."""
    if not isinstance(key, str) or not key:
        return None
    try:
        shape = changeable(data, key, _SEARCHABLE)
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
