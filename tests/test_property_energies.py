"""Claim: energies keep their digits down to underflow, and their errors hold what was dropped."""

import numpy as np
import ong_tables as ong
import pytest

from vibecalc.errors import NumericalFailure
from vibecalc.kinematics.harmonics import motion_harmonics
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.linear import dynamics, response
from vibecalc.response.energies import (
    Energy,
    mass_of,
    mean_over_cycle,
    peak_over_cycle,
    velocity,
)


def exactly(value: np.ndarray) -> Bounded:
    return Bounded(value, np.zeros(np.shape(value)))


def energy_over_cycle(
    weight: Bounded,
    state: Bounded,
    orders: np.ndarray,
    retained: int | None = None,
    tail: float = 0.0,
) -> Energy:
    return Energy(
        mean_over_cycle(weight, state, retained, tail),
        peak_over_cycle(weight, state, orders, retained, tail),
    )


def test_a_state_below_all_squares_has_no_energy() -> None:
    weight = exactly(np.eye(6))
    tiny = exactly(np.full((2, 6), 1e-300 + 0j))
    total = energy_over_cycle(weight, tiny, np.array([1, 2]))
    assert total.mean.value == total.peak.value == 0.0
    assert 0.0 < total.mean.error < 1e-320
    nothing = energy_over_cycle(weight, exactly(np.zeros((2, 6), dtype=complex)), np.array([1, 2]))
    assert (nothing.mean.value, *nothing.peak) == (0.0, 0.0, 0.0)


def totals(kept: int, guard: int, tail: float, ratio: float) -> Energy:
    """Kinetic energy of cylinder A with orders to `kept` + `guard` at a ratio R/L."""
    matrices = ong.si_matrices()
    highest = kept + guard
    orders = np.array([1, *range(2, highest + 1, 2)])
    acceleration = -motion_harmonics(ratio, highest, derivative=2)[orders]
    force = acceleration[:, None] * np.array([0.0, 1.0, 0.0, ong.LEVER_A * ong.INCH, 0.0, 0.0])
    motion = response(dynamics(matrices, orders * ong.SPEED), force, 1e-15 * np.abs(force))
    used = int(np.count_nonzero(orders <= kept))
    state = velocity(motion, orders * ong.SPEED)
    return energy_over_cycle(mass_of(matrices), state, orders, used, tail)


@pytest.mark.parametrize("ratio", [0.2105, 0.9, 0.999999])
def test_dropped_orders_are_in_the_errors(ratio: float) -> None:
    """Few orders, the next as guards, against many; up to a crank as long as the rod."""
    whole = totals(400, 0, 0.0, ratio)
    for kept in (2, 10, 40):
        cut = totals(kept, 400 - kept, 1.0, ratio)
        for one, other in zip(whole, cut, strict=True):
            assert abs(one.value - other.value) <= other.error + one.error
        blind = totals(kept, 400 - kept, 0.0, ratio)
        assert blind.mean.value == cut.mean.value
        if ratio > 0.99 or kept == 2:
            # the difference is real, and without the tail it would be missed
            missed = whole.mean.value - blind.mean.value
            assert missed > blind.mean.error + whole.mean.error


def test_energy_without_a_lower_bound_is_refused() -> None:
    weight = exactly(np.diag([1.0, 1.0, 1.0, 1.0, 1.0, -1e-6]))
    with pytest.raises(NumericalFailure, match="no lower bound"):
        energy_over_cycle(weight, exactly(np.ones((1, 6)) + 0j), np.array([1]))
    pair = np.eye(6)
    pair[0, 1] = pair[1, 0] = 1.0 + 1e-9
    with pytest.raises(NumericalFailure, match="negative eigenvalue"):
        energy_over_cycle(exactly(pair), exactly(np.ones((1, 6)) + 0j), np.array([1]))
