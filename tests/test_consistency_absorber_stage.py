"""Claim: stages of an absorber hand on what the kernels compute, in units, within bounds and stock;
what fails next to a tuning is left out with a warning, and the report calls each thing its name.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from absorber_cases import TUNED
from shipped_cases import CASES, ROOT, result_of

from vibecalc.core.report.text import render_report
from vibecalc.core.results.record import Record, Result
from vibecalc.core.results.store import read_result
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import execute, load_checked
from vibecalc.errors import CaseError, NumericalFailure


def run(name: str, *settings: str, wanted: frozenset[str] | None = None) -> Record:
    (loaded,) = load_checked([CASES[name]], (*settings, "reference=[]", "limit=[]"))
    return run_case(loaded.case, wanted=wanted)


def value(record: Record, path: str) -> Any:
    return record[path].values


def test_the_wanted_spring_and_oil_give_the_tuning() -> None:
    """Bought exactly as said, they are the tuned absorber."""
    record = result_of("absorber_rig_a").record
    rate = float(value(record, "hardware/spring_rate"))
    assert 4.0 * rate * (0.138 * np.cos(np.radians(20.0))) ** 2 == pytest.approx(
        float(value(record, "tuning/torsional_stiffness")), rel=1e-12
    )
    shares = sum(float(value(record, f"hardware/gap/{name}")) for name in ("rim", "sides", "bore"))
    assert shares * float(value(record, "hardware/dynamic_viscosity")) == pytest.approx(
        float(value(record, "tuning/torsional_damping")), rel=1e-12
    )


def test_no_optimum_is_a_failure_and_no_help_a_result() -> None:
    with pytest.raises(NumericalFailure, match="without bound"):
        run("absorber", "tuning.excitation='unbalance'", "tuning.response='acceleration'",
            "tuning.compare=[]", "tuning.mistuning=[]", "tuning.sensitivity=false",
            "machine.primary.damping_ratio=0.1")  # fmt: skip
    (loaded,) = load_checked(
        [CASES["absorber_design_chart"]],
        ("machine.primary.damping_ratio=0.71", "reference=[]", "limit=[]"),
    )
    record = run_case(loaded.case)
    assert value(record, "tuning/helps") == 0
    assert (
        value(record, "tuning/stiffness_ratio")
        == value(record, "tuning/damping_over_primary_critical")
        == 0
    )
    assert any("no absorber helps" in words for words in record.warnings)


#: a machine of 2000 kg on a floor, with bounds
FLOOR = """schema = 1
title = "floor"
[machine]
kind = "absorber"
primary = { mass = "2000 kg", linear_stiffness = "11369 N/mm", damping_ratio = 0.02 }
secondary = { mass_ratio = 0.05 }
springs = { count = 4, rate = "127 N/mm" }
[tuning]
mistuning = ["5 %"]
bounds = { travel = 13.27 }
[response.absorber]
"""


def floor(folder: Path, text: str = FLOOR) -> Result:
    path = folder / "floor.toml"
    path.write_text(text, encoding="utf-8")
    (loaded,) = load_checked([path], ())
    return execute(loaded)


@pytest.mark.long
def test_a_tuning_within_bounds_is_called_so(tmp_path: Path) -> None:
    result = floor(tmp_path)
    assert value(result.record, "tuning/travel") == pytest.approx(13.27, rel=1e-9)
    words = " ".join(render_report(result).split())
    assert "within the bounds: 9.471, without the absorber 25.01" in words
    assert "active bounds: spring travel;" in words
    assert "damper: 5221 N s/m" in words and "peak with exactly these: 9.471" in words
    assert not any("better than none" in warning for warning in result.record.warnings)


def test_masses_nearby_which_no_tuning_is_found_are_refused(tmp_path: Path) -> None:
    for ratio, good in ((1e4, True), (1.1e4, False), (1e6, False)):
        path = tmp_path / "heavy.toml"
        path.write_text(
            'schema = 1\ntitle = "heavy"\n[machine]\nkind = "absorber"\n'
            f"primary = {{ damping_ratio = 0.02 }}\nsecondary = {{ mass_ratio = {ratio} }}\n"
            "[tuning]\n"
        )
        if good:
            (loaded,) = load_checked([path], ())
            assert 1.0 < value(run_case(loaded.case), "tuning/peak") < 1.001
        else:
            with pytest.raises(CaseError, match="no tuning is found"):
                load_checked([path], ())


@pytest.mark.long
def test_bounds_that_leave_no_help_are_said_to(tmp_path: Path) -> None:
    result = floor(tmp_path, FLOOR.replace("13.27", "0.5"))
    record = result.record
    assert value(record, "tuning/helps") == 0
    assert value(record, "tuning/peak") > value(record, "tuning/peak_alone")
    assert any("no absorber within the bounds does better" in w for w in record.warnings)
    assert "No absorber within the bounds reduces" in " ".join(render_report(result).split())


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ("excitation='unbalance', response='velocity', kind='viscous'", "without bound"),
        ("excitation='unbalance', norm='h2'", "no mean square"),
    ],
)
def test_what_has_no_optimum_is_said(settings: str, words: str) -> None:
    with pytest.raises(NumericalFailure, match=words):
        run("absorber", f"tuning={{{settings}}}")


#: of a run of the rig what has no part in what is asked here
SHORT = (
    "tuning.temperatures.points=2",
    "tuning.sensitivity=false",
    "tuning.mistuning=[]",
    "response.absorber.frequencies.points=11",
)


def number(record: Record, path: str) -> float:
    return float(record[path].values)


def test_slopes_of_a_response_without_bound_are_left_out() -> None:
    tuning = "tuning={excitation='base', response='acceleration', norm='h2', sensitivity=true}"
    record = run("absorber", tuning)
    assert "tuning/sensitivity/peak" not in record
    assert any("no slopes" in words for words in record.warnings)


@pytest.mark.long
def test_travel_that_no_stock_keeps_leaves_tuning_and_hardware() -> None:
    record = run("absorber_rig_a", "tuning.bounds={travel=5}", *SHORT)
    (words,) = [words for words in record.warnings if "stock" in words]
    assert "the least travel is 6.71448" in words
    assert "hardware/buy/peak" not in record
    assert number(record, "tuning/travel") == pytest.approx(5.0, rel=1e-9)
    assert number(record, "hardware/built/peak") > number(record, "tuning/peak")


def test_no_stock_is_ranked_by_peaks_for_a_mean_square() -> None:
    record = run("absorber_rig_a", "tuning={norm='h2'}")
    assert "hardware/pair/peak" not in record and "hardware/spring_rate" in record
    assert any("mean square" in words for words in record.warnings)


@pytest.mark.long
def test_an_oil_out_of_its_model_is_left_out() -> None:
    record = run("absorber_rig_a", "machine.gap.temperature='-40 degC'", *SHORT)
    kept = list(record["hardware/oil/damping"].axes[0].values)
    assert "ISO VG 680" not in kept and len(kept) == 6
    assert list(record["hardware/pair/peak"].axes[1].values) == kept
    assert any("'ISO VG 680' in stock is left out" in words for words in record.warnings)


def _text(tmp_path: Path, text: str, *settings: str) -> str:
    path = tmp_path / "case.toml"
    path.write_text(text, encoding="utf-8")
    (loaded,) = load_checked([path], settings)
    return " ".join(render_report(execute(loaded), full=True).split())


def _tuned(tmp_path: Path, table: str, damping: str = "0.02") -> str:
    text = TUNED.replace('compare = ["den_hartog"]', table)
    return _text(tmp_path, text, f"machine.primary.damping_ratio={damping}")


def test_mean_squares_are_not_called_peaks(tmp_path: Path) -> None:
    table = 'norm = "h2"\nmistuning = [0.01]\ncompare = ["warburton", "numerical"]'
    text = _tuned(tmp_path, table)
    assert "increase of the mean square" in text and "increase of the peak" not in text
    assert "true mean square" in text and "above the" not in text
    row = text.split("warburton ")[1].split()
    assert row[2] == "-" and float(row[3]) > 4.0


def test_a_threshold_of_zero_is_no_threshold(tmp_path: Path) -> None:
    text = _tuned(tmp_path, 'excitation = "base"\nresponse = "acceleration"', "0.0")
    assert "With any damping of the primary the response is unbounded." in text
    assert "damping of the primary of 0 on" not in text


def test_a_spring_alone_that_does_not_help(tmp_path: Path) -> None:
    text = _tuned(tmp_path, 'kind = "undamped_spring"')
    assert "No spring without a damper reduces the peak" in text
    assert "force excitation; one with spring and damper does." in text
    assert "No absorber" not in text and "governing peak" not in text


@pytest.mark.long
def test_where_none_helps_nothing_is_bought() -> None:
    text = render_report(
        result_of(
            "absorber_rig_a",
            "machine.primary.damping_ratio=0.9",
            "tuning.temperatures.points=2",
            "response.absorber.frequencies.points=11",
        )
    )
    part = text.split("To order:")[1].split("\n\n")[0]
    assert part.split() == ["-", "nothing:", "no", "absorber", "reduces", "the", "peak."]
    for absent in ("higher peak", "derivative", "above optimum", "antiresonance"):
        assert absent not in text


def test_two_absorbers_above_the_threshold() -> None:
    text = render_report(result_of("absorber_two", "machine.primary.damping_ratio=0.8"))
    assert "None of these absorbers helps" in text
    assert "(factor" not in text and "higher peak" not in text
    assert "None of these absorbers" not in render_report(result_of("absorber_two"))


@pytest.mark.parametrize(
    ("asked", "tuning", "words"),
    [
        ({"unbalance": 0.02}, "force", "displacement for unbalance excitation; displacements / "
         "(unbalance / mass of the primary)"),
        ({"base_displacement": 1e-3}, "force", "displacement for base excitation; displacements / "
         "base motion"),
        ({}, "unbalance", "displacement for unbalance excitation"),
        ({"excitation": "force"}, "unbalance", "displacement for force excitation; displacements / "
         "static displacement of the primary"),
    ],
)  # fmt: skip
def test_curves_name_what_they_are_over(asked: dict[str, Any], tuning: str, words: str) -> None:
    """The amplitude of a case says its excitation where the case does not, then [tuning]."""
    result = read_result(ROOT / "tests" / "golden" / "absorber.h5")
    response = {"absorber": {"excitation": None, **asked}}
    case = {**result.case, "tuning": {"excitation": tuning}, "response": response}
    shown = " ".join(render_report(replace(result, case=case), full=True).split())
    assert words in shown
