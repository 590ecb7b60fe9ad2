"""Claim: statistics of impacts are what the single revolutions say, their standard errors what
disjoint ensembles scatter by, and a motion without chaos has its closed form and no scatter."""

import numpy as np
import pytest
from impact_machines import (
    CLEARANCE,
    DAMPING,
    MASS,
    SPEED,
    STIFFNESS,
    compressor_drive,
    gas_towards,
    no_gas,
    source_joint,
)

from vibecalc.errors import UsageError
from vibecalc.impact.linkage import Joint, Linkage, Starts, spread_starts, velocity_scale
from vibecalc.impact.runs import (
    Study,
    distance,
    first_motion,
    parting,
    run_ensemble,
    run_fixed_steps,
)
from vibecalc.impact.simulate import simulate
from vibecalc.impact.statistics import (
    added_force,
    carried_force,
    mean_over_runs,
    quantiles,
    statistics,
)

COMPRESSOR = Linkage(compressor_drive(), gas_towards("crank"), MASS, source_joint())


def test_statistics_against_a_direct_count():
    values = np.random.default_rng(5).lognormal(size=(2, 7, 11, 3))
    mean = mean_over_runs(values)
    low, high = quantiles(values, (0.05, 0.95))
    for c in range(2):
        for n in range(3):
            column = values[c, :, :, n]
            of_members = [np.mean(row) for row in column]
            assert mean.value[c, n] == pytest.approx(np.mean(column), rel=1e-14)
            spread = np.std(of_members, ddof=1) / np.sqrt(7)
            assert mean.standard_error[c, n] == pytest.approx(spread, rel=1e-13)
            assert low.value[c, n] == pytest.approx(np.quantile(column, 0.05), rel=1e-13)
            assert high.value[c, n] == pytest.approx(np.quantile(column, 0.95), rel=1e-13)
            below = np.mean(column <= high.value[c, n], axis=1)
            share = np.std(below, ddof=1) / np.sqrt(7)
            ends = np.quantile(column, [0.95 - share, min(0.95 + share, 1.0)])
            assert high.standard_error[c, n] == pytest.approx((ends[1] - ends[0]) / 2, rel=1e-12)


def test_standard_errors_are_the_scatter_of_disjoint_ensembles():
    # revolutions of a member have much in common, as they do near a slowly decaying start
    generator = np.random.default_rng(7)
    trials, members, revolutions = 600, 40, 12
    of_member = generator.normal(size=(trials, members, 1))
    values = of_member + 0.5 * generator.normal(size=(trials, members, revolutions))
    mean = mean_over_runs(values)
    for statistic in (mean, *quantiles(values, (0.05, 0.5, 0.95))):
        scatter = np.std(statistic.value, ddof=1)
        reported = np.sqrt(np.mean(statistic.standard_error**2))
        assert 0.85 * scatter < reported < 1.25 * scatter
    # as if revolutions were independent
    naive = np.std(values) / np.sqrt(members * revolutions)
    assert naive < 0.5 * np.std(mean.value)


@pytest.mark.long
def test_neighbours_that_have_parted_are_not_missed():
    """When pairs part, and what members do, is the same where the neighbours run on to the end."""
    clearance, members, discard = np.array([1e-6, CLEARANCE]), 12, 3
    short = run_ensemble(COMPRESSOR, Study(clearance, members, discard, 3, 1), 1e-9)
    start = spread_starts(COMPRESSOR, clearance, members)
    gap = np.stack([start.gap, start.gap + 1e-9]).reshape(-1, 1)
    velocity = np.stack([start.velocity, start.velocity]).reshape(-1, 1)
    each = np.tile(np.repeat(clearance, members), 2)
    run = simulate(COMPRESSOR.with_clearance(each), Starts(gap, velocity), discard + 3, 1)
    ends = [
        np.concatenate([first[:, None], then], axis=1).reshape(2, 2, members, -1, 1)
        for first, then in ((gap, run.end_gap), (velocity, run.end_velocity))
    ]
    apart = distance(
        *(one[0] - one[1] for one in ends),
        clearance[:, None, None, None],
        velocity_scale(COMPRESSOR, clearance)[:, None, None],
    )
    dropped = np.isinf(short.distances)
    assert np.any(dropped) and not np.all(dropped[..., -1])
    np.testing.assert_array_equal(short.distances[~dropped], apart[~dropped])
    for found, expected in zip(parting(short.distances), parting(apart), strict=True):
        np.testing.assert_array_equal(found, expected)
    force = run.forces.mean[0, : 2 * members, discard:].reshape(2, members, 3)
    np.testing.assert_array_equal(short.forces.mean[0], force)


