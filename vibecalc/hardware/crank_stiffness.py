"""Equivalent length and torsional stiffness of one crank throw, by formulas that differ.

A throw between the middles of two journals is as stiff as a plain round shaft of diameter D_e and
length L_e. All formulas here have one form,

    L_e / D_e^4 = journal / (D_j^4 - d_j^4) + pin / (D_c^4 - d_c^4) + web / (h b^3),

with lengths `journal`, `pin` and `web` made of the journal L_j, the pin L_c, the web thickness h,
its width b and the crank radius R. Journals and pin twist, webs bend; the formulas allow in
different ways for what the joints give. None counts the fillets, the clearance in the bearings or
the overlap of pin and journal: the spread between them is an estimate of doubt, not a bound.
BICERA's own method (Nestorides 1958) reads its allowances from charts and is not among them.
"""

import math
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.closed_form import closed_form, floats
from vibecalc.numerics.rounding import WithError
from vibecalc.numerics.typing import FloatArray


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


def throw_flexibility(throw: Throw, formula: str = "carter") -> WithError:
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
    value = journal / _fourth_powers(d_j, b_j) + pin / _fourth_powers(d_c, b_c) + web
    found = closed_form(value, 20.0)
    # what the crank radius less the diameters loses in its difference
    return found._replace(error=found.error + closed_form(4.0 * web * r / free, 1.0).error)


def throw_stiffness(throw: Throw, shear_modulus: FloatArray, formula: str = "carter") -> WithError:
    """pi G / 32 over `throw_flexibility`, in N m/rad; shear modulus G in Pa (eq. 4.9)."""
    flexible = throw_flexibility(throw, formula)
    (modulus,) = floats(shear_modulus)
    value = math.pi / 32.0 * modulus / flexible.value
    error = closed_form(value, 5.0).error + np.abs(value) * flexible.error / flexible.value
    return WithError(np.asarray(value), np.asarray(error))


class StiffnessSpread(NamedTuple):
    """What the formulas that apply say of one throw, (f, ...) each, and how far they are apart.

    `doubt` (...) is half of (largest - smallest) over their middle: a relative measure.
    """

    formulas: tuple[str, ...]
    stiffness: FloatArray
    error: FloatArray
    doubt: FloatArray
    left_out: tuple[str, ...]


def stiffness_spread(
    throw: Throw, shear_modulus: FloatArray, formulas: tuple[str, ...] = tuple(THROW_FORMULAS)
) -> StiffnessSpread:
    """All named formulas side by side; those that do not apply are listed in `left_out`."""
    found: dict[str, WithError] = {}
    left: list[str] = []
    for name in formulas:
        try:
            found[name] = throw_stiffness(throw, shear_modulus, name)
        except NumericalFailure:
            left.append(name)
    if not found:
        raise NumericalFailure("none of the formulas applies to this throw")
    stiffness = np.stack([one.value for one in found.values()])
    low, high = stiffness.min(axis=0), stiffness.max(axis=0)
    error = np.stack([one.error for one in found.values()])
    return StiffnessSpread(
        tuple(found), stiffness, error, np.asarray((high - low) / (high + low)), tuple(left)
    )


def _fourth_powers(outer: FloatArray, inner: FloatArray) -> FloatArray:
    return np.asarray((outer - inner) * (outer + inner) * (outer * outer + inner * inner))
