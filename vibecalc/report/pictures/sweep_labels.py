"""Names of many lines at their right ends, shifted apart where the lines come close."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.report.pictures.canvas import COLOURS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: least distance of two names, as a share of the height of a panel
_APART = 0.042
#: after each round of colours another line
_STYLES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (1, 1.4)))


def line_style(place: int) -> dict[str, Any]:
    """Colour and dashes of the line with this number; 18 lines differ."""
    return {
        "color": COLOURS[place % len(COLOURS)],
        "ls": _STYLES[place // len(COLOURS) % len(_STYLES)],
    }


def name_ends(axes: "Axes", x: np.ndarray, drawn: np.ndarray, names: tuple[str, ...]) -> None:
    """Names behind the last finite value of each line (points, lines), in the order of these.

    The scale of the panel must be final.
    """
    found: list[tuple[float, int, float]] = []
    for i in range(drawn.shape[1]):
        finite = np.flatnonzero(np.isfinite(drawn[:, i]))
        if finite.size:
            end = finite[-1]
            pixel = axes.transData.transform((x[end], drawn[end, i]))
            found.append((float(axes.transAxes.inverted().transform(pixel)[1]), i, x[end]))
    found.sort()
    heights = spread_out(np.array([height for height, _, _ in found]), _APART)
    for height, (_, i, end) in zip(heights, found, strict=True):
        axes.annotate(names[i].split("=")[-1], (end, height), xytext=(5, 0),
                      xycoords=("data", "axes fraction"), textcoords="offset points",
                      va="center", color=line_style(i)["color"], fontsize=9,
                      annotation_clip=False)  # fmt: skip


def spread_out(places: np.ndarray, apart: float) -> np.ndarray:
    """Ascending places moved as little as need be (in squares) to be so far apart."""
    # with the distances taken off, what is left need only ascend: means of pools that do not
    steps = apart * np.arange(len(places))
    pools: list[tuple[float, int]] = []
    for value in places - steps:
        mean, count = float(value), 1
        while pools and pools[-1][0] > mean:
            other, many = pools.pop()
            mean = (mean * count + other * many) / (count + many)
            count += many
        pools.append((mean, count))
    flat = [mean for mean, count in pools for _ in range(count)]
    return np.asarray(np.array(flat) + steps)
