"""Marks of a run-up: orders on natural frequencies, speeds left out, where the axis begins."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.pictures.canvas import QUIET, natural_frequencies
from vibecalc.results.record import Record

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_ORDERS = (1, 2)
#: Ratio of frequencies below which two marks have no room for words of their own.
_CLOSE = 1.18


def resonances(record: Record, axes: "Axes", speed: np.ndarray) -> None:
    """Dotted lines where an order meets a mode; lines of one order that lie close share words."""
    frequencies = natural_frequencies(record)
    for order in _ORDERS:
        groups: list[list[int]] = []
        for mode, natural in enumerate(frequencies):
            at = natural / order
            if not speed.min() < at < speed.max():
                continue
            axes.axvline(at, color=QUIET, linestyle=":", linewidth=1.0, zorder=0)
            if groups and natural < _CLOSE * frequencies[groups[-1][0]]:
                groups[-1].append(mode)
            else:
                groups.append([mode])
        for group in groups:
            axes.annotate(
                f"order {order}" + (_modes(group) if len(frequencies) > 1 else ""),
                (frequencies[group[0]] / order, 0.98),
                xycoords=axes.get_xaxis_transform(),
                xytext=(-2, 0),
                textcoords="offset points",
                rotation=90,
                ha="right",
                va="top",
                fontsize=8,
                color=QUIET,
                zorder=1,
            )


def _modes(group: list[int]) -> str:
    first, last = group[0] + 1, group[-1] + 1
    if first == last:
        return f", mode {first}"
    return f", modes {first}" + (f", {last}" if last == first + 1 else f" to {last}")


def lowest(record: Record, speed: np.ndarray) -> float:
    """Where the logarithmic axis begins: well below the first order resonance."""
    first = min(natural_frequencies(record), default=float(speed.max())) / max(_ORDERS)
    return max(float(speed.min()), 0.25 * min(float(first), float(speed.max())))


def unbounded(record: Record) -> bool:
    """Whether speeds were left out because the forces have no bound there."""
    low = record.quantities.get("isolation/masked/low")
    return low is not None and low.values.size > 0


def window(
    speed: np.ndarray, values: np.ndarray, shown: tuple[float, float], bounds: list[float]
) -> tuple[float, float]:
    """Ends of a logarithmic force axis: decades around what is usual between the resonances.

    The samples crowd at the resonances, so the usual force is the median over evenly spaced
    (logarithmic) speeds within `shown`, of the largest curve.
    """
    largest = np.atleast_2d(values).max(axis=0)
    places = np.geomspace(*shown, 400)
    usual = np.interp(places, speed, np.where(np.isfinite(largest), largest, 0.0))
    middle = float(np.median(usual[usual > 0.0])) if np.any(usual > 0.0) else 1.0
    return 1e-2 * middle, max([1e3 * middle, *(3.0 * bound for bound in bounds)])


def masked(record: Record, axes: "Axes") -> None:
    """Shade the intervals of speed that were left out."""
    low, high = (record.quantities.get(f"isolation/masked/{end}") for end in ("low", "high"))
    if low is None or high is None:
        return
    for start, stop in zip(np.atleast_1d(low.values), np.atleast_1d(high.values), strict=True):
        axes.axvspan(float(start), float(stop), color="#f3c6cc", linewidth=1.0)
