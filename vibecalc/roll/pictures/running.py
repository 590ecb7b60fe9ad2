"""Pictures of the running state: one turn, levels by order, what changes them."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.report.canvas import COLOURS, LIMIT, QUIET, TOTAL, canvas, crank_angle_axis, note
from vibecalc.core.report.curves import Curve, Curves, Panel, Plot
from vibecalc.core.report.sections import along, having, scalar_of, table_of
from vibecalc.core.report.sources import Ends, Look
from vibecalc.core.report.writing import ZERO, rpm, show
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.roll.pictures.motor import MotorCurve, ends, headroom, motor_curve, rpm_of, zeros_of
from vibecalc.roll.report.advice import PERCENT, ROLL, Changes, changes, shell_acts

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# One turn of the machine: torque, speed and slip, and the way along the curve of the motor.
# ----------------------------------------------------------------------------

_CYCLE = ROLL + "cycle/"
_ORBIT = COLOURS[1]
#: columns of three and of two panels
_MOSAIC: list[Any] = [
    ["torque", "curve"],
    ["torque", "curve"],
    ["speed", "curve"],
    ["speed", "part"],
    ["slip", "part"],
    ["slip", "part"],
]
#: torque of the gas acts against the motor's: what it demands is the negative one
_TORQUES = (
    ("gas_torque", "gas torque demand", -1.0, COLOURS[5]),
    ("motor_torque", "motor", 1.0, _ORBIT),
)


def draw_roll_cycle(result: Result) -> "Figure | None":
    """Courses over the crank angle at the left, torque over slip at the right; None without both.

    At the right above is the whole curve of the motor, below the part of it on which it runs.
    """
    record = result.record
    torque, speed, slip = (
        along(record, _CYCLE + name, "crank_angle")
        for name in ("motor_torque", "crank_speed", "slip")
    )
    if torque is None or speed is None or slip is None:
        return None
    figure = canvas(result, "one turn, and its range on the motor curve", 7.2)
    panels = figure.subplot_mosaic(_MOSAIC)
    motor = table_of(result.case, "machine", "motor")
    _torques(panels["torque"], record)
    _speed(panels["speed"], record, *speed, motor)
    panels["slip"].plot(np.degrees(slip[1]), rpm_of(slip[0].values), color=COLOURS[2])
    panels["slip"].axhline(0.0, color=QUIET, linewidth=0.7)
    panels["slip"].set_ylabel("slip in rpm")
    for name in ("torque", "speed", "slip"):
        crank_angle_axis(panels[name])
        panels[name].set_xticks(range(0, 361, 90))
        if name != "slip":
            panels[name].set_xlabel("")
            panels[name].tick_params(labelbottom=False)
    slips = rpm_of(slip[0].values)
    torques = np.asarray(torque[0].values, dtype=float)
    curve = motor_curve(motor, slips)
    fitted = [scalar_of(record, f"response/roll/motor/breakdown_{w}") for w in ("slip", "torque")]
    if curve is not None and fitted[0] is not None and fitted[1] is not None:
        # a motor with fluxes has the peak of its fit, not that of the table
        curve = curve._replace(breakdown=(rpm(fitted[0]), fitted[1]))
    for name in ("curve", "part"):
        _curve(panels[name], curve, slips, torques, whole=name == "curve")
    panels["curve"].legend(loc="lower right")
    panels["part"].set_xlabel("slip in rpm")
    return figure


def _torques(axes: "Axes", record: Record) -> None:
    for name, words, sign, colour in _TORQUES:
        hit = along(record, _CYCLE + name, "crank_angle")
        if hit is not None:
            values = sign * np.asarray(hit[0].values)
            axes.plot(np.degrees(hit[1]), values, color=colour, label=words)
    axes.axhline(0.0, color=QUIET, linewidth=0.7)
    axes.set_ylabel("torque in N m")
    headroom(axes, 0.75)
    axes.legend(loc="upper left")


def _speed(
    axes: "Axes", record: Record, quantity: Quantity, angle: np.ndarray, motor: Mapping[str, Any]
) -> None:
    values = rpm_of(quantity.values)
    axes.plot(np.degrees(angle), values, color=COLOURS[0], label="crank relative to shell")
    mean = scalar_of(record, ROLL + "speed")
    if mean is not None:
        words = f"mean {show(rpm(mean), digits=5)} rpm"
        axes.axhline(rpm(mean), color=TOTAL, linewidth=1.0, linestyle="--", label=words)
    synchronous = motor.get("synchronous_speed")
    if isinstance(synchronous, int | float):
        words = f"synchronous {show(rpm(float(synchronous)), digits=5)} rpm"
        axes.axhline(rpm(synchronous), color=LIMIT, linewidth=1.0, linestyle=":", label=words)
    axes.set_ylabel("speed in rpm")
    headroom(axes, 1.2)
    axes.legend(loc="upper left")


def _curve(
    axes: "Axes", curve: MotorCurve | None, slip: np.ndarray, torque: np.ndarray, *, whole: bool
) -> None:
    """The motor's curve with the way of a turn along it: all of it, or the part that is used."""
    left, right, low, high = (*ends(slip, room=0.08), *ends(torque, room=0.08))
    if curve is not None:
        if whole:
            left, right = min(left, curve.slip[0]), max(right, curve.slip[-1])
        inside = (curve.slip >= left) & (curve.slip <= right)
        words = "motor curve"
        axes.plot(curve.slip[inside], curve.torque[inside], color=QUIET, linewidth=1.2, label=words)
        kept = (curve.node_slip >= left) & (curve.node_slip <= right)
        nodes, heights = curve.node_slip[kept], curve.node_torque[kept]
        if nodes.size:
            axes.plot(nodes, heights, "o", color=TOTAL, ms=4.5, label="table", zorder=4)
        if whole:
            low = min(low, float(curve.torque[inside].min()))
            high = max(high, float(curve.torque[inside].max()))
    axes.plot(slip, torque, color=_ORBIT, linewidth=3.0, alpha=0.8, label="one turn", zorder=3)
    if curve is not None and curve.breakdown is not None and whole:
        _breakdown(axes, *curve.breakdown)
    zeros_of(axes, whole=whole)
    axes.set_xlim(left, right)
    room = 0.08 * (high - low)
    axes.set_ylim(low - room, high + (2.0 if whole else 1.0) * room)


