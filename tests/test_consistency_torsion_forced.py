"""Claim: the forced response of a shaft line is the exact one within its error estimate, by
elimination along a tree and of any network, also where it meets resonances of its own.
"""

import mpmath as mp
import numpy as np
import pytest
from exact_shaft_line import exact_angles

from vibecalc.torsion.forced import forced, forced_masked
from vibecalc.torsion.line import Line, chain
from vibecalc.torsion.modes import natural_modes
from vibecalc.torsion.network import network_solution


@pytest.fixture(autouse=True)
def digits():
    with mp.workdps(40):
        yield


def engine() -> Line:
    """The published engine of seven inertias, with some damping in every shaft."""
    line = chain(np.array([18.64] * 6 + [2655.0]), np.array([22.82e6] * 5 + [19.21e6]))
    return line._replace(damping=1e-5 * line.stiffness)


def branched(generator: np.random.Generator) -> Line:
    """A tree of nine stations: massless ones, two elements side by side, all kinds of damping."""
    first = np.array([0, 1, 1, 3, 3, 5, 6, 6, 8, 3])
    second = np.array([1, 2, 3, 4, 5, 6, 7, 8, 6, 1])
    inertia = 10.0 ** generator.uniform(-2, 2, 9)
    inertia[[2, 5]] = 0.0
    return Line(
        inertia,
        generator.uniform(0, 3, 9) * (generator.random(9) < 0.3),
        generator.uniform(0, 1e4, 9) * (generator.random(9) < 0.2),
        first,
        second,
        10.0 ** generator.uniform(3, 8, 10),
        10.0 ** generator.uniform(-1, 3, 10) * (generator.random(10) < 0.5),
        0.02 * (generator.random(10) < 0.3),
    )


def true_error(line: Line, frequency, torque, angle) -> np.ndarray:
    exact = [exact_angles(line, w, t) for w, t in zip(frequency, torque, strict=True)]
    return np.max(np.abs(np.array(exact) - angle), axis=-1)


def test_trees_with_massless_stations_and_any_damping_are_exact_within_the_estimate():
    generator = np.random.default_rng(3)
    for _ in range(3):
        line = branched(generator)
        w = np.concatenate([10.0 ** generator.uniform(-3, 4, 5), [0.0]])
        w = w[: 6 if np.any(line.ground_stiffness) else 5]
        torque = generator.normal(size=(len(w), 9)) + 1j * generator.normal(size=(len(w), 9))
        found = forced(line, w, torque)
        wrong = true_error(line, w, torque, found.angle)
        largest = np.max(np.abs(found.angle), axis=-1)
        assert np.all(wrong <= found.error)
        assert np.all(found.error <= 1e-9 * largest)
        quick = forced(line, w, torque, estimate=False)
        assert quick.error.size == 0
        np.testing.assert_allclose(quick.angle, found.angle, rtol=0, atol=np.max(found.error) * 2)


def test_next_to_an_undamped_resonance_the_lost_digits_are_in_the_estimate():
    line = chain(np.ones(3), np.ones(2))
    gap = np.append(10.0 ** -np.arange(3.0, 10.0), 1e-7)
    w = np.append(1.0 + gap[:-1], np.sqrt(3.0) * (1 - 1e-7))
    torque = np.tile([1.0 + 0j, 0.3, 0.0], (len(w), 1))
    found = forced(line, w, torque)
    wrong = true_error(line, w, torque, found.angle)
    largest = np.max(np.abs(found.angle), axis=-1)
    assert np.all(wrong <= found.error)
    assert np.all(found.error <= 1e-14 * largest / gap)


@pytest.mark.parametrize("offset", [0.0, 1e-15, 1e-12, 1e-9])
def test_a_resonance_of_an_eliminated_sub_line_costs_no_digits(offset):
    # stations 0 and 1 alone resonate where station 1 is held at the far end of its shaft: nothing
    # special about the whole line, but elimination from that end divides by zero
    line = chain(np.array([1.0, 1.0, 1.0, 1.0]), np.array([1.0, 2.0, 3.0]))
    inner = np.sqrt((4.0 - np.sqrt(8.0)) / 2.0)
    w = np.array([inner, 1.0]) * (1.0 + offset)
    torque = np.zeros((2, 4), dtype=complex)
    torque[:, 3] = 1.0
    torque[:, 2] = 0.25
    for estimate in (True, False):
        found = forced(line, w, torque, estimate=estimate)
        wrong = true_error(line, w, torque, found.angle)
        assert np.all(wrong <= 1e-13 * np.max(np.abs(found.angle), axis=-1))


