"""Viscous damping of a ring in the oil gap of its casing, for the oils that may fill it."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.absorber.tables import COLDEST, HOTTEST, ICE, THICKEST, THINNEST
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, FloatArray, floats

# ----------------------------------------------------------------------------
# Viscous damping of a ring that turns in a casing, from the gaps around it.
#
# Between two walls that slide past each other the film is sheared evenly, so that every part of the
# ring adds dynamic viscosity times a length cubed. For radii Ro > Ri, width b, clearances h:
#
# - rim, between cylinders Ro and Ro + h: 4 pi b / (1/Ro^2 - 1/(Ro + h)^2), exact for any h;
# - two sides: 2 * integral of 2 pi r^3 / h from Ri to Ro = pi (Ro^4 - Ri^4) / h;
# - bore, between cylinders Ri - h and Ri: 4 pi b / (1/(Ri - h)^2 - 1/Ri^2).
#
# What holds it: a full, concentric gap and a Newtonian oil; films much thinner than the ring is
# wide (corners are left out, a share of about h/b); motion slow enough that the film follows at
# once. Off centre by e in a gap h, the film alone drags 1/sqrt(1 - (e/h)^2) as much at the rim, and
# pressure adds to that.
# ----------------------------------------------------------------------------


class RingGap(NamedTuple):
    """A ring in its casing, all in m. `inner_radius` 0 is a disc; `bore_clearance` inf: no bore."""

    outer_radius: ArrayLike
    inner_radius: ArrayLike
    width: ArrayLike
    rim_clearance: ArrayLike
    side_clearance: ArrayLike
    bore_clearance: ArrayLike = math.inf


class GapShares(NamedTuple):
    """Damping over dynamic viscosity, in m^3: of rim, sides and bore, and their sum."""

    rim: FloatArray
    sides: FloatArray
    bore: FloatArray
    total: Bounded


def gap_shares(gap: RingGap) -> GapShares:
    """Where the damping of a gap comes from, whose clearances are below the width of the ring."""
    outer, inner, wide, rim, side, bore = np.broadcast_arrays(*floats(*gap))
    grown = outer + rim
    # 1/Ro^2 - 1/(Ro + h)^2 = h (2 Ro + h) / (Ro (Ro + h))^2
    at_rim = 4.0 * math.pi * wide * np.square(outer * grown) / (rim * (2.0 * outer + rim))
    at_sides = math.pi * (outer - inner) * (outer + inner) * (outer**2 + inner**2) / side
    there = np.isfinite(bore)
    play = np.where(there, bore, 0.0)
    shrunk = inner - play
    below = np.where(there, play * (2.0 * inner - play), 1.0)
    in_bore = np.where(there, 4.0 * math.pi * wide * np.square(inner * shrunk) / below, 0.0)
    return GapShares(at_rim, at_sides, in_bore, rounded(at_rim + at_sides + in_bore, 16.0))


def viscosity_for_damping(gap: RingGap, damping: ArrayLike) -> Bounded:
    """Dynamic viscosity in Pa s that gives a damping in N m s/rad."""
    return rounded(np.asarray(damping) / gap_shares(gap).total.value, 18.0)


# ----------------------------------------------------------------------------
# Rule for the clearance between seismic mass and casing.
# ----------------------------------------------------------------------------

_INCH = 0.0254


def clearance_rule(outer_radius: ArrayLike) -> Bounded:
    """0.010 in * (1 + sqrt(D / 10 in)) in m, D twice the outer radius (m); Baca 2007, eq. 3.19."""
    (radius,) = floats(outer_radius)
    return rounded(0.010 * _INCH * (1.0 + np.sqrt(2.0 * radius / (10.0 * _INCH))), 8.0)


# ----------------------------------------------------------------------------
# Kinematic viscosity of an oil against temperature: a straight line on the chart of ASTM D341.
#
#     log10 log10(nu + 0.7) = F - G log10 T          nu in mm^2/s (cSt), T in K
#
# (Walther's equation with the constant of the chart; Baca 2007, eq. 3.18). The line holds above
# 2 mm^2/s, where further terms of D341 vanish, and between the temperatures of the chart; what lies
# outside is refused. Drawn through two measured points it interpolates well; beyond them the
# measurements count more and more.
# ----------------------------------------------------------------------------

_SHIFT = 0.7e-6
_UNIT = 1e-6


class Walther(NamedTuple):
    """The line through two points: temperatures (K) and kinematic viscosities (m^2/s) of them."""

    temperature: tuple[ArrayLike, ArrayLike]
    viscosity: tuple[ArrayLike, ArrayLike]


def kinematic_viscosity(line: Walther, temperature: ArrayLike) -> Bounded:
    """Viscosity in m^2/s at a temperature in K.

    Raises NumericalFailure for a temperature or a viscosity outside the chart.
    """
    (warm,) = floats(temperature)
    cold, hot = COLDEST - ICE, HOTTEST - ICE
    for outside in warm[(warm < COLDEST) | (warm > HOTTEST)].flat:
        raise NumericalFailure(
            f"the viscosity line ends at {cold:.0f} and {hot:.0f} C; asked for a viscosity at "
            f"{outside - ICE:.6g} C"
        )
    (first, second), (low, high) = floats(*line.temperature), _double_log(*line.viscosity)
    share = np.log(warm / first) / np.log(second / first)
    double = low + (high - low) * share
    # log log beyond the chart would overflow in the next line: clip, then refuse
    shifted = np.exp(np.exp(np.minimum(double, 3.5))) * _UNIT
    value = shifted - _SHIFT
    for far in np.flatnonzero((value < THINNEST) | (value > THICKEST)):
        thick, there = (float(np.ravel(one)[far]) for one in np.broadcast_arrays(value, warm))
        raise NumericalFailure(
            f"a kinematic viscosity of {1e6 * thick:.4g} mm^2/s at {there - ICE:.6g} C is "
            f"outside the range of the viscosity line, {THINNEST * 1e6:.0f} to "
            f"{THICKEST * 1e6:.0e} mm^2/s"
        )
    size = np.abs(low) + np.abs(high - low) * (np.abs(share) + 1.0 / np.abs(np.log(second / first)))
    error = shifted * (1.0 + np.log(shifted / _UNIT) * (8.0 + 8.0 * size)) * UNIT_ROUNDOFF
    return Bounded(value, error)


def _double_log(*viscosity: ArrayLike) -> list[FloatArray]:
    return [np.log(np.log((one + _SHIFT) / _UNIT)) for one in floats(*viscosity)]


def known_range(line: Walther) -> tuple[float, float]:
    """Temperatures in K between which the viscosity of a line is known."""
    (first, second), (low, high) = floats(*line.temperature), _double_log(*line.viscosity)
    ends = (np.array(_double_log(THICKEST, THINNEST)) - low) / (high - low)
    cold, hot = np.clip(first * (second / first) ** ends, COLDEST, HOTTEST)
    return float(cold) * (1.0 + 1e-9), float(hot) * (1.0 - 1e-9)


# ----------------------------------------------------------------------------
# Density of an oil against temperature.
# ----------------------------------------------------------------------------

#: K, at which densities of oils are stated
STANDARD_TEMPERATURE = 288.15

#: kg/(m^3 K): expansion of lubricating oils over their density (API MPMS 11.1, ASTM D1250)
_LUBRICATING = 0.6278


def oil_density(
    density_at_15: ArrayLike, temperature: ArrayLike, expansion: ArrayLike | None = None
) -> Bounded:
    """rho_15 exp(-a T (1 + 0.8 a T)) in kg/m^3, T the kelvins above 15 C, a in 1/K.

    Without `expansion` that of lubricating oils, 0.6278 / rho_15; silicone fluids want their own.
    Source: API MPMS 11.1 (ASTM D1250), lubricating oils.
    """
    dense, warm = floats(density_at_15, temperature)
    rate = _LUBRICATING / dense if expansion is None else np.asarray(expansion, dtype=float)
    swell = rate * (warm - STANDARD_TEMPERATURE)
    value = dense * np.exp(-swell * (1.0 + 0.8 * swell))
    error = value * UNIT_ROUNDOFF * (4.0 + 8.0 * np.abs(swell) * (1.0 + np.abs(swell)))
    return Bounded(value, np.asarray(error))


# ----------------------------------------------------------------------------
# An oil from a list: what damping it gives in a gap at a temperature, and the reverse.
# ----------------------------------------------------------------------------


class Oil(NamedTuple):
    """Name, viscosity line, density at 15 C in kg/m^3; expansion in 1/K unless a mineral oil."""

    name: str
    line: Walther
    density_at_15: float
    expansion: float | None = None


def dynamic_viscosity(oil: Oil, temperature: ArrayLike) -> Bounded:
    """Kinematic viscosity times density in Pa s, at temperatures in K; refuses as the line does."""
    dense = oil_density(oil.density_at_15, temperature, oil.expansion)
    return kinematic_viscosity(oil.line, temperature) * dense


def oil_damping(oil: Oil, gap: RingGap, temperature: ArrayLike) -> Bounded:
    """Damping in N m s/rad of a gap filled with an oil, at temperatures in K."""
    return dynamic_viscosity(oil, temperature) * gap_shares(gap).total


def right_temperature(oil: Oil, gap: RingGap, damping: float) -> Bounded:
    """Temperature in K at which an oil gives a gap a damping in N m s/rad; 0 where it never does.

    Damping falls with temperature.
    """
    from scipy.optimize import brentq

    def off(warm: float) -> float:
        return float(oil_damping(oil, gap, warm).value) - damping

    low, high = known_range(oil.line)
    if off(low) < 0.0 or off(high) > 0.0:
        return Bounded(np.zeros(()), np.zeros(()))
    place = brentq(off, low, high, xtol=UNIT_ROUNDOFF * high, rtol=8.0 * UNIT_ROUNDOFF)
    ends = oil_damping(oil, gap, np.clip([place, place - 1e-3, place + 1e-3], low, high))
    error = ends.error[0] * 2e-3 / (ends.value[1] - ends.value[2])
    return Bounded(np.asarray(place), np.asarray(error + 16.0 * UNIT_ROUNDOFF * high))
