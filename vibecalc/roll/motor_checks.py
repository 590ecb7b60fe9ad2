"""Physical checks of a motor that finds the speed: its slip curve, its circuit, its controller."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.errors import KeyPath, Problem
from vibecalc.kinds import finds_speed

if TYPE_CHECKING:
    from vibecalc.parts.motor_tables import Motor, SlipTable
    from vibecalc.roll.tables import Control
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Is the motor that finds the speed a motor: its curve over the slip, its poles?
# ----------------------------------------------------------------------------

MOTOR: KeyPath = ("machine", "motor")
TABLE: KeyPath = (*MOTOR, "slip_table")
START: KeyPath = ("response", "start_up")


def slip_problems(case: "Case") -> list[Problem]:
    """Problems of the slip table, of the number of poles, and of a start beyond the table."""
    motor = case.machine.motor
    if motor is None or not finds_speed(case.machine):
        return []
    problems = [*_poles(motor)]
    if motor.kind == "linear":
        return problems
    problems += [*_table(motor.slip_table)]
    return problems or [*_start(case, motor)]


def _poles(motor: "Motor") -> Iterator[Problem]:
    if motor.kind == "dynamic" and motor.poles % 2:
        yield Problem(
            path=(*MOTOR, "poles"),
            message="the number of poles must be even",
            found=str(motor.poles),
            allowed="an even number: twice the pole pairs",
        )


def _table(table: "SlipTable") -> Iterator[Problem]:
    """One problem of the slips, or else one for each torque that cannot be."""
    slip, torque = table.slip, table.torque
    if len(slip) < 2:
        yield Problem(
            path=TABLE,
            message="a slip table needs two rows",
            found=f"slip {slip[0]:.6g} rad/s alone",
            allowed="two rows or more, the first at slip 0",
        )
    elif slip[0] != 0.0 or torque[0] != 0.0:
        yield Problem(
            path=(*TABLE, "slip", 0) if slip[0] else (*TABLE, "torque", 0),
            message="the slip table must begin at slip 0 with torque 0",
            found=f"{torque[0]:.6g} N*m at slip {slip[0]:.6g} rad/s in the first row",
            allowed="a first row of 0 and 0",
            hint="at synchronous speed the torque is zero; at negative slip the table applies "
            "with reversed sign",
        )
    elif not any(torque):
        yield Problem(
            path=(*TABLE, "torque"),
            message="the motor has no torque at any slip",
            found=f"0 N*m in all {len(torque)} rows",
            allowed="a torque above zero",
        )


def _start(case: "Case", motor: "Motor") -> Iterator[Problem]:
    """A start at a slip that the table does not reach cannot be followed."""
    study = None if case.response is None else case.response.start_up
    if study is None or motor.kind != "slip_table" or motor.beyond == "hold":
        return
    slip, largest = abs(motor.synchronous_speed - study.speed), motor.slip_table.slip[-1]
    if slip > largest * (1.0 + 1e-12):
        yield Problem(
            path=(*TABLE, "slip", len(motor.slip_table.slip) - 1),
            message="the slip at the start is outside the slip table",
            found=f"a last slip of {largest:.6g} rad/s, and {slip:.6g} rad/s at the start",
            allowed=f"rows up to {slip:.6g} rad/s, or extrapolation = 'hold' for the last torque "
            "there",
            also=START,
        )


# ----------------------------------------------------------------------------
# Can a motor with transients be made from what the case says of it, and followed as asked?
# ----------------------------------------------------------------------------

ROLL: KeyPath = ("response", "roll")
#: Hz; a line of another frequency is possible, a wrong number of poles is likelier
LINES = (50.0, 60.0)


def dynamic_problems(case: "Case") -> list[Problem]:
    """Problems of a dynamic motor: rows and resistance against its fit, methods that lack it."""
    motor = case.machine.motor
    if motor is None or not finds_speed(case.machine) or motor.kind != "dynamic":
        return []
    problems = [*_methods(case), *_start_with_transients(case)]
    if not slip_problems(case):
        problems += [*_rows(motor), *_resistance(motor)]
    return problems


def dynamic_cautions(motor: "Motor") -> Iterator[str]:
    """A sentence where speed and poles do not go with a line."""
    line = 0.5 * motor.poles * motor.synchronous_speed / (2.0 * math.pi)
    if min(abs(line - usual) / usual for usual in LINES) > 0.01:
        yield (
            f"with {motor.poles} poles and a synchronous speed of "
            f"{motor.synchronous_speed * 30.0 / math.pi:.6g} rpm the line has {line:.4g} Hz: is "
            "that so?"
        )


def _methods(case: "Case") -> Iterator[Problem]:
    roll = None if case.response is None else case.response.roll
    if roll is None:
        return
    if roll.method != "collocation":
        yield _refused("the method", (*ROLL, "method"), roll.method)
    for place, name in enumerate(roll.compare):
        if name != "collocation":
            yield _refused("comparing with the method", (*ROLL, "compare", place), name)


def _refused(what: str, path: KeyPath, name: str) -> Problem:
    return Problem(
        path=path,
        message=f"{what} {name!r} is for motors without transients: it has no fluxes as states",
        found="a motor of kind 'dynamic'",
        allowed="'collocation'",
        hint="with kind = 'slip_table' all methods follow the same table",
        also=(*MOTOR, "kind"),
    )


def _start_with_transients(case: "Case") -> Iterator[Problem]:
    if case.response is not None and case.response.start_up is not None:
        yield Problem(
            path=START,
            message="a start-up is followed with the torque of a slip table or a linear motor, not "
            "with the transients of a motor",
            found="a motor of kind 'dynamic'",
            allowed="a motor of kind 'slip_table' or 'linear'",
            hint="the same table with kind = 'slip_table' starts without the inrush transients",
            also=(*MOTOR, "kind"),
        )


def _rows(motor: "Motor") -> Iterator[Problem]:
    """Every cage takes two rows, and relative differences need torques above zero."""
    from vibecalc.roll.model import CAGES, DEFAULT

    slip, torque = motor.slip_table.slip, motor.slip_table.torque
    rows = [row for row in range(len(slip)) if slip[row] > 0.0]
    empty = [row for row in rows if not torque[row] > 0.0]
    if empty:
        yield Problem(
            path=(*TABLE, "torque", empty[0]),
            message="an induction motor has a torque at every slip above zero",
            found=f"{torque[empty[0]]:.6g} N*m in row {empty[0] + 1}",
            allowed="> 0 N*m",
            also=(*MOTOR, "kind"),
        )
        return
    cages = motor.cages or DEFAULT
    fitted, part = rows, "rows with a slip above zero"
    if CAGES[cages] == 1:
        top = max(rows, key=lambda row: torque[row])
        fitted, part = [row for row in rows if row <= top], "rows up to the largest torque"
    if len(fitted) < 2 * CAGES[cages]:
        yield Problem(
            path=TABLE,
            message=f"a {cages} cage has {2 * CAGES[cages]} parameters, and the table fewer rows "
            "to fit them to",
            found=f"{len(fitted)} {part}",
            allowed=f">= {2 * CAGES[cages]} such rows, or fewer cages",
            also=(*MOTOR, "cages") if motor.cages else None,
        )


def _resistance(motor: "Motor") -> Iterator[Problem]:
    """Behind a resistance R a line gives V^2 / (4 R) in each phase at most."""
    most = motor.voltage**2 / (4.0 * motor.stator_resistance * motor.synchronous_speed)
    largest = max(motor.slip_table.torque)
    if largest >= most:
        limit = motor.voltage**2 / (4.0 * largest * motor.synchronous_speed)
        yield Problem(
            path=(*MOTOR, "stator_resistance"),
            message="behind such a resistance no motor gives the largest torque of the table at "
            "this voltage",
            found=f"{motor.stator_resistance:.6g} ohm, hence {most:.6g} N*m at most, and "
            f"{largest:.6g} N*m in the table",
            allowed=f"< {limit:.4g} ohm",
            hint="the resistance is that of one phase of the equivalent star",
            also=(*TABLE, "torque"),
        )


# ----------------------------------------------------------------------------
# Can a controller of the motor do what is asked of it?
# ----------------------------------------------------------------------------

CONTROL: KeyPath = ("response", "control")


def control_problems(case: "Case") -> list[Problem]:
    """Problems of the target speed and of the full model."""
    control = None if case.response is None else case.response.control
    if control is None or not finds_speed(case.machine):
        return []
    return [*_target(case, control), *_full_model(case, control)]


def _target(case: "Case", control: "Control") -> Iterator[Problem]:
    """The loop runs slower than gain times reference, unless speed were fed back positively."""
    motor, target = case.machine.motor, control.target_speed
    if target is None or motor is None:
        return
    reference = motor.synchronous_speed if control.reference is None else control.reference
    smallest = min((control.gain, *control.gains))
    if target >= smallest * reference:
        yield Problem(
            path=(*CONTROL, "target_speed"),
            message="the machine cannot reach the target speed: a loaded motor runs below gain "
            "times reference",
            found=f"{target:.6g} rad/s, with a gain of {smallest:.6g} and a reference of "
            f"{reference:.6g} rad/s",
            allowed=f"< {smallest * reference:.6g} rad/s",
            also=(*CONTROL, "reference") if control.reference is not None else None,
        )


def _full_model(case: "Case", control: "Control") -> Iterator[Problem]:
    """The full model has a state for the lag of the actuator, and none for a delay."""
    motor = case.machine.motor
    if not control.full_model or motor is None:
        return
    if control.delay > 0.0:
        yield Problem(
            path=(*CONTROL, "full_model"),
            message="the full model of the closed loop has no delay, only a lag of the actuator: "
            "leave a delay to the reduced model",
            found=f"delay = {control.delay:.6g} s",
            allowed="full_model = false (stability and levels of the reduced model count the "
            "delay), or delay = 0 with actuator_lag longer by as much",
            also=(*CONTROL, "delay"),
        )
    if motor.kind == "dynamic":
        yield Problem(
            path=(*CONTROL, "full_model"),
            message="the full model of the closed loop has no transients of the motor's fluxes",
            found="a motor of kind 'dynamic'",
            allowed="full_model = false, or machine.motor.kind = 'slip_table'",
            also=("machine", "motor", "kind"),
        )
