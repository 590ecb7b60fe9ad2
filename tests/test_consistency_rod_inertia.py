"""Claim: the couple of a rod's own moment is what d'Alembert's sum over point masses gives.

A rod of given mass, mass centre and moment is three point masses, its usual stand-in is two. Both
are summed in many digits, from positions alone; the difference is the couple claimed.
"""

import mpmath as mp
import numpy as np
import pytest
from exact_rod import couple_of, energy_of, three_masses, two_masses

from vibecalc.excitation.inertia_forces import couple_about_axis
from vibecalc.excitation.rod_inertia import rod_couple_peak, split_inertia
from vibecalc.kinematics.rod_angle import rod_angle_harmonics
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.cycle_peak import cycle_peak

AXIS, STROKE = np.eye(3)[2], np.eye(3)[1]
#: R, L, e in m
GEOMETRIES = [(0.0127, 0.060325, 0.0), (0.06, 0.2, 0.015), (0.05, 0.12, -0.02)]
MASS, FIRST = 0.6, 0.0158
ANGLES = np.array([0.0, 0.3, 1.1, 1.57, 2.6, 3.3, 4.2, 4.72, 5.9])
HIGHEST = 80


def one_rod(geometry, inertia, name="acceleration", phase=0.0, bank=0.0):
    """Couple about the axis of one rod at ANGLES, and the sum of its errors."""
    turning = rod_angle_harmonics(*geometry, highest_order=HIGHEST)
    harmonics = getattr(turning, name)[1:]
    difference = inertia - split_inertia(MASS, FIRST, geometry[1]).value
    found = couple_about_axis(harmonics, [difference], [phase], [bank], AXIS)
    waves = np.exp(1j * np.multiply.outer(ANGLES, np.arange(1, HIGHEST + 1)))
    assert np.all(found.value[:, :5] == 0.0)
    assert np.all(found.error[:, :5] == 0.0)
    return (waves @ found.value).real[:, 5], found.error[:, 5].sum()


def exact(geometry, inertia, of, angle):
    """What the three masses have beyond the two."""
    lengths = [mp.mpf(value) for value in geometry]
    mass, first = mp.mpf(MASS), mp.mpf(FIRST)
    whole = of(three_masses(mass, first, mp.mpf(inertia), *lengths), angle)
    return whole - of(two_masses(mass, first, *lengths), angle)


@pytest.mark.parametrize("geometry", GEOMETRIES)
@pytest.mark.parametrize("inertia", [0.0, 2e-4, 3e-3])
def test_couple_of_three_masses(geometry, inertia):
    ours, error = one_rod(geometry, inertia)
    with mp.workdps(40):
        truth = np.array(
            [float(exact(geometry, inertia, couple_of, mp.mpf(a))) for a in ANGLES.tolist()]
        )
    assert np.abs(truth).max() > 1e-5
    # the waves of this test round by some n eps themselves
    slack = 1e-14 * np.abs(truth).max()
    assert np.abs(ours - truth).max() <= error + slack
    assert error <= 1e-11 * np.abs(truth).max()


@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_torque_of_a_separate_machine_from_the_energy(geometry):
    """At constant speed the rods' energy comes from the crankshaft: T = -dE/d(angle)."""
    inertia = 2e-4
    ours, error = one_rod(geometry, inertia, "product")
    with mp.workdps(40):
        truth = np.array(
            [
                float(mp.diff(lambda t: exact(geometry, inertia, energy_of, t), mp.mpf(a)))
                for a in ANGLES.tolist()
            ]
        )
    assert np.abs(ours - truth).max() <= error + 1e-14 * np.abs(truth).max()
    assert np.abs(truth).max() > 1e-6


@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_peak_is_that_of_the_harmonics(geometry):
    turning = rod_angle_harmonics(*geometry, highest_order=HIGHEST).acceleration
    peak = cycle_peak(-3e-4 * turning.value, np.arange(HIGHEST + 1))
    ours = rod_couple_peak(Bounded(np.array(-3e-4), np.array(1e-19)), *geometry)
    slack = peak.error + ours.error + 3e-4 * turning.error.sum()
    assert abs(peak.value - ours.value) <= slack
    assert ours.error >= 1e-19 * ours.value / 3e-4
