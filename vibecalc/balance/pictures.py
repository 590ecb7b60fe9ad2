"""Residual by order without and with the weights; the weights as vectors around their shafts."""

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.balance.report import axis_of
from vibecalc.balance.results import WeightsFound
from vibecalc.core.report.canvas import COLOURS, QUIET, TOTAL, canvas, palette, unit_words
from vibecalc.core.report.curves import Curve, Curves, Panel
from vibecalc.core.report.sections import by_size, having, labels, scalar_of
from vibecalc.core.report.writing import read, show
from vibecalc.core.results.record import Quantity, Result
from vibecalc.units import convert

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# By order, without the weights and with them.
# ----------------------------------------------------------------------------


#: what force and residual differ by at most that are the same
_ALIKE = 1e-9
_TIMES = {"before": ("without", QUIET), "after": ("with", COLOURS[0])}


def _acting(name: str, when: str) -> Callable[[Result], Quantity | None]:
    """A size by order, rounding as the zero that it is; none where it is zero before and after."""

    def made(result: Result) -> Quantity | None:
        both = {one: having(result.record, f"balance/{one}/{name}", "order") for one in _TIMES}
        if all(one is None or np.all(one.zero) for one in both.values()):
            return None
        found = both[when]
        return found and replace(found, values=np.where(found.zero, 0.0, found.values))

    return made


def _title(result: Result) -> str:
    """With the residual of all orders, without the weights and with them."""
    both = (scalar_of(result.record, f"balance/{when}/all_orders") for when in _TIMES)
    sizes = [size for size in both if size is not None]
    factor, unit = unit_words("N", max(sizes, default=0.0))
    listed = " and ".join(f"{show(factor * size, digits=4)} {unit}" for size in sizes)
    words = "without and with the weights, by order"
    return f"{words}; residual unbalance of all orders: {listed}" if sizes else words


_LABELS = {"force": "force", "couple": "couple", "residual": "residual unbalance"}


def _residual(result: Result) -> Quantity | None:
    """The weighted residual, none where it is the force alone."""
    residual, force = (_acting(name, "before")(result) for name in ("residual", "force"))
    if residual is None or force is None:
        return residual
    return None if np.allclose(residual.values, force.values, rtol=_ALIKE) else residual


def _before_and_after(name: str) -> Panel:
    bars = [Curve(_acting(name, when), f"{how} the weights", {"color": colour}, bars=True)
            for when, (how, colour) in _TIMES.items()]  # fmt: skip
    return Panel(_LABELS[name], tuple(bars), needs=(_residual,) * (name == "residual"))


BALANCE_ORDERS = Curves(_title, tuple(map(_before_and_after, _LABELS)), high=2.3)

# ----------------------------------------------------------------------------
# Weights as vectors at crank angle zero: a disc for each speed ratio.
# ----------------------------------------------------------------------------

_WORDS = {1: "crank speed", -1: "crank speed, reverse", 2: "twice crank speed",
          -2: "twice crank speed, reverse"}  # fmt: skip


def draw_weights(result: Result) -> "Figure | None":
    """Unbalances over their angle from the stroke; None where all are zero."""
    from matplotlib.ticker import MaxNLocator

    record = result.record
    unbalance = having(record, f"{WeightsFound.ROOT}/unbalance", "weight")
    if unbalance is None or not np.any(unbalance.values):
        return None
    unit = by_size("g*mm", unbalance.values)
    size = convert(1.0, "kg*m", unit) * np.asarray(unbalance.values, dtype=float)
    phase, position, ratio = (
        record[f"{WeightsFound.ROOT}/{name}"].values
        for name in ("phase", "position", "speed_ratio")
    )
    names, along = labels(unbalance.axes[0]), axis_of(result)
    ratios = [one for one in _WORDS if np.any((ratio == one) & (size > 0.0))]
    words = f"balance weights at crank angle zero, unbalance in {read(unit)}"
    figure = canvas(result, words, 0.6 + 2.6 * len(ratios))
    for place, one in enumerate(ratios):
        axes = figure.add_subplot(len(ratios), 1, place + 1, projection="polar")
        mine = np.flatnonzero((ratio == one) & (size > 0.0))
        for k, i in enumerate(mine):
            colour, dashes = palette(k)
            words = f"{names[i]}: {show(size[i])} at {show(1e3 * position[i, along], 1e-9)} mm"
            axes.plot([phase[i], phase[i]], [0.0, size[i]], dashes, color=colour, linewidth=2.0)
            axes.plot([phase[i]], [size[i]], "o", color=colour, label=words)
        together = np.sum(size[mine] * np.exp(1j * phase[mine]))
        if mine.size > 1 and abs(together) > 1e-9 * size[mine].sum():
            axes.plot([np.angle(together)], [abs(together)], "+", color=TOTAL, label="sum")
        # the numbers of the circles where no weight is near
        turned, around = np.degrees(phase[mine]), np.arange(0.0, 360.0, 7.5)
        apart = np.abs((np.subtract.outer(around, turned) + 180.0) % 360.0 - 180.0).min(axis=1)
        axes.set(theta_zero_location="N", rlabel_position=around[np.argmax(apart)],
                 ylim=(0.0, 1.15 * max(size[mine])))  # fmt: skip
        axes.yaxis.set_major_locator(MaxNLocator(2, steps=[1, 2, 5, 10], prune="lower"))
        axes.tick_params(labelsize=7)
        axes.legend(
            loc="upper left", bbox_to_anchor=(1.15, 1.0), fontsize=7,
            title=f"{one:+d}: {_WORDS[one]}", title_fontsize=8,
        )  # fmt: skip
    return figure
