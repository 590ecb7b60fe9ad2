"""Sections of optimisations and searches."""

import math
from collections.abc import Callable, Mapping
from typing import Any, Literal

import numpy as np

from vibecalc.core.report.choices import combinations, picked, unit_of_choices
from vibecalc.core.report.fronts import front
from vibecalc.core.report.robust import robust
from vibecalc.core.report.sections import (
    Part,
    Section,
    along,
    grouped,
    labels,
    read_as,
    scalar_of,
    section,
    table_of,
    together,
)
from vibecalc.core.report.writing import Column, number, paragraph, show, show_percent, table
from vibecalc.core.results.record import AT_START, Quantity, Record, Result
from vibecalc.core.results.select import worst
from vibecalc.core.results.verdicts import entries, name_of
from vibecalc.errors import ResultError
from vibecalc.units import convert, parse_quantity, split_number

# ----------------------------------------------------------------------------
# Where a variable of an optimisation started, and in which unit a case thinks of it.
# ----------------------------------------------------------------------------

VARIABLE = "optimisation/variable/"


def bound_unit(table: Mapping[str, Any], unit: str) -> str:
    """Unit of the bounds of a variable or a search, as the case writes it; `unit` without one."""
    for side in ("upper", "lower"):
        bound = table.get(side)
        written = split_number(bound)[1] if isinstance(bound, str) else ""
        if written:
            return written
    return unit_of_choices(table) or unit


def bound_units(case: Mapping[str, Any]) -> dict[str, str]:
    """Paths of variables and of values found, with the unit of their bounds if these have one."""
    study: Any = table_of(case, "optimisation").get("variables") or ()
    found = {VARIABLE + str(one["key"]): bound_unit(one, "") for one in study}
    fitted: Any = table_of(case, "fit").get("variables") or ()
    found |= {f"fit/value/{one['key']}": bound_unit(one, "") for one in fitted}
    searches: Any = case.get("find") or ()
    found |= {f"find/{one['name']}/value": bound_unit(one, "") for one in searches}
    return {path: unit for path, unit in found.items() if unit}


def in_unit(quantity: Quantity, unit: str) -> tuple[float, float]:
    """A scalar and its error in another unit."""
    value = float(quantity.values)
    return convert(value, quantity.unit, unit), convert(
        quantity.error_estimate, quantity.unit, unit
    )


def start_of(result: Result, key: str) -> float | None:
    """The start value of a variable: from the record, else as the case has it; None if neither."""
    stored = scalar_of(result.record, AT_START + VARIABLE + key)
    if stored is not None:
        return stored
    part: Any = result.case
    for name in key.replace("[", ".").replace("]", "").split("."):
        try:
            part = part[int(name)] if name.isdigit() else part[name]
        except (KeyError, IndexError, TypeError):
            return None
    return float(part) if isinstance(part, int | float) else None


# ----------------------------------------------------------------------------
# What to change, from what to what, what that brings, and what a small error in it costs.
# ----------------------------------------------------------------------------

_PREFIX = "optimisation/"
#: relative error up to which two values that it does not tell apart are the same to any user
_ALIKE = 1e-3


def advice(result: Result) -> list[str]:
    """One paragraph for each variable and one for all; nothing without computed slopes.

    Every number is a result or a value of the case.
    """
    record = result.record
    study: Mapping[str, Any] = table_of(result.case, "optimisation")
    keys = [str(variable["key"]) for variable in study.get("variables") or ()]
    said = [(key, _words(result, key)) for key in keys]
    lines = []
    for key, words in said:
        if words:
            lines += paragraph(f"{key}: {words}", "-")
    if not lines:
        return []
    return [*paragraph("advice:"), *lines, *_gain(record, study)]


def _words(result: Result, key: str) -> str:
    record = result.record
    if not any(f"{_PREFIX}{part}/{key}" in record for part in ("sensitivity", "deviation/loss")):
        return ""
    optimum = record.quantities.get(f"{_PREFIX}variable/{key}")
    if optimum is None:
        return ""
    start, end = start_of(result, key), float(optimum.values)
    unit = bound_units(result.case).get(VARIABLE + key, optimum.unit)
    factor = convert(1.0, optimum.unit, unit)
    value = f"{show(end * factor, optimum.error_estimate * factor)} {unit}".rstrip()
    if start is None:
        parts = [f"{value} is best"]
    elif abs(end - start) <= optimum.error_estimate:
        off = f"{show(float(optimum.error_estimate) * factor, digits=2)} {unit}".rstrip()
        rough = optimum.error_estimate > _ALIKE * abs(end)
        parts = [f"leave it at {value}" + f", known to {off} only" * rough]
    else:
        verb = "raise" if end > start else "lower"
        parts = [f"{verb} it from {show(start * factor)} to {value}"]
    slope = record.quantities.get(f"{_PREFIX}sensitivity/{key}")
    goal = record.quantities.get(_PREFIX + "objective")
    if slope is not None:
        for place, one in zip(labels(slope.axes[0]), slope.values, strict=True):
            shown = show(one / factor, slope.error_estimate / factor)
            size = goal.unit if goal is not None else ""
            each = f" per {unit}" if unit else ""
            parts.append(f"slope at the {place} {shown} {size}".rstrip() + each)
    return "; ".join([*parts, *_deviation(record, key, unit)])


