"""Claim: a study shows the case as written next to the optimum, and counts what is no machine."""

from pathlib import Path

import pytest

from vibecalc.core.report.text import render_report
from vibecalc.core.results.store import read_result
from vibecalc.core.study.execute import execute, load_checked

CASES = Path(__file__).resolve().parents[1] / "cases"


def test_balance_of_start_and_optimum_stand_in_one_report() -> None:
    result = read_result(CASES.parent / "tests" / "golden" / "four_cylinder.h5")
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
    head = (CASES / "four_cylinder.toml").read_text(encoding="utf-8").split("[optimisation]")[0]
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
