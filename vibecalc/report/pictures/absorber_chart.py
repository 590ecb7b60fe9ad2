"""Design chart: best stiffness, damping and peak over mass ratio and primary damping."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import having
from vibecalc.report.numbers import show
from vibecalc.report.pictures.canvas import canvas
from vibecalc.report.pictures.scales import plain_ticks
from vibecalc.results.record import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ROOT = "tuning/chart/"
_OVER = ("primary_damping", "mass_ratio")
_MASS, _STIFF = "mass ratio $J_2 / J_1$", "best stiffness ratio $K_2 / K_1$"
_OWN = r"best damping $\varepsilon_2 = c_2 / (2 J_2 \omega_2)$"
_PEAK = "least peak"


def picture(result: Result) -> "Figure | None":
    """Peak, stiffness and damping over the mass ratio, and over each other; a colour for z1."""
    found = {
        name: having(result.record, _ROOT + name, *_OVER)
        for name in ("peak", "stiffness_ratio", "own_damping")
    }
    peak, stiff, own = found["peak"], found["stiffness_ratio"], found["own_damping"]
    if peak is None or stiff is None or own is None:
        return None
    from matplotlib import colormaps

    figure = canvas(result, "best tuning, one colour for each damping of the primary", 11.0, 8.4)
    panels = figure.subplots(2, 3)
    damping, mass = (np.asarray(axis.values, dtype=float) for axis in peak.axes)
    tints = colormaps["viridis"](np.linspace(0.0, 0.92, len(damping)))
    for row, (value, tint) in enumerate(zip(damping, tints, strict=True)):
        top, k, z = (np.asarray(part.values, dtype=float)[row] for part in (peak, stiff, own))
        helped = (k > 0.0) | (z > 0.0)
        k, z = np.where(helped, k, np.nan), np.where(z > 0.0, z, np.nan)
        label = show(float(value), digits=2)
        pairs = ((mass, top), (mass, k), (mass, z), (z, top), (k, top), (k, z))
        for axes, (x, y) in zip(panels.flat, pairs, strict=True):
            axes.plot(x, y, color=tint, label=label if axes is panels.flat[0] else None)
    names = ((_MASS, _PEAK), (_MASS, _STIFF), (_MASS, _OWN), (_OWN, _PEAK), (_STIFF, _PEAK),
             (_STIFF, _OWN))  # fmt: skip
    for axes, (across, up) in zip(panels.flat, names, strict=True):
        _dress(axes, across, up, mass)
    figure.legend(title="damping of the primary", loc="outside lower center", ncols=10, fontsize=9)
    return figure


def _dress(axes: "Axes", across: str, up: str, mass: np.ndarray) -> None:
    axes.set_xlabel(across)
    axes.set_ylabel(up)
    if up == _PEAK:
        axes.set_yscale("log")
        plain_ticks(axes.yaxis)
    if across == _MASS and mass[-1] > 4.0 * mass[0]:
        axes.set_xscale("log")
        plain_ticks(axes.xaxis)
