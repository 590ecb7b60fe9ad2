"""Claim: mean and deviation over tolerances are those of the machines within them, and the optimum
is that of mean plus deviations; slopes, deviations and a front are those of the changed cases.
"""

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from shipped_cases import CASES
from stock_cases import BASE, ROBUST
from test_consistency_choices import run

from vibecalc.core.case.load import load_case, validate
from vibecalc.core.case.raw import case_at
from vibecalc.core.report.text import render_report
from vibecalc.core.results.record import Result
from vibecalc.core.results.store import read_result
from vibecalc.core.run.run import run_case
from vibecalc.core.study import scatter as scatter_module
from vibecalc.core.study.binding import Binding
from vibecalc.core.study.execute import execute, load_checked
from vibecalc.core.study.scatter import scatter_of
from vibecalc.errors import CaseError, NumericalFailure

GOLDEN = Path(__file__).resolve().parent / "golden"
GRAVITY, MASS = 9.80665, 120.0
MASS_BY = '{ key = "machine.body.mass", half_width = "10 %" }'
SAG = '[[limit]]\nquantity = "isolation/support_displacement/static"\nmax = "3 mm"\n'
STIFFNESS = "machine.mounts.each.stiffness"


def text(quantity: str, tolerances: str, limit: str = "") -> str:
    asked = ROBUST.replace("QUANTITY", quantity).replace("TOLERANCES", tolerances)
    return BASE + asked + limit


def written(folder: Path, content: str) -> Binding:
    path = folder / "case.toml"
    path.write_text(content, encoding="utf-8")
    return Binding(load_checked([path])[0])


def test_a_limit_that_is_linear_in_what_scatters(tmp_path: Path) -> None:
    """Sag M g / (4 k), M evenly within 10 %: k = M g (1 + 2 s) / (4 L), s near 0.1 / sqrt 3."""
    content = text("isolation/pitch/stiffness", MASS_BY, SAG)
    result = run(tmp_path, content)
    steps = scatter_of(load_checked([tmp_path / "case.toml"])[0].case.optimisation.robust).steps
    scatter, middle = float(np.std(steps, ddof=1)), float(np.mean(steps))
    assert abs(middle) < 2e-4 and scatter == pytest.approx(0.1 / np.sqrt(3.0), rel=0.02)
    share = 1.0 + middle + 2.0 * scatter
    stiffness = float(result.record[f"optimisation/variable/{STIFFNESS}"].values)
    assert stiffness == pytest.approx(MASS * GRAVITY * share / (4.0 * 3e-3), rel=1e-9)
    left = {
        name: float(result.record[f"optimisation/robust/margin_{name}"].values[0])
        for name in ("nominal", "mean", "deviation")
    }
    assert left["nominal"] == pytest.approx(1.0 - 1.0 / share, rel=1e-9)
    assert left["mean"] - 2.0 * left["deviation"] == pytest.approx(0.0, abs=1e-9)
    said = render_report(result)
    assert "machine.body.mass uniform within +-10 %. 64 samples" in said
    assert "mean and 2 deviations" in said


def test_a_quantity_that_is_quadratic_in_what_scatters(tmp_path: Path) -> None:
    """k (x1^2 + ...): with a deviation d of one x the mean rises by k d^2, the variance is
    k^2 (4 x^2 d^2 + 2 d^4); both known within a few of their standard errors.
    """
    by = '{ key = "machine.mounts.positions[2][0]", deviation = "40 mm" }'
    content = text("isolation/pitch/stiffness", by).replace(
        "tolerances", "samples = 256\ntolerances"
    )
    record = run(tmp_path, content, "isolation.lever=0.8").record
    x, d = 0.4, 0.04
    for place, k in ((0, 100e3), (1, 50e3)):
        exact = k * (4.0 * x * x + d * d), k * np.sqrt(4.0 * x * x * d * d + 2.0 * d**4)
        for name, wanted in zip(("mean", "deviation"), exact, strict=True):
            value = record[f"optimisation/robust/{name}"].values[place]
            error = record[f"optimisation/robust/{name}_error"].values[place]
            assert abs(value - wanted) < 4.0 * error < 0.05 * wanted
        assert record["optimisation/robust/nominal"].values[place] == pytest.approx(k * 4 * x * x)


