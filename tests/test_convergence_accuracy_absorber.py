"""Claim: the topics of tuning, absorber, pendulum, hardware, optimisation and find hold.

References agree with closed forms, methods converge as their theory says, what vibecalc takes is on
the front of error against counted work, and what fails says why.
"""

import math
from functools import cache

import numpy as np
import pytest
from long_but import long_but
from shipped_cases import CASES

from vibecalc.absorber.accuracy.by_other_means import (
    Question,
    System,
    first_place,
    grid_of,
    highest_peak,
    least_highest_peak,
    magnitude,
)
from vibecalc.absorber.accuracy.curves import absorber_curves_topics as curves_topics
from vibecalc.absorber.accuracy.hardware import absorber_parts_topics as parts_topics
from vibecalc.absorber.accuracy.pendulum import absorber_pendulum_topics as pendulum_topics
from vibecalc.absorber.accuracy.tuning import absorber_tuning_topics as tuning_topics
from vibecalc.absorber.tuning.closed_forms import nishihara_asami
from vibecalc.core.accuracy import frame_topics as find
from vibecalc.core.accuracy.frame_topics import find_topics as find_study_topics
from vibecalc.core.accuracy.frame_topics import optimisation_topics as optimisation_study_topics
from vibecalc.core.accuracy.other_searches import nelder_mead, within_budget
from vibecalc.core.accuracy.record import extra_work, fitted
from vibecalc.core.accuracy.topic import Measured, Timed, Topic, Trial, measure
from vibecalc.core.run.run import run_scene
from vibecalc.core.study.execute import load_checked
from vibecalc.errors import NumericalFailure

ONCE = Timed(longest=20.0, repeat=False)
#: relative error that every default reaches, unless a test says otherwise
ROUNDING = 2e-14
SCENES = {
    "absorber_rig_a": (tuning_topics, curves_topics, parts_topics),
    "absorber_pendulum": (pendulum_topics,),
}
#: what makes their runs short and leaves the topics as they are
SHORT = {
    "absorber_rig_a": (
        "tuning.temperatures.points=2",
        "tuning.sensitivity=false",
        "tuning.mistuning=[]",
        "response.absorber.frequencies.points=11",
    ),
    "absorber_pendulum": ("machine.pendulum.swings.points=7",),
}
LONG_SCENES = {
    "absorber": (tuning_topics, curves_topics),
    "absorber_curves": (curves_topics,),
    "absorber_damped": (curves_topics,),
    "absorber_design_chart": (tuning_topics,),
    "absorber_mass": (curves_topics,),
    "absorber_rig_a": SCENES["absorber_rig_a"],
    "absorber_rig_b": (tuning_topics, curves_topics, parts_topics),
    "absorber_two": (tuning_topics, curves_topics),
}


@cache
def measured_of(case: str, whole: bool = False) -> dict[str, Measured]:
    """Every topic of a case; unless `whole`, a shorter run of it without the slowest ways."""
    (loaded,) = load_checked([CASES[case]], () if whole else SHORT[case])
    scene = run_scene(loaded.case)
    topics = [t for topics_of in (SCENES | LONG_SCENES)[case] for t in topics_of(scene)]
    if not whole:
        for slow in ("differential evolution", "Nelder-Mead", "shooting"):
            topics = [without(topic, slow) for topic in topics]
    return {topic.name: measure(topic, ONCE) for topic in topics}


def without(topic: Topic, start: str) -> Topic:
    return topic._replace(
        solvers=tuple(one for one in topic.solvers if not one.name.startswith(start))
    )


def trials_of(found: Measured, start: str) -> list[Trial]:
    trials = [trial for trial in found.trials if trial.solver.startswith(start)]
    assert trials, start
    return trials


def default_of(found: Measured) -> Trial:
    (trial,) = [trial for trial in found.trials if trial.is_default]
    return trial


def holds(found: Measured, accurate: float = ROUNDING) -> None:
    """Reference, default and front of one topic."""
    assert found.reference.agreement < 1e-12, found.topic.name
    default = default_of(found)
    assert default.done and default.worst_relative < accurate, (found.topic.name, default)
    extra = extra_work(found.topic, found.trials)
    assert extra <= found.topic.default_extra, (found.topic.name, extra)
    assert all(trial.done or trial.cause for trial in found.trials)


def order_of(found: Measured, start: str) -> float:
    fit = fitted(trials_of(found, start), found.reference.agreement)
    assert fit is not None and fit.kind == "order", fit
    return fit.value


@pytest.mark.parametrize("case", long_but(SCENES, "absorber_rig_a"))
def test_default_methods_are_accurate_and_on_the_front(case: str) -> None:
    for found in measured_of(case).values():
        holds(found)


