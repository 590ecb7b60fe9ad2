"""Claim: what fails next to a tuning is left out with a warning, and hardware keeps bounds."""

import numpy as np
import pytest
from shipped_cases import CASES

from vibecalc.absorber.tuning.minimax import minimax
from vibecalc.core.results.record import Record
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import load_checked
from vibecalc.errors import NumericalFailure


def run(name: str, *settings: str, wanted: frozenset[str] | None = None) -> Record:
    (loaded,) = load_checked([CASES[name]], (*settings, "reference=[]", "limit=[]"))
    return run_case(loaded.case, wanted=wanted)


#: of a run of the rig what has no part in what is asked here
SHORT = (
    "tuning.temperatures.points=2",
    "tuning.sensitivity=false",
    "tuning.mistuning=[]",
    "response.absorber.frequencies.points=11",
)


def number(record: Record, path: str) -> float:
    return float(record[path].values)


@pytest.mark.parametrize(
    "damping",
    [
        pytest.param(0.7071, marks=pytest.mark.long),
        pytest.param(0.707106, marks=pytest.mark.long),
        0.7071067,
    ],
)
def test_a_run_nearby_the_threshold_keeps_its_tuning(damping: float) -> None:
    setting = (
        f"machine.primary.damping_ratio={damping}", "tuning.bounds={travel=11.1}",
        "tuning.compare=[]", "tuning.mistuning=[]", "response.absorber.vary={own_damping=[0.1]}",
    )  # fmt: skip
    record, best = run("absorber", *setting), minimax(damping, 0.1)
    assert number(record, "tuning/stiffness_ratio") == best.stiffness_ratio
    assert number(record, "tuning/certificate") < 1e-7
    # the free optimum keeps the limit of travel
    assert number(record, "tuning/unbounded/stiffness_ratio") == best.stiffness_ratio
    assert number(record, "tuning/bounds/penalty") == 0.0
    assert not np.any(record["tuning/bounds/active"].values)
    assert "tuning/sensitivity/peak" not in record
    assert any(words.startswith("slopes of the tuning left out") for words in record.warnings)
    with pytest.raises(NumericalFailure, match="sensitivity"):
        run("absorber", *setting, wanted=frozenset({"tuning/sensitivity/peak"}))


def test_slopes_of_a_response_without_bound_are_left_out() -> None:
    tuning = "tuning={excitation='base', response='acceleration', norm='h2', sensitivity=true}"
    record = run("absorber", tuning)
    assert "tuning/sensitivity/peak" not in record
    assert any("no slopes" in words for words in record.warnings)


def test_travel_that_no_stock_keeps_leaves_tuning_and_hardware() -> None:
    record = run("absorber_rig_a", "tuning.bounds={travel=5}", *SHORT)
    (words,) = [words for words in record.warnings if "stock" in words]
    assert "the least travel is 6.71448" in words
    assert "hardware/buy/peak" not in record
    assert number(record, "tuning/travel") == pytest.approx(5.0, rel=1e-9)
    assert number(record, "hardware/built/peak") > number(record, "tuning/peak")


@pytest.mark.long
def test_what_is_bought_keeps_the_bounds() -> None:
    free = run("absorber_rig_a")
    record = run("absorber_rig_a", "tuning.bounds={damping_ratio=[0.0, 0.01]}")
    assert number(record, "tuning/secondary_damping") == pytest.approx(0.01, rel=1e-12)
    for bought, tuned in (("spring_rate", "stiffness_ratio"),
                          ("dynamic_viscosity", "secondary_damping")):  # fmt: skip
        share = number(record, f"tuning/{tuned}") / number(record, f"tuning/unbounded/{tuned}")
        change = number(record, f"hardware/{bought}") / number(free, f"hardware/{bought}")
        assert change == pytest.approx(share, rel=1e-12) and abs(share - 1.0) > 1e-3


def test_no_stock_is_ranked_by_peaks_for_a_mean_square() -> None:
    record = run("absorber_rig_a", "tuning={norm='h2'}")
    assert "hardware/pair/peak" not in record and "hardware/spring_rate" in record
    assert any("mean square" in words for words in record.warnings)


def test_an_oil_out_of_its_model_is_left_out() -> None:
    record = run("absorber_rig_a", "machine.gap.temperature='-40 degC'", *SHORT)
    kept = list(record["hardware/oil/damping"].axes[0].values)
    assert "ISO VG 680" not in kept and len(kept) == 6
    assert list(record["hardware/pair/peak"].axes[1].values) == kept
    assert any("'ISO VG 680' in stock is left out" in words for words in record.warnings)
