"""Claim: a sweep that cannot be meant is refused before its first run, in words that help."""

from typing import Any

import pytest
from refused import problems_of as of_form
from shipped_cases import CASES
from sweep_samples import (
    DAMPING,
    MODEL,
    ORDERS,
    PHASE,
    SPEED,
    STIFFNESS,
    axis,
    design_of,
    generator,
    scattered,
    spread,
)

from vibecalc.core.study.execute import load_checked
from vibecalc.core.study.sweep.checks import check_design, keep_problems
from vibecalc.core.study.sweep.prepare import axis_table, sampling_table
from vibecalc.errors import CaseError, Problem, UsageError

HALF = {"distribution": {"kind": "normal", "mean": 1, "deviation": 1}}
SAMPLED = {"sampling": "sobol"}
THOUSAND = {"sampling": "latin_hypercube", "points": 1000}
PADDED = PHASE.replace("[0]", "[00]")
WIDE = [spread(key, 1, 2, 1000) for key in (STIFFNESS, DAMPING, SPEED, PHASE)]
Row = tuple[list[dict[str, Any]], dict[str, Any], str, str]


def problems_of(*axes: dict[str, Any], **more: Any) -> list[Problem]:
    """Problems of a sweep over the generator, those of its values included."""
    try:
        design = design_of(*axes, **more)
    except CaseError as error:
        return list(error.problems)
    return check_design(design, generator().resolved)


def said(problem: Problem) -> str:
    return " | ".join([problem.message, problem.found, problem.allowed, problem.hint])


#: keys that no axis can vary, and words of the hint
KEYS = {
    "machine.mounts.each.stifness": "did you mean 'stiffness'?",
    "machine.crank_train.crank_phase": "has no key",
    "machine.crank_train.cylinders[3].crank_phase": "[0] to [2], so no [3]",
    "title": "only keys below machine",
    "a key": "not a key",
}
#: axes without usable values: the axis, where the problem is, and words of it
VALUES: list[tuple[dict[str, Any], str, str]] = [
    (axis(STIFFNESS, 1), "values", "two points or more | one"),
    (axis(STIFFNESS, 1, 2, 1), "values", "same | 1 as number 1 and number 3"),
    (axis(STIFFNESS, 1, "2 mm"), "values", "wrong dimension | '2 mm', a length"),
    (axis(MODEL, "pitch", "rigid"), "values", "did you mean 'rigid_body'?"),
    (axis("machine.mounts.each", 1, 2), "values", "cannot be 1 | 1 | a table with stiffness"),
    (axis("machine.crank_train.cylinders", 1, 2), "values", "a key in it is machine.crank_tr"),
    (axis(ORDERS, [1, 2], [3, 4]), "values", "cannot be a list of 2 entries"),
    (axis(STIFFNESS, True, False), "values", "cannot be true | true"),
    (axis(ORDERS, 4, 5.5), "values", "not a whole number | 5.5"),
    (spread(STIFFNESS, 1, 2), "key", "a grid needs the number of points"),
    (spread(STIFFNESS, 1, 2, 1), "points", "two points or more | 1"),
    (spread(STIFFNESS, "1 N/mm", 1000, 3), "to", "the same value"),
    (spread(PHASE, "-5 deg", "5 deg", 3, spacing="log"), "spacing", "cannot pass zero"),
    (spread(ORDERS, 10, 80, 4), "points", "whole numbers only | 33.3333333 and 1 more"),
    (spread(MODEL, 1, 2, 3), "from", "is a choice"),
    ({"key": STIFFNESS, **HALF}, "distribution", "a grid has no random values"),
]
#: distributions that are none: kind, parameters, words
DISTRIBUTIONS: list[tuple[str, dict[str, Any], str]] = [
    ("normal", {"mean": 1, "deviation": 0}, "deviation has to be > 0"),
    ("lognormal", {"mean": -1, "deviation": 1}, "its mean has to be"),
    ("lognormal", {"mean": 1, "deviation": 1e7}, "1e+06 times the mean"),
    ("uniform", {"min": 2, "max": 1}, "min has to be below max"),
    ("triangular", {"min": 1, "max": 2, "mode": 3}, "mode has to be between"),
]
#: whole sweeps: axes, other keys, where the problem is, and words of it
SWEEPS: dict[str, Row] = {
    "no axis": ([], {}, "", "a sweep needs at least one axis"),
    "whole number": (
        [scattered(ORDERS, "normal", mean=9, deviation=1)],
        SAMPLED,
        "",
        "whole number cannot have a distribution",
    ),
    "whole number without points": ([spread(ORDERS, 4, 9)], SAMPLED, "", "needs its points"),
    "choice": ([scattered(MODEL, "normal", mean=9, deviation=1)], SAMPLED, "", "is a choice"),
    "twice": (
        [axis(STIFFNESS, 1, 2), axis(DAMPING, 1, 2), axis(STIFFNESS, 3, 4)],
        {},
        "axes.2.key",
        f"two axes vary {STIFFNESS}",
    ),
    "twice, padded": (
        [axis(PHASE, 1, 2), axis(PADDED, 3, 4)],
        {},
        "axes.1.key",
        f"two axes vary {PHASE}",
    ),
    "unequal": (
        [axis(STIFFNESS, 1, 2, 3, **{"in_step": [axis(DAMPING, 1, 2)]})],
        {},
        "",
        f"keys that vary together need equally many values | 2 for {DAMPING}, 3 for {STIFFNESS}",
    ),
    "too many": (WIDE, {}, "", "1e+12 points | 1000 x 1000 x 1000 x 1000 | at most 1e+09"),
    "too many runs": (
        [spread(STIFFNESS, 1, 2)],
        {**SAMPLED, "points": 10**9, "indices": True},
        "points",
        "1000000000 x 3 runs",
    ),
    "below a bound": (
        [spread(STIFFNESS, "-5 N/mm", "50 N/mm", 12)],
        {},
        "axes.0",
        "takes values that it must not have | -5000 N/m (1 of 12 values) | >= 0 N/m",
    ),
    "samples below a bound": (
        [spread(STIFFNESS, "-1 N/mm", "4 N/mm")],
        THOUSAND,
        "",
        "(200 of 1000 points)",
    ),
    # one slice in a thousand each: the share below zero is 15.87 %
    "a tail below a bound": (
        [scattered(STIFFNESS, "normal", mean="10 N/mm", deviation="10 N/mm")],
        THOUSAND,
        "",
        "of 1000 points) | >= 0 N/m | ",
    ),
    "no machine": (
        [axis("machine.crank_train.piston_mass", 0.2, 0.3)],
        {},
        "",
        "no point of the sweep is a case: ",
    ),
}
ROWS: dict[str, Row] = {
    **{key: ([axis(key, 1, 2)], {}, "axes.0.key", words) for key, words in KEYS.items()},
    **{f"{key}: {words}": ([table], {}, f"axes.0.{key}", words) for table, key, words in VALUES},
    **{
        f"{kind}: {words}": ([scattered(STIFFNESS, kind, **parameters)], SAMPLED, "", words)
        for kind, parameters, words in DISTRIBUTIONS
    },
    **SWEEPS,
}


