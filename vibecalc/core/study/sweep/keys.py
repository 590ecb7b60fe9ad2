"""Keys that a sweep may vary, and from the table of one in `[sweep]` to the values it takes."""

import json
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.case.diagnose import shown
from vibecalc.core.case.raw import get_key, nearest, parse_key
from vibecalc.core.case.search_checks import no_such_key
from vibecalc.core.case.study_tables import Along, Distribution
from vibecalc.core.case.walk import Shape, keys_of, shape_at, unit_problem, with_names, words
from vibecalc.core.study.sweep.values import (
    PARAMETERS,
    AxisValues,
    Scatter,
    SpacedValues,
    ValueList,
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


def target(key: str, resolved: Mapping[str, Any]) -> tuple[KeyPath, Shape]:
    """Path and shape of a key that a sweep may vary; UsageError, with what was meant, if not.

    `resolved` is the case in SI with its defaults. The table of the key has to be there, the key
    itself may be absent.
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


def label(path: KeyPath) -> str:
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


def refused(path: KeyPath, message: str, **words: Any) -> CaseError:
    """What is wrong at one place of the case."""
    return CaseError([Problem(path=path, message=message, **words)])


class KeyTable(NamedTuple):
    """One key's table in `[sweep]`, its place there, the key taken apart and what it may hold."""

    table: Along
    place: KeyPath
    path: KeyPath
    shape: Shape

    def refused(self, key: str, message: str, **words: str) -> CaseError:
        """What is wrong at a key of the table."""
        return refused((*self.place, key), message, **words)

    def number(self, key: str, written: Any, *, difference: bool = False) -> float:
        """A value in SI."""
        name, shape = self.table.key, self.shape
        if isinstance(written, bool):
            raise self.refused(key, f"{name} cannot be true or false", allowed=words(shape))
        try:
            return shape._replace(difference=shape.difference or difference).number(written)
        except UnitError as error:
            problem = unit_problem(error, (*self.place, key), shape, f"{name}: ")
            raise CaseError([problem]) from None


def read_values(key: KeyTable, sampled: bool, points: int | None) -> AxisValues:
    """The values of one key; `points` stands in for absent ones. CaseError with one problem."""
    table, shape = key.table, key.shape
    if table.values:
        return _listed(key)
    if shape.kind not in ("number", "whole"):
        form = "distribution" if table.distribution else "from"
        raise key.refused(form, f"{table.key} is a {shape.kind}", allowed=words(shape))
    if table.distribution is not None:
        return _drawn(key, table.distribution, sampled)
    return _spread(key, sampled, points)


def _listed(key: KeyTable) -> ValueList:
    written, shape, name = key.table.values, key.shape, key.table.key
    if len(written) < 2:
        hint = f"a single value is --set {name}={written[0]}"
        raise key.refused("values", "an axis needs two points or more", found="one", hint=hint)
    if shape.kind in ("choice", "text"):
        wrong = [one for one in written if shape.kind == "choice" and one not in shape.choices]
        if wrong:
            raise key.refused(
                "values",
                f"{name} cannot be {wrong[0]!r:.60}",
                allowed=words(shape),
                hint=nearest(str(wrong[0]), [str(one) for one in shape.choices]),
            )
        return ValueList(values=tuple(str(one) for one in written))
    several = any(isinstance(one, list | tuple | dict) for one in written)
    if several or shape.kind not in ("number", "whole"):
        return _contents(key)
    numbers = tuple(key.number("values", one) for one in written)
    _check_whole(key, np.array(numbers))
    return ValueList(values=numbers)


#: what a value of a kind of key that is no number is in TOML
_TYPES = {"flag": bool, "list": list | tuple, "table": dict}
_SWITCH = {"true": True, "false": False}
_LONGEST_LABEL = 40


def _contents(key: KeyTable) -> ValueList:
    """Lists, tables and switches, each as one value."""
    shape, kind, name = key.shape, key.shape.kind, key.table.key
    written = [_SWITCH.get(str(one), one) if kind == "flag" else one for one in key.table.values]
    values = tuple(with_names(shape, one) for one in written)
    three = (list, tuple, str, int, float) if shape.or_three else ()
    wrong = [one for one in values if not isinstance(one, _TYPES.get(kind, three))]
    if wrong:
        raise key.refused(
            "values",
            f"{name} cannot be {shown(wrong[0])}",
            found=shown(wrong[0]),
            allowed="values = [[...], [...]], " * (kind == "list") + words(shape),
            hint=f"a key in it is {name}[0]" if kind == "list" else "",
        )
    return ValueList(values=labels(values), contents=values)


def labels(values: Sequence[Any]) -> tuple[str, ...]:
    """What stands for lists and tables in files and reports: themselves, or number and begin."""
    plain = (json.dumps(one, ensure_ascii=False, separators=(",", "=")) for one in values)
    return tuple(
        text if len(text) <= _LONGEST_LABEL else f"{number}: {text[: _LONGEST_LABEL - 8]} ..."
        for number, text in enumerate((one.replace('"', "") for one in plain), 1)
    )


def _spread(key: KeyTable, sampled: bool, points: int | None) -> AxisValues:
    table = key.table
    ends = key.number("from", table.start), key.number("to", table.stop)
    if ends[0] == ends[1]:
        raise key.refused("to", "from and to are the same value", found=str(table.stop))
    logarithmic = table.spacing == "log"
    if logarithmic and not (min(ends) > 0.0 or max(ends) < 0.0):
        found = f"from {table.start} to {table.stop}"
        raise key.refused("spacing", "equal ratios never pass zero", found=found, allowed="linear")
    count = table.points if table.points is not None else points
    if count is None and not sampled:
        raise key.refused("key", "a grid needs the number of points", allowed="points = 21, say")
    if count is not None and count < 2:
        raise key.refused("points", "an axis needs two points or more", found=str(count))
    whole = key.shape.kind == "whole"
    if whole and (count is None or count > _MOST_WHOLE):
        message = "a whole number needs its points"
        raise key.refused("from", message, allowed="values, or points")
    if count is None:
        return Scatter(kind="log_uniform" if logarithmic else "uniform", parameters=ends)
    start, stop, factor = _fractions(table.start, table.stop, key.shape.unit or "", ends)
    spread = SpacedValues(start=start, stop=stop, factor=factor, log=logarithmic, count=count)
    if whole:
        _check_whole(key, spread.at(np.arange(count)))
    return spread


def _fractions(
    start: Written | None, stop: Written | None, unit: str, ends: tuple[float, float]
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


def _drawn(key: KeyTable, given: Distribution, sampled: bool) -> Scatter:
    if not sampled:
        hint = "or give values, or from, to and points"
        allowed = 'sampling = "sobol", "latin_hypercube" or "monte_carlo" in [sweep]'
        raise key.refused("distribution", "a grid does not draw", allowed=allowed, hint=hint)
    if key.shape.kind == "whole":
        message = "a whole number cannot scatter"
        raise key.refused("distribution", message, allowed="values = [...]")
    needed, kind = PARAMETERS[given.kind], given.kind
    numbers = {
        name: key.number("distribution", one, difference=name == "deviation")
        for name in needed
        if (one := getattr(given, name)) is not None
    }
    if "mode" in needed:
        numbers.setdefault("mode", 0.5 * numbers["lower"] + 0.5 * numbers["upper"])
    scatter = Scatter(kind=kind, parameters=tuple(numbers[name] for name in needed))
    if objection := scatter.objection():
        raise key.refused("distribution", objection)
    return scatter


def _check_whole(key: KeyTable, values: np.ndarray) -> None:
    wrong = values[values != np.rint(values)] if key.shape.kind == "whole" else values[:0]
    if wrong.size:
        more = f" and {wrong.size - 1} more" if wrong.size > 1 else ""
        raise key.refused(
            "values" if key.table.values else "points",
            f"{key.table.key} takes whole numbers only",
            found=f"{wrong[0]:.9g}{more}",
        )
