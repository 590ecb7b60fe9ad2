"""What an optimisation is after, as its case says it: variables, choices, objectives, units."""

import math
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.case.raw import get_key
from vibecalc.core.report.sections import having, read_as, scalar_of, table_of
from vibecalc.core.report.writing import show_in
from vibecalc.core.results.record import AT_START, FRONT_NAMES, Estimate, Quantity, Record, Result
from vibecalc.core.results.select import Side, worst
from vibecalc.errors import ResultError, UsageError
from vibecalc.units import convert, parse_quantity, si_value, split_number

PREFIX = "optimisation/"
#: where an optimum stands in its bounds
SIDES = {-1: "at lower", 0: "", 1: "at upper"}
VARIABLE, PICKED, FRONT = f"{PREFIX}variable/", f"{PREFIX}choice/", f"{PREFIX}front/"
FITTED = "fit/value/"


def written_at(case: Mapping[str, Any], key: str) -> Any:
    """What a case has at a key, `machine.mounts[0].stiffness`; None if nothing."""
    with suppress(UsageError):
        return get_key(case, key)
    return None


#: words that more than one table has, and the tables that say whose they are
_SHARED = frozenset({"inertia", "stiffness", "damping", "torque", "gain"})
_OWNERS = frozenset({"rotor", "shell", "motor", "friction", "control"})


#: a coordinate of an entry of a list of places
_COORDINATE = re.compile(r"(?:.*\.)?(\w+)s\.(\w+)s\[(\d+)\]\[([012])\]")


def coordinate_words(key: str) -> str:
    """`position of mount 3 along x` for `machine.mounts.positions[2][0]`, else the key itself."""
    found = _COORDINATE.fullmatch(key)
    if found is None:
        return key
    owner, name, place, axis = (one.replace("_", " ") for one in found.groups())
    return f"{name} of {owner} {int(place) + 1} along {'xyz'[int(axis)]}"


def key_words(keys: Sequence[str], case: Mapping[str, Any]) -> list[str]:
    """The shortest end of each key that no other key has, and whose it is where many have such."""
    parts = [key.split(".") for key in keys]
    names = []
    for key, path in zip(keys, parts, strict=True):
        if coordinate_words(key) != key:
            names.append(coordinate_words(key))
            continue
        others = [other for other in parts if other is not path]
        alone = (n for n in range(1, len(path)) if all(o[-n:] != path[-n:] for o in others))
        size = next(alone, len(path))
        owned = path[-2:-1] != [] and path[-2] in _OWNERS
        if size == 1 and path[-1] in _SHARED and owned:
            size = 2
        owner = _member(".".join(path[:-1]), case) if size == 2 else ""
        mark = " " if size == 2 and owned else "."
        words = f"{path[-1]} of {owner}" if owner else mark.join(path[-size:])
        names.append(words.replace("_", " "))
    return names


def _member(key: str, case: Mapping[str, Any]) -> str:
    """The name that the case gives to a member of a list, `cylinders[0]`; empty if it has none."""
    found = written_at(case, key) if key.endswith("]") else None
    return str(found.get("name") or "") if isinstance(found, Mapping) else ""


# ----------------------------------------------------------------------------
# Variables, in the unit that a case thinks of them.
# ----------------------------------------------------------------------------


class Variable(NamedTuple):
    """A variable of numbers: bounds, start (None without one) and optimum, all in `unit`."""

    key: str
    unit: str
    factor: float
    lower: float
    upper: float
    start: float | None
    value: float
    error: float


def bound_unit(table: Mapping[str, Any], unit: str) -> str:
    """Unit of the bounds or choices of a variable, as the case writes it; `unit` without one."""
    given = [table.get("max"), table.get("min"), *(table.get("choices") or ())]
    numbers = (one for one in given if isinstance(one, str) and one[:1] in "+-.0123456789")
    return next(filter(None, (split_number(one)[1] for one in numbers)), unit)


def bound_units(case: Mapping[str, Any]) -> dict[str, str]:
    """Paths of variables and of values found, with the unit of their bounds if these have one."""
    given = [
        (VARIABLE, "key", "", table_of(case, "optimisation").get("variables")),
        (FITTED, "key", "", table_of(case, "fit").get("variables")),
        ("find/", "name", "/value", case.get("find")),
    ]
    found = {f"{root}{one[name]}{end}": bound_unit(one, "")
             for root, name, end, rows in given for one in rows or ()}  # fmt: skip
    return {path: unit for path, unit in found.items() if unit}


def in_unit(quantity: Quantity, unit: str) -> tuple[float, Estimate]:
    """A scalar and its error in another unit."""
    factor = convert(1.0, quantity.unit, unit)
    return float(quantity.values) * factor, quantity.estimate * factor


def variables_of(result: Result, read: Mapping[str, str] | None = None) -> list[Variable]:
    """Variables of numbers that have an optimum; in `read` units for others."""
    found = []
    for given in table_of(result.case, "optimisation").get("variables") or ():
        key = str(given["key"])
        quantity = result.record.quantities.get(VARIABLE + key)
        if quantity is None or given.get("choices") or given.get("integer"):
            continue
        written = bound_unit(given, quantity.unit)
        unit = (read or {}).get(written, written)
        lower, upper = (convert(parse_quantity(given[end], quantity.unit), quantity.unit, unit)
                        for end in ("min", "max"))  # fmt: skip
        start = scalar_of(result.record, AT_START + VARIABLE + key)
        start = written_at(result.case, key) if start is None else start
        known = isinstance(start, int | float)
        begun = convert(float(start), quantity.unit, unit) if known else None
        factor = convert(1.0, quantity.unit, unit)
        found.append(Variable(key, unit, factor, lower, upper, begun, *in_unit(quantity, unit)))
    return found


