"""Claim: of a free machine the fastest running state is found, or it is said that there is none.

Truth: marching down from above, which cannot pass a periodic motion; laws of scale and of turning.
"""

import re

import numpy as np
import pytest
from roll_machines import RADIUS, RPM, SYNCHRONOUS, source_drive, source_machine

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.slip_torque import slip_curve
from vibecalc.numerics.periodic.other_methods import march_turns
from vibecalc.numerics.periodic.panels import constant_start
from vibecalc.roll.mechanism import RollDrive, RollMachine, as_batch
from vibecalc.roll.rates import roll_problem, surely_fastest
from vibecalc.roll.running import running_state
from vibecalc.roll.steady import SteadyTurn, started_momentum, steady_state

#: by what the march, with three points on half panels and kinks passed over, may be off
COARSE = 2e-3


def random_machine(random: np.random.Generator) -> tuple[RollMachine, RollDrive]:
    """Anything from a light load to beyond breakdown; table and curve read in any way."""
    machine = source_machine(
        gas_scale=random.uniform(0.2, 3.4) * random.uniform(0.7, 1.3, 2),
        rotor_inertia=10.0 ** random.uniform(-1.3, 1.0),
        shell_inertia=10.0 ** random.uniform(0.0, 2.5),
        reciprocating_mass=random.uniform(1.0, 20.0, 2),
        rod_length=RADIUS / random.uniform(0.1, 0.9),
        wrist_pin_offset=random.choice([0.0, 0.003]),
        crank_angle_offset=[0.0, random.choice([np.pi, 0.5 * np.pi, 1.0])],
        friction_torque=random.choice([0.0, 20.0]),
        friction_damping=random.choice([0.0, 0.3]),
        piston_friction=random.choice([0.0, 200.0]),
        motor_scale=random.uniform(0.7, 1.3),
    )
    gas = str(random.choice(["linear", "parabola", "cubic"]))
    motor = str(random.choice(["linear", "parabola", "monotone"]))
    return as_batch(machine), source_drive(gas, motor, holds=True)


def from_above(machine: RollMachine, drive: RollDrive) -> float | None:
    """Crank speed at angle zero to which a march comes down; None if it stalls."""
    problem, rates = roll_problem(machine, drive, started_momentum(machine, SYNCHRONOUS))
    edges = np.sort(np.concatenate([problem.edges, 0.5 * (problem.edges[1:] + problem.edges[:-1])]))
    march = march_turns(
        rates, edges, np.array([1.5 * SYNCHRONOUS]), floor=1e-3 * SYNCHRONOUS, most_turns=400
    )
    assert march.converged[0] or march.stalled[0]
    return float(march.path[0, 0]) if march.converged[0] else None


def compare(machine: RollMachine, drive: RollDrive) -> str:
    """What the running state is, held against the march: "runs", "stalls" or "demand"."""
    lowest = from_above(machine, drive)
    try:
        running = running_state(machine, drive, rtol=1e-7, orders=10, started_at=SYNCHRONOUS)
    except NumericalFailure as failure:
        assert lowest is None
        words = str(failure)
        assert words.startswith("roll: no running state exists: ")
        if "from any speed the machine comes to a standstill" in words:
            return "stalls"
        asked, most = map(float, re.findall(r"([\d.]+) N\*m", words))
        assert asked > most
        return "demand"
    assert lowest == pytest.approx(float(running.state.solution.left[0, 0, 0]), rel=COARSE)
    return "runs"


def some(count: int, seed: int) -> set[str]:
    random = np.random.default_rng(seed)
    return {compare(*random_machine(random)) for _ in range(count)}


@pytest.mark.long
@pytest.mark.parametrize("seed", range(2, 10))
def test_many_states_are_where_marches_from_above_end(seed: int) -> None:
    assert some(200, seed) == {"runs", "stalls", "demand"}


def humped() -> RollDrive:
    """A motor that has a second peak far down, so that it can run at two speeds."""
    slip, torque = [0, 60, 110, 300, 500, 700, 880], [0, 700, 1000, 500, 1100, 1300, 1200]
    return source_drive()._replace(
        motor=slip_curve(np.array(slip) * RPM, np.array(torque, dtype=float), "monotone"),
        holds=True,
    )


def begun_at(machine: RollMachine, drive: RollDrive, speed: float) -> SteadyTurn:
    first = steady_state(machine, drive, 6, started_at=SYNCHRONOUS)
    solution = constant_start(first.problem, 6, np.array([[speed]]))
    return steady_state(
        machine, drive, 6, started_at=SYNCHRONOUS, start=first._replace(solution=solution)
    )


@pytest.mark.parametrize("scale", [2.0, 2.5])
def test_a_slower_state_is_not_taken_for_the_running_state(scale: float) -> None:
    machine, drive = as_batch(source_machine(gas_scale=[scale, scale])), humped()
    slow = begun_at(machine, drive, 300.0 * RPM)
    assert slow.solved[0] and not surely_fastest(machine, drive, slow.turn)[0]
    running = running_state(machine, drive, rtol=1e-9, orders=10, started_at=SYNCHRONOUS)
    fast = running.state.turn
    assert np.min(fast.crank_speed) > np.max(slow.turn.crank_speed)
    assert float(fast.period[0]) < 0.7 * float(slow.turn.period[0])
