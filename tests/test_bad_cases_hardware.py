"""Claim: hardware that does not exist is refused in words."""

import numpy as np
import pytest

from vibecalc.absorber.hardware.oil_gap import (
    Oil,
    RingGap,
    Walther,
    gap_damping,
    gap_shares,
    kinematic_viscosity,
    nearest_oils,
    oil_damping,
    right_temperature,
    temperature_for,
)
from vibecalc.absorber.hardware.overhung import bending_frequencies
from vibecalc.absorber.hardware.rods_and_springs import (
    EndBody,
    OverhungRod,
    Springs,
    axial_torsional_stiffness,
    coupled_frequencies,
    inner_radius_for,
    rank,
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
    with pytest.raises(NumericalFailure, match="outside the range"):
        temperature_for(LINE, 1e-6)
    with pytest.raises(NumericalFailure, match="would have to be at"):
        temperature_for(LINE, 10.0)


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
        gap_damping(GAP._replace(**{part: 0.008}), 0.2)


def test_a_bore_that_its_gap_fills():
    with pytest.raises(NumericalFailure, match="as wide as the bore"):
        gap_shares(RingGap(0.148, 0.004, 0.007, 0.0005, 0.0005, 0.005))


def test_no_oil_is_known_at_a_temperature():
    with pytest.raises(NumericalFailure, match="none of 1 oils has a known viscosity at 280 C"):
        nearest_oils([OIL], GAP, 1.0, 553.15)
    with pytest.raises(NumericalFailure, match="outside the range"):
        oil_damping(OIL, GAP, 553.15)


def test_a_damping_that_no_temperature_gives():
    with pytest.raises(NumericalFailure, match="10W-40 gives this gap between"):
        right_temperature(OIL, GAP, 1e-6)
    with pytest.raises(NumericalFailure, match="never 1e\\+09"):
        right_temperature(OIL, GAP, 1e9)


def test_a_disc_too_light_for_an_inertia():
    with pytest.raises(NumericalFailure, match="a full disc of these dimensions"):
        inner_radius_for(0.2, 7850.0, 0.14834, 0.03)
    limit = np.pi / 2.0 * 7850.0 * 0.03 * 0.14834**4
    assert inner_radius_for(limit * (1 - 1e-12), 7850.0, 0.14834, 0.03).value < 1e-3


def test_springs_that_hold_nothing():
    plane = Springs(*(np.full(4, v) for v in (342.0, 0.14, 0.138, 0.6, 0.0, 0.0)))
    stiffness = axial_torsional_stiffness(plane).value
    with pytest.raises(NumericalFailure, match="no axial stiffness without tension"):
        coupled_frequencies(stiffness, 7.0, 0.077)
    with pytest.raises(NumericalFailure, match="two ends meet"):
        axial_torsional_stiffness(
            plane._replace(casing_radius=plane.mass_radius, angle=np.zeros(4))
        )


def test_lists_without_an_answer():
    with pytest.raises(NumericalFailure, match="list of parts"):
        rank([], 1.0)
    with pytest.raises(NumericalFailure, match="above zero"):
        rank([1.0], 0.0)


def test_more_modes_than_are_computed():
    with pytest.raises(NumericalFailure, match="7 modes of a rod asked for; 6 are computed"):
        bending_frequencies(OverhungRod(4086.0, 3.9, 1.6, 0.1), EndBody(13.8), 7)
