"""Do the tables that drive a machine make sense: gas pressure over a turn, torque of a motor?"""

from collections.abc import Iterator

from vibecalc.case.engine_firing import cycle_angle
from vibecalc.case.gas_parts import GasPressure
from vibecalc.case.kinds import finds_speed, has_crank_train
from vibecalc.case.schema import Case
from vibecalc.errors import KeyPath, Problem
from vibecalc.machine.turn_checks import quoted, turn_problems

PRESSURE: KeyPath = ("machine", "crank_train", "gas_pressure")
TORQUE: KeyPath = ("machine", "motor", "torque")
#: Pa, below the pressure of the crankcase: an empty cylinder
VACUUM = -1e5


def drive_problems(case: Case) -> list[Problem]:
    """Problems of the tables of gas pressure and of motor torque by order."""
    return [*_pressure(case), *_torque(case)]


def _pressure(case: Case) -> Iterator[Problem]:
    if not has_crank_train(case.machine):
        return
    table = case.machine.crank_train.gas_pressure
    if table is None:
        return
    yield from pressure_problems(PRESSURE, table, cycle_angle(case.machine))


def pressure_problems(path: KeyPath, table: GasPressure, period: float) -> Iterator[Problem]:
    """Problems of a table of gas pressure at `path` over `period`, rad: a turn, or a cycle."""
    pressure = table.pressure
    yield from turn_problems(
        path, "gas pressure", table.crank_angle, "pressure", pressure, "Pa", period
    )
    low = min(range(len(pressure)), key=lambda row: pressure[row])
    if pressure[low] < VACUUM:
        yield Problem(
            path=(*path, "pressure", low),
            message="the gas pressure is lower than that of an empty cylinder",
            found=f"{quoted(pressure[low], 'Pa')} in row {low + 1}",
            allowed=f">= {quoted(VACUUM, 'Pa')}, counted from the pressure of the crankcase",
        )


def _torque(case: Case) -> Iterator[Problem]:
    if case.machine.motor is None or finds_speed(case.machine):
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
