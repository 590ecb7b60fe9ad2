"""Claim: what is compared for forces, mounts, body, impacts and changes is measured truthfully.

The truths are known to what is stated, each integrator and grid shows the order of its theory,
and no method does the same for much less counted work than the one vibecalc takes.
"""

from functools import cache

import numpy as np
import pytest
from shipped_cases import CASES

from vibecalc.core.accuracy.other_integrators import (
    Signal,
    harmonics_of_samples,
    march_fixed,
    march_scipy,
    peak_topic,
    samples_of_harmonics,
)
from vibecalc.core.accuracy.other_searches import (
    chebyshev_maximum,
    golden_maximum,
    grid_maximum,
    parabola_maximum,
    places_of,
)
from vibecalc.core.accuracy.record import extra_work, fitted
from vibecalc.core.accuracy.topic import Measured, Timed, Topic, measure
from vibecalc.core.results.layout import TRIAL_FAILED
from vibecalc.core.run.plan import plan_case
from vibecalc.core.run.run import run_scene
from vibecalc.core.run.stage import Scene
from vibecalc.core.study.execute import load_checked
from vibecalc.errors import NumericalFailure
from vibecalc.excitation.accuracy import excitation_force_topics, motor_force_topics
from vibecalc.isolation.accuracy.run_up import run_up_curve_topics, run_up_topics
from vibecalc.isolation.accuracy.steady import isolation_steady_topics
from vibecalc.isolation.adapters.common import LARGEST
from vibecalc.kinematics.accuracy import kinematics_harmonics_topics, kinematics_motion_topics
from vibecalc.response.accuracy.forced import response_steady_topics
from vibecalc.response.accuracy.modes import response_modes_topics
from vibecalc.response.accuracy.operations import operations_topics
from vibecalc.response.accuracy.switching import switching_topics

#: module of topics, case that has its stage, and how well the truth is known
MEASURED = (
    ("kinematics_harmonics", "compressor", 1e-25),
    ("kinematics_motion", "compressor", 1e-14),
    ("excitation_force", "compressor", 1e-14),
    ("isolation_steady", "generator", 1e-14),
    ("run_up", "generator", 1e-13),
    ("response_steady", "compressor", 1e-14),
    ("response_modes", "compressor", 1e-20),
    ("operations", "compressor", 1e-13),
    ("motor_force", "compressor_motor", 1e-14),
    ("switching", "compressor_switching", 3e-13),
)
TAKES_LONG = ("switching", "isolation_steady")
TOPICS_OF = {
    "kinematics_harmonics": kinematics_harmonics_topics,
    "kinematics_motion": kinematics_motion_topics,
    "excitation_force": excitation_force_topics,
    "isolation_steady": isolation_steady_topics,
    "run_up": run_up_topics,
    "response_steady": response_steady_topics,
    "response_modes": response_modes_topics,
    "operations": operations_topics,
    "motor_force": motor_force_topics,
    "switching": switching_topics,
    "run_up_curve": run_up_curve_topics,
}
BY_MODULE = {module: case for module, case, _ in MEASURED}


@cache
def scene_of(case: str) -> Scene:
    """A run of what the topics read; stages that only give results are left out."""
    (loaded,) = load_checked([CASES[case]], ())
    read = {stage.quantities[0] for stage in plan_case(loaded.case) if not stage.is_last}
    return run_scene(loaded.case, wanted=frozenset({LARGEST, *read}))


def topics_of(module: str, case: str) -> list[Topic]:
    found = TOPICS_OF[module](scene_of(case))
    assert all(isinstance(topic, Topic) for topic in found)
    return list(found)


@cache
def measured(module: str, case: str) -> tuple[Measured, ...]:
    return tuple(measure(topic, Timed(repeat=False)) for topic in topics_of(module, case))


def one(module: str, name: str, case: str = "") -> Measured:
    found = measured(module, case or BY_MODULE[module])
    return next(each for each in found if each.topic.name == name)


def order_of(found: Measured, solver: str) -> float:
    trials = [trial for trial in found.trials if trial.solver == solver]
    fit = fitted(trials, found.reference.agreement)
    assert fit is not None, f"{found.topic.name}: {solver} shows no order"
    return fit.value


