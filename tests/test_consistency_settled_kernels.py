"""Claim: kernels that stop where settled give what longer ways give, each row by itself."""

import mpmath
import numpy as np
import pytest

from vibecalc.absorber.hardware.overhung import bending_frequencies
from vibecalc.absorber.hardware.rods_and_springs import EndBody, OverhungRod
from vibecalc.absorber.pendulum_order import Pendulum, order_of_swing
from vibecalc.numerics.cycle_peak import cycle_peak, needed_orders
from vibecalc.response.switching.motion import PANEL_PHASE


def test_orders_below_rounding_are_left_out_and_counted() -> None:
    orders = np.arange(1, 81)
    rows = np.exp(-3.0 * orders)[None, None] * np.ones((2, 1, 1), dtype=complex)
    rows[1, 0, -1] = 1e-3
    highest, left_out = needed_orders(rows, orders)
    assert highest.tolist() == [16, 80]
    assert 0.0 < left_out[0] < 2.0**-53 * np.exp(-3.0) and left_out[1] == 0.0
    peak = cycle_peak(rows[0, 0], orders)
    assert abs(float(peak.value) - float(np.sum(rows[0, 0].real))) <= peak.error


@pytest.mark.parametrize("swing", [1e-8, 0.3, 1.7, 3.0, 3.1415])
def test_order_on_a_circle_is_the_elliptic_integral(swing: float) -> None:
    own = order_of_swing(Pendulum(1.0, 0.2, 0.05), np.array([swing, 0.0, 3.1]))
    with mpmath.workdps(34):
        true = mpmath.sqrt((mpmath.mpf(0.2) - mpmath.mpf(0.05)) / mpmath.mpf(0.05)) * mpmath.pi
        true /= 2 * mpmath.ellipk(mpmath.sin(mpmath.mpf(swing) / 2) ** 2)
        assert abs(mpmath.mpf(float(own.value[0])) - true) <= float(own.error[0])
    assert own.value[0] == order_of_swing(Pendulum(1.0, 0.2, 0.05), swing).value


def test_modes_of_a_rod_do_not_depend_on_how_many_are_asked_for() -> None:
    rod, body = OverhungRod(4e3, 3.0, 0.6, 0.2), EndBody(9.0, 0.05, 0.1, 0.02)
    six = bending_frequencies(rod, body, 6)
    for count in range(1, 6):
        few = bending_frequencies(rod, body, count)
        assert np.all(np.abs(few.value - six.value[:count]) <= few.error + six.error[:count])


def test_gauss_rule_of_a_panel_is_at_rounding_for_the_fastest_load() -> None:
    true = (np.exp(1j * PANEL_PHASE) - 1.0) / (1j * PANEL_PHASE)
    for points, bound in ((7, 3e-15), (6, 2e-12)):
        place, weight = np.polynomial.legendre.leggauss(points)
        found = 0.5 * weight @ np.exp(0.5j * PANEL_PHASE * (1.0 + place))
        assert abs(found - true) <= bound * abs(true)
