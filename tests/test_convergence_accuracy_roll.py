"""Claim: the topics of roll, start-up, control and measurement know the truth and the cheapest way.

Of each topic the reference agrees with an independent way, series show the order that theory
says, the default of vibecalc is on the front in counted work (or pays for what it says), and what
fails is named.
"""

from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from shipped_cases import CASES

from vibecalc.core.accuracy.record import extra_work, fitted
from vibecalc.core.accuracy.topic import Measured, Timed, Topic, measure
from vibecalc.core.run.stage import Scene
from vibecalc.core.study.execute import load_checked
from vibecalc.errors import NumericalFailure
from vibecalc.measurement import accuracy as plate_levels
from vibecalc.measurement.accuracy import measurement_topics
from vibecalc.measurement.model import build_harmonics, reference_row
from vibecalc.parts.machine import build_machine
from vibecalc.roll.accuracy.by_other_means import (
    RollSetup,
    departure,
    retrace,
    roll_setup,
    spectrum,
)
from vibecalc.roll.accuracy.control import control_topics
from vibecalc.roll.accuracy.running import roll_topics
from vibecalc.roll.accuracy.start_up import StartPlan, follow, start_up_topics
from vibecalc.roll.mechanism import inertia
from vibecalc.roll.model import build_roll, roll_drive
from vibecalc.roll.start_up_system import FULL_LOAD
from vibecalc.roll.steady import steady_state

ONCE = Timed(repeat=False)
EVERY = (control_topics, measurement_topics, roll_topics, start_up_topics)

PHASORS = """
schema = 1
title = "Four points of a plate with phases"
[machine]
kind = "plate"
[measurement]
amplitude = "zero_to_peak"
phase_step = 1e-6
amplitude_step = 1e-6
orders = [1]
positions = [
  { name = "a", x = 0.0, y = 0.0 },
  { name = "b", x = 1.0, y = 0.0 },
  { name = "c", x = 0.0, y = 1e-3 },
  { name = "d", x = 1.0, y = 1e-3 },
]
readings = [
  { at = "a", amplitude = [1.0], phase = ["0 deg"] },
  { at = "b", amplitude = [1.2], phase = ["90 deg"] },
  { at = "c", amplitude = [1.4], phase = ["20 deg"] },
  { at = "d", amplitude = [1.1], phase = ["120 deg"] },
]
"""


@cache
def scene_of(name: str) -> Scene:
    """A shipped case with its machine; the topics of these stages ask for nothing more."""
    (loaded,) = load_checked([CASES[name]])
    case = loaded.case
    return Scene(case=case, parts=build_machine(case))


@cache
def setup_of(name: str) -> RollSetup:
    return roll_setup(scene_of(name))


def topic_named(found: list[Topic], name: str) -> Topic:
    return next(topic for topic in found if topic.name == name)


def held(topic: Topic, agreement: float) -> Measured:
    """What measuring gives, after the tests that every topic has to pass."""
    found = measure(topic, ONCE)
    assert found.reference.agreement <= agreement, topic.name
    assert extra_work(topic, found.trials) <= topic.default_extra, topic.name
    default = next(trial for trial in found.trials if trial.is_default)
    assert default.done
    for solver in topic.solvers:
        if solver.theory.startswith("order"):
            trials = [trial for trial in found.trials if trial.solver == solver.name]
            fit = fitted(trials, found.reference.agreement)
            if fit is not None:
                wanted = float(solver.theory.split()[1])
                assert fit.value == pytest.approx(wanted, abs=0.3), solver.name
        if solver.theory == "geometric":
            trials = [trial for trial in found.trials if trial.solver == solver.name and trial.done]
            clear = [trial for trial in trials if trial.error > 100.0 * trial.noise]
            ratios = [b.error / a.error for a, b in pairwise(clear)]
            # no level gains less than a third of what its neighbours gain, in digits
            assert len(ratios) >= 2 and max(ratios) < 0.3, solver.name
    return found


