"""Claim: operations and balances are combined as phasors; the range over all phases of the balance
weight is the true one, mean and peak, and its errors bound what the search may have missed.
"""

import mpmath
import numpy as np
import ong_tables as ong
import pytest
from exact_peaks import cycle_peak as exact_peak
from isolation_machines import random_body
from long_but import long_but
from mpmath import mpf

from vibecalc.errors import NumericalFailure
from vibecalc.kinematics.harmonics import motion_harmonics
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.linear import Linear, dynamics, response
from vibecalc.response.energies import (
    Energy,
    dropped_mean,
    mass_of,
    mean_over_cycle,
    peak_over_cycle,
    stiffness_of,
    velocity,
)
from vibecalc.response.modes import modes
from vibecalc.response.operations import (
    Parts,
    at_phase,
    mean_energy_range,
    peak_energy_range,
    search_phases,
    superpose,
)

ORDERS = np.array([1, 2, 4])
SEEDS = range(8)


def exactly(value: np.ndarray) -> Bounded:
    return Bounded(value, np.zeros(np.shape(value)))


def machine(seed: int) -> tuple[Linear, float, Bounded, Bounded]:
    """A random body, a speed, loads of 2 operations, and of 3 balances for each of them."""
    body, generator = random_body(seed), np.random.default_rng(seed)
    speed = float(modes(body.matrices).natural_frequency[1] * generator.uniform(0.4, 2.5))
    shaking = generator.normal(size=(2, 2, 3, 6)) * 10.0 ** -np.array([0.0, 0.5, 2.0])[:, None]
    size = 10.0 ** generator.uniform(-3.0, 1.0, size=(2, 3, 1))
    residual = generator.normal(size=(2, 2, 3, 6)) * size
    return (
        body.matrices,
        speed,
        exactly(shaking[0] + 1j * shaking[1]),
        exactly(residual[0] + 1j * residual[1]),
    )


def weights_and_states(matrices: Linear, speed: float, parts: Parts) -> list[tuple[Bounded, Parts]]:
    return [
        (mass_of(matrices), parts.times(1j * speed * ORDERS)),
        (stiffness_of(matrices), parts),
    ]


@pytest.mark.parametrize("seed", long_but(SEEDS, 0))
def test_guard_orders_enter_the_errors_of_the_ranges_only(seed: int) -> None:
    matrices, speed, shaking, residual = machine(seed)
    parts = superpose(dynamics(matrices, ORDERS * speed), Parts(shaking, residual))
    for weight, state in weights_and_states(matrices, speed, parts):
        first = state._replace(shaking=Bounded(*(part[:, :2] for part in state.shaking)))
        guards = Bounded(*(part[:, 2:] for part in state.shaking))
        rest = dropped_mean(weight, guards, 1.0)
        few = mean_over_cycle(weight, at_phase(state), 2, 1.0)
        pairs = (
            (mean_energy_range(weight, first), mean_energy_range(weight, first, rest)),
            (
                peak_energy_range(weight, first, ORDERS[:2]),
                peak_energy_range(weight, state, ORDERS, 2, 1.0),
            ),
        )
        for without, found in pairs:
            for (value, error), same in zip(found[:2], without[:2], strict=True):
                np.testing.assert_allclose(value, same.value, rtol=1e-13)
                assert np.all(error > same.error)
        whole = (mean_energy_range(weight, state), peak_energy_range(weight, state, ORDERS))
        for all_of_them, (_, found) in zip(whole, pairs, strict=True):
            for ours, end in zip(all_of_them[:2], found[:2], strict=True):
                assert np.all(np.abs(ours.value - end.value) <= end.error)
        low, high, *_ = pairs[0][1]
        assert np.all(few.value <= high.value * (1.0 + 1e-14))
        assert np.all(few.value >= low.value - low.error)


def rounding_of(harmonics: np.ndarray, turned: np.ndarray) -> float:
    """What is granted for the rounding of a peak energy."""
    length = np.linalg.norm(harmonics, axis=0).sum() + np.linalg.norm(turned)
    return float(8.0 * np.finfo(float).eps * length**2)


