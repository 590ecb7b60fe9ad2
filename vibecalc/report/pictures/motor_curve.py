"""The curve of a motor as the case gives it, sampled for a picture."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from vibecalc.report.numbers import rpm

_POINTS = 1201
_RPM = 2.0 * np.pi / 60.0


class MotorCurve(NamedTuple):
    """Torque over slip, N*m and rpm, the rows of the table, and slip and torque at breakdown."""

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
    summit = (rpm(at), most) if np.isfinite(most) else None
    return MotorCurve(rpm_of(grid), torque, rpm_of(both[kept]), mirrored[kept], summit)


def rpm_of(speeds: np.ndarray) -> np.ndarray:
    """Turns per minute of speeds in rad/s."""
    return np.asarray(speeds, dtype=float) / _RPM
