"""Stiffness, section modulus and inertia of shafts and crank throws from their dimensions."""

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.gauss import gauss_rule
from vibecalc.numerics.rounding import FloatArray

if TYPE_CHECKING:
    from vibecalc.torsion.shaft_line_tables import Throw

# ----------------------------------------------------------------------------
# Stiffness and section modulus of round shafts in torsion: plain, hollow, tapered.
#
# Saint-Venant torsion of each slice; the extra give of a fillet is not counted. Lengths and
# diameters in m, shear modulus in Pa, stiffness in N m/rad. All formulas here are right to
# roundings.
# ----------------------------------------------------------------------------

#: points of the two Gauss rules whose difference bounds the error of the shorter one
_COARSE, _FINE = 20, 30
#: share of the stiffness above which they disagree too much
_SETTLED = 1e-13
#: outer and inner diameter
Ring = tuple[float, float]


def fourth_powers(outer: float | FloatArray, inner: float | FloatArray) -> float | FloatArray:
    """D^4 - d^4 as a product, which keeps its digits for a thin tube."""
    return (outer - inner) * (outer + inner) * (outer * outer + inner * inner)


def section_modulus(outer: float, bore: float = 0.0) -> float:
    """Polar section modulus pi (D^4 - d^4) / (16 D) in m^3: torque over largest shear stress."""
    return math.pi / 16.0 * float(fourth_powers(outer, bore)) / outer


def shaft_stiffness(shear_modulus: float, length: float, ends: tuple[Ring, Ring]) -> float:
    """Stiffness of one part: G I_p / L, or of a cone when its ends differ.

    Of a cone both diameters run straight from one end to the other. A solid one is closed,
    1/k = 32 L (D1^2 + D1 D2 + D2^2) / (3 pi G D1^3 D2^3); a hollow one is integrated, and
    NumericalFailure says where its wall is too thin at an end for that.
    """
    (outer, inner), (last, bore) = ends
    factor = math.pi / 32.0 * shear_modulus / length
    if ends[0] == ends[1]:
        return factor * float(fourth_powers(outer, inner))
    if inner == bore == 0.0:
        return factor * 3.0 * outer**3 * last**3 / (outer**2 + outer * last + last**2)

    def mean_flexibility(points: int) -> float:
        rule = gauss_rule(points)
        wide = outer * (1.0 - rule.nodes) + last * rule.nodes
        hole = inner * (1.0 - rule.nodes) + bore * rule.nodes
        return float(np.sum(rule.weights / fourth_powers(wide, hole)))

    fine = mean_flexibility(_FINE)
    if abs(fine - mean_flexibility(_COARSE)) > _SETTLED * fine:
        raise NumericalFailure("a hollow cone runs out to a wall too thin for its stiffness")
    return factor / fine


# ----------------------------------------------------------------------------
# Moment of inertia of one crank throw about the axis of the crankshaft, from its dimensions.
#
# Baca (2007, section 4.3.1) sums journal, pin, two webs, rod, piston with gudgeon pin and balance
# weight and gives no formula for any of them. Each part is an exact integral over a plain body
# here; fillets, oil holes and chamfers are left out. Lengths in m, masses in kg, density in kg/m^3,
# inertias in kg m^2.
# ----------------------------------------------------------------------------


def journal_inertia(density: float, diameter: float, length: float, bore: float = 0.0) -> float:
    """Of a round journal on the axis: pi rho L (D^4 - d^4) / 32; bore < diameter."""
    return math.pi / 32.0 * density * length * float(fourth_powers(diameter, bore))


def pin_inertia(
    density: float, diameter: float, length: float, crank_radius: float, bore: float = 0.0
) -> float:
    """Of a crank pin whose centre runs at `crank_radius`: m (R^2 + (D^2 + d^2) / 8)."""
    mass = 0.25 * math.pi * density * length * (diameter - bore) * (diameter + bore)
    return mass * (crank_radius**2 + (diameter**2 + bore**2) / 8.0)


