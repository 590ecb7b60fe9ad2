"""Claim: runs with play keep the laws that hold for any of them: time runs back, no crossing of a
face is passed over; statistics do not depend on the order of members, and who leads and when runs
part is read off as a plain count would.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from impact_machines import (
    CLEARANCE,
    DAMPING,
    LENGTH,
    MASS,
    RADIUS,
    SPEED,
    STIFFNESS,
    compressor_drive,
    near,
    source_joint,
    source_linkage,
    states,
)

from vibecalc.impact.ledger import absolute_mean, highest
from vibecalc.impact.linkage import (
    assemble_train,
    slider_crank_drive,
    spring_energy,
)
from vibecalc.impact.roots import bernstein, sign_changes, single_root
from vibecalc.impact.runs import APART, TOGETHER, parting
from vibecalc.impact.simulate import simulate
from vibecalc.impact.statistics import (
    IMPACT,
    Statistic,
    dominance,
    dominant,
    dominant_from,
    mean_over_runs,
    quantiles,
)
from vibecalc.kinematics.slider_crank import piston_motion


@pytest.mark.long
def test_time_runs_back():
    # without damping the motion is reversible: forwards a turn, then back with the pin's motion
    # mirrored in time. Errors grow with every contact, so few contacts: a wide gap
    drive = compressor_drive()
    joint = source_joint(clearance=6 * CLEARANCE, contact_damping=0.0, film_damping=0.0)
    gap, velocity = np.array([1.1e-4, 1.3e-4]), np.array([0.3, -0.2])
    linkage = source_linkage(joint=joint)
    there = simulate(linkage, states(gap, velocity), 1, 1)
    mirrored = linkage._replace(
        drive=drive._replace(displacement=np.conj(drive.displacement)),
        gas=linkage.gas._replace(force=linkage.gas.force[::-1]),
    )
    last = there.end_gap[:, 0]
    back = simulate(mirrored, states(last, -there.end_velocity[:, 0]), 1, 1)
    contacts = there.forces.contacts[0, :, 0]
    assert np.all(contacts >= 2)
    # on the way back every contact is made where it was broken
    ends_touching = ((last < 0.0) | (last > joint.clearance))[:, 0]
    assert np.array_equal(back.forces.contacts[0, :, 0], contacts - ends_touching)
    np.testing.assert_allclose(back.end_gap[:, 0, 0], gap, rtol=1e-6)
    np.testing.assert_allclose(back.end_velocity[:, 0, 0], -velocity, rtol=1e-6)


SIZE = st.floats(-2.0, 2.0)


@pytest.mark.long
@given(
    st.tuples(SIZE, SIZE, SIZE, SIZE, SIZE, SIZE),
    st.sampled_from(["continuous", "full_deflection"]),
    st.sampled_from(["crank", "head"]),
)
@settings(max_examples=7, deadline=None)
def test_energy_balance_of_machines_of_any_size(sizes, law, sense):
    gap_size, stiff, heavy, contact, film, fast = (10.0**size for size in sizes)
    drive = slider_crank_drive(RADIUS, LENGTH, SPEED * fast**0.25)
    joint = source_joint(
        law,
        clearance=CLEARANCE * gap_size**0.5,
        stiffness=STIFFNESS * stiff**0.5,
        contact_damping=DAMPING * contact,
        film_damping=DAMPING * film,
    )
    linkage = source_linkage(sense, joint, drive=drive, mass=MASS * heavy**0.25)
    run = simulate(linkage, states(near(2)), 1, 8)
    assert np.all(run.imbalance < 1e-12)
    wrist = run.forces
    assert np.all(wrist.peak >= wrist.mean)
    bound = wrist.mean[..., None] * np.array([1.0, *[2.0] * 8])
    assert np.all(np.abs(wrist.harmonics) <= bound * (1 + 1e-12))
    assert np.all(wrist.contact_time <= 2 * np.pi / drive.speed * (1 + 1e-12))


@given(st.lists(st.floats(0.01, 0.99), min_size=0, max_size=4), st.integers(0, 2**32 - 1))
def test_sign_changes_bound_the_roots(roots, seed):
    # a product of known roots and of a factor without roots in the interval
    factor = np.polynomial.Polynomial(np.random.default_rng(seed).random(5) + 0.05)
    for root in roots:
        factor *= np.polynomial.Polynomial([-root, 1.0])
    coefficients = np.zeros((12, 1))
    coefficients[: len(factor.coef), 0] = factor.coef
    changes = int(sign_changes(bernstein(coefficients) > 0.0)[0])
    assert changes >= len(roots) and (changes - len(roots)) % 2 == 0
    if len(roots) == 1:
        found = single_root(coefficients, np.zeros(1), np.ones(1))[0]
        assert found == pytest.approx(roots[0], rel=1e-12)


@given(st.integers(0, 2**32 - 1))
def test_statistics_of_a_piece(seed):
    generator = np.random.default_rng(seed)
    force = generator.normal(size=(14, 5)) / (1.0 + np.arange(14))[:, None] ** 2
    at = (np.arange(20000) + 0.5) / 20000
    dense = np.array([np.abs(np.polynomial.polynomial.polyval(at, force[:, k])) for k in range(5)])
    np.testing.assert_allclose(absolute_mean(force), dense.mean(axis=1), rtol=1e-6, atol=1e-7)
    top = highest(force, np.zeros(5))
    assert np.all(top >= dense.max(axis=1) * (1 - 1e-13))
    ends = np.maximum(np.abs(force[0]), np.abs(force.sum(axis=0)))
    np.testing.assert_allclose(top, np.maximum(dense.max(axis=1), ends), rtol=1e-6)
    assert np.array_equal(highest(force, top + 1.0), top + 1.0)


@pytest.mark.parametrize("law", ["continuous", "full_deflection"])
def test_spring_energy_is_the_integral_of_the_force(law):
    train = assemble_train(source_linkage(joint=source_joint(law)), 1)
    for end in (2.5 * CLEARANCE, -1.5 * CLEARANCE, 0.5 * CLEARANCE):
        place = np.linspace(0.0, end, 200001)
        middle = 0.5 * (place[1:] + place[:-1])
        rest = CLEARANCE if law == "continuous" else 0.0
        force = STIFFNESS * np.where(
            middle > CLEARANCE, middle - rest, np.where(middle < 0.0, middle, 0.0)
        )
        stored = spring_energy(train.gaps, np.array([[end]]))[0, 0]
        work = np.sum(force * np.diff(place))
        assert stored == pytest.approx(work, rel=1e-4, abs=1e-15)


@pytest.mark.parametrize("rod_ratio", [0.1, 0.5, 0.9, 0.98])
def test_drive_is_the_slider_crank(rod_ratio):
    drive = slider_crank_drive(rod_ratio, 1.0, 7.0, with_rod_tangent=True)
    angle = np.linspace(0, 2 * np.pi, 301)
    motion = piston_motion(angle, rod_ratio, 1.0)
    place = np.sum(drive.displacement * np.exp(1j * np.outer(angle, drive.orders)), axis=1).real
    np.testing.assert_allclose(place, rod_ratio + 1.0 - motion.position, atol=4e-15)
    bent = -np.square(drive.orders) * drive.displacement
    bend = np.sum(bent * np.exp(1j * np.outer(angle, drive.orders)), axis=1).real
    np.testing.assert_allclose(bend, -motion.acceleration, atol=3e-14 / (1 - rod_ratio))
    wave = np.exp(1j * np.outer(angle, drive.tangent_orders))
    tangent = np.sum(drive.rod_tangent * wave, axis=1).real
    exact = np.tan(np.arcsin(rod_ratio * np.sin(angle)))
    np.testing.assert_allclose(tangent, exact, atol=2e-13)


sizes = st.floats(0.0, 1e6)


@settings(max_examples=30)
@given(
    arrays(np.float64, (2, 6, 4), elements=st.floats(-1e6, 1e6)),
    st.permutations(range(6)),
)
def test_members_may_stand_in_any_order(values, order):
    for one, two in zip(
        (mean_over_runs(values), *quantiles(values, (0.05, 0.5, 0.95))),
        (mean_over_runs(values[:, order]), *quantiles(values[:, order], (0.05, 0.5, 0.95))),
        strict=True,
    ):
        scale = 1e-12 * max(np.max(np.abs(values)), 1e-300)
        np.testing.assert_allclose(one.value, two.value, rtol=0.0, atol=scale)
        np.testing.assert_allclose(one.standard_error, two.standard_error, rtol=1e-6, atol=scale)


@given(arrays(np.int64, st.integers(1, 12), elements=st.integers(0, 2)))
def test_dominant_from_is_a_count_from_the_end(leading):
    order = len(leading)
    while order > 0 and leading[order - 1] == IMPACT:
        order -= 1
    expected = order + 1 if order < len(leading) else 0
    assert dominant_from(leading) == expected


@settings(max_examples=30)
@given(
    arrays(np.float64, (2, 8), elements=sizes),
    arrays(np.float64, (2, 8), elements=st.floats(0.0, 10.0)),
    arrays(np.float64, 8, elements=sizes),
    arrays(np.float64, 8, elements=sizes),
)
def test_dominance_names_the_largest(value, uncertainty, shaking, motor):
    found = dominance(Statistic(value, uncertainty), shaking, motor)
    for c in range(2):
        for n in range(8):
            three = (shaking[n], value[c, n], motor[n])
            assert three[found.dominant[c, n]] == max(three)
    np.testing.assert_array_equal(
        found.dominant_from, dominant_from(dominant(value, shaking, motor))
    )
    sure = dominance(Statistic(value, np.zeros_like(value)), shaking, motor)
    assert not np.any(sure.dominant_spread) and not np.any(sure.dominant_from_spread)
    # an uncertainty that can change what dominates an order shows
    flips = (value - 2 * uncertainty > shaking) != (value + 2 * uncertainty > shaking)
    assert np.all((found.dominant_spread > 0.0)[flips & (motor == 0.0)])


@given(st.floats(-14.0, -2.0), st.floats(0.05, 6.0), st.integers(1, 20))
def test_exponential_parting(exponent, rate, turns):
    start = 10.0**exponent
    distances = np.minimum(start * np.exp(rate * np.arange(turns + 1)), 1.0)
    found = parting(distances)
    when = np.log(APART / start) / rate
    # a distance beyond 1, as of runs that have parted, is no part of the exponential
    reaches = distances[-1] >= APART
    if not reaches:
        assert np.isinf(found.revolutions)
    elif start * np.exp(rate * np.ceil(when)) <= 1.0 and start > TOGETHER:
        assert abs(found.revolutions - when) < 1e-9 * (1.0 + when)
        assert abs(found.rate - rate) < 1e-9 * rate
    else:
        assert np.floor(when) <= found.revolutions <= np.ceil(when) + 1e-9


def test_runs_that_fall_together_never_part():
    found = parting(np.array([[1e-6, 1e-12, 0.0, 0.0], [0.5, 1.0, 1.0, 1.0]]))
    assert np.isinf(found.revolutions[0]) and found.rate[0] == np.log(TOGETHER / 1e-6) / 3
    assert found.revolutions[1] == 0.0
