"""The cylinders of a pump as arrays: the liquid of a case, and its pressure over a turn."""

from functools import lru_cache

from vibecalc.case.schema import Machine
from vibecalc.excitation import pump_cycle
from vibecalc.excitation.cylinder_torque import CrankGeometry
from vibecalc.excitation.gas_card import GasCard
from vibecalc.excitation.pump_cycle import Liquid
from vibecalc.machine.engine import crank_geometry


def liquid_of(machine: Machine) -> Liquid:
    """What the cylinders of a validated pump work with."""
    given = machine.crank_train.pump_cycle
    if given is None:
        raise ValueError("the case has no pump_cycle")
    return Liquid(**given.model_dump())


def pump_card(machine: Machine) -> GasCard:
    """The pressure on a plunger; NumericalFailure where a pump draws nothing."""
    return _card(liquid_of(machine), crank_geometry(machine))


# the stages of the pump and of its mounts ask for the same one
@lru_cache(maxsize=16)
def _card(liquid: Liquid, geometry: CrankGeometry) -> GasCard:
    card = pump_cycle.pump_card(liquid, geometry)
    for array in (card.node, card.coefficient):
        array.flags.writeable = False
    return card