def _breakdown(axes: "Axes", slip: float, torque: float) -> None:
    axes.plot([slip], [torque], "*", color=LIMIT, ms=12, zorder=5)
    note(axes, f"breakdown {show(torque, digits=4)} N m\nat {show(slip, digits=4)} rpm",
        (slip, torque), (8, -4), color=LIMIT, va="bottom")  # fmt: skip


# ----------------------------------------------------------------------------
# Levels of the shell's acceleration by order: computed, published and measured.
# ----------------------------------------------------------------------------

_PATH = ROLL + "level/shell_acceleration"
#: how far published and measured levels stand next to an order
_APART = 0.22
#: more orders than these get no mark of their own on the axis
_MARKED = 24


def _levels(result: Result) -> Quantity | None:
    """Levels of the orders that swing; of what is zero by symmetry there is none."""
    level = having(result.record, _PATH, "order")
    if level is None:
        return None
    acts = shell_acts(result.record, level.axes[0].values)
    return replace(level, values=np.where(acts, np.asarray(level.values, dtype=float), np.nan))


def _whiskers(plot: Plot) -> None:
    """From the lowest to the highest level with any way to read the gas tables."""
    level = having(plot.result.record, ROLL + "interpolation/level", "interpolant", "order")
    orders, values = plot.drawn[0]
    if level is None:
        return
    known = np.asarray(level.axes[1].values)
    places = np.flatnonzero(np.isin(known, orders[np.isfinite(values)]))
    found = np.asarray(level.values, dtype=float)[:, places]
    if places.size:
        middle, reach = 0.5 * (found.min(axis=0) + found.max(axis=0)), 0.5 * np.ptp(found, axis=0)
        plot.axes.errorbar(known[places], middle, yerr=reach, fmt="none", ecolor=TOTAL, zorder=5,
                           elinewidth=1.3, capsize=5,
                           label="other interpolations of the gas tables")  # fmt: skip


def _foot(plot: Plot) -> Ends:
    """Stems of the levels, and zeros at the foot of what is zero by symmetry."""
    orders, values = plot.drawn[0]
    acts = np.isfinite(values)
    drawn = [*values[acts], *plot.points] or [-1.0, 1.0]
    low, high = min(drawn), max(drawn)
    room = max(0.1 * (high - low), 2.0)
    plot.axes.vlines(orders[acts], low - room, values[acts], color=COLOURS[0], alpha=0.35,
                     linewidth=5.0)  # fmt: skip
    for order in orders[~acts]:
        note(plot.axes, ZERO, (order, low - room), (0, 4), ha="center", color=QUIET)
    plot.axes.set_xlim(orders[0] - 0.6, orders[-1] + 0.6)
    if len(orders) <= _MARKED:
        plot.axes.set_xticks(orders)
    plot.axes.grid(visible=False, axis="x")
    return low - room, high + room


_DOTS: Look = {"color": COLOURS[0], "marker": "o", "ms": 7, "linestyle": "", "zorder": 4}

ROLL_LEVELS = Curves(
    "angular acceleration of the shell by order",
    (
        Panel(
            "level in {} re 1 rad/s$^2$, zero-to-peak",
            (Curve(_levels, "computed", _DOTS, apart=_APART), _whiskers),
            ends=_foot,
        ),
    ),
    high=4.1,
)


# ----------------------------------------------------------------------------
# What more and less of each parameter do to each harmonic of the shell: a map of the changes.
# ----------------------------------------------------------------------------

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


def draw_roll_sensitivity(result: Result) -> "Figure | None":
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
    figure = canvas(result, words, 2.6 + 0.62 * max(len(rank), 2))
    panels = figure.subplots(2, 1)
    largest = float(np.max(size, initial=0.0)) or 1.0
    scale = min(largest, _DEEPEST)
    for axes, part, word in zip(panels, effect, ("more", "less"), strict=True):
        image = axes.imshow(part, cmap=_COLOURS, vmin=-scale, vmax=scale, aspect="auto")
        axes.set_title(f"{PERCENT} % {word}")
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
