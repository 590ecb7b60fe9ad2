"""Pictures of optimisations: start and optimum, combinations, tolerances, the front."""

import re
from collections.abc import Callable, Sequence
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.report.canvas import COLOURS, LIMIT, QUIET, canvas, note, panels_of, unit_words
from vibecalc.core.report.goals import (
    FRONT,
    PREFIX,
    Goal,
    Variable,
    goals_of,
    objective_of,
    variables_of,
    worst_of,
)
from vibecalc.core.report.sections import having, labels, scalar_of
from vibecalc.core.report.studies import sigmas_of
from vibecalc.core.report.writing import fold, show
from vibecalc.core.results.record import AT_START, FRONT_NAMES, Quantity, Result
from vibecalc.core.results.verdicts import name_of, verdicts_of
from vibecalc.units import convert

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: where a legend stands above its panel
ABOVE: dict[str, Any] = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "ncols": 2}


def in_words(result: Result, path: str, width: int = 44) -> str:
    """What a quantity is, folded for an axis."""
    quantity = result.record.quantities.get(path)
    words = "" if quantity is None else quantity.long_name
    return "\n".join(fold(words or path.rsplit("/", 1)[-1].replace("_", " "), width))


def name_rows(axes: "Axes", names: Sequence[str], label: str, legend: bool = True) -> None:
    """Names of what stands below each other, the first at the top, and words for the other axis."""
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.5, -0.7)
    axes.grid(visible=False, axis="y")
    axes.set_xlabel(label)
    if legend:
        axes.legend(**ABOVE)


def lying(
    axes: "Axes", at: Any, sizes: Sequence[float], wide: float, write: Callable[[float], str],
    **look: Any,
) -> None:  # fmt: skip
    """Bars to the right with their numbers."""
    axes.barh(at, sizes, wide, **look)
    for place, size in zip(at, sizes, strict=True):
        note(axes, write(size), (size, place), (4, 0), va="center")


# ----------------------------------------------------------------------------
# Combinations and tolerances.
# ----------------------------------------------------------------------------

_BARS = 20


def draw_combinations(result: Result) -> "Figure | None":
    """Bars of the objective, words at those that keep no limits; None where nothing is picked."""
    objective = having(result.record, f"{PREFIX}combinations/objective", "combination")
    if objective is None or not np.any(np.isfinite(objective.values)):
        return None
    goal, texts = objective_of(result, objective.unit), labels(objective.axes[0])[:_BARS]
    kept = np.isfinite(objective.values[:_BARS])
    heights = goal.factor * objective.values[:_BARS][kept]
    figure = canvas(result, "optimisation: combinations", 1.6 + 0.34 * kept.size)
    axes, colours = figure.subplots(), [COLOURS[0], *[QUIET] * (heights.size - 1)]
    lying(axes, np.flatnonzero(kept), heights.tolist(), 0.62, show, color=colours)
    for place in np.flatnonzero(~kept):
        note(axes, "limits not met", (0.0, place), (4, 0), va="center", color=LIMIT)
    axes.set_xlim(right=1.15 * max(0.0, float(np.max(heights))) or None)
    label = f"{_with_unit(goal)}; optimum of each combination"
    name_rows(axes, texts, label, legend=False)
    return figure


def draw_robust(result: Result) -> "Figure | None":
    """The objective at start and optimum: mean with its deviations, and the nominal value."""
    mean = having(result.record, f"{PREFIX}robust/mean", "point")
    if mean is None:
        return None
    goal, points = objective_of(result, mean.unit), labels(mean.axes[0])
    names = ("mean", "deviation", "nominal", "value")
    found = (result.record[f"{PREFIX}robust/{name}"].values for name in names)
    middle, apart, nominal, value = (goal.factor * one for one in found)
    figure = canvas(result, "optimisation over tolerances", 1.8 + 0.5 * len(points))
    axes, place, most = figure.subplots(), np.arange(len(points)), sigmas_of(result) or 1.0
    axes.errorbar(middle, place, xerr=most * apart, fmt="o", color=COLOURS[0], capsize=4,
                  label=f"mean and {most:g} deviations")  # fmt: skip
    axes.plot(nominal, place, "D", color=QUIET, mfc="white", label="without tolerances")
    for at, end in enumerate(value.tolist()):
        note(axes, show(end), (end, at), (0, 6), ha="center")
    name_rows(axes, points, _with_unit(goal))
    return figure


