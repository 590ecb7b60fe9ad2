"""Keys that a sweep may vary, and from the table of one in `[sweep]` to the values it takes."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.case.diagnose import shown
from vibecalc.core.case.raw import get_key, parse_key
from vibecalc.core.case.search_checks import no_such_key, read_choice
from vibecalc.core.case.study_tables import Along, Distribution
from vibecalc.core.case.walk import Shape, keys_of, shape_at, unit_problem, with_names, words
from vibecalc.core.results.sweep_file import SweptKey
from vibecalc.core.study.sweep.values import (
    PARAMETERS,
    Values,
    listed,
    objection,
    scattered,
    spaced,
)
from vibecalc.errors import CaseError, KeyPath, Problem, UnitError, UsageError, dotted
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


@dataclass(frozen=True, kw_only=True)
class AxisKey(SweptKey):
    """A key that varies: taken apart, with what it may hold, its values, and its table's place."""

    path: KeyPath
    shape: Shape
    values: Values
    place: KeyPath

    @property
    def whole(self) -> bool:
        """Whether its values are whole numbers, or count choices."""
        return bool(self.choices) or self.shape.kind == "whole"

    def typed(self, column: np.ndarray) -> list[Any]:
        """Values as a case has them: doubles, whole numbers, names, lists or tables."""
        listed = column.astype(np.int64).tolist() if self.whole else column.tolist()
        meant = self.values.contents or self.choices
        return [meant[place] for place in listed] if meant else listed


def refused(path: KeyPath, message: str, **words: Any) -> CaseError:
    """What is wrong at one place of the case."""
    return CaseError([Problem(path=path, message=message, **words)])


def read_key(
    table: Along, place: KeyPath, resolved: Mapping[str, Any], sampled: bool, points: int | None
) -> AxisKey:
    """One key with its values for a case in SI with its defaults; `points` stands in for absent
    ones. CaseError for what is wrong with it."""
    try:
        path, shape = _target(table.key, resolved)
    except UsageError as error:
        raise refused(
            (*place, "key"),
            "a sweep cannot vary this key",
            found=table.key[:80],
            allowed="a number or a choice of this case, as in machine.mounts.each.stiffness",
            hint=str(error),
        ) from error
    read = _KeyTable(table, place, shape)
    values = read.values(sampled, points)
    return AxisKey(
        key=dotted(path),
        label=_label(path),
        unit=shape.unit or "",
        written_unit=read.written_unit(),
        choices=values.names,
        path=path,
        shape=shape,
        values=values,
        place=place,
    )


def _target(key: str, resolved: Mapping[str, Any]) -> tuple[KeyPath, Shape]:
    """Path and shape of a key; UsageError, with what was meant, if a sweep may not vary it.

    The table of the key has to be there, the key itself may be absent.
    """
    path = parse_key(key)
    shape = shape_at(path)
    if shape is None:
        raise UsageError(no_such_key(path))
    if path[0] not in VARIED:
        raise UsageError(f"only keys below {', '.join(VARIED)} can vary")
    if shape.kind not in _VARIABLE:
        raise UsageError(f"{dotted(path)} is {words(shape)}, which no sweep varies")
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


def _label(path: KeyPath) -> str:
    """What the schema says of a key, for axes of plots; the key itself where it says nothing."""
    for size in range(len(path), 0, -1):
        name, parent = path[size - 1], shape_at(path[: size - 1])
        if isinstance(name, str) and parent is not None and parent.table is not None:
            return keys_of(parent.table)[name].description or dotted(path)
    return dotted(path)


# ----------------------------------------------------------------------------
# From one key's table in `[sweep]` to the values it takes.
# ----------------------------------------------------------------------------

Written = str | int | float

_MOST_WHOLE = 100_000  # whole numbers on an axis; a longer one is not looked through
#: what a value of a kind of key that is no number is in TOML
_TYPES = {"flag": bool, "list": list | tuple, "table": dict}
_SWITCH = {"true": True, "false": False}
_LONGEST_LABEL = 40


