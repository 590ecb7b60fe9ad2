"""Picture of a fit: what was measured against what is computed, as written and fitted."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.report.canvas import COLOURS, QUIET, canvas, note
from vibecalc.core.report.fit import PREFIX, quantities_of
from vibecalc.core.report.sections import having, labels, read_as
from vibecalc.core.report.study_pictures import ABOVE, name_rows
from vibecalc.core.report.writing import fold
from vibecalc.core.results.record import Quantity, Result
from vibecalc.core.results.select import select
from vibecalc.errors import UnitError
from vibecalc.units import convert, parse_quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Parts = dict[str, Quantity]
_MOST = 6
#: characters of the name of a point
_NAME = 34


def draw_fit(result: Result) -> "Figure | None":
    """A panel for each measured quantity, and the residuals over the uncertainties."""
    quantities = quantities_of(result)
    residual = having(result.record, PREFIX + "residual", "measured_point")
    if not quantities or residual is None:
        return None
    curves = [name for name, parts in quantities.items() if _across(parts) is not None][:_MOST]
    heights = [2.4] * len(curves) + [0.6 + 0.36 * len(residual.values)]
    figure = canvas(result, "fit: measured against computed", 1.2 + sum(heights))
    panels = figure.subplots(len(heights), 1, squeeze=False, height_ratios=heights)[:, 0]
    for axes, name in zip(panels, curves, strict=False):
        _curve(axes, result, name, quantities[name])
    _residuals(panels[-1], result, residual)
    return figure


def _across(parts: Parts) -> tuple[str, str, np.ndarray, dict[str, str]] | None:
    """Axis, unit, numbers and what all share, where the points lie along one axis of numbers."""
    names = [name.split(" (")[0].split(", ") for name in labels(parts["measured"].axes[0])]
    shared = set.intersection(*map(set, names))
    own = [one.partition("=") for name in names for one in name if one not in shared]
    axes = {axis for axis, _, _ in own}
    if len(names) < 3 or len(own) != len(names) or len(axes) != 1:
        return None
    (axis,) = axes
    unit, si = ("rpm", "rad/s") if axis.endswith("speed") else ("", "")
    try:
        values = np.array([parse_quantity(entry, si) for _, _, entry in own])
    except (UnitError, ValueError):
        return None
    picked = (one.partition("=") for one in shared)
    return axis, unit, values * convert(1.0, si, unit), {name: entry for name, _, entry in picked}


def _curve(axes: "Axes", result: Result, path: str, parts: Parts) -> None:
    across = _across(parts)
    assert across is not None
    axis, axis_unit, places, where = across
    order = np.argsort(places, kind="stable")
    name, unit = read_as(path, parts["measured"].unit)
    factor = convert(1.0, parts["measured"].unit, unit)
    values = {key: np.asarray(one.values, dtype=float) * factor for key, one in parts.items()}
    if "at_start" in values:
        axes.plot(places[order], values["at_start"][order], "o--", color=QUIET, mfc="white",
                  lw=0.8, label="computed as written")  # fmt: skip
    whole = result.record.quantities.get(path)
    along = None if whole is None else next((one for one in whole.axes if one.name == axis), None)
    values_of = np.zeros(0) if whole is None else select(whole, where).values
    if along is not None and values_of.shape == (len(along.values),) and along.unit:
        at = np.asarray(along.values, dtype=float) * convert(1.0, along.unit, axis_unit)
        kept = (at >= 0.8 * places.min()) & (at <= 1.2 * places.max())
        axes.plot(at[kept], np.abs(values_of[kept]) * factor, color=COLOURS[0])
        axes.plot(places, values["computed"], "o", ms=3, color=COLOURS[0], label="fitted")
    else:
        axes.plot(places[order], values["computed"][order], "o-", ms=4, color=COLOURS[0],
                  label="fitted")  # fmt: skip
    axes.errorbar(
        places, values["measured"], values["uncertainty"], fmt="x", color=COLOURS[1], capsize=3,
        label="measured, ± standard uncertainty",
    )  # fmt: skip
    axes.set_xlabel(f"{axis} in {axis_unit}" if axis_unit else axis)
    axes.set_ylabel("\n".join(fold(f"{name} in {unit}" if unit else name, 28)))
    axes.legend(**ABOVE)


def _residuals(axes: "Axes", result: Result, residual: Quantity) -> None:
    """Computed less measured over the uncertainty, before and after."""
    places = np.arange(len(residual.values))
    before = having(result.record, PREFIX + "start_residual", "measured_point")
    reach = 1.2 * float(np.max(np.abs(residual.values), initial=4.0))
    if before is not None:
        shown = np.clip(before.values, -0.97 * reach, 0.97 * reach)
        axes.plot(shown, places, "o", color=QUIET, mfc="white", label="computed as written")
        for place, there in enumerate(before.values):
            if abs(there) > reach:
                side = "right" if there > 0.0 else "left"
                note(axes, f"{there:+.3g}", (shown[place], place), (-7 if there > 0.0 else 7, -3),
                     ha=side)  # fmt: skip
    axes.barh(places, residual.values, 0.5, color=COLOURS[0], label="fitted")
    axes.axvspan(-2.0, 2.0, color="#eeeeee", zorder=0)
    axes.set_xlim(-reach, reach)
    names = []
    for label in labels(residual.axes[0]):
        path, _, entry = label.partition(" [")
        words = f"{read_as(path, '')[0]}, {entry.rstrip(']').replace('=', ' ')}"
        names.append("\n".join(fold(words.removesuffix(", "), _NAME)))
    name_rows(axes, names, "computed less measured, over the standard uncertainty")
