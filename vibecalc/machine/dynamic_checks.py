"""Can a motor with transients be made from what the case says of it, and followed as asked?"""

import math
from collections.abc import Iterator

from vibecalc.case.kinds import finds_speed
from vibecalc.case.schema import Case
from vibecalc.errors import KeyPath, Problem
from vibecalc.machine.slip_checks import MOTOR, TABLE, slip_problems
from vibecalc.parts.tables import Motor

ROLL: KeyPath = ("response", "roll")
START: KeyPath = ("response", "start_up")
#: Hz; a line of another frequency is possible, a wrong number of poles is likelier
LINES = (50.0, 60.0)


def dynamic_problems(case: Case) -> list[Problem]:
    """Problems of a dynamic motor: rows and resistance against its fit, methods that lack it."""
    motor = case.machine.motor
    if motor is None or not finds_speed(case.machine) or motor.kind != "dynamic":
        return []
    problems = [*_methods(case), *_start(case)]
    if not slip_problems(case):
        problems += [*_rows(motor), *_resistance(motor)]
    return problems


def dynamic_cautions(motor: Motor) -> Iterator[str]:
    """A sentence where speed and poles do not go with a line."""
    line = 0.5 * motor.poles * motor.synchronous_speed / (2.0 * math.pi)
    if min(abs(line - usual) / usual for usual in LINES) > 0.01:
        yield (
            f"with {motor.poles} poles and a synchronous speed of "
            f"{motor.synchronous_speed * 30.0 / math.pi:.6g} rpm the line has {line:.4g} Hz: is "
            "that so?"
        )


def _methods(case: Case) -> Iterator[Problem]:
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


def _start(case: Case) -> Iterator[Problem]:
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


def _rows(motor: Motor) -> Iterator[Problem]:
    """Every cage takes two rows, and relative differences need torques above zero."""
    from vibecalc.machine.roll_motor import CAGES, DEFAULT

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


def _resistance(motor: Motor) -> Iterator[Problem]:
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
