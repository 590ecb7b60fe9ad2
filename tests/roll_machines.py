"""The machine of Herold (1977) as arrays, for tests: data of his appendix A."""

import csv
from pathlib import Path

import numpy as np

from vibecalc.excitation.gas_tables import gas_force
from vibecalc.excitation.slip_torque import SlipCurve, slip_curve
from vibecalc.roll.mechanism import RollDrive, RollMachine, roll_machine

CASES = Path(__file__).parents[1] / "cases"
GRAVITY = 9.8066
RPM = 2.0 * np.pi / 60.0
FIRST_MASS, SECOND_MASS = 104.7 / GRAVITY, 76.5 / GRAVITY
ROTOR, SHELL = 20.7 / GRAVITY, 1488.0 / GRAVITY
RADIUS, LENGTH = 0.0635, 0.2921
SYNCHRONOUS = 900.0 * RPM


def columns(name: str) -> np.ndarray:
    """The numbers of a CSV file of the cases, (columns, rows), in the units of the file."""
    lines = (CASES / name).read_text().splitlines()
    rows = list(csv.reader(line for line in lines if not line.startswith("#")))
    return np.array(rows[1:], dtype=float).T


def source_machine(**changes: object) -> RollMachine:
    """The compressor of the source; `changes` replace or add fields of `RollMachine`."""
    fields: dict[str, object] = {
        "crank_radius": RADIUS,
        "rod_length": LENGTH,
        "crank_angle_offset": [0.0, np.pi],
        "reciprocating_mass": [FIRST_MASS, SECOND_MASS],
        "rotor_inertia": ROTOR,
        "shell_inertia": SHELL,
    }
    return roll_machine(**(fields | changes))


def source_drive(
    gas: str = "parabola", motor: str = "linear", equal: bool = False, **changes: object
) -> RollDrive:
    """Its gas forces and motor; `equal` puts the first stage's forces on both pistons."""
    slip, torque = columns("roll_motor.csv")
    files = ("roll_first_stage.csv", "roll_first_stage.csv" if equal else "roll_second_stage.csv")
    forces = []
    for name in files:
        angle, force = columns(name)
        forces.append(gas_force(np.radians(angle), force, gas))
    return RollDrive(
        tuple(forces), slip_curve(slip * RPM, torque, motor), np.asarray(SYNCHRONOUS)
    )._replace(**changes)


def straight_drive(gas: str = "linear", **changes: object) -> RollDrive:
    """The same by straight lines, the last torque of the motor held beyond its table."""
    return source_drive(gas, **({"holds": True} | changes))


def constant_torque(torque: float) -> SlipCurve:
    """A motor with one torque at every slip."""
    return SlipCurve(np.empty(0), np.zeros(1), np.array([[torque, 0.0]]), np.inf)
