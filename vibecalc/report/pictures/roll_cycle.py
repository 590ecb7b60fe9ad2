"""One turn of the machine: torque, speed and slip, and the way along the curve of the motor."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.report.levels import ROLL
from vibecalc.report.lookup import along, scalar_of, table_of
from vibecalc.report.numbers import rpm, show
from vibecalc.report.pictures.canvas import (
    COLOURS,
    LIMIT,
    QUIET,
    TOTAL,
    canvas,
    crank_angle_axis,
)
from vibecalc.report.pictures.motor_curve import MotorCurve, motor_curve, rpm_of
from vibecalc.results.record import Quantity, Record, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
    ("gas_torque", "demand of the gas", -1.0, COLOURS[5]),
    ("motor_torque", "motor", 1.0, _ORBIT),
)


def picture(result: Result) -> "Figure | None":
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
    figure = canvas(result, "one turn, and the motor on its curve", 9.9, 7.2)
    panels = figure.subplot_mosaic(_MOSAIC)
    motor = table_of(result.case, "machine", "motor")
    _torques(panels["torque"], record)
    _speed(panels["speed"], record, *speed, motor)
    _slip(panels["slip"], *slip)
    for name in ("torque", "speed", "slip"):
        crank_angle_axis(panels[name])
        if name != "slip":
            panels[name].set_xlabel("")
            panels[name].tick_params(labelbottom=False)
    slips = rpm_of(slip[0].values)
    torques = np.asarray(torque[0].values, dtype=float)
    curve = motor_curve(motor, slips)
    fitted = [scalar_of(record, f"response/roll/motor/breakdown_{w}") for w in ("slip", "torque")]
    if curve is not None and fitted[0] is not None and fitted[1] is not None:
        # a motor with fluxes has the summit of its fit, not that of the table
        curve = curve._replace(breakdown=(rpm(fitted[0]), fitted[1]))
    for name in ("curve", "part"):
        _curve(panels[name], curve, slips, torques, whole=name == "curve")
    panels["curve"].legend(loc="lower right", fontsize=9)
    panels["part"].set_xlabel("slip in rpm")
    figure.align_ylabels([panels[name] for name in ("torque", "speed", "slip")])
    figure.align_ylabels([panels[name] for name in ("curve", "part")])
    return figure


def _torques(axes: "Axes", record: Record) -> None:
    for name, words, sign, colour in _TORQUES:
        hit = along(record, _CYCLE + name, "crank_angle")
        if hit is not None:
            values = sign * np.asarray(hit[0].values)
            axes.plot(np.degrees(hit[1]), values, color=colour, label=words)
    axes.axhline(0.0, color=QUIET, linewidth=0.7)
    axes.set_ylabel("torque in N*m")
    axes.legend(loc="best", fontsize=9)


def _speed(
    axes: "Axes", record: Record, quantity: Quantity, angle: np.ndarray, motor: Mapping[str, Any]
) -> None:
    values = rpm_of(quantity.values)
    axes.plot(np.degrees(angle), values, color=COLOURS[0], label="crank against shell")
    mean = scalar_of(record, ROLL + "speed")
    if mean is not None:
        words = f"mean {show(rpm(mean), digits=5)} rpm"
        axes.axhline(rpm(mean), color=TOTAL, linewidth=1.0, linestyle="--", label=words)
    synchronous = motor.get("synchronous_speed")
    if isinstance(synchronous, int | float):
        words = f"synchronous {show(rpm(float(synchronous)), digits=5)} rpm"
        axes.axhline(rpm(synchronous), color=LIMIT, linewidth=1.0, linestyle=":", label=words)
    axes.set_ylabel("speed in rpm")
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.45 * (high - low))
    axes.legend(loc="upper left", ncols=2, fontsize=9)


def _slip(axes: "Axes", quantity: Quantity, angle: np.ndarray) -> None:
    values = rpm_of(quantity.values)
    axes.plot(np.degrees(angle), values, color=COLOURS[2])
    axes.axhline(0.0, color=QUIET, linewidth=0.7)
    axes.set_ylabel("slip in rpm")


def _curve(
    axes: "Axes", curve: MotorCurve | None, slip: np.ndarray, torque: np.ndarray, *, whole: bool
) -> None:
    """The motor's curve with the way of a turn along it: all of it, or the part that is used."""
    left, right, low, high = (*_ends(slip), *_ends(torque))
    if curve is not None:
        if whole:
            left, right = min(left, curve.slip[0]), max(right, curve.slip[-1])
        inside = (curve.slip >= left) & (curve.slip <= right)
        words = "curve of the motor"
        axes.plot(curve.slip[inside], curve.torque[inside], color=QUIET, linewidth=1.2, label=words)
        kept = (curve.node_slip >= left) & (curve.node_slip <= right)
        nodes, heights = curve.node_slip[kept], curve.node_torque[kept]
        if nodes.size:
            axes.plot(nodes, heights, "o", color=TOTAL, ms=4.5, label="rows of its table", zorder=4)
        if whole:
            low = min(low, float(curve.torque[inside].min()))
            high = max(high, float(curve.torque[inside].max()))
    axes.plot(slip, torque, color=_ORBIT, linewidth=3.0, alpha=0.8, label="one turn", zorder=3)
    if curve is not None and curve.breakdown is not None and whole:
        _breakdown(axes, *curve.breakdown)
    axes.axhline(0.0, color=QUIET, linewidth=0.7)
    axes.axvline(0.0, color=QUIET, linewidth=0.7)
    axes.set_xlim(left, right)
    room = 0.08 * (high - low)
    axes.set_ylim(low - room, high + (2.0 if whole else 1.0) * room)
    axes.set_ylabel("torque of the motor in N*m")
    axes.set_title("all of the curve" if whole else "where it runs", loc="left", fontsize=10)


def _ends(values: np.ndarray) -> tuple[float, float]:
    low, high = float(values.min()), float(values.max())
    room = 0.08 * (high - low) or 1.0
    return low - room, high + room


def _breakdown(axes: "Axes", slip: float, torque: float) -> None:
    axes.plot([slip], [torque], "*", color=LIMIT, ms=12, zorder=5)
    axes.annotate(
        f"breakdown {show(torque, digits=4)} N*m at {show(slip, digits=4)} rpm",
        (slip, torque),
        xytext=(8, 3),
        textcoords="offset points",
        color=LIMIT,
        fontsize=9,
        va="bottom",
    )
