"""Limits on torsional stress against speed, separation margins: rules as data, what they say."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import BoolArray, FloatArray, floats

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
# Limits on torsional vibration against speed, and separations: what a rule of `shaft_rules` says.
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