@pytest.mark.parametrize(
    ("module", "case", "bound"),
    [
        pytest.param(*one, marks=[pytest.mark.long] if one[0] in TAKES_LONG else [])
        for one in MEASURED
    ],
)
def test_truths_are_known_and_the_default_is_worth_its_work(
    module: str, case: str, bound: float
) -> None:
    found = measured(module, case)
    assert found
    for each in found:
        assert each.reference.agreement <= bound, each.topic.name
        # as the last bits of a processor may make the noise half as large or twice
        for share in (0.5, 1.0, 2.0):
            trials = [trial._replace(noise=share * trial.noise) for trial in each.trials]
            assert extra_work(each.topic, trials) <= each.topic.default_extra, each.topic.name
        assert (each.topic.default_extra == 1.0) == (each.topic.default_why == "")
        for trial in each.trials:
            assert (trial.status == TRIAL_FAILED) == (trial.cause != "")
            if trial.is_default:
                assert trial.worst_relative <= max(1e-9, each.reference.agreement)


@pytest.mark.parametrize(
    ("module", "name", "solver", "order"),
    [
        ("kinematics_motion", "acceleration over a turn", "differences", 2.0),
        ("excitation_force", "force peak", "grid", 2.0),
        ("excitation_force", "couple peak", "grid with parabola", 4.0),
        ("motor_force", "axial force peak", "grid", 2.0),
        pytest.param(
            "isolation_steady", "largest support force", "RK4 shooting", 4.0, marks=pytest.mark.long
        ),
        ("run_up", "largest forces of the run-up", "grid", 2.0),
        ("response_steady", "translations by order", "RK4 shooting", 4.0),
        ("response_modes", "natural frequencies", "scan of the determinant", 2.0),
        ("operations", "range of the mean energy", "grid", 2.0),
        ("operations", "range of the mean energy", "grid with parabola", 4.0),
        pytest.param("switching", "change at once", "Euler", 1.0, marks=pytest.mark.long),
        pytest.param("switching", "change at once", "RK4", 4.0, marks=pytest.mark.long),
        pytest.param("switching", "run-down", "Euler", 1.0, marks=pytest.mark.long),
        pytest.param("switching", "run-down", "RK4", 4.0, marks=pytest.mark.long),
        pytest.param("switching", "run-down", "DOP853", 1.0, marks=pytest.mark.long),
    ],
)
def test_solvers_show_the_order_of_their_theory(
    module: str, name: str, solver: str, order: float
) -> None:
    assert order_of(one(module, name), solver) == pytest.approx(order, abs=0.3)


def test_series_and_samples_lose_what_the_closed_form_of_harmonics_keeps() -> None:
    found = one("kinematics_harmonics", "harmonics of the acceleration")
    error = {(trial.solver, trial.setting): trial.worst_relative for trial in found.trials}
    assert error["exact harmonics", 1.0] < 1e-14
    # 40 terms, as the source has them, reach order 80 with one term alone
    assert 0.5 < error["truncated series", 40.0] < 1.0
    # rounding of the first harmonic buries the last, 1e-75 of it
    assert error["FFT of samples", 1280.0] > 1e40
    few = next(
        trial for trial in found.trials if (trial.solver, trial.setting) == ("FFT of samples", 8)
    )
    assert few.status == TRIAL_FAILED and "more than 160 are needed" in few.cause


def test_a_start_off_the_peak_is_a_failure_with_its_cause() -> None:
    found = one("motor_force", "axial force peak")
    causes = [trial.cause for trial in found.trials if trial.status == TRIAL_FAILED]
    assert any("leaves the peak" in cause for cause in causes)
    scan = one("response_modes", "natural frequencies")
    causes = [trial.cause for trial in scan.trials if trial.status == TRIAL_FAILED]
    assert any("changes of sign, not 6" in cause for cause in causes)


def test_a_tighter_range_of_peak_energies_takes_more_peaks_and_is_kept() -> None:
    found = one("operations", "range of the peak energy")
    trials = [trial for trial in found.trials if trial.solver == "branch and bound"]
    work = [trial.work for trial in trials]
    assert work == sorted(work) and work[0] < work[-1]
    assert all(trial.worst_relative <= trial.setting for trial in trials)


