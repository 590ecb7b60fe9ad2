"""Baca Vasquez 2007, chapter 4: the pressure card of appendix II and the torques made of it."""

import numpy as np
import pytest

from vibecalc.excitation.cylinder_torque import cylinder_torque, gas_torque_at, inertia_torque_at
from vibecalc.excitation.gas_tables import FOUR_STROKE, gas_card
from vibecalc.parts.firing import angles_in_order
from vibecalc.parts.geometry import CrankGeometry

ENGINE = CrankGeometry(0.035, 0.123, 0.076)
MASS = 0.363 + 2.0 * 0.096 / 3.0
# two printed columns; 360 degrees ends the first and begins the second
FIRST = [
    *(30, 73, 60, 44, 31, 22.5, 17.5, 15, 11, 9.5, 9, 8, 7, 6, 5, 4.5, 4, 3.5, 3, 2.5, 2, 1.5),
    *[1] * 15,
]
SECOND = [
    *(1, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1),
    *(1.17, 1.33, 1.5, 1.66, 1.83, 1.99, 2.16, 2.33, 2.5, 3, 3.5, 4, 5, 7.5, 12, 17.5, 22.5, 30),
]
ANGLE = np.radians(np.arange(0.0, 721.0, 10.0))
PRESSURE = 1e5 * np.array([*FIRST, *SECOND[1:]], dtype=float)
CARD = gas_card(ANGLE, PRESSURE, cycle=FOUR_STROKE)


def test_the_card_of_appendix_ii_has_73_points_and_closes() -> None:
    assert FIRST[-1] == SECOND[0] and len(PRESSURE) == len(ANGLE) == 73
    assert PRESSURE[-1] == PRESSURE[0] and CARD.cycle == FOUR_STROKE


@pytest.mark.parametrize("speed", [400.0, 800.0])
def test_torques_of_figures_4_6_and_4_7_follow_from_the_printed_equations(speed: float) -> None:
    """Eq. 4.1 and 4.2, with the acceleration (4.4) by differences of y: its bracket is misprinted.

    The figures' rotating torque of eq. 4.3 is left out: a centrifugal force has none.
    """
    phi = np.radians(np.linspace(3.0, 717.0, 120))
    ratio = 0.035 / 0.123

    def way(at: np.ndarray) -> np.ndarray:
        return 0.158 - 0.035 * np.cos(at) - 0.123 * np.sqrt(1 - (ratio * np.sin(at)) ** 2)

    lever = 0.035 * (
        ratio * np.sin(phi) * np.cos(phi) / np.sqrt(1 - (ratio * np.sin(phi)) ** 2) + np.sin(phi)
    )
    area = np.pi * 0.076**2 / 4
    h = 1e-3
    bend = (-way(phi + 2 * h) - way(phi - 2 * h) + 16 * (way(phi + h) + way(phi - h))) / 12
    acceleration = speed**2 * (bend - 2.5 * way(phi)) / h**2
    printed_gas = np.interp(phi, ANGLE, PRESSURE) * area * lever
    gas = gas_torque_at(CARD, ENGINE, phi)
    assert np.abs(gas - printed_gas).max() < 1e-12 * np.abs(gas).max()
    inertia = speed**2 * inertia_torque_at(ENGINE, MASS, 0.0, phi)
    assert np.abs(inertia + MASS * acceleration * lever).max() < 1e-8 * np.abs(inertia).max()


@pytest.mark.parametrize("speed", [400.0, 800.0])
def test_thirty_half_orders_follow_the_curve_of_figure_4_9(speed: float) -> None:
    """What the series of eq. 4.5 misses is, in the mean square, what the later orders carry."""
    torque = cylinder_torque([CARD], ENGINE, reciprocating_mass=MASS, harmonics=400)
    phi = np.arange(5760) * (FOUR_STROKE / 5760)
    exact = gas_torque_at(CARD, ENGINE, phi) + speed**2 * inertia_torque_at(ENGINE, MASS, 0.0, phi)
    total = torque.gas.value[0] + speed**2 * torque.inertia.value
    kept, later = total[:30], total[30:]
    wave = np.exp(1j * np.outer(torque.order[:30], phi))
    off = torque.mean.value[0] + (kept @ wave).real - exact
    assert np.mean(off**2) == pytest.approx(0.5 * np.sum(np.abs(later) ** 2), rel=1e-3)
    assert np.sqrt(np.mean(off**2)) < 0.01 * np.abs(exact).max()


def test_the_firing_order_has_the_printed_phase_angles() -> None:
    """Figure 4.8: 1 5 3 6 2 4."""
    found = angles_in_order("153624", [], FOUR_STROKE, 0.0)
    degrees = [np.degrees(found[name]) for name in "123456"]
    assert degrees == pytest.approx([0.0, 480.0, 240.0, 600.0, 120.0, 360.0], rel=1e-14)
