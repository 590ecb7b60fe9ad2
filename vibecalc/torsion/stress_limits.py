"""Limits on torsional stress of shafts and crankshafts, separation margins: rules as data."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import BoolArray, FloatArray, floats

if TYPE_CHECKING:
    from vibecalc.torsion.question_tables import Crank, CrankBending
    from vibecalc.torsion.shaft_line_tables import Throw

# ----------------------------------------------------------------------------
# Rules for torsional vibration of shafts, as data: edition, scope and numbers, all informative.
#
# A verdict by these rules is a reading aid. The societies apply their own current text; what is
# written here follows the editions named and has not been checked against a bought copy.
# ----------------------------------------------------------------------------


class Rule(NamedTuple):
    """Where a limit comes from, what it is for and what it is not for."""

    name: str
    edition: str
    scope: str
    not_for: str
    measure: str
    status: str = "informative"


M68 = Rule(
    "IACS UR M68",
    "Rev.3, February 2021",
    "propulsion shafts (intermediate, thrust and propeller shafts) of traditional forged design, "
    "from 0 to 105 % of the rated speed",
    "crankshafts (UR M53), shafts of gears, electric motors, generators and turbines, additional "
    "strengthening for ice",
    "half range of the synthesis of all orders, nominal stress of the plain section",
)
API_618 = Rule(
    "API 618 torsional separation",
    "5th edition, 2007",
    "trains with reciprocating compressors: undamped torsional natural frequencies",
    "stress or torque limits; engines under a classification rule",
    "distance of a natural frequency from multiples of the operating speed",
)
API_684 = Rule(
    "API 617 / 684 torsional separation",
    "API RP 684, 2nd edition, 2005",
    "trains of turbomachinery: undamped torsional natural frequencies",
    "reciprocating machines with many orders",
    "distance of a natural frequency from one and two times the operating speed",
)
API_671 = Rule(
    "API 671",
    "4th edition, 2007",
    "special-purpose couplings: data sheet of stiffness and torque; separation as API 684",
    "limits on torsional stress",
    "distance of a natural frequency from one and two times the operating speed",
)
M53 = Rule(
    "IACS UR M53",
    "Rev.5, May 2023",
    "solid forged or cast crankshafts with one throw between main bearings: fillets of pin and "
    "journal, outlet of a radial oil bore in the pin",
    "semi-built crankshafts (journal fillets, shrink fits), surface treatment, proportions outside "
    "of its formulas; bending stresses are those of the case",
    "half range of the synthesis of all orders, nominal stress of the pin, with which the fatigue "
    "strength is 1.15 of the equivalent stress where that is least",
)
ALTERNATING_SHARE = Rule(
    "alternating torque of gears",
    "share of the case",
    "gears: half range of the vibratory torque over the mean torque at the operating speed",
    "reversal of the torque at other speeds, which hammering tells",
    "half range of the synthesis of all orders, on the first wheel",
)
TORQUE_TABLE = Rule(
    "torque table of the case",
    "as given",
    "what the case says it is for",
    "speeds outside the table",
    "half range of the synthesis of all orders, on its own shaft; of a gear on its first wheel",
)
USER_TABLE = Rule(
    "table of the case",
    "as given",
    "what the case says it is for",
    "speeds outside the table",
    "as the case says",
)


class Separation(NamedTuple):
    """Least relative distance from the range of each order; orders not listed carry none."""

    rule: Rule
    margin: dict[float, float]


SEPARATIONS = {
    "api_618": Separation(API_618, {1.0: 0.10, **{float(n): 0.05 for n in range(2, 11)}}),
    "api_684": Separation(API_684, {1.0: 0.10, 2.0: 0.10}),
    "api_671": Separation(API_671, {1.0: 0.10, 2.0: 0.10}),
}

#: Pa: tensile strength that M68 lets count at most, of carbon steel
STRENGTH_CAP = 600e6

# ----------------------------------------------------------------------------
# Limits on torsional vibration against speed, and separations: what a rule says.
#
# Everything here is informative. IACS UR M68 is for propulsion shafts and says nothing of
# crankshafts. Stresses are half ranges of the synthesis of all orders, in Pa; speeds in rad/s.
# ----------------------------------------------------------------------------

#: c_K of M68 (M68.5, table of factors): `propeller_*` from the aftmost bearing to the propeller,
#: `propeller_forward` from there to the stern tube seal
SHAFT_KINDS = {
    "flange": 1.0,
    "shrink_fit": 1.0,
    "keyway_taper": 0.60,
    "keyway_cylinder": 0.45,
    "radial_hole": 0.50,
    "longitudinal_slot": 0.30,
    "thrust_collar": 0.85,
    "thrust_roller_bearing": 0.85,
    "propeller_flange": 0.55,
    "propeller_keyless": 0.55,
    "propeller_keyed": 0.55,
    "propeller_forward": 0.80,
}

#: M68 covers speed ratios from 0 to this
HIGHEST_RATIO = 1.05
#: from this ratio on M68 wants continuous running to be possible: no barred range
NO_BARRED_RANGE = 0.8


class StressLimits(NamedTuple):
    """Permissible stresses (...) in Pa."""

    continuous: FloatArray
    transient: FloatArray


def covered(speed_ratio: ArrayLike) -> BoolArray:
    """Where M68 says anything: speed over rated speed from 0 to 1.05."""
    (ratio,) = floats(speed_ratio)
    return np.asarray((ratio >= 0.0) & (ratio <= HIGHEST_RATIO))


def counted_strength(tensile_strength: ArrayLike) -> FloatArray:
    """Tensile strength in Pa that M68 lets count: up to a cap."""
    (strength,) = floats(tensile_strength)
    return np.asarray(np.minimum(strength, STRENGTH_CAP))


def size_factor(diameter: ArrayLike) -> FloatArray:
    """c_D of M68, 0.35 + 0.93 d^-0.2 with d in mm, for outer diameters in m."""
    (wide,) = floats(diameter)
    return np.asarray(0.35 + 0.93 * (wide / 1e-3) ** -0.2)


def propulsion_shaft_limits(
    speed_ratio: ArrayLike,
    tensile_strength: ArrayLike,
    diameter: ArrayLike,
    design_factor: float = 1.0,
) -> StressLimits:
    """tau_C and tau_T of IACS UR M68 for propulsion shafts, NOT for crankshafts.

    tau_C = (sigma_B + 160) / 18 c_K c_D (3 - 2 lambda^2) in N/mm^2, with 1.38 in place of the
    bracket from lambda = 0.9 on; c_D = 0.35 + 0.93 d^-0.2, d in mm; tau_T = 1.7 tau_C / sqrt(c_K).
    Tensile strength in Pa (counted up to a cap), outer diameter in m; `design_factor` is c_K, 1
    for an intermediate shaft with a flange. NumericalFailure where the rule does not cover a speed
    ratio (`covered`).
    """
    ratio, strength, wide = floats(speed_ratio, tensile_strength, diameter)
    if not np.all(covered(ratio)):
        worst = float(ratio.flat[int(np.argmax(np.abs(ratio - 0.5)))])
        raise NumericalFailure(
            f"IACS UR M68 has no limit at {worst:g} of the rated speed; it covers 0 to 1.05"
        )
    counted, size = counted_strength(strength), size_factor(wide)
    speed_factor = np.where(ratio < 0.9, 3.0 - 2.0 * ratio**2, 1.38)
    steady = (counted / 1e6 + 160.0) / 18.0 * design_factor * size * speed_factor * 1e6
    return StressLimits(np.asarray(steady), np.asarray(1.7 * steady / np.sqrt(design_factor)))


class BarredRange(NamedTuple):
    """Speeds (...) in rad/s to be passed through quickly, and whether a rule lets one be there."""

    lower: FloatArray
    upper: FloatArray
    permitted: BoolArray


def barred_range(critical_speed: ArrayLike, rated_speed: ArrayLike) -> BarredRange:
    """16 n_c / (18 - lambda) to (18 - lambda) n_c / 16 with lambda = n_c / n_0 (IACS UR M68).

    `permitted` is false from lambda = 0.8 on: there the range has to be designed away. Critical
    speeds above the covered range, lambda > 1.05, raise NumericalFailure.
    """
    critical, rated = floats(critical_speed, rated_speed)
    ratio = critical / rated
    if not np.all(covered(ratio)):
        raise NumericalFailure("IACS UR M68 bars no range about a speed above 1.05 of the rated")
    width = 18.0 - ratio
    return BarredRange(
        np.asarray(16.0 * critical / width),
        np.asarray(width * critical / 16.0),
        np.asarray(ratio < NO_BARRED_RANGE),
    )


class SeparationVerdict(NamedTuple):
    """`margin` (m, q): relative distance of each frequency from the range of each order.

    Negative inside the range, by how far the nearer end is; `kept` (m, q).
    """

    margin: FloatArray
    kept: BoolArray


def separation(
    natural_frequency: ArrayLike,
    order: ArrayLike,
    lowest_speed: float,
    highest_speed: float,
    rule: str = "api_618",
) -> SeparationVerdict:
    """Separation of natural frequencies (m,) in rad/s from orders (q,) of a range of speeds.

    The distance is relative to the end of the range q [lowest, highest] that is nearer; orders are
    positive.
    """
    frequency, orders = floats(natural_frequency, order)
    asked = SEPARATIONS[rule].margin
    low, high = orders * lowest_speed, orders * highest_speed
    # a range that begins at rest has no side below
    below = np.where(low > 0.0, (low - frequency[:, None]) / np.where(low > 0.0, low, 1.0), -1.0)
    above = (frequency[:, None] - high) / high
    required = np.array([asked.get(float(q), 0.0) for q in orders])
    margin = np.maximum(below, above)
    return SeparationVerdict(margin, (margin >= required) | (required == 0.0))


# ----------------------------------------------------------------------------
# Proportions of a solid crank throw, and the ranges that the formulas hold in.
#
# All of this is IACS UR M53, Rev.5, May 2023, as the rules of the Korean Register for steel ships,
# 2025, Part 5, print it too; the factors of the fillets are those of the FVV, those of the oil bore
# of the ESDU. Where a printing has cut off their last digits, 0.857 b^3 and 1.5276 w^2 hold.
# Informative.
# ----------------------------------------------------------------------------

#: where a throw is judged, in this order everywhere
PLACES = ("pin fillet", "journal fillet", "oil bore")
#: what the fatigue strength has to be of the equivalent stress, at least
ACCEPTABILITY = 1.15
#: factor K of how a crankshaft is made, without surface treatment
CRANKSHAFT_KINDS = {
    "continuous_grain_flow": 1.05,
    "free_form": 1.0,
    "cast_cold_rolled": 0.93,
}
#: mm: a radius counts as no less
_LEAST_RADIUS = 2.0


class CrankThrow(NamedTuple):
    """Dimensions of throws (r,) in m; `oil_bore` is 0 where the pin has none."""

    pin_diameter: FloatArray
    pin_bore: FloatArray
    journal_diameter: FloatArray
    journal_bore: FloatArray
    web_thickness: FloatArray
    web_width: FloatArray
    crank_radius: FloatArray
    pin_fillet: FloatArray
    journal_fillet: FloatArray
    pin_recess: FloatArray
    journal_recess: FloatArray
    oil_bore: FloatArray


def crank_throws(given: "Sequence[Crank | Throw]", crank_radius: float) -> CrankThrow:
    """Dimensions (r,) of throws of a case."""
    keys = CrankThrow._fields
    rows = [
        [crank_radius if key == "crank_radius" else getattr(one, key) or 0.0 for key in keys]
        for one in given
    ]
    return CrankThrow(*np.array(rows, dtype=float).reshape(-1, len(keys)).T)


class Proportions(NamedTuple):
    """Over the diameter of the pin (r,): names as M53 has them."""

    r_h: FloatArray
    r_g: FloatArray
    s: FloatArray
    w: FloatArray
    b: FloatArray
    d_o: FloatArray
    d_g: FloatArray
    d_h: FloatArray


#: of each proportion what it is, and the range that the formulas hold in. M53 lets overlaps below
#: -0.5 count as -0.5 in some of its factors, which is left out here
RANGES = {
    "r_h": ("fillet radius of the pin", 0.03, 0.13),
    "r_g": ("fillet radius of the journal", 0.03, 0.13),
    "s": ("overlap of pin and journal", -0.5, 0.5),
    "w": ("web thickness", 0.2, 0.8),
    "b": ("web width", 1.1, 2.2),
    "d_o": ("oil bore", 0.0, 0.2),
    "d_g": ("bore of the journal", 0.0, 0.8),
    "d_h": ("bore of the pin", 0.0, 0.8),
}


def proportions(throw: CrankThrow) -> Proportions:
    """Fillets, overlap S = (D + D_G) / 2 - E, web and bores over the pin diameter D."""
    wide = np.asarray(throw.pin_diameter)
    overlap = 0.5 * (wide + throw.journal_diameter) - throw.crank_radius
    return Proportions(
        throw.pin_fillet / wide,
        throw.journal_fillet / wide,
        overlap / wide,
        throw.web_thickness / wide,
        throw.web_width / wide,
        throw.oil_bore / wide,
        throw.journal_bore / wide,
        throw.pin_bore / wide,
    )


# ----------------------------------------------------------------------------
# Stress concentration factors (M53.3).
# ----------------------------------------------------------------------------


class Concentration(NamedTuple):
    """`bending` and `torsion` (r, 3) at the `PLACES`, `compression` (r,) in the journal fillet.

    alpha_B, beta_B, gamma_B; alpha_T, beta_T, gamma_T; beta_Q. Those of a bore that is not there
    are 0.
    """

    bending: FloatArray
    torsion: FloatArray
    compression: FloatArray


def _polynomial(x: FloatArray, *coefficients: float) -> FloatArray:
    return np.asarray(np.polynomial.polynomial.polyval(x, coefficients))


def stress_concentration(throw: CrankThrow) -> Concentration:
    """Factors of the fillets on nominal stresses of web and pin, of the bore on those of the pin.

    Proportions are within `RANGES`. The journal fillet counts by its own diameter in torsion.
    """
    one = proportions(throw)
    s, w, b, away = one.s, one.w, one.b, 1.0 - one.s
    recess = (throw.pin_recess + throw.journal_recess) / throw.pin_diameter
    recess = np.maximum(1.0 + recess * (1.8 + 3.2 * s), 1.0)
    pin = 2.6914 * recess * (
        _polynomial(w, -4.1883, 29.2004, -77.5925, 91.9454, -40.0416)
        + away * _polynomial(w, 9.5440, -58.3480, 159.3415, -192.5846, 85.2916)
        + away**2 * _polynomial(w, -3.8399, 25.0444, -70.5571, 87.0328, -39.1832)
    )  # fmt: skip
    pin = pin * 2.1790 * w**0.7171 * _polynomial(b, 0.6840, -0.0077, 0.1473)
    pin = pin * 0.2081 * one.r_h**-0.5231 * _polynomial(one.d_g, 0.9993, 0.27, -1.0211, 0.5306)
    pin = pin * _polynomial(one.d_h, 0.9978, 0.3145, -1.5241, 2.4147)
    journal = 2.7146 * recess * (
        _polynomial(w, -1.7625, 2.9821, -1.5276)
        + away * _polynomial(w, 5.1169, -5.8089, 3.1391)
        + away**2 * _polynomial(w, -2.1567, 2.3297, -1.2952)
    )  # fmt: skip
    journal = journal * 2.2422 * w**0.7548 * _polynomial(b, 0.5616, 0.1197, 0.1176)
    journal = journal * 0.1908 * one.r_g**-0.5568 * _polynomial(one.d_g, 1.0012, -0.6441, 1.2265)
    journal = journal * _polynomial(one.d_h, 1.0022, -0.1903, 0.0073)
    compression = 3.0128 * recess * _polynomial(away, 0.4368, 2.1630, -1.5212)
    compression = compression * w / (0.0637 + 0.9369 * w) * (b - 0.5)
    compression = compression * 0.5331 * one.r_g**-0.2038
    compression = compression * _polynomial(one.d_h, 0.9937, -1.1949, 1.7373)
    shape = 0.8 * _polynomial(b, 7.8955, -10.654, 5.3482, -0.857) * w**-0.145
    power = -0.322 + 0.1015 * away
    of_journal = throw.journal_fillet / throw.journal_diameter
    bored = np.asarray(throw.oil_bore) > 0.0
    bore_bending = np.where(bored, _polynomial(one.d_o, 3.0, -5.88, 34.6), 0.0)
    bore_torsion = np.where(bored, _polynomial(one.d_o, 4.0, -6.0, 30.0), 0.0)
    torsion = shape * one.r_h**power, shape * of_journal**power, bore_torsion
    return Concentration(
        np.stack(np.broadcast_arrays(pin, journal, bore_bending), axis=-1),
        np.stack(np.broadcast_arrays(*torsion), axis=-1),
        np.asarray(compression),
    )


# ----------------------------------------------------------------------------
# Fatigue strength (M53.6), equivalent stress (M53.5) and what it leaves for torsion (M53.7).
# ----------------------------------------------------------------------------


def fatigue_strength(
    throw: CrankThrow, tensile_strength: ArrayLike, kind_factor: ArrayLike
) -> FloatArray:
    """sigma_DW (r, 3) in Pa at the `PLACES`; a factor K above 1 holds in fillets only."""
    wide = np.stack([throw.pin_diameter, throw.journal_diameter, throw.pin_diameter], axis=-1)
    round_ = np.stack([throw.pin_fillet, throw.journal_fillet, 0.5 * throw.oil_bore], axis=-1)
    strength = np.asarray(tensile_strength, dtype=float)[..., None] / 1e6
    radius = np.maximum(round_ / 1e-3, _LEAST_RADIUS)
    factor = np.asarray(kind_factor, dtype=float)[..., None]
    factor = factor * np.array([1.0, 1.0, 0.0]) + np.minimum(factor, 1.0) * [0.0, 0.0, 1.0]
    size = 0.264 + 1.073 * (wide / 1e-3) ** -0.2
    notch = (785.0 - strength) / 4900.0 + 196.0 / strength * np.sqrt(1.0 / radius)
    return np.asarray(factor * (0.42 * strength + 39.3) * (size + notch) * 1e6)


def bending_stresses(concentration: Concentration, bending: "CrankBending") -> FloatArray:
    """Alternating bending stresses (r, 3) in Pa at the `PLACES`, the additional one in fillets."""
    factor = concentration.bending
    pin = factor[..., 0] * bending.web + bending.additional
    journal = factor[..., 1] * bending.web + concentration.compression * bending.compressive
    bore = factor[..., 2] * (bending.oil_bore or 0.0)
    return np.stack(np.broadcast_arrays(pin, journal + bending.additional, bore), axis=-1)


def torsion_ratio(throw: CrankThrow) -> FloatArray:
    """Nominal torsional stresses (r, 3) at the `PLACES` over that of the pin."""
    pin, journal = (
        (wide**4 - bore**4) / wide
        for wide, bore in (
            (np.asarray(throw.pin_diameter), throw.pin_bore),
            (np.asarray(throw.journal_diameter), throw.journal_bore),
        )
    )
    one = np.ones_like(pin)
    return np.stack([one, pin / journal, one], axis=-1)


def equivalent_stress(bending: FloatArray, torsion: FloatArray) -> FloatArray:
    """sigma_v (..., 3) in Pa of bending and torsional stresses at the `PLACES`.

    Von Mises in fillets; at the bore the principal stress, sigma_BO / 3 (1 + 2 sqrt(1 + 9/4
    (sigma_TO / sigma_BO)^2)).
    """
    fillet = np.hypot(bending, np.sqrt(3.0) * torsion)
    bore = (bending + 2.0 * np.hypot(bending, 1.5 * torsion)) / 3.0
    return np.asarray(np.where(np.array([False, False, True]), bore, fillet))


def permissible_torsion(bending: FloatArray, strength: FloatArray) -> FloatArray:
    """Torsional stresses (..., 3) at the `PLACES` with which sigma_DW = 1.15 sigma_v.

    0 where bending alone is more than that.
    """
    most = strength / ACCEPTABILITY
    fillet = (most - bending) * (most + bending) / 3.0
    half = 0.5 * (3.0 * most - bending)
    bore = 4.0 / 9.0 * (half - bending) * (half + bending)
    square = np.where(np.array([False, False, True]), bore, fillet)
    return np.asarray(np.sqrt(np.maximum(np.where(most > bending, square, 0.0), 0.0)))
