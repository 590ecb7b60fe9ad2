"""Sections of optimisations and searches."""

import math
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from vibecalc.core.report.goals import (
    FRONT,
    PICKED,
    PREFIX,
    SIDES,
    VARIABLE,
    Variable,
    bound_unit,
    bound_units,
    coordinate_words,
    goals_of,
    in_unit,
    label_of,
    objective_of,
    picked_of,
    variables_of,
)
from vibecalc.core.report.rows import Cells, How, Rows, first, others, part_of, rows_of, whole
from vibecalc.core.report.sections import (
    Part,
    Section,
    grouped,
    labels,
    read_as,
    scalar_of,
    section,
    stacked,
    table_of,
    together,
    written,
)
from vibecalc.core.report.writing import many, number, paragraph, show, show_in, show_percent, table
from vibecalc.core.results.record import AT_START, FRONT_NAMES, Estimate, Quantity, Record, Result
from vibecalc.core.results.select import worst
from vibecalc.core.results.verdicts import entries, name_of
from vibecalc.errors import ResultError
from vibecalc.units import convert

# ----------------------------------------------------------------------------
# The optimum: variables in their bounds, objective, what was held, start next to optimum.
# ----------------------------------------------------------------------------

#: What the tables above the generic ones tell, or what belongs into the file alone.
_REPORTED = tuple(PREFIX + name for name in (
    "variable/", "choice/", "combinations/", "robust/", "active_bound/", "history/", "optima/",
    "margin", "multiplier", "objective", "sensitivity/", "deviation/", "gain", "front/",
))  # fmt: skip
#: Of vectors with these endings the largest entry stands for the whole.
_WORST = ("_peak", "displacement/static", "displacement/total")
#: rows of searches, optima and combinations
_ROWS = 12


def optimisation(result: Result) -> Section | None:
    """The section, None if the case does not optimise."""
    record = result.record
    paths = [path for path in record if path.startswith(PREFIX) and not path.startswith(AT_START)]
    if not paths:
        return None
    left = grouped([record[path] for path in paths if not path.startswith(_REPORTED)], PREFIX)
    picked = table(("choice", "as written", "optimum", number("options")), picked_of(result))
    blocks: list[Part] = [picked, _variables(result), _objective(result), _combinations(result)]
    blocks += [_robust(result), advice(result), rows_of(record, HOLDING), _nearby(record)]
    searched = together(rows_of(record, OPTIMA), rows_of(record, SEARCHES), left)
    details = {"optima and searches": searched}
    return section("Optimisation", [*blocks, _front(result)], details, paths)


def _ended(record: Record) -> str:
    """What the search ended in: an optimum, or the nearest to one where limits cannot be kept."""
    return "optimum" if PREFIX + "objective" in record else "nearest"


def _variables(result: Result) -> list[str]:
    rows = []
    for one in variables_of(result):
        start = "-" if one.start is None else show(one.start)
        side = scalar_of(result.record, f"{PREFIX}active_bound/{one.key}")
        cells = [coordinate_words(one.key), start, show(one.value, one.error), one.unit]
        rows.append([*cells, show(one.lower), show(one.upper), SIDES[int(side or 0)]])
    ties = []
    for variable in table_of(result.case, "optimisation").get("variables") or ():
        there = f"{PREFIX}variable/{variable['key']}" in result.record
        for tie in variable.get("followed_by") or () if there else ():
            factor, offset = float(tie.get("factor", 1.0)), tie.get("offset")
            tied = coordinate_words(str(tie["key"]))
            words = f"{tied} follows {'' if factor == 1.0 else f'{factor:g} times '}"
            words += coordinate_words(str(variable["key"])) + (
                "" if offset is None else f" + {offset}"
            )
            ties += paragraph(words, "-")
    heads = ("variable", number("start"), number(_ended(result.record)), "unit", number("lower"),
             number("upper"), "")  # fmt: skip
    return stacked(table(heads, rows), ties)


