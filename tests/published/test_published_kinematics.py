"""Claim: the truncated series gives every kinematic coefficient that Gibson and Ong print.

Ong (2000) uses R = 0.5 in, L = 2.375 in, w = 361 rad/s. Appendix I is cut off, not rounded, after
six significant digits; its last entry stands one unit higher than the exact value cut off.
"""

from decimal import ROUND_DOWN, ROUND_HALF_EVEN, Context, Decimal
from fractions import Fraction
from math import comb

import numpy as np
import pytest
from ong_tables import APPENDIX_I, LENGTH, RADIUS, SPEED
from shipped_cases import result_of

from vibecalc.core.results.select import scalar
from vibecalc.kinematics.harmonics import motion_harmonics
from vibecalc.kinematics.truncated_series import truncated_harmonics, truncated_motion
from vibecalc.units import convert


def acceleration(terms, highest_order):
    """Ong's coefficients: way from top dead centre, so acceleration towards the crank, in/s^2."""
    series = truncated_harmonics(RADIUS / LENGTH, terms, highest_order, derivative=2)
    return -RADIUS * SPEED**2 * series.real


def digits(value, rounding):
    return Context(prec=6, rounding=rounding).create_decimal(Decimal(float(value)))


def test_one_term_is_the_classic_first_and_second_order():
    # Gibson (2008), eq. 5: m r w^2 (cos + lam cos 2) as force on the frame
    ratio = 0.06 / 0.2
    np.testing.assert_array_max_ulp(
        truncated_harmonics(ratio, 1, 4, derivative=2).real,
        np.array([0.0, -1.0, -ratio, 0.0, 0.0]),
        maxulp=1,
    )
    angle = np.linspace(0.0, 6.0, 61)
    classic = -0.06 * (np.cos(angle) + ratio * np.cos(2 * angle))
    motion = truncated_motion(angle, 0.06, 0.2, 1)
    np.testing.assert_allclose(motion.acceleration, classic, rtol=0, atol=1e-16)


def test_ong_appendix_one_all_41_coefficients():
    ours = acceleration(40, 80)[[1, *range(2, 81, 2)]]
    assert len(APPENDIX_I) == 41
    for value, printed in zip(ours[:-1], APPENDIX_I[:-1], strict=True):
        assert digits(value, ROUND_DOWN) == Decimal(printed)
    # order 80: 2.700289988e-72 exactly (one product of integers and of 4/19). The source's algebra
    # program kept few digits: 5e-9 more, and it cuts off to the printed 2.70029e-72
    exact = Fraction(2 * comb(80, 40) * 80**2, 16**40 * 79) * Fraction(4, 19) ** 79
    exact *= Fraction(361**2, 2)
    assert abs(Fraction(float(-ours[-1])) / exact - 1) < 1e-14
    assert digits(ours[-1], ROUND_HALF_EVEN) == Decimal(APPENDIX_I[-1])
    assert digits(ours[-1] * (1 + 5e-9), ROUND_DOWN) == Decimal(APPENDIX_I[-1])


@pytest.mark.parametrize(("terms", "printed"), [(5, "0.000282702"), (10, "0.000312864")])
def test_ong_section_2_3_tenth_harmonic_depends_on_the_cut(terms, printed):
    value = acceleration(terms, 10)[10]
    assert Decimal(printed) in {digits(value, ROUND_DOWN), digits(value, ROUND_HALF_EVEN)}


def test_ong_expressions_of_fourth_and_sixth_order():
    # eqs. 2.16 and 2.17, over R w^2
    ratio = RADIUS / LENGTH
    fourth = [ratio + ratio**3 / 4, -(ratio**3) / 4]
    sixth = [
        ratio + ratio**3 / 4 + 15 * ratio**5 / 128,
        -(ratio**3) / 4 - 3 * ratio**5 / 16,
        9 * ratio**5 / 128,
    ]
    factor = RADIUS * SPEED**2
    np.testing.assert_allclose(acceleration(2, 4)[2::2] / factor, fourth, rtol=2e-15)
    np.testing.assert_allclose(acceleration(3, 6)[2::2] / factor, sixth, rtol=2e-15)


def test_the_cut_at_forty_terms_spoils_the_last_published_orders():
    exact = -RADIUS * SPEED**2 * motion_harmonics(RADIUS / LENGTH, 80, derivative=2).real
    lacking = 1.0 - acceleration(40, 80) / np.where(exact == 0.0, 1.0, exact)
    assert lacking[60] == pytest.approx(1.5e-9, rel=0.05)
    assert lacking[70] == pytest.approx(2.7e-4, rel=0.05)
    assert lacking[76] == pytest.approx(0.06, rel=0.1)
    assert lacking[80] == pytest.approx(0.59, rel=0.02)


def test_equations_2_10_to_2_12() -> None:
    r, ell = 0.5, 2.375
    printed = {
        1: r,
        2: r**2 * (512 * ell**6 + 128 * ell**4 * r**2 + 60 * ell**2 * r**4 + 35 * r**6) / 512,
        4: -(r**4) * (64 * ell**4 + 48 * ell**2 * r**2 + 35 * r**4) / 256,
        6: 9 * r**6 * (4 * ell**2 + 5 * r**2) / 512,
        8: -5 * r**8 / 256,
    }
    record = result_of("compressor", "kinematics.series=truncated", "kinematics.terms=4").record
    for order, value in printed.items():
        expected = value if order == 1 else value / ell**7
        for path, scale in (("acceleration", 361.0**2), ("position", -1.0 / order**2)):
            found = scalar(record[f"kinematics/{path}_harmonics"], {"order": order})
            ours = -convert(complex(found).real, "m", "in")
            assert ours / scale == pytest.approx(expected, rel=1e-13), (path, order)