# ----------------------------------------------------------------------------
# Names of what is picked: of a stock its items, of a key the values of its list.
# ----------------------------------------------------------------------------


def label_of(case: Mapping[str, Any], path: str, value: float) -> str:
    """The name of what is picked at a path `optimisation/choice/...`."""
    study, name, place = table_of(case, "optimisation"), path.removeprefix(PICKED), int(value) - 1
    for stock in study.get("stock") or ():
        if stock["name"] == name:
            return str(stock["items"][place]["name"])
    lists = {one["key"]: one.get("choices") or () for one in study.get("variables") or ()}
    return str(lists[name][place])


def picked_of(result: Result) -> list[list[str]]:
    """Name, how it was written, what was picked, and the length of each list of the case."""
    case, record, found = result.case, result.record, list[list[str]]()
    study = table_of(case, "optimisation")
    lists: list[tuple[str, Any, Any]]
    lists = [(str(one["name"]), one["items"], _written(case, one))
             for one in study.get("stock") or ()]  # fmt: skip
    lists += [(str(one["key"]), one.get("choices") or (), written_at(case, str(one["key"])))
              for one in study.get("variables") or ()]  # fmt: skip
    whole = {one["key"]: one for one in study.get("variables") or () if one.get("integer")}
    for name, given, before in lists:
        place = scalar_of(record, PICKED + name)
        quantity = record.quantities.get(VARIABLE + name)
        if place is not None:
            label = label_of(case, PICKED + name, place)
            found.append([name, str(before), label, str(len(given))])
        elif quantity is not None and (given or name in whole):
            unit = bound_unit({"choices": given}, quantity.unit)
            if isinstance(before, int | float):
                before = show_in(convert(float(before), quantity.unit, unit), unit)
            low, high = (parse_quantity(whole.get(name, {}).get(one) or 0.0, "")
                         for one in ("min", "max"))  # fmt: skip
            size = len(given) or int(np.floor(high) - np.ceil(low)) + 1
            text = show_in(in_unit(quantity, unit)[0], unit)
            found.append([name, "-" if before is None else str(before), text, str(size)])
    return found


def _written(case: Mapping[str, Any], stock: Mapping[str, Any]) -> str:
    """The item that the case as written has, or that it has none of them."""
    for item in stock["items"]:
        pairs = ((written_at(case, f"{stock['table']}.{key}"), written)
                 for key, written in item["values"].items())  # fmt: skip
        if all(_same(value, written) for value, written in pairs):
            return str(item["name"])
    return "none of them"


def _same(value: Any, written: Any) -> bool:
    if isinstance(value, str) or value is None:
        return bool(value == written)
    return math.isclose(value, si_value(written) if isinstance(written, str) else written,
                        rel_tol=1e-12)  # fmt: skip


# ----------------------------------------------------------------------------
# Objectives, in the unit that people read.
# ----------------------------------------------------------------------------


class Goal(NamedTuple):
    """An objective: its quantity, the entries that count, of which the worst does, name and unit.

    A value in SI times `factor` is in `unit`.
    """

    path: str
    where: Mapping[str, Any]
    side: Side
    name: str
    unit: str
    factor: float

    @property
    def smaller(self) -> bool:
        """Whether it is to be small: then its largest entry is the worst."""
        return self.side == "max"

    def at(self, record: Record, root: str = "") -> float | None:
        """Its value in SI, at the start with `AT_START`; None if there is none that is finite."""
        return worst_of(record, root + self.path, self.where, self.side)

    def best(self, values: np.ndarray) -> float:
        """The best of values."""
        return float(np.min(values) if self.smaller else np.max(values))

    def shown(self, value: float, error: float = 0.0) -> str:
        """A value in SI as it is read."""
        return show_in(value * self.factor, self.unit, error * self.factor)


def worst_of(record: Record, path: str, where: Mapping[str, Any], side: Side) -> float | None:
    """The worst entry of a result; None if it has none that is finite."""
    try:
        value = worst(record.quantities[path], where, side)[0]
    except (KeyError, ResultError):
        return None
    return float(value) if np.isfinite(value) else None


def goal_of(given: Mapping[str, Any], unit: str) -> Goal:
    """An objective as the case has it, of a quantity in `unit`."""
    path, smaller = str(given.get("quantity") or ""), given.get("sense", "min") == "min"
    name, shown = read_as(path, unit)
    where = dict(given.get("where") or {})
    return Goal(path, where, "max" if smaller else "min", name, shown, convert(1.0, unit, shown))


def objective_of(result: Result, unit: str = "") -> Goal:
    """The objective of an optimisation, of a quantity in `unit` where the result lacks it."""
    given = table_of(result.case, "optimisation", "objective")
    path = str(given.get("quantity") or "")
    there = path in result.record
    return goal_of(given, result.record[path].unit if there else unit or read_as(path, "")[1])


def goals_of(result: Result) -> list[tuple[Goal, Quantity]]:
    """The objectives of a front and their values along it; none without a front."""
    study: Mapping[str, Any] = table_of(result.case, "optimisation")
    given = [table_of(study, name) for name in FRONT_NAMES[:2]]
    given += list(study.get("further_objectives") or ())
    found = [having(result.record, FRONT + name, "front_point") for name in FRONT_NAMES]
    pairs = zip(given, found, strict=False)
    goals = [(goal_of(goal, one.unit), one) for goal, one in pairs if one is not None]
    return goals if len(goals) > 1 else []