def _objective(result: Result) -> list[str]:
    goal = objective_of(result)
    quantity = result.record.quantities.get(goal.path)
    if quantity is None:
        return []
    over = table_of(result.case, "optimisation", "robust")
    words = "objective, without tolerances: " if over else "objective: "
    if _ended(result.record) == "optimum" and not over:
        words += "smallest " if goal.smaller else "largest "
    try:
        value, label = worst(quantity, goal.where, goal.side)
    except ResultError as missing:
        return paragraph(f"{words}{goal.name}: {missing}")
    words += f"{goal.name}: {goal.shown(value, quantity.error_estimate)}"
    words += f" at {label.replace('=', ' ')}" if label else ""
    before = goal.at(result.record, AT_START)
    return paragraph(words + (f"; at the start {goal.shown(before)}" if before is not None else ""))


def largest_of(quantity: Quantity) -> float:
    """The largest entry, of complex ones by magnitude."""
    return worst(quantity, {}, "max")[0]


def _nearby(record: Record) -> list[str]:
    """Scalars, and the largest entries of some vectors, at the start and at the optimum."""
    pairs = []
    for path, quantity in record.items():
        before = record.quantities.get(AT_START + path)
        peak = len(quantity.axes) == 1 and path.endswith(_WORST)
        if before is not None and not path.startswith(PREFIX) and (peak or not quantity.axes):
            pairs += [(before, quantity)] * (largest_of(before) != largest_of(quantity))
    ended = _ended(record)
    return side_by_side((f"at start and {ended}", "start", ended), pairs)


def side_by_side(heads: Sequence[str], pairs: Iterable[tuple[Quantity, Quantity]]) -> list[str]:
    """A table of results before and after a change."""
    rows = []
    for before, after in pairs:
        start, end = largest_of(before), largest_of(after)
        name, unit = read_as(after.path, after.unit)
        change = show_percent((end - start) / abs(start) if start else None)
        rows.append([name, written(before, unit)(start), written(after, unit)(end), unit, change])
    title, *ends = heads
    return table((title, *map(number, ends), "unit", number("change")), rows)


# ----------------------------------------------------------------------------
# How an optimum was found: what holds it, distinct optima, a line for each search.
# ----------------------------------------------------------------------------


def _or_failed(value: float, error: Estimate) -> str:
    return "failed" if math.isinf(value) else show(value, error)


def _marked(yes: str, no: str) -> How:
    return lambda value, _: yes if value else no


def _listed(of: str, folder: str, *columns: Cells) -> Rows:
    """The first rows of a list of objectives with what belongs to them."""
    rest = others("{left} further ones are in the result file")
    return Rows(of, of, columns, f"{PREFIX}{folder}", places=first(_ROWS), rest=rest)


_OBJECTIVE = Cells("objective", "objective {unit}", _or_failed)
OPTIMA = _listed("optimum", "optima", _OBJECTIVE, Cells("found_by", "searches", whole))
_KEPT = Cells("feasible", "limits kept", _marked("yes", "no"))
SEARCHES = _listed(
    "search", "history", _OBJECTIVE, _KEPT, Cells("evaluations", "evaluations", whole)
)
_LEFT = Cells("margin", "margin / limit")
_HELD = Cells("multiplier", "multiplier {unit}"), Cells("multiplier", "", _marked("active", ""))
HOLDING = Rows("limit", "limit", (_LEFT, *_HELD), PREFIX.rstrip("/"))


# ----------------------------------------------------------------------------
# What is picked, tolerances, and the front between objectives.
# ----------------------------------------------------------------------------


def _combinations(result: Result) -> list[str]:
    """What was examined, in words, and the best combinations."""
    record, root = result.record, f"{PREFIX}combinations"
    objective = record.quantities.get(f"{root}/objective")
    if objective is None:
        return []
    best = _OBJECTIVE._replace(how=objective_of(result, objective.unit).unit, blank=True)
    columns = best, _KEPT._replace(how=_marked("", "no"))
    possible, examined, kept, runs = (
        int(scalar_of(record, PREFIX + name) or 0)
        for name in ("combinations/possible", "combinations/examined", "combinations/kept",
                     "evaluations")
    )  # fmt: skip
    count = f"all {possible} combinations" if examined == possible else f"{examined} of {possible}"
    words = f"{count} examined ({runs} points in total); {kept if kept < examined else 'all'} "
    words += "meet the limits"
    beyond = "; no combination that differs in a single choice is better"
    words += beyond * (examined < possible)
    lines, _ = rows_of(record, _listed("combination", "combinations", *columns))
    return paragraph(words) + lines


