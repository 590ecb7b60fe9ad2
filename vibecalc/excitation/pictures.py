"""Shaking force and couple over a turn; axial force of the motor by order and over a turn."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.report.canvas import (
    COLOURS,
    LIMIT,
    QUIET,
    TOTAL,
    canvas,
    crank_angle_axis,
    mark_angles,
    unit_words,
    waves,
)
from vibecalc.core.report.curves import Curve, Curves, Panel, level
from vibecalc.core.report.sections import having, labels
from vibecalc.core.report.sources import over_turn
from vibecalc.core.report.writing import show
from vibecalc.core.results.record import Quantity, Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.gridspec import GridSpec

# ----------------------------------------------------------------------------
# Shaking force and couple: each direction over the turn, and the path of the vector.
# ----------------------------------------------------------------------------

#: of the largest of all, below which a direction is balanced
_BALANCED = 1e-9
#: crank angles marked on the path, in degrees
_QUARTERS = (0, 90, 180, 270)
#: of the largest, how far the axes of the path reach
_REACH = 1.4


def draw_shaking(result: Result) -> "Figure | None":
    """Force above, couple below, with paths where two directions act; None if all is balanced."""
    found = [having(result.record, f"excitation/{name}", "order", "direction")
             for name in ("force", "couple")]  # fmt: skip
    tops = [0.0 if one is None else float(np.abs(one.values).max(initial=0.0)) for one in found]
    floor = _BALANCED * max(tops)
    rows = [one for one, top in zip(found, tops, strict=True) if one is not None and top > floor]
    if not rows:
        return None
    orders = [f"{order:g}" for order in np.asarray(rows[0].axes[0].values, dtype=float)]
    words = f"orders {orders[0]} to {orders[-1]}" if len(orders) > 1 else f"order {orders[0]}"
    words += ", without the balance weights" * ("balance/after/residual" in result.record)
    figure = canvas(result, f"shaking force and couple over a turn, {words}", 1.0 + 3.3 * len(rows))
    grid = figure.add_gridspec(len(rows), 2, width_ratios=[1.9, 1.0])
    for place, quantity in enumerate(rows):
        _shaking(figure, grid, place, quantity, floor)
    return figure


def _shaking(
    figure: "Figure", grid: "GridSpec", place: int, quantity: Quantity, floor: float
) -> None:
    order = np.asarray(quantity.axes[0].values, dtype=float)
    angle = np.linspace(0.0, 2.0 * np.pi, max(721, 16 * int(order.max()) + 1))
    signal = np.real(np.asarray(quantity.values).T @ waves(order, angle))
    factor, unit = unit_words(quantity.unit, float(np.abs(signal).max()))
    size, degrees = np.abs(signal).max(axis=1), np.degrees(angle)
    acting = np.flatnonzero(size > floor)
    left = figure.add_subplot(grid[place, :] if acting.size < 2 else grid[place, 0])
    names = labels(quantity.axes[1])
    for i in acting:
        top = int(np.argmax(np.abs(signal[i]) > (1.0 - _BALANCED) * size[i]))  # the first
        at = f"{show(factor * signal[i][top], digits=4)} {unit} at {degrees[top]:.0f} deg"
        left.plot(degrees, factor * signal[i], color=COLOURS[i], label=f"{names[i]}: peak {at}")
    left.axhline(0.0, color=QUIET, linewidth=0.8)
    left.set_ylabel(f"{quantity.path.rsplit('/', 1)[-1]} in {unit}")
    left.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0))
    crank_angle_axis(left)
    if acting.size < 2:
        return
    across, up = np.sort(np.argsort(-size)[:2])  # of three, the path is seen along the weakest
    x, y = factor * signal[across], factor * signal[up]
    right = figure.add_subplot(grid[place, 1])
    right.plot(x, y, color=TOTAL)
    right.plot([0.0], [0.0], "+", color=QUIET)
    mark_angles(right, x + 1j * y, degrees, _QUARTERS, LIMIT)
    right.set_aspect("equal", adjustable="box")
    reach = _REACH * max(float(np.abs(x).max()), float(np.abs(y).max()))
    right.set(xlim=(-reach, reach), ylim=(-reach, reach))
    right.locator_params(nbins=4)
    right.set_xlabel(f"{names[across]} in {unit}")
    right.set_ylabel(f"{names[up]} in {unit}")
    right.set_title("path, crank angle in deg", fontsize=8)


# ----------------------------------------------------------------------------
# Axial force of the motor's skewed conductors: amplitude by order, and over one turn.
# ----------------------------------------------------------------------------

_FOLDER = "excitation/motor/"
_FORCE = _FOLDER + "axial_force"

_BOUND = "sum of amplitudes (bound) {}"
_IN_TIME = (
    Curve(over_turn(_FORCE), "force, mean apart", {"color": TOTAL}),
    level(_FOLDER + "sum_of_amplitudes", _BOUND, True, color=LIMIT),
    level(_FOLDER + "peak", "peak {}", True, color=COLOURS[1]),
    level(_FOLDER + "rms", "rms {}", True, color=COLOURS[2]),
)
MOTOR_FORCE = Curves(
    "axial force of the motor's skewed conductors",
    (Panel("amplitude", (Curve(_FORCE, bars=True),)), Panel("force", _IN_TIME)),
    high=2.65,
    names=2,
)

# ----------------------------------------------------------------------------
# With slave rods: the force of each order, parted by the sense in which it turns.
# ----------------------------------------------------------------------------

_BARS = (Curve("excitation/turning/with_crank", "with the crank", bars=True),
         Curve("excitation/turning/against_crank", "against the crank", bars=True))  # fmt: skip
TURNING_FORCE = Curves(
    "forces that turn with the crank and against it, by order", (Panel("force", _BARS),)
)
