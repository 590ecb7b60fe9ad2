"""Does a pump draw anything?"""

import math

from vibecalc.case.schema import Case
from vibecalc.errors import KeyPath, Problem
from vibecalc.machine.crank_train_checks import turns

CYCLE: KeyPath = ("machine", "crank_train", "pump_cycle")
#: pressure difference over bulk modulus: below, a compression takes no angle that could be followed
STIFFEST = 1e-6


def pump_problems(case: Case) -> list[Problem]:
    """Problems of dead volume and bulk modulus, which have to leave something to be drawn."""
    if case.machine.kind != "pump" or not turns(case.machine.crank_train):
        return []
    train = case.machine.crank_train
    given, bore = train.pump_cycle, train.bore
    if given is None or bore is None:
        return []
    strain = (given.discharge_pressure - given.suction_pressure) / given.bulk_modulus
    if strain < STIFFEST:
        return [
            Problem(
                path=(*CYCLE, "bulk_modulus"),
                message="the liquid is too stiff for its pressures: its valves would open at once",
                found=f"it gives way by {strain:.3g} of its volume",
                allowed=f"{STIFFEST:g} or more: water and oil have 1.5 to 2.3 GPa",
                also=(*CYCLE, "discharge_pressure"),
            )
        ]
    # the offset makes the stroke a little longer than this, which draws a little more
    swept = 0.5 * math.pi * bore**2 * train.crank_radius
    expanded = given.dead_volume * math.expm1(min(strain, 50.0))
    if expanded < swept:
        return []
    return [
        Problem(
            path=(*CYCLE, "dead_volume"),
            message="the pump draws nothing: what it leaves in the dead volume expands by more "
            "than the plunger sweeps",
            found=f"{1e6 * expanded:.4g} cm^3 of {1e6 * swept:.4g} cm^3",
            allowed=f"dead_volume below {1e6 * swept / math.expm1(min(strain, 50.0)):.4g} cm^3 "
            "at these pressures",
            also=(*CYCLE, "bulk_modulus"),
        )
    ]
