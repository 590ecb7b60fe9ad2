"""Checks of what a search may change, pick and scatter: keys of this case, values they may have."""

import math
from collections.abc import Generator, Iterator
from typing import Any

from vibecalc.core.case.raw import Data, get_key, is_value, nearest, parse_key, read_number
from vibecalc.core.case.rules import At, OneOf, Row
from vibecalc.core.case.walk import Shape, bound_words, keys_of, shape_at, unit_problem, words
from vibecalc.errors import KeyPath, Problem, UnitError, UsageError, dotted
from vibecalc.units import parse_quantity

# ----------------------------------------------------------------------------
# Keys of this case that may be changed.
# ----------------------------------------------------------------------------

CHANGEABLE = ("machine", "excitation", "isolation")
#: kinds of keys that a search may move, and those that it may pick from a list
_CONTINUOUS, PICKED = ("number",), ("number", "whole", "choice")
#: keys that were met, with the place that changes them
Seen = dict[str, KeyPath]


def changeable(case: Data, key: str, tables: tuple[str, ...], kinds: tuple[str, ...]) -> Shape:
    """Shape of a key of this case that a search may set; UsageError, with a hint, if it may not.

    The key has to be one of these kinds below one of `tables`; a key that may be left out need not
    be there, unless one stands there that excludes it.
    """
    target = parse_key(key)
    shape, last = shape_at(target), str(target[-1])
    if target[0] not in tables:
        raise UsageError(f"only keys below {', '.join(tables)} can be changed")
    if shape is None:
        raise UsageError(no_such_key(target))
    if shape.kind not in kinds:
        what = "a continuous number" if kinds == _CONTINUOUS else "a number or a name"
        raise UsageError(f"{dotted(target)} is not {what}, but {words(shape)}")
    row = _table_of(case, target)
    if row is None or keys_of(row.model)[last].is_required():
        get_key(case, target)
    elif last not in row:
        with_key = Row({**row.data, last: math.nan}, row.path, case, row.model)
        for rule in row.model.RULES:
            given = rule.given(with_key) if isinstance(rule, OneOf) else []
            if len(given) > 1:
                raise UsageError(f"{given[1]} and {given[0]} are mutually exclusive")
    return shape


def _table_of(case: Data, target: KeyPath) -> Row | None:
    """The table of the case that may have such a key; None for an entry of a list."""
    table, parent = get_key(case, target[:-1]), shape_at(target[:-1])
    if not isinstance(table, dict) or parent is None or parent.table is None:
        return None
    return Row(table, target[:-1], case, parent.table)


def no_such_key(target: KeyPath) -> str:
    """Words on a key that no case has: which part of it, and what may have been meant."""
    size = next(size for size in range(len(target)) if shape_at(target[: size + 1]) is None)
    parent = shape_at(target[:size])
    known = list(keys_of(parent.table)) if parent and parent.table else []
    hint = nearest(str(target[size]), known)
    where = dotted(target[:size]) or "a case"
    return "; ".join(filter(None, (f"{where} has no key {target[size]!r}", hint)))


def _changed(
    row: Row,
    at: At,
    key: Any,
    seen: Seen,
    kinds: tuple[str, ...] = _CONTINUOUS,
    tables: tuple[str, ...] = CHANGEABLE,
    refusal: str = "a search cannot change this key",
    twice: str = "{key} is changed twice",
) -> Generator[Problem, None, Shape | None]:
    """Yield what is wrong with a key that is changed; returns its shape, None where it has none."""
    if not isinstance(key, str) or not key:
        return None
    try:
        shape = changeable(row.case, key, tables, kinds)
    except UsageError as error:
        allowed = "the key of a number of this case, as in machine.mounts.each.stiffness"
        yield row.problem(at, refusal, found=key[:80], allowed=allowed, hint=str(error))
        return None
    if key in seen:
        yield row.problem(at, twice.format(key=key), also=seen[key])
    seen.setdefault(key, row.place(at))
    return shape


# ----------------------------------------------------------------------------
# Values that a key may have: bounds, what follows from them, entries of a list.
# ----------------------------------------------------------------------------

#: most whole numbers between two bounds
MOST_WHOLE = 10_000


