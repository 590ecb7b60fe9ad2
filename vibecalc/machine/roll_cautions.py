"""What is possible but unlikely in the roll of a machine, and what has no effect on it."""

import math
from collections.abc import Iterator

from vibecalc.case.kinds import finds_speed, has_crank_train
from vibecalc.case.roll_form import STEPPING
from vibecalc.case.schema import Case
from vibecalc.parts.crank_train import build_crank_train, working_names
from vibecalc.parts.firing import shakes_with_torque

SENTENCE = "only the roll of the machine uses it: [response.roll], start_up or control"


def asks_roll(case: Case) -> bool:
    """Whether anything is asked that the motor finds the speed of."""
    response = case.response
    if response is None:
        return False
    asked = (response.roll, response.start_up, response.control)
    return any(table is not None for table in asked)


def roll_cautions(case: Case) -> list[str]:
    """Sentences for the report, on a case without problems."""
    if not asks_roll(case):
        return list(_unused(case))
    if not (has_crank_train(case.machine) and finds_speed(case.machine)):
        return []
    return [*_step(case), *_pistons(case), *_demand(case), *_line(case), *_start(case)]


def _unused(case: Case) -> Iterator[str]:
    machine = case.machine
    train = machine.crank_train if has_crank_train(machine) else None
    parts = {
        "[machine.motor]": machine.motor is not None and finds_speed(machine),
        "[machine.rotor]": machine.rotor is not None and not _turns_unsteadily(case),
        "[machine.shell]": machine.shell is not None,
        "[machine.friction]": machine.friction is not None,
        "the gas force of a cylinder": train is not None
        and any(cylinder.gas_force for cylinder in train.cylinders),
    }
    for name, there in parts.items():
        if there:
            yield f"{name} has no effect: {SENTENCE}"


def _turns_unsteadily(case: Case) -> bool:
    """Whether the inertia of the rotor counts at a given speed of the crank."""
    shaken = (case.excitation, case.isolation, case.response)
    driven = has_crank_train(case.machine) and not finds_speed(case.machine)
    return driven and any(part is not None for part in shaken) and shakes_with_torque(case)


def _step(case: Case) -> Iterator[str]:
    roll = None if case.response is None else case.response.roll
    if roll is None or roll.step is None:
        return
    if not any(method in STEPPING for method in (roll.method, *roll.compare)):
        yield (
            f"response.roll.step has no effect: it is for the methods {' and '.join(STEPPING)}, "
            "and neither method nor compare names one of them"
        )


def _pistons(case: Case) -> Iterator[str]:
    from vibecalc.machine.roll import gas_tables

    train = build_crank_train(case.machine.crank_train)
    works, tables = working_names(case.machine.crank_train, case.excitation), gas_tables(case)
    loaded = {name for name, table in zip(train.names, tables, strict=True) if table is not None}
    without = [repr(name) for name in works if name not in loaded]
    if loaded and without:
        yield (
            f"no gas acts in cylinder {', '.join(without)}, unlike in the others: it has no "
            "gas_force, and the crank train no gas_pressure with a bore"
        )
    for name, mass in zip(train.names, train.reciprocating_mass, strict=True):
        if name in works and mass == 0.0:
            yield f"what moves with the piston of cylinder '{name}' has a mass of 0 kg"


def _demand(case: Case) -> Iterator[str]:
    """Mean torque that gas and friction take, against the largest of the motor."""
    from vibecalc.machine.roll import mean_demand, motor_curve

    motor = case.machine.motor
    if motor is None or motor.kind == "linear":
        return
    from vibecalc.excitation.slip_torque import breakdown

    largest, demand = breakdown(motor_curve(motor))[1], mean_demand(case)
    if demand > largest:
        yield (
            f"gas and friction take about {demand:.4g} N*m in the mean over a turn, and the motor "
            f"gives {largest:.4g} N*m at most: there may be no running state"
        )


def _line(case: Case) -> Iterator[str]:
    from vibecalc.machine.dynamic_checks import dynamic_cautions

    motor = case.machine.motor
    if motor is not None and motor.kind == "dynamic":
        yield from dynamic_cautions(motor)


def _start(case: Case) -> Iterator[str]:
    motor = case.machine.motor
    study = None if case.response is None else case.response.start_up
    if motor is None or study is None:
        return
    if motor.kind == "slip_table":
        slip, last = abs(motor.synchronous_speed - study.speed), motor.slip_table.slip[-1]
        if slip > last:
            yield (
                f"the start at a slip of {slip:.4g} rad/s lies beyond the motor's table, which "
                f"ends at {last:.4g} rad/s: its last torque, {motor.slip_table.torque[-1]:.4g} "
                "N*m, is held"
            )
    if study.load is not None and study.load.time[-1] >= study.duration:
        yield (
            f"the load changes at {study.load.time[-1]:.4g} s, after the end of the start-up at "
            f"{study.duration:.4g} s"
        )
    if abs(study.crank_angle) > 4.0 * math.pi + 1e-6:
        yield (
            f"the start-up begins at a crank angle of {study.crank_angle:.6g} rad, more than two "
            f"turns: should it be '{study.crank_angle:.6g} deg'?"
        )
