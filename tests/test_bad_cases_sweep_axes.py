"""Claim: a sweep that cannot be meant is refused before its first run, in words that help."""

import pytest
from pydantic import ValidationError
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


def problems_of(*axes, **more) -> list[Problem]:
    """Problems of a sweep over the generator, those of its values included."""
    try:
        design = design_of(*axes, **more)
    except CaseError as error:
        return list(error.problems)
    return check_design(design, generator().resolved)


def said(problem: Problem) -> str:
    return " | ".join([problem.message, problem.found, problem.allowed, problem.hint])


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("machine.mounts.each.stifness", "did you mean machine.mounts.each.stiffness?"),
        ("mounts.each.stiffness", "did you mean machine.mounts.each.stiffness?"),
        ("machine.crank_train.crank_phase", "has no key"),
        ("machine.mounts.each", "is a table with stiffness, damping"),
        ("machine.crank_train.cylinders", "a key in it is machine.crank_train.cylinders[0]."),
        ("machine.crank_train.cylinders[3].crank_phase", "[0] to [2], so no [3]"),
        ("machine.crank_train.cylinders.crank_phase", "has no key"),
        ("machine.mounts.each.stiffness[1]", "is no list"),
        ("machine.motor.torque.order[0]", "machine has no key 'motor'"),
        ("title", "only keys below machine"),
        ("limit[0].max", "only keys below machine"),
        ("sweep.points", "only keys below machine"),
        ("a key", "not a key"),
        ("[0]", "start with the name of a table"),
    ],
)
def test_keys_that_cannot_vary(key, words):
    (problem,) = problems_of(axis(key, 1, 2))
    assert problem.path == ("sweep", "axes", 0, "key")
    assert problem.message == "a sweep cannot vary this key"
    assert words in problem.hint


HALF = {"distribution": {"kind": "normal", "mean": 1, "deviation": 1}}


@pytest.mark.parametrize(
    ("table", "key", "words"),
    [
        (axis(STIFFNESS), "key", "has no values"),
        (axis(STIFFNESS, 1), "values", "two points or more | one"),
        (axis(STIFFNESS, 1, 2, 1), "values", "same | 1 as number 1 and number 3"),
        (axis(STIFFNESS, "1 N/mm", 1000), "values", "two points of an axis are the same"),
        (axis(STIFFNESS, 1, "2 mm"), "values", "wrong dimension | '2 mm', a length"),
        (axis(STIFFNESS, 1, "much"), "values", "not a number"),
        (axis(STIFFNESS, 1, 2, points=2), "points", "belongs to from and to"),
        (axis(STIFFNESS, 1, 2, spacing="log"), "spacing", "belongs to from and to"),
        (axis(STIFFNESS, 1, 2, **{"from": 1}), "from", "says twice"),
        (axis(MODEL, "pitch", "rigid"), "values", "did you mean 'rigid_body'?"),
        (axis(MODEL, "pitch", 3), "values", "cannot be 3"),
        (axis(ORDERS, 4, 5.5), "values", "whole numbers only | 5.5"),
        (spread(STIFFNESS, 1, 2), "key", "a grid needs the number of points"),
        (spread(STIFFNESS, 1, 2, 1), "points", "two points or more | 1"),
        (spread(STIFFNESS, 1, 2, -3), "points", "two points or more | -3"),
        (spread(STIFFNESS, 1, None, 3), "key", "to is missing"),
        (spread(STIFFNESS, "1 N/mm", 1000, 3), "to", "the same value"),
        (spread(PHASE, "-5 deg", "5 deg", 3, spacing="log"), "spacing", "never pass zero"),
        (spread(STIFFNESS, 0, 5, 3, spacing="log"), "spacing", "from 0.0 to 5.0"),
        (spread(STIFFNESS, "1 kg", 5, 3), "from", "a mass"),
        (spread(ORDERS, 10, 80, 4), "points", "whole numbers only | 33.3333333 and 1 more"),
        (spread(MODEL, 1, 2, 3), "from", "is a choice"),
        ({"key": STIFFNESS, **HALF}, "distribution", "a grid does not draw"),
    ],
)  # fmt: skip
def test_axes_without_usable_values(table, key, words):
    (problem,) = problems_of(table)
    assert problem.path == ("sweep", "axes", 0, key)
    assert words in said(problem)


@pytest.mark.parametrize(
    ("kind", "parameters", "words"),
    [
        ("normal", {"mean": 1}, "deviation too little | | mean and deviation"),
        ("normal", {"mean": 1, "deviation": 0}, "deviation has to be > 0"),
        ("normal", {"mean": 1, "deviation": 1, "mode": 1}, "mode too much"),
        ("normal", {"mean": "1 kg", "deviation": 1}, "a mass"),
        ("lognormal", {"mean": -1, "deviation": 1}, "its mean has to be"),
        ("lognormal", {"mean": 1, "deviation": 1e7}, "1e+06 times the mean"),
        ("uniform", {"lower": 2, "upper": 1}, "lower has to be below upper"),
        ("uniform", {"mean": 2, "deviation": 1}, "mean too much"),
        ("triangular", {"lower": 1, "upper": 2, "mode": 3}, "mode has to be between"),
    ],
)
def test_distributions_that_are_none(kind, parameters, words):
    (problem,) = problems_of(scattered(STIFFNESS, kind, **parameters), sampling="sobol")
    assert words.replace(" | | ", " |  | ") in said(problem)


