"""Claim: kernels that stop where settled give what longer ways give, each row by itself."""

import mpmath
import numpy as np
import pytest

from vibecalc.absorber.pendulum_order import Pendulum, order_of_swing


@pytest.mark.parametrize("swing", [1e-8, 0.3, 1.7, 3.0, 3.1415])
def test_order_on_a_circle_is_the_elliptic_integral(swing: float) -> None:
    own = order_of_swing(Pendulum(1.0, 0.2, 0.05), np.array([swing, 0.0, 3.1]))
    with mpmath.workdps(34):
        true = mpmath.sqrt((mpmath.mpf(0.2) - mpmath.mpf(0.05)) / mpmath.mpf(0.05)) * mpmath.pi
        true /= 2 * mpmath.ellipk(mpmath.sin(mpmath.mpf(swing) / 2) ** 2)
        assert abs(mpmath.mpf(float(own.value[0])) - true) <= float(own.error[0])
    assert own.value[0] == order_of_swing(Pendulum(1.0, 0.2, 0.05), swing).value
