"""Machines for the tests of start-up and marching: the source's, and ones with closed forms."""

import numpy as np

from vibecalc.excitation.gas_tables import GasForce, gas_force
from vibecalc.excitation.slip_torque import SlipCurve, slip_curve
from vibecalc.roll.mechanism import RollDrive, RollMachine, roll_machine

GRAVITY = 9.8066
RPM = 2.0 * np.pi / 60.0

# Herold (1977), appendix A: slip in rpm, N m; pressure forces every 10 degrees, N
SLIP = [0, 6, 11, 20, 34, 40, 70, 108, 180, 300, 500, 900]
TORQUE = [0, 239, 361, 485, 616, 744, 949, 1009, 949, 746, 610, 542]
STAGE_1 = [
    21472, 17704, 14150, 11516, 7860, 5445, 3599, 2691, 2349, 2282, 2273, 2282, 2531, 2682, 2736,
    2971, 3016, 3176, 3145, 3252, 3416, 3768, 3941, 4524, 4964, 5663, 6588, 8287, 10409, 13193,
    17188, 20715, 22450, 22810, 22784, 22428, 21472,
]  # fmt: skip
STAGE_2 = [
    6499, 6481, 6770, 7046, 7375, 7949, 8750, 9635, 10849, 12446, 15204, 18847, 23762, 29545,
    33873, 34536, 35070, 33931, 32783, 31516, 26213, 21596, 16632, 13002, 10284, 8243, 7437, 6881,
    6392, 6219, 6219, 6308, 6534, 6592, 6663, 6637, 6499,
]  # fmt: skip
#: the levels of the shell's acceleration that the source prints, dB against 1 rad/s^2
PRINTED = [4.3, 8.9, 0.2, 0.4, -22.2, -15.0, -18.2, -20.0, -25.1, -26.6]

DEGREES = np.radians(10.0 * np.arange(37))


def source_machine(**changes: object) -> RollMachine:
    fields: dict[str, object] = {
        "crank_radius": 0.0635,
        "rod_length": 0.2921,
        "crank_angle_offset": [0.0, -np.pi],
        "reciprocating_mass": [104.7 / GRAVITY, 76.5 / GRAVITY],
        "rotor_inertia": 20.7 / GRAVITY,
        "shell_inertia": 1488.0 / GRAVITY,
    }
    return roll_machine(**{**fields, **changes})


def source_gas(interpolation: str = "linear", factor: float = 1.0) -> tuple[GasForce, GasForce]:
    first = factor * np.array(STAGE_1, dtype=float)
    second = factor * np.roll(np.array(STAGE_2[:-1], dtype=float), -18)
    return (
        gas_force(DEGREES, first, interpolation),
        gas_force(DEGREES, np.append(second, second[0]), interpolation),
    )


def source_drive(
    interpolation: str = "linear",
    motor: str = "linear",
    factor: float = 1.0,
    holds: bool = True,
) -> RollDrive:
    curve = slip_curve(np.array(SLIP) * RPM, TORQUE, motor)
    return RollDrive(source_gas(interpolation, factor), curve, np.array(900.0 * RPM), holds)


def constant_torque(torque: float) -> SlipCurve:
    """A motor with one torque at every slip."""
    return SlipCurve(np.empty(0), np.zeros(1), np.array([[torque, 0.0]]), np.inf)
