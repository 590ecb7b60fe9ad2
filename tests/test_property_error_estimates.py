"""Claim: the error estimates in a record are honest, from the kinematics to the run-up.

Seeded random machines, pitch and rigid body, are run from their case tables; every quantity is held
against an independent truth in 50 digits (`exact_*.py`), for the inputs as stored. At most 1 % of
the estimates are below a tenth of the true error, at most 5 % above a thousand times of it. An
undershot `[excitation] orders` is in the estimates, and `[accuracy] rtol` is met or said not to be.
"""

import numpy as np
import pytest
from random_machines import Table, random_machine, without_damping
from truth_report import Judged, judge

from vibecalc.core.case.load import validate
from vibecalc.core.results.tolerance import reached
from vibecalc.core.run.run import run_case

MOST_TOO_LOW, MOST_TOO_HIGH = 0.01, 0.05
#: a rigid body, and a pitching one without damping; one with damping is held further down
FEW = {
    "rigid_body": [random_machine(1, "rigid_body")],
    "undamped": [without_damping(random_machine(22, "pitch"))],
}


def hold(judged: list[Judged]) -> None:
    """The claim for a set of (machine, quantity) pairs."""
    low = [one for one in judged if one.too_low]
    high = [one for one in judged if one.too_high]
    assert len(low) <= MOST_TOO_LOW * len(judged), low
    assert len(high) <= MOST_TOO_HIGH * len(judged), high


@pytest.fixture(scope="module")
def judged() -> dict[str, list[Judged]]:
    return {kind: [one for table in FEW[kind] for one in judge(table)] for kind in FEW}


@pytest.mark.parametrize("kind", FEW)
def test_estimates_against_truth(kind: str, judged: dict[str, list[Judged]]) -> None:
    assert len(judged[kind]) > 30 * len(FEW[kind])
    assert sum(one.error > 0.0 for one in judged[kind]) > 0.5 * len(judged[kind])
    hold(judged[kind])


def test_estimates_are_not_zero_where_there_is_an_error(judged: dict[str, list[Judged]]) -> None:
    silent = [one for each in judged.values() for one in each if one.error > one.estimate == 0.0]
    assert silent == []


@pytest.mark.long
@pytest.mark.parametrize("model", ["pitch", "rigid_body"])
def test_estimates_of_three_hundred_machines(model: str) -> None:
    judged = [one for seed in range(100, 400) for one in judge(random_machine(seed, model))]
    judged += [
        one
        for seed in range(100, 130)
        for one in judge(without_damping(random_machine(seed, model)))
    ]
    low, high = (sum(getattr(one, which) for one in judged) for which in ("too_low", "too_high"))
    print(f"{model}: {len(judged)} estimates, {low} too low, {high} too high")
    hold(judged)


def cut_machine(seed: int, model: str, orders: int, run_up: bool = True) -> Table:
    """A random machine with R/L = .4, of which only a few orders are kept."""
    table = random_machine(seed, model)
    train = table["machine"]["crank_train"]
    train["rod_length"] = train["crank_radius"] / 0.4
    table.pop("kinematics", None)
    table["excitation"]["orders"] = orders
    if not run_up:
        del table["isolation"]["run_up"]
    return table


@pytest.mark.parametrize(
    ("orders", "seed", "model", "run_up"),
    [
        (2, 2, "pitch", False),
        pytest.param(2, 2, "pitch", True, marks=pytest.mark.long),
        pytest.param(3, 3, "rigid_body", True, marks=pytest.mark.long),
        pytest.param(4, 2, "pitch", True, marks=pytest.mark.long),
    ],
)
def test_peaks_count_what_a_cut_leaves_out(
    orders: int, seed: int, model: str, run_up: bool
) -> None:
    judged = judge(cut_machine(seed, model, orders, run_up))
    peaks = [one for one in judged if "peak" in one.path or one.path.endswith("residual")]
    cut = [one for one in peaks if one.error > 1e-9 * one.size]
    assert len(cut) > 0.6 * len(peaks)
    for one in cut:
        assert 0.1 * one.error <= one.estimate <= 1e3 * one.error, one
    harmonics = [one for one in judged if one.path.endswith("_harmonics")]
    assert len(harmonics) >= 6
    for one in harmonics:  # a harmonic that is kept is as exact as ever
        assert one.estimate <= 1e-9 * one.size, one


@pytest.mark.parametrize(
    ("rtol", "count"),
    [
        (1e-6, 4),
        *(pytest.param(rtol, 20, marks=pytest.mark.long) for rtol in (1e-3, 1e-6, 1e-9)),
    ],
)
def test_default_orders_meet_the_tolerance_or_the_run_says_where_not(
    rtol: float, count: int
) -> None:
    missed = total = 0
    for seed in range(40, 40 + count):
        table = random_machine(seed, "pitch" if seed % 2 else "rigid_body")
        table["accuracy"]["rtol"] = rtol
        table["excitation"].pop("orders", None)
        record = run_case(validate(table))
        warned = " ".join(record.warnings)
        for path, quantity in record.items():
            relative = reached(quantity)
            if relative is None:
                continue
            total += 1
            if relative > rtol:
                missed += 1
                assert f"not within rtol = {rtol:g}" in warned, path
    assert total > count * 30
    assert missed <= 0.02 * total


@pytest.mark.parametrize(
    "seeds", [(43,), pytest.param((41, 43, 47), marks=pytest.mark.long)], ids=len
)
def test_true_error_of_the_default_orders_is_within_the_tolerance(seeds: tuple[int, ...]) -> None:
    """Against the truth: rtol = 1e-3 leaves real truncation errors, all of them below it."""
    errors = []
    for seed in seeds:
        table = random_machine(seed, "pitch")
        table["accuracy"]["rtol"] = 1e-3
        table["excitation"] = {"driven_machine": "on_body"}
        del table["isolation"]["run_up"]  # whose peaks the machines above have
        judged = judge(table)
        hold(judged)
        errors += [one.error / one.size for one in judged if one.path.endswith("steady_peak")]
    assert len(errors) == 2 * len(seeds)
    assert 1e-12 < max(errors) < 1e-3


def test_a_tolerance_that_is_missed_is_named_with_what_was_reached() -> None:
    table = cut_machine(1, "pitch", 2)
    record = run_case(validate(table))
    (warning,) = [text for text in record.warnings if "not within rtol" in text]
    name, share = warning.split("estimates: ")[1].split(" (")[:2]
    quantity = record[name]
    largest = float(np.max(np.abs(quantity.values)))
    assert float(share.split(")")[0]) == pytest.approx(quantity.error_estimate / largest, rel=0.06)
    table["excitation"]["orders"] = 60
    assert not any("not within rtol" in text for text in run_case(validate(table)).warnings)
