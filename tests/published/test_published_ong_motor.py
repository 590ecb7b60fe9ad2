"""Claim: Ong's axial force and equivalent masses come out; where the source slips, by its slip.

Ong (2000), sections 3.3, 6.2 and 8.3, in lbf, in and s. The 41 torques of Table 6.1 are those of
the shipped case.
"""

from decimal import ROUND_DOWN, ROUND_HALF_EVEN, Context, Decimal
from types import SimpleNamespace

import numpy as np
import pytest
from shipped_cases import ROOT, result_of

from vibecalc.excitation.axial_force import axial_force

TABLE = np.loadtxt(ROOT / "cases" / "compressor_motor_torque.csv", delimiter=",", skiprows=2)
DIAMETER, SKEW = 6.0, 0.035
GRAVITY = 386.088
OTHER_GRAVITY = 386.4


def digits(value, count, rounding=ROUND_HALF_EVEN):
    return Context(prec=count, rounding=rounding).create_decimal(Decimal(float(value)))


def force():
    order, cosine, sine = TABLE.T
    torque = SimpleNamespace(order=order.astype(int), cosine=cosine, sine=sine)
    return axial_force(SimpleNamespace(torque=torque, rotor_diameter=DIAMETER, skew_angle=SKEW))[1]


def test_table_6_1_is_complete():
    np.testing.assert_array_equal(TABLE[:, 0], np.arange(41))
    # first, largest, smallest and last entries as printed
    assert TABLE[0].tolist() == [0.0, -137.454, 0.0]
    assert TABLE[4, 1] == TABLE[1:, 1].max() == 78.6477
    assert TABLE[2, 2] == TABLE[:, 2].max() == 63.3141
    assert TABLE[37].tolist() == [37.0, -0.0914587, 0.0368388]
    assert TABLE[40].tolist() == [40.0, 0.428037, -0.269016]


def test_axial_force_by_the_sine():
    """Section 6.2.1, eq. 6.6: F_z = 3.446 lb, with sin(beta) and the last digit cut off."""
    by_the_sine = force().sum_of_amplitudes.value * np.cos(SKEW)
    direct = np.sum(np.hypot(*(2.0 * TABLE[1:, 1:] / DIAMETER * np.sin(SKEW)).T))
    assert by_the_sine == pytest.approx(direct, rel=1e-14)
    assert digits(direct, 4, ROUND_DOWN) == Decimal("3.446")
    assert digits(direct, 5) == Decimal("3.4468")


def test_axial_force_of_the_discussion():
    """Section 8.3: 3.45 lb, which the right formula gives too."""
    assert digits(force().sum_of_amplitudes.value, 3) == Decimal("3.45")


def test_what_the_force_is_instead_of_its_bound():
    ours = force()
    assert digits(ours.peak.value, 3) == Decimal("3.13")
    assert digits(ours.rms.value, 3) == Decimal("1.04")


@pytest.mark.parametrize(
    ("gravity", "printed"), [(GRAVITY, "8.929E-5"), (OTHER_GRAVITY, "8.9218E-5")]
)
def test_share_of_the_rod_at_the_wrist_pin(gravity, printed):
    """Section 3.3.1 prints two values for one: 8.929e-5, right, and 8.9218e-5, with g = 386.4."""
    share = 0.131 / gravity * 0.625 / (0.625 + 1.75)
    assert digits(share, len(printed) - 4) == Decimal(printed)


@pytest.mark.parametrize(
    ("name", "printed"), [("reciprocating", "0.001990"), ("rotating", "0.0002500")]
)
def test_equivalent_masses(name, printed):
    slinch = 4.4482216152605 / 0.0254
    masses = result_of("compressor_motor").record[f"excitation/mass/{name}"].values
    assert masses.shape == (2,)
    for one in masses / slinch:
        assert digits(one, 4) == Decimal(printed)


def test_the_other_gravity_hides_in_the_sum():
    """With either value of the rod's share the reciprocating mass rounds to 1.990e-3."""
    pistons = (0.659 + 0.075) / GRAVITY
    for share in (8.929e-5, 8.9218e-5):
        assert digits(pistons + share, 4) == Decimal("0.001990")