def test_a_real_loop_is_exact_within_the_estimate():
    line = Line(
        *(np.array(one) for one in ([1.0, 2.0, 0.0, 4.0], [0.0] * 4, [0.0] * 4)),
        *(np.array(one) for one in ([0, 1, 2, 3], [1, 2, 3, 0])),
        *(np.array(one) for one in ([1e3, 2e5, 3e3, 4e2], [1.0, 0, 0, 0], [0.0, 0.01, 0, 0])),
    )
    w, torque = np.array([0.01, 11.0, 900.0]), np.tile([1.0, -1.0j, 0.5, 0.0], (3, 1))
    found = forced(line, w, torque)
    wrong = true_error(line, w, torque, found.angle)
    assert np.all(wrong <= found.error)
    # a dense matrix holds the inertia of slow motion next to k: eps k / (w^2 sum J) is lost
    lost = 1e-14 * (1.0 + 2e5 / (w**2 * 7.0))
    assert np.all(found.error <= 10.0 * lost * np.max(np.abs(found.angle), axis=-1))


def test_at_rest_balanced_torques_leave_the_static_twist():
    line, torque = engine(), np.array([3.0, 0, 0, -1.0, 0, 0, -2.0])
    found = forced(line, 0.0, torque)
    twist = np.cumsum(torque)[:-1] / line.stiffness
    assert found.angle[:-1] - found.angle[1:] == pytest.approx(twist, rel=1e-13)
    assert abs(np.sum(line.inertia * found.angle)) <= 1e-12 * np.max(np.abs(found.angle)) * 2655
    # the limit of low frequency
    low = forced(line, 0.03, torque)
    assert np.max(np.abs(low.angle - found.angle)) <= 1e-6 * np.max(np.abs(found.angle)) + low.error
    assert not np.any(forced(line, 0.0, np.zeros(7)).angle)


def test_an_angle_that_cancels_to_zero_by_chance_leaves_a_branch_its_error():
    # rounded, the second station does not move at all; the first one hangs on it near its resonance
    line = chain(
        np.array([0.18395658310321794, 0.15084061049874883, 0.12870499274504185,
                  0.5818128576813408]),
        np.array([117.77149768934163, 8306.184505856736, 7357.461981117741]),
    )  # fmt: skip
    torque = np.array([[0.0, -1.1171600918770255, 0.0, 1.0]], dtype=complex)
    found = forced(line, [25.30052844704747], torque)
    assert true_error(line, [25.30052844704747], torque, found.angle)[0] <= found.error[0]


def test_an_undamped_critical_in_a_range_is_masked_and_the_rest_is_right():
    line = chain(np.ones(2), np.array([2.0]))
    found = forced_masked(line, np.array([1.0, 2.0, 3.0]), np.array([1.0, 0.0]))
    assert found.masked.tolist() == [False, True, False]
    assert found.error[1] == np.inf and not np.any(found.angle[1])
    # (k - w^2 J) / (w^2 J (w^2 J - 2 k)) of the driven station
    assert found.angle[0, 0] == pytest.approx((2.0 - 1.0) / (1.0 * (1.0 - 4.0)), rel=1e-14)


def test_the_bound_of_a_network_holds_next_to_resonances_of_its_parts():
    generator = np.random.default_rng(1)
    for _ in range(12):
        line = branched(generator)
        n, held = 9, generator.integers(9)
        fixed = line.inertia.copy()
        fixed[held] += 1e9
        natural = natural_modes(line._replace(inertia=fixed)).frequency
        away = generator.choice([-1, 1], 2) * 10.0 ** generator.uniform(-14, -3, 2)
        w = generator.choice(natural[-4:], 2) * (1.0 + away)
        torque = generator.normal(size=(2, n)) + 1j * generator.normal(size=(2, n))
        torque[:, generator.random(n) < 0.5] = 0.0
        loads = [one[None] if one.any() else None for one in torque.T]
        found = network_solution(line, w, loads, np.empty((n, 1, 2), complex))
        wrong = true_error(line, w, torque, found.angle[:, 0].T)
        assert np.all(wrong <= found.error[0])
        assert np.all(found.error <= 1e-11 * found.largest)


def test_a_line_of_2000_inertias_holds_its_bound_at_a_cost_that_grows_with_its_length(monkeypatch):
    """Few frequencies are solved as a network as well, and 40 digits agree within its bound."""
    solved = []

    def counted(line, frequency, *rest):
        solved.append(len(frequency))
        return network_solution(line, frequency, *rest)

    monkeypatch.setattr("vibecalc.torsion.forced.network_solution", counted)
    generator, count = np.random.default_rng(1), 2000
    stiffness = 1e6 * (1.0 + generator.random(count - 1)) * count / 7
    line = chain(0.05 + 0.1 * generator.random(count), stiffness)
    line = line._replace(damping=1e-5 * stiffness)
    w = np.linspace(20.0, 90.0, 10)[:, None] * np.arange(1, 31) * 0.5
    found = forced_masked(line, w, np.ones((1, 1, 6), complex), stations=range(6))
    assert not found.masked.any()
    share = found.error / np.max(np.abs(found.angle), axis=-1)
    assert 0 < sum(solved) < w.size / 4
    assert share.max() < 1e-9
    worst = np.unravel_index(np.argsort(share, axis=None)[[-1, -2]], w.shape)
    torque = np.tile(np.where(np.arange(count) < 6, 1.0 + 0j, 0.0), (2, 1))
    assert np.all(true_error(line, w[worst], torque, found.angle[worst]) <= found.error[worst])
