"""Numbers of Herold (1977), sections 6 and 7 and appendix A, for docs/validation_roll.md.

Printed, as the source came to them, and right; units are those of the printed number.
"""

import math
from functools import cache

import numpy as np
from herold_numbers import EQUAL_FORCES, LAGS, LEVELS, disturbance, equal_pressure, program, reduced
from herold_numbers import changed as changed_program
from herold_simulation import STEP
from pages import Row, shows
from roll_control_loops import MOTOR_GAIN, SOURCE, TARGET, source_load
from roll_machines import FIRST_MASS, ROTOR, SECOND_MASS, SYNCHRONOUS, source_drive, source_machine
from scipy.optimize import brentq, minimize_scalar

from vibecalc.roll.control.gains import UNCONTROLLED, evaluate, evaluate_at_speed, motor_gain_study
from vibecalc.roll.control.loop import Controller, speed_feedback_for, steady_speed
from vibecalc.roll.steady import multipliers, steady_state
from vibecalc.roll.turn import harmonics, level, readings

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


def needed(name: str, low: float, high: float, decibels: float) -> float:
    """The value of one field, lengths in mm, that changes the second harmonic by so much."""
    found = brentq(lambda x: changed(2, **{name: [x]}) - decibels, low, high, xtol=1e-9)
    return float(found) * (1.0 if name == "shell_inertia" else 1e3)


def least(order: int, which: tuple[float, float], low: float, high: float) -> tuple[float, float]:
    """Factor on the masses of the pistons with the least level, and the change there in dB."""
    found = minimize_scalar(
        lambda f: changed(order, **pistons(f, which)),
        bounds=(low, high),
        method="bounded",
        options={"xatol": 1e-5},
    )
    return float(found.x), float(found.fun)


BOTH, FIRST, SECOND = (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)
#: printed change of the second harmonic in dB: what is changed, where its exact value lies
CHANGES = (
    ("rod of 3302 mm", "-10", "rod_length", 3.302, (1.0, 9.0), "mm"),
    ("rod of 1930 mm", "-6", "rod_length", 1.930, (1.0, 9.0), "mm"),
    ("crank of 21 mm", "-10", "crank_radius", 0.021, (0.01, 0.05), "mm"),
    ("crank of 32 mm", "-6", "crank_radius", 0.032, (0.01, 0.05), "mm"),
    ("shell of 464 kg m^2", "-10", "shell_inertia", 464.0, (200.0, 900.0), "kg m^2"),
    ("shell of 304 kg m^2", "-6", "shell_inertia", 304.0, (200.0, 900.0), "kg m^2"),
)
#: pistons, harmonic, and the factors between which the least level lies
LEAST = (
    ("both pistons", 2, BOTH, (2.0, 3.0)),
    ("both pistons", 6, BOTH, (2.0, 2.6)),
    ("first piston", 2, FIRST, (3.0, 4.0)),
    ("first piston", 6, FIRST, (4.5, 5.5)),
    ("second piston", 2, SECOND, (4.0, 5.0)),
    ("second piston", 6, SECOND, (3.0, 4.5)),
)
#: motor gain in N m s/rad of Table 8; levels of harmonics 1 and 2 in dB, speed in rad/s, printed
GAINS = (50.0, 100.0, 150.0, 203.4, 300.0, 600.0, 1000.0, 2000.0, 4000.0, 10000.0)
TABLE_8 = {
    1: ("7.0", "6.3", "5.3", "4.2", "2.1", "-2.8", "-6.9", "-13.0", "-18.8", "-26.7"),
    2: ("9.9", "9.6", "9.3", "8.9", "7.9", "4.7", "1.2", "-4.3", "-10.2", "-18.1"),
    0: ("88.2", "91.2", "92.2", "92.8", "93.2", "93.7", "94.0", "94.1", "94.2", "94.2"),
}


