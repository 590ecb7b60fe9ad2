"""Claim: each question's truth is known, its default is right and on the front by counted work.

The plain ways converge as theory says, and what fails says why.
"""

from functools import cache

import numpy as np
import pytest
from shipped_cases import CASES

from vibecalc.core.accuracy.frame_topics import optimisation_topics
from vibecalc.core.accuracy.kinds import Optimal, optimum, within_budget
from vibecalc.core.accuracy.record import fitted
from vibecalc.core.accuracy.topic import Ask, Measured, Solver, measure
from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.results.named import named
from vibecalc.core.results.trials import Trial, extra
from vibecalc.core.run.plan import plan_case
from vibecalc.core.run.run import run_scene
from vibecalc.core.run.stage import Scene
from vibecalc.core.study.execute import load_checked
from vibecalc.errors import NumericalFailure
from vibecalc.isolation.accuracy import LARGEST

ONCE = (60.0, 0)
LONG = pytest.mark.long
HIGHEST_ORDER = "response/torsion/variable_inertia/highest_order"
#: case, stage, question, how well its truth is known, error of the default
EVERY = [
    ("compressor", "kinematics", "harmonics of the acceleration", 1e-25, 1e-14),
    ("compressor", "excitation", "force peak", 1e-14, 1e-14),
    ("compressor", "excitation", "couple peak", 1e-14, 1e-14),
    ("compressor", "response", "natural frequencies", 1e-15, 1e-14),
    ("compressor", "response", "translations by order", 1e-14, 1e-14),
    ("compressor_motor", "motor", "axial force peak", 1e-14, 1e-14),
    ("generator", "isolation", "support force by order", 1e-14, 1e-14),
    ("generator", "isolation", "largest support force", 1e-14, 1e-14),
    ("generator", "run_up", "largest force of the run-up", 1e-13, 1e-13),
    ("generator_on_floor", "foundation", "force on the ground", 1e-14, 1e-14),
    ("pump", "pump", "torque of the liquid", 1e-14, 1e-14),
    ("engine_damped", "torsion", "natural frequencies", 1e-15, 1e-14),
    ("engine_damped", "torsion", "torques by order", 1e-14, 1e-14),
    ("engine_damped", "torsion", "gas torque of a cylinder", 1e-14, 1e-14),
    ("engine_damped", "torsion", "highest torque over the cycle", 1e-13, 1e-14),
    ("engine_variable_inertia", "torsion_speeds", "largest torque", 1e-14, 1e-14),
    ("absorber_rig_a", "absorber", "highest peak", 1e-14, 1e-14),
    ("roll", "roll", "largest slip", 1e-12, 1e-12),
    ("roll_control", "control", "load", 1e-14, 1e-14),
]
EVERY_LONG = [
    ("engine_bearing_loads", "bearing_loads", "highest main bearing load", 1e-13, 1e-14),
    ("absorber_pendulum", "pendulum", "order of swing", 1e-13, 2e-14),
    ("compressor", "operations", "highest peak energy", 1e-13, 1e-9),
    ("absorber_rig_a", "tuning", "least peak", 1e-10, 2e-14),
    ("absorber_two", "tuning", "least peak", 1e-9, 2e-14),
    ("absorber_two", "absorber", "highest peak", 1e-13, 2e-14),
    ("compressor_impact", "impact", "first contacts", 1e-11, 1e-13),
    ("roll", "roll", "spectrum", 1e-10, 1e-12),
    ("roll_startup", "start-up", "motion", 1e-10, 1e-8),
    ("compressor_switching", "switching", "change at once", 1e-12, 1e-12),
    ("compressor_switching", "switching", "run-down", 1e-12, 1e-12),
    ("engine_damper_heat", "damper design", "least largest torque", 1e-5, 1e-14),
    ("engine_two_stroke", "transient", "torques in time", 1e-11, 2e-14),
    ("engine_variable_inertia", "variable inertia", "half ranges", 2e-6, 1e-4),
]


@cache
def scene_of(case: str) -> Scene:
    """What the stages of a case hand on, without results that nothing reads."""
    (loaded,) = load_checked([CASES[case]], ())
    read = {stage.quantities[0] for stage in plan_case(loaded.case) if not stage.is_last}
    read |= {path for path in CATALOGUE if path.startswith("isolation/") and "run_up" in path}
    return run_scene(loaded.case, wanted=frozenset(read | {LARGEST, HIGHEST_ORDER}))


@cache
def measured(case: str, stage: str, name: str) -> Measured:
    scene = scene_of(case)
    (planned,) = (one for one in plan_case(scene.case) if one.name == stage)
    topics = [topic for where in planned.topics for topic in named(where)(scene)]
    return measure(next(one for one in topics if one.ask.name == name), *ONCE)


def trials_of(found: Measured, solver: str) -> list[Trial]:
    return [one for one in found.trials if one.method == solver]


def order_of(found: Measured, solver: str) -> float:
    kind, value = fitted(trials_of(found, solver), found.reference.agreement)
    assert kind == "order", (found.topic.ask.name, solver)
    return value


