"""Claim: the running state with a motor in time is the motion that its equations lead to.

Truth: the equations in time with complex fluxes, marched by DOP853 until they repeat; differences
for derivatives; the monodromy matrix; power.
"""

import functools
import re
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from long_but import long_but
from roll_machines import RPM, SYNCHRONOUS, columns, source_drive, source_machine
from scipy.integrate import solve_ivp

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.induction_motor import InductionMotor
from vibecalc.excitation.induction_motor_fit import MotorFit, fit_induction_motor
from vibecalc.excitation.induction_motor_flux import CircuitMotor, circuit_motor, power_flow
from vibecalc.numerics.periodic.panels import evaluate
from vibecalc.numerics.rounding import FloatArray
from vibecalc.roll.mechanism import (
    RollDrive,
    RollMachine,
    as_batch,
    gas_forces,
    gas_torque,
    inertia,
    is_mounted,
    place_at,
)
from vibecalc.roll.rates import roll_problem
from vibecalc.roll.running import Running, running_state
from vibecalc.roll.turn import balance, readings

MOUNTS = {"shell_stiffness": 5e4, "shell_damping": 400.0}
FRICTION = {"friction_torque": 3.0, "friction_damping": 0.2, "piston_friction": 20.0}


def source_fit(cages: int) -> MotorFit:
    """The source's motor, with the stator resistance that the shipped case has."""
    slip, torque = columns("roll_motor.csv")
    return fit_induction_motor(
        slip * RPM,
        torque,
        line_frequency=4.0 * SYNCHRONOUS,
        pole_pairs=4,
        phase_voltage=440.0 * np.sqrt(2.0 / 3.0),
        stator_resistance=0.045,
        cages=cages,
    )


@functools.cache
def motor_with(cages: int) -> CircuitMotor:
    return circuit_motor(source_fit(cages).motor)


def machine_of(**changes: Any) -> RollMachine:
    return as_batch(source_machine(**changes))


def drive_of(cages: int, gas: str = "parabola", **changes: Any) -> RollDrive:
    return source_drive(gas, circuit=motor_with(cages)._replace(**changes))


class InTime:
    """d/dt of (crank angle, w, shell angle, s, fluxes as real and imaginary parts), one machine.

    Both equations of motion are solved together, and the currents from the inductances.
    """

    def __init__(self, machine: RollMachine, drive: RollDrive):
        assert drive.circuit is not None
        self.machine, self.drive = machine, drive
        self.motor: InductionMotor = drive.circuit.motor
        cages = np.asarray(self.motor.rotor_leakage)
        leakage = np.concatenate([[float(np.asarray(self.motor.stator_leakage))], cages])
        self.inductance = np.diag(leakage) + float(np.asarray(self.motor.magnetising_inductance))
        self.resistance = np.concatenate(
            [[float(np.asarray(self.motor.stator_resistance))], self.motor.rotor_resistance]
        )

    def electrical(self, flux: np.ndarray, speed: float) -> tuple[np.ndarray, float, np.ndarray]:
        """Rates of complex fluxes, torque, currents."""
        motor = self.motor
        current = np.linalg.solve(self.inductance, flux)
        line = float(np.asarray(motor.line_frequency))
        pairs = float(np.asarray(motor.pole_pairs))
        seen = np.full(flux.size, line - pairs * speed)
        seen[0] = line
        voltage = np.zeros(flux.size)
        voltage[0] = float(np.asarray(motor.phase_voltage))
        rates = voltage - self.resistance * current - 1j * seen * flux
        return rates, 1.5 * pairs * float(np.imag(np.conj(flux[0]) * current[0])), current

    def __call__(self, _: float, y: FloatArray) -> FloatArray:
        machine = self.machine
        angle, speed, turned, shell = y[:4]
        flux = y[4::2] + 1j * y[5::2]
        rates, torque, _ = self.electrical(flux, speed)
        moved = inertia(machine, np.array([[angle]]))
        gas = float(gas_torque(moved, gas_forces(machine, self.drive, np.array([[angle]])))[0, 0])
        j, n, q, j_, n_, q_ = (
            float(part[0, 0])
            for part in (
                moved.shell, moved.coupling, moved.crank,
                moved.shell_slope, moved.coupling_slope, moved.crank_slope,
            )
        )  # fmt: skip
        dry = float(machine.friction_torque[0])
        dry += float(machine.piston_friction[0] * np.sum(np.abs(moved.stroke)))
        inner = torque + gas - dry - float(machine.friction_damping[0]) * speed
        outer = -float(machine.shell_stiffness[0]) * turned
        outer -= float(machine.shell_damping[0]) * shell
        known = [
            outer - j_ * speed * shell - n_ * speed * speed,
            inner + 0.5 * j_ * shell * shell - 0.5 * q_ * speed * speed,
        ]
        moves = np.linalg.solve([[j, n], [n, q]], known)
        fluxes = np.stack([rates.real, rates.imag], axis=1).ravel()
        return np.concatenate([[speed, moves[1], shell, moves[0]], fluxes])


KINDS: dict[str, dict[str, Any]] = {
    "free": {},
    "mounted": MOUNTS,
    "rubbing": {"wrist_pin_offset": 0.004, "rod_inertia_difference": [0.01, -0.02], **FRICTION},
}


def run(machine: RollMachine, drive: RollDrive, rtol: float = 1e-11) -> Running:
    started = None if is_mounted(machine) else SYNCHRONOUS
    return running_state(machine, drive, rtol=rtol, orders=10, started_at=started)


