"""Crankshafts by IACS UR M53: stress concentration, fatigue strength, what torsion may add."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.rounding import FloatArray

if TYPE_CHECKING:
    from vibecalc.torsion.question_tables import Crank, CrankBending
    from vibecalc.torsion.shaft_line_tables import Throw

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