def error_of(found: Measured, solver: str, setting: float | None = None) -> float:
    trials = [trial for trial in found.trials if trial.solver == solver]
    return next(r.error for r in trials if setting is None or r.setting == setting)


def test_roll() -> None:
    every = roll_topics(scene_of("roll"))
    found = held(topic_named(every, "spectrum"), 1e-12)
    kinds = {trial.solver for trial in found.trials}
    assert len(kinds) == 11
    default = next(trial for trial in found.trials if trial.is_default)
    assert default.error <= 1e-12
    # the published program, at its own step
    published = error_of(found, "Euler, as published", 5e-4)
    assert 0.03 < published < 0.2
    # nothing blind to kinks comes within a thousand errors of the default
    blind = ("Fourier", "shooting", "not split", "Runge", "scipy", "quick")
    least = min(r.error for r in found.trials if any(word in r.solver for word in blind))
    assert least > 1e3 * default.error


def test_largest_slip() -> None:
    """Looks stop where closer ones would tell no more, not where one finds the last place again."""
    found = held(topic_named(roll_topics(scene_of("roll")), "largest slip"), 1e-12)
    assert error_of(found, "closer and closer looks") <= 1e-12


def test_march_of_a_turn_tells_a_wrong_state() -> None:
    setup = setup_of("roll")
    # the march shares the quadrature of the state, and sees the error of the state alone
    for points, least, most in ((3, 1e-8, 1e-5), (14, 0.0, 1e-12)):
        found = steady_state(setup.machine, setup.drive, points, started_at=setup.started_at)
        again = retrace(setup, found)
        values = spectrum(setup, found.turn)
        off = float(np.max(np.abs(again.values - values)) / np.max(np.abs(values)))
        assert least <= max(off, again.gap) <= most


def test_steps_of_all_panels_tell_a_wrong_state() -> None:
    setup = setup_of("roll")
    found = steady_state(setup.machine, setup.drive, 14, started_at=setup.started_at)
    assert departure(setup, found) < 1e-11
    left = found.solution.left.copy()
    left[0, 5] *= 1.0 + 1e-8
    moved = found._replace(solution=found.solution._replace(left=left))
    assert departure(setup, moved) > 1e-9


@pytest.mark.long
def test_start_up() -> None:
    found = held(topic_named(start_up_topics(scene_of("roll_startup")), "motion"), 1e-11)
    # a change of load within a step leaves the order one to methods that do not look
    trials = [trial for trial in found.trials if trial.solver == "Runge-Kutta"]
    fit = fitted(trials, found.reference.agreement)
    assert fit is not None and fit.value == pytest.approx(1.0, abs=0.3)
    marched = [r.error for r in found.trials if r.solver.startswith("one march")]
    assert all(after < before for before, after in pairwise(marched))


@pytest.mark.long
def test_implicit_steps_of_the_closed_loop() -> None:
    """A tolerance ten times closer brings an error at least five times smaller."""
    every = control_topics(scene_of("roll_control"))
    found = held(topic_named(every, "closed loop"), 1e-14)
    errors = [trial.error for trial in found.trials if "Radau" in trial.solver]
    assert len(errors) == 3
    assert all(after < 0.2 * before for before, after in pairwise(errors))


@pytest.mark.long
def test_shaking_of_a_start() -> None:
    for name in ("roll_startup", "roll_mounted"):
        for topic in start_up_topics(scene_of(name)):
            held(topic, 1e-10)


def test_reference_of_a_start_keeps_the_angular_momentum() -> None:
    parts = build_roll(scene_of("roll").case)
    start = np.array([0.3, 80.0, 0.0, 0.5])
    plan = StartPlan(parts.machine, roll_drive(parts), FULL_LOAD, start, 0.02)
    end = follow(plan).state

    def momentum(state: np.ndarray) -> float:
        moved = inertia(parts.machine, state[:1])
        return float(moved.shell[0] * state[3] + moved.coupling[0] * state[1])

    assert momentum(end) == pytest.approx(momentum(start), rel=1e-12)
    assert end[0] > start[0] + 1.0


