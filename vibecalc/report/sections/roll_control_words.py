"""Words for loops: what their status means, and what their margins come to."""

import math
from typing import Any

import numpy as np

from vibecalc.report.lookup import scalar_of
from vibecalc.report.numbers import hertz, show
from vibecalc.results.record import Record

CONTROL = "response/control/"
#: of `status`
STATUS = (
    "stable",
    "STABLE ONLY WITHOUT ANY DELAY",
    "ON THE LIMIT OF STABILITY",
    "UNSTABLE",
    "UNSTABLE WITH THE LEAST LAG",
)
#: s; shorter times are written in microseconds
_SHORT = 1e-4
SHORT = ("stable", "no delay", "limit", "UNSTABLE", "UNSTABLE")


def status_words(record: Record, below: str) -> str:
    """What holds of a loop, loud where its levels are worth nothing; empty if not known."""
    status = scalar_of(record, f"{CONTROL}{below}status")
    if status is None:
        return ""
    words = STATUS[int(status)]
    if int(status) == 1:
        return f"{words}: its levels hold on paper only"
    return words if int(status) == 0 else f"{words}: its amplitudes have no bound"


def feedback_words(gain: Any, speed: float, acceleration: Any) -> str:
    """Gain and feedbacks in one line."""
    return (
        f"gain {show(gain, digits=5)}, speed feedback {show(speed, digits=6)}, feedback of the "
        f"shell's acceleration {show(acceleration, digits=5)} s"
    )


def margin_words(record: Record, below: str) -> list[tuple[str, str]]:
    """Rows of margins, and of what the actuator has to bear."""

    def value(name: str) -> float:
        found = scalar_of(record, f"{CONTROL}{below}{name}")
        return math.nan if found is None else found

    up, down = in_decibels(value("gain_margin")), in_decibels(value("gain_reduction"))
    margins = (
        f"gain {up} up and {down} down, phase {in_phase(value('phase_margin'))}, "
        f"delay {in_time(value('delay_margin'))}"
    )
    width, through = value("bandwidth"), value("feedthrough")
    wide = "without end" if math.isinf(width) else f"{show(hertz(width), digits=4)} Hz"
    bears = f"gain of one up to {wide}, {show(through, digits=4)} at high frequency; "
    rate = value("command_rate")
    bears += f"field speed changes by up to {show(rate, digits=4)} rad/s^2, torque of the motor up "
    bears += f"to {show(value('torque_peak'), digits=4)} N*m"
    most = scalar_of(record, f"{CONTROL}breakdown_torque")
    if most is not None and math.isfinite(value("torque_peak")) and value("torque_peak") > most:
        bears += f", MORE THAN THE {show(most, digits=4)} N*m THAT IT HAS"
    return [("margins", margins), ("it takes", bears)]


def in_decibels(level: float) -> str:
    """A factor in dB; `any` if there is no limit."""
    return "any" if math.isinf(level) else f"{level:.2f} dB"


def in_phase(angle: float) -> str:
    """An angle in degrees; `any` if there is no limit."""
    return "any" if math.isinf(angle) else f"{np.degrees(angle):.1f} deg"


def in_time(time: Any) -> str:
    """A time in ms; `any` if there is no limit, `none` for nothing."""
    if time is None or time == 0.0:
        return "none"
    if math.isinf(time):
        return "any"
    if time < _SHORT:
        return f"{show(1e6 * float(time), digits=4)} us"
    return f"{show(1e3 * float(time), digits=4)} ms"