def _deviation(record: Record, key: str, unit: str) -> list[str]:
    size = record.quantities.get(f"{_PREFIX}deviation/size/{key}")
    loss = record.quantities.get(f"{_PREFIX}deviation/loss/{key}")
    if size is None or loss is None:
        return []
    moved, lost = float(size.values), float(loss.values)
    direction = "more" if moved > 0 else "less"
    amount = f"{show(abs(convert(moved, size.unit, unit)))} {unit}".rstrip()
    objective = scalar_of(record, _PREFIX + "objective")
    if abs(lost) <= loss.error_estimate:
        effect = "changes the objective by nothing that can be seen"
        if loss.error_estimate > _ALIKE * abs(objective or 0.0):
            off = show(float(loss.error_estimate), digits=2)
            effect = f"changes the objective by less than its error, {off} {loss.unit}".rstrip()
    else:
        share = f" ({show_percent(abs(lost / objective)).lstrip('+')})" if objective else ""
        verb = "costs" if lost > 0 else "gains"
        effect = f"{verb} {show(abs(lost), digits=4)} {loss.unit}".rstrip() + share
    words = [f"at the optimum {amount} {direction} {effect}"]
    margin = record.quantities.get(f"{_PREFIX}deviation/margin/{key}")
    if margin is not None and float(margin.values) < -margin.error_estimate:
        broken = show_percent(-float(margin.values)).removeprefix("+")
        words.append(f"a deviation of that size may break a limit by {broken} of its bound")
    return words


def _gain(record: Record, study: Mapping[str, Any]) -> list[str]:
    gain = record.quantities.get(_PREFIX + "gain")
    if gain is None:
        return []
    value = float(gain.values)
    sense = "lower" if table_of(study, "objective").get("sense", "min") == "min" else "higher"
    amount = f"{show(abs(value), gain.error_estimate)} {gain.unit}".rstrip()
    if value < -gain.error_estimate:
        sense = "higher" if sense == "lower" else "lower"
        return paragraph(f"together: the objective becomes {sense} by {amount}, to keep the limits")
    return paragraph(f"together: the objective becomes {sense} by {amount}")


# ----------------------------------------------------------------------------
# Found values: what was changed, to what, and the result that this brings.
# ----------------------------------------------------------------------------

FIND_PREFIX = "find/"
_DIGITS = 5
_COLUMNS = (
    Column("name", 13),
    Column("key", 23),
    number("written", 10),
    number("found", 10),
    Column("unit", 6),
    number("ratio", 8),
    number("reached", 10),
    number("wanted", 11),
)
_MOST = 8
_MACHINE, _COUNTS = "machine/", "/evaluations"


def find(result: Result) -> Section | None:
    """The section, None if the case searches for nothing."""
    paths = [path for path in result.record if path.startswith(FIND_PREFIX)]
    rows, below, missing = [], list[str](), list[str]()
    words, machines = list[str](), list[list[str]]()
    for search in entries(result, "find"):
        parts = _results_of(result, search)
        if "value" in parts:
            rows.append(_row(search, parts))
            below += paragraph(_find_words(result, search, parts), "-")
            machines.append(_machine(result, search, parts))
        else:
            missing.append(str(search["name"]))
    if not rows:
        return None
    if missing:
        words += paragraph(f"nothing found for {', '.join(missing)}: see the warnings", "-")
    words += paragraph("all other sections show the case as written", "-")
    details = {"what each search reached": together(below, *machines)}
    return section("Found values", [[*table(_COLUMNS, rows), *words]], details, paths)


