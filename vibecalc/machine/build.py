"""All parts of one machine, built from a validated case."""

from dataclasses import dataclass
from typing import Any

from vibecalc.case.kinds import has_crank_train
from vibecalc.case.schema import Machine
from vibecalc.case.tables import Excitation
from vibecalc.machine.body import RigidBody, build_body
from vibecalc.machine.crank_train import (
    CrankTrain,
    RotatingMasses,
    build_crank_train,
    build_rotating_masses,
    moving,
)
from vibecalc.machine.mounts import Mounts, build_mounts


@dataclass(frozen=True, kw_only=True)
class MachineParts:
    """What stages read of a machine; a part that the case leaves out is None.

    So is the crank train of a kind that does without; no stage is planned then that reads it.
    """

    crank_train: CrankTrain
    rotating_masses: RotatingMasses
    body: RigidBody | None
    mounts: Mounts | None


def build_machine(machine: Machine, options: Excitation | None = None) -> MachineParts:
    """Arrays of every part that the case has.

    `options` says which cylinders work; `crank_train` then has the moving masses of these alone.
    A body given as a mass matrix, or mounts given as a stiffness matrix, are no parts: see
    `system.py`.
    """
    body, mounts = machine.body, machine.mounts
    train, rotating = _turning(machine, options)
    return MachineParts(
        crank_train=train,
        rotating_masses=rotating,
        body=None if body is None or body.mass_matrix is not None else build_body(body),
        mounts=None
        if mounts is None or mounts.stiffness_matrix is not None
        else build_mounts(mounts),
    )


def _turning(machine: Machine, options: Excitation | None) -> tuple[CrankTrain, RotatingMasses]:
    if not has_crank_train(machine):
        nothing: Any = None
        return nothing, nothing
    train = build_crank_train(machine.crank_train)
    if options is not None:
        train = moving(train, options.working, options.idle)
    return train, build_rotating_masses(machine.crank_train, options)
