"""Physical checks of the roll of a machine: what is refused and what is only unlikely."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.errors import KeyPath, Problem
from vibecalc.kinds import asks_roll, finds_speed, has_crank_train, working
from vibecalc.numerics.rounding import BoolArray
from vibecalc.parts.crank_train import build_crank_train, rod_share, working_names
from vibecalc.parts.firing import shakes_with_torque
from vibecalc.roll.tables import STEPPING
from vibecalc.schema import Case

if TYPE_CHECKING:
    from vibecalc.roll.tables import Roll

# ----------------------------------------------------------------------------
# Can rotor, pistons and shell move like this, and can that motion be followed as asked?
# ----------------------------------------------------------------------------

CYLINDERS: KeyPath = ("machine", "crank_train", "cylinders")
ROLL: KeyPath = ("response", "roll")
#: Nodes of one panel: more of them lose digits, since they crowd at its ends.
MOST_NODES = 32
#: Steps of one turn: below, the highest harmonic has fewer than four samples in its period.
FEWEST_IN_A_PERIOD = 4
MOST_STEPS = 2_000_000


def roll_problems(case: Case) -> list[Problem]:
    """Problems of pistons, of the steady motion asked for, and of the load at start-up."""
    if not (asks_roll(case) and has_crank_train(case.machine) and finds_speed(case.machine)):
        return []
    response = case.response
    problems = [*_pistons(case), *_drifting(case)]
    if response is not None and response.roll is not None:
        problems += [*_start(case, response.roll), *_work(case, response.roll)]
    return problems


def roll_suspects(case: Case) -> BoolArray:
    """Points (...) of a case with arrays that `roll_problems` may refuse."""
    train, shell, motor = case.machine.crank_train, case.machine.shell, case.machine.motor
    response = case.response
    if shell is None or motor is None or response is None or response.roll is None:
        return np.zeros((), dtype=bool)
    sprung, damped = np.asarray(shell.stiffness) != 0.0, np.asarray(shell.damping) != 0.0
    found = damped & ~sprung
    if response.roll.started_at is not None:
        started = np.asarray(response.roll.started_at)
        found = found | sprung | damped | (started > 2.0 * motor.synchronous_speed)
    share = 0.0 if train.rod is None else train.rod.mass * rod_share(train)
    for cylinder in train.cylinders:
        if cylinder.reciprocating_mass is not None:
            found = found | (np.asarray(cylinder.reciprocating_mass) < share)
    return np.asarray(found)


def _pistons(case: Case) -> Iterator[Problem]:
    """Of a mass that has the rod's share in it, something has to be left for the piston."""
    train = case.machine.crank_train
    works = working_names(train, working(case))
    share = 0.0 if train.rod is None else train.rod.mass * rod_share(train)
    for place, cylinder in enumerate(train.cylinders):
        mass = cylinder.reciprocating_mass
        if mass is not None and mass < share and cylinder.name in works:
            yield Problem(
                path=(*CYLINDERS, place, "reciprocating_mass"),
                message=f"the piston of cylinder {cylinder.name!r} has a negative mass: what "
                "moves with it includes the rod's share",
                found=f"{mass:.6g} kg, with {share:.6g} kg of the rod",
                allowed=f">= {share:.6g} kg",
                also=("machine", "crank_train", "rod"),
            )


def _drifting(case: Case) -> Iterator[Problem]:
    """A shell that is damped, and not held, may repeat its motion at any angle."""
    shell, response = case.machine.shell, case.response
    control = None if response is None else response.control
    periodic = response is not None and response.roll is not None
    periodic |= control is not None and control.full_model
    if periodic and shell is not None and shell.damping and not shell.stiffness:
        yield Problem(
            path=("machine", "shell", "damping"),
            message="with damping and no stiffness the shell drifts: it has no steady position",
            found=f"{shell.damping:.6g} N*m*s/rad, and no stiffness",
            allowed="damping together with a stiffness, or neither of them",
            hint="the stiffness of very soft mounts hardly matters",
            also=("machine", "shell", "stiffness"),
        )


def _start(case: Case, roll: "Roll") -> Iterator[Problem]:
    shell, motor = case.machine.shell, case.machine.motor
    if roll.started_at is None or shell is None or motor is None:
        return
    if shell.stiffness or shell.damping:
        yield Problem(
            path=(*ROLL, "started_at"),
            message="started_at fixes the angular momentum, which is not constant on mounts",
            found=f"mounts of {shell.stiffness:.6g} N*m/rad and {shell.damping:.6g} N*m*s/rad",
            allowed="no started_at, or a shell without stiffness and damping",
            hint="on mounts the steady motion does not depend on the start",
            also=("machine", "shell", "stiffness" if shell.stiffness else "damping"),
        )
    elif roll.started_at > 2.0 * motor.synchronous_speed:
        yield Problem(
            path=(*ROLL, "started_at"),
            message="the machine cannot have been started at more than twice its synchronous speed",
            found=f"{roll.started_at:.6g} rad/s",
            allowed=f"<= {2.0 * motor.synchronous_speed:.6g} rad/s",
            hint="speeds are in rad/s unless they carry a unit, as in '900 rpm'",
            also=("machine", "motor", "synchronous_speed"),
        )


