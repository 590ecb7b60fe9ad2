"""Kinematic viscosity of an oil against temperature: a straight line on the chart of ASTM D341.

    log10 log10(nu + 0.7) = F - G log10 T          nu in mm^2/s (cSt), T in K

(Walther's equation with the constant of the chart; Baca 2007, eq. 3.18). The line holds above
2 mm^2/s, where further terms of D341 vanish, and between the temperatures of the chart; what lies
outside is refused. Drawn through two measured points it interpolates well; beyond them the
measurements count more and more, which `spread` tells.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.closed_form import floats
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.numerics.typing import FloatArray

#: temperatures of the chart, in K (-70 and 370 C)
COLDEST, HOTTEST = 203.15, 643.15

#: m^2/s: the least and the greatest kinematic viscosity for which the line is drawn
THINNEST, THICKEST = 2e-6, 20.0

_SHIFT = 0.7e-6
_UNIT = 1e-6


class Walther(NamedTuple):
    """The line through two points: temperatures (K) and kinematic viscosities (m^2/s) of them."""

    temperature: tuple[ArrayLike, ArrayLike]
    viscosity: tuple[ArrayLike, ArrayLike]


class WaltherConstants(NamedTuple):
    """F and G of the line with decimal logarithms, mm^2/s and kelvin."""

    intercept: FloatArray
    slope: FloatArray


def constants(line: Walther) -> WaltherConstants:
    """F and G. Raises NumericalFailure for points that make no line (see `kinematic_viscosity`)."""
    first, second, low, high = _ends(line)
    slope = (low - high) / np.log(second / first)
    intercept = (low + slope * np.log(first) - math.log(math.log(10.0))) / math.log(10.0)
    return WaltherConstants(np.asarray(intercept), np.asarray(slope))


def kinematic_viscosity(line: Walther, temperature: ArrayLike) -> WithError:
    """Viscosity in m^2/s at a temperature in K.

    Raises NumericalFailure for a temperature or a viscosity outside the chart, for points at one
    temperature, and for an oil that would grow thicker with heat.
    """
    (warm,) = floats(temperature)
    cold, hot = COLDEST - 273.15, HOTTEST - 273.15
    for outside in warm[(warm < COLDEST) | (warm > HOTTEST)].flat:
        raise NumericalFailure(
            f"the viscosity line ends at {cold:.0f} and {hot:.0f} C; asked for a viscosity at "
            f"{outside - 273.15:.6g} C"
        )
    first, second, low, high = _ends(line)
    share = np.log(warm / first) / np.log(second / first)
    double = low + (high - low) * share
    # log log beyond the chart would overflow in the next line: clip, then refuse
    shifted = np.exp(np.exp(np.minimum(double, 3.5))) * _UNIT
    value = shifted - _SHIFT
    _in_range(value, warm)
    size = np.abs(low) + np.abs(high - low) * (np.abs(share) + 1.0 / np.abs(np.log(second / first)))
    error = shifted * (1.0 + np.log(shifted / _UNIT) * (8.0 + 8.0 * size)) * UNIT_ROUNDOFF
    return WithError(value, error)


def spread(
    line: Walther, temperature: ArrayLike, measured: tuple[ArrayLike, ArrayLike]
) -> FloatArray:
    """What errors of the two measured viscosities (m^2/s, each at most so large) become, m^2/s.

    Linear: d nu = Z ln Z sum w_i d nu_i / (Z_i ln Z_i), Z = nu + 0.7 mm^2/s, with the weights w_i
    of the straight line, of which one is negative outside the two points.
    """
    found = kinematic_viscosity(line, temperature).value
    first, second, low, high = _ends(line)
    share = np.log(np.asarray(temperature) / first) / np.log(second / first)
    here = (found + _SHIFT) / _UNIT
    total = np.zeros(())
    for weight, double, off in ((1.0 - share, low, measured[0]), (share, high, measured[1])):
        there = np.exp(double)
        total = total + np.abs(weight) * np.asarray(off) / (np.exp(there) * there)
    return np.asarray(here * np.log(here) * total)


def temperature_for(line: Walther, viscosity: ArrayLike) -> WithError:
    """Temperature in K at which the oil has a viscosity in m^2/s. Raises as above."""
    (wanted,) = floats(viscosity)
    _in_range(wanted, None)
    first, second, low, high = _ends(line)
    share = (_double_log(wanted) - low) / (high - low)
    value = first * np.exp(share * np.log(second / first))
    if np.any((value < COLDEST) | (value > HOTTEST)):
        raise NumericalFailure(
            f"the oil would have to be at {float(value.flat[0]) - 273.15:.6g} C, outside the range "
            f"of the viscosity line ({COLDEST - 273.15:.0f} to {HOTTEST - 273.15:.0f} C)"
        )
    steep = np.abs(np.log(second / first) / (high - low))
    size = 8.0 + 8.0 * steep * (np.abs(low) + np.abs(high) + np.abs(_double_log(wanted)) + 2.0)
    return WithError(value, value * size * UNIT_ROUNDOFF)


def _double_log(viscosity: FloatArray) -> FloatArray:
    return np.asarray(np.log(np.log((viscosity + _SHIFT) / _UNIT)))


def _ends(line: Walther) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    first, second = floats(*line.temperature)
    thick, thin = floats(*line.viscosity)
    _in_range(thick, first)
    _in_range(thin, second)
    if np.any((second - first) * (thick - thin) <= 0.0):
        raise NumericalFailure(
            "the two points of a viscosity line need two temperatures, and less viscosity at the "
            "higher one"
        )
    return first, second, _double_log(thick), _double_log(thin)


def _in_range(viscosity: FloatArray, temperature: FloatArray | None) -> None:
    bad = (viscosity < THINNEST) | (viscosity > THICKEST)
    if not np.any(bad):
        return
    worst = float(np.broadcast_to(viscosity, bad.shape)[bad][0]) * 1e6
    place = ""
    if temperature is not None:
        place = f" at {float(np.broadcast_to(temperature, bad.shape)[bad][0]) - 273.15:.6g} C"
    raise NumericalFailure(
        f"a kinematic viscosity of {worst:.4g} mm^2/s{place} is outside the range of the viscosity "
        f"line, {THINNEST * 1e6:.0f} to {THICKEST * 1e6:.0e} mm^2/s"
    )