def judged(
    place: str, printed: str, right: float | None, source: float | None, slip: str, other: str,
) -> Row:  # fmt: skip
    """Reproduced, with the slip, or compatible, as the numbers say."""
    if right is not None and shows(printed, right):
        return Row(place, printed, right, None, "reproduced")
    if right is not None and source is not None and shows(printed, source):
        return Row(place, printed, right, source, "with the slip", slip)
    return Row(place, printed, right, source, "compatible", other)


def simulation() -> tuple[Row, ...]:
    """Sections 6.3 to 6.5 and 7.1."""
    turn = running()[2].turn
    w, share = turn.crank_speed[0], turn.weight[0] / turn.crank_speed[0]
    mean = float(np.sum(share * w) / np.sum(share))
    ends = np.concatenate([w, running()[2].solution.ends[0, :, 0]])
    spread = 100.0 * float(np.ptp(ends)) / mean
    largest = 100.0 * float(np.max(np.abs(ends / mean - 1.0)))
    period = float(turn.period[0])
    left = abs(complex(multipliers(running()[2])[0][0, 0]))
    return (
        Row("6.3, steps of 0.5 ms per revolution", "136", period / STEP, float(program().steps[0]),
            "with the slip", "first revolution, from 900 rpm; the next two: 135"),
        Row("6.3, steps for 1 % of the period", "100", 1.0 / 0.01, None, "reproduced"),
        Row("6.3, levels with a period 1 % off, dB", "< 0.5", wrong_period(0.01), None,
            "reproduced", "square wave, ten harmonics"),
        Row("6.4, revolutions in 0.5 s", "7", 0.5 / period, None, "reproduced"),
        Row("6.4, revolutions until steady", "2", math.ceil(math.log(1e-6) / math.log(left)), None,
            "reproduced", f"to 1e-6, as {left:.2e} of a deviation remains per revolution; not with "
            "a heavy rotor"),
        Row("6.5, drift of the momentum, %", "0.003", 0.0, program(single=True).drift,
            "with the slip", "truncated states, see appendix A"),
        Row("6.5, harmonic 1 with mounts, dB", "72.", None, None, "garbled",
            "7.2 dB; mount data not given"),
        Row("7.1, speed variation, %", "< 4.0", largest, None, "reproduced",
            f"from the mean; {spread:.1f} peak to peak"),
    )  # fmt: skip


def wrong_period(off: float) -> float:
    """Largest error in dB of ten harmonics of a square wave analysed with that period."""
    count = 200000
    phase = (np.arange(count) + 0.5) / count
    wave = np.where(phase * (1.0 + off) % 1.0 < 0.5, 1.0, -1.0)
    order = np.arange(1, 11, 2)
    found = np.abs(np.exp(2j * np.pi * order[:, None] * phase) @ wave) * 2.0 / count
    return float(np.max(np.abs(20.0 * np.log10(found * order * np.pi / 4.0))))


def appendix_a() -> tuple[Row, ...]:
    single, right = program(single=True), best_estimate()
    lag = -np.angle(right) % (2.0 * np.pi)
    slip, other = "Euler steps of 0.5 ms, whole steps per revolution", "time zero up to a step late"
    frequency = 1.0 / float(running()[2].turn.period[0])
    lags = [
        judged(f"lag, rad, order {n}", f"{LAGS[n - 1]:.3f}", float(lag[n - 1]),
               float(single.lag[n - 1]), slip, other) for n in ORDERS
    ]  # fmt: skip
    return (
        *(judged(f"level, dB, order {n}", f"{LEVELS[n - 1]:.1f}", float(level(right)[n - 1]),
                 float(single.level[n - 1]), slip, other) for n in ORDERS),
        *sorted(lags, key=lambda row: row.verdict),
        Row("frequency, Hz", "14.8", frequency, None, "reproduced"),
        Row("drift of the momentum, %", "0.0029", 0.0, single.drift, "compatible",
            "truncation: each step loses half a unit of 2^-16 rad/s on average"),
    )  # fmt: skip