@pytest.mark.long
@pytest.mark.parametrize("case", LONG_SCENES)
def test_so_they_are_in_the_other_cases(case: str) -> None:
    topics = measured_of(case, whole=True)
    assert topics
    for name, found in topics.items():
        # ratios of several absorbers are known to half the digits of what they hold level
        holds(found, 1e-10 if (case, name) == ("absorber_two", "tuning") else ROUNDING)


def test_every_module_has_topics() -> None:
    assert set(measured_of("absorber_rig_a")) == {
        "least peak", "tuning", "highest peak", "peaks of the family",
        "lowest bending frequency", "damping of the gap",
    }  # fmt: skip
    assert set(measured_of("absorber_pendulum")) == {"order of swing", "torque of a steady swing"}


@pytest.mark.parametrize(("case", "topic", "solver", "order"), [
    ("absorber_rig_a", "lowest bending frequency", "beam elements", 4.0),
    ("absorber_rig_a", "damping of the gap", "midpoint sums", 2.0),
    ("absorber_pendulum", "order of swing", "midpoint rule in the angle", 0.5),
])  # fmt: skip
def test_solvers_show_their_order(case: str, topic: str, solver: str, order: float) -> None:
    found = measured_of(case)[topic]
    (theory,) = [one.theory for one in found.topic.solvers if one.name == solver]
    assert theory == f"order {order:g}"
    assert order_of(found, solver) == pytest.approx(order, abs=0.3)


def test_sines_of_a_steady_swing_converge_geometrically() -> None:
    trials = trials_of(measured_of("absorber_pendulum")["torque of a steady swing"], "sines")
    errors = {trial.setting: trial.worst_relative for trial in trials}
    # from 2 to 4 some four digits, from 4 to 8 twice as many or round-off
    first = math.log10(errors[2.0] / errors[4.0])
    assert first > 3.0
    assert errors[8.0] < max(errors[4.0] * 10.0 ** (-1.5 * first), 1e-14)


def test_a_difference_of_like_numbers_costs_digits_that_the_default_keeps() -> None:
    found = measured_of("absorber_pendulum")["order of swing"]
    plain = min(trial.worst_relative for trial in trials_of(found, "midpoint rule in u"))
    assert plain > 100.0 * default_of(found).worst_relative


def test_the_grid_of_the_source_ends_above_the_least_peak() -> None:
    found = measured_of("absorber_rig_a")["least peak"]
    finest = trials_of(found, "grid")[-1]
    assert finest.setting == 0.001
    assert finest.worst_relative > 1e-4
    assert finest.work > 100.0 * default_of(found).work


def test_a_grid_misses_a_peak_by_no_more_than_its_curvature_allows() -> None:
    # the absorber fastened rigidly: one mass, one peak
    system = System(0.1, (0.1,), (math.inf,), (0.0,), (0,))
    truth = highest_peak(system, 0.94)
    x, step = truth.place[0], 1e-3
    low, mid, high = magnitude(system, np.array([x - step, x, x + step]))
    bend = abs(low - 2.0 * mid + high) / step**2
    for spacing in (0.02, 0.005, 0.001):
        places = np.arange(0.5, 1.5, spacing)
        missed = truth.value - float(np.max(magnitude(system, places)))
        assert 0.0 <= missed <= 1.05 * bend * (0.5 * spacing) ** 2 / 2.0


def tops_of(system: System) -> list[float]:
    """Frequency ratios of the maxima on a grid of .001."""
    x = np.arange(1.0, 2000.0) / 1000.0
    curve = magnitude(system, x)
    inner = (curve[1:-1] > curve[:-2]) & (curve[1:-1] > curve[2:])
    return [float(place) for place in x[1:-1][inner]]


def test_many_digits_agree_with_closed_forms() -> None:
    for mass in (0.01, 1.0):
        k, z2, peak = (float(part) for part in nishihara_asami(np.asarray(mass)))
        start = System(0.0, (mass,), (float(f"{k:.3e}"),), (float(f"{z2:.3e}"),), (0,))
        found = least_highest_peak(start, True, tops_of(start), (0.5, 0.5))
        assert found.value == pytest.approx(peak, rel=1e-15)
        assert found.place == pytest.approx((k, z2), rel=1e-14)
    # fastened rigidly: one mass 1 + m with the damping ratio z1 / sqrt(1 + m)
    ratio = 0.1 / math.sqrt(1.25)
    lone = highest_peak(System(0.1, (0.25,), (math.inf,), (0.0,), (0,)), 0.89)
    scale = 2.0 * ratio * math.sqrt(1.0 - ratio**2)
    assert lone.value == pytest.approx(1.0 / scale, rel=1e-15)
    assert lone.place[0] == pytest.approx(math.sqrt((1.0 - 2.0 * ratio**2) / 1.25), rel=1e-14)


