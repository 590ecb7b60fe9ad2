"""Keys that a sweep may vary, and from the table of one in `[sweep]` to the values it takes."""

import difflib
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.case.diagnose import shown
from vibecalc.core.case.raw import get_key, key_text, parse_key
from vibecalc.core.case.study_tables import Along, Distribution
from vibecalc.core.case.walk import Shape, allowed_of, keys_of, shape_at, with_names, words
from vibecalc.core.study.sweep.values import (
    PARAMETERS,
    AxisValues,
    RandomValues,
    Scatter,
    SpacedValues,
    ValueList,
)
from vibecalc.errors import KeyPath, Problem, UnitError, UsageError
from vibecalc.units import parse_quantity, split_number

# ----------------------------------------------------------------------------
# The keys a sweep may vary: numbers, choices, names, switches, and whole lists and tables.
# ----------------------------------------------------------------------------

VARIED = (
    *("machine", "kinematics", "excitation", "balance", "response", "isolation", "foundation"),
    *("measurement", "tuning", "damper_design", "bearing_loads", "accuracy"),
    *("point", "vibration_severity", "base_motion"),
)
_VARIABLE = ("number", "whole", "choice", "text", "flag", "list", "table")
_LISTED = 64  # entries of a list whose keys are offered as the nearest ones


def target(key: str, resolved: Mapping[str, Any]) -> tuple[KeyPath, Shape]:
    """Path and shape of a key that a sweep may vary; UsageError, with the nearest key, if not.

    `resolved` is the case in SI with its defaults. The table of the key has to be there, the key
    itself may be absent.
    """
    path = parse_key(key)
    shape = shape_at(path)
    if shape is None:
        raise UsageError(f"a case has no key {key_text(path)}{_nearest(path, resolved)}")
    if path[0] not in VARIED:
        raise UsageError(f"only keys below {', '.join(VARIED)} can vary")
    if shape.kind not in _VARIABLE:
        raise UsageError(f"{key_text(path)} is {words(shape)}, which no sweep varies")
    if not _may_be_added(path, resolved):
        get_key(resolved, path)
    return path, shape


def _may_be_added(path: KeyPath, resolved: Mapping[str, Any]) -> bool:
    """Whether the table of a key is there, or the key is the next entry of a list in such a one."""
    last = path[-1]
    if isinstance(last, str):
        return isinstance(get_key(resolved, path[:-1]), dict)
    shape, table = shape_at(path[:-1]), get_key(resolved, path[:-2])
    if shape is None or shape.kind != "list" or not isinstance(table, dict):
        return False
    return last == len(table.get(path[-2], ()))


def label(path: KeyPath) -> str:
    """What the schema says of a key, for axes of plots; the key itself where it says nothing."""
    for size in range(len(path), 0, -1):
        name, parent = path[size - 1], shape_at(path[: size - 1])
        if isinstance(name, str) and parent is not None and parent.table is not None:
            return keys_of(parent.table)[name].description or key_text(path)
    return key_text(path)


def _nearest(path: KeyPath, resolved: Mapping[str, Any]) -> str:
    known = dict.fromkeys([*_leaves(resolved, ()), *_siblings(path)])
    near = difflib.get_close_matches(key_text(path), known, n=1, cutoff=0.6)
    return f"; did you mean {near[0]}?" if near else ""


def _siblings(path: KeyPath) -> Iterator[str]:
    """Keys of the innermost table on the way that the schema knows, present or not."""
    for size in range(len(path) - 1, 0, -1):
        parent = shape_at(path[:size])
        if parent is not None and parent.table is not None:
            yield from (key_text((*path[:size], name)) for name in keys_of(parent.table))
            return


def _leaves(place: Any, above: KeyPath) -> Iterator[str]:
    """Keys of numbers and choices that are in the case, at or below a place."""
    if above:
        if above[0] not in VARIED:
            return
        shape = shape_at(above)
        if shape is not None and shape.kind in ("number", "whole", "choice"):
            yield key_text(above)
            return
    else:
        shape = None
    entries: list[tuple[str | int, Any]] = []
    if isinstance(place, dict):
        entries = list(place.items())
    elif isinstance(place, list):
        entries = list(enumerate(place[:_LISTED]))
    for name, entry in entries:
        yield from _leaves(entry, (*above, name))


# ----------------------------------------------------------------------------
# From one key's table in `[sweep]` to the values it takes; what is wrong goes into a list.
# ----------------------------------------------------------------------------

Written = str | int | float

_MOST_WHOLE = 100_000  # whole numbers on an axis; a longer one is not looked through


class KeyPlace(NamedTuple):
    """One key's table, where it stands, what its key may hold, and where problems go."""

    table: Along
    path: KeyPath
    shape: Shape
    problems: list[Problem]

    def refuse(
        self, key: str, message: str, *, found: str = "", allowed: str = "", hint: str = ""
    ) -> None:
        """Note a problem at a key of the table."""
        path = (*self.path, key)
        self.problems.append(
            Problem(path=path, message=message, found=found, allowed=allowed, hint=hint)
        )