def _machine(result: Result, search: Mapping[str, Any], parts: Mapping[str, Quantity]) -> list[str]:
    """What else is not as written in the machine found, by its numbers."""
    rows = []
    for name, quantity in parts.items():
        path = name.removeprefix(_MACHINE)
        before = result.record.quantities.get(path)
        if path == name or before is None or before.axes or path.endswith(_COUNTS):
            continue
        written, error = before.values[()], quantity.error_estimate
        if abs(quantity.values[()] - written) > error + before.error_estimate:
            rows.append(
                [
                    path,
                    show(written, before.error_estimate, _DIGITS),
                    show(quantity.values[()], error, _DIGITS),
                    quantity.unit,
                ]
            )
    if not rows:
        return []
    head = Column(f"with {search['name']}", 50)
    return [*table((head, number("written"), number("found"), Column("unit", 10)), rows)]


def _results_of(result: Result, search: Mapping[str, Any]) -> dict[str, Quantity]:
    """What was found, by the last part of its path."""
    root = f"{FIND_PREFIX}{search['name']}/"
    return {
        path.removeprefix(root): quantity
        for path, quantity in result.record.items()
        if path.startswith(root)
    }


def _row(search: Mapping[str, Any], parts: Mapping[str, Quantity]) -> list[str]:
    unit = bound_unit(search, parts["value"].unit)
    return [
        str(search["name"]),
        str(search["key"]),
        show(*in_unit(parts["written"], unit), _DIGITS) if "written" in parts else "-",
        show(*in_unit(parts["value"], unit), _DIGITS),
        unit,
        _number(parts, "ratio"),
        _number(parts, "reached"),
        str(search["seek"]) if search.get("seek") else _number(parts, "wanted"),
    ]


def _find_words(result: Result, search: Mapping[str, Any], parts: Mapping[str, Quantity]) -> str:
    where = dict(search.get("where") or {})
    path, key = str(search["quantity"]), str(search["key"])
    words = name_of(path, where)
    words += f": {_number(parts, 'reached')} {parts['reached'].unit}".rstrip()
    unit = bound_unit(search, parts["value"].unit)
    words += f" with {key} = {show(*in_unit(parts['value'], unit), _DIGITS)} {unit}".rstrip()
    words += _written(result, path, where)
    if search.get("change") is not None:
        words += f"; wanted: a change of {search['change']}"
    if search.get("also"):
        also = (
            f"{one} = {_number(parts, f'also/{one}')} {parts[f'also/{one}'].unit}"
            for one in search["also"]
        )
        words += f"; in the same ratio: {', '.join(also)}"
    others = parts.get("others")
    if others is not None and others.values.size:
        values = (convert(float(other), others.unit, unit) for other in others.values[:_MOST])
        shown = ", ".join(show(other, digits=_DIGITS) for other in values)
        more = f" and {others.values.size - _MOST} more" if others.values.size > _MOST else ""
        what = "further extremes" if search.get("seek") else "further solutions"
        words += f"; {what} at {shown}{more} {unit}".rstrip()
    return words


def _written(result: Result, path: str, where: Mapping[str, Any]) -> str:
    quantity = result.record.quantities.get(path)
    if quantity is None:
        return ""
    try:
        value, _ = worst(quantity, where, "max")
    except ResultError:
        return ""
    shown = show(value, quantity.error_estimate, _DIGITS)
    return f"; as written {shown} {quantity.unit}".rstrip()


def _number(parts: Mapping[str, Quantity], name: str) -> str:
    quantity = parts.get(name)
    if quantity is None:
        return "-"
    return show(quantity.values[()], quantity.error_estimate, _DIGITS)


# ----------------------------------------------------------------------------
# The optimum: variables in their bounds, objective, what was held, start next to optimum.
# ----------------------------------------------------------------------------

PREFIX = "optimisation/"
#: What the tables above the generic ones tell, or what belongs into the file alone.
_REPORTED = tuple(
    PREFIX + name
    for name in (
        "variable/",
        "choice/",
        "combinations/",
        "robust/",
        "active_bound/",
        "history/",
        "optima/",
        "margin",
        "multiplier",
        "objective",
        "sensitivity/",
        "deviation/",
        "gain",
        "methods/",
        "front/",
    )
)
#: Of vectors with these endings the largest entry stands for the whole.
_WORST = ("_peak", "/sag", "/excursion")


def optimisation(result: Result) -> Section | None:
    """The section, None if the case does not optimise."""
    record = result.record
    paths = [path for path in record if path.startswith(PREFIX) and not path.startswith(AT_START)]
    if not paths:
        return None
    others = [record[path] for path in paths if not path.startswith(_REPORTED)]
    blocks = [picked(result), _variables(result), _objective(result), combinations(result)]
    blocks += [robust(result), advice(result), holding(record)]
    blocks += [_nearby(record), front(result, bound_units(result.case))]
    how = together(optima(record), searches(record), grouped(others, PREFIX))
    details: dict[str, Part] = {"methods side by side": search_methods(result)}
    details["optima and searches"] = how
    return section("Optimisation", blocks, details, paths)


