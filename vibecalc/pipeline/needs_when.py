"""Conditions on a case, read from the case alone, under which a module is needed.

True is needed, False is not, None is perhaps: it hangs on what is computed.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING

from vibecalc.case.engine_mounted import driven_machine, shakes_with_torque
from vibecalc.case.kinds import finds_speed, has_speed

if TYPE_CHECKING:
    from vibecalc.case.schema import Case

Rule = Callable[["Case"], bool | None]
#: freedoms of a shaft line from which modes are worth an import of scipy
_LONG_LINE = 64


def perhaps_if(rule: Rule) -> Rule:
    """Perhaps where `rule` holds, else not."""
    return lambda case: None if rule(case) else False


def unless(rule: Rule) -> Rule:
    """Where `rule` does not hold."""
    return lambda case: not rule(case)


def perhaps(case: "Case") -> None:
    return None


def always(case: "Case") -> bool:
    return True


def never(case: "Case") -> bool:
    return False


def has_curves(case: "Case") -> bool:
    return case.kinematics is not None


def bears_torque(case: "Case") -> bool:
    return has_speed(case.machine) and shakes_with_torque(case)


def rod_is_placed(case: "Case") -> bool:
    train = case.machine.crank_train
    return train.rod is not None and train.rod.crank_pin_to_mass_centre is not None


def rod_has_inertia(case: "Case") -> bool:
    rod = case.machine.crank_train.rod
    return rod is not None and rod.inertia is not None


def has_matrices(case: "Case") -> bool:
    body, mounts = case.machine.body, case.machine.mounts
    return (body is not None and body.mass_matrix is not None) or (
        mounts is not None and mounts.stiffness_matrix is not None
    )


def has_mass_matrix(case: "Case") -> bool:
    return case.machine.body is not None and case.machine.body.mass_matrix is not None


def has_parts(case: "Case") -> bool:
    body, mounts = case.machine.body, case.machine.mounts
    return (body is not None and body.mass_matrix is None) or (
        mounts is not None and mounts.stiffness_matrix is None
    )


def computes_cycle(case: "Case") -> bool:
    return case.machine.crank_train.gas_cycle is not None


def has_pump_cycle(case: "Case") -> bool:
    train = case.machine.crank_train
    return train is not None and train.pump_cycle is not None


def is_planar(case: "Case") -> bool:
    return case.isolation is not None and case.isolation.model == "planar"


def has_impact(case: "Case") -> bool:
    return case.response is not None and case.response.impact is not None


def has_primary(case: "Case") -> bool:
    return case.machine.primary is not None


def has_several(case: "Case") -> bool:
    return bool(case.machine.secondaries)


def has_pendulum(case: "Case") -> bool:
    return case.machine.pendulum is not None


def warms(case: "Case") -> bool:
    return case.tuning is not None and case.tuning.temperatures is not None


def has_limits(case: "Case") -> bool:
    torsion = None if case.response is None else case.response.torsion
    return torsion is not None and bool(torsion.limits)


def long_line(case: "Case") -> bool | None:
    line = case.machine.shaft_line
    if line is None:
        return False
    return None if len(line.stations) + len(line.dampers) >= _LONG_LINE else False


def has_line(case: "Case") -> bool:
    return case.machine.shaft_line is not None


def turns_with_the_engine(case: "Case") -> bool:
    return has_line(case) and driven_machine(case) == "on_body"


def marches(case: "Case") -> bool | None:
    roll = None if case.response is None else case.response.roll
    return roll is not None and "dop853" in (roll.method, *roll.compare)


def is_dynamic(case: "Case") -> bool:
    motor = case.machine.motor
    return motor is not None and motor.kind == "dynamic"


def has_study(case: "Case") -> bool:
    return case.optimisation is not None


def has_methods(case: "Case") -> bool:
    study = case.optimisation
    return study is not None and bool(study.compare or study.method)


def has_sensitivity(case: "Case") -> bool:
    return case.optimisation is not None and bool(case.optimisation.sensitivity)


def has_front(case: "Case") -> bool:
    return case.optimisation is not None and bool(case.optimisation.second_objective)


def has_finds(case: "Case") -> bool:
    return bool(case.find)


def has_axes(case: "Case") -> bool:
    return case.sweep is not None and bool(case.sweep.axes)


def speed_is_found(case: "Case") -> bool:
    return finds_speed(case.machine)


def has_measurement(case: "Case") -> bool:
    return case.measurement is not None


def has_transient(case: "Case") -> bool:
    torsion = None if case.response is None else case.response.torsion
    return torsion is not None and torsion.transient is not None


def gas_is_cubic(case: "Case") -> bool | None:
    roll = None if case.response is None else case.response.roll
    if roll is not None and roll.interpolations:
        return True
    return speed_is_found(case) and case.machine.crank_train.gas_interpolation == "cubic"


def slip_is_monotone(case: "Case") -> bool | None:
    motor = case.machine.motor
    table = motor is not None and motor.slip_table is not None
    return perhaps_if(speed_is_found)(case) if table else False
