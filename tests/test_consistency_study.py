"""Claim: a study shows the case as written next to the optimum, counts what is no machine, and may
change a key that the case leaves out like any other.
"""

from pathlib import Path

import numpy as np
import pytest
from shipped_cases import CASES, result_of
from sweep_blocks import quantities

from vibecalc.core.case.load import load_case
from vibecalc.core.case.raw import number_at
from vibecalc.core.report.text import render_report
from vibecalc.core.run.run import run_case
from vibecalc.core.study.binding import Binding, Foreseen
from vibecalc.core.study.execute import execute, load_checked
from vibecalc.core.study.sweep.design import make_design
from vibecalc.core.study.sweep.evaluate import Evaluator
from vibecalc.core.study.sweep.prepare import sweep_settings
from vibecalc.errors import CaseError, NumericalFailure


def test_balance_of_start_and_optimum_stand_in_one_report() -> None:
    result = result_of("four_cylinder")
    record = result.record
    start = record["optimisation/start/excitation/balance/total_position_sine"].values
    assert start[0] == pytest.approx(-0.6, abs=1e-12)
    text = render_report(result, full=True)
    optimum, rest = text.split("Balance table at the start")
    assert "Balance table of equal cylinders (z" in optimum
    assert "-0.6000" in rest.split("order 2")[0]
    assert record["excitation/residual"].values < record[
        "optimisation/start/excitation/residual"
    ].values  # fmt: skip


def test_points_that_are_no_machine_are_counted_and_said(tmp_path: Path) -> None:
    head = CASES["four_cylinder"].read_text(encoding="utf-8").split("[optimisation]")[0]
    study = """
[optimisation]
variables = [{ key = "machine.crank_train.rod_length", min = "20 mm", max = "400 mm" }]
objective = { quantity = "excitation/residual" }
starts = 4
"""
    path = tmp_path / "rod.toml"
    path.write_text(head + study, encoding="utf-8")
    record = execute(load_checked([path])[0]).record
    said = [text for text in record.warnings if "could not be evaluated" in text]
    assert len(said) == 1
    assert "connecting rod must be longer than the crank radius" in said[0]
    assert int(record["optimisation/failures"].values) > 0
    assert record["optimisation/variable/machine.crank_train.rod_length"].values == 0.4


# ----------------------------------------------------------------------------
# A point of a search that a check refuses, or arrays cannot compute, has its own run.
# ----------------------------------------------------------------------------


def binding_of(name: str) -> Binding:
    return Binding(load_case(CASES[name]))


def test_points_that_need_a_run_of_their_own_are_left_to_it() -> None:
    study = binding_of("generator_mount_design")
    undamped = study.first * np.array([1.0, 0.0, 1.0])  # a run-up without bound
    wanted = frozenset({study.goal.quantity, *(limit.quantity for limit, _ in study.held)})
    assert Foreseen().find(study, study.first, wanted) is not None
    assert Foreseen().find(study, undamped, wanted) is None
    binding = binding_of("compressor_balance")
    beyond = binding.first.copy()
    beyond[0] = -1.0  # an unbalance below zero, which the schema refuses
    assert Foreseen().find(binding, beyond, frozenset({binding.goal.quantity})) is None
    with pytest.raises(NumericalFailure):
        binding.evaluate(beyond)


# ----------------------------------------------------------------------------
# Keys that the case leaves out.
# ----------------------------------------------------------------------------

MISFIRE, TORQUE = "response.torsion.misfire[0]", "response/torsion/torque_half_range"
LINE = ("reference=[]", "reference_table=[]", "limit=[]")
LOSS, FORCE = "machine.mounts.each.loss_factor", "isolation/support_force/steady_peak"
DAMPING = "machine.mounts.each.damping"
BOUNDS = "min = 0.01, max = 0.3"


def test_a_misfire_in_a_sweep_is_that_of_single_runs() -> None:
    """Neither the list nor its entry is in the case."""
    asked = sweep_settings([f"{MISFIRE}=1,4"], (), None, (TORQUE,))
    without = ("response.torsion.speeds",)
    (loaded,) = load_checked([CASES["engine_damped"]], (*LINE, *asked), without)
    assert loaded.case.sweep is not None
    design = make_design(loaded.case.sweep, loaded.resolved)
    block = Evaluator(loaded, design, (TORQUE,))(np.arange(2))
    assert not block.status.any(), block.message
    alone = []
    for name in ("1", "4"):
        settings = (*LINE, f'response.torsion.misfire=["{name}"]')
        (single,) = load_checked([CASES["engine_damped"]], settings, without)
        alone.append(run_case(single.case, wanted=frozenset({TORQUE}))[TORQUE].values)
    assert np.array_equal(quantities(block)[TORQUE].values, alone)
    assert not np.array_equal(*alone)


def test_the_optimiser_starts_in_the_middle_of_the_bounds() -> None:
    study = (
        f'optimisation={{objective={{quantity="{FORCE}"}}, variables=[{{key="{LOSS}", {BOUNDS}}}]}}'
    )
    (loaded,) = load_checked([CASES["generator"]], ("reference=[]", "limit=[]", study), (DAMPING,))
    binding = Binding(loaded)
    assert binding.first == pytest.approx([0.155])
    value, _ = binding.worst(np.array([0.1]))
    (single,) = load_checked([CASES["generator"]], (f"{LOSS}=0.1",), (DAMPING,))
    assert value == run_case(single.case)[FORCE].values.max()


def test_a_search_along_a_key_that_is_left_out() -> None:
    """The loss factor that lets through a force between those of its bounds."""

    def force(loss: float) -> float:
        (loaded,) = load_checked([CASES["generator"]], (f"{LOSS}={loss}",), (DAMPING,))
        return float(run_case(loaded.case, wanted=frozenset({FORCE}))[FORCE].values.max())

    wanted = force(0.12)
    search = f'find=[{{name="loss", key="{LOSS}", {BOUNDS}, quantity="{FORCE}", target={wanted}}}]'
    settings = ("reference=[]", "limit=[]", search)
    (loaded,) = load_checked([CASES["generator"]], settings, (DAMPING,))
    record = execute(loaded).record
    assert float(record["find/loss/value"].values) == pytest.approx(0.12, rel=1e-6)
    assert "find/loss/written" not in record and "find/loss/ratio" not in record


def test_a_key_taken_out_has_its_default_again() -> None:
    settings = ("isolation.gravity=3.0", "reference=[]", "limit=[]")
    plain, without = (
        load_checked([CASES["generator"]], settings, unset)[0]
        for unset in ((), ("isolation.run_up", DAMPING))
    )
    assert plain.case.isolation is not None and plain.case.isolation.run_up is not None
    assert without.case.isolation is not None and without.case.isolation.run_up is None
    assert number_at(without.resolved, "isolation.gravity", 0.0) == 3.0
    assert number_at(without.resolved, DAMPING, 7.0) in (0.0, 7.0)
    with pytest.raises(CaseError, match="no stiffness"):
        load_checked([CASES["generator"]], (), ("machine.mounts.each.stiffness",))
