"""Start against optimum: variables inside their bounds, and how much of each limit is used."""

from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from vibecalc.errors import ResultError
from vibecalc.report.limits import LimitRow, judge_limits
from vibecalc.report.lookup import START, scalar_of, table_of
from vibecalc.report.numbers import show
from vibecalc.report.pictures.canvas import COLOURS, LIMIT, QUIET, canvas
from vibecalc.report.sections.key_start import VARIABLE, start_of
from vibecalc.results.record import Result
from vibecalc.results.select import worst
from vibecalc.units import convert, parse_quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def picture(result: Result) -> "Figure | None":
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
