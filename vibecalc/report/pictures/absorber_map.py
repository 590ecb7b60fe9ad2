"""Largest response over stiffness and damping of the absorber, around the optimum."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import having, scalar_of
from vibecalc.report.numbers import show
from vibecalc.report.pictures.canvas import COLOURS, LIMIT, TOTAL, canvas
from vibecalc.report.pictures.scales import plain_ticks
from vibecalc.results.record import Record, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import FuncNorm
    from matplotlib.figure import Figure

_SHARES = (0.01, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.5)
#: so many of them are named: the others lie on dark ground
_NAMED = 6
_MARKS = ("s", "D", "^", "v")


def picture(result: Result) -> "Figure | None":
    """Contours by how far the peak is above the best one; optimum, other methods, stock pairs."""
    record = result.record
    found = having(record, "tuning/map/peak", "stiffness_ratio", "secondary_damping")
    best = scalar_of(record, "tuning/peak")
    if found is None or best is None or not np.isfinite(best):
        return None
    free = scalar_of(record, "tuning/unbounded/peak")
    figure = canvas(result, "largest response over spring and damper", 8.6, 6.2)
    axes = figure.subplots()
    k, z2 = (np.asarray(axis.values, dtype=float) for axis in found.axes)
    above = np.asarray(found.values, dtype=float).T / best - 1.0
    # beyond the bounds of a case there may be better ones
    above = np.where(np.isfinite(above), np.maximum(above, 0.0), 10.0 * _SHARES[-1])
    axes.contourf(k, z2, above, levels=[0.0, *_SHARES, 1e9], cmap="Blues", norm=_norm())
    axes.contour(k, z2, above, levels=_SHARES[_NAMED:], colors="white", linewidths=0.9)
    lines = axes.contour(k, z2, above, levels=_SHARES[:_NAMED], colors="white", linewidths=0.9)
    axes.clabel(lines, fmt=lambda value: f"+{100.0 * value:.3g} %", fontsize=8, colors=TOTAL)
    _methods(axes, record)
    _stock(axes, record, (k[0], k[-1]), (z2[0], z2[-1]))
    axes.plot(
        [float(record["tuning/stiffness_ratio"].values)],
        [float(record["tuning/secondary_damping"].values)],
        "*", color=LIMIT, ms=15, zorder=6,
        label=f"optimum{'' if free is None else ' within the bounds'}, peak {show(best, digits=4)}",
    )  # fmt: skip
    if free is not None:
        axes.plot(
            [float(record["tuning/unbounded/stiffness_ratio"].values)],
            [float(record["tuning/unbounded/secondary_damping"].values)],
            "*", color=LIMIT, ms=12, markerfacecolor="none", zorder=6, label="without the bounds",
        )  # fmt: skip
    axes.set_yscale("log")
    plain_ticks(axes.yaxis)
    axes.set_xlim(k[0], k[-1])
    axes.set_ylim(z2[0], z2[-1])
    axes.grid(visible=False)
    axes.set_xlabel("stiffness ratio $K_2 / K_1$")
    axes.set_ylabel(r"damping $c_2 / (2 \sqrt{K_1 J_1})$")
    figure.legend(loc="outside lower center", ncols=3, fontsize=9)
    return figure


def _norm() -> "FuncNorm":
    from matplotlib.colors import FuncNorm

    return FuncNorm((np.sqrt, np.square), vmin=0.0, vmax=4.0)


def _methods(axes: "Axes", record: Record) -> None:
    k = having(record, "tuning/method/stiffness_ratio", "method")
    z2 = having(record, "tuning/method/secondary_damping", "method")
    if k is None or z2 is None:
        return
    others = [(n, x, y) for n, x, y in zip(k.axes[0].values, k.values, z2.values, strict=True)
              if n != "numerical"]  # fmt: skip
    for place, (name, x, y) in enumerate(others):
        axes.plot(
            [x], [y], _MARKS[place % 4], color=COLOURS[(place + 1) % 6], ms=7 + 3 * place,
            label=str(name).replace("_", " "), zorder=5, markerfacecolor="none",
            markeredgewidth=1.6,
        )  # fmt: skip


def _stock(
    axes: "Axes", record: Record, across: tuple[float, float], along: tuple[float, float]
) -> None:
    """Pairs of stock parts that lie on the map."""
    k = having(record, "hardware/spring/stiffness_ratio", "stock_spring")
    z2 = having(record, "hardware/oil/secondary_damping", "stock_oil")
    if k is None or z2 is None:
        return
    x, y = (part.ravel() for part in np.meshgrid(k.values, z2.values))
    there = (across[0] < x) & (x < across[1]) & (along[0] < y) & (y < along[1])
    if np.any(there):
        axes.plot(x[there], y[there], ".", color=COLOURS[4], ms=10, label="pairs in stock",
                  markeredgecolor=TOTAL, markeredgewidth=0.5)  # fmt: skip
