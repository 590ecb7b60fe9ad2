"""Claim: the points of a sweep hang on its tables alone, each on its number, and hashes name them.

Truth: numpy's own grids, scipy's Sobol sequence, counts in equal slices, a second process.
"""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shipped_cases import CASES
from sweep_blocks import quantities
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

from vibecalc.core.case.load import load_case, validate
from vibecalc.core.case.raw import case_at
from vibecalc.core.case.study_tables import Sweep
from vibecalc.core.results.layout import BUG, DONE
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import execute
from vibecalc.core.study.sweep import evaluate
from vibecalc.core.study.sweep.checks import keep_problems, stored_paths
from vibecalc.core.study.sweep.design import make_design
from vibecalc.core.study.sweep.evaluate import Evaluator
from vibecalc.core.study.sweep.prepare import choose, identify
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


# ----------------------------------------------------------------------------
# Each point is what a run of its case alone gives, or says why there is none.
# ----------------------------------------------------------------------------

#: which arrays do not vary
END = "isolation.run_up.to"
KEEP = (
    "isolation/support_force/steady_peak",
    "isolation/couple_over_lever/run_up_peak",
    "excitation/force",
)
COMMON = ("isolation/support_force/steady_peak", "isolation/support_force/run_up_peak")


def test_points_are_the_runs_of_their_cases_to_the_last_bit() -> None:
    design = design_of(
        spread(SPEED, "3000 rpm", "5000 rpm", 3),
        axis(MODEL, "pitch", "rigid_body"),
        spread(STIFFNESS, "5 N/mm", "50 N/mm", 2),
    )
    block = Evaluator(generator(), design, COMMON)(np.arange(design.count))
    assert (block.status == DONE).all() and not any(block.message) and not block.left_out
    for number in range(design.count):
        case = validate(case_at(generator().resolved, design.settings(number)))
        record = run_case(case, wanted=frozenset(COMMON))
        for path in COMMON:
            quantity, found = record[path], quantities(block)[path]
            assert found.values[number].tobytes() == quantity.values.tobytes()
            assert found.errors[number] == quantity.error_estimate
            assert (found.unit, found.amplitude) == (quantity.unit, quantity.amplitude)


def test_a_mistake_of_ours_keeps_its_traceback(monkeypatch: pytest.MonkeyPatch) -> None:
    run = evaluate.run_case

    def broken(case: Any, **more: Any) -> Any:
        if case.machine.speed > 250.0:
            raise ZeroDivisionError("a slip")
        return run(case, **more)

    monkeypatch.setattr(evaluate, "run_case", broken)
    block = Evaluator(generator(), design_of(axis(SPEED, 200.0, 300.0)), KEEP)(np.arange(2))
    assert block.status.tolist() == [DONE, BUG]
    assert "Traceback" in block.message[1] and "ZeroDivisionError: a slip" in block.message[1]


@pytest.mark.long
def test_each_point_of_a_case_with_an_optimisation_is_optimised() -> None:
    loaded = load_case(CASES["generator_mount_design"], ["optimisation.starts=1"])
    key = "machine.speed"
    sweep = Sweep.model_validate({"axes": [axis(key, 500.0, 520.0)]})
    design = make_design(sweep, loaded.resolved)
    keep = ("optimisation/objective", "isolation/support_displacement/total")
    block = Evaluator(loaded, design, keep)(np.array([1]))
    assert block.status.tolist() == [DONE], block.message
    alone = load_case(CASES["generator_mount_design"], ["optimisation.starts=1", f"{key}=520.0"])
    record = execute(alone).record
    for path in keep:
        assert quantities(block)[path].values[0].tobytes() == record[path].values.tobytes()
    assert choose(loaded.case, design, keep).kind == "pool"


@pytest.mark.parametrize(
    ("points", "jobs", "kind"), [(5, 8, "reuse"), (5000, 1, "reuse"), (5000, 2, "pool")]
)
def test_processes_are_started_for_long_work_only(points: int, jobs: int, kind: str) -> None:
    design = design_of(spread(END, "1000 rpm", "5000 rpm", points))
    assert choose(generator().case, design, KEEP, jobs).kind == kind
