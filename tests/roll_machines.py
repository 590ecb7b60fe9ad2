"""The machine of Herold (1977) as arrays, for tests: data of his appendix A."""

import csv
from pathlib import Path

import numpy as np

from vibecalc.excitation.gas_tables import gas_force
from vibecalc.excitation.slip_torque import SlipCurve, slip_curve
from vibecalc.roll.mechanism import RollDrive, RollMachine, roll_machine
from vibecalc.roll.steady import QuickTurn

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


def quick_spectrum(turn: QuickTurn, orders: int) -> np.ndarray:
    """Harmonics 1 to `orders` in time of the shell's acceleration, as `turn.harmonics` has them."""
    moved, speed = turn.place.moved, turn.crank_speed
    square, shell = speed * speed, moved.shell[0]
    share = moved.coupling[0] / shell
    drift = turn.momentum / shell
    shell_slope, coupling_slope = moved.shell_slope[0], moved.coupling_slope[0]
    steep = moved.crank_slope[0] - share * (2.0 * coupling_slope - share * shell_slope)
    torque = turn.motor_torque + turn.place.load[0] - turn.place.drag[0, 0] * speed
    torque = torque + 0.5 * (drift * drift * shell_slope - steep * square)
    crank = torque * shell / moved.determinant[0]
    rate = (shell_slope * (drift - share * speed) * speed + coupling_slope * square) / shell
    acceleration = -rate - share * crank
    slow = (2.0 * np.pi / len(speed)) / speed
    time = np.cumsum(slow) - 0.5 * (slow + slow[0])
    period = slow.sum()
    wave = np.exp((-2j * np.pi / period) * time)
    powers = np.multiply.accumulate(np.broadcast_to(wave, (orders, len(wave))), axis=0)
    return powers @ (acceleration * slow) * (2.0 / period)
