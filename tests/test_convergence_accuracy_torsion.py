"""Claim: on shaft lines truths agree, series show their theory, defaults are on the front."""

from functools import cache

import numpy as np
import pytest
from shipped_cases import CASES

from vibecalc.core.accuracy.record import Fit, extra_work, fitted
from vibecalc.core.accuracy.topic import Measured, Timed, Topic, Trial, measure
from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.results.named import named
from vibecalc.core.run.plan import plan_case
from vibecalc.core.run.run import run_scene
from vibecalc.core.run.stage import Scene
from vibecalc.core.study.execute import load_checked
from vibecalc.errors import NumericalFailure
from vibecalc.torsion.accuracy.by_other_means import (
    dense_angles,
    exact_angles,
    exact_modes,
    fejer_rule,
    half_ranges_of_samples,
    pole_angles,
    steady_by_steps,
    transfer_angles,
)
from vibecalc.torsion.line import chain

#: stage, case, topics and how well their truths agree at least
SHORT = {
    ("torsion", "engine_damped"): {
        "natural frequencies": 1e-15,
        "mode shapes": 1e-15,
        "torques by order": 1e-15,
        "gas torque of a cylinder": 1e-14,
        "half ranges over the cycle": 1e-15,
        "orders left out": 1e-7,
    },
    ("torsion_speeds", "engine_variable_inertia"): {
        "curve against speed": 1e-15,
        "largest torque": 1e-14,
    },
    ("damper design", "engine_damper_heat"): {"least largest torque": 1e-5},
    ("transient", "engine_two_stroke"): {"torques in time": 1e-11},
    ("torque reaction", "engine_v8"): {"peak of a support force": 1e-14, "orders left out": 1e-9},
    ("variable inertia", "engine_variable_inertia"): {"half ranges": 2e-6},
    ("modal route as published", "engine_as_published"): {"twist on critical speeds": 1e-14},
}
TAKES_LONG = ("variable inertia", "damper design", "transient", "torque reaction")
STAGES = sorted({stage for stage, _ in SHORT})


@cache
def scene_of(case: str) -> Scene:
    """What the stages of a case hand on, without results that nothing reads."""
    (loaded,) = load_checked([CASES[case]], ())
    read = {stage.quantities[0] for stage in plan_case(loaded.case) if not stage.is_last}
    return run_scene(loaded.case, wanted=frozenset(read))


def topics_of(stage: str, case: str) -> list[Topic]:
    scene = scene_of(case)
    (planned,) = (one for one in plan_case(scene.case) if one.name == stage)
    return [topic for where in planned.topics for topic in named(where)(scene)]


@cache
def measured(stage: str, case: str) -> dict[str, Measured]:
    every = topics_of(stage, case)
    return {topic.name: measure(topic, Timed(repeat=False)) for topic in every}


def trials_of(stage: str, case: str, topic: str, solver: str) -> list[Trial]:
    return [one for one in measured(stage, case)[topic].trials if one.solver == solver]


def default_of(found: Measured) -> Trial:
    (trial,) = [one for one in found.trials if one.is_default]
    return trial


def fit_of(stage: str, case: str, topic: str, solver: str) -> Fit:
    agreement = measured(stage, case)[topic].reference.agreement
    fit = fitted(trials_of(stage, case, topic, solver), agreement)
    assert fit is not None
    return fit


def check(stage: str, found: dict[str, Measured]) -> None:
    """What holds for every topic of every case."""
    for name, one in found.items():
        topic = one.topic
        assert topic.stage == stage
        assert any(path.startswith(topic.quantity) for path in CATALOGUE), topic.quantity
        assert default_of(one).done, name
        extra = extra_work(topic, one.trials)
        assert extra <= topic.default_extra, (name, extra)
        assert bool(topic.default_why) == (topic.default_extra > 1.0), name
        assert all(trial.cause for trial in one.trials if not trial.done), name


@pytest.mark.parametrize(
    ("stage", "case"),
    [pytest.param(*one, marks=[pytest.mark.long] if one[0] in TAKES_LONG else []) for one in SHORT],
)
def test_truths_agree_and_defaults_are_on_the_front(stage: str, case: str) -> None:
    found, expected = measured(stage, case), SHORT[stage, case]
    assert set(found) == set(expected)
    check(stage, found)
    for name, bound in expected.items():
        assert found[name].reference.agreement <= bound, name