def test_a_whole_number_and_a_choice_do_not_scatter():
    (problem,) = problems_of(scattered(ORDERS, "normal", mean=9, deviation=1), sampling="sobol")
    assert "whole number cannot scatter" in problem.message
    (problem,) = problems_of(spread(ORDERS, 4, 9), sampling="sobol")
    assert "needs its points" in problem.message
    (problem,) = problems_of(scattered(MODEL, "normal", mean=9, deviation=1), sampling="sobol")
    assert "is a choice" in problem.message


def test_doubled_keys():
    (problem,) = problems_of(axis(STIFFNESS, 1, 2), axis(DAMPING, 1, 2), axis(STIFFNESS, 3, 4))
    assert problem.message == f"two axes vary {STIFFNESS}"
    assert problem.path == ("sweep", "axes", 2, "key")
    assert problem.also == ("sweep", "axes", 0, "key")
    inside = axis(STIFFNESS, 1, 2, **{"with": [axis(STIFFNESS, 3, 4)]})
    (problem,) = problems_of(inside)
    assert problem.path == ("sweep", "axes", 0, "with", 0, "key")
    padded = PHASE.replace("[0]", "[00]")
    (problem,) = problems_of(axis(PHASE, 1, 2), axis(padded, 3, 4))
    assert problem.message == f"two axes vary {PHASE}"


def test_zipped_axes_of_unequal_length():
    table = axis(STIFFNESS, 1, 2, 3, **{"with": [axis(DAMPING, 1, 2), spread(SPEED, 1, 2, 4)]})
    first, second = problems_of(table)
    assert first.message == "keys that vary together need equally many values"
    assert first.found == f"2 for {DAMPING}, 3 for {STIFFNESS}"
    assert second.found == f"4 for {SPEED}, 3 for {STIFFNESS}"
    assert first.also == ("sweep", "axes", 0, "key")


def test_all_problems_are_reported_at_once():
    wrong = axis(STIFFNESS, "1 kg", 2, **{"with": [spread("machine.sped", 1, 2)]})
    problems = problems_of(wrong, spread(DAMPING, 1, 1, 3))
    assert [problem.path[-1] for problem in problems] == ["values", "key", "to"]


def test_sizes_that_no_run_finishes():
    axes = [spread(key, 1, 2, 1000) for key in (STIFFNESS, DAMPING, SPEED, PHASE)]
    (problem,) = problems_of(*axes)
    assert problem.message == "the sweep would have 1 million million points"
    assert problem.found == "1000 x 1000 x 1000 x 1000"
    assert problem.allowed == "at most 1 thousand million"
    assert "32 years" in problem.hint
    (problem,) = problems_of(spread(STIFFNESS, 1, 2, 10**12))
    assert problem.message == "the sweep would have 1 million million points"
    (problem,) = problems_of(spread(STIFFNESS, 1, 2), sampling="sobol", points=10**9, indices=True)
    assert problem.found == "1000000000 x 3 runs"
    assert problem.path == ("sweep", "points")


def test_a_sweep_of_no_axis():
    (problem,) = problems_of()
    assert problem.message == "a sweep needs at least one axis"


@pytest.mark.parametrize(
    ("changes", "key", "words"),
    [
        ({"points": 8}, "points", "points belongs to a sampling"),
        ({"seed": 8}, "seed", "seed belongs to a sampling"),
        ({"sampling": "sobol", "points": 1}, "points", "points is out of range"),
        ({"indices": True}, "indices", "Sobol indices"),
        ({"sampling": "latin_hypercube", "indices": True}, "indices", "Sobol indices"),
    ],
)
def test_samplings_that_are_none(changes, key, words):
    sweep = {"axes": [{"key": STIFFNESS, "values": [1, 2]}], **changes}
    (problem,) = of_form({**generator().resolved, "sweep": sweep})
    assert problem.path == ("sweep", key)
    assert words in problem.message


