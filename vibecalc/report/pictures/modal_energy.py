"""Which freedoms move in which mode of the body: shares of energy as stacked bars."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import along, labels
from vibecalc.report.numbers import hertz, show
from vibecalc.report.pictures.canvas import COLOURS, canvas
from vibecalc.results.record import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PERCENT_WITH_TEXT = 8.0
#: Colours that need dark letters.
_LIGHT = (3, 4, 5)


def picture(result: Result) -> "Figure | None":
    """One bar for each mode, lowest on top; None without modes."""
    quantity = result.record.quantities.get("isolation/modes/energy_fraction")
    if quantity is None or [axis.name for axis in quantity.axes] != ["mode", "coordinate"]:
        return None
    modes, coordinates = (labels(axis) for axis in quantity.axes)
    shares = 100.0 * np.asarray(quantity.values, dtype=float)
    natural = along(result.record, "isolation/modes/natural_frequency", "mode")
    names = [f"mode {mode}" for mode in modes]
    if natural is not None:
        names = [
            f"{name}\n{show(hertz(float(value)), digits=4)} Hz"
            for name, value in zip(names, natural[0].values, strict=True)
        ]
    figure = canvas(result, "modes on the mounts: shares of energy", 8.4, 1.8 + 0.62 * len(modes))
    axes = figure.subplots()
    place = np.arange(len(modes))
    # A share can be negative where coordinates are coupled by the mass: it is stacked leftwards.
    ends = {sign: np.zeros(len(modes)) for sign in (-1.0, 1.0)}
    for j, name in enumerate(coordinates):
        colour = COLOURS[j % len(COLOURS)]
        ink = "black" if j % len(COLOURS) in _LIGHT else "white"
        left = np.where(shares[:, j] < 0.0, ends[-1.0], ends[1.0])
        axes.barh(place, shares[:, j], left=left, color=colour, height=0.72, label=name)
        for i in np.flatnonzero(np.abs(shares[:, j]) >= _PERCENT_WITH_TEXT):
            middle = left[i] + 0.5 * shares[i, j]
            words = f"{name} {shares[i, j]:.0f} %"
            axes.text(middle, float(i), words, ha="center", va="center", color=ink, fontsize=9)
        for sign, end in ends.items():
            end += np.where(sign * shares[:, j] > 0.0, shares[:, j], 0.0)
    axes.set_yticks(place, names)
    axes.invert_yaxis()
    axes.set_xlim(min(0.0, float(ends[-1.0].min())), max(100.0, float(ends[1.0].max())))
    axes.set_xlabel("share of the energy of the mode in %")
    axes.grid(visible=False, axis="y")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 1.12), ncols=6, fontsize=9)
    return figure
