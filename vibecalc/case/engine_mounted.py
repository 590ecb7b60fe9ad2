"""Does the torque of the cylinders of an engine or a pump reach its mounts?"""

from typing import TYPE_CHECKING

from vibecalc.case.engine_firing import TURN, cycle_angle
from vibecalc.case.kinds import gas_turns

if TYPE_CHECKING:
    from vibecalc.case.schema import Case


def torque_reaches_mounts(case: "Case") -> bool:
    """Whether a rigid body on mounts feels the torque of what is in the cylinders."""
    options, machine = case.isolation, case.machine
    if not gas_turns(machine) or options is None or options.model == "pitch":
        return False
    return has_gas(case) and _fires(case) and driven_machine(case) != "cancels_torque"


def driven_machine(case: "Case") -> str:
    """Where the driven machine stands, and what of the torque it gives back."""
    return "on_body" if case.excitation is None else case.excitation.driven_machine


def is_separate(case: "Case") -> bool:
    """Whether the driven machine stands elsewhere."""
    return driven_machine(case) == "separate"


def shakes_with_torque(case: "Case") -> bool:
    """Whether the couple of the crank train holds minus the torque of its masses.

    Not with a shaft line on the body: what of the torque arrives there the line says, and the
    torque reaction has it.
    """
    where = driven_machine(case)
    return where == "separate" or (where == "on_body" and case.machine.shaft_line is None)


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