@pytest.mark.parametrize(
    ("stage", "case", "topic"),
    [
        ("torsion", "engine_damped", "natural frequencies"),
        ("torsion", "engine_damped", "mode shapes"),
        ("torsion", "engine_damped", "torques by order"),
        ("torsion", "engine_damped", "gas torque of a cylinder"),
        ("torsion", "engine_damped", "half ranges over the cycle"),
        ("torsion_speeds", "engine_variable_inertia", "curve against speed"),
        ("torsion_speeds", "engine_variable_inertia", "largest torque"),
        pytest.param("transient", "engine_two_stroke", "torques in time", marks=pytest.mark.long),
        ("modal route as published", "engine_as_published", "twist on critical speeds"),
    ],
)
def test_defaults_reach_rounding(stage: str, case: str, topic: str) -> None:
    assert default_of(measured(stage, case)[topic]).worst_relative < 2e-14


def test_the_place_of_the_largest_torque_has_more_digits_than_its_height_alone_gives() -> None:
    found = measured("torsion_speeds", "engine_variable_inertia")["largest torque"]
    own, place = default_of(found).position_error, found.reference.position
    golden = [one for one in found.trials if one.solver == "grid and golden section"]
    assert own is not None and place is not None
    assert own < 1e-11 * place
    assert all((one.position_error or 0.0) < 1e-7 * place for one in golden)
    assert max(one.position_error or 0.0 for one in golden) > 1e-10 * place


@pytest.mark.parametrize(
    ("stage", "case", "topic", "solver", "kind", "value"),
    [
        # a bracket halved is log10(2) of a digit
        ("torsion", "engine_damped", "natural frequencies", "mode counts", "digits", 0.301),
        ("torsion", "engine_damped", "natural frequencies", "Holzer scan", "order", 2.0),
        ("torsion", "engine_damped", "mode shapes", "Holzer table", "digits", 1.0),
        ("torsion", "engine_damped", "gas torque of a cylinder", "samples", "order", 2.0),
        ("torsion", "engine_damped", "half ranges over the cycle", "grid", "order", 2.0),
        ("torsion", "engine_damped", "half ranges over the cycle", "grid with parabola",
         "order", 3.0),
        ("torsion_speeds", "engine_variable_inertia", "curve against speed",
         "full matrices, samples", "order", 2.0),
        ("torsion_speeds", "engine_variable_inertia", "largest torque", "grid", "order", 2.0),
    ],
)  # fmt: skip
def test_solvers_converge_as_theory_says(
    stage: str, case: str, topic: str, solver: str, kind: str, value: float
) -> None:
    fit = fit_of(stage, case, topic, solver)
    assert fit.kind == kind
    assert fit.value == pytest.approx(value, abs=0.3 if kind == "order" else 0.1 * value)


def test_quadrature_of_a_card_converges_geometrically() -> None:
    gauss = fit_of("torsion", "engine_damped", "gas torque of a cylinder", "Gauss")
    assert gauss.kind == "digits"
    assert gauss.value > 1.0


@pytest.mark.long
def test_harmonic_balance_converges_geometrically() -> None:
    balance = fit_of(
        "variable inertia", "engine_variable_inertia", "half ranges", "harmonic balance"
    )
    assert balance.kind == "digits"
    assert balance.value > 0.15


@pytest.mark.long
def test_fourth_order_steps_converge_until_they_are_unstable() -> None:
    trials = trials_of("transient", "engine_two_stroke", "torques in time", "Runge-Kutta")
    assert "unstable" in trials[0].cause
    fine = [one for one in trials if one.done][-3:]
    fit = fitted(fine, 1e-12)
    assert fit is not None
    assert fit.value == pytest.approx(4.0, abs=0.3)


@pytest.mark.long
def test_mean_inertias_and_a_linear_balance_keep_an_error_that_no_order_mends() -> None:
    stage, case = "variable inertia", "engine_variable_inertia"
    (mean,) = trials_of(stage, case, "half ranges", "mean inertias")
    linear = [one for one in trials_of(stage, case, "half ranges", "linear balance") if one.done]
    assert mean.worst_relative > 0.1
    assert linear[-1].worst_relative == pytest.approx(linear[-2].worst_relative, rel=0.05)
    assert linear[-1].worst_relative > 1e-3