def test_the_case_that_asks_for_the_cut_series_has_it_as_default() -> None:
    (found,) = measured("kinematics_harmonics", "generator")
    (default,) = [trial for trial in found.trials if trial.is_default]
    assert (default.solver, default.setting) == ("truncated series", 1.0)
    # what Gibson's one term lacks of the second harmonic at R / L = .3: 2.3 %
    assert default.worst_relative == pytest.approx(0.0231, abs=5e-4)


def test_a_circle_has_a_peak_and_no_place() -> None:
    circle = Signal(np.array([[3.0], [3.0j]]), np.array([1]))
    topic = peak_topic("excitation", "circle", "", "excitation/force_peak", "N", circle)
    found = measure(topic, Timed(repeat=False))
    assert topic.position == "" and found.reference.position is None
    assert all(
        trial.worst_relative < 1e-14 for trial in found.trials if trial.status != TRIAL_FAILED
    )
    two = Signal(np.array([[1.0 + 0.0j, 1.0]]), np.array([1, 3]))
    # cos a + cos 3a is largest, 2, at 0 and at half a turn, with the other sign
    known = peak_topic("excitation", "two", "", "excitation/force_peak", "N", two)
    assert known.reference().values == pytest.approx([2.0], rel=1e-15)
    for solver in known.solvers:
        position = solver.solve(solver.settings[-1]).position
        assert position is not None and abs(position) < 1e-3


def test_the_curve_of_a_run_up_is_drawn_from_fewest_speeds() -> None:
    found = one("run_up_curve", "curves of the run-up", "generator")
    # straight lines to a thousandth of the maximum are asked for, and had
    assert found.reference.agreement < 1e-4
    assert extra_work(found.topic, found.trials) == 1.0
    (default,) = [trial for trial in found.trials if trial.is_default]
    assert default.worst_relative < 1e-3
    # nothing even comes as close with as many speeds
    for trial in found.trials:
        if "speeds" in trial.solver and trial.work <= 2.0 * default.work:
            assert trial.worst_relative > 2.0 * default.worst_relative


@pytest.mark.parametrize(("method", "order"), [("euler", 1), ("rk4", 4)])
def test_fixed_steps_on_a_turning_vector(method: str, order: int) -> None:
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])
    errors = []
    for steps in (64, 128, 256):
        run = march_fixed(lambda t, x: turn @ x, np.array([1.0, 0.0]), 0.0, 1.0, steps, method)
        errors.append(float(np.hypot(*(run.states[-1] - [np.cos(1.0), np.sin(1.0)]))))
        assert run.evaluations == steps * (1 if order == 1 else 4)
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(order, abs=0.1)


def test_an_unstable_step_is_refused() -> None:
    with pytest.raises(NumericalFailure, match="unstable"):
        march_fixed(lambda t, x: -1e6 * x, np.ones(1), 0.0, 1.0, 200, "rk4")


def test_scipy_reaches_its_tolerance_or_gives_up() -> None:
    times = np.array([0.0, 0.3, 2.0])
    run = march_scipy(lambda t, x: -x, np.ones(1), times, 1e-12)
    assert run.states[:, 0] == pytest.approx(np.exp(-times), rel=1e-10)
    assert run.evaluations > 20
    with pytest.raises(NumericalFailure, match=r"gave up|double precision"):
        march_scipy(lambda t, x: x * x, np.ones(1), np.array([0.0, 2.0]), 1e-9)


def test_grids_miss_by_a_quarter_step_where_reported_to() -> None:
    places = places_of(0.0, 1.0, 11, peak=0.52)
    assert np.min(np.abs(places - 0.52)) == pytest.approx(0.025)
    assert places[0] >= 0.0 and places[-1] <= 1.0
    parabola = parabola_maximum(lambda x: 3.0 - (x - 0.52) ** 2, 0.0, 1.0, 7)
    assert (parabola.value, parabola.position) == pytest.approx((3.0, 0.52))
    plain = grid_maximum(lambda x: -((x - 0.52) ** 2), 0.0, 1.0, 11)
    assert plain.position == pytest.approx(0.5) and plain.evaluations == 11


