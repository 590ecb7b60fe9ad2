"""Motors for tests, and the equivalent circuit in many digits, written another way."""

import mpmath
import numpy as np

from vibecalc.excitation.induction_motor import InductionMotor

RPM = 2.0 * np.pi / 60.0
LINE = 120.0 * np.pi
#: Herold's Table 6 with the point at 180 rpm of his program, slip in rad/s and torque in N m
TABLE_SLIP = np.array([0, 6, 11, 20, 34, 40, 70, 108, 180, 300, 500, 900]) * RPM
TABLE_TORQUE = np.array([0, 239, 361, 485, 616, 744, 949, 1009, 949, 746, 610, 542.0])
GIVEN = {
    "line_frequency": LINE,
    "pole_pairs": 4,
    "phase_voltage": 440.0 * np.sqrt(2.0 / 3.0),
    "stator_resistance": 0.045,
}

ONE_CAGE = InductionMotor(
    **GIVEN,
    stator_leakage=9e-4,
    magnetising_inductance=0.026,
    rotor_resistance=np.array([0.08]),
    rotor_leakage=np.array([1.4e-3]),
)
TWO_CAGES = InductionMotor(
    **GIVEN,
    stator_leakage=8e-4,
    magnetising_inductance=0.027,
    rotor_resistance=np.array([0.085, 0.4]),
    rotor_leakage=np.array([4.5e-3, 1.4e-3]),
)
MOTORS = {"one cage": ONE_CAGE, "two cages": TWO_CAGES}


def exact_torque(motor, slip):
    """Torque from the power that crosses the air gap, by impedances, in mpmath."""
    with mpmath.workdps(40):
        line, p, voltage, stator, leakage, magnetising = (mpmath.mpf(float(x)) for x in motor[:6])
        fraction = p * mpmath.mpf(float(slip)) / line
        if fraction == 0:
            return mpmath.mpf(0)
        branches = [
            mpmath.mpf(float(r)) / fraction + mpmath.mpc(0, line * mpmath.mpf(float(x)))
            for r, x in zip(motor.rotor_resistance, motor.rotor_leakage, strict=True)
        ]
        inside = 1 / (sum(1 / z for z in branches) + 1 / mpmath.mpc(0, line * magnetising))
        current = voltage / (stator + mpmath.mpc(0, line * leakage) + inside)
        drop = current * inside
        power = sum(
            1.5 * abs(drop / z) ** 2 * mpmath.mpf(float(r)) / fraction
            for z, r in zip(branches, motor.rotor_resistance, strict=True)
        )
        return power * p / line


def random_motor(rng, cages):
    """A motor that could be built, of any size."""
    scale = 10.0 ** rng.uniform(-2, 2)
    magnetising = scale * rng.uniform(0.5, 2.0) * 0.03
    return InductionMotor(
        line_frequency=rng.uniform(100.0, 600.0),
        pole_pairs=int(rng.integers(1, 7)),
        phase_voltage=rng.uniform(50.0, 5000.0),
        stator_resistance=scale * 10.0 ** rng.uniform(-3, 0.5),
        stator_leakage=magnetising * 10.0 ** rng.uniform(-3, -0.7),
        magnetising_inductance=magnetising,
        rotor_resistance=scale * 10.0 ** rng.uniform(-2.5, 0.5, cages),
        rotor_leakage=magnetising * 10.0 ** rng.uniform(-2.5, -0.5, cages),
    )