def test_a_peak_that_is_not_there_is_refused() -> None:
    with pytest.raises(NumericalFailure, match="no peak near the frequency ratio 3"):
        highest_peak(System(0.1, (0.1,), (0.08,), (0.02,), (0,)), 3.0)


def test_a_grid_without_a_point_is_refused() -> None:
    question = Question(System(0.0, (0.1,), (0.08,), (0.02,), (0,)), True)
    assert np.all(np.isfinite(first_place(question)))
    with pytest.raises(NumericalFailure, match=r"a grid of 0\.5 has no point near"):
        grid_of(question, 0.5)


def test_searches_count_and_keep_the_best_point() -> None:
    calls: list[float] = []

    def bowl(place: np.ndarray) -> float:
        calls.append(float(np.sum((place - 0.3) ** 2)))
        return calls[-1]

    found = nelder_mead(bowl, np.array([0.0, 1.0]), 1e-6)
    assert found.evaluations == len(calls)
    assert found.value == min(calls) < 1e-10
    assert found.place == pytest.approx([0.3, 0.3], abs=1e-5)


@pytest.mark.parametrize("method", ["SLSQP", "COBYLA", "differential evolution"])
def test_a_budget_is_kept_and_so_are_limits(method: str) -> None:
    """Least x + y with x y >= .25 in the unit square: .5 each."""
    calls = 0

    def evaluate(place: np.ndarray) -> tuple[float, np.ndarray]:
        nonlocal calls
        calls += 1
        return float(np.sum(place)), np.array([place[0] * place[1] / 0.25 - 1.0])

    box, first = [(0.0, 1.0)] * 2, np.array([0.9, 0.6])
    found = within_budget(method, evaluate, box, first, 60)
    assert found.evaluations == calls <= 60
    # a population of twenty has seen three generations by then, and is only better than its start
    assert 1.0 - 1e-6 < found.value < (1.5 if method == "differential evolution" else 1.0 + 1e-6)
    with pytest.raises(NumericalFailure, match=f"{method} met no point that keeps all limits in"):
        within_budget(method, lambda at: (float(at[0]), np.array([-1.0])), box, first, 10)


def some_of(topic: Topic, *starts: str) -> Topic:
    return topic._replace(
        solvers=tuple(one for one in topic.solvers if one.name.startswith(starts))
    )


@pytest.mark.long
def test_an_optimum_with_fewer_starts() -> None:
    (loaded,) = load_checked([CASES["four_cylinder"]], ["optimisation.starts=1"])
    (topic,) = optimisation_study_topics(loaded)
    own, plain = some_of(topic, "sequential quadratic programming, refined", "SLSQP of").solvers
    few = own, plain._replace(settings=plain.settings[-1:])
    found = measure(topic._replace(solvers=few), ONCE)
    holds(found)
    assert default_of(found).position_error == pytest.approx(0.0, abs=1e-12)
    # phases have no ends, so that one search from the case as written gets there, too
    alone = trials_of(found, "SLSQP of")[-1]
    assert alone.worst_relative < 1e-9 and alone.work < default_of(found).work


@pytest.mark.long
def test_a_search_along_a_key_with_a_coarser_look() -> None:
    (loaded,) = load_checked([CASES["roll_design"]], ["find[0].points=5"])
    (topic,) = find_study_topics(loaded)
    own, plain = some_of(topic, "look", "Brent").solvers
    few = own, plain._replace(settings=plain.settings[::3])
    found = measure(topic._replace(solvers=few), ONCE)
    holds(found)
    errors = [trial.worst_relative for trial in trials_of(found, "Brent's method of scipy")]
    assert errors == sorted(errors, reverse=True) and errors[-1] < 1e-12


def test_a_search_from_bounds_on_one_side_is_refused() -> None:
    with pytest.raises(NumericalFailure, match="both bounds are on the same side"):
        find._bisection(lambda key: key + 1.0, 0.0, 1.0, 4.0)
    with pytest.raises(NumericalFailure, match="none of 4 runs is on the other side"):
        find._line(lambda key: key + 1.0, 0.0, 1.0, 4.0)


@pytest.mark.long
@pytest.mark.parametrize("case", ["four_cylinder", "generator_mount_design", "compressor_balance"])
def test_optima_of_the_shipped_cases(case: str) -> None:
    (loaded,) = load_checked([CASES[case]])
    (topic,) = optimisation_study_topics(loaded)
    holds(measure(topic, ONCE))


@pytest.mark.long
@pytest.mark.parametrize("case", ["roll_design", "roll_mounted"])
def test_searches_of_the_shipped_cases(case: str) -> None:
    (loaded,) = load_checked([CASES[case]])
    (topic,) = find_study_topics(loaded)
    found = measure(topic, ONCE)
    holds(found, 1e-12)
    assert found.topic.unit
