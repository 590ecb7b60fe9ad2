"""The numbers that docs/validation_roll.md shows by name, computed by the right physics."""

from functools import cache

import numpy as np
from pages import text_of
from roll_control_loops import MOTOR_GAIN, SOURCE, TARGET, source_load
from roll_machines import (
    FIRST_MASS,
    ROTOR,
    SECOND_MASS,
    SYNCHRONOUS,
    source_drive,
    source_machine,
)
from scipy.optimize import brentq, minimize_scalar

from vibecalc.roll.control.gains import UNCONTROLLED, evaluate, evaluate_at_speed, motor_gain_study
from vibecalc.roll.control.loop import Controller, speed_feedback_for, steady_speed
from vibecalc.roll.mechanism import gas_forces, gas_torque, inertia
from vibecalc.roll.steady import multipliers, steady_state
from vibecalc.roll.turn import harmonics, level, readings

PAGE = text_of("validation_roll")
ORDERS = np.arange(1, 11)
MASSES = np.array([FIRST_MASS, SECOND_MASS])
SIX_POUNDS = 6.0 * 0.45359237 * 0.3048**2
#: amplitudes of the load in N m with which Table 8 was computed
PRINTED_LOAD = (352.6, 475.5)


def running(gas: str = "parabola", equal: bool = False, **fields: object):
    """Machine, drive and turn of one machine, shell at rest at crank angle zero at 900 rpm."""
    machine = source_machine(**({"rotor_inertia": [ROTOR]} | fields))
    drive = source_drive(gas, equal=equal, synchronous_speed=np.full(1, SYNCHRONOUS))
    found = steady_state(machine, drive, 10, started_at=SYNCHRONOUS)
    assert found.solved.all()
    return machine, drive, found


def spectrum(gas: str = "parabola", equal: bool = False, **fields: object) -> np.ndarray:
    """Harmonics of the shell's acceleration, rad/s^2."""
    machine, drive, found = running(gas, equal, **fields)
    read = readings(machine, drive, found.turn)
    return harmonics(found.turn, read.shell_acceleration, ORDERS)[0]


@cache
def best_estimate() -> np.ndarray:
    return spectrum()


def changed(order: int, **fields: object) -> float:
    """Level of a changed machine less that of the source's, dB."""
    return float(level(spectrum(**fields))[order - 1] - level(best_estimate())[order - 1])


def pistons(factor: float, which: tuple[float, float]) -> dict[str, object]:
    return {"reciprocating_mass": MASSES * (1.0 + np.array(which) * (factor - 1.0))}


def solved(name: str, low: float, high: float, decibels: float) -> tuple[float]:
    """The value of one field, lengths in mm, that changes the second harmonic by so much."""
    found = brentq(lambda x: changed(2, **{name: [x]}) - decibels, low, high, xtol=1e-9)
    return (float(found) * (1.0 if name == "shell_inertia" else 1e3),)


def least(order: int, which: tuple[float, float], low: float, high: float) -> tuple[float, float]:
    """Factor on the masses of the pistons with the least level, and the change there."""
    found = minimize_scalar(
        lambda f: changed(order, **pistons(f, which)),
        bounds=(low, high),
        method="bounded",
        options={"xatol": 1e-5},
    )
    return float(found.x), float(found.fun)


BOTH, FIRST, SECOND = (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)
#: where values are looked for: crank radius in m, inertia of the shell in kg m^2
CRANK, SHELL = (0.01, 0.05), (200.0, 900.0)
#: pistons, harmonic, and the factors between which the least level lies
LEAST = (
    ("both pistons", 2, BOTH, (2.0, 3.0)),
    ("both pistons", 6, BOTH, (2.0, 2.6)),
    ("first piston", 2, FIRST, (3.0, 4.0)),
    ("first piston", 6, FIRST, (4.5, 5.5)),
    ("second piston", 2, SECOND, (4.0, 5.0)),
    ("second piston", 6, SECOND, (3.0, 4.5)),
)


