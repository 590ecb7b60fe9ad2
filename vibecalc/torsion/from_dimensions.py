"""Stiffness, section modulus and inertia of shafts and crank throws from their dimensions."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.numerics.gauss import gauss_rule
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, FloatArray, floats

# ----------------------------------------------------------------------------
# Stiffness and section modulus of round shafts in torsion: plain, hollow, tapered.
#
# Saint-Venant torsion of each slice; the extra give of a fillet is not counted.
# Lengths and diameters in m, shear modulus in Pa, stiffness in N m/rad.
# ----------------------------------------------------------------------------

#: points of the two Gauss rules whose difference bounds the error of the shorter one
_COARSE, _FINE = 20, 30
#: share of the stiffness above which they disagree too much
_SETTLED = 1e-13


def section_modulus(diameter: ArrayLike, bore: ArrayLike = 0.0) -> Bounded:
    """Polar section modulus pi (D^4 - d^4) / (16 D) in m^3: torque over largest shear stress."""
    outer, inner = floats(diameter, bore)
    return rounded(math.pi / 16.0 * _fourth_powers(outer, inner) / outer, 10.0)


def shaft_stiffness(
    shear_modulus: ArrayLike,
    length: ArrayLike,
    diameter: ArrayLike,
    bore: ArrayLike = 0.0,
    end_diameter: ArrayLike | None = None,
    end_bore: ArrayLike | None = None,
) -> Bounded:
    """Stiffness of one part: G I_p / L, or of a cone when an end differs.

    With `end_diameter` or `end_bore` both diameters run straight from one end to the other. A solid
    cone is closed, 1/k = 32 L (D1^2 + D1 D2 + D2^2) / (3 pi G D1^3 D2^3); a hollow one is
    integrated, and NumericalFailure says where its wall is too thin at an end for that.
    """
    modulus, long, outer, inner = floats(shear_modulus, length, diameter, bore)
    if end_diameter is None and end_bore is None:
        return rounded(math.pi / 32.0 * modulus * _fourth_powers(outer, inner) / long, 12.0)
    last = outer if end_diameter is None else np.asarray(end_diameter, dtype=float)
    bore_last = inner if end_bore is None else np.asarray(end_bore, dtype=float)
    if not np.any(inner) and not np.any(bore_last):
        mixed = (outer**2 + outer * last + last**2) / (3.0 * outer**3 * last**3)
        return rounded(math.pi / 32.0 * modulus / (long * mixed), 20.0)
    coarse = _mean_flexibility(outer, last, inner, bore_last, _COARSE)
    fine = _mean_flexibility(outer, last, inner, bore_last, _FINE)
    off = np.abs(fine - coarse) / fine
    if np.any(off > _SETTLED):
        raise NumericalFailure("a hollow cone runs out to a wall too thin for its stiffness")
    value = np.asarray(math.pi / 32.0 * modulus / (long * fine))
    # nodes near a thin wall: the difference of the diameters loses what they have in common
    wall = np.minimum((outer - inner) / outer, (last - bore_last) / last)
    return Bounded(value, value * (off + UNIT_ROUNDOFF * (40.0 + 6.0 / wall)))


def _mean_flexibility(
    outer: FloatArray, last: FloatArray, inner: FloatArray, bore_last: FloatArray, points: int
) -> FloatArray:
    """Mean of 1 / (D^4 - d^4) along the part, by a Gauss rule."""
    rule = gauss_rule(points)
    at = rule.nodes
    wide = outer[..., None] * (1.0 - at) + last[..., None] * at
    hole = inner[..., None] * (1.0 - at) + bore_last[..., None] * at
    return np.asarray(np.sum(rule.weights / _fourth_powers(wide, hole), axis=-1))


def _fourth_powers(outer: FloatArray, inner: FloatArray) -> FloatArray:
    """D^4 - d^4 as a product, which keeps its digits for a thin tube."""
    return np.asarray((outer - inner) * (outer + inner) * (outer * outer + inner * inner))


# ----------------------------------------------------------------------------
# Moment of inertia of one crank throw about the axis of the crankshaft, from its dimensions.
#
# Baca (2007, section 4.3.1) sums journal, pin, two webs, rod, piston with gudgeon pin and balance
# weight and gives no formula for any of them. Each part is an exact integral over a plain body
# here; fillets, oil holes and chamfers are left out. Lengths in m, masses in kg, density in kg/m^3,
# inertias in kg m^2; all arguments broadcast.
# ----------------------------------------------------------------------------


def journal_inertia(
    density: ArrayLike, diameter: ArrayLike, length: ArrayLike, bore: ArrayLike = 0.0
) -> Bounded:
    """Of a round journal on the axis: pi rho L (D^4 - d^4) / 32; bore < diameter."""
    heavy, outer, long, inner = floats(density, diameter, length, bore)
    fourth = (outer - inner) * (outer + inner) * (outer * outer + inner * inner)
    return rounded(math.pi / 32.0 * heavy * long * fourth, 12.0)


def pin_inertia(
    density: ArrayLike,
    diameter: ArrayLike,
    length: ArrayLike,
    crank_radius: ArrayLike,
    bore: ArrayLike = 0.0,
) -> Bounded:
    """Of a crank pin whose centre runs at `crank_radius`: m (R^2 + (D^2 + d^2) / 8)."""
    heavy, outer, long, radius, inner = floats(density, diameter, length, crank_radius, bore)
    mass = 0.25 * math.pi * heavy * long * (outer - inner) * (outer + inner)
    return rounded(mass * (radius**2 + (outer**2 + inner**2) / 8.0), 16.0)


def rectangular_web_inertia(
    density: ArrayLike,
    thickness: ArrayLike,
    width: ArrayLike,
    beyond_journal: ArrayLike,
    beyond_pin: ArrayLike,
    crank_radius: ArrayLike,
) -> Bounded:
    """Of one web, a plate `width` across the throw.

    Along the throw it reaches from `beyond_journal` behind the axis of the journal to `beyond_pin`
    past the axis of the pin.
    """
    heavy, thick, wide, behind, past, radius = floats(
        density, thickness, width, beyond_journal, beyond_pin, crank_radius
    )
    top = radius + past
    # integral of y^2 + x^2 over the plate; the cubes of both ends count with the same sign
    along = wide * (top**3 + behind**3) / 3.0
    across = wide**3 * (top + behind) / 12.0
    return rounded(heavy * thick * (along + across), 16.0)


def disc_ended_web_inertia(
    density: ArrayLike, thickness: ArrayLike, width: ArrayLike, crank_radius: ArrayLike
) -> Bounded:
    """Of one web of straight flanks, ended by half discs about the axes of journal and pin."""
    heavy, thick, wide, radius = floats(density, thickness, width, crank_radius)
    end = 0.5 * wide
    straight = wide * radius**3 / 3.0 + wide**3 * radius / 12.0
    half = 0.5 * math.pi * end**2
    # the centre of a half disc lies 4 r / (3 pi) from its flat
    at_pin = half * (radius**2 + 2.0 * radius * 4.0 * end / (3.0 * math.pi) + 0.5 * end**2)
    return rounded(heavy * thick * (straight + at_pin + half * 0.5 * end**2), 24.0)


def offset_body_inertia(
    mass: ArrayLike, distance: ArrayLike, own_inertia: ArrayLike = 0.0
) -> Bounded:
    """Of any body whose mass centre runs at `distance`: m r^2 + J of the body about its centre.

    The rotating part of a rod is a point at the crank radius, with `own_inertia` zero.
    """
    heavy, far, own = floats(mass, distance, own_inertia)
    return rounded(heavy * far**2 + own, 4.0)


def reciprocating_inertia(
    mass: ArrayLike, crank_radius: ArrayLike, rod_length: ArrayLike, method: str = "mean"
) -> Bounded:
    """What a mass that goes up and down adds to the crank, a constant in place of its course.

    `"half"`: m R^2 / 2, as if the rod were endless. `"mean"`: the mean over a turn of
    m (dx / d theta)^2, m R^2 / (1 + sqrt(1 - (R / L)^2)), exact for a centred slider-crank. The
    inertia swings between zero at the dead centres and about twice that.
    """
    heavy, radius, rod = floats(mass, crank_radius, rod_length)
    ratio = radius / rod
    if method == "half":
        return rounded(0.5 * heavy * radius**2 * np.ones_like(ratio), 3.0)
    if method != "mean":
        raise ValueError(f"unknown method {method!r}; known: half, mean")
    root = np.sqrt((1.0 - ratio) * (1.0 + ratio))
    value = np.asarray(heavy * radius**2 / (1.0 + root))
    # the root loses digits where crank and rod are nearly of one length
    lost = 8.0 + 2.0 / np.maximum(1.0 - ratio, UNIT_ROUNDOFF)
    return Bounded(value, np.asarray(value * UNIT_ROUNDOFF * lost))


def throw_inertia(*parts: Bounded) -> Bounded:
    """Sum of the parts of a throw; a web counts twice where it is handed over twice."""
    value = np.asarray(sum(np.asarray(part.value, dtype=float) for part in parts))
    error = np.asarray(sum(np.asarray(part.error, dtype=float) for part in parts))
    return Bounded(value, error + len(parts) * UNIT_ROUNDOFF * np.abs(value))


# ----------------------------------------------------------------------------
# Equivalent length and torsional stiffness of one crank throw, by formulas that differ.
#
# A throw between the middles of two journals is as stiff as a plain round shaft of diameter D_e and
# length L_e. All formulas here have one form,
#
#     L_e / D_e^4 = journal / (D_j^4 - d_j^4) + pin / (D_c^4 - d_c^4) + web / (h b^3),
#
# with lengths `journal`, `pin` and `web` made of the journal L_j, the pin L_c, the web thickness h,
# its width b and the crank radius R. Journals and pin twist, webs bend; the formulas allow in
# different ways for what the joints give. None counts the fillets, the clearance in the bearings or
# the overlap of pin and journal: the spread between them is an estimate of uncertainty, not a
# bound. BICERA's own method (Nestorides 1958) reads its allowances from charts and is not among
# them.
# ----------------------------------------------------------------------------


class Throw(NamedTuple):
    """Dimensions of a throw in m, (...) each: one length of journal, one pin, two equal webs."""

    journal_length: FloatArray
    journal_diameter: FloatArray
    journal_bore: FloatArray
    pin_length: FloatArray
    pin_diameter: FloatArray
    pin_bore: FloatArray
    web_thickness: FloatArray
    web_width: FloatArray
    crank_radius: FloatArray


class ThrowFormula(NamedTuple):
    """Multiples of lengths; `web_diameters` takes a share of D_j + D_c off the crank radius."""

    journal_by_web: float
    journal_by_diameter: float
    pin_length: float
    pin_by_web: float
    pin_by_diameter: float
    web: float
    web_diameters: float
    source: str
    suits: str


#: 0.93 is the bending of two webs over R, 12 * 2 * (pi / 32) * G / E for a G / E of 0.395
THROW_FORMULAS = {
    "source": ThrowFormula(
        0.0, 0.0, 1.0, 0.0, 0.0, 0.93, 0.0,
        "Baca (2007), eq. 4.9 as printed",
        "no allowance for the joints of web and pin: an upper bound among these",
    ),
    "timoshenko": ThrowFormula(
        0.9, 0.0, 1.0, 0.9, 0.0, 0.93, 0.0,
        "Timoshenko, journals free in their bearings, for G / E = 0.395",
        "journals with clearance, solid webs",
    ),
    "carter": ThrowFormula(
        0.8, 0.0, 0.75, 0.0, 0.0, 1.5, 0.0,
        "Carter, after Ker Wilson and Nestorides (1958)",
        "flexible webs between stiff journals and pins",
    ),
    "ker_wilson": ThrowFormula(
        0.0, 0.4, 1.0, 0.0, 0.4, 1.0, 0.2,
        "Ker Wilson, after Nestorides (1958)",
        "stiff webs between flexible journals and pins",
    ),
}  # fmt: skip


def throw_flexibility(throw: Throw, formula: str = "carter") -> Bounded:
    """L_e / D_e^4 in 1/m^3, shape (...): equivalent length is this times D_e^4.

    `formula` is a name of `THROW_FORMULAS`. NumericalFailure where a formula is asked outside what
    it can mean: a web that is shorter than what it takes off for pin and journal.
    """
    if formula not in THROW_FORMULAS:
        known = ", ".join(THROW_FORMULAS)
        raise ValueError(f"unknown formula {formula!r}; known: {known}")
    rule = THROW_FORMULAS[formula]
    l_j, d_j, b_j, l_c, d_c, b_c, h, b, r = floats(*throw)
    free = r - rule.web_diameters * (d_j + d_c)
    if np.any(free <= 0.0):
        raise NumericalFailure(
            f"the {formula} formula has no web left: the crank radius is not above "
            f"{rule.web_diameters:g} times the sum of the diameters of journal and pin"
        )
    journal = l_j + rule.journal_by_web * h + rule.journal_by_diameter * d_j
    pin = rule.pin_length * l_c + rule.pin_by_web * h + rule.pin_by_diameter * d_c
    web = rule.web * free / (h * b**3)
    value = journal / _hollow(d_j, b_j) + pin / _hollow(d_c, b_c) + web
    # the last: what the crank radius less the diameters loses in its difference
    return Bounded(value, UNIT_ROUNDOFF * (20.0 * value + 4.0 * web * r / free))


def throw_stiffness(throw: Throw, shear_modulus: FloatArray, formula: str = "carter") -> Bounded:
    """pi G / 32 over `throw_flexibility`, in N m/rad; shear modulus G in Pa (eq. 4.9)."""
    flexible = throw_flexibility(throw, formula)
    (modulus,) = floats(shear_modulus)
    value = math.pi / 32.0 * modulus / flexible.value
    error = rounded(value, 5.0).error + np.abs(value) * flexible.error / flexible.value
    return Bounded(np.asarray(value), np.asarray(error))


class StiffnessSpread(NamedTuple):
    """What the formulas that apply say of one throw, (f, ...) each, and how far they are apart.

    `uncertainty` (...) is half of (largest - smallest) over their middle: a relative measure.
    """

    formulas: tuple[str, ...]
    stiffness: FloatArray
    error: FloatArray
    uncertainty: FloatArray
    left_out: tuple[str, ...]


def stiffness_spread(
    throw: Throw, shear_modulus: FloatArray, formulas: tuple[str, ...] = tuple(THROW_FORMULAS)
) -> StiffnessSpread:
    """All named formulas side by side; those that do not apply are listed in `left_out`."""
    estimates: dict[str, Bounded] = {}
    left: list[str] = []
    for name in formulas:
        try:
            estimates[name] = throw_stiffness(throw, shear_modulus, name)
        except NumericalFailure:
            left.append(name)
    if not estimates:
        raise NumericalFailure("none of the formulas applies to this throw")
    stiffness = np.stack([one.value for one in estimates.values()])
    low, high = stiffness.min(axis=0), stiffness.max(axis=0)
    error = np.stack([one.error for one in estimates.values()])
    return StiffnessSpread(
        tuple(estimates), stiffness, error, np.asarray((high - low) / (high + low)), tuple(left)
    )


def _hollow(outer: FloatArray, inner: FloatArray) -> FloatArray:
    return np.asarray((outer - inner) * (outer + inner) * (outer * outer + inner * inner))