def _work(case: Case, roll: "Roll") -> Iterator[Problem]:
    """Points and steps against the highest order."""
    motor, methods = case.machine.motor, (roll.method, *roll.compare)
    # the points are those of the first method that has any
    method = next((name for name in methods if name in ("collocation", "fourier")), "")
    if roll.points is not None and method == "fourier" and roll.points <= 2 * roll.orders:
        yield Problem(
            path=(*ROLL, "points"),
            message="the points of a revolution resolve only orders below half their number",
            found=f"{roll.points} points for {roll.orders} orders",
            allowed=f"> {2 * roll.orders} points, or fewer orders",
            also=(*ROLL, "orders"),
        )
    elif roll.points is not None and method == "collocation" and roll.points > MOST_NODES:
        yield Problem(
            path=(*ROLL, "points"),
            message="so many nodes in one panel gain nothing",
            found=str(roll.points),
            allowed=f"1 to {MOST_NODES} nodes in each panel",
        )
    if roll.step is None or motor is None or not any(name in STEPPING for name in methods):
        return
    turn = 2.0 * math.pi / motor.synchronous_speed
    longest = turn / (FEWEST_IN_A_PERIOD * roll.orders)
    if roll.step > longest:
        yield Problem(
            path=(*ROLL, "step"),
            message=f"the step is too long for order {roll.orders}: fewer than "
            f"{FEWEST_IN_A_PERIOD} steps per period",
            found=f"{roll.step:.6g} s",
            allowed=f"<= {longest:.3g} s, or fewer orders",
            also=(*ROLL, "orders"),
        )
    elif turn > MOST_STEPS * roll.step:
        yield Problem(
            path=(*ROLL, "step"),
            message="steps this short take too many of them",
            found=f"{roll.step:.6g} s: {turn / roll.step:.3g} steps in a turn",
            allowed=f">= {turn / MOST_STEPS:.3g} s",
        )


# ----------------------------------------------------------------------------
# What is possible but unlikely in the roll of a machine, and what has no effect on it.
# ----------------------------------------------------------------------------

SENTENCE = "only the roll of the machine uses it: [response.roll], start_up or control"


def roll_cautions(case: Case) -> list[str]:
    """Sentences for the report, on a case without problems."""
    if not asks_roll(case):
        return list(_unused(case))
    if not (has_crank_train(case.machine) and finds_speed(case.machine)):
        return []
    return [
        *_step(case),
        *_unlikely_pistons(case),
        *_demand(case),
        *_line(case),
        *_unlikely_start(case),
    ]


def _unused(case: Case) -> Iterator[str]:
    machine = case.machine
    parts = {
        "[machine.motor]": machine.motor is not None and finds_speed(machine),
        "[machine.rotor]": machine.rotor is not None and not _turns_unsteadily(case),
        "[machine.shell]": machine.shell is not None,
        "[machine.friction]": machine.friction is not None,
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
            f"response.roll.step has no effect: it applies to {' and '.join(STEPPING)}, "
            "and neither method nor compare names one of them"
        )


def _unlikely_pistons(case: Case) -> Iterator[str]:
    from vibecalc.roll.model import gas_tables

    train = build_crank_train(case.machine.crank_train)
    works, tables = working_names(case.machine.crank_train, working(case)), gas_tables(case)
    loaded = {name for name, table in zip(train.names, tables, strict=True) if table is not None}
    without = [repr(name) for name in works if name not in loaded]
    if loaded and without:
        yield (
            f"no gas acts in cylinder {', '.join(without)}, unlike in the others: it has no "
            "gas_force, and the crank train no gas_pressure with a bore"
        )
    for name, mass in zip(train.names, train.reciprocating_mass, strict=True):
        if name in works and mass == 0.0:
            yield f"the reciprocating mass of cylinder '{name}' is 0 kg"


def _demand(case: Case) -> Iterator[str]:
    """Mean torque that gas and friction take, against the largest of the motor."""
    from vibecalc.roll.model import mean_demand, motor_curve

    motor = case.machine.motor
    if motor is None or motor.kind == "linear":
        return
    from vibecalc.excitation.slip_torque import breakdown

    largest, demand = breakdown(motor_curve(motor))[1], mean_demand(case)
    if demand > largest:
        yield (
            f"gas and friction need a mean torque of about {demand:.4g} N*m, above the breakdown "
            f"torque of the motor, {largest:.4g} N*m: there may be no running state"
        )


def _line(case: Case) -> Iterator[str]:
    from vibecalc.roll.motor_checks import dynamic_cautions

    motor = case.machine.motor
    if motor is not None and motor.kind == "dynamic":
        yield from dynamic_cautions(motor)


def _unlikely_start(case: Case) -> Iterator[str]:
    motor = case.machine.motor
    study = None if case.response is None else case.response.start_up
    if motor is None or study is None:
        return
    if motor.kind == "slip_table":
        slip, last = abs(motor.synchronous_speed - study.speed), motor.slip_table.slip[-1]
        if slip > last:
            yield (
                f"the start at a slip of {slip:.4g} rad/s is beyond the motor's table, which "
                f"ends at {last:.4g} rad/s: its last torque, {motor.slip_table.torque[-1]:.4g} "
                "N*m, is used"
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