@cache
def running_numbers() -> dict[str, float]:
    """Numbers of sections 6.3 to 6.5 and 7.1."""
    machine, drive, found = running()
    turn = found.turn
    w, share = turn.crank_speed[0], turn.weight[0] / turn.crank_speed[0]
    mean = float(np.sum(share * w) / np.sum(share))
    ends = np.concatenate([w, found.solution.ends[0, :, 0]])
    angle = (np.arange(7200) + 0.5) * 2.0 * np.pi / 7200
    moved = inertia(machine, angle[None])
    torque = gas_torque(moved, gas_forces(machine, drive, angle[None]))[0]
    torque = torque - 0.5 * moved.crank_slope[0] * 92.76**2
    load = [np.mean(torque * np.exp(1j * n * angle)) * (2 if n else 1) for n in range(3)]
    period = float(turn.period[0])
    return {
        "frequency": 1.0 / period,
        "steps in a turn": period / 0.0005,
        "turns in the time": 0.5 / period,
        "what a turn keeps of a deviation": abs(complex(multipliers(found)[0][0, 0])),
        "speed, least to largest": 100.0 * float(np.ptp(ends)) / mean,
        "speed, largest from the mean": 100.0 * float(np.max(np.abs(ends / mean - 1.0))),
        "mean of d": float(load[0].real),
        "d, harmonic 1": abs(load[1]),
        "d, harmonic 2": abs(load[2]),
        "lag of harmonic 1": float(np.degrees(np.angle(load[1])) % 360.0),
        "lag of harmonic 2": float(np.degrees(np.angle(load[2])) % 360.0),
    }


@cache
def study_numbers() -> dict[str, tuple[float, ...]]:
    """Of section 6.6: change at the printed value, and the value that brings the change named."""
    return {
        "rod, 10 dB": (changed(2, rod_length=[3.302]), *solved("rod_length", 1.0, 9.0, -10.0)),
        "rod, 6 dB": (changed(2, rod_length=[1.930]), *solved("rod_length", 1.0, 9.0, -6.0)),
        "crank, 10 dB": (changed(2, crank_radius=[0.021]), *solved("crank_radius", *CRANK, -10.0)),
        "crank, 6 dB": (changed(2, crank_radius=[0.032]), *solved("crank_radius", *CRANK, -6.0)),
        "shell, 10 dB": (
            changed(2, shell_inertia=[464.0]),
            *solved("shell_inertia", *SHELL, -10.0),
        ),
        "shell, 6 dB": (changed(2, shell_inertia=[304.0]), *solved("shell_inertia", *SHELL, -6.0)),
        **{
            f"rotor, harmonic {order}": (changed(order, rotor_inertia=[SIX_POUNDS]),)
            for order in range(1, 5)
        },
        "both pistons, factor 2": (changed(2, **pistons(2.0, BOTH)),),
    }


@cache
def least_numbers() -> dict[str, tuple[float, float]]:
    """Factor on piston masses with the least level, and the change of the level there in dB."""
    return {
        f"{name}, harmonic {order}": least(order, which, *between)
        for name, order, which, between in LEAST
    }


def numbers() -> dict[str, tuple[float, ...]]:
    """All of them by name, in the order of their columns."""
    alone = {**running_numbers(), **control_numbers()}
    return {
        **{name: (value,) for name, value in alone.items()},
        **study_numbers(),
        **least_numbers(),
    }


@cache
def control_numbers() -> dict[str, float]:
    """Numbers of section 7.2 that stand in the text."""
    speed = float(steady_speed(SOURCE, UNCONTROLLED, 94.25, -303.3).value)
    load = source_load(*PRINTED_LOAD)
    pair = motor_gain_study(SOURCE, np.array([1.0, 10.0]) * MOTOR_GAIN, load)
    drop = pair.level.value[0] - pair.level.value[1]
    praised = evaluate_at_speed(SOURCE, Controller(10.0, 0.0, -10.0), load, TARGET)
    less = evaluate(SOURCE, UNCONTROLLED, load).level.value - praised.level.value
    return {
        "running speed": speed,
        "the same in Hz": speed / (2.0 * np.pi),
        "feedback at a large gain": float(
            speed_feedback_for(SOURCE, np.array([1e12]), 94.25, -303.3, 92.76).value[0]
        ),
        "tenfold motor gain, harmonic 1": float(drop[0]),
        "tenfold motor gain, harmonic 2": float(drop[1]),
        "tenfold motor gain, speed": 100.0 * float(pair.speed.value[1] / pair.speed.value[0] - 1.0),
        "controller, harmonic 1": float(less[0]),
        "controller, harmonic 2": float(less[1]),
    }
