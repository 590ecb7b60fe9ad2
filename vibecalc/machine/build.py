"""All parts of one machine, built from a validated case."""

from dataclasses import dataclass

from vibecalc.case.schema import Machine
from vibecalc.machine.body import RigidBody, build_body
from vibecalc.machine.crank_train import (
    CrankTrain,
    RotatingMasses,
    build_crank_train,
    build_rotating_masses,
)
from vibecalc.machine.mounts import Mounts, build_mounts


@dataclass(frozen=True, kw_only=True)
class MachineParts:
    """What stages read of a machine; a part that the case leaves out is None."""

    crank_train: CrankTrain
    rotating_masses: RotatingMasses
    body: RigidBody | None
    mounts: Mounts | None


def build_machine(machine: Machine) -> MachineParts:
    """Arrays of every part that the case has."""
    return MachineParts(
        crank_train=build_crank_train(machine.crank_train),
        rotating_masses=build_rotating_masses(machine.crank_train),
        body=None if machine.body is None else build_body(machine.body),
        mounts=None if machine.mounts is None else build_mounts(machine.mounts),
    )
