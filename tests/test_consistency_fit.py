"""Claim: a fit finds least squares, its covariance is theirs, and it says what points do not tell.

Closed forms: linear regression, the pitch mode on four mounts. Else Monte Carlo.
"""

from pathlib import Path

import numpy as np
import pytest
from fit_cases import CASE, POINTS, TRUTH, measured, text_with
from refused import refused

from vibecalc.core.report.fit_pictures import draw_fit
from vibecalc.core.report.text import render_report
from vibecalc.core.results.record import Result
from vibecalc.core.results.store import read_result
from vibecalc.core.study.execute import execute, load_checked
from vibecalc.core.study.measured_points import measured_points
from vibecalc.core.study.search.least_squares import LeastSquares
from vibecalc.core.study.search.problem import spread
from vibecalc.errors import NumericalFailure

TINY = 1e-15


def test_linear_least_squares_are_those_of_the_normal_equations() -> None:
    rng = np.random.default_rng(1)
    t = np.linspace(0.0, 3.0, 25)
    rows, uncertainty = np.stack([np.ones(25), t, t**2], axis=1), np.linspace(0.1, 0.3, 25)
    read = rows @ [1.0, 2.0, -0.5] + uncertainty * rng.standard_normal(25)
    found = LeastSquares(
        lambda x: ((rows @ x - read) / uncertainty, np.full(25, TINY)),
        np.array([0.0, 0.0, -2.0]), np.array([3.0, 5.0, 2.0]), np.array([2.0, 2.0, 1.0]),
        spread(2, 3),
    )  # fmt: skip
    weighed = rows / uncertainty[:, None]
    expected = np.linalg.solve(weighed.T @ weighed, weighed.T @ (read / uncertainty))
    assert np.all(np.abs(found.variables - expected) <= 1e-12)
    covariance = found.covariance * np.outer(found.widths, found.widths)
    assert covariance == pytest.approx(np.linalg.inv(weighed.T @ weighed), rel=1e-9)
    assert found.told.all()
    assert found.felt.all()
    rest = (rows @ expected - read) / uncertainty
    assert found.chi_square == pytest.approx(rest @ rest, rel=1e-12)
    assert list(found.searches) == pytest.approx([rest @ rest] * 3, rel=1e-9)


def test_what_points_do_not_tell_is_named() -> None:
    found = LeastSquares(  # a natural frequency tells the ratio, and nothing of a third key
        lambda x: ((np.sqrt(x[0] / x[1]) - np.array([40.0, 40.2, 40.1])) / 0.1, np.full(3, TINY)),
        np.array([1e4, 10.0, 1.0]), np.array([1e6, 300.0, 3e3]), np.array([3e5, 100.0, 100.0]),
        spread(2, 3),
    )  # fmt: skip
    assert found.felt.tolist() == [True, True, False]
    assert found.variables[2] == pytest.approx(100.0, rel=1e-12)  # as written
    assert found.told.tolist() == [True, False, False]
    assert np.isinf(np.diag(found.covariance)).all()
    stiffness, mass = (found.combinations[0] / found.widths * found.variables)[:2]
    assert stiffness == pytest.approx(-mass, rel=1e-5)  # k up and m down
    # of the combination it tells: u(k/m) by hand, in ways between bounds
    ratio = found.variables[0] / found.variables[1]
    slope = 0.5 * np.sqrt(ratio) * np.hypot(*(found.widths / found.variables)[:2])
    assert found.deviations[0] == pytest.approx(0.1 / slope / np.sqrt(3.0), rel=1e-5)


def test_a_key_that_would_go_beyond_its_bound_is_on_it() -> None:
    found = LeastSquares(
        lambda x: (np.array([x[0] - 2.0, x[1] - 0.5, x[0] + x[1] - 1.0]), np.full(3, TINY)),
        np.zeros(2), np.ones(2), np.array([0.5, 0.5]), spread(1, 2),
    )  # fmt: skip
    assert found.variables == pytest.approx([1.0, 0.25], abs=1e-12)
    assert found.active.tolist() == [1.0, 0.0]
    with pytest.raises(NumericalFailure, match="none of 2 searches"):
        LeastSquares(_none, np.zeros(1), np.ones(1), np.ones(1), spread(1, 1))