def sigmas_of(result: Result) -> float:
    """How many deviations count."""
    given: Any = table_of(result.case, "optimisation", "robust").get("sigmas", 2.0)
    return float(given)


def _robust(result: Result) -> list[str]:
    """Mean and deviation at start and optimum, and of what the limits leave; what was drawn."""
    record, root = result.record, f"{PREFIX}robust"
    mean = record.quantities.get(f"{root}/mean")
    if mean is None:
        return []
    goal, sigmas = objective_of(result, mean.unit), f"mean and {sigmas_of(result):g} deviations"
    off = "  its standard error"
    parts = {"nominal": "without tolerances", "mean": "mean", "mean_error": off,
             "deviation": "standard deviation", "deviation_error": off, "value": sigmas,
             "value_error": off}  # fmt: skip
    columns = [Cells(path, words, goal.unit) for path, words in parts.items()]
    of = Rows("point", goal.name, columns, root=root, across=True)
    columns = [Cells(f"margin_{one}", one) for one in ("nominal", "mean", "deviation")]
    left = Rows("limit", "margin / limit", columns, root=root)
    scattered = []
    for one in table_of(result.case, "optimisation", "robust").get("tolerances") or ():
        how = f"normal, standard deviation {one.get('deviation')}"
        if one.get("half_width") is not None:
            how = f"uniform within +-{one['half_width']}"
        scattered.append(f"{one['key']} {how}")
    count, points = (int(scalar_of(record, PREFIX + name) or 0)
                     for name in ("robust/samples", "evaluations"))  # fmt: skip
    words = f"tolerances: {'; '.join(scattered)}. {count} samples, the same deviations at each of "
    words += f"{points} points; the standard errors are those of the sampling"
    return [*paragraph(words), *stacked(rows_of(record, of)[0], rows_of(record, left)[0])]


#: variables that are shown next to two objectives, and to more of them
_MOST_VARIABLES, _FEWER = 4, 2


def _front(result: Result) -> list[str]:
    """Objectives, what is picked and the first variables along the front, numbers of the result."""
    goals, record, units = goals_of(result), result.record, bound_units(result.case)
    if not goals:
        return []
    titles = [name.removesuffix("_objective") for name in FRONT_NAMES[: len(goals)]]
    named = zip(goals, FRONT_NAMES, titles, strict=False)
    columns = [Cells(name, f"{title} {{unit}}", goal.unit) for (goal, _), name, title in named]

    def picks(choice: str) -> How:
        return lambda value, _: label_of(result.case, PICKED + choice, float(value))

    choices, keys = ([path.removeprefix(root) for path in record if path.startswith(root)]
                     for root in (f"{FRONT}choice/", f"{FRONT}variable/"))  # fmt: skip
    columns += [Cells(f"choice/{one}", one, picks(one)) for one in choices]
    most = _MOST_VARIABLES if len(goals) == 2 else _FEWER
    for key in keys[:most]:
        short = ".".join(key.rsplit(".", 2)[-2:])
        columns.append(Cells(f"variable/{key}", f"{short} {{unit}}", units.get(VARIABLE + key, "")))
    knee, along = int(scalar_of(record, FRONT + "knee") or 0), goals[0][1]
    marks = np.where(np.arange(len(along.values)) + 1 == knee, "knee", "")
    columns.append(Cells(lambda _: part_of(along, marks, *along.axes), ""))
    names = [goal.name for goal, _ in goals]
    words = f"Pareto front: best objective for each value of the second, {names[1]}"
    if len(names) > 2:
        listed = "; ".join(map(": ".join, zip(titles, names, strict=True)))
        words = f"Pareto front: no objective improves without another getting worse. {listed}"
    more = many(len(keys) - most, "further variable is", "further variables are")
    words += f"; {more} in the result file" * (len(keys) > most)
    best = " and ".join(goal.shown(goal.best(one.values), one.error_estimate)
                        for goal, one in goals)  # fmt: skip
    end = f"knee at point {knee}" if knee else "no knee"
    lines, _ = rows_of(record, Rows("front_point", "front", columns, root=FRONT.rstrip("/")))
    utopia = f"utopia point, the best of each objective alone: {best}; {end}"
    return [*paragraph(words), *lines, *paragraph(utopia)]


