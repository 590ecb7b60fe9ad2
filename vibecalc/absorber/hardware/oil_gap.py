"""Viscous damping of a ring in the oil gap of its casing, for the oils that may fill it."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

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
    """Where the damping of a gap comes from.

    Raises NumericalFailure where a clearance is not below the width of the ring, or the bore
    clearance (if finite) not below the inner radius: no such film exists.
    """
    outer, inner, wide, rim, side, bore = np.broadcast_arrays(*floats(*gap))
    _check(wide, rim, side, bore, inner)
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


def _check(
    wide: FloatArray, rim: FloatArray, side: FloatArray, bore: FloatArray, inner: FloatArray
) -> None:
    widest = np.maximum(np.maximum(rim, side), np.where(np.isfinite(bore), bore, 0.0))
    if np.any(widest >= wide):
        worst = np.unravel_index(np.argmax(widest - wide), wide.shape)
        raise NumericalFailure(
            f"a gap of {1e3 * widest[worst]:.4g} mm is no film for a mass "
            f"{1e3 * wide[worst]:.4g} mm wide: the damping of a gap has to be that of a thin film"
        )
    if np.any(np.isfinite(bore) & (bore >= inner)):
        raise NumericalFailure("the gap in the bore is as wide as the bore itself")


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


def kinematic_viscosity(line: Walther, temperature: ArrayLike) -> Bounded:
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
    return Bounded(value, error)


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


def _in_range(viscosity: FloatArray, temperature: FloatArray) -> None:
    bad = (viscosity < THINNEST) | (viscosity > THICKEST)
    if not np.any(bad):
        return
    worst = float(np.broadcast_to(viscosity, bad.shape)[bad][0]) * 1e6
    warm = float(np.broadcast_to(temperature, bad.shape)[bad][0]) - 273.15
    raise NumericalFailure(
        f"a kinematic viscosity of {worst:.4g} mm^2/s at {warm:.6g} C is outside the range of the "
        f"viscosity line, {THINNEST * 1e6:.0f} to {THICKEST * 1e6:.0e} mm^2/s"
    )


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

_HALVINGS = 60


class Oil(NamedTuple):
    """Name, viscosity line, density at 15 C in kg/m^3; expansion in 1/K unless a mineral oil."""

    name: str
    line: Walther
    density_at_15: float
    expansion: float | None = None


def dynamic_viscosity(oil: Oil, temperature: ArrayLike) -> Bounded:
    """Kinematic viscosity times density in Pa s, at temperatures in K; refuses as the line does."""
    thick = kinematic_viscosity(oil.line, temperature)
    dense = oil_density(oil.density_at_15, temperature, oil.expansion)
    value = thick.value * dense.value
    error = thick.error * dense.value + thick.value * dense.error + UNIT_ROUNDOFF * value
    return Bounded(value, error)


def oil_damping(oil: Oil, gap: RingGap, temperature: ArrayLike) -> Bounded:
    """Damping in N m s/rad of a gap filled with an oil, at temperatures in K."""
    thick, shares = dynamic_viscosity(oil, temperature), gap_shares(gap).total
    value = thick.value * shares.value
    error = thick.error * shares.value + thick.value * shares.error + UNIT_ROUNDOFF * value
    return Bounded(value, error)


def right_temperature(oil: Oil, gap: RingGap, damping: float) -> Bounded:
    """Temperature in K at which an oil gives a gap a damping in N m s/rad.

    Damping falls with temperature; the place is found by bisection. Raises NumericalFailure where
    the oil does not reach the damping between the ends of its line.
    """
    low, high = _known_range(oil)
    ends = oil_damping(oil, gap, np.array([low, high])).value
    if not ends[1] <= damping <= ends[0]:
        raise NumericalFailure(
            f"{oil.name} gives this gap between {ends[1]:.4g} and {ends[0]:.4g} N m s/rad "
            f"({high - 273.15:.4g} to {low - 273.15:.4g} C), never {damping:.4g}"
        )
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if oil_damping(oil, gap, middle).value > damping:
            low = middle
        else:
            high = middle
    near = oil_damping(oil, gap, np.array([low, high - 1e-3, high + 1e-3]).clip(COLDEST, HOTTEST))
    slope = (near.value[1] - near.value[2]) / 2e-3
    uncertainty = near.error[0] / slope + 2.0 * UNIT_ROUNDOFF * high + (high - low)
    return Bounded(np.asarray(0.5 * (low + high)), np.asarray(uncertainty))


def _known_range(oil: Oil) -> tuple[float, float]:
    """Temperatures between which the line of an oil stays within its viscosities, to 1e-9 K."""
    inside = float(np.mean(np.asarray(oil.line.temperature, dtype=float)))
    return _last_known(oil, inside, COLDEST + 1e-3), _last_known(oil, inside, HOTTEST - 1e-3)


def _last_known(oil: Oil, known: float, end: float) -> float:
    if _known(oil, end):
        return end
    for _ in range(_HALVINGS):
        middle = 0.5 * (known + end)
        known, end = (middle, end) if _known(oil, middle) else (known, middle)
    return known


def _known(oil: Oil, temperature: float) -> bool:
    try:
        kinematic_viscosity(oil.line, temperature)
    except NumericalFailure:
        return False
    return True


# ----------------------------------------------------------------------------
# What becomes of a tuned absorber while its oil warms.
# ----------------------------------------------------------------------------


class Warming(NamedTuple):
    """Over temperature (n,) in K: damping in N m s/rad, the same referred to the primary, peak.

    `secondary_damping` is c2 / (2 sqrt(K1 J1)); `penalty` the peak over the least one, less 1.
    """

    temperature: FloatArray
    damping: Bounded
    secondary_damping: Bounded
    peak: Bounded
    penalty: FloatArray


def warming(
    temperature: ArrayLike,
    damping_at: Callable[[FloatArray], Bounded],
    primary_stiffness: float,
    primary_inertia: float,
    peak_of: Callable[[FloatArray], Bounded],
    least_peak: float,
) -> Warming:
    """Damping, its ratio and the peak of the primary at each temperature (n,) in K.

    `damping_at` gives the damping of the gap (N m s/rad), `peak_of` the largest amplification for
    secondary dampings (n,) with everything else as built, both with errors; the error of the
    damping is carried into the peak by a difference. Stiffnesses are taken as constant: those of
    steel fall by some 3 per cent over 100 K.
    """
    (warm,) = floats(temperature)
    damping = damping_at(warm)
    scale = 2.0 * np.sqrt(primary_stiffness * primary_inertia)
    value = damping.value / scale
    share = Bounded(value, damping.error / scale + 2.0 * UNIT_ROUNDOFF * value)
    peak = peak_of(value)
    step = 1e-6 * value
    slope = np.abs(peak_of(value + step).value - peak.value) / step
    uncertainty = peak.error + share.error * (slope + 2.0 * peak.error / step)
    return Warming(
        warm, damping, share, Bounded(peak.value, uncertainty), peak.value / least_peak - 1.0
    )