class _KeyTable(NamedTuple):
    """One key's table in `[sweep]`, its place there, and what the key may hold."""

    table: Along
    place: KeyPath
    shape: Shape

    def refused(self, key: str, message: str, **words: str) -> CaseError:
        """What is wrong at a key of the table."""
        return refused((*self.place, key), message, **words)

    def number(self, key: str, written: Any, *, difference: bool = False) -> float:
        """A value in SI."""
        shape = self.shape
        try:
            return shape._replace(difference=shape.difference or difference).number(written)
        except UnitError as error:
            problem = unit_problem(error, (*self.place, key), shape, f"{self.table.key}: ")
            raise CaseError([problem]) from None

    def written_unit(self) -> str:
        """The unit in which the values of a number are written, the first that has one."""
        table, given = self.table, self.table.distribution
        drawn = (given.mean, given.max, given.min) if given else ()
        texts = (table.stop, table.start, *table.values, *drawn)
        number = self.shape.kind == "number"
        units = (split_number(one)[1] for one in texts if number and isinstance(one, str))
        return next(filter(None, units), self.shape.unit or "")

    def values(self, sampled: bool, points: int | None) -> Values:
        """The values of the key; CaseError with one problem."""
        table, kind = self.table, self.shape.kind
        if table.values:
            return self.listed(table.values)
        if kind not in ("number", "whole"):
            form = "distribution" if table.distribution else "from"
            raise self.refused(form, f"{table.key} is a {kind}", allowed=words(self.shape))
        if table.distribution is not None:
            return self.drawn(table.distribution, sampled)
        return self.spread(sampled, table.points if table.points is not None else points)

    def listed(self, written: Sequence[Any]) -> Values:
        """Numbers, choices, lists, tables or switches, one by one."""
        shape, name = self.shape, self.table.key
        if len(written) < 2:
            hint = f"a single value is --set {name}={written[0]}"
            raise self.refused("values", "an axis needs two points or more", found="one", hint=hint)
        if shape.kind == "text":
            return listed(tuple(map(str, written)))
        single = not any(isinstance(one, list | tuple | dict | bool) for one in written)
        if not single or shape.kind not in ("choice", "number", "whole"):
            contents = self.contents(written)
            return listed(labels(contents), contents)
        try:
            values: tuple[Any, ...] = tuple(read_choice(one, shape) for one in written)
        except UnitError as error:
            problem = unit_problem(error, (*self.place, "values"), shape, f"{name}: ")
            raise CaseError([problem]) from None
        return listed(values)

    def contents(self, written: Sequence[Any]) -> tuple[Any, ...]:
        """Lists, tables and switches, each as one value."""
        shape, kind = self.shape, self.shape.kind
        given = [_SWITCH.get(str(one), one) if kind == "flag" else one for one in written]
        values = tuple(with_names(shape, one) for one in given)
        three = (list, tuple, str, int, float) if shape.or_three else ()
        for one in values:
            switch = isinstance(one, bool)
            if switch != (kind == "flag") or not isinstance(one, _TYPES.get(kind, three)):
                raise self.refused(
                    "values",
                    f"{self.table.key} cannot be {shown(one)}",
                    found=shown(one),
                    allowed="values = [[...], [...]], " * (kind == "list") + words(shape),
                    hint=f"a key in it is {self.table.key}[0]" if kind == "list" else "",
                )
        return values

    def spread(self, sampled: bool, count: int | None) -> Values:
        """From one end to the other, or drawn between them where there is no count."""
        table = self.table
        ends = self.number("from", table.start), self.number("to", table.stop)
        if ends[0] == ends[1]:
            raise self.refused("to", "from and to are the same value", found=str(table.stop))
        logarithmic = table.spacing == "log"
        if logarithmic and not (min(ends) > 0.0 or max(ends) < 0.0):
            found = f"from {table.start} to {table.stop}"
            raise self.refused(
                "spacing", "logarithmic spacing cannot pass zero", found=found, allowed="linear"
            )
        if count is None and not sampled:
            allowed = "points = 21, say"
            raise self.refused("key", "a grid needs the number of points", allowed=allowed)
        if count is not None and count < 2:
            raise self.refused("points", "an axis needs two points or more", found=str(count))
        whole = self.shape.kind == "whole"
        if whole and (count is None or count > _MOST_WHOLE):
            message = "a whole number needs its points"
            raise self.refused("from", message, allowed="values, or points")
        if count is None:
            return scattered("log_uniform" if logarithmic else "uniform", *ends)
        written = as_written(table.start, table.stop, self.shape.unit or "", ends)
        values = spaced(*written, table.spacing or "linear", count)
        numbers = values.at(np.arange(count)) if whole else np.empty(0)
        wrong = numbers[numbers != np.rint(numbers)]
        if wrong.size:
            more = f" and {wrong.size - 1} more" if wrong.size > 1 else ""
            message = f"{table.key} takes whole numbers only"
            raise self.refused("points", message, found=f"{wrong[0]:.9g}{more}")
        return values

    def drawn(self, given: Distribution, sampled: bool) -> Values:
        """By a distribution."""
        if not sampled:
            hint = "or give values, or from, to and points"
            allowed = 'sampling = "sobol", "latin_hypercube" or "monte_carlo" in [sweep]'
            raise self.refused(
                "distribution", "a grid has no random values", allowed=allowed, hint=hint
            )
        if self.shape.kind == "whole":
            message = "a whole number cannot have a distribution"
            raise self.refused("distribution", message, allowed="values = [...]")
        numbers = {
            name: self.number("distribution", one, difference=name == "deviation")
            for name in PARAMETERS[given.kind]
            if (one := getattr(given, name)) is not None
        }
        if given.kind == "triangular":
            numbers.setdefault("mode", 0.5 * numbers["min"] + 0.5 * numbers["max"])
        parameters = [numbers[name] for name in PARAMETERS[given.kind]]
        if wrong := objection(given.kind, *parameters):
            raise self.refused("distribution", wrong)
        return scattered(given.kind, *parameters)


def labels(values: Sequence[Any]) -> tuple[str, ...]:
    """What stands for lists and tables in files and reports: themselves, or number and begin."""
    plain = (json.dumps(one, ensure_ascii=False, separators=(",", "=")) for one in values)
    return tuple(
        text if len(text) <= _LONGEST_LABEL else f"{number}: {text[: _LONGEST_LABEL - 8]} ..."
        for number, text in enumerate((one.replace('"', "") for one in plain), 1)
    )


def as_written(
    start: Written | None, stop: Written | None, unit: str, ends: tuple[float, float]
) -> tuple[Fraction, Fraction, float]:
    """Both ends as written and their factor to SI; in SI where they are written differently.

    Also in SI where the unit is a scale with another zero.
    """
    texts = [split_number(str(end)) for end in (start, stop)]
    # a zero has no unit of its own
    units = {name for (_, name), end in zip(texts, ends, strict=True) if name or end}
    name = next(iter(units), "")
    factor, numbers = 1.0, list(ends)
    if len(units) == 1 and not parse_quantity(f"0 {name}", unit):
        factor, numbers = parse_quantity(f"1 {name}", unit), [float(text) for text, _ in texts]
    first, last = (Fraction(repr(number)) for number in numbers)
    return first, last, factor