def _variables(result: Result) -> list[str]:
    given: Any = table_of(result.case, "optimisation").get("variables") or ()
    rows, ties = [], list[str]()
    for variable in given:
        key = str(variable["key"])
        quantity = result.record.quantities.get(VARIABLE + key)
        ties += _ties(variable) if quantity is not None else []
        if quantity is None or _is_picked(variable):
            continue
        start = start_of(result, key)
        unit = bound_unit(variable, quantity.unit)
        rows.append(
            [
                key,
                "-" if start is None else show(convert(start, quantity.unit, unit)),
                show(*in_unit(quantity, unit)),
                unit,
                _bound(variable["lower"], quantity.unit, unit),
                _bound(variable["upper"], quantity.unit, unit),
                side_of(result.record, key),
            ]
        )
    columns = (
        Column("variable", 33),
        number("start", 11),
        number(_end(result.record), 11),
        Column("unit", 7),
        number("lower", 11),
        number("upper", 11),
        Column("", 8),
    )
    return [*(table(columns, rows) if rows else []), *(["", *ties] if ties else [])]


def _is_picked(variable: Mapping[str, Any]) -> bool:
    return bool(variable.get("choices") or variable.get("integer"))


def _end(record: Record) -> str:
    """What the search ended in: an optimum, or the nearest to one where limits cannot be kept."""
    return "optimum" if PREFIX + "objective" in record else "nearest"


def _ties(variable: Mapping[str, Any]) -> list[str]:
    """A sentence for each key that follows a variable."""
    lines = []
    for tie in variable.get("with") or ():
        factor, offset = float(tie.get("factor", 1.0)), tie.get("offset")
        words = f"{tie['key']} follows {'' if factor == 1.0 else f'{factor:g} times '}"
        words += str(variable["key"]) + ("" if offset is None else f" + {offset}")
        lines += paragraph(words, "-")
    return lines


def _bound(value: float | str, key_unit: str, unit: str) -> str:
    """A bound as a number in the unit that is shown."""
    return show(convert(parse_quantity(value, key_unit), key_unit, unit))


def _objective(result: Result) -> list[str]:
    objective: Mapping[str, Any] = table_of(result.case, "optimisation", "objective")
    path = str(objective.get("quantity") or "")
    if path not in result.record:
        return []
    sense = "smallest" if objective.get("sense", "min") == "min" else "largest"
    where = dict(objective.get("where") or {})
    # The worst entry is the largest of what is made small, and the other way round.
    side: Literal["max", "min"] = "max" if sense == "smallest" else "min"
    at_optimum = _end(result.record) == "optimum"
    quantity = result.record[path]
    name, unit = read_as(path, quantity.unit)
    factor = convert(1.0, quantity.unit, unit)
    over = table_of(result.case, "optimisation", "robust")
    goal = "objective, without tolerances" if over else "objective"
    words = f"{goal}: {sense} {name}" if at_optimum and not over else f"{goal}: {name}"
    try:
        value, label = worst(quantity, where, side)
        words += f": {show(value * factor, quantity.error_estimate * factor)} {unit}".rstrip()
        words += f" at {label.replace('=', ' ')}" if label else ""
        if AT_START + path in result.record:
            before, _ = worst(result.record[AT_START + path], where, side)
            words += f"; at the start {show(before * factor)} {unit}".rstrip()
    except ResultError as error:
        words += f": {error}"
    return paragraph(words)


def _nearby(record: Record) -> list[str]:
    rows = []
    for path, quantity in record.items():
        before = record.quantities.get(AT_START + path)
        peak = len(quantity.axes) == 1 and path.endswith(_WORST)
        if before is None or path.startswith(PREFIX) or not (peak or not quantity.axes):
            continue
        start, end = (worst(each, {}, "max")[0] for each in (before, quantity))
        if start == end:
            continue
        change = (end - start) / abs(start) if start else None
        name, unit = read_as(path, quantity.unit)
        factor = convert(1.0, quantity.unit, unit)
        rows.append(
            [
                name,
                show(start * factor, before.error_estimate * factor),
                show(end * factor, quantity.error_estimate * factor),
                unit,
                show_percent(change),
            ]
        )
    columns = (
        Column(f"at start and {_end(record)}", 48),
        number("start"),
        number(_end(record)),
        Column("unit", 10),
        number("change"),
    )
    return table(columns, rows) if rows else []


# ----------------------------------------------------------------------------
# How an optimum was found: what holds it, distinct optima, one line for each search.
# ----------------------------------------------------------------------------

