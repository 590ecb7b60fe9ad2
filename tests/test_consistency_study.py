"""Claim: a study starts from the case as written, shows it next to the optimum, and outlives it."""

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


@pytest.mark.long
def test_a_start_without_a_result_is_said_and_the_search_goes_on(tmp_path: Path) -> None:
    text = (CASES / "generator_mount_design.toml").read_text(encoding="utf-8")
    frequency = (12 * 4 * 0.4**2 * 10000 / (100 * (0.35**2 + 0.8**2))) ** 0.5
    for old, new in (
        ('speed = "4900 rpm"', f"speed = {frequency!r}"),
        (', damping = "50 N*s/m"', ', damping = "0 N*s/m"'),
        ("run_up = {", "# run_up = {"),
        ("[[limit]]", "[[spare]]"),
    ):
        assert old in text
        text = text.replace(old, new, 1)
    path = tmp_path / "singular_start.toml"
    path.write_text(text.split("[[spare]]")[0], encoding="utf-8")
    result = execute(load_checked([path], ["optimisation.starts=1"])[0])
    said = [text for text in result.record.warnings if "optimisation/start is left out" in text]
    assert len(said) == 1
    assert "undamped natural frequency" in said[0]
    assert not [name for name in result.record if name.startswith("optimisation/start/")]
    assert result.record["isolation/support_displacement/total"].values.min() > 0.0


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
