"""Is the motor that finds the speed a motor: its curve over the slip, its poles?"""

from collections.abc import Iterator

from vibecalc.case.kinds import finds_speed
from vibecalc.case.schema import Case
from vibecalc.errors import KeyPath, Problem
from vibecalc.parts.tables import Motor, SlipTable

MOTOR: KeyPath = ("machine", "motor")
TABLE: KeyPath = (*MOTOR, "slip_table")
START: KeyPath = ("response", "start_up")


def slip_problems(case: Case) -> list[Problem]:
    """Problems of the slip table, of the number of poles, and of a start beyond the table."""
    motor = case.machine.motor
    if motor is None or not finds_speed(case.machine):
        return []
    problems = [*_poles(motor)]
    if motor.kind == "linear":
        return problems
    problems += [*_table(motor.slip_table)]
    return problems or [*_start(case, motor)]


def _poles(motor: Motor) -> Iterator[Problem]:
    if motor.kind == "dynamic" and motor.poles % 2:
        yield Problem(
            path=(*MOTOR, "poles"),
            message="a motor has as many north poles as south poles",
            found=str(motor.poles),
            allowed="an even number: twice the pole pairs",
        )


def _table(table: SlipTable) -> Iterator[Problem]:
    """One problem of the slips, or else one for each torque that cannot be."""
    slip, torque = table.slip, table.torque
    back = [n for n in range(1, len(slip)) if not slip[n] > slip[n - 1]]
    if len(slip) < 2:
        yield Problem(
            path=TABLE,
            message="a slip table of one row is no curve",
            found=f"slip {slip[0]:.6g} rad/s alone",
            allowed="two rows or more, the first at slip 0",
        )
    elif back:
        last = back[0]
        twice = slip[last] == slip[last - 1]
        yield Problem(
            path=(*TABLE, "slip", last),
            message="a slip stands twice" if twice else "the slips of the table have to ascend",
            found=f"{slip[last - 1]:.6g} rad/s, then {slip[last]:.6g} rad/s, in rows "
            f"{last} and {last + 1}",
            allowed="each larger than the one before it",
        )
    elif slip[0] != 0.0 or torque[0] != 0.0:
        yield Problem(
            path=(*TABLE, "slip", 0) if slip[0] else (*TABLE, "torque", 0),
            message="the slip table has to begin at slip 0 with torque 0",
            found=f"{torque[0]:.6g} N*m at slip {slip[0]:.6g} rad/s in the first row",
            allowed="a first row of 0 and 0",
            hint="a rotor that turns with the field has no torque; at negative slip the table is "
            "continued with the sign turned",
        )
    else:
        yield from _backwards(torque)


def _backwards(torque: tuple[float, ...]) -> Iterator[Problem]:
    low = min(range(len(torque)), key=lambda row: torque[row])
    if torque[low] < 0.0:
        yield Problem(
            path=(*TABLE, "torque", low),
            message="a motor that turns slower than its field does not brake",
            found=f"{torque[low]:.6g} N*m in row {low + 1}",
            allowed=">= 0 N*m at every slip",
            hint="the torque of the table is on the rotor, in the sense of rotation",
        )
    elif not any(torque):
        yield Problem(
            path=(*TABLE, "torque"),
            message="the motor has no torque at any slip",
            found=f"0 N*m in all {len(torque)} rows",
            allowed="a torque above zero",
        )


def _start(case: Case, motor: Motor) -> Iterator[Problem]:
    """A start at a slip that the table does not reach cannot be followed."""
    study = None if case.response is None else case.response.start_up
    if study is None or motor.kind != "slip_table" or motor.beyond == "hold":
        return
    slip, largest = abs(motor.synchronous_speed - study.speed), motor.slip_table.slip[-1]
    if slip > largest * (1.0 + 1e-12):
        yield Problem(
            path=(*TABLE, "slip", len(motor.slip_table.slip) - 1),
            message="the start lies beyond the slip table",
            found=f"a last slip of {largest:.6g} rad/s, and {slip:.6g} rad/s at the start",
            allowed=f"rows up to {slip:.6g} rad/s, or beyond = 'hold' for the last torque there",
            also=START,
        )