@pytest.mark.parametrize("name", ROWS)
def test_sweeps_that_cannot_be_meant(name: str) -> None:
    axes, more, place, words = ROWS[name]
    (problem,) = problems_of(*axes, **more)
    path = ("sweep", *(int(key) if key.isdigit() else key for key in place.split(".") if key))
    assert problem.path[: len(path)] == path
    assert words in said(problem)


@pytest.mark.parametrize(
    ("changes", "key", "words"),
    [
        ({"points": 8}, "points", "points belongs to a sampling"),
        ({"seed": 8}, "seed", "seed belongs to a sampling"),
        ({"sampling": "sobol", "points": 1}, "points", "points is out of range"),
        ({"keep": ["a/b", "a/b"]}, "keep", "is given twice"),
        ({"indices": True}, "indices", "Sobol indices"),
        ({"sampling": "latin_hypercube", "indices": True}, "indices", "Sobol indices"),
    ],
)
def test_samplings_that_are_none(changes: dict[str, Any], key: str, words: str) -> None:
    sweep = {"axes": [{"key": STIFFNESS, "values": [1, 2]}], **changes}
    (problem,) = of_form({**generator().resolved, "sweep": sweep})
    assert problem.path[:2] == ("sweep", key)
    assert words in problem.message


MODELS = (axis(MODEL, "pitch", "rigid_body"),)
PEAK = "isolation/couple_over_lever/steady_peak"


@pytest.mark.parametrize(
    ("kept", "axes", "words"),
    [
        (["isolation/couple_over_lever/steady_peek"], (), f"did you mean '{PEAK}'?"),
        (["excitation/residual"], (), "no table of this case requests it"),
        (
            ["isolation/couple_over_lever/run_up"],
            (),
            "keep isolation/couple_over_lever/run_up_peak instead",
        ),
        (["isolation/pitch/inertia"], MODELS, "isolation.model = rigid_body"),
        (["isolation/modes/shape"], MODELS, "isolation.model = pitch"),
    ],
)
def test_results_that_cannot_be_kept(
    kept: list[str], axes: tuple[dict[str, Any], ...], words: str
) -> None:
    loaded = generator()
    design = design_of(*(axes or [axis(STIFFNESS, 5000, 6000)]))
    (problem,) = keep_problems(kept, loaded.case, design, loaded.resolved)
    assert problem.path[:2] == ("sweep", "keep") and words in said(problem)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("machine.speed", "needs key="),
        ("machine.speed=1,,2", "a value is missing"),
        ("machine.speed=1:2:", "start:stop:points"),
        ("machine.speed=1:2:5ln", "start:stop:points"),
        ("machine.speed=5:50 rpm:21", "give every value its unit, as in '50 rpm'"),
        ("machine.speed=1,2,3 rpm", "give every value its unit, as in '3 rpm'"),
        ("sobel:8", "did you mean sobol?"),
        ("grid:8", "no sampling 'grid'"),
        ("sobol", "METHOD:POINTS"),
    ],
)
def test_texts_that_are_no_axis_and_no_sampling(text: str, words: str) -> None:
    with pytest.raises(UsageError) as caught:
        (axis_table if text.startswith("machine") else sampling_table)(text)
    assert words in str(caught.value)


def test_check_looks_at_the_sweep_too(tmp_path) -> None:  # type: ignore[no-untyped-def]
    case = CASES["generator_mount_design"].read_text(encoding="utf-8")
    swept = """
[sweep]
axes = [{ key = "machine.mounts.each.stiffness", from = "5 N/mm", to = "50 N/mm", points = 3 }]
"""
    (tmp_path / "both.toml").write_text(case + swept, encoding="utf-8")
    with pytest.raises(CaseError) as caught:
        load_checked([tmp_path / "both.toml"])
    (problem,) = caught.value.problems
    assert problem.message == "a key that the sweep sets cannot be searched for as well"
    assert "both.toml:" in str(caught.value)