def _with_unit(goal: Goal) -> str:
    return f"{goal.name}{',' * (',' in goal.name)} in {goal.unit}" if goal.unit else goal.name


# ----------------------------------------------------------------------------
# The front: a panel for each two objectives, with start, utopia and knee.
# ----------------------------------------------------------------------------


def draw_front(result: Result) -> "Figure | None":
    """Each objective over each one before it, None without a front in the result."""
    goals = goals_of(result)
    if not goals:
        return None
    pairs = list(combinations(range(len(goals)), 2))
    across = 1 if len(pairs) == 1 else 2 if len(pairs) < 9 else 3
    count, high = "two" if across == 1 else len(goals), 3.9 * -(-len(pairs) // across) + 0.6
    figure = canvas(result, f"front between {count} objectives", 5.4 if across == 1 else high)
    for panel, pair in zip(panels_of(figure, len(pairs), across), pairs, strict=True):
        _draw_pair(result, panel, [goals[one] for one in pair], len(pairs) == 1)
        if [FRONT_NAMES[one] for one in pair] == list(FRONT_NAMES[:2]):
            panel.legend(loc="best")
    return figure


def _draw_pair(
    result: Result, axes: "Axes", pair: list[tuple[Goal, Quantity]], alone: bool
) -> None:
    goals = [goal for goal, _ in pair]
    across, up = (np.asarray(one.values, dtype=float) * goal.factor for goal, one in pair)
    if alone:
        axes.plot(across, up, "-", color=COLOURS[0], linewidth=0.7, alpha=0.5)
    axes.plot(across, up, "o", color=COLOURS[0], label="front (computed points)")
    for place in (0, len(across) - 1) if alone else ():
        note(axes, str(place + 1), (across[place], up[place]), (6, 6))
    knee = int(scalar_of(result.record, FRONT + "knee") or 0)
    if knee:
        axes.plot([across[knee - 1]], [up[knee - 1]], "o", color=LIMIT, ms=9, mfc="none",
                  label=f"knee, point {knee}")  # fmt: skip
    best = [goal.best(values) for goal, values in zip(goals, (across, up), strict=True)]
    axes.plot(best[:1], best[1:], "*", color=QUIET, ms=10, label="utopia")
    start = [goal.factor * value for goal in goals
             if (value := goal.at(result.record, AT_START)) is not None]  # fmt: skip
    if len(start) == 2:
        axes.plot(start[:1], start[1:], "s", color=QUIET, mfc="white", ms=8, label="start")
    words = [_axis(result, goal, 44 if alone else 32) for goal in goals]
    axes.set_xlabel(words[0])
    axes.set_ylabel(words[1])


def _axis(result: Result, goal: Goal, width: int) -> str:
    words = name_of(in_words(result, goal.path, width), goal.where)
    unit = f" in {unit_words(goal.unit)[1]}" if goal.unit else ""
    return f"{words}{unit}\n({'smaller' if goal.smaller else 'larger'} is better)"


# ----------------------------------------------------------------------------
# Start against optimum: variables inside their bounds, and how much of each limit is used.
# ----------------------------------------------------------------------------

#: of the width between its bounds, below which an optimum is written as 0
_ROUNDING = 1e-9


#: words, start and optimum in percent of a bound, or of the objective at the start; which of them
Use = tuple[str, float, float, bool]


def draw_start_and_optimum(result: Result) -> "Figure | None":
    """Variables above, limits and objective below; None without variables in the result."""
    variables = variables_of(result, {"m": "mm", "rad": "deg"})
    if not variables:
        return None
    uses = _uses(result)
    rows = [len(variables), len(uses)] if uses else [len(variables)]
    figure = canvas(result, "optimisation: start and optimum", 2.2 + 0.62 * sum(rows))
    panels = figure.subplots(len(rows), 1, squeeze=False, height_ratios=rows)[:, 0]
    _draw_variables(panels[0], variables)
    if uses:
        _draw_uses(panels[1], uses)
    return figure


def _key_words(key: str) -> str:
    """`cylinders[1].crank_phase`, which counts from 0, as cylinder 2: crank phase."""
    *way, last = key.replace("_", " ").split(".")
    way = [re.sub(r"s\[(\d+)\]$", lambda place: f" {int(place[1]) + 1}", part) for part in way[-2:]]
    return ": ".join([*([", ".join(way)] if way else ()), last])


def _draw_variables(axes: "Axes", variables: list[Variable]) -> None:
    for i, one in enumerate(variables):
        span = 100.0 / (one.upper - one.lower)
        axes.plot([0.0, 100.0], [i, i], color="#cccccc", linewidth=3.0, zorder=1)
        if one.start is not None:
            place = float(np.clip((one.start - one.lower) * span, 0.0, 100.0))
            axes.plot([place], [i], "o", color=QUIET, mfc="white", ms=8, zorder=2,
                      label=None if i else "start")  # fmt: skip
        found = abs(one.value) >= _ROUNDING * (one.upper - one.lower)
        optimum = one.value if found else 0.0  # as far as a search finds it
        axes.plot([(optimum - one.lower) * span], [i], "o", color=COLOURS[0], ms=8, zorder=3,
                  label=None if i else "optimum")  # fmt: skip
        was = "" if one.start is None else f"{show(one.start)} → "
        words = f"{was}{show(optimum)} {unit_words(one.unit)[1]}".rstrip()
        note(axes, words, (50.0, i), (0, 7), ha="center")
    axes.set_xlim(-2.0, 102.0)
    names = [_key_words(one.key.removeprefix("machine.")) for one in variables]
    name_rows(axes, names, "place between lower (0) and upper bound (100) in %")


def _uses(result: Result) -> list[Use]:
    uses: list[Use] = []
    for row in verdicts_of(result):
        if row.max and not row.element and row.at != "start" and np.isfinite(row.computed):
            start = worst_of(result.record, AT_START + row.quantity, row.where, "max")
            factor = 100.0 * convert(1.0, result.record[row.quantity].unit, row.unit) / row.max
            limit = f"max {row.max:g} {unit_words(row.unit)[1]}".rstrip()
            words = f"{in_words(result, row.quantity)}\n{limit}"
            uses.append((words, factor * (start or 0.0), 100.0 * row.utilisation, True))
    goal = objective_of(result)
    start, end = goal.at(result.record, AT_START), goal.at(result.record)
    if start and end is not None:
        words = f"objective:\n{in_words(result, goal.path)}"
        uses.append((words, 100.0, 100.0 * end / start, False))
    return uses


def _draw_uses(axes: "Axes", uses: list[Use]) -> None:
    place = np.arange(len(uses), dtype=float)
    names, starts, ends, limited = zip(*uses, strict=True)
    lying(axes, place - 0.19, starts, 0.36, "{:.1f} %".format, color="#c9c9c9", label="start")
    lying(axes, place + 0.19, ends, 0.36, "{:.1f} %".format, color=COLOURS[0], label="optimum")
    if any(limited):
        axes.axvline(100.0, color=LIMIT, linestyle="--", linewidth=1.3)
    axes.set_xlim(0.0, 1.18 * max([100.0, *starts, *ends]))
    parts = ["% of the limit"] * any(limited) + ["objective: % of its start"] * (not all(limited))
    name_rows(axes, names, "; ".join(parts))
