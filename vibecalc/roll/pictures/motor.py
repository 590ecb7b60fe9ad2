"""Pictures of the motor: its curve over the slip, with transients and without."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibecalc.core.report.canvas import COLOURS, QUIET, TOTAL, canvas, note
from vibecalc.core.report.sections import along
from vibecalc.core.report.writing import rpm
from vibecalc.core.results.record import Record, Result
from vibecalc.roll.report.advice import ROLL, shell_acts

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# The curve of a motor as the case gives it, sampled for a picture.
# ----------------------------------------------------------------------------

_POINTS = 1201
_RPM = 2.0 * np.pi / 60.0


class MotorCurve(NamedTuple):
    """Torque over slip, N m and rpm, the rows of the table, and slip and torque at breakdown."""

    slip: np.ndarray
    torque: np.ndarray
    node_slip: np.ndarray
    node_torque: np.ndarray
    breakdown: tuple[float, float] | None


def motor_curve(motor: Mapping[str, Any], slips: np.ndarray) -> MotorCurve | None:
    """The curve over its table and over `slips` (rpm), read as the case has it.

    None for a motor without one. At negative slip it goes as far as the machine does, with the
    rows of the table mirrored.
    """
    from vibecalc.excitation.slip_torque import breakdown, linear_motor, slip_curve, slip_torque

    table, gain = motor.get("slip_table"), motor.get("gain")
    nodes = heights = np.empty(0)
    if isinstance(table, Mapping):
        nodes, heights = (np.asarray(table[key], dtype=float) for key in ("slip", "torque"))
        curve = slip_curve(nodes, heights, str(motor.get("interpolation") or "monotone"))
    elif isinstance(gain, int | float):
        curve = linear_motor(float(gain))
    else:
        return None
    room = 0.1 * (float(np.ptp(slips)) or 1.0)
    low, high = min(0.0, float(slips.min()) - room), float(slips.max()) + room
    if nodes.size:
        high = max(high, rpm(float(curve.largest)))
    both = np.concatenate([-nodes[:0:-1], nodes])
    grid = np.unique(np.concatenate([np.linspace(low * _RPM, high * _RPM, _POINTS), both]))
    grid = grid[(grid >= low * _RPM) & (grid <= high * _RPM)]
    torque = np.asarray(slip_torque(curve, grid).value)
    mirrored = np.concatenate([-heights[:0:-1], heights])
    kept = both >= low * _RPM
    at, most = breakdown(curve)
    peak = (rpm(at), most) if np.isfinite(most) else None
    return MotorCurve(rpm_of(grid), torque, rpm_of(both[kept]), mirrored[kept], peak)


def rpm_of(speeds: np.ndarray) -> np.ndarray:
    """Turns per minute of speeds in rad/s."""
    return np.asarray(speeds, dtype=float) / _RPM


# ----------------------------------------------------------------------------
# Torque over slip of a motor with transients: table, fitted curve, and a turn with each.
# ----------------------------------------------------------------------------

_MOTOR = ROLL + "motor/"
_LEVELS = (
    (_MOTOR + "table_level", "slip table", TOTAL, "o"),
    (_MOTOR + "static_level", "steady curve of the fit", COLOURS[0], "s"),
    (ROLL + "level/shell_acceleration", "with transients", COLOURS[1], "D"),
)
_CURVE = COLOURS[0]
_ORBIT = COLOURS[1]


def draw_dynamic_motor(result: Result) -> "Figure | None":
    """The whole curve and the part that is used at the left, levels at the right.

    None for a motor without transients.
    """
    record = result.record
    curve = along(record, _MOTOR + "curve", "slip")
    slip = along(record, ROLL + "cycle/slip", "crank_angle")
    torque = along(record, ROLL + "cycle/motor_torque", "crank_angle")
    if curve is None or slip is None or torque is None:
        return None
    figure = canvas(result, "motor: table, fitted circuit, and its transients", 7.2)
    panels = figure.subplot_mosaic([["curve", "levels"], ["part", "change"]])
    orbit = rpm_of(slip[0].values), np.asarray(torque[0].values, dtype=float)
    for name in ("curve", "part"):
        _plane(panels[name], record, orbit, whole=name == "curve")
    panels["curve"].legend(loc="lower right", bbox_to_anchor=(1.0, 0.07))
    _levels(panels["levels"], record)
    _change(panels["change"], record)
    return figure


def _plane(
    axes: "Axes", record: Record, orbit: tuple[np.ndarray, np.ndarray], *, whole: bool
) -> None:
    curve = along(record, _MOTOR + "curve", "slip")
    rows = along(record, _MOTOR + "table/torque", "slip")
    first, second = (
        along(record, f"{_MOTOR}cycle/static_{name}", "crank_angle") for name in ("slip", "torque")
    )
    if curve is not None:
        slips = rpm_of(curve[1])
        axes.plot(slips, curve[0].values, color=_CURVE, linewidth=1.2, label="fitted, steady")
    if rows is not None:
        axes.plot(
            rpm_of(rows[1]), rows[0].values, "o", color=TOTAL, ms=4.5, label="table", zorder=4
        )
    if first is not None and second is not None:
        words = "one turn, steady torque"
        axes.plot(
            rpm_of(first[0].values), second[0].values,
            color=COLOURS[5], linewidth=4.0, alpha=0.8, label=words, zorder=2.5,
        )  # fmt: skip
    axes.plot(*orbit, color=_ORBIT, linewidth=1.8, label="one turn, with transients", zorder=3)
    axes.plot(orbit[0][:1], orbit[1][:1], "o", color=_ORBIT, ms=6, zorder=4)
    if not whole:
        note(axes, "crank angle 0", (orbit[0][0], orbit[1][0]), (8, -2), color=_ORBIT, va="center")
    zeros_of(axes, whole=whole)
    axes.set_xlabel("slip in rpm")
    if not whole:
        axes.set_xlim(*ends(orbit[0], *([] if first is None else [rpm_of(first[0].values)])))
        axes.set_ylim(*ends(orbit[1], *([] if second is None else [second[0].values])))


def _levels(axes: "Axes", record: Record) -> None:
    for path, words, colour, mark in _LEVELS:
        hit = along(record, path, "order")
        if hit is None:
            continue
        values = np.asarray(hit[0].values, dtype=float)
        kept = np.isfinite(values) & shell_acts(record, hit[1])
        face = "none" if mark == "o" else colour  # what lies on it stays visible
        size = 10.0 if mark == "o" else 5.5
        axes.plot(hit[1][kept], values[kept], mark, color=colour, mfc=face, ms=size, label=words)
    axes.set_ylabel("level in dB re 1 rad/s$^2$")
    _orders(axes, record)
    headroom(axes, 0.4)
    axes.legend(loc="upper right")
    axes.set_title("angular acceleration of the shell", loc="left")


def _change(axes: "Axes", record: Record) -> None:
    for shift, (name, words, colour) in zip(
        (-0.2, 0.2),
        (("fit_change", "fit for table", _CURVE), ("dynamics_change", "transients", _ORBIT)),
        strict=True,
    ):
        hit = along(record, _MOTOR + name, "order")
        if hit is None:
            continue
        values = np.asarray(hit[0].values, dtype=float)
        kept = np.isfinite(values) & shell_acts(record, hit[1])
        axes.bar(hit[1][kept] + shift, values[kept], 0.38, color=colour, label=words)
    axes.axhline(0.0, color=QUIET, linewidth=0.7)
    axes.set_ylabel("change of the level in dB")
    axes.set_xlabel("order")
    _orders(axes, record)
    axes.legend(loc="best")
    axes.set_title("changes", loc="left")


def _orders(axes: "Axes", record: Record) -> None:
    hit = along(record, ROLL + "level/shell_acceleration", "order")
    if hit is not None:
        axes.set_xlim(float(hit[1].min()) - 0.6, float(hit[1].max()) + 0.6)
        if len(hit[1]) <= 20:
            axes.set_xticks(hit[1])


def ends(*values: np.ndarray, room: float = 0.06) -> tuple[float, float]:
    """Ends of an axis with that share of the range as room."""
    low = min(float(one.min()) for one in values)
    high = max(float(one.max()) for one in values)
    wide = room * (high - low) or 1.0
    return low - wide, high + wide


def zeros_of(axes: "Axes", *, whole: bool) -> None:
    """Lines at no slip and no torque, and what the plane of torque over slip is called."""
    axes.axhline(0.0, color=QUIET, linewidth=0.7)
    axes.axvline(0.0, color=QUIET, linewidth=0.7)
    axes.set_ylabel("motor torque in N m")
    axes.set_title("full curve" if whole else "operating range", loc="left")


def headroom(axes: "Axes", share: float) -> None:
    """Room for the legend above the curves, a share of their range."""
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + share * (high - low))
