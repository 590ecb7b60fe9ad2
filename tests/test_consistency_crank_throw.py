"""Claim: inertias of the parts of a throw are those of the bodies, and the parts of a shaft add up
to the whole, against quadrature over the body and closed forms taken apart differently.
"""

import mpmath
import numpy as np
import pytest

from vibecalc.errors import NumericalFailure
from vibecalc.torsion.from_dimensions import (
    THROW_FORMULAS,
    disc_ended_web_inertia,
    journal_inertia,
    pin_inertia,
    reciprocating_inertia,
    rectangular_web_inertia,
    section_modulus,
    shaft_stiffness,
    stiffness_by_formula,
    throw_inertia,
    throw_stiffness,
)
from vibecalc.torsion.shaft_line_tables import Throw

STEEL, SHEAR = 7850.0, 79.3e9
RADIUS = 0.035
#: a throw of an engine of this stroke; journal and pin do not overlap
THROW = Throw(
    journal_length=0.028, journal_diameter=0.040, pin_length=0.030, pin_diameter=0.034,
    web_thickness=0.018, web_width=0.062, density=STEEL, shear_modulus=SHEAR,
    balance_weight_inertia=0.001,
)  # fmt: skip
#: short stroke, thick journal and pin: they overlap
OVERLAPPED = THROW.model_copy(update={"journal_diameter": 0.09, "pin_diameter": 0.09})


def gauss(function, low, high, points=40):
    node, weight = np.polynomial.legendre.leggauss(points)
    half = 0.5 * (high - low)
    return half * np.sum(weight * function(low + half * (1.0 + node)))


def test_webs_against_quadrature_over_the_plate():
    width, thick, past, behind = 0.062, 0.018, 0.03, 0.04

    def strip(y, half):
        return 2.0 * half * y**2 + 2.0 * half**3 / 3.0

    plate = gauss(lambda y: strip(y, 0.5 * width), -behind, RADIUS + past)
    found = rectangular_web_inertia(STEEL, thick, width, behind, RADIUS + past)
    assert found == pytest.approx(STEEL * thick * plate, rel=1e-13)
    # disc ends: in the angle of the rim, which is smooth where the width is not
    end = 0.5 * width

    def rim(centre, side):
        return gauss(
            lambda t: strip(centre + side * end * np.sin(t), end * np.cos(t)) * end * np.cos(t),
            0.0,
            0.5 * np.pi,
        )

    whole = gauss(lambda y: strip(y, end), 0.0, RADIUS) + rim(0.0, -1.0) + rim(RADIUS, 1.0)
    found = disc_ended_web_inertia(STEEL, thick, width, RADIUS)
    assert found == pytest.approx(STEEL * thick * whole, rel=1e-13)


def test_round_parts_and_the_parallel_axis():
    mass = STEEL * np.pi / 4.0 * (0.034**2 - 0.012**2) * 0.03
    moved = journal_inertia(STEEL, 0.034, 0.03, 0.012) + mass * RADIUS**2
    assert pin_inertia(STEEL, 0.034, 0.03, RADIUS, 0.012) == pytest.approx(moved)
    web = disc_ended_web_inertia(STEEL, 0.018, 0.062, RADIUS)
    journal, pin = journal_inertia(STEEL, 0.04, 0.028), pin_inertia(STEEL, 0.034, 0.03, RADIUS)
    assert throw_inertia(THROW, RADIUS) == pytest.approx(journal + pin + 2.0 * web + 0.001)


def test_mean_inertia_of_a_piston_is_the_mean_over_a_turn():
    with mpmath.workdps(30):
        for ratio in (0.05, 0.2846, 0.9):
            k = mpmath.mpf(ratio)

            def speed(t, k=k):
                root = mpmath.sqrt(1 - (k * mpmath.sin(t)) ** 2)
                return (mpmath.sin(t) + k * mpmath.sin(t) * mpmath.cos(t) / root) ** 2

            truth = mpmath.quad(speed, mpmath.linspace(0, 2 * mpmath.pi, 9)) / (2 * mpmath.pi)
            found = reciprocating_inertia(1.0, 1.0, 1.0 / ratio)
            assert found == pytest.approx(float(truth), rel=1e-14)
    assert reciprocating_inertia(2.0, 3.0, 1e9) == pytest.approx(9.0)