def test_a_crank_with_friction_that_comes_to_rest_is_not_followed() -> None:
    parts = build_roll(scene_of("roll").case)
    machine = parts.machine._replace(friction_torque=np.asarray(5000.0))
    plan = StartPlan(machine, roll_drive(parts), FULL_LOAD, np.array([0.3, 20.0, 0.0, 0.0]), 0.1)
    with pytest.raises(NumericalFailure, match="comes to rest"):
        follow(plan)


@pytest.mark.long
def test_control() -> None:
    every = control_topics(scene_of("roll_control"))
    assert [topic.name for topic in every] == ["load", "closed loop", "delay margin", "poles"]
    load = held(every[0], 1e-14)
    # more angles do not mend a stroke that is cut short
    assert error_of(load, "sums with the two-term stroke", 3600.0) > 1e-3
    # implicit steps take long and are left to the long tests
    quick = [solver for solver in every[1].solvers if "scipy" not in solver.name]
    loop = held(every[1]._replace(solvers=tuple(quick)), 1e-14)
    unstable = [trial for trial in loop.trials if not trial.done]
    assert [trial.setting for trial in unstable] == [256.0]
    assert "unstable" in unstable[0].cause
    margin = held(every[2], 1e-14)
    assert error_of(margin, "closed form") <= 1e-13
    poles = held(every[3], 1e-14)
    assert error_of(poles, "stable closed form") <= 1e-13


@pytest.mark.parametrize(
    "without", ["least squares, closer", pytest.param("", marks=pytest.mark.long)]
)
def test_measurement_from_levels(without: str) -> None:
    (topic,) = measurement_topics(scene_of("roll_measured"))
    solvers = tuple(solver for solver in topic.solvers if solver.name != without)
    found = held(topic._replace(solvers=solvers), 1e-14)
    assert error_of(found, "second moments") <= 1e-13
    # the source's own cosines are as good where its readings are given
    assert error_of(found, "phases by cosines") <= 1e-13
    # a single start may end in the other motion that the levels leave
    assert error_of(found, "least squares, more starts", 1.0) > 0.1
    assert error_of(found, "least squares, more starts", 8.0) < 1e-6


def test_levels_without_a_motion_are_refused_by_cosines() -> None:
    table = scene_of("roll_measured").case.measurement
    assert table is not None
    given = plate_levels.levels_of(build_harmonics(table)[0], reference_row(table))
    louder = given.amplitudes * np.where(given.rows[:, 0] == 0.0, 10.0, 1.0)
    with pytest.raises(NumericalFailure, match="no plate moves so"):
        plate_levels.by_cosines(given._replace(amplitudes=louder))
    one = given._replace(rows=given.rows[::-1])
    assert plate_levels.suits_cosines(one)
    assert not plate_levels.suits_cosines(given._replace(rows=given.rows[:4]))


def test_measurement_from_phasors(tmp_path: Path) -> None:
    """Points in a narrow strip, a condition of some thousand: so many roundings may be lost."""
    path = tmp_path / "phasors.toml"
    path.write_text(PHASORS, encoding="utf-8")
    (loaded,) = load_checked([path])
    case = loaded.case
    scene = Scene(case=case, parts=build_machine(case))
    (topic,) = measurement_topics(scene)
    found = held(topic, 1e-14)
    assert error_of(found, "singular values") <= 1e-12
    assert error_of(found, "numpy.linalg.lstsq") <= 1e-12


def test_cases_without_these_stages_have_no_such_topics() -> None:
    for topics in EVERY:
        assert topics(scene_of("generator")) == []


@pytest.mark.long
@pytest.mark.parametrize(
    "name", ["roll_equal_pressure", "roll_balanced", "roll_dynamic_motor", "roll_mounted"]
)
def test_other_machines_that_roll(name: str) -> None:
    for topic in roll_topics(scene_of(name)):
        held(topic, 1e-12)