def test_values_outside_the_bounds_are_counted():
    first, second = problems_of(
        spread(STIFFNESS, "-5 N/mm", "50 N/mm", 12), axis(SPEED, 10, 0, -20, 5)
    )
    assert first.message == f"{STIFFNESS} takes values that it must not have"
    assert first.found == "-5000 N/m (1 of 12 values, 4 of 48 points)"
    assert first.allowed == ">= 0 N/m"
    assert second.found == "0, -20 rad/s (2 of 4 values, 24 of 48 points)"
    assert second.path == ("sweep", "axes", 1)
    both_sides = spread("accuracy.rtol", -0.5, 0.5, 11)
    (problem,) = problems_of(both_sides)
    assert problem.found == "-0.5, -0.4, -0.3, ... (10 of 11 values)"
    falling = spread(STIFFNESS, 3, -3, 10**6)
    (problem,) = problems_of(falling)
    assert "(500000 of 1 million values)" in problem.found


def test_samples_outside_the_bounds_are_counted():
    scatter = scattered(STIFFNESS, "normal", mean="10 N/mm", deviation="10 N/mm")
    (problem,) = problems_of(scatter, sampling="latin_hypercube", points=1000)
    # one slice in a thousand each: the share below zero is 15.87 %
    assert "(159 of 1000 points)" in problem.found or "(158 of 1000 points)" in problem.found
    assert "lognormal" in problem.hint
    (problem,) = problems_of(
        spread(STIFFNESS, "-1 N/mm", "4 N/mm"), sampling="latin_hypercube", points=1000
    )
    assert "(200 of 1000 points)" in problem.found
    inside = scattered(STIFFNESS, "lognormal", mean="10 N/mm", deviation="10 N/mm")
    assert not problems_of(inside, sampling="latin_hypercube", points=1000)


def test_a_sweep_without_a_case_in_it():
    (problem,) = problems_of(axis("machine.crank_train.piston_mass", 0.2, 0.3))
    assert problem.message.startswith("no point of the sweep is a case: ")


def test_results_that_cannot_be_kept():
    loaded = generator()

    def kept(*paths, design=None):
        design = design or design_of(axis(STIFFNESS, 5000, 6000))
        return keep_problems(paths, loaded.case, design, loaded.resolved)

    (problem,) = kept("isolation/lever_force/steady_peek")
    assert problem.path == ("sweep", "keep", 0)
    assert problem.hint == "did you mean 'isolation/lever_force/steady_peak'?"
    (problem,) = kept("excitation/residual")
    assert "no table of this case asks for it" in problem.hint
    (problem,) = kept("isolation/lever_force/run_up")
    assert "'speed' is chosen anew" in problem.message
    assert problem.hint == "keep isolation/lever_force/run_up_peak instead"
    peak = "isolation/lever_force/steady_peak"
    (problem,) = kept(peak, peak)
    assert problem.message == f"{peak} is kept twice"
    models = design_of(axis(MODEL, "pitch", "rigid_body"))
    (problem,) = kept("isolation/pitch/inertia", design=models)
    assert problem.message == "not every point of the sweep has this quantity"
    assert "isolation.model = rigid_body" in problem.found
    (problem,) = kept("isolation/modes/shape", design=models)
    assert "isolation.model = pitch" in problem.found


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("machine.speed", "needs key="),
        ("machine.speed=", "needs key="),
        ("machine.speed=1,,2", "a value is missing"),
        ("machine.speed=1:2:3:4", "start:stop:points"),
        ("machine.speed=1:2:", "start:stop:points"),
        ("machine.speed=1:2:1e6", "start:stop:points"),
        ("machine.speed=1:2:-3", "start:stop:points"),
        ("machine.speed=1:2:5ln", "start:stop:points"),
        ("machine.speed=:2:5", "a value is missing"),
        ("machine speed=1:2:5", "not a key"),
        ("machine.speed=5:50 rpm:21", "give every value its unit, as in '50 rpm'"),
        ("machine.speed=1,2,3 rpm", "give every value its unit, as in '3 rpm'"),
    ],
)
def test_texts_that_are_no_axis(text, words):
    with pytest.raises(UsageError) as caught:
        axis_table(text)
    assert words in str(caught.value)
    assert "--grid" in str(caught.value) or "not a key" in words


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("sobel:8", "did you mean sobol?"),
        ("grid:8", "no sampling 'grid'"),
        ("sobol", "METHOD:POINTS"),
        ("sobol:8:1:1", "METHOD:POINTS"),
        ("sobol:many", "METHOD:POINTS"),
        ("sobol:-8", "METHOD:POINTS"),
    ],
)
def test_texts_that_are_no_sampling(text, words):
    with pytest.raises(UsageError) as caught:
        sampling_table(text)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    "more", [{"seed": -1}, {"seed": 2**32}, {"points": 1.5}, {"points": True}, {"sampling": "lhs"}]
)
def test_tables_that_the_schema_refuses(more):
    with pytest.raises(ValidationError):
        design_of(axis(STIFFNESS, 1, 2), **more)
    with pytest.raises(ValidationError):
        design_of(axis(STIFFNESS, 1, True))


def test_check_looks_at_the_sweep_too(tmp_path):
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
    assert problem.found == "machine.mounts.each.stiffness"
    assert "both.toml:" in str(caught.value)