def exact_peak_at(rows: list[list[mpmath.mpc]], turned: list[mpmath.mpc], phase: mpf) -> mpf:
    shifted = [
        [row[0] + mpmath.expj(phase) * r, *row[1:]] for row, r in zip(rows, turned, strict=True)
    ]
    return exact_peak(shifted, ORDERS.tolist())[0] ** 2 / 2


@pytest.mark.parametrize("seed", long_but(range(4), 0))
def test_lowest_and_highest_peak_in_many_digits(seed: int) -> None:
    """Golden section about the phases found, in 30 digits: nothing better is near."""
    generator = np.random.default_rng(seed)
    harmonics = generator.normal(size=(2, 2, 3)) * np.array([1.0, 0.4, 0.05])
    y = harmonics[0] + 1j * harmonics[1]
    r = generator.normal(size=2) + 1j * generator.normal(size=2)
    found, _ = search_phases(y[None], ORDERS, r[None], 1e-12)
    with mpmath.workdps(30):
        rows = [[mpmath.mpmathify(complex(x)) for x in row] for row in y]
        turned = [mpmath.mpmathify(complex(x)) for x in r]
        for sign, phase, (value, error) in (
            (1, found.low_phase, found.low),
            (-1, found.high_phase, found.high),
        ):
            low, high = mpf(phase.item()) - mpf("1e-3"), mpf(phase.item()) + mpf("1e-3")
            section = (mpmath.sqrt(5) - 1) / 2
            for _ in range(70):
                left, right = high - section * (high - low), low + section * (high - low)
                if sign * exact_peak_at(rows, turned, left) < sign * exact_peak_at(
                    rows, turned, right
                ):
                    high = right
                else:
                    low = left
            best = exact_peak_at(rows, turned, (low + high) / 2)
            off = float(abs(mpf(value.item()) - best))
            assert off <= error.item()
            assert error.item() <= 1e-12 * value.item() + 3.0 * rounding_of(y, r)


def test_a_phase_that_does_not_matter() -> None:
    """Without a residual, without shaking, and for two circles that turn against each other."""
    circle = np.array([[1.0 + 0j], [-1j]])
    none = np.zeros((2, 1), dtype=complex)
    found, _ = search_phases(
        np.stack([circle, none, circle, none]),
        np.array([1]),
        np.stack([none[:, 0], circle[:, 0], 0.3 * circle[:, 0].conj(), none[:, 0]]),
        1e-6,
    )
    expected = 0.5 * np.square([1.0, 1.0, 1.3, 0.0])
    np.testing.assert_allclose(found.low.value, expected, rtol=1e-14)
    np.testing.assert_allclose(found.high.value, expected, rtol=1e-14)
    assert found.low_phase[0] == 0.0 and np.all(found.low.error[:2] < 1e-14)
    assert np.all(found.high.error <= 1.1e-6 * expected)


def test_search_that_is_broken_off_says_how_far_it_came_and_leaves_others_alone() -> None:
    """For opposite circles no interval can ever be dropped."""
    circle = np.array([[1.0 + 0j], [-1j]])
    harmonics, orders = np.stack([circle, circle]), np.array([1])
    turned = np.stack([0.3 * circle[:, 0].conj(), [0.2, 0.3j]])
    (low, high, *_), _ = search_phases(harmonics, orders, turned, 1e-14)
    expected = 0.5 * 1.3**2
    assert 1e-9 < high.error[0] < 1e-6
    assert abs(high.value[0] - expected) <= 1e-14
    assert high.error[1] <= 4.0 * rounding_of(circle, turned[1])
    (its_low, its_high, *_), _ = search_phases(harmonics[1:], orders, turned[1:], 1e-14)
    assert (its_low.value.item(), its_high.value.item()) == (low.value[1], high.value[1])


# ----------------------------------------------------------------------------
# Digits down to underflow, and what was dropped.
# ----------------------------------------------------------------------------


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