def test_formulas_for_a_throw_by_hand():
    one = stiffness_by_formula(THROW, RADIUS)
    # eq. 4.9 in millimetres
    web, slim = 18 * 62**3, 35 - 0.2 * 74
    by_hand = {
        "source": 28 / 40**4 + 30 / 34**4 + 0.93 * 35 / web,
        "timoshenko": (28 + 0.9 * 18) / 40**4 + (30 + 0.9 * 18) / 34**4 + 0.93 * 35 / web,
        "carter": (28 + 0.8 * 18) / 40**4 + 0.75 * 30 / 34**4 + 1.5 * 35 / web,
        "ker_wilson": (28 + 0.4 * 40) / 40**4 + (30 + 0.4 * 34) / 34**4 + slim / web,
    }
    assert one.keys() == by_hand.keys()
    for name, flexible in by_hand.items():
        assert one[name] == pytest.approx(SHEAR * 1e-9 * np.pi / 32.0 / flexible, rel=1e-12)
    # a bore counts like one in a shaft
    bored = throw_stiffness(THROW.model_copy(update={"pin_bore": 0.017}), RADIUS, "source")
    flexible = by_hand["source"] + 30 / 34**4 / (1 - 0.5**4) - 30 / 34**4
    assert bored == pytest.approx(SHEAR * 1e-9 * np.pi / 32.0 / flexible, rel=1e-12)
    # allowances only add: the printed equation is the stiffest of those with whole webs
    assert one["source"] == max(one.values())


def test_a_formula_without_a_web_is_left_out():
    with pytest.raises(NumericalFailure, match="no web left"):
        throw_stiffness(OVERLAPPED, RADIUS, "ker_wilson")
    assert "ker_wilson" not in stiffness_by_formula(OVERLAPPED, RADIUS)


def test_the_factor_of_the_printed_web_is_its_bending():
    # two webs as beams of length R turn by 2 R T / (E h b^3 / 12): for G / E = .395 it is 0.93
    ratio = 79.0 / 200.0
    assert 24.0 * np.pi / 32.0 * ratio == pytest.approx(THROW_FORMULAS["source"].web, abs=0.0015)


@pytest.mark.parametrize(("bore", "last"), [(0.0, 0.0), (0.02, 0.02), (0.03, 0.055)])
def test_cones_against_mpmath(bore, last):
    def slice_(x):
        outer = mpmath.mpf("0.05") + x * (mpmath.mpf("0.08") - mpmath.mpf("0.05"))
        inner = mpmath.mpf(bore) + x * (mpmath.mpf(last) - mpmath.mpf(bore))
        return 1 / (outer**4 - inner**4)

    with mpmath.workdps(30):
        mean = mpmath.quad(slice_, mpmath.linspace(0, 1, 5))
        truth = float(mpmath.pi / 32 * mpmath.mpf(SHEAR) / (mpmath.mpf("0.3") * mean))
    found = shaft_stiffness(SHEAR, 0.3, ((0.05, bore), (0.08, last)))
    assert found == pytest.approx(truth, rel=1e-12)


def test_a_cone_that_runs_out_is_refused():
    with pytest.raises(NumericalFailure, match="wall too thin"):
        shaft_stiffness(SHEAR, 0.3, ((0.05, 0.0), (0.06, 0.0599999999)))


def test_stress_is_torque_over_the_section():
    # shear stress r T / I_p at the surface, integrated over the section, gives the torque back
    outer, bore, torque = 0.08, 0.05, 1500.0
    stress = torque / section_modulus(outer, bore)
    again = gauss(lambda r: stress * r / (outer / 2.0) * r * 2.0 * np.pi * r, bore / 2, outer / 2)
    assert again == pytest.approx(torque, rel=1e-13)
