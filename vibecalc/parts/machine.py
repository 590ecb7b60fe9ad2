"""All parts of one machine, built from a validated case."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from vibecalc.kinds import has_crank_train
from vibecalc.parts.body import RigidBody, build_body
from vibecalc.parts.crank_train import (
    CrankTrain,
    RotatingMasses,
    build_crank_train,
    build_rotating_masses,
    moving,
)
from vibecalc.parts.mount_state import mounts_of
from vibecalc.parts.mounts import Mounts
from vibecalc.schema import Case


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class MachineParts:
    """What stages read of a machine; a part that the case leaves out is None.

    So is the crank train of a kind that does without; no stage is planned then that reads it.
    """

    crank_train: CrankTrain
    rotating_masses: RotatingMasses
    body: RigidBody | None
    mounts: Mounts | None


def _train(case: Case) -> CrankTrain | None:
    if not has_crank_train(case.machine):
        return None
    train, options = build_crank_train(case.machine.crank_train), case.excitation
    return train if options is None else moving(train, options.working, options.idle)


def _rotating(case: Case) -> RotatingMasses | None:
    return build_rotating_masses(case) if has_crank_train(case.machine) else None


def _body(case: Case) -> RigidBody | None:
    body = case.machine.body
    return None if body is None or body.mass_matrix is not None else build_body(body)


#: part -> what builds it
PARTS: dict[str, Callable[[Case], Any]] = {
    "crank_train": _train,
    "rotating_masses": _rotating,
    "body": _body,
    "mounts": mounts_of,
}


def build_machine(case: Case) -> MachineParts:
    """Arrays of every part that the case has.

    `[excitation]` says which cylinders work; `crank_train` has the moving masses of these alone.
    A body given as a mass matrix, or mounts given as a stiffness matrix, are no parts: see
    `system.py`.
    """
    return MachineParts(**{name: build(case) for name, build in PARTS.items()})