def rectangular_web_inertia(
    density: float, thickness: float, width: float, behind: float, top: float
) -> float:
    """Of one web, a plate `width` across the throw.

    Along the throw it reaches from `behind` the axis of the journal to `top` above it.
    """
    # integral of y^2 + x^2 over the plate; the cubes of both ends count with the same sign
    along = width * (top**3 + behind**3) / 3.0
    across = width**3 * (top + behind) / 12.0
    return density * thickness * (along + across)


def disc_ended_web_inertia(
    density: float, thickness: float, width: float, crank_radius: float
) -> float:
    """Of one web of straight flanks, ended by half discs about the axes of journal and pin."""
    end, radius = 0.5 * width, crank_radius
    straight = width * radius**3 / 3.0 + width**3 * radius / 12.0
    half = 0.5 * math.pi * end**2
    # the centre of a half disc lies 4 r / (3 pi) from its flat
    at_pin = half * (radius**2 + 2.0 * radius * 4.0 * end / (3.0 * math.pi) + 0.5 * end**2)
    return density * thickness * (straight + at_pin + half * 0.5 * end**2)


def reciprocating_inertia(mass: float, crank_radius: float, rod_length: float) -> float:
    """What a mass that goes up and down adds to the crank, a constant in place of its course.

    The mean over a turn of m (dx / d theta)^2, m R^2 / (1 + sqrt(1 - (R / L)^2)), exact for a
    centred slider-crank. The inertia swings between zero at the dead centres and about twice that.
    """
    ratio = crank_radius / rod_length
    return mass * crank_radius**2 / (1.0 + math.sqrt((1.0 - ratio) * (1.0 + ratio)))


def throw_inertia(throw: "Throw", crank_radius: float) -> float:
    """Of journal, pin, two webs and their weights."""
    density, thick, width = throw.density, throw.web_thickness, throw.web_width
    behind, past = throw.beyond_journal, throw.beyond_pin
    if behind is None or past is None:
        web = disc_ended_web_inertia(density, thick, width, crank_radius)
    else:
        web = rectangular_web_inertia(density, thick, width, behind, crank_radius + past)
    journal = throw.journal_diameter, throw.journal_length, throw.journal_bore
    pin = throw.pin_diameter, throw.pin_length, crank_radius, throw.pin_bore
    metal = journal_inertia(density, *journal) + pin_inertia(density, *pin) + 2.0 * web
    return metal + throw.balance_weight_inertia


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


def throw_stiffness(throw: "Throw", crank_radius: float, formula: str) -> float:
    """Stiffness of a throw in N m/rad, pi G / 32 over L_e / D_e^4 (eq. 4.9).

    `formula` is a name of `THROW_FORMULAS`. NumericalFailure where a formula is asked outside what
    it can mean: a web that is shorter than what it takes off for pin and journal.
    """
    rule, width = THROW_FORMULAS[formula], throw.web_width
    journal, pin, thick = throw.journal_diameter, throw.pin_diameter, throw.web_thickness
    free = crank_radius - rule.web_diameters * (journal + pin)
    if free <= 0.0:
        raise NumericalFailure(
            f"the {formula} formula has no web left: the crank radius is not above "
            f"{rule.web_diameters:g} times the sum of the diameters of journal and pin"
        )
    along = throw.journal_length + rule.journal_by_web * thick + rule.journal_by_diameter * journal
    over = rule.pin_length * throw.pin_length + rule.pin_by_web * thick + rule.pin_by_diameter * pin
    flexibility = (
        along / fourth_powers(journal, throw.journal_bore)
        + over / fourth_powers(pin, throw.pin_bore)
        + rule.web * free / (thick * width**3)
    )
    return float(math.pi / 32.0 * throw.shear_modulus / flexibility)


def stiffness_by_formula(throw: "Throw", crank_radius: float) -> dict[str, float]:
    """What each of the formulas that apply says of one throw, in N m/rad."""
    found: dict[str, float] = {}
    for name in THROW_FORMULAS:
        try:
            found[name] = throw_stiffness(throw, crank_radius, name)
        except NumericalFailure:  # a formula that has no web left
            continue
    return found