def _bounds(row: Row, shape: Shape) -> Generator[Problem, None, list[float]]:
    """Problems of `min` and `max`: unit, range, order; returns those that can be read."""
    values: list[float] = []
    for side in ("min", "max"):
        if not is_value(row[side]):
            continue
        try:
            values.append(shape.number(row[side]))
        except UnitError as error:
            yield unit_problem(error, row.place(side), shape, f"{side}: ")
            continue
        if not shape.allows(values[-1]):
            message = f"{side} is outside the range of {row['key']}"
            yield row.problem(side, message, found=str(row[side])[:60], allowed=bound_words(shape))
    if len(values) == 2 and not values[0] < values[1]:
        yield row.problem(
            "min",
            "the lower bound has to be below the upper one",
            found=f"min {row['min']} and max {row['max']}",
            allowed="min < max",
            also="max",
        )
    return values


def _taken(row: Row, at: At, key: str, shape: Shape, values: list[float]) -> Iterator[Problem]:
    """That a key which follows would take a value that it must not have."""
    wrong = [value for value in values if not shape.allows(value)]
    if wrong:
        message = f"between the bounds {key} would take a value outside its range"
        found = f"{wrong[0]:.6g} {shape.unit or ''}".rstrip()
        yield row.problem(at, message, found=found, allowed=bound_words(shape))


def read_choice(value: Any, shape: Shape) -> float | int | str:
    """A value of a list as the case holds it, in SI; UnitError for what its key cannot be."""
    found = str(value)[:60]
    if shape.kind == "choice":
        if value not in shape.choices:
            near = nearest(str(value), [str(one) for one in shape.choices])
            raise UnitError("no value of this key", found=repr(value)[:60], hint=near)
        return str(value)
    number = shape.number(value)
    if not shape.allows(number):
        raise UnitError("a value outside the range of the key", found=found)
    if shape.kind == "whole" and number != int(number):
        raise UnitError("not a whole number", found=found)
    return int(number) if shape.kind == "whole" else number


def _read(value: Any, shape: Shape, path: KeyPath) -> Generator[Problem, None, Any]:
    if not is_value(value):
        return None
    try:
        return read_choice(value, shape)
    except UnitError as error:
        yield unit_problem(error, path, shape, "")
        return None


# ----------------------------------------------------------------------------
# [optimisation] and [fit]: variables with what follows them, stocks, keys that scatter.
# ----------------------------------------------------------------------------

_WHO: dict[str | int, str] = {"optimisation": "the optimiser", "fit": "a fit"}


def check_search(row: Row) -> Iterator[Problem]:
    """Yield the problems of what a search changes, of what it picks and of what scatters."""
    seen: Seen = {}
    refusal = f"{_WHO.get(row.path[0], 'a search')} cannot change this key"
    twice = "two variables change {key}"
    for variable in row.each("variables"):
        picked = variable.data.get("choices") or variable["integer"] is True
        kinds, key = PICKED if picked else _CONTINUOUS, variable["key"]
        shape = yield from _changed(variable, "key", key, seen, kinds, refusal=refusal, twice=twice)
        if shape is None:
            continue
        if variable.data.get("choices"):
            yield from _choices(variable, shape)
        else:
            yield from _bounds(variable, shape)
            if picked:
                yield from _whole_ones(variable, shape)
        for tie in variable.each("followed_by"):
            of = yield from _changed(tie, "key", tie["key"], seen, refusal=refusal, twice=twice)
            if of is not None:
                yield from _tie(variable, shape, tie, of)
    for stock in row.each("stock"):
        yield from _stock(stock, seen)
    robust, scattered = row.below("robust"), Seen()
    for tolerance in robust.each("tolerances") if robust else ():
        shape = yield from _changed(
            tolerance,
            "key",
            tolerance["key"],
            scattered,
            tables=(*CHANGEABLE, "response"),
            refusal="this key cannot have a tolerance",
            twice="{key} has two tolerances",
        )
        for side in ("half_width", "deviation") if shape else ():
            yield from _size(tolerance, side, shape.unit or "" if shape else "")


