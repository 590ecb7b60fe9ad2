"""Claim: the torque harmonics of a cylinder are those of its card and its masses, to rounding.

The truth is mpmath: its Gauss rules in 30 digits on the straight pieces of a card, and the
trapezoidal rule on what the positions alone say of the kinetic energy.
"""

import mpmath
import numpy as np
import pytest
from exact_rod import fourier
from mpmath import mpf
from mpmath.calculus.quadrature import GaussLegendre

from vibecalc.excitation.cylinder_torque import (
    cylinder_torque,
    gas_harmonics,
    gas_torque_at,
    inertia_harmonics,
    inertia_torque_at,
    phasor,
    weighted,
)
from vibecalc.excitation.gas_tables import FOUR_STROKE, TWO_STROKE, card_weights, gas_card
from vibecalc.parts.geometry import CrankGeometry

CAR = CrankGeometry(0.035, 0.123, 0.076)
#: crank pin nearly as long as the rod, wrist pin next to it
STEEP = CrankGeometry(0.05, 0.058, 0.09, wrist_pin_offset=-0.004)
ANGLE = np.radians([-340.0, -180.0, -60.0, -20.0, 0.0, 7.0, 15.0, 40.0, 110.0, 200.0, 380.0])
PRESSURE = 1e5 * np.array([0.3, 0.9, 4.0, 12.0, 30.0, 71.0, 60.0, 25.0, 6.0, 1.1, 0.3])


def exact_gas(card, geometry: CrankGeometry, orders: list[float]) -> list[mpmath.mpc]:
    """2 / cycle times the integral of T exp(-i q t) (1 / cycle for q = 0), straight pieces only."""
    radius, length, offset = (
        mpf(v) for v in (geometry.crank_radius, geometry.rod_length, geometry.wrist_pin_offset)
    )
    area = mpmath.pi * mpf(geometry.bore) ** 2 / 4
    rule = GaussLegendre(mpmath.mp).calc_nodes(5, mpmath.mp.prec)  # 48 nodes
    found = [mpmath.mpc(0)] * len(orders)
    for i, row in enumerate(card.coefficient):
        low, high = mpf(card.node[i]), mpf(card.node[i + 1])
        parts = int(mpmath.ceil((high - low) * 2))
        for part in range(parts):
            half = (high - low) / parts / 2
            middle = low + half * (2 * part + 1)
            for x, w in rule:
                t = middle + half * x
                pressure = mpf(row[0]) + mpf(row[1]) * (t - low)
                across = radius * mpmath.sin(t) - offset
                pull = across / mpmath.sqrt(length**2 - across**2)
                torque = pressure * area * radius * (mpmath.sin(t) + mpmath.cos(t) * pull)
                for j, q in enumerate(orders):
                    found[j] += w * half * torque * mpmath.expj(-mpf(q) * t)
    return [f * (1 if q == 0 else 2) / mpf(card.cycle) for f, q in zip(found, orders, strict=True)]


@pytest.mark.parametrize(
    "geometry", [pytest.param(CAR, marks=pytest.mark.long), STEEP], ids=["car", "steep"]
)
def test_gas_harmonics_agree_with_quadrature_in_many_digits(geometry: CrankGeometry) -> None:
    card = gas_card(ANGLE, PRESSURE, cycle=FOUR_STROKE)
    orders = [0.5, 1.0, 3.0, 14.5, 60.0]
    with mpmath.workdps(30):
        mean, *truth = exact_gas(card, geometry, [0.0, *orders])
        gas, found_mean = gas_harmonics(card, geometry, orders)
        off = [float(abs(mpmath.mpc(v) - t)) for v, t in zip(gas.value, truth, strict=True)]
        off_mean = float(abs(mpf(float(found_mean.value)) - mean.real))
    largest = np.abs(gas.value).max()
    assert np.all(off <= gas.error) and off_mean <= found_mean.error
    # honest and no excuse: at most 1e-13 of the largest order, where 1e-15 is attained
    assert np.all(gas.error < 1e-13 * largest) and max(off) < 4e-15 * largest


