"""Claim: the couple of a rod's own moment is what d'Alembert's sum over point masses gives.

A rod of given mass, mass centre and moment is three point masses, its usual stand-in is two. Both
are summed in many digits, from positions alone; the difference is the couple claimed.
"""

import mpmath as mp
import numpy as np
import pytest
from exact_rod import couple_of, energy_of, on_the_rod, three_masses, two_masses

from vibecalc.excitation.inertia_forces import (
    inertia_torque,
    reciprocating_excitation,
    torque_reaction,
)
from vibecalc.excitation.rod_inertia import (
    rod_couple_peak,
    rod_inertia_excitation,
    rod_torque_reaction,
    split_inertia,
)
from vibecalc.kinematics.harmonics import motion_harmonics
from vibecalc.kinematics.rod_angle import rod_angle_harmonics
from vibecalc.numerics.cycle_peak import cycle_peak

AXIS, STROKE = np.eye(3)[2], np.eye(3)[1]
#: R, L, e in m
GEOMETRIES = [(0.0127, 0.060325, 0.0), (0.06, 0.2, 0.015), (0.05, 0.12, -0.02)]
MASS, FIRST = 0.6, 0.0158
ANGLES = np.array([0.0, 0.3, 1.1, 1.57, 2.6, 3.3, 4.2, 4.72, 5.9])
HIGHEST = 80


def one_rod(geometry, inertia, make=rod_inertia_excitation, phase=0.0, bank=0.0):
    """Couple about the axis of one rod at ANGLES, and the sum of its errors."""
    turning = rod_angle_harmonics(*geometry, highest_order=HIGHEST)
    harmonics = turning.acceleration if make is rod_inertia_excitation else turning.product
    difference = inertia - split_inertia(MASS, FIRST, geometry[1]).value
    found = make(
        harmonics.value,
        inertia_difference=[difference],
        crank_phase=[phase],
        bank_angle=[bank],
        axis=AXIS,
        motion_error=harmonics.error,
    )
    waves = np.exp(1j * np.multiply.outer(ANGLES, np.arange(1, HIGHEST + 1)))
    assert np.all(found.force == 0.0)
    assert np.all(found.force_error == 0.0)
    assert np.all(found.couple[:, :2] == 0.0)
    return (waves @ found.couple).real[:, 2], found.couple_error[:, 2].sum()


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


def test_couple_is_zero_where_the_moment_is_that_of_the_two_masses():
    geometry = GEOMETRIES[0]
    same = float(split_inertia(MASS, FIRST, geometry[1]).value)
    ours, _ = one_rod(geometry, same)
    assert np.all(ours == 0.0)


@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_torque_of_a_separate_machine_from_the_energy(geometry):
    """At constant speed the rods' energy comes from the crankshaft: T = -dE/d(angle)."""
    inertia = 2e-4
    ours, error = one_rod(geometry, inertia, rod_torque_reaction)
    with mp.workdps(40):
        truth = np.array(
            [
                float(mp.diff(lambda t: exact(geometry, inertia, energy_of, t), mp.mpf(a)))
                for a in ANGLES.tolist()
            ]
        )
    assert np.abs(ours - truth).max() <= error + 1e-14 * np.abs(truth).max()
    assert np.abs(truth).max() > 1e-6


@pytest.mark.parametrize("geometry", GEOMETRIES[1:])
def test_signs_are_those_of_the_pistons(geometry):
    """The same sums over point masses give the couples that the pistons put on the body."""
    radius, length, offset = geometry
    motion = motion_harmonics(radius / length, HIGHEST, offset / radius)
    train = {"crank_radius": radius, "reciprocating_mass": [MASS], "crank_phase": [0.0]}
    train |= {"bank_angle": [0.0], "axis": AXIS}
    of_force = reciprocating_excitation(
        motion,
        position=[0.0],
        origin=np.zeros(3),
        stroke=STROKE,
        across=np.cross(STROKE, AXIS),
        wrist_pin_offset=offset,
        **train,
    )
    of_torque = torque_reaction(inertia_torque(motion, HIGHEST), **train)
    waves = np.exp(1j * np.multiply.outer(ANGLES, np.arange(1, HIGHEST + 1)))
    with mp.workdps(40):
        wrist = [(mp.mpf(MASS), on_the_rod(mp.mpf(1), *map(mp.mpf, geometry)))]
        couple = [float(couple_of(wrist, mp.mpf(a))) for a in ANGLES.tolist()]
        rate = [float(mp.diff(lambda t: energy_of(wrist, t), mp.mpf(a))) for a in ANGLES.tolist()]
    for ours, truth in ((of_force, couple), (of_torque, rate)):
        signal = (waves @ ours.couple).real[:, 2]
        np.testing.assert_allclose(signal, truth, rtol=0, atol=1e-13 * np.abs(truth).max())


