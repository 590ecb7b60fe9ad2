"""The numbers of docs/validation_roll.md, by the right physics and by the source's program.

Running states are those of Gauss collocation, which `test_consistency_roll_core_hard` holds against
the independent `exact_roll`.
"""

from collections.abc import Callable
from functools import cache

import numpy as np
from published.test_published_roll import (
    LEVELS,
    POUND_SQUARE_FOOT,
    TABLE_6,
    equal_pressure,
    reduced,
)
from published.test_published_roll import best_estimate as program
from published.test_published_roll_control import TABLE_8
from roll_control_loops import MOTOR_GAIN, SOURCE, TARGET, source_load
from roll_machines import (
    FIRST_MASS,
    GRAVITY,
    ROTOR,
    RPM,
    SECOND_MASS,
    SHELL,
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

ORDERS = np.arange(1, 11)
MASSES = np.array([FIRST_MASS, SECOND_MASS])
SIX_POUNDS = 6.0 * POUND_SQUARE_FOOT
#: amplitudes of the load in N m: what Table 8 was computed with, what is right at 92.76 rad/s
PRINTED_LOAD, RIGHT_LOAD = (352.6, 475.5), (345.578, 472.225)
Values = dict[str, tuple[float, ...]]


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


def solved(name: str, low: float, high: float, decibels: float) -> float:
    """The value of one field that changes the second harmonic by so much."""
    return float(brentq(lambda x: changed(2, **{name: [x]}) - decibels, low, high, xtol=1e-9))


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


def the_machine() -> Values:
    full = {str(row[0]): (100.0 * row[1] * row[0] * RPM / 44.7e3,) for row in TABLE_6 if row[3]}
    return full | {
        "4.1, weight of the unit": (3600.0 * 0.45359237 * GRAVITY,),
        "6.2, power of the motor": (60.0 * 0.7457,),
        "6.6, rod": (11.5 * 25.4,),
        "6.6, crank": (2.5 * 25.4,),
        "6.6, shell": (SHELL,),
        "6.6, rotor": (ROTOR,),
    }


def the_simulation() -> Values:
    return {name: (value,) for name, value in running_numbers().items() if name in (
        "steps in a turn", "turns in the time", "what a turn keeps of a deviation",
        "speed, largest from the mean", "speed, least to largest",
    )}  # fmt: skip


def appendix_a() -> Values:
    single, double, levels = program(single=True), program(), level(best_estimate())
    lags = -np.angle(best_estimate()) % (2.0 * np.pi)
    columns = single.level, levels, LEVELS - levels, single.lag, lags
    numbers = single.frequency, double.frequency, running_numbers()["frequency"]
    return {str(n): row for n, *row in zip(ORDERS, *columns, strict=True)} | {
        "frequency": numbers,
        "drift of the momentum": (single.drift, double.drift, 0.0),
    }


def table_7() -> Values:
    """Odd orders have no motion: what is printed is the arithmetic of the source's computer."""
    equal = {"equal": True, "reciprocating_mass": [FIRST_MASS, FIRST_MASS]}
    linear, parabola = (level(spectrum(gas, **equal)) for gas in ("linear", "parabola"))
    found = {}
    for place, value in enumerate(level(best_estimate())):
        odd = place % 2 == 0
        rest = (linear[place], parabola[place])
        found[str(place + 1)] = (value, equal_pressure(odd)[place], *(() if odd else rest))
    return found


def section_6_6() -> Values:
    """Change at the printed value, and the value that brings the change; least vibration."""
    both, twice = BOTH, pistons(2.0, BOTH)
    return {
        "rod, 10 dB": (changed(2, rod_length=[3.302]), 1e3 * solved("rod_length", 1.0, 9.0, -10.0)),
        "rod, 6 dB": (changed(2, rod_length=[1.930]), 1e3 * solved("rod_length", 1.0, 9.0, -6.0)),
        "crank, 10 dB": (
            changed(2, crank_radius=[0.021]),
            1e3 * solved("crank_radius", 0.01, 0.05, -10.0),
        ),
        "crank, 6 dB": (
            changed(2, crank_radius=[0.032]),
            1e3 * solved("crank_radius", 0.01, 0.05, -6.0),
        ),
        "shell, 10 dB": (
            changed(2, shell_inertia=[464.0]),
            solved("shell_inertia", 200.0, 900.0, -10.0),
        ),
        "shell, 6 dB": (
            changed(2, shell_inertia=[304.0]),
            solved("shell_inertia", 200.0, 900.0, -6.0),
        ),
        **{f"rotor, harmonic {n}": (changed(n, rotor_inertia=[SIX_POUNDS]),) for n in range(1, 5)},
        "both pistons, factor 2": (changed(2, **twice),),
        "both pistons, harmonic 2": least(2, both, 2.0, 3.0),
        "both pistons, harmonic 6": least(6, both, 2.0, 2.6),
        "first piston, harmonic 2": least(2, FIRST, 3.0, 4.0),
        "first piston, harmonic 6": least(6, FIRST, 4.5, 5.5),
        "second piston, harmonic 2": least(2, SECOND, 4.0, 5.0),
        "second piston, harmonic 6": least(6, SECOND, 3.0, 4.5),
    }


def the_reduced_model() -> Values:
    names = "mean of d", "d, harmonic 1", "d, harmonic 2", "lag of harmonic 1", "lag of harmonic 2"
    found = {name: (running_numbers()[name],) for name in names}
    apart = np.max(np.abs(reduced(None) - LEVELS))
    return found | {"7.1, reduced model against the full one": (float(apart),)}


def control() -> Values:
    """Numbers of section 7.2 that stand in the text, and Table 8."""
    speed = float(steady_speed(SOURCE, UNCONTROLLED, 94.25, -303.3).value)
    load = source_load(*PRINTED_LOAD)
    pair = motor_gain_study(SOURCE, np.array([1.0, 10.0]) * MOTOR_GAIN, load)
    drop = pair.level.value[0] - pair.level.value[1]
    praised = evaluate_at_speed(SOURCE, Controller(10.0, 0.0, -10.0), load, TARGET)
    less = evaluate(SOURCE, UNCONTROLLED, load).level.value - praised.level.value
    text = {
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
    source, right = (
        motor_gain_study(SOURCE, TABLE_8[:, 0], source_load(*load))
        for load in (PRINTED_LOAD, RIGHT_LOAD)
    )
    rows = zip(TABLE_8[:, 0], source.level.value, right.level.value, right.speed.value, strict=True)
    return {name: (value,) for name, value in text.items()} | {
        str(gain): (one[0], other[0], one[1], other[1], w) for gain, one, other, w in rows
    }


#: by the number of the section: numbers of each row, from left to right
SECTIONS: dict[int, Callable[[], Values]] = {
    1: the_machine,
    2: the_simulation,
    3: appendix_a,
    4: table_7,
    5: section_6_6,
    6: the_reduced_model,
    7: control,
}
