"""Claim: tunings and peaks found together for many points are those of single runs."""

from pathlib import Path

import numpy as np
import pytest
from array_machines import designed, hold
from shipped_cases import CASES

from vibecalc.absorber.stage import PEAKS, TOGETHER
from vibecalc.core.case.raw import get_key, parse_key
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


def test_arrays_are_single_runs() -> None:
    axes = [
        {"key": "machine.primary.damping_ratio", "values": [0.0, 0.69]},
        {"key": "machine.secondary.mass_ratio", "values": [0.01, 2.0]},
    ]
    hold(LOADED, designed(LOADED, axes), tuple(TOGETHER), fewest=4, generous=None)


PRIMARY, SECONDARY = "machine.primary.", "machine.secondary."
#: keys that vary, and how much of the value as written each point has
VARIED = {
    "absorber_curves": {f"{SECONDARY}mass_ratio": (1.0, 0.2, 3.0)},
    "unit": {
        f"{PRIMARY}natural_frequency": (0.4, 1.1), f"{PRIMARY}damping_ratio": (0.0, 9.0),
        f"{SECONDARY}linear_stiffness": (0.0, 2.0), f"{SECONDARY}linear_damping": (0.1, 8.0),
    },
}  # fmt: skip


@pytest.mark.parametrize("name", VARIED)
def test_peaks_by_arrays_are_those_of_single_runs(name: str, tmp_path: Path) -> None:
    path = CASES.get(name, tmp_path / "unit.toml")
    if name not in CASES:
        path.write_text(UNIT)
    (loaded,) = load_checked([path], ("reference=[]", "limit=[]"))
    axes = [
        {"key": key, "values": list(get_key(loaded.resolved, parse_key(key)) * np.array(shares))}
        for key, shares in VARIED[name].items()
    ]
    design = designed(loaded, axes)
    assert unsupported(loaded.case, [parse_key(key) for key in design.keys], PEAKS) is None
    hold(loaded, design, tuple(PEAKS), fewest=design.count, generous=1.0 + 1e-6)


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