def read_values(place: KeyPlace, sampled: bool, points: int | None) -> AxisValues | None:
    """The values of one key; None if its table has problems. `points` stands in for absent ones."""
    table, choice = place.table, place.shape.kind not in ("number", "whole")
    forms = {
        "values": bool(table.values),
        "from": table.start is not None or table.stop is not None,
        "distribution": table.distribution is not None,
    }
    used = [form for form, there in forms.items() if there]
    if len(used) != 1:
        what = "says twice what it takes" if used else "has no values"
        place.refuse(
            used[-1] if used else "key",
            f"{table.key[:80]} {what}",
            found=" and ".join(used),
            allowed="values = [...], or from, to and points, or a distribution",
        )
        return None
    for key, given in (("points", table.points), ("spacing", table.spacing)):
        if given is not None and used != ["from"]:
            place.refuse(key, f"{key} belongs to from and to, not to {used[0]}")
            return None
    if choice and used != ["values"]:
        place.refuse(used[0], f"{table.key} is a {place.shape.kind}", allowed=words(place.shape))
        return None
    if used == ["values"]:
        return _listed(place)
    if used == ["from"]:
        return _spread(place, sampled, points)
    return _drawn(place, sampled)


def _listed(place: KeyPlace) -> ValueList | None:
    values = place.table.values
    if len(values) < 2:
        place.refuse(
            "values",
            "an axis needs two points or more",
            found="one",
            hint=f"a single value is --set {place.table.key}={values[0]}",
        )
        return None
    if place.shape.kind in ("choice", "text"):
        return _choices(place)
    whole = any(isinstance(value, list | tuple | dict) for value in values)
    if whole or place.shape.kind not in ("number", "whole"):
        return _wholes(place)
    numbers = []
    for value in values:
        number = _number(place, "values", value)
        if number is None:  # the first wrong one is enough
            return None
        numbers.append(number)
    return (
        ValueList(values=tuple(numbers)) if _whole_where_needed(place, np.array(numbers)) else None
    )


def _choices(place: KeyPlace) -> ValueList | None:
    allowed = place.shape.choices
    named = place.shape.kind == "text"
    wrong = [value for value in place.table.values if value not in allowed and not named]
    if wrong:
        near = difflib.get_close_matches(str(wrong[0]), [str(one) for one in allowed], n=1)
        place.refuse(
            "values",
            f"{place.table.key} cannot be {wrong[0]!r:.60}",
            allowed=words(place.shape),
            hint=f"did you mean {near[0]!r}?" if near else "",
        )
        return None
    return ValueList(values=tuple(str(value) for value in place.table.values))


#: what a value of a kind of key that is no number is in TOML
_TYPES = {"flag": bool, "list": list | tuple, "table": dict}
_SWITCH = {"true": True, "false": False}
_LONGEST_LABEL = 40


def _wholes(place: KeyPlace) -> ValueList | None:
    """Lists, tables and switches, each as one value."""
    shape, kind = place.shape, place.shape.kind
    values = tuple(
        _SWITCH.get(str(one), one) if kind == "flag" else one for one in place.table.values
    )
    values = tuple(with_names(shape, one) for one in values)
    three = (list, tuple, str, int, float) if shape.or_three else ()
    wrong = [one for one in values if not isinstance(one, _TYPES.get(kind, three))]
    if wrong:
        example = f"values = [[...], [...]], {words(shape)}" if kind == "list" else words(shape)
        message = f"{place.table.key} cannot be {shown(wrong[0])}"
        hint = f"a key in it is {place.table.key}[0]" if kind == "list" else ""
        place.refuse("values", message, found=shown(wrong[0]), allowed=example, hint=hint)
        return None
    return ValueList(values=labels(values), contents=values)


def labels(values: Sequence[Any]) -> tuple[str, ...]:
    """What stands for lists and tables in files and reports: themselves, or number and begin."""
    texts = [_compact(value) for value in values]
    return tuple(
        text if len(text) <= _LONGEST_LABEL else f"{number}: {text[: _LONGEST_LABEL - 8]} ..."
        for number, text in enumerate(texts, 1)
    )


def _compact(value: Any) -> str:
    if isinstance(value, dict):
        return f"{{{','.join(f'{key}={_compact(one)}' for key, one in value.items())}}}"
    if isinstance(value, list | tuple):
        return f"[{','.join(map(_compact, value))}]"
    return str(value).lower() if isinstance(value, bool) else str(value)