def test_two_ways_to_a_smooth_peak_agree_in_the_place() -> None:
    def bell(x: np.ndarray) -> np.ndarray:
        return np.exp(-np.square(x - 0.3)) + 0.1 * x

    # 0.1 = 2 (x - .3) exp(-(x - .3)^2), by its own series
    d = 0.05
    for _ in range(60):
        d = 0.05 * np.exp(d * d)
    golden = golden_maximum(bell, 0.0, 1.0)
    smooth = chebyshev_maximum(bell, 0.4, 0.2, 16)
    assert golden.position == pytest.approx(0.3 + d, abs=1e-7)
    assert smooth.position == pytest.approx(0.3 + d, abs=1e-11)
    with pytest.raises(NumericalFailure, match="no maximum"):
        chebyshev_maximum(lambda x: x, 0.0, 1.0, 4)


def test_samples_and_harmonics_are_inverse_and_fold_when_few() -> None:
    orders = np.array([0, 1, 3])
    harmonics = np.array([2.0, 1.0 - 2.0j, 0.5j])
    back = harmonics_of_samples(samples_of_harmonics(harmonics, orders, 16), 5)
    assert back[orders] == pytest.approx(harmonics, abs=1e-14)
    assert np.abs(back[[2, 4, 5]]).max() < 1e-14
    # order 3 looks like order 1 in four samples
    few = harmonics_of_samples(samples_of_harmonics(harmonics, orders, 4), 1)
    assert few[1] == pytest.approx(harmonics[1] + np.conj(harmonics[2]))
    with pytest.raises(NumericalFailure, match="more than 6 are needed"):
        harmonics_of_samples(np.zeros(6), 3)


@pytest.mark.long
def test_impacts_from_contact_to_contact_against_integrators() -> None:
    found = one("impact", "first contacts", "compressor_impact")
    assert found.reference.agreement < 1e-11
    assert extra_work(found.topic, found.trials) <= found.topic.default_extra
    error = {(trial.solver, trial.setting): trial.worst_relative for trial in found.trials}
    assert error["from contact to contact", 1.0] < 1e-13
    # the kinks cost Runge-Kutta its order: 64 times the steps do not give six digits
    assert 1e-6 < error["RK4", 3072.0] < 1e-3
    assert error["DOP853 with events", 1e-12] < 1e-10


@pytest.mark.long
def test_the_mean_of_an_ensemble_is_known_to_its_standard_error() -> None:
    found = one("impact", "mean force of an ensemble", "compressor_impact")
    # two independent methods differ by less than the scatter of 256 members
    assert found.reference.agreement < 0.05
    assert extra_work(found.topic, found.trials) <= found.topic.default_extra
    most = max((r for r in found.trials if r.solver == "from contact to contact"),
               key=lambda trial: trial.setting)  # fmt: skip
    # four standard errors of 64 members where 256 have the agreement
    assert most.worst_relative < 4.0 * 2.0 * found.reference.agreement


@pytest.mark.long
def test_scatter_of_group_means_falls_with_the_root_of_their_size() -> None:
    from vibecalc.impact.linkage import Starts, spread_starts
    from vibecalc.impact.model import build_joints
    from vibecalc.impact.runs import follow_events

    machine = scene_of("compressor_impact").case.machine
    linkage = build_joints(machine, None).linkage
    clearance, members = np.array([3.81e-5]), 512
    start = spread_starts(linkage, clearance, members)
    flat = Starts(*(part.reshape(-1, part.shape[-1]) for part in start))
    run = follow_events(linkage, np.repeat(clearance, members), flat, 3, 1)
    # in the third turn the starts are forgotten
    force = run.wrist_pin.mean_absolute_force[:, 2]
    shuffled = np.random.default_rng(5).permutation(force)
    sizes = np.array([2, 4, 8, 16, 32])
    scatter = [np.std(shuffled.reshape(-1, size).mean(axis=1)) for size in sizes]
    slope = np.polyfit(np.log(sizes), np.log(scatter), 1)[0]
    assert slope == pytest.approx(-0.5, abs=0.1)