@pytest.mark.parametrize(
    ("case", "stage", "name", "agreement", "error"),
    [*EVERY, *(pytest.param(*row, marks=LONG) for row in EVERY_LONG)],
)
def test_truths_are_known_and_defaults_are_on_the_front(
    case: str, stage: str, name: str, agreement: float, error: float
) -> None:
    found = measured(case, stage, name)
    ask = found.topic.ask
    assert found.reference.agreement <= agreement
    (default,) = (trial for trial in found.trials if trial.is_default)
    assert default.done and default.worst_relative <= max(error, agreement)
    # as the last bits of a processor may make the noise half as large or twice
    for share in (0.5, 1.0, 2.0):
        assert extra(found.trials, share * found.reference.noise, "work") <= ask.extra
    assert (ask.extra == 1.0) == (ask.why == "")
    assert any(path.startswith(ask.quantity.split(",")[0]) for path in CATALOGUE), ask.quantity
    assert all(trial.done or trial.cause for trial in found.trials)


@pytest.mark.parametrize(
    ("case", "stage", "name", "solver", "order"),
    [
        ("compressor", "excitation", "couple peak", "grid", 2.0),
        ("compressor_motor", "motor", "axial force peak", "grid", 2.0),
        ("generator", "isolation", "largest support force", "grid", 2.0),
        ("generator", "run_up", "largest force of the run-up", "grid", 2.0),
        ("pump", "pump", "torque of the liquid", "numpy.fft of samples", 2.0),
        ("engine_damped", "torsion", "gas torque of a cylinder", "numpy.fft of samples", 2.0),
        ("engine_damped", "torsion", "highest torque over the cycle", "grid", 2.0),
        ("engine_variable_inertia", "torsion_speeds", "largest torque", "grid", 2.0),
        pytest.param(
            "compressor_switching", "switching", "run-down", "scipy DOP853", 1.0, marks=LONG
        ),
    ],
)
def test_ways_show_the_order_of_their_theory(
    case: str, stage: str, name: str, solver: str, order: float
) -> None:
    assert order_of(measured(case, stage, name), solver) == pytest.approx(order, abs=0.3)


def test_series_and_samples_lose_what_the_closed_form_of_harmonics_keeps() -> None:
    found = measured("compressor", "kinematics", "harmonics of the acceleration")
    error = {(trial.method, trial.setting): trial.worst_relative for trial in found.trials}
    # 40 terms, as the source has them, reach order 80 with one term alone
    assert 0.5 < error["truncated series", 40.0] < 1.0
    # rounding of the first harmonic buries the last, 1e-75 of it
    assert error["numpy.fft of samples", 1280.0] > 1e40
    few = trials_of(found, "numpy.fft of samples")[0]
    assert "more than 160 are needed" in few.cause


def test_the_case_that_asks_for_the_cut_series_has_it_as_default() -> None:
    found = measured("generator", "kinematics", "harmonics of the acceleration")
    (default,) = [trial for trial in found.trials if trial.is_default]
    assert default.name == "truncated series | 1"
    # what Gibson's one term lacks of the second harmonic at R / L = .3: 2.3 %
    assert default.worst_relative == pytest.approx(0.0231, abs=5e-4)


def test_a_search_that_would_take_long_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vibecalc.core.accuracy.frame_topics.LONGEST", 1e-6)
    with pytest.raises(NumericalFailure, match="the search would take about"):
        optimisation_topics(load_checked([CASES["four_cylinder"]])[0])


# ----------------------------------------------------------------------------
# Each kind on a question whose answer is known.
# ----------------------------------------------------------------------------

ASK = Ask("question", "words", "path")


def least_sum(place: np.ndarray) -> tuple[float, np.ndarray]:
    """Least x + y with x y >= .25 in the unit square: .5 each."""
    return float(np.sum(place)), np.array([place[0] * place[1] / 0.25 - 1.0])


@pytest.mark.parametrize("method", ["SLSQP", "COBYLA", "differential evolution"])
def test_a_budget_is_kept_and_so_are_limits(method: str) -> None:
    calls = 0

    def evaluate(place: np.ndarray) -> tuple[float, np.ndarray]:
        nonlocal calls
        calls += 1
        return least_sum(place)

    box, first = [(0.0, 1.0)] * 2, np.array([0.9, 0.6])
    value, asked = within_budget(method, evaluate, box, first, 60)
    assert asked == calls <= 60
    # a population of twenty has seen three generations by then, and is only better than its start
    assert 1.0 - 1e-6 < value < (1.5 if method == "differential evolution" else 1.0 + 1e-6)
    with pytest.raises(NumericalFailure, match=f"{method} met no point that keeps all limits in"):
        within_budget(method, lambda at: (float(at[0]), np.array([-1.0])), box, first, 10)


def test_an_optimum_is_confirmed_from_four_digits_of_it() -> None:
    def asked(place: float, value: float) -> float:
        ours = Solver("ours", lambda _: Optimal(np.full(2, place), value, 0.0, 1.0))
        topic = optimum(
            ASK, ours, lambda: least_sum, [(0.0, 1.0)] * 2, np.array([0.9, 0.6]), (60,),
            ("SLSQP",), "evaluations",
        )  # fmt: skip
        return topic.reference().agreement

    assert asked(0.5, 1.0) < 1e-9
    # what is no optimum is not confirmed
    assert asked(0.6, 1.2) > 0.1
