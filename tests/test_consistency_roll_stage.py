"""Claim: the stage hands on what the kernels compute, and every error estimate bounds the error.

Truth of the estimates: the same machine with six Gauss points more on each panel, solved to 1e-12.
"""

import numpy as np
import pytest
from roll_machines import ROTOR, SYNCHRONOUS, source_drive, source_machine
from shipped_cases import CASES, fresh

from vibecalc.core.study.execute import load_checked
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.level import level_of
from vibecalc.roll.adapters.readings import (
    MachineTurn,
    TurnSolutions,
    numbers_of,
    peaks_of,
    spectra_of,
)
from vibecalc.roll.mechanism import RollDrive, RollMachine, as_batch
from vibecalc.roll.model import build_roll, roll_drive
from vibecalc.roll.results import FORCES, ROLL, VARIABLES
from vibecalc.roll.running import motion_of_state, running_state
from vibecalc.roll.steady import SteadyTurn, steady_state
from vibecalc.roll.turn import by_cylinder, harmonics, readings

ORDERS = np.arange(1, 11)


def seen_of(machine: RollMachine, drive: RollDrive, state: SteadyTurn) -> MachineTurn:
    return MachineTurn(machine, drive, state.turn, motion_of_state(machine, drive, state))


@pytest.mark.parametrize("name", ["roll", pytest.param("roll_mounted", marks=pytest.mark.long)])
def test_results_are_those_of_the_kernels(name: str) -> None:
    result = fresh(name)
    (loaded,) = load_checked([CASES[name]])
    roll = loaded.case.response.roll
    parts = build_roll(loaded.case)
    machine, drive = as_batch(parts.machine), roll_drive(parts)
    running = running_state(
        machine,
        drive,
        rtol=loaded.case.accuracy.rtol,
        orders=roll.orders,
        started_at=roll.started_at,
    )
    turn = running.state.turn
    read = readings(machine, drive, turn)
    for variable in (*VARIABLES, *FORCES):
        values = np.asarray(getattr(read, variable))
        by_order = harmonics if variable in VARIABLES else by_cylinder
        found = result.record[f"{ROLL}/{variable}"]
        np.testing.assert_array_equal(found.values, by_order(turn, values, ORDERS)[0])
        levels, uncertainty = level_of(
            Bounded(found.values, np.asarray(found.error_estimate)), reference=1.0
        )
        shown = result.record[f"{ROLL}/level/{variable}"]
        # where a harmonic is zero within its error both say so
        there = np.isfinite(shown.values) & np.isfinite(levels)
        np.testing.assert_allclose(shown.values[there], levels[there], rtol=1e-14)
        lag = result.record[f"{ROLL}/phase_lag/{variable}"].values[there]
        turned = found.values[there] * np.exp(1j * lag)
        np.testing.assert_allclose(turned, np.abs(found.values)[there], rtol=1e-12)
        assert uncertainty.shape == levels.shape
    speed = result.record[f"{ROLL}/speed"]
    assert float(speed.values) == pytest.approx(2.0 * np.pi / float(turn.period[0]), rel=1e-15)
    multiplier = result.record[f"{ROLL}/multiplier"]
    np.testing.assert_array_equal(multiplier.values, running.multiplier[0])
    trivial = int(result.record[f"{ROLL}/trivial_multipliers"].values)
    assert trivial + len(multiplier.values) == 4


def random_machine(random: np.random.Generator) -> tuple[RollMachine, RollDrive]:
    mounted = random.random() < 0.3
    machine = source_machine(
        gas_scale=random.uniform(0.3, 1.4, 2),
        rotor_inertia=ROTOR * 10.0 ** random.uniform(-0.2, 1.0),
        shell_inertia=10.0 ** random.uniform(0.7, 2.5),
        rod_length=random.uniform(0.08, 0.6),
        wrist_pin_offset=random.choice([0.0, 0.005]),
        crank_angle_offset=[0.0, random.choice([np.pi, 0.5 * np.pi])],
        friction_damping=random.choice([0.0, 0.3]),
        piston_friction=random.choice([0.0, 100.0]),
        shell_stiffness=3e5 if mounted else 0.0,
        shell_damping=2e3 if mounted else 0.0,
    )
    drive = source_drive(
        str(random.choice(["linear", "parabola", "cubic", "trigonometric"])),
        str(random.choice(["linear", "parabola", "monotone"])),
        holds=True,
    )
    return as_batch(machine), drive


@pytest.mark.parametrize(
    ("rtol", "count"),
    [
        (1e-4, 2),
        (1e-10, 2),
        pytest.param(1e-4, 10, marks=pytest.mark.long),
        pytest.param(1e-10, 20, marks=pytest.mark.long),
    ],
)
def test_estimates_bound_the_error_of_random_machines(rtol: float, count: int) -> None:
    random = np.random.default_rng(count)
    shares = []
    for _ in range(count):
        machine, drive = random_machine(random)
        running = running_state(machine, drive, rtol=rtol, orders=10)
        own, other = (seen_of(machine, drive, s) for s in (running.state, running.check))
        better = steady_state(
            machine, drive, running.state.points + 6, start=running.state, tolerance=1e-13
        )
        assert better.solved[0]
        truth = seen_of(machine, drive, better)
        solutions = TurnSolutions(own, other)
        exact, coarse = spectra_of(truth, 10), spectra_of(other, 10)
        for name, (values, rounding) in spectra_of(own, 10).items():
            error = solutions.error(values, coarse[name][0]) + rounding
            # one number stands for a dataset: its largest
            missed = np.abs(values - exact[name][0])
            assert np.max(missed) <= np.max(error) + exact[name][1], (name, machine)
            if name == "shell_acceleration":
                shares.append(np.max(missed) / np.max(np.abs(values)))
        for name, number in numbers_of(own).items():
            finer, coarser = (numbers_of(s)[name] for s in (truth, other))
            uncertainty = abs(number.value - coarser.value) + 64.0 * 2.0**-52 * number.size
            uncertainty += number.error
            assert abs(number.value - finer.value) <= uncertainty + 64.0 * 2.0**-52 * number.size, (
                name
            )
    # what is asked for is kept, too
    assert max(shares) < rtol


def test_peaks_are_no_lower_than_any_value_of_the_turn() -> None:
    random = np.random.default_rng(8)
    for _ in range(2):
        machine, drive = random_machine(random)
        running = running_state(machine, drive, rtol=1e-8, orders=10)
        seen = seen_of(machine, drive, running.state)
        angles = np.linspace(0.0, 2.0 * np.pi, 20001)
        read = readings(machine, drive, seen.motion(angles))
        for name, (tops, left) in peaks_of(seen).items():
            dense = np.abs(np.asarray(getattr(read, name))[0]).max(axis=0)
            assert np.all(tops + left >= dense * (1.0 - 1e-9))
            assert np.all(tops <= dense * (1.0 + 1e-4))


def test_levels_below_their_error_are_zero() -> None:
    levels, uncertainty = level_of(
        Bounded(np.array([1.0, 1e-3j]), np.array([1e-2, 1e-2])), reference=1.0
    )
    assert levels.tolist() == [0.0, -np.inf]
    assert uncertainty[0] == pytest.approx(-20.0 * np.log10(0.99)) and uncertainty[1] == 0.0


@pytest.mark.parametrize("points", [3, 8])
def test_points_of_the_case_are_kept(points: int) -> None:
    machine, drive = as_batch(source_machine()), source_drive()
    running = running_state(
        machine, drive, rtol=1e-10, orders=10, started_at=SYNCHRONOUS, points=points
    )
    assert (running.state.points, running.check.points) == (points, points + 2)
