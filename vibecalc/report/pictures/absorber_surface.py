"""Response over the frequency and a ratio that varies: the surface from above, and its ridge."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import having, labels
from vibecalc.report.pictures.canvas import COLOURS, canvas
from vibecalc.report.pictures.scales import plain_ticks
from vibecalc.report.sections.absorber import ABSORBER
from vibecalc.results.record import Quantity, Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: fewer curves are told apart as curves
FEWEST = 10
#: decades of the amplitude that are told apart
_DECADES = (-1.0, 1.5)
#: decades of the axis from which on plain numbers would not fit below it
_WIDE = 1.5


def varied(curve: Quantity) -> tuple[str, np.ndarray, np.ndarray]:
    """Words of the ratio that varies, its values, and the places of these curves, ascending."""
    found = []
    for place, name in enumerate(labels(curve.axes[0])):
        words, _, number = name.rpartition(" ")
        if words and words != "as":
            found.append((float(number), place, words))
    found.sort()
    values, places = (np.array([row[i] for row in found]) for i in range(2))
    return (found[0][2] if found else ""), values, places.astype(int)


def picture(result: Result) -> "Figure | None":
    """Amplitude as colour; beside it the largest one over the ratio, on the same axis."""
    curve = having(result.record, ABSORBER + "curve", "curve", "frequency_ratio")
    largest = having(result.record, ABSORBER + "largest", "curve")
    if curve is None or largest is None:
        return None
    words, values, places = varied(curve)
    if len(values) < FEWEST:
        return None
    figure = canvas(result, f"response over frequency and {words}", 10.0, 5.6)
    left, right = figure.subplots(1, 2, sharey=True, width_ratios=[2.4, 1.0])
    x = np.asarray(curve.axes[1].values, dtype=float)
    size = np.abs(np.asarray(curve.values))[places]
    shown = np.log10(np.clip(np.where(np.isfinite(size), size, 1e9), 1e-9, 1e9))
    mesh = left.pcolormesh(
        x, values, shown, cmap="viridis", vmin=_DECADES[0], vmax=_DECADES[1], shading="nearest"
    )
    bar = figure.colorbar(mesh, ax=left, location="bottom", aspect=40, extend="both")
    marks = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)
    bar.set_ticks([float(np.log10(mark)) for mark in marks], labels=[f"{m:g}" for m in marks])
    bar.set_label("amplitude ratio")
    tops = np.asarray(largest.values, dtype=float)[places]
    right.plot(np.where(np.isfinite(tops), tops, np.nan), values, ".-", color=COLOURS[1])
    right.set_xscale("log")
    if np.ptp(np.log10(tops[np.isfinite(tops)])) < _WIDE:
        plain_ticks(right.xaxis)
    right.set_xlabel("largest response")
    right.set_ylabel(words)
    right.tick_params(labelleft=True)
    left.set_xlabel("frequency over the primary's own")
    left.set_ylabel(words)
    left.grid(visible=False)
    return figure
