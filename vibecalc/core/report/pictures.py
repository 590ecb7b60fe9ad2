"""Pictures of studies: start against optimum, the front, error against seconds."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from vibecalc.core.report.accuracy import RungView, TopicView, topics_of
from vibecalc.core.report.canvas import COLOURS, LIMIT, QUIET, TOTAL, canvas
from vibecalc.core.report.searches import FRONT_PREFIX
from vibecalc.core.report.sections import START, along, scalar_of, table_of
from vibecalc.core.report.studies import VARIABLE, start_of
from vibecalc.core.report.verdicts import LimitRow, judge_limits
from vibecalc.core.report.writing import fold, show
from vibecalc.core.results.layout import is_accuracy
from vibecalc.core.results.record import Result
from vibecalc.core.results.select import worst
from vibecalc.errors import ResultError
from vibecalc.units import convert, parse_quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# Error against seconds: a panel for each topic, a line for each method.
# ----------------------------------------------------------------------------

_ACROSS = 3
#: more methods than these are named beside the panel
_INSIDE = 5
#: letters of a title in an inch
_LETTERS = 9
_WORDS = (
    "worst relative error over seconds; filled: the front; ring: what vibecalc takes; "
    "dotted: the truth is known to it"
)
_MARKERS = ("o", "s", "^", "D", "v", "P")

#: errors are drawn from here on; what is exact sits on the lower edge
_LEAST = 1e-17


def draw_accuracy(result: Result) -> "Figure | None":
    """Log-log panels of worst relative error over seconds, None for a result of another kind.

    The front in seconds is filled, what vibecalc takes is ringed, failed settings are crosses on
    the upper edge, at the seconds that the failure took.
    """
    if not is_accuracy(result):
        return None
    topics = topics_of(result)
    across = min(_ACROSS, len(topics))
    down = -(-len(topics) // across)
    widest = max(len(topic.methods) for topic in topics)
    width = (5.4 if widest <= _INSIDE else 7.2) * across
    words = "\n".join(fold(_WORDS, int(_LETTERS * width)))
    figure = canvas(result, words, width, 0.6 + 4.1 * down)
    panels = figure.subplots(down, across, squeeze=False).ravel()
    for axes, topic in zip(panels, topics, strict=False):
        _panel(axes, topic)
    for axes in panels[len(topics) :]:
        axes.set_visible(False)
    return figure


def _panel(axes: "Axes", topic: TopicView) -> None:
    done = [rung for rung in topic.rungs if rung.done and rung.seconds]
    errors = [_height(rung) for rung in done] or [1.0]
    low, top = _span(errors, 2.0)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(*_span([_across(rung) for rung in topic.rungs if rung.seconds] or [1.0], 1.0))
    axes.set_ylim(low, top)
    axes.minorticks_off()
    for place, method in enumerate(topic.methods):
        colour, marker = COLOURS[place % len(COLOURS)], _MARKERS[place % len(_MARKERS)]
        line = "-" if place < len(COLOURS) else "--"
        rungs = [rung for rung in topic.of(method.name) if rung.seconds]
        measured = [rung for rung in rungs if rung.done]
        front = [rung for rung in measured if rung.in_seconds]
        failed = [rung for rung in rungs if not rung.done]
        style: dict[str, Any] = {"color": colour, "marker": marker, "ms": 5}
        _dots(
            axes, measured, linestyle=line, linewidth=1.2, mfc="white", label=method.name, **style
        )
        _dots(axes, front, linestyle="none", **style)
        if failed:
            edge = [_across(rung) for rung in failed]
            axes.plot(edge, [top] * len(edge), "x", color=colour, ms=7, clip_on=False)
    defaults = [rung for rung in done if rung.is_default]
    _dots(axes, defaults, linestyle="none", marker="o", color=TOTAL, mfc="none", ms=12, mew=1.4)
    if topic.agreement > low:
        axes.axhline(topic.agreement, color=LIMIT, linestyle=":", linewidth=1.0)
    axes.set_title("\n".join(fold(f"{topic.words['stage']}: {topic.words['name']}", 44)))
    axes.set_xlabel("seconds")
    axes.set_ylabel("worst relative error")
    if len(topic.methods) <= _INSIDE:
        axes.legend(fontsize=7, loc="best")
    else:
        axes.legend(fontsize=7, loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)


def _dots(axes: "Axes", rungs: Sequence[RungView], **style: Any) -> None:
    axes.plot([_across(rung) for rung in rungs], [_height(rung) for rung in rungs], **style)


def _across(rung: RungView) -> float:
    return rung.seconds or 0.0


def _height(rung: RungView) -> float:
    return max(rung.relative, _LEAST) if math.isfinite(rung.relative) else 1.0


def _span(values: Sequence[float], decades: float) -> tuple[float, float]:
    """Ends of an axis around the values, at least so many decades apart."""
    low, high = math.log10(min(values)) - 0.3, math.log10(max(values)) + 0.3
    more = max(0.5 * (decades - (high - low)), 0.0)
    return 10.0 ** (low - more), 10.0 ** (high + more)


# ----------------------------------------------------------------------------
# The front between two objectives, with the start.
# ----------------------------------------------------------------------------


def draw_pareto(result: Result) -> "Figure | None":
    """Second objective over the first, None without a front in the result."""
    one = along(result.record, FRONT_PREFIX + "objective", "front_point")
    two = along(result.record, FRONT_PREFIX + "second_objective", "front_point")
    if one is None or two is None:
        return None
    study = table_of(result.case, "optimisation")
    goals = [table_of(study, name) for name in ("objective", "second_objective")]
    figure = canvas(result, "front between two objectives", 7.4, 5.4)
    axes = figure.subplots()
    across, up = (np.asarray(part[0].values, dtype=float) for part in (one, two))
    axes.plot(across, up, "-", color=COLOURS[0], linewidth=0.7, alpha=0.5)
    axes.plot(across, up, "o", color=COLOURS[0], ms=5, label="front (computed points)")
    for place in (0, len(across) - 1):
        axes.annotate(
            str(place + 1),
            (across[place], up[place]),
            xytext=(6, 6),
            textcoords="offset points",
            fontsize=9,
        )
    start = [_start(result, goal) for goal in goals]
    if start[0] is not None and start[1] is not None:
        axes.plot([start[0]], [start[1]], "s", color=QUIET, mfc="white", ms=8, label="start")
    units = (one[0].unit, two[0].unit)
    words = [_axis(goal, unit) for goal, unit in zip(goals, units, strict=True)]
    axes.set_xlabel(words[0])
    axes.set_ylabel(words[1])
    axes.legend(loc="best")
    return figure


def _axis(goal: Mapping[str, Any], unit: str) -> str:
    picks = ", ".join(f"{axis}={entry}" for axis, entry in dict(goal.get("where") or {}).items())
    sense = "smaller" if goal.get("sense", "min") == "min" else "larger"
    name = str(goal.get("quantity")) + (f" [{picks}]" if picks else "")
    return f"{name}{f' in {unit}' if unit else ''}\n({sense} is better)"


def _start(result: Result, goal: Mapping[str, Any]) -> float | None:
    quantity = result.record.quantities.get(START + str(goal.get("quantity")))
    if quantity is None:
        return None
    side: Literal["max", "min"] = "max" if goal.get("sense", "min") == "min" else "min"
    try:
        value, _ = worst(quantity, dict(goal.get("where") or {}), side)
    except ResultError:
        return None
    return value if np.isfinite(value) else None


# ----------------------------------------------------------------------------
# Start against optimum: variables inside their bounds, and how much of each limit is used.
# ----------------------------------------------------------------------------


def draw_start_and_optimum(result: Result) -> "Figure | None":
    """Variables above, limits and objective below; None without variables in the result."""
    variables = _variables(result)
    if not variables:
        return None
    uses = _uses(result)
    rows = [len(variables), len(uses)] if uses else [len(variables)]
    figure = canvas(result, "optimisation: start and optimum", 8.6, 2.2 + 0.62 * sum(rows))
    panels = figure.subplots(len(rows), 1, squeeze=False, height_ratios=rows)[:, 0]
    _draw_variables(panels[0], variables)
    if uses:
        _draw_uses(panels[1], uses)
    return figure


Side = Literal["max", "min"]
Variable = tuple[str, str, float, float, float | None, float]
Use = tuple[str, float | None, float, bool]


def _variables(result: Result) -> list[Variable]:
    given: Any = table_of(result.case, "optimisation").get("variables") or ()
    found: list[Variable] = []
    for variable in given:
        key = str(variable["key"])
        quantity = result.record.quantities.get(VARIABLE + key)
        value = scalar_of(result.record, VARIABLE + key)
        if quantity is None or value is None:
            continue
        lower, upper = (parse_quantity(variable[end], quantity.unit) for end in ("lower", "upper"))
        found.append((key, quantity.unit, lower, upper, start_of(result, key), value))
    return found


def _draw_variables(axes: "Axes", variables: list[Variable]) -> None:
    names = []
    for i, (key, unit, lower, upper, start, optimum) in enumerate(variables):
        names.append(key.removeprefix("machine."))
        span = 100.0 / (upper - lower)
        axes.plot([0.0, 100.0], [i, i], color="#cccccc", linewidth=3.0, zorder=1)
        if start is not None:
            place = float(np.clip((start - lower) * span, 0.0, 100.0))
            axes.plot([place], [i], "o", color=QUIET, mfc="white", ms=8, zorder=2, label="start")
        place = (optimum - lower) * span
        axes.plot([place], [i], "o", color=COLOURS[0], ms=8, zorder=3, label="optimum")
        was = "" if start is None else f"{show(start, digits=4)} → "
        words = f"{was}{show(optimum, digits=4)} {unit}".rstrip()
        axes.annotate(words, (50.0, i), xytext=(0, 7), textcoords="offset points", ha="center")
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.5, -0.7)
    axes.set_xlim(-2.0, 102.0)
    axes.set_xlabel("place between lower (0) and upper bound (100) in %")
    axes.grid(visible=False, axis="y")
    handles, texts = axes.get_legend_handles_labels()
    once = dict(zip(texts, handles, strict=True))
    axes.legend(
        once.values(),
        once.keys(),
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
        ncols=2,
        fontsize=9,
    )


def _uses(result: Result) -> list[Use]:
    """Name, start and optimum in percent of the bound or of the start, whether it is a limit."""
    uses: list[Use] = []
    for row in judge_limits(result):
        if row.max and row.at != "start" and np.isfinite(row.computed):
            start = _start_value(result, row.quantity, dict(row.where), "max")
            if start is not None:
                start = 100.0 * convert(start, result.record[row.quantity].unit, row.unit) / row.max
            uses.append((_short(row), start, 100.0 * row.computed / row.max, True))
    objective = table_of(result.case, "optimisation", "objective")
    path, where = str(objective.get("quantity") or ""), dict(objective.get("where") or {})
    if path in result.record:
        side: Side = "max" if objective.get("sense", "min") == "min" else "min"
        start = _start_value(result, path, where, side)
        if start:
            end, _ = worst(result.record[path], where, side)
            uses.append((f"objective {path.split('/', 1)[-1]}", 100.0, 100.0 * end / start, False))
    return uses


def _start_value(result: Result, path: str, where: dict[str, Any], side: Side) -> float | None:
    quantity = result.record.quantities.get(START + path)
    if quantity is None:
        return None
    try:
        value, _ = worst(quantity, where, side)
    except ResultError:
        return None
    return value if np.isfinite(value) else None


def _short(row: LimitRow) -> str:
    return f"{row.quantity.split('/', 1)[-1]}\nmax {row.max:g} {row.unit}".rstrip()


def _draw_uses(axes: "Axes", uses: list[Use]) -> None:
    place = np.arange(len(uses), dtype=float)
    starts = [use[1] if use[1] is not None else 0.0 for use in uses]
    ends = [use[2] for use in uses]
    axes.barh(place - 0.19, starts, 0.36, color="#c9c9c9", label="start")
    axes.barh(place + 0.19, ends, 0.36, color=COLOURS[0], label="optimum")
    for i, (start, end) in enumerate(zip(starts, ends, strict=True)):
        for shift, value in ((-0.19, start), (0.19, end)):
            axes.annotate(
                f"{value:.1f} %",
                (value, i + shift),
                xytext=(4, 0),
                textcoords="offset points",
                va="center",
                fontsize=9,
            )
    limited, aimed = any(use[3] for use in uses), not all(use[3] for use in uses)
    if limited:
        axes.axvline(100.0, color=LIMIT, linestyle="--", linewidth=1.3)
    axes.set_yticks(place, [use[0] for use in uses])
    axes.invert_yaxis()
    axes.set_xlim(0.0, 1.18 * max([100.0, *starts, *ends]))
    parts = ["% of the limit"] * limited + ["objective: % of its start"] * aimed
    axes.set_xlabel("; ".join(parts))
    axes.grid(visible=False, axis="y")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, fontsize=9)