def start_in_time(machine: RollMachine, found: Running) -> FloatArray:
    """The state of `InTime` at crank angle zero."""
    state = evaluate(found.state.solution, np.zeros(1))[0, 0]
    if is_mounted(machine):
        w, turned, s = state[:3]
        return np.concatenate([[0.0, w, turned, s], state[3:]])
    place = place_at(machine, drive_of(1), np.zeros((1, 1))).moved
    s = (found.state.momentum[0] - place.coupling[0, 0] * state[0]) / place.shell[0, 0]
    return np.concatenate([[0.0, state[0], 0.0, s], state[1:]])


@pytest.mark.long
@pytest.mark.parametrize(
    ("kind", "cages"), [("mounted", 1), ("mounted", 3), ("free", 1), ("free", 3)]
)
def test_a_turn_in_time_comes_back(kind: str, cages: int) -> None:
    machine, drive = machine_of(**KINDS[kind]), drive_of(cages)
    found = run(machine, drive)
    truth, start = InTime(machine, drive), start_in_time(machine, found)
    # panel by panel, so that no step goes over a kink of the gas tables
    state, time = start, 0.0
    for edge in found.state.solution.edges[0][1:]:

        def there(_: float, y: FloatArray, edge: float = float(edge)) -> float:
            return float(y[0] - edge)

        there.terminal = True  # type: ignore[attr-defined]
        part = solve_ivp(
            truth, (0.0, 1.0), state, method="DOP853", rtol=1e-11, atol=1e-13, events=there
        )
        state, time = part.y_events[0][0], time + float(part.t_events[0][0])
    assert abs(time / found.state.turn.period[0] - 1.0) < 1e-10
    kept = [1, 2, 3] if kind == "mounted" else [1, 3]
    for place in (*kept, *range(4, start.size)):
        assert abs(state[place] - start[place]) < 1e-9 * max(1.0, abs(start[place])), place


@pytest.mark.parametrize("kind", long_but(KINDS, "rubbing"))
def test_power_over_a_turn(kind: str) -> None:
    machine, drive = machine_of(**KINDS[kind]), drive_of(3)
    found = run(machine, drive)
    turn, stages = found.state.turn, found.state.solution.stages
    flat = stages.reshape(-1, stages.shape[-1])
    flow = power_flow(motor_with(3).motor, flat[:, -8:], flat[:, 0])
    rate = turn.weight[0] / turn.crank_speed[0]
    work = {name: float(np.sum(rate * getattr(flow, name))) for name in flow._fields}
    used = work["stator_copper"] + work["rotor_copper"] + work["mechanical"]
    assert abs(work["electrical"] - used) < 1e-10 * work["electrical"]
    assert min(work["stator_copper"], work["rotor_copper"]) > 0.0
    own = balance(machine, turn, readings(machine, drive, turn))
    np.testing.assert_allclose(own.motor[0], work["mechanical"], rtol=1e-13)
    assert abs(own.residual[0]) < 1e-10 * own.motor[0]


@pytest.mark.long
@pytest.mark.parametrize(
    ("kind", "cages"),
    [
        ("free", 1),
        ("free", 2),
        ("mounted", 2),
    ],
)
def test_multipliers_of_the_monodromy_matrix(kind: str, cages: int) -> None:
    machine, drive = machine_of(**KINDS[kind]), drive_of(cages)
    found = run(machine, drive)
    state = found.state
    rhs, _ = roll_problem(machine, drive, None if kind == "mounted" else state.momentum)
    n = state.solution.left.shape[-1]

    def linear(angle: float, y: FloatArray) -> FloatArray:
        at = evaluate(state.solution, np.array([angle]))[:, None]
        _, slope = rhs.rhs(np.array([[[angle]]]), at, None)
        return np.asarray((slope[0, 0, 0] @ y.reshape(n, n)).ravel())

    carried = np.eye(n).ravel()
    for low, high in pairwise(state.solution.edges[0]):
        part = solve_ivp(linear, (low, high), carried, method="DOP853", rtol=1e-9, atol=1e-12)
        carried = part.y[:, -1]
    wanted = np.linalg.eigvals(carried.reshape(n, n))
    own = found.multiplier[0]
    assert own.shape == (n,)
    for value in own:
        assert np.abs(wanted - value).min() < 1e-8
    np.testing.assert_allclose(np.prod(own), np.linalg.det(carried.reshape(n, n)), rtol=1e-6)


@pytest.mark.long
@pytest.mark.parametrize("started_at", [SYNCHRONOUS, pytest.param(None, marks=pytest.mark.long)])
def test_where_it_folds(started_at: float | None) -> None:
    """The inertia reported is that below which there is none: above it a multiplier nears 1."""
    changes = {"gas_scale": [3.2, 3.2]}
    drive = drive_of(2)
    with pytest.raises(NumericalFailure, match="ceases to exist below") as caught:
        running_state(machine_of(**changes), drive, rtol=1e-9, orders=10, started_at=started_at)
    reported = re.search(r"about ([\d.]+) kg", str(caught.value))
    assert reported is not None
    least = float(reported.group(1))
    largest = []
    for more in (1.001, 1.01, 1.1):
        machine = machine_of(**changes, rotor_inertia=more * least)
        found = running_state(machine, drive, rtol=1e-9, orders=10, started_at=started_at)
        largest.append(float(np.abs(found.multiplier[0]).max()))
    assert largest[2] < largest[1] < largest[0] < 1.0
    # a fold: 1 less the multiplier goes with the root of the distance
    assert 2.0 < (1.0 - largest[1]) / (1.0 - largest[0]) < 3.9


@pytest.mark.long
def test_too_much_for_the_motor() -> None:
    with pytest.raises(NumericalFailure, match="no running state: gas and friction ask for"):
        run(machine_of(gas_scale=[6.0, 6.0]), drive_of(2))
    with pytest.raises(NumericalFailure, match="unstable: a disturbance grows"):
        run(machine_of(rotor_inertia=0.1), drive_of(1))
