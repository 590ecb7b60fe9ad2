"""Checks of form of what a search picks from and of what scatters: choices, stocks, tolerances."""

import math
import re
from collections.abc import Generator, Iterator
from typing import Any

from vibecalc.core.case.raw import Data, get_key, nearest, parse_key, read_number, tables_at
from vibecalc.core.case.rules import Row
from vibecalc.core.case.search_checks import CHANGEABLE, PICKED, changeable, inside
from vibecalc.core.case.walk import Shape, allowed_of, bound_words, keys_of, shape_at, words
from vibecalc.errors import KeyPath, Problem, UnitError, UsageError
from vibecalc.units import parse_quantity

# ----------------------------------------------------------------------------
# One value of a list: a number of its key, a whole one, or a name that it may have.
# ----------------------------------------------------------------------------

#: most whole numbers between two bounds
MOST_WHOLE = 10_000


def read_choice(value: Any, shape: Shape) -> float | int | str:
    """A value of a list as the case holds it, in SI; UnitError for what its key cannot be."""
    if shape.kind == "choice":
        if value not in shape.choices:
            raise UnitError("no value of this key", found=repr(value)[:60], allowed=words(shape))
        return str(value)
    number = shape.number(value)
    if not inside(number, shape):
        raise UnitError(
            "a value that the key must not have", found=str(value)[:60], allowed=bound_words(shape)
        )
    if shape.kind == "whole":
        if number != int(number):
            raise UnitError("not a whole number", found=str(value)[:60], allowed=words(shape))
        return int(number)
    return number


def _read(value: Any, shape: Shape, path: KeyPath) -> Generator[Problem, None, Any]:
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        return None
    try:
        return read_choice(value, shape)
    except (UnitError, OverflowError) as error:
        said = error if isinstance(error, UnitError) else UnitError("too large")
        yield Problem(
            path=path,
            message=said.message,
            found=said.found,
            allowed=allowed_of(said, shape),
            hint=said.hint,
        )
        return None


# ----------------------------------------------------------------------------
# Variables that are picked: listed values, whole numbers between bounds.
# ----------------------------------------------------------------------------


def choice_problems(variable: Data, path: KeyPath, shape: Shape) -> Iterator[Problem]:
    """Problems of `choices` of a variable: values of its key, each once."""
    taken: dict[Any, int] = {}
    given = variable.get("choices")
    for place, value in enumerate(given if isinstance(given, list) else ()):
        read = yield from _read(value, shape, (*path, "choices", place))
        if read is not None and taken.setdefault(read, place) != place:
            yield Problem(
                path=(*path, "choices", place),
                message=f"{str(value)[:40]} stands twice",
                also=(*path, "choices", taken[read]),
            )
    if shape.kind == "choice" and variable.get("with"):
        yield Problem(path=(*path, "with"), message="no key can follow one that holds names")


def whole_numbers(lower: float, upper: float) -> range:
    """The whole numbers between two bounds."""
    return range(math.ceil(lower), math.floor(upper) + 1)


def integer_problems(variable: Data, path: KeyPath, shape: Shape) -> Iterator[Problem]:
    """Problems of a variable of whole numbers: its unit, and that there are some."""
    if shape.unit:
        yield Problem(
            path=(*path, "integer"),
            message=f"{variable['key']} has units, and no whole numbers",
            found=shape.unit,
            allowed="a list of values",
            hint='choices = ["1 mm", "2 mm"]',
        )
        return
    bounds = [read_number(variable.get(side), "") for side in ("lower", "upper")]
    if None in bounds:
        return
    low, high = (float(bound or 0.0) for bound in bounds)
    count = len(whole_numbers(low, high)) if abs(low) < 1e15 and abs(high) < 1e15 else 0
    if low < high and not 1 <= count <= MOST_WHOLE:
        yield Problem(
            path=(*path, "lower"),
            message="no whole number between the bounds" if not count else "too many whole numbers",
            found=f"{variable['lower']} to {variable['upper']}",
            allowed=f"1 to {MOST_WHOLE} of them",
            also=(*path, "upper"),
        )


# ----------------------------------------------------------------------------
# Stocks, and keys that scatter.
# ----------------------------------------------------------------------------


def check_choices(row: Row) -> Iterator[Problem]:
    """Yield the problems of variables that are picked, of stocks and of tolerances."""
    seen: dict[str, KeyPath] = {}
    for position, variable in tables_at(row.data, "variables"):
        path, key = (*row.path, "variables", position), variable.get("key")
        ties = [tie.get("key") for _, tie in tables_at(variable, "with")]
        seen |= {one: (*path, "key") for one in (key, *ties) if isinstance(one, str)}
        shape = _shape(key) if isinstance(key, str) else None
        if shape is not None and shape.kind in PICKED:
            if variable.get("choices"):
                yield from choice_problems(variable, path, shape)
            elif variable.get("integer") is True:
                yield from integer_problems(variable, path, shape)
    for position, stock in tables_at(row.data, "stock"):
        yield from _stock(row.case, stock, (*row.path, "stock", position), seen)
    robust = row.data.get("robust")
    if isinstance(robust, dict):
        yield from _tolerances(row.case, robust, (*row.path, "robust"))


