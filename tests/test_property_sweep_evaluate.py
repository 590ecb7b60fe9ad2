"""Claim: each point of a sweep is what a run of its case alone gives, or says why there is none."""

from typing import Any

import numpy as np
import pytest
from shipped_cases import CASES
from sweep_blocks import quantities
from sweep_samples import MODEL, SPEED, STIFFNESS, axis, design_of, generator, spread

from vibecalc.core.case.load import load_case, validate
from vibecalc.core.case.raw import case_at
from vibecalc.core.case.study_tables import Sweep
from vibecalc.core.results.layout import BUG, DONE
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import execute
from vibecalc.core.study.sweep import evaluate
from vibecalc.core.study.sweep.design import make_design
from vibecalc.core.study.sweep.evaluate import Evaluator
from vibecalc.core.study.sweep.prepare import choose

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
