"""The optimum: variables in their bounds, objective, what was held, start beside optimum."""

from collections.abc import Mapping
from typing import Any, Literal

from vibecalc.errors import ResultError
from vibecalc.report.generic import grouped
from vibecalc.report.lookup import START, table_of
from vibecalc.report.numbers import show, show_percent
from vibecalc.report.sections.advice import advice
from vibecalc.report.sections.key_start import VARIABLE, bound_unit, in_unit, start_of
from vibecalc.report.sections.methods import methods
from vibecalc.report.sections.pareto import front
from vibecalc.report.sections.search import holding, optima, searches, side_of
from vibecalc.report.sections.section import Section
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Record, Result
from vibecalc.results.select import worst
from vibecalc.units import convert, parse_quantity

PREFIX = "optimisation/"
#: What the tables above the generic ones tell, or what belongs into the file alone.
_TOLD = tuple(
    PREFIX + name
    for name in (
        "variable/",
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
    own = [path for path in record if path.startswith(PREFIX) and not path.startswith(START)]
    if not own:
        return None
    lines = [*_variables(result), *_objective(result), *advice(result), *holding(record)]
    lines += [*_beside(record), *front(result), *methods(result)]
    lines += [*optima(record), *searches(record)]
    rest = [record[path] for path in own if not path.startswith(_TOLD)]
    tables = grouped(rest, PREFIX)
    lines += ["", *tables] if tables and lines else tables
    return Section("Optimisation", lines, frozenset(own)) if lines else None


def _variables(result: Result) -> list[str]:
    given: Any = table_of(result.case, "optimisation").get("variables") or ()
    rows, ties = [], list[str]()
    for variable in given:
        key = str(variable["key"])
        quantity = result.record.quantities.get(VARIABLE + key)
        if quantity is None:
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
        ties += _ties(variable)
    columns = (
        Column("variable", 33),
        number("start", 11),
        number(_end(result.record), 11),
        Column("unit", 7),
        number("lower", 11),
        number("upper", 11),
        Column("", 8),
    )
    return [*table(columns, rows), *(["", *ties] if ties else [])] if rows else []


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


def _bound(value: float | str, own: str, unit: str) -> str:
    """A bound as a number in the unit that is shown."""
    return show(convert(parse_quantity(value, own), own, unit))


def _objective(result: Result) -> list[str]:
    objective: Mapping[str, Any] = table_of(result.case, "optimisation", "objective")
    path = str(objective.get("quantity") or "")
    if path not in result.record:
        return []
    sense = "smallest" if objective.get("sense", "min") == "min" else "largest"
    where = dict(objective.get("where") or {})
    # The worst entry is the largest of what is made small, and the other way round.
    side: Literal["max", "min"] = "max" if sense == "smallest" else "min"
    found = _end(result.record) == "optimum"
    words = f"objective: {sense} {path}" if found else f"objective: {path}"
    try:
        quantity = result.record[path]
        value, label = worst(quantity, where, side)
        words += f" = {show(value, quantity.error_estimate)} {quantity.unit}".rstrip()
        words += f" at {label}" if label else ""
        if START + path in result.record:
            before, _ = worst(result.record[START + path], where, side)
            words += f"; at the start {show(before)} {quantity.unit}".rstrip()
    except ResultError as error:
        words += f": {error}"
    return ["", *paragraph(words)]


def _beside(record: Record) -> list[str]:
    rows = []
    for path, quantity in record.items():
        before = record.quantities.get(START + path)
        peak = len(quantity.axes) == 1 and path.endswith(_WORST)
        if before is None or path.startswith(PREFIX) or not (peak or not quantity.axes):
            continue
        start, end = (worst(each, {}, "max")[0] for each in (before, quantity))
        if start == end:
            continue
        change = (end - start) / abs(start) if start else None
        rows.append(
            [
                path + (" (worst)" if peak else ""),
                show(start, before.error_estimate),
                show(end, quantity.error_estimate),
                quantity.unit,
                show_percent(change),
            ]
        )
    columns = (
        Column(f"start beside {_end(record)}", 40),
        number("start"),
        number(_end(record)),
        Column("unit", 10),
        number("change"),
    )
    return ["", *table(columns, rows)] if rows else []