# ----------------------------------------------------------------------------
# What to change, from what to what, what that brings, and what a small error in it costs.
# ----------------------------------------------------------------------------

#: relative error up to which two values that it does not tell apart are the same to any user
_ALIKE = 1e-3


def advice(result: Result) -> list[str]:
    """One paragraph for each variable and one for all; nothing without computed slopes.

    Every number is a result or a value of the case.
    """
    said = [(one.key, _advised(result.record, one)) for one in variables_of(result)]
    lines = [line for key, words in said if words for line in paragraph(f"{key}: {words}", "-")]
    return [*paragraph("advice:"), *lines, *_gain(result)] if lines else []


def _advised(record: Record, one: Variable) -> str:
    slope, size, loss = (
        record.quantities.get(f"{PREFIX}{part}/{one.key}")
        for part in ("sensitivity", "deviation/size", "deviation/loss")
    )
    if slope is None and loss is None:
        return ""
    parts = [f"{show_in(one.value, one.unit, one.error)}"]
    if one.start is None:
        parts[0] += " is best"
    elif abs(one.value - one.start) <= one.error:
        rough = one.error > _ALIKE * abs(one.value)
        off = f" (accurate to {show_in(one.error, one.unit, digits=2)})"
        parts[0] = f"keep {parts[0]}" + off * rough
    else:
        verb = "raise" if one.value > one.start else "lower"
        parts[0] = f"{verb} from {show(one.start)} to {parts[0]}"
    goal = record.quantities.get(PREFIX + "objective")
    unit = "" if goal is None else goal.unit
    if slope is not None:
        for place, steep in zip(labels(slope.axes[0]), slope.values / one.factor, strict=True):
            shown = show_in(steep, unit, float(slope.error_estimate) / one.factor)
            parts.append(f"slope at the {place} {shown}" + f" per {one.unit}" * bool(one.unit))
    if size is not None and loss is not None:
        parts += _deviation(record, one, size, loss)
    return "; ".join(parts)


def _deviation(record: Record, one: Variable, size: Quantity, loss: Quantity) -> list[str]:
    moved, lost = float(size.values), float(loss.values)
    amount = show_in(abs(convert(moved, size.unit, one.unit)), one.unit)
    objective = scalar_of(record, PREFIX + "objective")
    if abs(lost) <= loss.error_estimate:
        effect = "has no visible effect on the objective"
        if loss.error_estimate > _ALIKE * abs(objective or 0.0):
            off = show_in(float(loss.error_estimate), loss.unit, digits=2)
            effect = f"changes the objective by less than its error, {off}"
    else:
        share = f" ({show_percent(abs(lost / objective)).lstrip('+')})" if objective else ""
        effect = f"{'costs' if lost > 0 else 'gains'} {show_in(abs(lost), loss.unit)}{share}"
    words = [f"at the optimum {amount} {'more' if moved > 0 else 'less'} {effect}"]
    margin = record.quantities.get(f"{PREFIX}deviation/margin/{one.key}")
    if margin is not None and float(margin.values) < -margin.error_estimate:
        broken = show_percent(-float(margin.values)).removeprefix("+")
        words.append(f"that deviation may exceed a limit by {broken}")
    return words


def _gain(result: Result) -> list[str]:
    gain = result.record.quantities.get(PREFIX + "gain")
    if gain is None:
        return []
    value, worse = float(gain.values), float(gain.values) < -gain.error_estimate
    lower = objective_of(result, gain.unit).smaller != worse
    amount = show_in(abs(value), gain.unit, gain.error_estimate)
    words = f"all changes together: objective {'lower' if lower else 'higher'} by {amount}"
    return paragraph(words + " to meet the limits" * worse)


# ----------------------------------------------------------------------------
# Found values: what was changed, to what, and the result that this brings.
# ----------------------------------------------------------------------------

FIND_PREFIX = "find/"
_DIGITS = 4
#: further solutions that are named
_MOST = 8
_MACHINE, _COUNTS = "machine/", "/evaluations"