def _none(variables: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    raise NumericalFailure("no steady state")


# ----------------------------------------------------------------------------
# From a case to its result.
# ----------------------------------------------------------------------------


def shipped() -> Result:
    return read_result(Path(__file__).with_name("golden") / "generator_mount_fit.h5")


def test_the_shipped_case_finds_the_truth_behind_its_noise() -> None:
    (loaded,) = load_checked([CASE])
    told = [float(str(one.value).split()[0]) for one in loaded.case.reference]
    assert told == measured()
    record = shipped().record
    for key, truth in TRUTH.items():
        value, error = record[f"fit/value/{key}"], record[f"fit/standard_error/{key}"]
        assert abs(float(value.values) - truth) <= 2.5 * float(error.values)
        assert float(error.values) < 0.03 * truth
    assert int(record["fit/degrees_of_freedom"].values) == len(POINTS) - len(TRUTH)
    # the case as fitted is the case that the stages hold
    pitch = record["isolation/pitch/natural_frequency"]
    assert float(pitch.values) == float(
        record["fit/computed/isolation/pitch/natural_frequency"].values[0]
    )
    text = render_report(shipped(), full=True)
    assert "machine.mounts.each.stiffness" in text
    assert "--unset fit" in text
    assert draw_fit(shipped()) is not None


#: of four mounts at +-.4 m along x, pitch: I w^2 = 4 k (.4 m)^2
ONE = """
[fit]
variables = [
  { key = "machine.mounts.each.stiffness", min = "20 N/mm", max = "500 N/mm" }, OTHER
]
starts = 0
[[reference]]
quantity = "isolation/pitch/natural_frequency"
value = "15.0 Hz"
uncertainty = "2 %"
source = "bump test"
kind = "measured"
[[reference]]
quantity = "isolation/pitch/natural_frequency"
value = "15.2 Hz"
source = "another"
kind = "measured"
"""


def case_of(folder: Path, other: str = "") -> Path:
    text = CASE.read_text(encoding="utf-8")
    path = folder / "one.toml"
    text = text[: text.index("[fit]")].replace('run_up = { from = "500 rpm", to = "1500 rpm" }', "")
    path.write_text(text + ONE.replace("OTHER", other), encoding="utf-8")
    return path


def test_a_natural_frequency_gives_the_stiffness_by_hand(tmp_path: Path) -> None:
    record = execute(load_checked([case_of(tmp_path)])[0]).record
    off = np.array([0.02 * 15.0, 0.05 / np.sqrt(3.0)])  # of the second its last digit
    weights = off**-2.0
    mean = float(np.sum(weights * [15.0, 15.2]) / np.sum(weights))
    stiffness = 6.35 * (2.0 * np.pi * mean) ** 2 / (4.0 * 0.4**2)
    found, error = (
        float(record[f"fit/{name}/machine.mounts.each.stiffness"].values)
        for name in ("value", "standard_error")
    )
    assert found == pytest.approx(stiffness, rel=1e-9)
    assert error == pytest.approx(2.0 * stiffness / mean / np.sqrt(np.sum(weights)), rel=1e-6)
    chi = float(np.sum(weights * (np.array([15.0, 15.2]) - mean) ** 2))
    assert float(record["fit/chi_square"].values) == pytest.approx(chi, rel=1e-8)
    # one degree of freedom: the probability is that of a normal deviate of both signs
    from math import erfc, sqrt

    assert float(record["fit/probability"].values) == pytest.approx(erfc(sqrt(chi / 2)), rel=1e-7)


def test_stiffness_and_inertia_are_not_told_apart_by_frequencies(tmp_path: Path) -> None:
    inertia = '{ key = "machine.body.inertia[1]", min = 4.5, max = 10.0 }'
    record = execute(load_checked([case_of(tmp_path, inertia)])[0]).record
    assert any(
        "cannot separate machine.mounts.each.stiffness and machine.body.inertia[1]" in one
        and "+1 % of stiffness with +1 % of inertia[1]" in one
        for one in record.warnings
    )
    assert np.isinf(record["fit/standard_error/machine.body.inertia[1]"].values)


@pytest.mark.long
def test_scatter_of_noisy_sets_is_the_stated_uncertainty(tmp_path: Path) -> None:
    text = CASE.read_text(encoding="utf-8").replace("starts = 1", "starts = 0")
    found, errors, chi = [], [], []
    for seed in range(30):
        path = tmp_path / "noisy.toml"
        path.write_text(text_with(text, measured(seed)), encoding="utf-8")
        record = execute(load_checked([path])[0]).record
        found.append([float(record[f"fit/value/{key}"].values) for key in TRUTH])
        growth = float(record["fit/growth"].values)
        errors.append([float(record[f"fit/standard_error/{key}"].values) / growth for key in TRUTH])
        chi.append(float(record["fit/chi_square"].values))
    ratio = np.std(found, axis=0, ddof=1) / np.mean(errors, axis=0)
    assert np.all((ratio > 0.7) & (ratio < 1.35))
    mean = np.mean(found, axis=0) - np.array([*TRUTH.values()])
    assert np.all(np.abs(mean) < 4.0 * np.mean(errors, axis=0) / np.sqrt(30.0))
    assert np.mean(chi) == pytest.approx(len(POINTS) - len(TRUTH), abs=2.5)


def test_uncertainties_stand_in_the_file_of_the_values(tmp_path: Path) -> None:
    (tmp_path / "force.csv").write_text(
        "speed, force [N], scatter [N], share [%]\n600 rpm, 66, 1.5, 2\n700 rpm, 106, 2.5, 3\n"
    )
    text = CASE.read_text(encoding="utf-8")
    table = '[[reference_table]]\nquantity = "isolation/support_force/run_up"\naxis = "speed"\n'
    table += 'where = { mount = "1" }\nfile = "force.csv"\ncolumn = "force"\nsource = "b"\n'
    path = tmp_path / "case.toml"
    for column, expected in (("scatter", [1.5, 2.5]), ("share", [1.32, 3.18])):
        path.write_text(f'{text}\n{table}kind = "measured"\nuncertainty_column = "{column}"\n')
        points = measured_points(load_checked([path])[0].case)[-2:]
        assert [point.uncertainty for point in points] == pytest.approx(expected, rel=1e-12)
    path.write_text(f'{text}\n{table}uncertainty_column = "scater"\n')
    assert "did you mean 'scatter'" in refused(path)
