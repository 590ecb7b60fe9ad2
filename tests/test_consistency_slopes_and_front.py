"""Claim: a case that asks for slopes, deviations and a front gets those of the changed cases."""

import re
from pathlib import Path

import numpy as np
import pytest

from vibecalc.core.results.record import Result
from vibecalc.core.study.execute import execute, load_checked
from vibecalc.errors import CaseError

CASE = Path(__file__).resolve().parents[1] / "cases" / "generator_mount_design.toml"
ROOT = "optimisation"
STIFFNESS = "machine.mounts.each.stiffness"
DAMPING = "machine.mounts.each.damping"
ASKED = """
starts = 1
sensitivity = "both"
second_objective = { quantity = "isolation/support_force/steady_peak" }
front_points = 3
"""


def written(folder: Path, extra: str) -> Path:
    """The mount design without its run-up, two variables only, and what else is asked for."""
    text = CASE.read_text(encoding="utf-8").split("[[limit]]")[0]
    kept = [line for line in text.split("\n") if "run_up" not in line and "block.mass" not in line]
    limit = '\n[[limit]]\nquantity = "isolation/support_force/steady_peak"\nmax = "100 N"\n'
    path = folder / "study.toml"
    path.write_text("\n".join(kept) + extra + limit, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Result:
    return execute(load_checked([written(tmp_path_factory.mktemp("study"), ASKED)])[0])


def test_slopes_are_those_of_the_case(study: Result) -> None:
    """The sag is M g / (4 k): far above resonance it is nearly all of the objective."""
    slope = study.record[f"{ROOT}/sensitivity/{STIFFNESS}"]
    assert list(slope.axes[0].values) == ["start", "optimum"]
    assert slope.unit == "m/(N/m)"
    assert slope.values[0] == pytest.approx(-100 * 9.81 / (4 * 1e4**2), rel=2e-3)
    gain = float(study.record[f"{ROOT}/gain"].values)
    start = float(np.max(study.record[f"{ROOT}/start/isolation/support_displacement/total"].values))
    assert gain == pytest.approx(start - float(study.record[f"{ROOT}/objective"].values), rel=1e-12)


def test_deviation_is_a_run_of_the_changed_case(study: Result, tmp_path: Path) -> None:
    record = study.record
    size = float(record[f"{ROOT}/deviation/size/{STIFFNESS}"].values)
    assert abs(size) == pytest.approx(0.01 * (500e3 - 2e3))
    optimum = {key: float(record[f"{ROOT}/variable/{key}"].values) for key in (STIFFNESS, DAMPING)}
    settings = [f"{STIFFNESS}={optimum[STIFFNESS] + size!r}", f"{DAMPING}={optimum[DAMPING]!r}"]
    text = written(tmp_path, "").read_text(encoding="utf-8")
    alone = re.sub(r"\[optimisation\].*?\n(?=\n\[\[limit)", "", text, flags=re.DOTALL)
    (tmp_path / "alone.toml").write_text(alone, encoding="utf-8")
    moved = execute(load_checked([tmp_path / "alone.toml"], settings)[0]).record
    there = float(np.max(moved["isolation/support_displacement/total"].values))
    loss = record[f"{ROOT}/deviation/loss/{STIFFNESS}"]
    here = float(record[f"{ROOT}/objective"].values)
    assert abs(float(loss.values) - (there - here)) <= loss.error_estimate + 1e-15


def test_front_begins_at_the_optimum(study: Result) -> None:
    record = study.record
    first, second = (
        record[f"{ROOT}/front/{name}"].values for name in ("objective", "second_objective")
    )
    assert first.size == 3
    assert first[0] == pytest.approx(float(record[f"{ROOT}/objective"].values), rel=1e-9)
    assert second[0] == pytest.approx(100.0, rel=1e-9)
    assert np.all(np.diff(first) > 0) and np.all(np.diff(second) < 0)
    assert record[f"{ROOT}/front/variable/{STIFFNESS}"].values[0] == pytest.approx(
        float(record[f"{ROOT}/variable/{STIFFNESS}"].values), rel=1e-6
    )


@pytest.mark.parametrize(
    ("extra", "words"),
    [
        ("front_points = 5\n", "a front needs a second objective"),
        (
            'second_objective = { quantity = "isolation/support_displacement/total" }\n',
            "the same as the first",
        ),
        ('second_objective = { quantity = "isolation/nothing" }\n', "isolation/nothing"),
        (
            'second_objective = { quantity = "isolation/pitch/inertia", where = { order = 1 } }\n',
            "has no axis 'order'",
        ),
        ('compare = ["nelder_mead"]\n', "leave out method and compare"),
        ('method = "hooke_jeeves"\n', "leave out method and compare"),
        ('sensitivity = "everywhere"\n', "everywhere"),
    ],
)
def test_what_cannot_be_meant_is_said(tmp_path: Path, extra: str, words: str) -> None:
    with pytest.raises(CaseError) as caught:
        load_checked([written(tmp_path, extra)])
    assert words in str(caught.value)