def test_modes_of_a_damped_line_are_not_its_response() -> None:
    trials = trials_of("torsion", "engine_damped", "torques by order", "sum over modes")
    assert trials[-1].worst_relative > 1e-2
    (poles,) = trials_of("torsion", "engine_damped", "torques by order", "state matrix")
    assert poles.worst_relative < 1e-10


def test_a_rigid_mode_loses_half_the_digits_as_an_eigenvalue() -> None:
    for solver in ("symmetric form", "eigenvalues of K / J", "state matrix"):
        (trial,) = trials_of("torsion", "engine_damped", "natural frequencies", solver)
        assert 1e-11 < trial.worst_relative < 1e-6


@pytest.mark.parametrize(
    ("topic", "solver", "cause"),
    [
        ("torques by order", "transfer matrices", "branches"),
        ("torques by order", "state matrix", "loss factor"),
        ("orders left out", "steps in time", "loss factor"),
        ("natural frequencies", "Holzer scan", "changes of sign"),
    ],
)
def test_what_a_geared_line_rules_out_is_named(topic: str, solver: str, cause: str) -> None:
    (whole,) = [one for one in topics_of("torsion", "engine_geared") if one.name == topic]
    (method,) = [one for one in whole.solvers if one.name == solver]
    for setting in method.settings:
        with pytest.raises(NumericalFailure, match=cause):
            method.solve(setting)


def test_exact_modes_of_a_uniform_row_are_its_sines() -> None:
    frequency, shape = exact_modes(chain(np.ones(6), np.ones(5)))
    place = np.arange(6) + 0.5
    waves = [np.cos(np.pi * m * place / 6) for m in range(6)]
    assert frequency == pytest.approx(2.0 * np.sin(np.pi * np.arange(6) / 12), abs=1e-15)
    for own, wave in zip(shape, waves, strict=True):
        assert abs(own @ wave) == pytest.approx(np.linalg.norm(own) * np.linalg.norm(wave))


def test_ways_to_the_forced_response_meet() -> None:
    random = np.random.default_rng(4)
    line = chain(1.0 + random.random(5), 50.0 + random.random(4))
    line = line._replace(damping=np.full(4, 0.3), absolute_damping=random.random(5))
    w = np.array([1.0, 5.0, 11.0])
    torque = random.normal(size=(3, 5)) + 1j * random.normal(size=(3, 5))
    true = exact_angles(line, w, torque)
    for way in (dense_angles, transfer_angles, pole_angles):
        assert way(line, w, torque) == pytest.approx(true, rel=1e-11)
    turned = line._replace(first=line.second, second=line.first)
    assert exact_angles(turned, w, torque) == pytest.approx(true, rel=1e-14)
    with pytest.raises(NumericalFailure, match="branches"):
        transfer_angles(line._replace(first=np.zeros(4, dtype=np.int64)), w, torque)


def test_rule_of_fejer_is_exact_for_polynomials() -> None:
    node, weight = fejer_rule(8)
    powers = np.arange(8)
    assert weight @ node[:, None] ** powers == pytest.approx(1.0 / (powers + 1.0), rel=1e-14)


def test_steps_over_a_cycle_give_the_steady_vibration() -> None:
    line = chain(np.array([2.0, 3.0]), np.array([40.0]))._replace(damping=np.array([1.5]))
    speed, cycle = 2.0, 4.0 * np.pi

    def torque(angle: np.ndarray) -> np.ndarray:
        return np.stack([np.cos(1.5 * angle), np.zeros_like(angle)], axis=-1)

    found = steady_by_steps(line, torque, speed, cycle, 400).torque
    w = np.array([1.5 * speed])
    angle = exact_angles(line, w, np.array([[1.0 + 0.0j, 0.0]]))[0]
    true = abs((40.0 + 1j * w[0] * 1.5) * (angle[0] - angle[1]))
    assert half_ranges_of_samples(found.T) == pytest.approx([true], rel=1e-6)
    with pytest.raises(NumericalFailure, match="unstable"):
        steady_by_steps(line, torque, speed, cycle, 8)


@pytest.mark.long
@pytest.mark.parametrize("case", sorted(name for name in CASES if name.startswith("engine")))
def test_every_engine_has_its_defaults_on_the_front(case: str) -> None:
    stages = [one.name for one in plan_case(scene_of(case).case) if one.name in STAGES]
    assert stages
    for stage in stages:
        check(stage, measured(stage, case))
