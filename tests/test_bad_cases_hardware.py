"""Claim: hardware that does not exist is refused in words."""

import pytest

from vibecalc.absorber.hardware.oil_gap import (
    Oil,
    RingGap,
    Walther,
    gap_shares,
    kinematic_viscosity,
    oil_damping,
    right_temperature,
)
from vibecalc.absorber.hardware.overhung import bending_frequencies
from vibecalc.absorber.hardware.rods_and_springs import (
    EndBody,
    OverhungRod,
)
from vibecalc.errors import NumericalFailure

LINE = Walther((313.15, 373.15), (86e-6, 13.8e-6))
OIL = Oil("10W-40", LINE, 870.0)
GAP = RingGap(0.148, 0.1, 0.007, 0.0005, 0.0005)


@pytest.mark.parametrize("temperature", [200.0, 643.2, [300.0, 700.0]])
def test_temperatures_off_the_chart(temperature):
    with pytest.raises(NumericalFailure, match="viscosity line ends at -70 and 370 C"):
        kinematic_viscosity(LINE, temperature)


def test_an_oil_too_thin_for_the_line():
    with pytest.raises(NumericalFailure, match=r"mm\^2/s at 280 C is outside the range"):
        kinematic_viscosity(LINE, 553.15)


@pytest.mark.parametrize(
    ("temperature", "viscosity"),
    [((313.15, 313.15), (86e-6, 13.8e-6)), ((313.15, 373.15), (13.8e-6, 86e-6))],
)
def test_points_that_make_no_line(temperature, viscosity):
    with pytest.raises(NumericalFailure, match="two temperatures, and less viscosity"):
        kinematic_viscosity(Walther(temperature, viscosity), 300.0)


@pytest.mark.parametrize("part", ["rim_clearance", "side_clearance", "bore_clearance"])
def test_a_gap_wider_than_the_mass(part):
    with pytest.raises(NumericalFailure, match="a gap of 8 mm is no film for a mass 7 mm wide"):
        gap_shares(GAP._replace(**{part: 0.008}))


def test_a_bore_that_its_gap_fills():
    with pytest.raises(NumericalFailure, match="as wide as the bore"):
        gap_shares(RingGap(0.148, 0.004, 0.007, 0.0005, 0.0005, 0.005))


def test_no_oil_is_known_at_a_temperature():
    with pytest.raises(NumericalFailure, match="outside the range"):
        oil_damping(OIL, GAP, 553.15)


def test_a_damping_that_no_temperature_gives():
    with pytest.raises(NumericalFailure, match="10W-40 gives this gap between"):
        right_temperature(OIL, GAP, 1e-6)
    with pytest.raises(NumericalFailure, match="never 1e\\+09"):
        right_temperature(OIL, GAP, 1e9)


def test_more_modes_than_are_computed():
    with pytest.raises(NumericalFailure, match="7 modes of a rod asked for; 6 are computed"):
        bending_frequencies(OverhungRod(4086.0, 3.9, 1.6, 0.1), EndBody(13.8), 7)
