"""Claim: what nothing holds is free, however tiny the stiffness that rounding makes of it."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from random_machines import Table
from refused import problems_of
from response_machines import run

from vibecalc.cli.starters import starter
from vibecalc.core.report.text import render_report
from vibecalc.core.study.execute import execute, load_checked

CASES = Path(__file__).resolve().parents[1] / "cases"
HARD = "60 N/mm"


def on_mounts(scene: str, *stiffness: object) -> Table:
    table = tomllib.loads(starter(scene))
    table["machine"]["mounts"]["each"]["stiffness"] = list(stiffness)
    return table


@pytest.mark.parametrize(("free", "none"), [(1, 0.0), (3, 1e-14)])
def test_a_direction_without_stiffness_is_a_free_mode(free: int, none: float) -> None:
    # held along x alone it also turns about x as it likes
    stiffness = (HARD, none, HARD if free == 1 else none)
    record = run(on_mounts("compressor", *stiffness))
    natural = record["response/modes/natural_frequency"]
    loose = natural.values <= natural.error_estimate
    assert np.flatnonzero(loose).tolist() == list(range(free))
    assert np.all(natural.values[~loose] > 10.0)
    assert natural.error_estimate < 1e-6
    assert "response/modes/damping_ratio" not in record
    assert "response/modes/distance" not in record
    assert not any("natural_frequency" in words for words in record.warnings)


@pytest.mark.parametrize("soft", ["1 N/m", "60 N/mm"])
def test_a_soft_mode_is_held_and_keeps_its_digits(soft: str) -> None:
    table = on_mounts("compressor", HARD, soft, HARD)
    record = run(table)
    natural = record["response/modes/natural_frequency"]
    assert np.all(natural.values > 1e6 * natural.error_estimate)
    assert "response/modes/damping_ratio" in record


def test_a_change_of_a_body_that_is_free_is_refused_in_these_words() -> None:
    (problem,) = problems_of(on_mounts("switching", HARD, 0.0, HARD))
    assert problem.message.startswith("a change between operations needs a body that its mounts")
    assert problem.found == "nothing resists moving along y"


def test_a_run_up_through_an_undamped_resonance_has_no_largest_energy(tmp_path: Path) -> None:
    path = tmp_path / "undamped.toml"
    text = (CASES / "compressor_a.toml").read_text(encoding="utf-8").split("[[reference")[0]
    path.write_text(text, encoding="utf-8")
    asked = "response.run_up={from=20.0, to=40.0}"
    (loaded,) = load_checked([path], [asked])
    words = " ".join(render_report(execute(loaded), full=True).split())
    assert "kinetic, mean over a turn unbounded" in words
    assert "speeds left out: an order on an undamped natural frequency" in words
