"""Does the torque of an engine's cylinders reach its mounts?"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vibecalc.case.schema import Case


def torque_reaches_mounts(case: "Case") -> bool:
    """Whether a rigid body on mounts feels the gas torque of an engine.

    With the driven machine on the body that takes a shaft line: at a constant speed of the crank
    the machine gives back all of the torque, and nothing is left.
    """
    options, machine = case.isolation, case.machine
    if machine.kind != "engine" or options is None or options.model != "rigid_body":
        return False
    return has_gas(case) and _fires(case) and (is_separate(case) or machine.shaft_line is not None)


def is_separate(case: "Case") -> bool:
    """Whether the driven machine stands elsewhere."""
    return case.excitation is not None and case.excitation.driven_machine == "separate"


def has_gas(case: "Case") -> bool:
    """Whether the case says anything of the pressure in its cylinders."""
    train = case.machine.crank_train
    return bool(train.gas_pressure or train.gas_cards or train.gas_cycle)


def _fires(case: "Case") -> bool:
    """Whether the case says when its cylinders fire; in two strokes the throws do."""
    train = case.machine.crank_train
    told = bool(train.firing_order) or any(c.firing_angle is not None for c in train.cylinders)
    return told or case.machine.cycle == "two_stroke" or len(train.cylinders) == 1