def _stock(data: Data, stock: Data, path: KeyPath, seen: dict[str, KeyPath]) -> Iterator[Problem]:
    name = stock.get("name")
    if isinstance(name, str) and re.search("[^A-Za-z0-9_]", name):
        yield Problem(
            path=(*path, "name"),
            message="a name that cannot stand in a result path",
            found=repr(name[:60]),
            allowed="letters, digits and _, as in front_mount",
        )
    also = stock.get("also")
    places = [("table", stock.get("table"))]
    places += [("also", one) for one in (also if isinstance(also, list) else ())]
    tables = []
    for key, table in places:
        if isinstance(table, str) and table:
            found = yield from _table(data, table, (*path, key))
            if found:
                tables.append(table)
    items = tables_at(stock, "items")
    first = items[0][1].get("values") if items else None
    for place, item in items:
        values, where = item.get("values"), (*path, "items", place, "values")
        if not isinstance(values, dict) or not isinstance(first, dict):
            continue
        if values.keys() != first.keys():
            yield Problem(
                path=where,
                message="all items of a stock settle the same keys",
                found=", ".join(values) or "no key",
                allowed=", ".join(first),
                also=(*path, "items", items[0][0], "values"),
            )
            continue
        for table in tables:
            for key, value in values.items():
                yield from _item(data, f"{table}.{key}", value, (*where, key), seen, place == 0)


def _table(data: Data, table: str, path: KeyPath) -> Generator[Problem, None, bool]:
    try:
        target = parse_key(table)
        shape = shape_at(target)
        if target[0] not in CHANGEABLE:
            raise UsageError(f"only tables below {', '.join(CHANGEABLE)} can be changed")
        if shape is None or shape.table is None:
            raise UsageError(f"a case has no table at {table}")
        get_key(data, target)
    except UsageError as error:
        yield Problem(
            path=path,
            message="nothing can be put there",
            found=table[:80],
            allowed="a table of this case, as machine.mounts.each",
            hint=str(error),
        )
        return False
    return True


def _item(
    data: Data, key: str, value: Any, path: KeyPath, seen: dict[str, KeyPath], first: bool
) -> Iterator[Problem]:
    """Problems of one value of an item of a stock."""
    try:
        shape = changeable(data, key, CHANGEABLE, PICKED)
    except UsageError as error:
        if first:
            table, _, last = key.rpartition(".")
            known = list(keys_of(found.table)) if (found := _shape(table)) and found.table else []
            yield Problem(
                path=path,
                message="a stock cannot settle this key",
                found=key[:80],
                allowed="keys of the table that hold a number or a name",
                hint=nearest(last, known) or str(error),
            )
        return
    if seen.setdefault(key, path)[: len(path) - 3] != path[:-3]:
        yield Problem(path=path, message=f"{key} is changed twice", also=seen[key])
    yield from _read(value, shape, path)


def _shape(key: str) -> Shape | None:
    try:
        return shape_at(parse_key(key))
    except UsageError:
        return None


def _tolerances(data: Data, robust: Data, path: KeyPath) -> Iterator[Problem]:
    taken: dict[str, int] = {}
    for position, tolerance in tables_at(robust, "tolerances"):
        key, here = tolerance.get("key"), (*path, "tolerances", position)
        if not isinstance(key, str) or not key:
            continue
        try:
            shape = changeable(data, key, (*CHANGEABLE, "response"))
        except UsageError as error:
            yield Problem(
                path=(*here, "key"),
                message="this key cannot scatter",
                found=key[:80],
                allowed="the key of a number of this case, as in machine.mounts.each.stiffness",
                hint=str(error),
            )
            continue
        if taken.setdefault(key, position) != position:
            other = (*path, "tolerances", taken[key], "key")
            yield Problem(path=(*here, "key"), message=f"{key} scatters twice", also=other)
        for side in ("half_width", "deviation"):
            yield from _size(tolerance.get(side), shape, (*here, side))


def _size(value: Any, shape: Shape, path: KeyPath) -> Iterator[Problem]:
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        return
    try:
        size, _ = share_or_size(value, shape.unit or "")
    except (UnitError, OverflowError) as error:
        said = error.message if isinstance(error, UnitError) else "too large"
        yield Problem(
            path=path,
            message=said,
            found=str(value)[:60],
            allowed=f"a size{f' in {shape.unit}' if shape.unit else ''}, or a share as '15 %'",
        )
        return
    if not 0.0 < size < math.inf:
        yield Problem(path=path, message="a tolerance is above zero", found=str(value)[:60])


def share_or_size(value: float | str, unit: str) -> tuple[float, bool]:
    """A tolerance in SI, and whether it is a share of the value: what is given in percent."""
    share = isinstance(value, str) and value.rstrip().endswith("%")
    return parse_quantity(value, "" if share else unit, difference=True), share