def _spread(place: KeyPlace, sampled: bool, points: int | None) -> SpacedValues | None:
    table = place.table
    if table.start is None or table.stop is None:
        missing = "from" if table.start is None else "to"
        place.refuse("key", f"{missing} is missing", allowed="from, to and points")
        return None
    first, last = _number(place, "from", table.start), _number(place, "to", table.stop)
    if first is None or last is None:
        return None
    ends = (first, last)
    if first == last:
        place.refuse("to", "from and to are the same value", found=str(table.stop))
        return None
    logarithmic = table.spacing == "log"
    if logarithmic and not (min(ends) > 0.0 or max(ends) < 0.0):
        found = f"from {table.start} to {table.stop}"
        place.refuse("spacing", "equal ratios never pass zero", found=found, allowed="linear")
        return None
    count = table.points if table.points is not None else points
    if count is None and not sampled:
        place.refuse("key", "a grid needs the number of points", allowed="points = 21, say")
        return None
    if count is not None and count < 2:
        place.refuse("points", "an axis needs two points or more", found=str(count))
        return None
    start, stop, factor = _fractions(table.start, table.stop, place.shape.unit or "", ends)
    spread = SpacedValues(start=start, stop=stop, factor=factor, log=logarithmic, count=count)
    return spread if _whole_steps(place, spread) else None


def _fractions(
    start: Written, stop: Written, unit: str, ends: tuple[float, float]
) -> tuple[Fraction, Fraction, float]:
    """Both ends as written and their factor to SI; in SI where they are written differently.

    Also in SI where the unit is a scale with another zero.
    """
    texts = [split_number(str(end)) for end in (start, stop)]
    # a zero has no unit of its own
    units = {name for (_, name), end in zip(texts, ends, strict=True) if name or end}
    name = next(iter(units), "")
    if len(units) == 1 and not parse_quantity(f"0 {name}", unit):
        factor, numbers = parse_quantity(f"1 {name}", unit), [float(text) for text, _ in texts]
    else:
        factor, numbers = 1.0, list(ends)
    first, last = (Fraction(repr(number)) for number in numbers)
    return first, last, factor


def _drawn(place: KeyPlace, sampled: bool) -> RandomValues | None:
    given = place.table.distribution
    if given is None:
        return None
    if not sampled:
        hint = "or give values, or from, to and points"
        allowed = 'sampling = "sobol", "latin_hypercube" or "monte_carlo" in [sweep]'
        place.refuse("distribution", "a grid does not draw", allowed=allowed, hint=hint)
        return None
    if place.shape.kind == "whole":
        place.refuse("distribution", "a whole number cannot scatter", allowed="values = [...]")
        return None
    parameters = _parameters(place, given)
    if parameters is None:
        return None
    scatter = Scatter(kind=given.kind, parameters=parameters)
    objection = scatter.objection()
    if objection:
        place.refuse("distribution", objection)
        return None
    return RandomValues(scatter=scatter)


def _parameters(place: KeyPlace, given: Distribution) -> tuple[float, ...] | None:
    needed = PARAMETERS[given.kind]
    written = {name: getattr(given, name) for name in type(given).model_fields if name != "kind"}
    extra = [name for name, value in written.items() if value is not None and name not in needed]
    missing = [n for n in needed if written[n] is None and n != "mode"]
    if extra or missing:
        what = f"{extra[0]} too much" if extra else f"{missing[0]} too little"
        message = f"a {given.kind} distribution with {what}"
        place.refuse("distribution", message, allowed=" and ".join(needed))
        return None
    read = {
        name: _number(place, "distribution", written[name], difference=name == "deviation")
        for name in needed
        if written[name] is not None
    }
    numbers = {name: value for name, value in read.items() if value is not None}
    if len(numbers) < len(read):
        return None
    if "mode" in needed and "mode" not in numbers:
        numbers["mode"] = 0.5 * numbers["lower"] + 0.5 * numbers["upper"]
    return tuple(numbers[name] for name in needed)


def _number(
    place: KeyPlace, key: str, written: Written, *, difference: bool = False
) -> float | None:
    if isinstance(written, bool):
        place.refuse(key, f"{place.table.key} cannot be true or false", allowed=words(place.shape))
        return None
    try:
        shape = place.shape
        return shape._replace(difference=shape.difference or difference).number(written)
    except (UnitError, OverflowError) as error:
        unit_error = error if isinstance(error, UnitError) else UnitError("too large for a double")
        place.refuse(
            key,
            f"{place.table.key}: {unit_error.message}",
            found=unit_error.found,
            allowed=allowed_of(unit_error, place.shape),
            hint=unit_error.hint,
        )
        return None


def _whole_where_needed(place: KeyPlace, values: np.ndarray) -> bool:
    wrong = values[values != np.rint(values)] if place.shape.kind == "whole" else values[:0]
    if wrong.size:
        place.refuse(
            "values" if place.table.values else "points",
            f"{place.table.key} takes whole numbers only",
            found=f"{wrong[0]:.9g}" + (f" and {wrong.size - 1} more" if wrong.size > 1 else ""),
        )
    return not wrong.size


def _whole_steps(place: KeyPlace, spread: SpacedValues) -> bool:
    if place.shape.kind != "whole":
        return True
    if spread.count is None or spread.count > _MOST_WHOLE:
        place.refuse("from", "a whole number needs its points", allowed="values, or points")
        return False
    return _whole_where_needed(place, spread.at(np.arange(spread.count)))
