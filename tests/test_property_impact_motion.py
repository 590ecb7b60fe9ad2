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
    near,
    source_joint,
    source_linkage,
    states,
)

from vibecalc.impact.ledger import absolute_mean, highest
from vibecalc.impact.linkage import slider_crank_drive
from vibecalc.impact.runs import APART, TOGETHER, parting
from vibecalc.impact.simulate import simulate
from vibecalc.impact.statistics import IMPACT, dominant_from

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


@given(arrays(np.int64, st.integers(1, 12), elements=st.integers(0, 2)))
def test_dominant_from_is_a_count_from_the_end(leading):
    order = len(leading)
    while order > 0 and leading[order - 1] == IMPACT:
        order -= 1
    expected = order + 1 if order < len(leading) else 0
    assert dominant_from(leading) == expected


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