_ROWS = 12
_SIDES = {-1: "at lower", 0: "", 1: "at upper"}


def holding(record: Record) -> list[str]:
    """Limits with their margin at the optimum; active ones have a multiplier."""
    margin = along(record, _PREFIX + "margin", "limit")
    multiplier = along(record, _PREFIX + "multiplier", "limit")
    if margin is None or multiplier is None:
        return []
    rows = []
    for i, name in enumerate(labels(margin[0].axes[0])):
        price = float(multiplier[0].values[i])
        rows.append(
            [
                name,
                show(float(margin[0].values[i]), margin[0].error_estimate),
                show(price, multiplier[0].error_estimate),
                multiplier[0].unit,
                "active" if price else "",
            ]
        )
    columns = (
        Column("limit", 46),
        number("margin / limit", 14),
        number("multiplier", 13),
        Column("unit", 8),
        Column("", 8),
    )
    return table(columns, rows)


def side_of(record: Record, key: str) -> str:
    """`at lower` or `at upper` for a variable on a bound, else nothing."""
    quantity = record.quantities.get(f"{_PREFIX}active_bound/{key}")
    return _SIDES.get(int(quantity.values), "") if quantity is not None else ""


def optima(record: Record) -> list[str]:
    """Distinct optima, best first, with the number of searches that ended there."""
    found_by = (number("searches", 10), "optima/found_by", str)
    return _numbered(record, "optimum", "optima", "optima/objective", found_by)


def searches(record: Record) -> list[str]:
    """One line for each search: where its objective ended, whether the limits were kept."""
    kept = (number("limits kept", 12), "history/feasible", ("no", "yes").__getitem__)
    evaluations = (number("evaluations", 12), "history/evaluations", str)
    return _numbered(record, "search", "searches", "history/objective", kept, evaluations)


def _numbered(
    record: Record,
    axis: str,
    noun: str,
    path: str,
    *more: tuple[Column, str, Callable[[int], str]],
) -> list[str]:
    """A line for each entry along an axis: its number, its objective, and counts in words."""
    objective = along(record, _PREFIX + path, axis)
    if objective is None:
        return []
    quantity, names = objective
    counts = [(np.asarray(record[_PREFIX + name].values), words) for _, name, words in more]
    rows = []
    for i, name in enumerate(names[:_ROWS]):
        value = float(quantity.values[i])
        shown = "failed" if math.isinf(value) else show(value, quantity.error_estimate)
        rows.append([str(int(name)), shown, *(words(int(many[i])) for many, words in counts)])
    columns = (Column(axis, 8), number(f"objective {quantity.unit}".rstrip(), 20))
    further = len(names) - _ROWS
    below = paragraph(f"{further} further {noun} are in the result file") if further > 0 else []
    return [*table((*columns, *(column for column, _, _ in more)), rows), *below]


# ----------------------------------------------------------------------------
# Search methods side by side: where each ended on its own, and what it cost.
# ----------------------------------------------------------------------------

_METHODS_PREFIX = "optimisation/methods/"
_ROOM = 13


def search_methods(result: Result) -> list[str]:
    """One line for each compared method; seconds from the timings, `-` where there are none."""
    record = result.record
    objective = along(record, _METHODS_PREFIX + "objective", "method")
    if objective is None:
        return []
    names = labels(objective[0].axes[0])
    rows = []
    for i, name in enumerate(names):
        seconds = result.timings.get(f"method {name}")
        residual = _value(record, "kkt_residual", i)
        rows.append(
            [
                name,
                show(objective[0].values[i], objective[0].error_estimate),
                _cell(record, "shortfall", i),
                _cell(record, "distance", i),
                "kink" if math.isinf(residual) else f"{residual:.1e}",
                show(int(_value(record, "evaluations", i))),
                "-" if seconds is None else f"{seconds:.2f}",
                "yes" if _value(record, "converged", i) else "NO",
            ]
        )
    unit = objective[0].unit
    columns = (
        Column("methods side by side", 22),
        number(f"objective {unit}".rstrip(), _ROOM),
        number(f"too high by {unit}".rstrip(), 11),
        number("distance", 9),
        number("residual", 9),
        number("points", 7),
        number("s", 7),
        Column("converged", 9),
    )
    return table(columns, rows)


def _value(record: Record, name: str, i: int) -> float:
    return float(np.asarray(record[_METHODS_PREFIX + name].values)[i])


def _cell(record: Record, name: str, i: int) -> str:
    quantity = record[_METHODS_PREFIX + name]
    return show(quantity.values[i], quantity.error_estimate, digits=3)
