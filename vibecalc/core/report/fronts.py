"""The front between objectives: its points in a table, and drawn, for each two of them."""

from collections.abc import Mapping
from itertools import combinations
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from vibecalc.core.report.choices import PICKED, label_of
from vibecalc.core.report.sections import along, read_as, scalar_of, table_of
from vibecalc.core.report.writing import Column, fold, number, paragraph, show, table
from vibecalc.core.results.record import AT_START, Quantity, Result
from vibecalc.core.results.select import worst
from vibecalc.errors import ResultError
from vibecalc.units import convert

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FRONT = "optimisation/front/"
NAMES = ("objective", "second_objective", "third_objective", "fourth_objective", "fifth_objective")
#: variables that fit next to two objectives, and to more of them
_VARIABLES, _FEWER = 4, 2
_ROOM = 14


def goals_of(result: Result) -> list[tuple[Mapping[str, Any], Quantity]]:
    """The objectives of a front as the case has them, and their values along it; none without."""
    study: Mapping[str, Any] = table_of(result.case, "optimisation")
    given = [table_of(study, name) for name in NAMES[:2]]
    given += list(study.get("further_objectives") or ())
    found = [along(result.record, FRONT + name, "front_point") for name in NAMES[: len(given)]]
    return [(goal, one[0]) for goal, one in zip(given, found, strict=True) if one is not None]


def best_of(goal: Mapping[str, Any], quantity: Quantity) -> float:
    """The best of one objective on the front, whatever the others are there."""
    pick = np.min if goal.get("sense", "min") == "min" else np.max
    return float(pick(quantity.values))


def in_words(result: Result, path: str, width: int = 44) -> str:
    """What a quantity is, folded for an axis."""
    quantity = result.record.quantities.get(path)
    words = "" if quantity is None else quantity.long_name
    return "\n".join(fold(words or path.rsplit("/", 1)[-1].replace("_", " "), width))


# ----------------------------------------------------------------------------
# The table: one line for each point.
# ----------------------------------------------------------------------------


def front(result: Result, units: Mapping[str, str]) -> list[str]:
    """Objectives, what is picked and the first variables along the front, numbers of the result.

    `units` are those that the case gives bounds in, by the path of the variable.
    """
    goals = goals_of(result)
    if len(goals) < 2:
        return []
    count = len(goals[0][1].values)
    knee = int(scalar_of(result.record, FRONT + "knee") or 0)
    columns = [Column("front", 5)]
    rows = [[str(i + 1)] for i in range(count)]
    for (goal, quantity), name in zip(goals, NAMES, strict=False):
        title = name.removesuffix("_objective")
        _, unit = read_as(str(goal.get("quantity")), quantity.unit)
        _add(columns, rows, title, quantity, unit)
    for path, quantity in result.record.items():
        choice = path.removeprefix(FRONT + "choice/")
        if choice != path:
            columns.append(Column(choice, _ROOM))
            for row, value in zip(rows, quantity.values, strict=True):
                row.append(label_of(result.case, PICKED + choice, float(value)))
    root = f"{FRONT}variable/"
    variables = [path.removeprefix(root) for path in result.record if path.startswith(root)]
    most = _VARIABLES if len(goals) == 2 else _FEWER
    for key in variables[:most]:
        quantity = result.record[root + key]
        unit = units.get(f"optimisation/variable/{key}", quantity.unit)
        _add(columns, rows, _last(key), quantity, unit)
    if knee:
        columns.append(Column("", 4))
        for i, row in enumerate(rows):
            row.append("knee" if i + 1 == knee else "")
    words = _words(goals)
    if len(variables) > most:
        further = len(variables) - most
        words += (
            f"; {further} further variable{'s are' if further > 1 else ' is'} in the result file"
        )
    return [*paragraph(words), *table(columns, rows), *_utopia(result, goals)]


def _words(goals: list[tuple[Mapping[str, Any], Quantity]]) -> str:
    names = [read_as(str(goal.get("quantity")), one.unit)[0] for goal, one in goals]
    if len(names) == 2:
        return f"front: the best objective for each value of the second, {names[1]}"
    listed = "; ".join(
        f"{name.removesuffix('_objective')}: {words}"
        for name, words in zip(NAMES, names, strict=False)
    )
    return f"front: no objective can be better without another being worse. {listed}"


def _utopia(result: Result, goals: list[tuple[Mapping[str, Any], Quantity]]) -> list[str]:
    """The best of each objective, which no point has together, and the knee."""
    shown = []
    for goal, one in goals:
        unit = read_as(str(goal.get("quantity")), one.unit)[1]
        factor = convert(1.0, one.unit, unit)
        value = show(best_of(goal, one) * factor, one.error_estimate * factor)
        shown.append(f"{value} {unit}".rstrip())
    knee = int(scalar_of(result.record, FRONT + "knee") or 0)
    words = f"utopia, the best of each alone: {' and '.join(shown)}; "
    words += f"the front bends most at point {knee}, its knee" if knee else "the front has no knee"
    return paragraph(words)