def test_phase_and_bank_shift_the_crank_angle():
    geometry = GEOMETRIES[1]
    phase, bank = 2.1, 0.4
    ours, error = one_rod(geometry, 2e-4, phase=phase, bank=bank)
    with mp.workdps(40):
        shift = mp.mpf(phase) - mp.mpf(bank)
        truth = [float(exact(geometry, 2e-4, couple_of, mp.mpf(a) + shift)) for a in ANGLES]
    assert np.abs(ours - truth).max() <= error + 1e-14 * np.abs(truth).max()


def test_cylinders_add_and_one_that_stands_adds_nothing():
    turning = rod_angle_harmonics(*GEOMETRIES[1], highest_order=12).acceleration
    phases, banks = [0.0, np.pi, 1.0], [0.0, 0.0, 0.5]

    def together(differences):
        return rod_inertia_excitation(
            turning.value,
            inertia_difference=differences,
            crank_phase=phases,
            bank_angle=banks,
            axis=AXIS,
            motion_error=turning.error,
        )

    whole = together([2e-4, 3e-4, 4e-4])
    parts = [together(row) for row in np.diag([2e-4, 3e-4, 4e-4])]
    slack = whole.couple_error + sum(part.couple_error for part in parts)
    assert np.all(np.abs(whole.couple - sum(part.couple for part in parts)) <= slack)
    still = together([2e-4, 0.0, 0.0])
    np.testing.assert_array_equal(still.couple, parts[0].couple)
    opposed = together([2e-4, 2e-4, 0.0])  # throws at 180 degrees: odd orders cancel
    odd = np.abs(opposed.couple[::2, 2])
    assert np.all(odd <= opposed.couple_error[::2, 2])
    assert abs(opposed.couple[1, 2]) > 1e-7


def test_leading_axes_broadcast():
    turning = rod_angle_harmonics(*GEOMETRIES[1], highest_order=5).acceleration
    phases = np.array([[0.0, 1.0], [0.5, 2.0], [0.1, 0.2]])
    many = rod_inertia_excitation(
        turning.value,
        inertia_difference=np.array([1e-4, 2e-4]),
        crank_phase=phases,
        bank_angle=np.zeros(2),
        axis=AXIS,
        inertia_error=1e-20,
    )
    assert many.couple.shape == many.couple_error.shape == many.force.shape == (3, 5, 3)
    one = rod_inertia_excitation(
        turning.value,
        inertia_difference=[1e-4, 2e-4],
        crank_phase=phases[1],
        bank_angle=[0.0, 0.0],
        axis=AXIS,
    )
    assert np.all(np.abs(many.couple[1] - one.couple) <= many.couple_error[1])
    more = many.couple_error[1, :, 2] - one.couple_error[:, 2]
    np.testing.assert_allclose(more, 2e-20 * np.abs(turning.value[1:]), rtol=1e-3)


@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_peak_is_that_of_the_harmonics(geometry):
    turning = rod_angle_harmonics(*geometry, highest_order=HIGHEST).acceleration
    peak = cycle_peak(-3e-4 * turning.value, np.arange(HIGHEST + 1))
    ours = rod_couple_peak(-3e-4, *geometry, inertia_error=1e-19)
    slack = peak.error + ours.error + 3e-4 * turning.error.sum()
    assert abs(peak.value - ours.value) <= slack
    assert ours.error >= 1e-19 * ours.value / 3e-4


def test_split_inertia_in_digits():
    ours = split_inertia(MASS, FIRST, 0.060325)
    with mp.workdps(30):
        truth = mp.mpf(MASS) * mp.mpf(FIRST) * (mp.mpf(0.060325) - mp.mpf(FIRST))
        assert abs(mp.mpf(float(ours.value)) - truth) <= ours.error <= 1e-15 * truth
