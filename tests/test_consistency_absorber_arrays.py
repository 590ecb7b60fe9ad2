"""Claim: tunings found together for many points are those of single runs, with honest errors."""

import numpy as np
import pytest
from shipped_cases import CASES

from vibecalc.absorber.stage import TOGETHER
from vibecalc.core.case.load import validate
from vibecalc.core.case.raw import case_at, parse_key
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import load_checked
from vibecalc.core.study.sweep.at_once import compute, unsupported

(LOADED,) = load_checked([CASES["absorber_design_chart"]], ("reference=[]", "limit=[]"))
DAMPING, MASS = (
    parse_key(key) for key in ("machine.primary.damping_ratio", "machine.secondary.mass_ratio")
)
KEEP = frozenset(TOGETHER)
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
