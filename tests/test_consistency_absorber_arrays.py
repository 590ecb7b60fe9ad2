"""Claim: tunings and peaks found together for many points are those of single runs."""

from pathlib import Path

import numpy as np
import pytest
from shipped_cases import CASES

from vibecalc.absorber.stage import PEAKS, TOGETHER
from vibecalc.core.case.load import validate
from vibecalc.core.case.raw import case_at, get_key, parse_key
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import load_checked
from vibecalc.core.study.sweep.at_once import compute, unsupported

(LOADED,) = load_checked([CASES["absorber_design_chart"]], ("reference=[]", "limit=[]"))
DAMPING, MASS = (
    parse_key(key) for key in ("machine.primary.damping_ratio", "machine.secondary.mass_ratio")
)
KEEP = frozenset(TOGETHER)
UNIT = """
schema = 1
title = "an absorber in units"
[machine]
kind = "absorber"
primary = { mass = "100 kg", natural_frequency = "10 Hz", damping_ratio = 0.01 }
secondary = { mass = "5 kg", linear_stiffness = "17 N/mm", linear_damping = "60 N*s/m" }
[response.absorber]
frequencies = { from = "5 Hz", to = "15 Hz" }
"""
POINTS = ((0.0, 0.1), (0.3, 0.01), (0.69, 0.5), (0.5, 2.0))


def test_arrays_are_single_runs() -> None:
    z1, m = np.array(POINTS).T
    parts, alone = compute(LOADED.case, {DAMPING: z1, MASS: m}, len(POINTS), KEEP)
    assert not len(alone) and len(parts) == 1
    for place, point in enumerate(POINTS):
        settings = {
            "machine.primary.damping_ratio": point[0],
            "machine.secondary.mass_ratio": point[1],
        }
        record = run_case(validate(case_at(LOADED.resolved, settings)), wanted=KEEP)
        for path in TOGETHER:
            column = parts[0].columns[path]
            apart = abs(float(column.values[place]) - float(record[path].values))
            slack = column.errors[place] + record[path].error_estimate
            assert apart <= slack + 1e-15, path


PRIMARY, SECONDARY = "machine.primary.", "machine.secondary."
#: keys that vary, and how much of the value as written each point has
VARIED = {
    "absorber_curves": {f"{SECONDARY}mass_ratio": (1.0, 0.2, 3.0)},
    "unit": {
        f"{PRIMARY}natural_frequency": (1.0, 1.1, 0.4), f"{PRIMARY}damping_ratio": (1.0, 0.0, 9.0),
        f"{SECONDARY}linear_stiffness": (1.0, 0.0, 2.0), f"{SECONDARY}linear_damping": (1, 8, 0.1),
    },
}  # fmt: skip


@pytest.mark.parametrize("name", VARIED)
def test_peaks_by_arrays_are_those_of_single_runs(name: str, tmp_path: Path) -> None:
    path = CASES.get(name, tmp_path / "unit.toml")
    if name not in CASES:
        path.write_text(UNIT)
    (loaded,) = load_checked([path], ("reference=[]", "limit=[]"))
    written = {parse_key(key): get_key(loaded.resolved, key) for key in VARIED[name]}
    values = {
        parse_key(key): written[parse_key(key)] * np.array(shares)
        for key, shares in VARIED[name].items()
    }
    assert unsupported(loaded.case, [*values], PEAKS) is None
    parts, alone = compute(loaded.case, values, 3, frozenset(PEAKS))
    assert not len(alone)
    for place in range(3):
        settings = {key: float(values[parse_key(key)][place]) for key in VARIED[name]}
        case = validate(case_at(loaded.resolved, settings))
        record = run_case(case, wanted=frozenset(PEAKS))
        for path_of in PEAKS:
            column, single = parts[0].columns[path_of], record[path_of]
            with np.errstate(invalid="ignore"):
                apart = np.where(
                    column.values[place] == single.values, 0.0,
                    np.abs(column.values[place] - single.values),
                )  # fmt: skip
            assert np.max(apart) <= column.errors[place] + single.error_estimate, path_of
            assert column.errors[place] == pytest.approx(single.error_estimate, rel=1e-6)


def test_points_that_need_words_are_left_to_single_runs() -> None:
    z1, m = np.array([0.1, 0.8, -0.1, 0.1]), np.array([0.1, 0.1, 0.1, np.nan])
    parts, alone = compute(LOADED.case, {DAMPING: z1, MASS: m}, 4, KEEP)
    assert alone.tolist() == [1, 2, 3]
    assert parts[0].places.tolist() == [0]


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("tuning.norm='h2'", "found together"),
        ("tuning.mistuning=[0.1]", "point by point"),
        ("tuning.kind='viscous'", "found together"),
    ],
)
def test_what_arrays_do_not_do(setting: str, words: str) -> None:
    keys = [parse_key("machine.secondary.mass_ratio")]
    assert unsupported(LOADED.case, keys, ["tuning/peak"]) is None
    (other,) = load_checked([CASES["absorber_design_chart"]], (setting, "reference=[]", "limit=[]"))
    assert words in str(unsupported(other.case, keys, ["tuning/peak"]))
