"""Machines with motors in time, and their equations once more, in time and with complex fluxes."""

import functools
from typing import Any

import numpy as np
from roll_machines import RPM, SYNCHRONOUS, columns, source_drive, source_machine

from vibecalc.excitation.induction_motor import InductionMotor
from vibecalc.excitation.induction_motor_fit import MotorFit, fit_induction_motor
from vibecalc.excitation.induction_motor_flux import CircuitMotor, circuit_motor
from vibecalc.numerics.rounding import FloatArray
from vibecalc.roll.mechanism import (
    RollDrive,
    RollMachine,
    as_batch,
    gas_forces,
    gas_torque,
    inertia,
)

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