def _tie(variable: Row, leads: Shape, tie: Row, shape: Shape) -> Iterator[Problem]:
    """Problems of a key that follows a variable: its unit, and values it would take."""
    unit, factor = shape.unit or "", tie["factor"]
    if unit != (leads.unit or ""):
        message = f"{tie['key']} cannot follow {variable['key']}: they have other units"
        found = f"{unit or 'no unit'} and {leads.unit or 'no unit'}"
        yield tie.problem("key", message, found=found)
        return
    offset = read_number(tie.data.get("offset", 0.0), unit, difference=True)
    if offset is None:
        found = str(tie["offset"])[:60]
        message = "no offset in the unit of the key"
        yield tie.problem("offset", message, found=found, allowed=unit or "a number")
    elif isinstance(factor, int | float) and not isinstance(factor, bool):
        bounds = (read_number(variable[side], unit) for side in ("min", "max"))
        values = [factor * bound + offset for bound in bounds if bound is not None]
        yield from _taken(tie, "", tie["key"], shape, values)


def _choices(variable: Row, shape: Shape) -> Iterator[Problem]:
    """Problems of `choices` of a variable: values of its key, each once."""
    taken: dict[Any, int] = {}
    for place, value in enumerate(variable.entries("choices")):
        path = (*variable.path, "choices", place)
        read = yield from _read(value, shape, path)
        if read is not None and taken.setdefault(read, place) != place:
            also = (*path[:-1], taken[read])
            yield variable.problem(path, f"{str(value)[:40]} is given twice", also=also)
    if shape.kind == "choice" and variable["followed_by"]:
        yield variable.problem("followed_by", "no key can follow one that holds names")


def whole_numbers(lower: float, upper: float) -> range:
    """The whole numbers between two bounds."""
    return range(math.ceil(lower), math.floor(upper) + 1)


def _whole_ones(variable: Row, shape: Shape) -> Iterator[Problem]:
    """Problems of a variable of whole numbers: its unit, and that there are some."""
    if shape.unit:
        yield variable.problem(
            "integer",
            f"{variable['key']} has units, and no whole numbers",
            found=shape.unit,
            allowed="a list of values",
            hint='choices = ["1 mm", "2 mm"]',
        )
        return
    low, high = (read_number(variable[side], "") for side in ("min", "max"))
    if low is None or high is None or not low < high:
        return
    count = len(whole_numbers(low, high)) if max(abs(low), abs(high)) < 1e15 else 0
    if not 1 <= count <= MOST_WHOLE:
        yield variable.problem(
            "min",
            "no whole number between the bounds" if not count else "too many whole numbers",
            found=f"{variable['min']} to {variable['max']}",
            allowed=f"1 to {MOST_WHOLE} of them",
            also="max",
        )


def _stock(stock: Row, seen: Seen) -> Iterator[Problem]:
    """Problems of a stock: the tables that take over what is picked, and what its items settle."""
    places: list[tuple[KeyPath, Any]] = [(stock.place("table"), stock["table"])]
    places += [
        ((*stock.path, "further_tables", n), one)
        for n, one in enumerate(stock.entries("further_tables"))
    ]
    tables = []
    for path, table in places:
        if isinstance(table, str) and table:
            try:
                _check_table(stock.case, table)
                tables.append(table)
            except UsageError as error:
                yield stock.problem(
                    path,
                    "nothing can be put there",
                    found=table[:80],
                    allowed="a table of this case, as machine.mounts.each",
                    hint=str(error),
                )
    items = stock.each("items")
    first = items[0]["values"] if items else None
    for item in items:
        values = item["values"]
        if not isinstance(values, dict) or not isinstance(first, dict):
            continue
        if values.keys() != first.keys():
            yield item.problem(
                "values",
                "all items of a stock settle the same keys",
                found=", ".join(values) or "no key",
                allowed=", ".join(first),
                also=items[0].place("values"),
            )
            continue
        for table in tables:
            for key in values:
                yield from _item(item, table, key, seen, item is items[0])


def _check_table(case: Data, table: str) -> None:
    """Raises UsageError where the case has no such table that may be changed."""
    target = parse_key(table)
    shape = shape_at(target)
    if target[0] not in CHANGEABLE:
        raise UsageError(f"only tables below {', '.join(CHANGEABLE)} can be changed")
    if shape is None or shape.table is None:
        raise UsageError(f"a case has no table at {table}")
    get_key(case, target)


