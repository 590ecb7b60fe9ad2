"""Claim: a case that asks for methods, slopes and a front gets them as results and in words."""

import re
from pathlib import Path

import numpy as np
import pytest

from vibecalc.core.report.text import render_report
from vibecalc.core.results.record import Result
from vibecalc.core.study.execute import execute, load_checked
from vibecalc.core.study.planned import optimisation_entries
from vibecalc.errors import CaseError

CASE = Path(__file__).resolve().parents[1] / "cases" / "generator_mount_design.toml"
ROOT = "optimisation"
STIFFNESS = "machine.mounts.each.stiffness"
DAMPING = "machine.mounts.each.damping"
METHODS = ["sequential_quadratic", "hooke_jeeves"]
ASKED = f"""
starts = 1
compare = {METHODS}
sensitivity = "both"
second_objective = {{ quantity = "isolation/support_force/steady_peak" }}
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


def test_every_path_of_the_catalogue_is_there(study: Result, tmp_path: Path) -> None:
    case = load_checked([written(tmp_path, ASKED)])[0].case
    entries = optimisation_entries(case)
    assert {path for path in study.record if path.startswith(ROOT)} == set(entries)
    for path, entry in entries.items():
        quantity = study.record[path]
        assert (quantity.unit, tuple(axis.name for axis in quantity.axes)) == (
            entry.unit,
            entry.axes,
        )
        assert np.all(~np.isnan(quantity.values)) if quantity.values.dtype.kind == "f" else True
        assert np.isfinite(quantity.error_estimate)


def test_methods_end_at_the_optimum_and_cost_what_they_cost(study: Result) -> None:
    record = study.record
    names = record[f"{ROOT}/methods/objective"].axes[0].values
    assert list(names) == METHODS
    best = float(record[f"{ROOT}/objective"].values)
    assert record[f"{ROOT}/methods/objective"].values == pytest.approx(
        np.full(len(METHODS), best), rel=1e-5
    )
    assert np.all(np.abs(record[f"{ROOT}/methods/shortfall"].values) <= 1e-5 * best)
    assert np.all(record[f"{ROOT}/methods/distance"].values < 1e-3)
    evaluations = record[f"{ROOT}/methods/evaluations"].values
    assert evaluations[1] > 2 * evaluations[0]
    assert list(record[f"{ROOT}/methods/converged"].values) == [1] * len(METHODS)


def test_slopes_are_those_of_the_case(study: Result) -> None:
    """The sag is M g / (4 k): far above resonance it is nearly all of the objective."""
    slope = study.record[f"{ROOT}/sensitivity/{STIFFNESS}"]
    assert list(slope.axes[0].values) == ["start", "optimum"]
    assert slope.unit == "m/(N/m)"
    assert slope.values[0] == pytest.approx(-100 * 9.81 / (4 * 1e4**2), rel=2e-3)
    gain = float(study.record[f"{ROOT}/gain"].values)
    start = float(
        np.max(study.record[f"{ROOT}/start/isolation/support_displacement/excursion"].values)
    )
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
    there = float(np.max(moved["isolation/support_displacement/excursion"].values))
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


def test_the_report_says_it_in_words_and_tables(study: Result) -> None:
    text = render_report(study, full=True)
    assert max(map(len, text.splitlines())) <= 100
    for words in ("methods side by side", "front: the best objective for each", "advice:"):
        assert words in text
    value = float(study.record[f"{ROOT}/variable/{STIFFNESS}"].values)
    joined = re.sub(r"\s+", " ", text)
    assert f"{STIFFNESS}: raise it from 10.00 to {value / 1e3:.1f} kN/m" in joined
    assert "together: the objective becomes lower by" in joined
    assert "hooke_jeeves" in text.split("methods side by side")[1].split("optimum")[0]


@pytest.mark.long
@pytest.mark.parametrize("method", ["hooke_jeeves", "nelder_mead"])
def test_another_method_comes_to_the_same_optimum(
    study: Result, tmp_path: Path, method: str
) -> None:
    path = written(tmp_path, f'starts = 1\nmethod = "{method}"\n')
    record = execute(load_checked([path])[0]).record
    for name in (f"variable/{STIFFNESS}", f"variable/{DAMPING}", "objective"):
        one, two = record[f"{ROOT}/{name}"], study.record[f"{ROOT}/{name}"]
        assert abs(float(one.values - two.values)) <= one.error_estimate + two.error_estimate
    assert not [name for name in record if "methods/" in name or "sensitivity/" in name]
    assert any(method.split("_")[0] in one.name.lower() for one in record.methods)


@pytest.mark.parametrize(
    ("extra", "words"),
    [
        ("front_points = 5\n", "a front needs a second objective"),
        (
            'second_objective = { quantity = "isolation/support_displacement/excursion" }\n',
            "the same as the first",
        ),
        ('second_objective = { quantity = "isolation/nothing" }\n', "isolation/nothing"),
        (
            'second_objective = { quantity = "isolation/pitch/inertia", where = { order = 1 } }\n',
            "has no axis 'order'",
        ),
        ('compare = ["hooke_jeeves", "hooke_jeeves"]\n', "hooke_jeeves is compared twice"),
        ('compare = ["simplex"]\n', "simplex"),
        ('method = "annealing"\n', "annealing"),
        ('sensitivity = "everywhere"\n', "everywhere"),
    ],
)
def test_what_cannot_be_meant_is_said(tmp_path: Path, extra: str, words: str) -> None:
    with pytest.raises(CaseError) as caught:
        load_checked([written(tmp_path, extra)])
    assert words in str(caught.value)
