"""The joints with play of one cylinder, with what moves and loads them, from a case to arrays."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.impact.checks import moving_masses
from vibecalc.impact.linkage import GasForce, Joint, Linkage, slider_crank_drive
from vibecalc.parts import motor_tables as joint_parts
from vibecalc.parts import tables as parts
from vibecalc.parts.crank_train import build_crank_train
from vibecalc.schema import Case, Machine


class Joints(NamedTuple):
    """The running gear of `cylinder`, and all the mass (kg) that moves with its piston.

    `linkage.mass` is what lies beyond the wrist pin's play: piston and pin. The rod's reciprocating
    share lies on the crank's side of it: driven, or with play in the crank pin a mass between two
    gaps. `reciprocating_mass` has both. Angles count from the cylinder's own top dead centre.
    """

    linkage: Linkage
    cylinder: str
    reciprocating_mass: float


def build_joints(
    machine: Machine, working: Sequence[str] | None, *, gas_towards_crank: bool = True
) -> Joints:
    """The linkage of the cylinder that [machine.joints] names, or of the first that works.

    `working` names the cylinders that work, None all. The gas pushes the piston towards the
    crank, as a pressure above that of the crankcase does, or (the sense of eq. 5.1 of Ong 2000)
    towards the head.

    The mass beyond the wrist pin's play is piston and pin: of a mass that has the rod's share in
    it, and a case that gives the rod, that share is taken off. A reciprocating mass without a rod
    is taken as it is. (The source takes its whole reciprocating mass, with the rod's share.)
    """
    joints, case_train = machine.joints, machine.crank_train
    assert joints is not None
    train = build_crank_train(case_train)
    name, whole, rod = moving_masses(machine, working)
    bore = joints.bore
    drive = slider_crank_drive(
        train.crank_radius,
        train.rod_length,
        machine.speed,
        train.wrist_pin_offset,
        with_rod_tangent=bore is not None,
    )
    linkage = Linkage(
        drive,
        _gas_force(case_train, 1.0 if gas_towards_crank else -1.0),
        whole - rod,
        _joint(joints.wrist_pin, joints.wrist_pin.spring),
        None if joints.crank_pin is None else _joint(joints.crank_pin, joints.crank_pin.spring),
        None if joints.crank_pin is None else rod,
        None if bore is None else _joint(bore, "continuous"),
    )
    return Joints(linkage, name, whole)


def _joint(play: joint_parts.Play, law: str) -> Joint:
    given = play.clearance, play.stiffness, play.contact_damping, play.film_damping
    clearance, stiffness, contact, film = (np.asarray(one, dtype=np.float64) for one in given)
    return Joint(clearance, stiffness, contact, film, law)


def _gas_force(train: parts.CrankTrain, sense: float) -> GasForce:
    table = train.gas_pressure
    if table is None or train.bore is None:
        return GasForce(np.zeros(0), np.zeros(0))
    area = 0.25 * math.pi * train.bore**2
    return GasForce(np.array(table.crank_angle), sense * area * np.array(table.pressure))


def joints_of(case: Case) -> Joints:
    """Those of a case that has them and asks for impacts."""
    options = case.response.impact if case.response else None
    working = case.excitation.working if case.excitation else None
    towards_crank = options is None or options.pressure == "towards_crank"
    return build_joints(case.machine, working, gas_towards_crank=towards_crank)
