"""Claim: the points of a sweep hang on its tables alone, each on its number, and hashes name them.

Truth: numpy's own grids, scipy's Sobol sequence, counts in equal slices, a second process.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sweep_samples import (
    ALL_KINDS,
    DAMPING,
    MODEL,
    ORDERS,
    SPEED,
    STIFFNESS,
    axis,
    design_of,
    generator,
    spread,
)

from vibecalc.core.case.raw import case_at
from vibecalc.core.study.sweep.checks import keep_problems, stored_paths
from vibecalc.core.study.sweep.prepare import identify
from vibecalc.core.study.sweep.sampling import MOST_POINTS, drawn

SAMPLINGS = sorted(MOST_POINTS)


def test_grid_is_in_c_order():
    design = design_of(
        spread(STIFFNESS, 1, 3, 3), axis(SPEED, 10, 20), spread(DAMPING, 100, 400, 4)
    )
    mesh = np.meshgrid([1.0, 2.0, 3.0], [10.0, 20.0], [100.0, 200.0, 300.0, 400.0], indexing="ij")
    assert design.shape == (3, 2, 4)
    assert design.count == 24
    points = design.value_of(np.arange(24))
    assert np.array_equal(points, np.stack([part.ravel() for part in mesh], axis=1))


@settings(max_examples=15, deadline=None)
@given(st.sampled_from(["grid", *SAMPLINGS]), st.data())
def test_a_point_hangs_on_its_number_alone(sampling, data):
    if sampling == "grid":
        design = design_of(
            spread(STIFFNESS, "5 N/mm", "50 N/mm", 11, spacing="log"), *ALL_KINDS[2:]
        )
    else:
        indices = sampling in ("sobol", "monte_carlo") and data.draw(st.booleans())
        design = design_of(*ALL_KINDS, sampling=sampling, points=40, indices=indices)
    everything = design.value_of(np.arange(design.count))
    numbers = np.array(data.draw(st.lists(st.integers(0, design.count - 1), max_size=7)), dtype=int)
    assert np.array_equal(design.value_of(numbers), everything[numbers])
    with pytest.raises(IndexError):
        design.value_of(np.array([design.count]))


def test_blocks_of_a_long_sampling_go_on_where_the_one_before_ends():
    from scipy.stats import kstest, qmc

    for sampling in ("sobol", "monte_carlo"):
        shares = drawn(sampling, np.arange((1 << 16) - 512, (1 << 16) + 512), 2, 1 << 17, 3)
        assert len({tuple(point) for point in shares.tolist()}) == 1024
        assert kstest(shares[512:, 0], "uniform").pvalue > 1e-3
    whole = qmc.Sobol(2, rng=3).random(1 << 17)[(1 << 16) - 512 : (1 << 16) + 512]
    shares = drawn("sobol", np.arange((1 << 16) - 512, (1 << 16) + 512), 2, 1 << 17, 3)
    assert np.max(np.abs(shares - whole)) < 2.0**-30


@pytest.mark.parametrize("sampling", ["sobol", "monte_carlo"])
def test_runs_for_sobol_indices_exchange_one_axis_at_a_time(sampling):
    axes = [spread(key, 1, 2, **{"in_step": []}) for key in (STIFFNESS, DAMPING, SPEED)]
    axes[1]["in_step"] = [spread(ORDERS, 4, 8, 5)]
    design = design_of(*axes, sampling=sampling, points=8, indices=True)
    assert design.count == 8 * 5
    runs = design.value_of(np.arange(40)).reshape(8, 5, 4)
    a, b = runs[:, 0], runs[:, 1]
    assert np.all(a[:, :2] != b[:, :2])
    for position, columns in enumerate([[0], [1, 2], [3]]):
        expected = a.copy()
        expected[:, columns] = b[:, columns]
        assert np.array_equal(runs[:, 2 + position], expected)


def test_the_hash_knows_all_that_is_computed():
    resolved, design = generator().resolved, design_of(axis(STIFFNESS, 5000, 6000))
    hashes = {identify(resolved, design, ["a"]), identify(resolved, design, ["a", "c"])}
    other = case_at(resolved, {"accuracy.rtol": 1e-6}, without=())
    hashes.add(identify(other, design, ["a"]))
    hashes.add(identify(resolved, design_of(axis(STIFFNESS, 6000, 5000)), ["a"]))
    for seed in (1, 2):
        sampled = design_of(spread(STIFFNESS, 1, 2), sampling="sobol", points=4, seed=seed)
        hashes.add(identify(resolved, sampled, ["a"]))
    assert len(hashes) == 6
    assert identify(resolved, design, ["a", "b"]) == identify(resolved, design, ["b", "a", "b"])
    assert identify({**resolved, "sweep": {}}, design, ["a"]) == identify(resolved, design, ["a"])


def test_default_and_named_quantities_are_kept():
    loaded = generator()
    design = design_of(axis(STIFFNESS, 5000, 6000))
    kept = stored_paths((), loaded.case, design, loaded.resolved)
    assert "isolation/couple_over_lever/run_up_peak" in kept
    assert "isolation/couple_over_lever/run_up" not in kept
    assert {limit.quantity for limit in loaded.case.limit} <= set(kept)
    assert not list(keep_problems(kept, loaded.case, design, loaded.resolved))
    by_model = design_of(axis(MODEL, "pitch", "rigid_body"))
    shared = stored_paths((), loaded.case, by_model, loaded.resolved)
    assert "isolation/pitch/inertia" in kept
    assert "isolation/pitch/inertia" not in shared
    assert "isolation/support_force/steady_peak" in shared
    assert not list(keep_problems(shared, loaded.case, by_model, loaded.resolved))
