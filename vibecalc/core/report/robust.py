"""An optimum over tolerances: mean and deviation of the objective and of the limits."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.report.sections import along, labels, read_as, scalar_of, table_of
from vibecalc.core.report.writing import Column, number, paragraph, show, table
from vibecalc.core.results.record import Result
from vibecalc.units import convert

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ROBUST = "optimisation/robust/"
_ROWS = (
    ("nominal", "without tolerances", ""),
    ("mean", "mean", "mean_error"),
    ("deviation", "standard deviation", "deviation_error"),
    ("value", "mean and {} deviations", "value_error"),
)


def sigmas_of(result: Result) -> str:
    """How many deviations count."""
    given: Any = table_of(result.case, "optimisation", "robust").get("sigmas", 2.0)
    return f"{float(given):g}"


def robust(result: Result) -> list[str]:
    """Mean and deviation at start and optimum, and of what the limits leave; what was drawn."""
    record, mean = result.record, along(result.record, ROBUST + "mean", "point")
    if mean is None:
        return []
    goal = str(table_of(result.case, "optimisation", "objective").get("quantity"))
    name, unit = read_as(goal, mean[0].unit)
    factor = convert(1.0, mean[0].unit, unit)
    points = labels(mean[0].axes[0])
    rows = []
    for path, words, error in _ROWS:
        quantity = record[ROBUST + path]
        row = [words.format(sigmas_of(result))]
        for place in range(len(points)):
            row.append(show(float(quantity.values[place]) * factor))
        known = (
            "" if not error else show(float(record[ROBUST + error].values[-1]) * factor, digits=2)
        )
        rows.append([*row, unit, known])
    columns = (
        Column(name[:38], 38),
        *(number(point, 11) for point in points),
        Column("unit", 8),
        number("standard error", 14),
    )
    limits = _limits(result)
    return [*paragraph(_drawn(result)), *table(columns, rows), *([""] if limits else []), *limits]


def _drawn(result: Result) -> str:
    """What scatters, and how many machines stand for it."""
    given: Any = table_of(result.case, "optimisation", "robust")
    scattered = "; ".join(
        f"{one['key']} evenly within +-{one['half_width']}"
        if one.get("half_width") is not None
        else f"{one['key']} normally with a deviation of {one['deviation']}"
        for one in given.get("tolerances") or ()
    )
    count = int(scalar_of(result.record, ROBUST + "samples") or 0)
    points = int(scalar_of(result.record, "optimisation/evaluations") or 0)
    return (
        f"over tolerances: {scattered}. {count} machines, the same deviations for each of "
        f"{points} points; standard errors are those of other machines drawn"
    )


def _limits(result: Result) -> list[str]:
    mean = along(result.record, ROBUST + "margin_mean", "limit")
    if mean is None:
        return []
    columns = (
        Column("share of the limit that is left", 46),
        number("nominal", 10),
        number("mean", 10),
        number("deviation", 10),
    )
    parts = [result.record[f"{ROBUST}margin_{one}"] for one in ("nominal", "mean", "deviation")]
    rows = [
        [name, *(show(float(part.values[place])) for part in parts)]
        for place, name in enumerate(labels(mean[0].axes[0]))
    ]
    return table(columns, rows)


def draw_robust(result: Result) -> "Figure | None":
    """The objective at start and optimum: mean with its deviations, and the nominal value."""
    from vibecalc.core.report.canvas import COLOURS, QUIET, canvas, note

    mean = along(result.record, ROBUST + "mean", "point")
    if mean is None:
        return None
    goal = str(table_of(result.case, "optimisation", "objective").get("quantity"))
    name, unit = read_as(goal, mean[0].unit)
    factor = convert(1.0, mean[0].unit, unit)
    points = labels(mean[0].axes[0])
    middle, apart, nominal, value = (
        np.asarray(result.record[ROBUST + one].values, dtype=float) * factor
        for one in ("mean", "deviation", "nominal", "value")
    )
    figure = canvas(result, "optimisation over tolerances", 1.8 + 0.5 * len(points))
    axes = figure.subplots()
    place = np.arange(len(points))
    most = float(sigmas_of(result)) or 1.0
    axes.errorbar(middle, place, xerr=most * apart, fmt="o", color=COLOURS[0], capsize=4,
                  label=f"mean and {most:g} deviations")  # fmt: skip
    axes.plot(nominal, place, "D", color=QUIET, mfc="white", label="without tolerances")
    for at, end in zip(place, value, strict=True):
        note(axes, show(float(end)), (float(end), float(at)), (6, 4))
    axes.set_yticks(place, points)
    axes.set_ylim(len(points) - 0.5, -0.6)
    axes.set_xlabel(f"{name}{f' in {unit}' if unit else ''}")
    axes.grid(visible=False, axis="y")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    return figure
