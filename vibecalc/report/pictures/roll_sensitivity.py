"""What more and less of each parameter do to each harmonic of the shell: a map of the changes."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.pictures.canvas import QUIET, canvas
from vibecalc.report.sections.roll_advice import PERCENT, Changes, changes
from vibecalc.results.record import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: fields with more entries than these bear no numbers
_NUMBERED = 16
#: dB; a smaller effect is a blank field
_WORTH = 0.005
#: dB; larger ones have the deepest colour, lest one of them pale all the others
_DEEPEST = 3.0
#: red where the harmonic gets louder
_COLOURS = "RdBu_r"
#: beyond this share of the scale letters are white
_DARK = 0.5


def picture(result: Result) -> "Figure | None":
    """Parameters down, orders across, dB for ten percent more above, for ten percent less below.

    An order that the shell does not have is hatched: its level has no change in dB. None without
    such changes.
    """
    found = changes(result)
    if found is None or not found.orders.size:
        return None
    # what does most stands on top
    size = np.max(np.abs(np.nan_to_num(found.values)), axis=(0, 2), initial=0.0)
    rank = np.argsort(-size, kind="stable")
    effect = found.values[:, rank]
    words = f"change of the shell's levels with {PERCENT} % more and {PERCENT} % less"
    figure = canvas(result, words, 9.0, 2.6 + 0.62 * max(len(rank), 2))
    panels = figure.subplots(2, 1)
    largest = float(np.max(size, initial=0.0)) or 1.0
    scale = min(largest, _DEEPEST)
    for axes, part, word in zip(panels, effect, ("more", "less"), strict=True):
        image = axes.imshow(part, cmap=_COLOURS, vmin=-scale, vmax=scale, aspect="auto")
        axes.set_title(f"{PERCENT} % {word}", fontsize=10)
        axes.set_xticks(range(len(found.orders)), [str(int(order)) for order in found.orders])
        axes.set_yticks(range(len(rank)), [found.words[i] for i in rank])
        axes.grid(visible=False)
        axes.tick_params(length=0)
        for spine in axes.spines.values():
            spine.set_visible(False)
        _fields(axes, part, found, scale)
    panels[1].set_xlabel("order, multiple of the crank speed")
    figure.colorbar(
        image,
        ax=list(panels),
        label="dB; blue: quieter",
        pad=0.02,
        extend="both" if largest > scale else "neither",
    )
    return figure


def _fields(axes: "Axes", effect: np.ndarray, found: Changes, scale: float) -> None:
    """Numbers where there is room, and hatches over orders that are zero."""
    for j in np.flatnonzero(~found.acts):
        axes.axvspan(
            j - 0.5, j + 0.5, facecolor="#f2f2f2", edgecolor=QUIET, hatch="///", linewidth=0.0
        )
    for i in np.flatnonzero(np.isnan(effect).all(axis=1)):
        middle = 0.5 * (effect.shape[1] - 1)
        axes.text(middle, float(i), "no running state", ha="center", va="center", fontsize=8)
    if len(found.orders) > _NUMBERED:
        return
    for (i, j), value in np.ndenumerate(effect):
        if abs(value) >= _WORTH:
            colour = "white" if abs(value) > _DARK * scale else "black"
            axes.text(j, i, f"{value:+.2f}", ha="center", va="center", fontsize=8, color=colour)