def test_machines_at_once_and_one_by_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Arrays, single runs, and the cases of the machines each written down give the same."""
    by = f'{{ key = "{STIFFNESS}", half_width = "15 %" }}, {MASS_BY}'
    content = text("isolation/support_force/steady_peak", by, SAG)
    binding = written(tmp_path, content.replace("tolerances", "samples = 8\ntolerances"))
    place = np.array([120e3])
    once = binding.worst(place)
    monkeypatch.setattr(scatter_module, "by_arrays", lambda *_: False)
    single = binding.worst(place)
    assert once[0] == pytest.approx(single[0], rel=1e-12)
    assert once[1] == pytest.approx(single[1], abs=1e-12)
    steps = binding.scatter.steps
    forces = []
    for step in steps:
        settings = {STIFFNESS: 120e3 * (1.0 + step[0]), "machine.body.mass": MASS * (1.0 + step[1])}
        record = run_case(validate(case_at(binding._resolved, settings)))
        forces.append(np.max(record["isolation/support_force/steady_peak"].values))
    assert once[0] == pytest.approx(np.mean(forces) + 2.0 * np.std(forces, ddof=1), rel=1e-12)


def test_a_machine_without_a_result_says_so(tmp_path: Path) -> None:
    by = f'{{ key = "{STIFFNESS}", deviation = "90 %" }}'
    with pytest.raises(NumericalFailure, match="a machine within the tolerances"):
        written(tmp_path, text("isolation/pitch/stiffness", by)).evaluate(np.array([1e5]))


def test_the_shipped_stock() -> None:
    """Mean less two deviations of sqrt(4 k x^2 / I) / (2 pi) is 9 Hz at the distance found."""
    record = read_result(GOLDEN / "generator_mount_stock.h5").record
    robust = load_case(CASES["generator_mount_stock"]).case.optimisation.robust
    stiffness = 60e3 * (1.0 + scatter_of(robust).steps[:, 0])
    roots = np.sqrt(4.0 * stiffness / (100.0 * (0.8**2 + 0.35**2) / 12.0)) / (2.0 * np.pi)
    x = 9.0 / (np.mean(roots) - 2.0 * np.std(roots, ddof=1))
    assert float(record["optimisation/choice/mount"].values) == 3.0
    found = record["optimisation/variable/machine.mounts.positions[2][0]"]
    assert float(found.values) == pytest.approx(x, rel=1e-8)


#: an absorber whose spring and damper are sought for the least of its two peaks
ABSORBER = """schema = 1
title = "absorber"
[machine]
kind = "absorber"
primary = { damping_ratio = 0.01 }
secondary = { mass_ratio = 0.05, stiffness_ratio = 0.04, damping_over_primary_critical = 0.02 }
[response.absorber]
[optimisation]
objective = { quantity = "response/absorber/largest" }
starts = 2
variables = [
  { key = "machine.secondary.stiffness_ratio", min = 0.02, max = 0.1 },
  { key = "machine.secondary.damping_over_primary_critical", min = 1e-3, max = 0.2 },
]
"""
SCATTERED = """[optimisation.robust]
tolerances = [
  { key = "machine.primary.damping_ratio", deviation = "3 %" },
  { key = "machine.secondary.damping_over_primary_critical", half_width = "20 %" },
]
sigmas = 2
samples = 16
"""


def test_machines_of_several_candidates_at_once_are_those_of_each_alone(tmp_path: Path) -> None:
    binding = written(tmp_path, ABSORBER + SCATTERED)
    points = binding.lower + (binding.upper - binding.lower) * np.array([[0.1, 0.6], [0.5, 0.4]])
    wanted = frozenset({"response/absorber/largest"})
    binding.ahead(points)
    for point in points:
        alone = binding.machines_at(point, binding.scatter, wanted)
        parts, _, errors = binding.evaluate(point)
        middle, apart, _ = alone.moments("response/absorber/largest", {}, "max")
        assert parts[0] == pytest.approx(middle + 2.0 * apart, rel=1e-14) and errors[0] < 1e-9


def test_the_least_of_two_peaks_is_the_tuning_in_closed_form(tmp_path: Path) -> None:
    """Each peak is smooth where they are alike: few points, and the last digits."""
    found = run(tmp_path, ABSORBER).record
    data = tomllib.loads(ABSORBER.split("[optimisation]")[0]) | {"tuning": {"kind": "free"}}
    del (
        data["machine"]["secondary"]["stiffness_ratio"],
        data["machine"]["secondary"]["damping_over_primary_critical"],
    )
    tuned = run_case(validate(data))
    objective, peak = found["optimisation/objective"], tuned["tuning/peak"]
    assert float(objective.values) == pytest.approx(float(peak.values), rel=1e-12)
    assert float(objective.error_estimate) < 1e-10
    for name in ("stiffness_ratio", "damping_over_primary_critical"):
        sought = found[f"optimisation/variable/machine.secondary.{name}"]
        there = float(tuned[f"tuning/{name}"].values)
        assert abs(float(sought.values) - there) <= 2.0 * sought.error_estimate + 1e-12
    assert int(found["optimisation/evaluations"].values) < 500


# ----------------------------------------------------------------------------
# Slopes, deviations and a front are those of the changed cases.
# ----------------------------------------------------------------------------

CASE = CASES["generator_mount_design"]
ROOT = "optimisation"
DAMPING = "machine.mounts.each.damping"
ASKED = """
starts = 1
sensitivity = "both"
second_objective = { quantity = "isolation/support_force/steady_peak" }
front_points = 3
"""


def mount_design(folder: Path, extra: str) -> Path:
    """The mount design without its run-up, two variables only, and what else is asked for."""
    text = CASE.read_text(encoding="utf-8").split("[[limit]]")[0]
    kept = [line for line in text.split("\n") if "run_up" not in line and "block.mass" not in line]
    limit = '\n[[limit]]\nquantity = "isolation/support_force/steady_peak"\nmax = "100 N"\n'
    path = folder / "study.toml"
    path.write_text("\n".join(kept) + extra + limit, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Result:
    return execute(load_checked([mount_design(tmp_path_factory.mktemp("study"), ASKED)])[0])


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
    text = mount_design(tmp_path, "").read_text(encoding="utf-8")
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
        load_checked([mount_design(tmp_path, extra)])
    assert words in str(caught.value)