def _item(item: Row, table: str, last: str, seen: Seen, first: bool) -> Iterator[Problem]:
    """Problems of one value of an item of a stock; those of its key are said of the first item."""
    key, path = f"{table}.{last}", (*item.path, "values", last)
    try:
        shape = changeable(item.case, key, CHANGEABLE, PICKED)
    except UsageError as error:
        if first:
            parent = shape_at(parse_key(table))
            known = list(keys_of(parent.table)) if parent and parent.table else []
            yield item.problem(
                path,
                "a stock cannot settle this key",
                found=key[:80],
                allowed="keys of the table that hold a number or a name",
                hint=nearest(last, known) or str(error),
            )
        return
    if seen.setdefault(key, path)[: len(path) - 3] != path[:-3]:
        yield item.problem(path, f"{key} is changed twice", also=seen[key])
    yield from _read(item["values"][last], shape, path)


def _size(row: Row, side: str, unit: str) -> Iterator[Problem]:
    """Problems of how far a key scatters."""
    if not is_value(row[side]):
        return
    found = str(row[side])[:60]
    try:
        size, _ = share_or_size(row[side], unit)
    except UnitError as error:
        allowed = f"a size{f' in {unit}' if unit else ''}, or a share as '15 %'"
        yield row.problem(side, error.message, found=found, allowed=allowed)
        return
    if not 0.0 < size < math.inf:
        yield row.problem(side, "a tolerance is above zero", found=found)


def share_or_size(value: float | str, unit: str) -> tuple[float, bool]:
    """A tolerance in SI, and whether it is a share of the value: what is given in percent."""
    share = isinstance(value, str) and value.rstrip().endswith("%")
    return parse_quantity(value, "" if share else unit, difference=True), share


# ----------------------------------------------------------------------------
# [[find]]: a key, its bounds, and the keys that change in its ratio.
# ----------------------------------------------------------------------------

_SEARCHABLE = ("machine", "excitation", "response", "isolation")


def check_find(row: Row) -> Iterator[Problem]:
    """Yield the problems of key, bounds, and of the keys that follow it, of one [[find]]."""
    seen: Seen = {}
    key, also, ratios = row["key"], row["scaled_with"], list[float]()
    lead = yield from _number(row, "key", key, seen)
    if lead is not None:
        shape, written = lead
        bounds = yield from _bounds(row, shape)
        if written:
            ratios = [bound / written for bound in bounds if not math.isnan(written)]
        if also and written == 0.0:
            message = "keys cannot change in the ratio of one that is zero as written"
            yield row.problem("key", message, found=f"{key} = 0", also="scaled_with")
        elif also and math.isnan(written):
            message = f"keys cannot change in the ratio of {key}, which the case leaves out"
            yield row.problem("scaled_with", message, hint=f"write {key} into the case")
    for place, other in enumerate(row.entries("scaled_with")):
        at = (*row.path, "scaled_with", place)
        number = yield from _number(row, at, other, seen)
        if number is not None:
            shape, written = number
            if written == 0.0:
                message = "a key that is zero does not change in any ratio"
                yield row.problem(at, message, found=f"{other} = 0")
            yield from _taken(row, at, other, shape, [ratio * written for ratio in ratios])


def _number(
    row: Row, at: At, key: Any, seen: Seen
) -> Generator[Problem, None, tuple[Shape, float] | None]:
    """Yield the problems of a key; returns its shape and its value in SI, nan if left out."""
    shape = yield from _changed(row, at, key, seen, tables=_SEARCHABLE)
    if shape is None:
        return None
    target = parse_key(key)
    table = _table_of(row.case, target)
    written = get_key(row.case, target) if table is None else table[str(target[-1])]
    if isinstance(written, list):
        words = {
            "found": f"a list of {len(written)} numbers",
            "allowed": f"one of them, as {key}[0]",
        }
        yield row.problem(at, f"{key} is a list here", **words)
        return None
    number = math.nan if written is None else read_number(written, shape.unit or "")
    return None if number is None else (shape, number)
