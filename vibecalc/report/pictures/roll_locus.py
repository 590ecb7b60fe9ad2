"""Root locus: the poles of the controlled loop as its gain grows."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import having, table_of
from vibecalc.report.numbers import show
from vibecalc.report.pictures.canvas import COLOURS, LIMIT, QUIET, TOTAL, canvas
from vibecalc.report.sections.roll_control_words import CONTROL, status_words
from vibecalc.results.record import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: poles as far left as this many times the one nearest to the axis decide nothing
_FAR = 1e4


def picture(result: Result) -> "Figure | None":
    """Left the plane of the poles, right how fast they fade over the gain; None without poles.

    What lies to the right of the axis, or above it, grows without a bound. Poles that are all real
    would lie on one line of the plane: then it is left out.
    """
    locus = having(result.record, CONTROL + "locus/pole", "locus_gain", "branch")
    if locus is None:
        return None
    gain = np.asarray(locus.axes[0].values, dtype=float)
    pole = np.where(np.isfinite(np.abs(locus.values)), locus.values, np.nan + 0j)
    asked = table_of(result.case, "response", "control")
    own, words = asked.get("gain"), status_words(result.record, "")
    title = "poles of the loop as the gain grows (reduced model)"
    if isinstance(own, int | float):
        title += f"; with the gain of the case, {show(own, 0, 4)}: {words}"
    found = having(result.record, CONTROL + "pole", "pole")
    at = np.zeros(0, dtype=complex) if found is None else np.asarray(found.values, dtype=complex)
    at = at[np.isfinite(np.abs(at))]
    if np.any(_swings(pole)) or np.any(_swings(at)):
        figure = canvas(result, title, 10.2, 5.4)
        first, fading = figure.subplots(1, 2)
        _plane(first, gain, pole, at)
    else:
        figure = canvas(result, title + "\nall poles are real: nothing swings", 10.2, 5.4)
        first = fading = figure.subplots()
    _fading(fading, gain, pole, own)
    if first is fading and isinstance(own, int | float):
        there = np.full(at.shape, float(own))
        fading.plot(there, at.real, "x", color=COLOURS[1], ms=9, markeredgewidth=2.2, zorder=5,
                    label="gain of the case")  # fmt: skip
    figure.legend(*first.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def _swings(pole: np.ndarray) -> np.ndarray:
    """Which poles are not real."""
    return np.asarray(np.abs(pole.imag) > 1e-9 * np.abs(pole))


def _pairs(pole: np.ndarray) -> np.ndarray:
    """Poles with the conjugate of each that swings, (gains, branches) or (poles,)."""
    swings = _swings(pole)
    other = pole[..., np.any(swings, axis=0)] if pole.ndim > 1 else pole[swings]
    return np.concatenate([pole, np.conj(other)], axis=-1)


def _plane(axes: "Axes", gain: np.ndarray, pole: np.ndarray, at: np.ndarray) -> None:
    from matplotlib.collections import LineCollection
    from matplotlib.colors import LogNorm

    pole, at = _pairs(pole), _pairs(at)
    real, imaginary = pole.real, pole.imag
    linear = _linear(np.abs(pole))
    axes.set_xscale("symlog", linthresh=linear)
    axes.set_yscale("symlog", linthresh=linear)
    norm, lines = LogNorm(gain[0], gain[-1]), None
    for column in range(pole.shape[1]):
        points = np.stack([real[:, column], imaginary[:, column]], axis=-1)
        pieces = np.stack([points[:-1], points[1:]], axis=1)
        lines = LineCollection(list(pieces), cmap="viridis", norm=norm, linewidth=2.6)
        lines.set_array(gain[:-1])
        axes.add_collection(lines)
        axes.plot(*points[0], "o", color=TOTAL, ms=6, markerfacecolor="white",
                  label=f"K = {show(gain[0], 0, 3)}" if column == 0 else None)  # fmt: skip
    if at.size:
        axes.plot(at.real, at.imag, "x", color=COLOURS[1], ms=9, markeredgewidth=2.2, zorder=5,
                  label="gain of the case")  # fmt: skip
    axes.axhline(0.0, color=QUIET, linewidth=0.7)
    low = 3.0 * min(float(np.nanmin(real)), -linear)
    high = max(3.0 * float(np.nanmax(real)), 2.0 * linear)
    tall = max(3.0 * float(np.nanmax(np.abs(imaginary))), 2.0 * linear)
    axes.set_xlim(low, high)
    axes.set_ylim(-tall, tall)
    axes.axvspan(0.0, high, facecolor="#f6dede", edgecolor=LIMIT, hatch="////", linewidth=0.0,
                 zorder=0)  # fmt: skip
    axes.axvline(0.0, color=LIMIT, linewidth=1.2)
    axes.set_xlabel("real part in 1/s; hatched: grows without a bound")
    axes.set_ylabel("imaginary part in 1/s")
    axes.tick_params(axis="x", labelrotation=45)
    if lines is not None:
        axes.figure.colorbar(lines, ax=axes, label="gain K", pad=0.02)


def _linear(sizes: np.ndarray) -> float:
    """A power of ten up to which a scale is linear: below the nearest pole, unless it is far."""
    least, most = float(np.nanmin(sizes)), float(np.nanmax(sizes))
    return float(10.0 ** np.floor(np.log10(max(least, most / _FAR, 1e-12))))


def _fading(axes: "Axes", gain: np.ndarray, pole: np.ndarray, own: object) -> None:
    axes.set_xscale("log")
    linear = _linear(np.abs(pole.real))
    axes.set_yscale("symlog", linthresh=linear)
    for column in range(pole.shape[1]):
        swings = _swings(pole[:, column])
        colour = COLOURS[column % len(COLOURS)]
        real = pole[:, column].real
        axes.plot(gain, real, color=colour, linewidth=1.4)
        axes.plot(gain, np.where(swings, real, np.nan), color=colour, linewidth=3.4, alpha=0.45)
    axes.axhline(0.0, color=LIMIT, linewidth=1.2)
    low, high = axes.get_ylim()
    high = max(high, 2.0 * linear)
    axes.set_ylim(low, high)
    axes.axhspan(0.0, high, facecolor="#f6dede", edgecolor=LIMIT, hatch="////", linewidth=0.0,
                 zorder=0)  # fmt: skip
    if isinstance(own, int | float):
        axes.axvline(float(own), color=COLOURS[1], linestyle=":")
    axes.set_xlim(gain[0], gain[-1])
    axes.set_xlabel("gain K")
    axes.set_ylabel("real part in 1/s (thick: swings)")