def table_7() -> tuple[Row, ...]:
    machine = {"reciprocating_mass": np.array([FIRST_MASS, FIRST_MASS])}
    right = level(spectrum("linear", equal=True, **machine))
    residue = "start-up residue; exactly zero"
    slip = "Euler steps of 0.5 ms, whole steps per revolution"
    odd = [
        Row(f"Table 7, equal forces, dB, order {n}", f"{EQUAL_FORCES[n - 1]:.1f}", None,
            float(equal_pressure(single=True)[n - 1]), "compatible", residue)
        for n in ORDERS[::2]
    ]  # fmt: skip
    even = [
        judged(f"Table 7, equal forces, dB, order {n}", f"{EQUAL_FORCES[n - 1]:.1f}",
               float(right[n - 1]), float(equal_pressure()[n - 1]), slip, "")
        for n in ORDERS[1::2]
    ]  # fmt: skip
    unequal = float(level(best_estimate())[8])
    return (
        *odd,
        *even,
        Row("Table 7, unequal forces, dB, order 9", "-25.0", unequal,
            float(program(single=True).level[8]), "misprint", "-25.1 in appendix A"),
    )  # fmt: skip


def design_changes() -> tuple[Row, ...]:
    rows = []
    for place, printed, name, value, between, unit in CHANGES:
        exact = needed(name, *between, float(printed))
        reason = f"exactly with {exact:.{1 if exact < 100.0 else 0}f} {unit}"
        rows.append(Row(f"{place}, dB", printed, changed(2, **{name: [value]}), None, "reproduced",
                        reason))  # fmt: skip
    light, program_light = (
        [change(order) for order in (1, 2, 3, 4)]
        for change in (
            lambda order: changed(order, rotor_inertia=[SIX_POUNDS]),
            lambda order: float(changed_program(rotor_inertia=SIX_POUNDS)[order - 1]),
        )
    )
    sharp = changed_program(rotor_inertia=0.3)
    place = "rotor of 6 lbm ft^2, dB, harmonic"
    rows += [
        Row(f"{place} 2", "-10", light[1], None, "reproduced"),
        Row(f"{place} 3", "-5", light[2], None, "reproduced"),
        Row(f"{place} 4", "-2.4", light[3], program_light[3], "with the slip",
            "Euler steps of 0.5 ms"),
        Row(f"{place} 1", "-8.5", light[0], program_light[0], "not reproducible",
            f"with 0.3 kg m^2: {sharp[0]:.1f}, harmonic 2 {sharp[1]:.1f}"),
        Row("pistons of twice the mass, dB", "-7", changed(2, **pistons(2.0, BOTH)), None,
            "reproduced"),
    ]  # fmt: skip
    for name, order, which, between in LEAST:
        tried = [1.0, 2.0, 4.0, 8.0]
        coarse = tried[int(np.argmin([changed(order, **pistons(f, which)) for f in tried]))]
        factor, _ = least(order, which, *between)
        rows.append(Row(f"best factor on the mass, {name}, harmonic {order}", f"{coarse:.1f}",
                        factor, coarse, "with the slip", "best of 1, 2, 4 and 8"))  # fmt: skip
    return tuple(rows)


def reduced_model() -> tuple[Row, ...]:
    closed, opened = disturbance(TARGET, gas="parabola"), disturbance(TARGET)
    lag = np.degrees(np.angle(closed)) % 360.0
    apart = reduced(MOTOR_GAIN) - LEVELS
    return (
        Row("7.1, reduced model against the full one, dB", "< 1.1",
            float(np.max(np.abs(reduced(None) - LEVELS))), None, "reproduced",
            f"full motor table; with {MOTOR_GAIN} N m s/rad harmonics 3 and 7 are {-apart[2]:.1f} "
            f"and {-apart[6]:.1f} dB low"),
        Row("eq. 97, mean, N m", "-303.3", float(closed[0].real), float(opened[0].real),
            "with the slip", "open gas tables"),
        Row("eq. 97, N m, harmonic 1", "352.6", abs(closed[1]), None, "not reproducible",
            "no reading of the tables gives it"),
        Row("eq. 97, N m, harmonic 2", "488.2", abs(closed[2]), None, "not reproducible",
            "Table 8 uses 475.5"),
        Row("eq. 97, deg, angle 1", "271", float(lag[1]), None, "compatible",
            "truncated; angles of eq. 94 are lags"),
        Row("eq. 97, deg, angle 2", "64.7", float(lag[2]), None, "compatible",
            "0.2 degrees are 0.5 rad/s of speed"),
    )  # fmt: skip


