"""Does the torque of the cylinders of an engine or a pump reach its mounts?"""

from typing import TYPE_CHECKING

from vibecalc.case.engine_firing import TURN, cycle_angle
from vibecalc.case.kinds import gas_turns

if TYPE_CHECKING:
    from vibecalc.case.schema import Case


def torque_reaches_mounts(case: "Case") -> bool:
    """Whether a rigid body on mounts feels the torque of what is in the cylinders.

    With the driven machine on the body that takes a shaft line: at a constant speed of the crank
    the machine gives back all of the torque, and nothing is left.
    """
    options, machine = case.isolation, case.machine
    if not gas_turns(machine) or options is None or options.model == "pitch":
        return False
    return has_gas(case) and _fires(case) and (is_separate(case) or machine.shaft_line is not None)


def is_separate(case: "Case") -> bool:
    """Whether the driven machine stands elsewhere."""
    return case.excitation is not None and case.excitation.driven_machine == "separate"


def has_gas(case: "Case") -> bool:
    """Whether the case says anything of the pressure in its cylinders."""
    train = case.machine.crank_train
    return bool(train.gas_pressure or train.gas_cards or train.gas_cycle or train.pump_cycle)


def _fires(case: "Case") -> bool:
    """Whether the case says when its cylinders fire; where a cycle is a turn the throws do."""
    train = case.machine.crank_train
    if cycle_angle(case.machine) == TURN:
        return True
    told = bool(train.firing_order) or any(c.firing_angle is not None for c in train.cylinders)
    return told or len(train.cylinders) == 1
