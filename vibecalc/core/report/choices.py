"""What an optimisation picked from lists and stocks, next to the other combinations."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.report.sections import along, labels, read_as, scalar_of, table_of
from vibecalc.core.report.writing import Column, number, paragraph, show, table
from vibecalc.core.results.record import Record, Result
from vibecalc.units import convert, parse_quantity, split_number

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# Names of what is picked: of a stock its items, of a key the values of its list.
# ----------------------------------------------------------------------------

_ROOT = "optimisation/"
PICKED, COMBINATIONS = f"{_ROOT}choice/", f"{_ROOT}combinations/"
_MOST = 12


def unit_of_choices(variable: Mapping[str, Any]) -> str:
    """The unit that the values of a list carry, or nothing."""
    given = variable.get("choices") or ()
    units = (split_number(one)[1] for one in given if isinstance(one, str) and one[:1] in _DIGITS)
    return next(filter(None, units), "")


_DIGITS = "+-.0123456789"


def picked_of(result: Result) -> list[tuple[str, str, str, int]]:
    """Name, what was picked, how it was written and the length of each list, as the case has it."""
    study = table_of(result.case, "optimisation")
    found = []
    for stock in study.get("stock") or ():
        items = stock["items"]
        place = scalar_of(result.record, f"{PICKED}{stock['name']}")
        if place is not None:
            written = _written(result.case, stock)
            found.append((stock["name"], items[int(place) - 1]["name"], written, len(items)))
    for variable in study.get("variables") or ():
        key, given = str(variable["key"]), variable.get("choices") or ()
        place = scalar_of(result.record, PICKED + key)
        if place is not None:
            found.append((key, str(given[int(place) - 1]), str(_at(result.case, key)), len(given)))
            continue
        value = scalar_of(result.record, f"{_ROOT}variable/{key}")
        if value is None or not (given or variable.get("integer")):
            continue
        unit = result.record[f"{_ROOT}variable/{key}"].unit
        written_unit = unit_of_choices(variable) or unit
        shown = f"{show(convert(value, unit, written_unit))} {written_unit}".rstrip()
        before = _at(result.case, key)
        if isinstance(before, int | float):
            before = f"{show(convert(float(before), unit, written_unit))} {written_unit}".rstrip()
        low, high = (parse_quantity(variable.get(one) or 0.0, "") for one in ("lower", "upper"))
        size = len(given) or int(np.floor(high) - np.ceil(low)) + 1
        found.append((key, shown, "-" if before is None else str(before), size))
    return found


def label_of(case: Mapping[str, Any], path: str, value: float) -> str:
    """The name of what is picked at a path `optimisation/choice/...`."""
    study, name, place = table_of(case, "optimisation"), path.removeprefix(PICKED), int(value) - 1
    for stock in study.get("stock") or ():
        if stock["name"] == name:
            return str(stock["items"][place]["name"])
    lists = {one["key"]: one.get("choices") or () for one in study.get("variables") or ()}
    return str(lists[name][place])


def _at(case: Mapping[str, Any], key: str) -> Any:
    part: Any = case
    for name in key.replace("[", ".").replace("]", "").split("."):
        try:
            part = part[int(name)] if name.isdigit() else part[name]
        except (KeyError, IndexError, TypeError):
            return None
    return part


def _written(case: Mapping[str, Any], stock: Mapping[str, Any]) -> str:
    """The item that the case as written has, or that it has none of them."""
    for item in stock["items"]:
        values = {key: _at(case, f"{stock['table']}.{key}") for key in item["values"]}
        if all(_same(values[key], written) for key, written in item["values"].items()):
            return str(item["name"])
    return "none of them"


def _same(value: Any, written: Any) -> bool:
    from vibecalc.units import si_value

    if isinstance(value, str) or value is None:
        return bool(value == written)
    number_written = si_value(written) if isinstance(written, str) else float(written)
    return bool(abs(value - number_written) <= 1e-12 * abs(value))


# ----------------------------------------------------------------------------
# The section: what was picked, what was examined, the best combinations.
# ----------------------------------------------------------------------------


def picked(result: Result) -> list[str]:
    """What was picked for each choice, out of how many."""
    rows = [[name, written, found, str(size)] for name, found, written, size in picked_of(result)]
    columns = (
        Column("picked", 37),
        Column("as written", 19),
        Column("optimum", 19),
        number("out of", 7),
    )
    return table(columns, rows) if rows else []


def combinations(result: Result) -> list[str]:
    """What was examined, in words, and the best combinations."""
    record = result.record
    objective = along(record, COMBINATIONS + "objective", "combination")
    if objective is None:
        return []
    goal = str(table_of(result.case, "optimisation", "objective").get("quantity"))
    _, unit = read_as(goal, objective[0].unit)
    factor = convert(1.0, objective[0].unit, unit)
    kept = np.asarray(record[COMBINATIONS + "feasible"].values)
    rows = []
    for place, name in enumerate(labels(objective[0].axes[0])[:_MOST]):
        value = float(objective[0].values[place])
        shown = show(value * factor, objective[0].error_estimate * factor)
        rows.append([name, shown if np.isfinite(value) else "-", "" if kept[place] else "no"])
    columns = (
        Column("combination", 50),
        number(f"objective {unit}".rstrip(), 18),
        Column("limits kept", 12),
    )
    further = len(objective[1]) - _MOST
    below = paragraph(f"{further} further ones are in the result file") if further > 0 else []
    return [*paragraph(examined_words(record)), *table(columns, rows), *below]


def examined_words(record: Record) -> str:
    """How many combinations were examined, and what that shows."""
    possible, examined, kept = (
        int(scalar_of(record, COMBINATIONS + name) or 0)
        for name in ("possible", "examined", "kept")
    )
    runs = int(scalar_of(record, f"{_ROOT}evaluations") or 0)
    count = f"all {possible} combinations" if examined == possible else f"{examined} of {possible}"
    words = f"{count} examined, {runs} points in all; "
    words += f"{kept} of them keep the limits" if kept < examined else "all of them keep the limits"
    if examined < possible:
        words += "; none that differs in one choice from the one found is better"
    return words


# ----------------------------------------------------------------------------
# The picture: the objective of the best combinations, as bars.
# ----------------------------------------------------------------------------

_BARS = 20


def draw_combinations(result: Result) -> "Figure | None":
    """Bars of the objective, those that keep no limits left out; None where nothing is picked."""
    from vibecalc.core.report.canvas import COLOURS, QUIET, canvas, note

    objective = along(result.record, COMBINATIONS + "objective", "combination")
    if objective is None:
        return None
    values = np.asarray(objective[0].values, dtype=float)
    shown = np.flatnonzero(np.isfinite(values))[:_BARS]
    if not shown.size:
        return None
    goal = str(table_of(result.case, "optimisation", "objective").get("quantity"))
    name, unit = read_as(goal, objective[0].unit)
    heights = values[shown] * convert(1.0, objective[0].unit, unit)
    texts = labels(objective[0].axes[0])
    figure = canvas(result, "optimisation: combinations", 1.6 + 0.34 * shown.size)
    axes = figure.subplots()
    colours = [COLOURS[0], *[QUIET] * (shown.size - 1)]
    axes.barh(np.arange(shown.size), heights, 0.62, color=colours)
    for place, height in enumerate(heights):
        note(axes, show(float(height)), (float(height), place), (4, 0), va="center")
    axes.set_yticks(np.arange(shown.size), [texts[place] for place in shown])
    axes.invert_yaxis()
    axes.set_xlim(right=1.15 * max(0.0, float(np.max(heights))) or None)
    axes.set_xlabel(f"{name}{f' in {unit}' if unit else ''}: at its best with each")
    axes.grid(visible=False, axis="y")
    return figure
