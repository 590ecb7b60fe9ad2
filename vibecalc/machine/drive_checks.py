"""Do the tables that drive a machine make sense: gas pressure over a turn, torque of a motor?"""

import math
from collections.abc import Iterator

from vibecalc.case.schema import Case
from vibecalc.errors import KeyPath, Problem

PRESSURE: KeyPath = ("machine", "crank_train", "gas_pressure")
TORQUE: KeyPath = ("machine", "motor", "torque")
TURN = 2.0 * math.pi
#: rad; angles in degrees are a turn apart to rounding only
CLOSED = 1e-9
#: Pa, below the pressure of the crankcase: an empty cylinder
VACUUM = -1e5


def drive_problems(case: Case) -> list[Problem]:
    """Problems of the tables of gas pressure and of motor torque."""
    return [*_pressure(case), *_torque(case)]


def _pressure(case: Case) -> Iterator[Problem]:
    table = case.machine.crank_train.gas_pressure
    if table is None:
        return
    angle, pressure = table.crank_angle, table.pressure
    back = [n for n in range(1, len(angle)) if not angle[n] > angle[n - 1]]
    if back:
        last = back[0]
        yield Problem(
            path=(*PRESSURE, "crank_angle", last),
            message="the crank angles of the gas pressure have to ascend",
            found=f"{_degrees(angle[last - 1])}, then {_degrees(angle[last])}, in rows "
            f"{last} and {last + 1}",
            allowed="each larger than the one before it",
        )
    elif abs(angle[-1] - angle[0] - TURN) > CLOSED:
        yield Problem(
            path=(*PRESSURE, "crank_angle"),
            message="the crank angles of the gas pressure have to span one turn",
            found=f"from {_degrees(angle[0])} to {_degrees(angle[-1])}",
            allowed=f"a last angle of {_degrees(angle[0] + TURN)}",
            hint="the last row repeats the pressure of the first one",
        )
    elif abs(pressure[-1] - pressure[0]) > 1e-9 * max(map(abs, pressure)):
        yield Problem(
            path=(*PRESSURE, "pressure"),
            message="the gas pressure after a turn has to be that before it",
            found=f"{pressure[0]:.9g} Pa in the first row, {pressure[-1]:.9g} Pa in the last",
            allowed="the same pressure in the first and the last row",
        )
    low = min(range(len(pressure)), key=lambda row: pressure[row])
    if pressure[low] < VACUUM:
        yield Problem(
            path=(*PRESSURE, "pressure", low),
            message="the gas pressure is lower than that of an empty cylinder",
            found=f"{pressure[low]:.6g} Pa in row {low + 1}",
            allowed=f">= {VACUUM:.0f} Pa, counted from the pressure of the crankcase",
        )


def _torque(case: Case) -> Iterator[Problem]:
    if case.machine.motor is None:
        return
    seen: dict[int, int] = {}
    for row, order in enumerate(case.machine.motor.torque.order):
        if order in seen:
            yield Problem(
                path=(*TORQUE, "order", row),
                message=f"order {order} of the torque stands twice",
                found=f"rows {seen[order] + 1} and {row + 1}",
                allowed="each order once",
                also=(*TORQUE, "order", seen[order]),
            )
        seen.setdefault(order, row)


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.9g} deg"