def _add(
    columns: list[Column], rows: list[list[str]], title: str, quantity: Quantity, unit: str
) -> None:
    factor = convert(1.0, quantity.unit, unit)
    columns.append(number(f"{title} {unit}".rstrip(), _ROOM))
    for row, value in zip(rows, quantity.values, strict=True):
        row.append(show(float(value) * factor, quantity.error_estimate * factor))


def _last(key: str) -> str:
    """The end of a key, with its table where the end alone says little."""
    return ".".join(key.rsplit(".", 2)[-2:])


# ----------------------------------------------------------------------------
# The picture: a panel for each two objectives, with start, utopia and knee.
# ----------------------------------------------------------------------------


def draw_front(result: Result) -> "Figure | None":
    """Each objective over each one before it, None without a front in the result."""
    from vibecalc.core.report.canvas import canvas

    goals = goals_of(result)
    if len(goals) < 2:
        return None
    pairs = list(combinations(range(len(goals)), 2))
    if len(pairs) == 1:
        figure = canvas(result, "front between two objectives", 5.4)
        _draw_pair(result, figure.subplots(), goals[0], goals[1], NAMES[:2])
        return figure
    across = 2 if len(pairs) < 9 else 3
    down = -(-len(pairs) // across)
    figure = canvas(result, f"front between {len(goals)} objectives", 3.9 * down + 0.6)
    panels = figure.subplots(down, across, squeeze=False).ravel()
    for panel, (one, other) in zip(panels, pairs, strict=False):
        _draw_pair(result, panel, goals[one], goals[other], (NAMES[one], NAMES[other]))
    for panel in panels[len(pairs) :]:
        panel.set_visible(False)
    return figure


def _draw_pair(
    result: Result,
    axes: "Axes",
    one: tuple[Mapping[str, Any], Quantity],
    other: tuple[Mapping[str, Any], Quantity],
    names: tuple[str, ...],
) -> None:
    from vibecalc.core.report.canvas import COLOURS, LIMIT, QUIET, note

    units = [_unit(goal, quantity) for goal, quantity in (one, other)]
    factors = [
        convert(1.0, quantity.unit, unit)
        for (_, quantity), unit in zip((one, other), units, strict=True)
    ]
    across, up = (
        np.asarray(quantity.values, dtype=float) * factor
        for (_, quantity), factor in zip((one, other), factors, strict=True)
    )
    two = len(goals_of(result)) == 2
    if two:
        axes.plot(across, up, "-", color=COLOURS[0], linewidth=0.7, alpha=0.5)
    axes.plot(across, up, "o", color=COLOURS[0], label="front (computed points)")
    for place in (0, len(across) - 1) if two else ():
        note(axes, str(place + 1), (across[place], up[place]), (6, 6))
    knee = int(scalar_of(result.record, FRONT + "knee") or 0)
    if knee:
        axes.plot([across[knee - 1]], [up[knee - 1]], "o", color=LIMIT, ms=9, mfc="none",
                  label=f"knee, point {knee}")  # fmt: skip
    best = [best_of(*one) * factor for one, factor in zip((one, other), factors, strict=True)]
    axes.plot(best[:1], best[1:], "*", color=QUIET, ms=10, label="utopia")
    start = [_start(result, goal) for goal, _ in (one, other)]
    if start[0] is not None and start[1] is not None:
        axes.plot([start[0] * factors[0]], [start[1] * factors[1]], "s", color=QUIET,
                  mfc="white", ms=8, label="start")  # fmt: skip
    axes.set_xlabel(_axis(result, one[0], units[0], 44 if two else 32))
    axes.set_ylabel(_axis(result, other[0], units[1], 44 if two else 32))
    if names == NAMES[:2]:
        axes.legend(loc="best")


def _unit(goal: Mapping[str, Any], quantity: Quantity) -> str:
    return read_as(str(goal.get("quantity")), quantity.unit)[1]


def _axis(result: Result, goal: Mapping[str, Any], unit: str, width: int) -> str:
    from vibecalc.core.report.canvas import unit_words

    picks = ", ".join(f"{axis}={entry}" for axis, entry in dict(goal.get("where") or {}).items())
    sense = "smaller" if goal.get("sense", "min") == "min" else "larger"
    name = in_words(result, str(goal.get("quantity")), width) + (f" [{picks}]" if picks else "")
    return f"{name}{f' in {unit_words(unit)[1]}' if unit else ''}\n({sense} is better)"


def _start(result: Result, goal: Mapping[str, Any]) -> float | None:
    quantity = result.record.quantities.get(AT_START + str(goal.get("quantity")))
    if quantity is None:
        return None
    side: Literal["max", "min"] = "max" if goal.get("sense", "min") == "min" else "min"
    try:
        value, _ = worst(quantity, dict(goal.get("where") or {}), side)
    except ResultError:
        return None
    return value if np.isfinite(value) else None
