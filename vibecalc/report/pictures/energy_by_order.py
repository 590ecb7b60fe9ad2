"""Kinetic and potential energy of each order alone, over as many decades as there are."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.report.lookup import having
from vibecalc.report.pictures.canvas import COLOURS, QUIET, canvas
from vibecalc.report.sections.response_energies import SMALLEST, last_normal
from vibecalc.results.record import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_KINDS = ("kinetic", "potential")


def picture(result: Result) -> "Figure | None":
    """Bars of the largest energy against order; None without energies by order above zero.

    The axis is in powers of ten by hand: bars of a logarithmic axis stop before 1e-308.
    """
    found: list[tuple[str, np.ndarray, np.ndarray, str]] = []
    for kind in _KINDS:
        quantity = having(result.record, f"response/{kind}_energy/peak_by_order", "order")
        if quantity is not None and np.any(quantity.values >= SMALLEST):
            orders = np.asarray(quantity.axes[0].values)
            found.append((kind, orders, np.asarray(quantity.values, dtype=float), quantity.unit))
    if not found:
        return None
    figure = canvas(result, "largest energy of each order alone", 8.6, 5.2)
    axes = figure.subplots()
    lowest = min(float(np.log10(values[values >= SMALLEST]).min()) for _, _, values, _ in found)
    highest = max(float(np.log10(values.max())) for _, _, values, _ in found)
    ends = [last_normal(values) for _, _, values, _ in found]
    underflows = any(ended for _, ended in ends)
    floor = float(np.log10(SMALLEST)) if underflows else lowest - 0.06 * max(highest - lowest, 3.0)
    width = 0.8 / len(found)
    for i, (kind, orders, values, _) in enumerate(found):
        acting = values >= SMALLEST
        heights = np.log10(values[acting]) - floor
        place = orders[acting] + (i - 0.5 * (len(found) - 1)) * width
        axes.bar(place, heights, width, bottom=floor, color=COLOURS[i], label=kind)
    last = max(int(orders[-1]) for _, orders, _, _ in found)
    axes.set_xlim(0.3, last + 0.7)
    axes.set_ylim(floor, highest + 0.08 * (highest - floor))
    _ticks(axes)
    axes.set_xlabel("order")
    axes.set_ylabel(f"energy in {found[0][3]}")
    axes.grid(visible=False, axis="x")
    axes.legend(loc="upper right", fontsize=9)
    if underflows:
        gone = max(int(found[i][1][end]) for i, (end, _) in enumerate(ends) if end >= 0)
        _underflow(axes, gone, last)
    return figure


def _ticks(axes: "Axes") -> None:
    """Whole orders below; beside them powers of ten, written as a logarithmic axis has them."""
    from matplotlib.ticker import FuncFormatter, MaxNLocator

    axes.xaxis.set_major_locator(MaxNLocator(nbins=10, integer=True))

    def power(value: Any, _: Any) -> str:
        return f"$10^{{{value:.0f}}}$"

    axes.yaxis.set_major_locator(MaxNLocator(nbins=9, integer=True))
    axes.yaxis.set_major_formatter(FuncFormatter(power))


def _underflow(axes: "Axes", gone: int, last: int) -> None:
    axes.axvspan(gone + 0.5, last + 0.7, color="#eeeeee", zorder=0)
    axes.annotate(
        f"beyond order {gone} below the smallest double: 0",
        (0.5 * (gone + last + 1.2), 0.5),
        xycoords=axes.get_xaxis_transform(),
        rotation=90,
        ha="center",
        va="center",
        fontsize=9,
        color=QUIET,
    )