@pytest.mark.parametrize("geometry", [CAR, STEEP], ids=["car", "steep"])
def test_inertia_harmonics_are_those_of_the_kinetic_energy(geometry: CrankGeometry) -> None:
    mass, difference = 0.43, -3e-4
    orders = np.array([0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 7.0, 30.0])
    found = inertia_harmonics(geometry, mass, difference, orders)
    whole = [1, 2, 3, 4, 7, 30]
    with mpmath.workdps(30):
        shape = [mpf(v) for v in (geometry.crank_radius, geometry.rod_length)]
        offset = mpf(geometry.wrist_pin_offset)
        moving = [mpf(mass), mpf(difference)]

        def energy(angle: mpf) -> mpf:
            across = shape[0] * mpmath.sin(angle) - offset
            rod = mpmath.sqrt(shape[1] ** 2 - across**2)
            speed = -shape[0] * mpmath.sin(angle) - across * shape[0] * mpmath.cos(angle) / rod
            turn = shape[0] * mpmath.cos(angle) / rod
            return (moving[0] * speed**2 + moving[1] * turn**2) / 2

        # T = -dE/dt, order by order
        truth = [-1j * n * c for n, c in zip(whole, fourier(energy, whole, 600), strict=True)]
        off = np.array(
            [
                float(abs(mpmath.mpc(v) - t))
                for v, t in zip(found.value[orders == np.floor(orders)], truth, strict=True)
            ]
        )
    assert np.all(off <= found.error[orders == np.floor(orders)])
    assert np.all(found.value[orders != np.floor(orders)] == 0.0)
    assert found.error.max() < 1e-13 * np.abs(found.value).max()


def test_the_series_is_the_curve() -> None:
    """Two-stroke, cubic card, two speeds: the sum of all orders is the torque at each angle."""
    angle = np.radians(np.arange(0.0, 361.0, 30.0))
    pressure = 1e5 * np.array([40, 22, 9, 4, 2, 1, 0.5, 0.6, 0.8, 1.5, 4, 15, 40.0])
    cards = [gas_card(angle, s * pressure, "cubic", cycle=TWO_STROKE) for s in (1.0, 1.5)]
    torque = cylinder_torque(
        cards, CAR, reciprocating_mass=0.43, rod_inertia_difference=2e-4, harmonics=120
    )
    mixed = weighted(torque, card_weights([100.0, 300.0], [150.0]))
    where = np.linspace(0.3, 6.1, 23)
    wave = np.exp(1j * np.outer(torque.order, where))
    gas = mixed.mean.value[0] + (mixed.gas.value[0] @ wave).real
    inertia = (torque.inertia.value @ wave).real
    direct = 1.125 * gas_torque_at(cards[0], CAR, where)
    # the third derivative jumps at the nodes of a spline: order q has 2 / cycle / q^4 of that
    unit = gas_card(angle, np.ones_like(angle), cycle=TWO_STROKE)
    third = 6.75 * cards[0].coefficient[:, 3]
    jump = np.abs(third - np.roll(third, 1)) @ np.abs(gas_torque_at(unit, CAR, angle[:-1]))
    rest = jump * (2.0 / TWO_STROKE) / (3.0 * 120.0**3)
    assert 0.05 * rest < np.abs(gas - direct).max() < rest
    exact = inertia_torque_at(CAR, 0.43, 2e-4, where)
    assert np.abs(inertia - exact).max() < 1e-14 * np.abs(exact).max()


def test_phasors_of_high_orders_keep_their_digits() -> None:
    angle, order = np.array([12.345678, 0.7]), np.array([200.0, 0.5])
    with mpmath.workdps(30):
        truth = [[mpmath.expj(-mpf(q) * mpf(a)) for a in angle] for q in order]
        off = [
            abs(mpmath.mpc(phasor(order, angle)[i, j]) - truth[i][j])
            for i in (0, 1)
            for j in (0, 1)
        ]
    assert max(off) < 3e-16
