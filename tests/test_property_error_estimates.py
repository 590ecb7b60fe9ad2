"""Claim: the error estimates in a record are honest, from the kinematics to the run-up.

Seeded random machines, on springs and compressors, are run from their case tables; every quantity
is held against an independent truth in 50 digits (`exact_*.py`), for the inputs as stored. Of many
machines at most 1 % of the estimates are below a tenth of the true error, at most 5 % above a
thousand times of it; of the few that CI runs, none is below. An undershot `[excitation] orders` is
in the estimates, and `[accuracy] rtol` is met or said not to be.
"""

import copy
from collections.abc import Callable, Iterable

import mpmath
import numpy as np
import pytest
from estimate_counts import UNIT, hold
from exact_response import response_results
from long_but import long_but
from random_machines import Table, random_machine, without_damping
from response_machines import random_compressor
from truth_report import DIGITS, Judged, judge, judge_rows

from vibecalc.core.case.load import validate
from vibecalc.core.results.tolerance import reached
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.core.run.run import run_case

#: of the range of a peak over the phases there is no truth here; numbers of modes are no estimates
WITHOUT_TRUTH = ("peak_low", "peak_high", "nearest_order", "resonances_skipped/")


def on_springs(seed: int, model: str, *, run_up: bool = True) -> Table:
    """A random machine on its mounts, with or without its run-up, which takes most of the time."""
    table = random_machine(seed, model)
    if not run_up:
        del table["isolation"]["run_up"]
    return table


def compressor(seed: int, *, run_up: bool = True, operations: bool = True) -> Table:
    """A random compressor; of its operations the first two."""
    table = random_compressor(seed)
    table["accuracy"]["rtol"] = max(table["accuracy"]["rtol"], 1e-9)
    response = table["response"]
    if not run_up:
        del response["run_up"]
    del response["operations"][2:]
    if not operations:
        del response["operations"]
        response.pop("balances", None)
    return table


class OfResponse(Judged):
    """A result of a compressor on its suspension."""

    @property
    def too_high(self) -> bool:
        """A thousand times above the true error; one below a quarter of a last place is luck.

        Energies that are nothing but round-off are compared by their roots, as amplitudes are.
        """
        nothing = "_energy" in self.path and self.size < self.estimate
        factor = 1e6 if nothing else 1e3
        met = self.error == self.size == 0.0
        return not met and self.estimate > factor * max(self.error, 0.25 * UNIT * self.size)


def judge_response(table: Table) -> list[Judged]:
    """Every result below `response/` of a run next to the truth."""
    case = validate(copy.deepcopy(table))
    assert check_machine(case) == []
    record = run_case(case)
    with mpmath.workdps(DIGITS):
        rows = judge_rows(response_results(case, record), record)
        judged: list[Judged] = [OfResponse(*one) for one in rows]
    missing = {path for path in record if path.startswith("response/")}
    missing -= {one.path for one in judged}
    missing = {path for path in missing if not any(part in path for part in WITHOUT_TRUTH)}
    assert not missing, f"no truth for {sorted(missing)}"
    return judged


#: what CI runs: every kind of moving part, of damping and of driven machine is in one of them
FEW: dict[str, tuple[Callable[[Table], list[Judged]], list[Table]]] = {
    "rigid body with run-up": (judge, [on_springs(1, "rigid_body")]),
    "pitch without damping": (judge, [without_damping(on_springs(22, "pitch"))]),
    "pitch": (judge, [on_springs(seed, "pitch", run_up=False) for seed in (1, 2, 3, 5)]),
    "rigid body": (judge, [on_springs(seed, "rigid_body", run_up=False) for seed in (3, 4, 6)]),
    "compressor": (
        judge_response,
        [compressor(seed, run_up=False, operations=False) for seed in (2, 4, 5, 7, 8, 11)],
    ),
    "operations": (judge_response, [compressor(seed, run_up=False) for seed in (0, 3, 9)]),
}
MANY: dict[str, tuple[Callable[[Table], list[Judged]], Iterable[Table]]] = {
    "pitch": (judge, (on_springs(seed, "pitch") for seed in range(100, 400))),
    "rigid body": (judge, (on_springs(seed, "rigid_body") for seed in range(100, 400))),
    "without damping": (
        judge,
        (
            without_damping(on_springs(seed, model))
            for seed in range(100, 130)
            for model in ("pitch", "rigid_body")
        ),
    ),
    "compressor": (
        judge_response,
        (
            compressor(seed, run_up=seed % 6 == 0, operations=seed % 3 == 0)
            for seed in range(400, 700)
        ),
    ),
    "compressor with everything": (
        judge_response,
        (random_compressor(seed) for seed in range(100, 300)),
    ),
}


@pytest.mark.parametrize(
    "kind", long_but(FEW, *(one for one in FEW if one not in ("operations", "compressor")))
)
def test_estimates_against_truth(kind: str) -> None:
    judge_one, tables = FEW[kind]
    judged = [one for table in tables for one in judge_one(table)]
    assert len(judged) > 20 * len(tables)
    assert sum(one.error > 0.0 for one in judged) > 0.5 * len(judged)
    assert [one for one in judged if one.too_low] == []
    hold(judged)


@pytest.mark.long
@pytest.mark.timeout(14000)
@pytest.mark.parametrize("kind", MANY)
def test_estimates_of_hundreds_of_machines(kind: str) -> None:
    judge_one, tables = MANY[kind]
    hold([one for table in tables for one in judge_one(table)])


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
                assert f"rtol = {rtol:g} not reached" in warned, path
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
    (warning,) = [text for text in record.warnings if "accuracy not reached" in text]
    name, share = warning.split("): ", 1)[1].split(" (")[:2]
    quantity = record[name]
    largest = float(np.max(np.abs(quantity.values)))
    assert float(share.split(")")[0]) == pytest.approx(quantity.error_estimate / largest, rel=0.06)
    table["excitation"]["orders"] = 60
    assert not any("accuracy not reached" in text for text in run_case(validate(table)).warnings)