def test_a_damped_gap_has_its_closed_form_and_no_scatter():
    # without gas nothing pushes the piston to a face: F + (m / D) F' = m Y''
    damping, clearance, orders = 4e3, 5.08e-3, 8
    joint = Joint(*(np.asarray(v) for v in (clearance, STIFFNESS, DAMPING, damping)))
    linkage = Linkage(compressor_drive(), no_gas(), MASS, joint)
    study = Study(np.array([clearance]), members=5, discard=1, revolutions=2, orders=orders)
    found = run_ensemble(linkage, study, perturbation=1e-10)
    lag = 1.0 + 1j * np.arange(orders + 1) * SPEED * MASS / damping
    carried = carried_force(linkage, orders)
    bands = statistics(found.forces, linkage)
    scale = np.max(np.abs(carried))
    expected = np.abs(carried / lag)[1:]
    for statistic in (bands[name] for name in ("spectrum", "spectrum_low", "spectrum_high")):
        np.testing.assert_allclose(statistic.value[0], expected, atol=1e-11 * scale)
        assert np.max(statistic.standard_error) < 1e-11 * scale
    assert bands["average_amplitude"].value[0] == pytest.approx(np.mean(expected), rel=1e-10)
    added = np.abs(added_force(linkage, found.forces))
    lost = np.broadcast_to(np.abs(carried / lag - carried), added[0].shape)
    np.testing.assert_allclose(added[0], lost, atol=1e-11 * scale)
    # neighbours keep their distance: nothing holds the piston to a place in the gap; but for
    # those that start so near a face that they meet it once
    apart = parting(found.distances)
    assert np.all(np.isinf(apart.revolutions))
    start = spread_starts(linkage, study.clearance, 5)
    reach = 2.0 * np.sum(expected) / (SPEED * damping) + np.abs(start.velocity) * MASS / damping
    free = ((start.gap > reach) & (start.gap < clearance - reach))[..., 0]
    assert np.count_nonzero(free) >= 2
    assert np.max(np.abs(apart.rate[free])) < 1e-6
    assert np.all(found.forces.contacts == 0.0)


@pytest.mark.long
def test_errors_of_the_first_motion_bound_what_rounding_does():
    clearances = CLEARANCE * np.array([0.1, 1.0, 5.0])
    first = first_motion(COMPRESSOR, clearances)
    for parts in (2, 3):
        other = first_motion(COMPRESSOR, clearances, subdivision=parts)
        assert other.contacts.shape == first.contacts.shape
        assert np.all(np.abs(other.contacts - first.contacts) <= first.contacts_error)
        assert np.all(np.abs(other.force - first.force) <= first.force_error)
    # and not by too much: ten digits remain of both
    assert np.max(first.contacts_error) < 1e-10
    assert np.max(first.force_error) < 1e-8 * np.max(np.abs(first.force))
    assert np.all(np.diff(first.contacts_error, axis=1) >= 0.0)


def test_a_study_beyond_memory_is_refused():
    study = Study(np.array([CLEARANCE]), members=10_000, discard=0, revolutions=1000, orders=2000)
    with pytest.raises(UsageError, match="GB"):
        run_ensemble(COMPRESSOR, study, 1e-11)
    with pytest.raises(UsageError, match="fewer members, revolutions or orders"):
        run_fixed_steps(COMPRESSOR, study, "rk4", 1024)
