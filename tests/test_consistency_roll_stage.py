"""Claim: the stage hands on what the kernels compute, and every error estimate bounds the error.

Truth of the estimates: the same machine with six Gauss points more on each panel, solved to 1e-12.
"""

import numpy as np
import pytest
from roll_machines import ROTOR, SYNCHRONOUS, source_drive, source_machine

from vibecalc.numerics.level import level_of
from vibecalc.roll.adapters.readings import (
    MachineTurn,
    peaks_of,
)
from vibecalc.roll.mechanism import RollDrive, RollMachine, as_batch
from vibecalc.roll.running import motion_of_state, running_state
from vibecalc.roll.steady import SteadyTurn
from vibecalc.roll.turn import readings


def seen_of(machine: RollMachine, drive: RollDrive, state: SteadyTurn) -> MachineTurn:
    return MachineTurn(machine, drive, state.turn, motion_of_state(machine, drive, state))


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
    levels, uncertainty = level_of(np.array([1.0, 1e-3j]), np.array([1e-2, 1e-2]), reference=1.0)
    assert levels.tolist() == [0.0, -np.inf]
    assert uncertainty[0] == pytest.approx(-20.0 * np.log10(0.99)) and uncertainty[1] == 0.0


@pytest.mark.parametrize("points", [3, 8])
def test_points_of_the_case_are_kept(points: int) -> None:
    machine, drive = as_batch(source_machine()), source_drive()
    running = running_state(
        machine, drive, rtol=1e-10, orders=10, started_at=SYNCHRONOUS, points=points
    )
    assert (running.state.points, running.check.points) == (points, points + 2)
