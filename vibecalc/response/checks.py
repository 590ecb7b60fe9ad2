"""Can the machine change from one operation to another?"""

from collections.abc import Iterator
from functools import partial

import numpy as np

from vibecalc.errors import KeyPath, Problem
from vibecalc.kinds import has_crank_train
from vibecalc.parts import body_tables as parts
from vibecalc.parts.firing import driven_machine, shakes_with_torque
from vibecalc.parts.mount_needs import mount_properties
from vibecalc.parts.mount_state import never_held
from vibecalc.parts.mounts import has_loss_factor
from vibecalc.schema import Case

SWITCHING: KeyPath = ("response", "switching")
MOUNTS: KeyPath = ("machine", "mounts")


def operation_problems(case: Case) -> Iterator[Problem]:
    """Problems of [response.switching]."""
    asked = case.response is not None and case.response.switching is not None
    if not asked or not has_crank_train(case.machine):
        return
    if shakes_with_torque(case):
        reported = (
            case.excitation is not None and "driven_machine" in case.excitation.model_fields_set
        )
        yield Problem(
            path=SWITCHING,
            message="a change between operations is computed without the torque of the masses on "
            "the body",
            found=f"driven_machine = '{driven_machine(case)}'"
            + ("" if reported else ", the default"),
            allowed="driven_machine = 'cancels_torque' in [excitation]",
            hint="that torque is not linear in the acceleration of the crank, so the steady "
            "orders do not give it while the speed changes",
            also=("excitation", "driven_machine") if reported else None,
        )
    mounts = case.machine.mounts
    if mounts is None:
        return
    if mounts.stiffness_matrix is None and (free := never_held(case)):
        yield Problem(
            path=MOUNTS,
            message="a change between operations needs a body that its mounts restrain",
            found="nothing resists " + ", ".join(free),
            allowed="a stiffness against each of the six motions",
            also=SWITCHING,
        )
    if _decays(mounts):
        return
    undamped = partial(
        Problem,
        path=MOUNTS,
        allowed="modal_damping, a damping_matrix, or mounts with damping",
        also=SWITCHING,
    )
    if has_loss_factor(mounts):
        yield undamped(
            message="a loss factor describes steady vibration at one frequency, not how a motion "
            "decays in time, and this body has no other damping",
            found="a loss_factor and no other damping",
            hint="half the loss factor is the damping ratio at resonance: modal_damping",
        )
    else:
        yield undamped(
            message="a change between operations needs damping: without it the body never settles",
            hint="modal_damping = 0.03 gives every mode a damping ratio of 3 %",
        )


def _decays(mounts: parts.Mounts) -> bool:
    """Tell whether anything viscous damps the body."""
    matrix = mounts.damping_matrix
    each = (properties.damping for properties in mount_properties(mounts))
    given = (mounts.modal_damping, None if matrix is None else matrix.values, *each)
    return any(one is not None and np.any(one) for one in given)