def control() -> tuple[Row, ...]:
    speed = float(steady_speed(SOURCE, UNCONTROLLED, 94.25, -303.3).value)
    load = source_load(*PRINTED_LOAD)
    pair = motor_gain_study(SOURCE, np.array([1.0, 10.0]) * MOTOR_GAIN, load)
    drop = pair.level.value[0] - pair.level.value[1]
    praised = evaluate_at_speed(SOURCE, Controller(10.0, 0.0, -10.0), load, TARGET)
    less = evaluate(SOURCE, UNCONTROLLED, load).level.value - praised.level.value
    feedback = speed_feedback_for(SOURCE, np.array([1e12]), 94.25, -303.3, 92.76)
    faster = 100.0 * float(pair.speed.value[1] / pair.speed.value[0] - 1.0)
    return (
        Row("eq. 106, rad/s", "92.76", speed, None, "reproduced"),
        Row("eq. 106, Hz", "14.76", speed / (2.0 * np.pi), None, "reproduced"),
        Row("eq. 107, feedback at a large gain", "1.016", float(feedback.value[0]), None,
            "reproduced"),
        Row("7.2, tenfold motor gain, dB, harmonic 1", "17", float(drop[0]), None, "reproduced"),
        Row("7.2, tenfold motor gain, dB, harmonic 2", "13", float(drop[1]), None, "reproduced"),
        Row("7.2, tenfold motor gain, speed, %", "1.4", faster, None, "reproduced"),
        Row("7.2, K = 10, k = -10, dB, harmonic 1", "39.5", float(less[0]), None, "reproduced",
            "valid for zero delay only"),
        Row("7.2, K = 10, k = -10, dB, harmonic 2", "41.5", float(less[1]), None,
            "not reproducible", "rounds to 41.6; eq. 113 as printed"),
        *table_8(),
    )  # fmt: skip


def table_8() -> list[Row]:
    right = motor_gain_study(SOURCE, np.array(GAINS), source_load())
    slip = motor_gain_study(SOURCE, np.array(GAINS), source_load(*PRINTED_LOAD))
    rows: list[Row] = []
    for order, load in ((1, 352.6), (2, 475.5)):
        reasons = f"load of {load} N m", "digits of the load not printed"
        column = []
        for place, (gain, printed) in enumerate(zip(GAINS, TABLE_8[order], strict=True)):
            found = (float(one.level.value[place, order - 1]) for one in (right, slip))
            label = f"Table 8, harmonic {order}, dB, {gain:g}"
            column.append(judged(label, printed, *found, *reasons))
        rows += sorted(column, key=lambda row: row.verdict)
    rows += [
        judged(f"Table 8, rad/s, {gain:g}", printed, float(speed), None, "", "")
        for gain, printed, speed in zip(GAINS, TABLE_8[0], right.speed.value, strict=True)
    ]
    misprints = {
        "Table 8, harmonic 1, dB, 2000": ("compatible", "misprint of -12.8"),
        "Table 8, rad/s, 1000": ("misprint", "rounds to 93.9"),
    }
    return [
        row._replace(verdict=misprints[row.place][0], reason=misprints[row.place][1])
        if row.place in misprints
        else row
        for row in rows
    ]


SECTIONS = {
    "2. The simulation (sections 6.3 to 6.5, 7.1)": simulation,
    "3. Appendix A": appendix_a,
    "4. Table 7: equal pressure forces": table_7,
    "5. Section 6.6: design changes": design_changes,
    "6. The reduced model (section 7.1)": reduced_model,
    "7. Control (section 7.2, Table 8, Fig. 28)": control,
}
