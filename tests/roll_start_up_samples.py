"""Results for the tests of the report: a start-up on mounts, made up by closed forms."""

import numpy as np
from report_samples import quantity
from roll_samples import RPM

from vibecalc.core.results.record import Axis, Quantity

STEM = "response/start_up/"


def start_up(started: bool = True) -> list[Quantity]:
    """Histories of a start on mounts: unloaded for half a second, settled after 1.7 s."""
    time = Axis(name="start_time", values=np.linspace(0.007, 2.8, 400), unit="s")
    t = time.values
    speed = 900.0 * RPM * np.minimum(t / 0.3, 1.0) * (1.0 if started else 0.1)
    swing = np.exp(-3.0 * t) * np.sin(48.0 * t)
    found = []
    for name, unit, size in (
        ("shell_angle", "rad", -3.2e-3 * swing),
        ("shell_acceleration", "rad/s^2", 7.4 * swing),
        ("motor_torque", "N*m", 1009.0 * np.abs(swing)),
        ("mount_torque", "N*m", 1225.0 * swing),
        ("crank_speed", "rad/s", speed),
    ):
        low, high = size - 0.02 * np.abs(size), size + 0.02 * np.abs(size)
        top = int(np.argmax(np.maximum(np.abs(low), np.abs(high))))
        peak = max(abs(low[top]), abs(high[top]))
        found += [
            quantity(f"{STEM}history/{name}_low", low, unit, time),
            quantity(f"{STEM}history/{name}_high", high, unit, time),
            quantity(f"{STEM}{name}_peak", peak, unit),
            quantity(f"{STEM}{name}_peak_time", t[top], "s"),
        ]
    turn = Axis(name="turn", values=np.arange(1, 37))
    step = Axis(name="load_step", values=np.array([0.0, 0.5]), unit="s")
    interval = Axis(name="start_interval", values=np.array([1, 2]))
    degrees = np.pi / 180.0
    return [
        *found,
        quantity(STEM + "started", int(started), ""),
        quantity(STEM + "settled", int(started), ""),
        quantity(STEM + "time_to_speed", 0.296 if started else np.inf, "s"),
        quantity(STEM + "time_to_steady", 1.715 if started else np.inf, "s"),
        quantity(STEM + "turn/begin", 0.22 + 0.0676 * turn.values, "s", turn),
        quantity(STEM + "turn/speed", np.full(36, 92.97), "rad/s", turn),
        quantity(STEM + "load/factor", [0.0, 1.0], "", step),
        quantity(STEM + "start_angles/lower", np.array([170.0, 340.0]) * degrees, "rad", interval),
        quantity(STEM + "start_angles/upper", np.array([262.0, 362.0]) * degrees, "rad", interval),
        quantity(STEM + "start_angles/fraction", 114.0 / 360.0, ""),
    ]
