"""Numbers as the report prints them: stable digits, 0 for zeros, the error where it is larger."""

import math
from typing import Any

import numpy as np

from vibecalc.results.record import Estimate

DIGITS = 6
#: of a value that its error exceeds, and below which share of the error it says nothing
_ROUGH, _LEAST_SHOWN = 3, 1e-3
_LOWEST_FIXED = 1e-4
_HIGHEST_FIXED = 1e7
_TURN = 2.0 * math.pi


def show(value: Any, error: float = 0.0, digits: int = DIGITS) -> str:
    """One number with a fixed count of significant digits.

    A complex number shows its magnitude, an integer all its digits. What is zero to rounding of
    the terms it is summed from is `0`: its digits would change from machine to machine. What does
    not exceed its `error` (absolute, same unit) for another reason is shown with it, `196 +-722`:
    it is unresolved. An error without terms counts as rounding. An infinite value is
    `unbounded`, an undefined one `undefined`.
    """
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, int | np.integer):
        return str(int(value))
    number: float = abs(value) if np.iscomplexobj(value) else float(value)
    if math.isnan(number):
        return "undefined"
    if math.isinf(number):
        return "unbounded" if number > 0 else "-unbounded"
    if isinstance(error, Estimate):
        if error.unresolved(number):
            least = number if abs(number) > _LEAST_SHOWN * error else 0.0
            return f"{show(least, digits=_ROUGH)} +-{show(float(error), digits=_ROUGH)}"
        if error.is_zero(number):
            return "0"
    # An error that is not known hides nothing: the accuracy section says so instead.
    elif number == 0.0 or (abs(number) <= error and math.isfinite(error)):
        return "0"
    mantissa, exponent = f"{number:.{digits - 1}e}".split("e")
    if _LOWEST_FIXED <= abs(float(f"{mantissa}e{exponent}")) < _HIGHEST_FIXED:
        return f"{number:.{max(digits - 1 - int(exponent), 0)}f}"
    return f"{mantissa}e{exponent}"


def show_error(error: float) -> str:
    """An error estimate with two digits; 0 is `exact`."""
    return "exact" if error == 0.0 else f"{error:.1e}"


def show_percent(fraction: float | None) -> str:
    """A relative difference in percent with its sign, `-` where it is undefined."""
    if fraction is None or math.isnan(fraction) or math.isinf(fraction):
        return "-"
    percent = 100.0 * fraction
    if abs(percent) < 5e-5:
        return "0.0000 %"
    if abs(percent) >= 1e4:
        return f"{percent:+.1e} %"
    decimals = 4 if abs(percent) < 1.0 else 2
    return f"{percent:+.{decimals}f} %"


def show_phase(value: complex, error: float = 0.0) -> str:
    """Phase of a complex amplitude in degrees, (-180, 180], `-` where the amplitude is zero.

    A positive phase leads. The half turn is printed as +180, whichever side round-off put it on.
    """
    if not abs(value) > error or not math.isfinite(abs(value)):
        return "-"
    degrees = round(math.degrees(math.atan2(value.imag, value.real)), 2)
    if degrees == -180.0:
        degrees = 180.0
    return f"{degrees + 0.0:.2f}"


def rpm(speed: float) -> float:
    """Turns per minute of a speed in rad/s."""
    return speed * 60.0 / _TURN


def hertz(frequency: float) -> float:
    """Cycles per second of a frequency in rad/s."""
    return frequency / _TURN


def is_speed(path: str) -> bool:
    """Whether a quantity in rad/s is a speed of rotation, told by its path."""
    return path.rsplit("/", 1)[-1].endswith("speed")


def also(path: str, value: float, unit: str, error: float = 0.0) -> str:
    """The same value as an engineer may rather want it: rpm, Hz of a frequency, degrees."""
    if unit == "rad" and math.isfinite(value):
        return f"{show(math.degrees(value), error * (360.0 / _TURN))} deg"
    if unit != "rad/s" or not math.isfinite(value):
        return ""
    if is_speed(path):
        return f"{show(rpm(value), rpm(error))} rpm"
    return f"{show(hertz(value), hertz(error))} Hz"