def find(result: Result) -> Section | None:
    """The section, None if the case searches for nothing."""
    record, rows, missing = result.record, list[list[str]](), list[str]()
    below, machines = list[str](), list[list[str]]()
    for search in entries(result, "find"):
        root = f"{FIND_PREFIX}{search['name']}/"
        parts = {path.removeprefix(root): one for path, one in record.items()
                 if path.startswith(root)}  # fmt: skip
        if "value" not in parts:
            missing.append(str(search["name"]))
            continue
        unit = bound_unit(search, parts["value"].unit)
        ends = (show(*in_unit(parts[name], unit), _DIGITS) if name in parts else "-"
                for name in ("written", "value"))  # fmt: skip
        of = _result_unit(search, parts)
        reached, wanted = (_number(parts, name, of) for name in ("reached", "wanted"))
        wanted = f"{search['sense']}imum" if search.get("sense") else wanted
        numbers = _number(parts, "ratio"), reached, wanted
        rows.append([str(search["name"]), str(search["key"]), *ends, unit, *numbers])
        below += paragraph(_find_words(result, search, parts), "-")
        pairs = ((record.quantities.get(name.removeprefix(_MACHINE)), one)
                 for name, one in parts.items() if name.startswith(_MACHINE))  # fmt: skip
        found = [(one, replace(other, path=one.path)) for one, other in pairs
                 if one is not None and _differ(one, other)]  # fmt: skip
        machines.append(side_by_side((f"with {search['name']}", "written", "found"), found))
    if not rows:
        return None
    notes = paragraph(f"no solution for {', '.join(missing)}: see the warnings", "-")
    notes = notes * bool(missing) + paragraph("all other sections: the machine of the case", "-")
    details = {"results of each search": together(below, *machines)}
    heads = ("name", "key", number("in the case"), number("found"), "unit", number("ratio"),
             number("result"), number("wanted"))  # fmt: skip
    shown = [path for path in record if path.startswith(FIND_PREFIX)]
    return section("Found values", [[*table(heads, rows), *notes]], details, shown)


def _differ(one: Quantity, other: Quantity) -> bool:
    """Whether a scalar of the machine as written differs from that of the machine found."""
    counts = bool(one.axes) or one.path.endswith(_COUNTS)
    apart = abs(other.values - one.values) > one.error_estimate + other.error_estimate
    return not counts and bool(apart)


def _find_words(result: Result, search: Mapping[str, Any], parts: Mapping[str, Quantity]) -> str:
    where, path = dict(search.get("where") or {}), str(search["quantity"])
    value, unit = parts["value"], bound_unit(search, parts["value"].unit)
    found, error = in_unit(value, unit)
    of = _result_unit(search, parts)
    words = f"{name_of(path, where)}: {_number(parts, 'reached', of)}"
    words += f" with {search['key']} = {show_in(found, unit, error, _DIGITS)}"
    before = result.record.quantities.get(path)
    if before is not None:
        with suppress(ResultError):
            factor = convert(1.0, before.unit, of)
            size, off = factor * worst(before, where, "max")[0], factor * before.error_estimate
            words += f"; as written {show_in(size, of, off, _DIGITS)}"
    if search.get("change") is not None:
        words += f"; wanted: a change of {search['change']}"
    also = [f"{one} = {_number(parts, f'scaled_with/{one}')}"
            for one in search.get("scaled_with") or ()]  # fmt: skip
    words += f"; in the same ratio: {', '.join(also)}" * bool(also)
    more = parts.get("others")
    if more is not None and more.values.size:
        values = more.values[:_MOST] * convert(1.0, more.unit, unit)
        further = more.values.size - _MOST
        shown = ", ".join(show(other, digits=_DIGITS) for other in values.tolist())
        shown += f" and {further} more" * (further > 0)
        what = "extremes" if search.get("sense") else "solutions"
        words += f"; further {what} at {shown} {unit}".rstrip()
    return words


def _result_unit(search: Mapping[str, Any], parts: Mapping[str, Quantity]) -> str:
    """The unit that the case writes the target in, else the one that people read the result in."""
    of = parts["reached"].unit if "reached" in parts else ""
    return bound_unit({"max": search.get("target")}, read_as(str(search["quantity"]), of)[1])


def _number(parts: Mapping[str, Quantity], name: str, unit: str | None = None) -> str:
    """A scalar with its unit: that given, else its own."""
    one = parts.get(name)
    if one is None:
        return "-"
    unit = one.unit if unit is None else unit
    value, error = in_unit(one, unit)
    return show_in(value, unit, error, _DIGITS)
