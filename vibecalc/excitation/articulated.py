"""Adapter of slave rods: their forces next to those of the other rods, and how these turn."""

from dataclasses import replace

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.articulated_forces import SlaveMasses, slave_excitation
from vibecalc.excitation.inertia_forces import forces_of
from vibecalc.excitation.results import Masses, Turning
from vibecalc.kinematics.adapter import PistonMotion
from vibecalc.kinematics.slave_adapter import slave_rods
from vibecalc.numerics.bounded import Bounded, Summed, rounded
from vibecalc.numerics.rounding import EPSILON
from vibecalc.parts.articulated import build_slaves
from vibecalc.parts.crank_train import CrankTrain
from vibecalc.schema import Machine


def on_crank_pins(train: CrankTrain, machine: Machine) -> CrankTrain:
    """The train with the pistons of slave rods left out of what moves."""
    own = np.ones(len(train.names))
    own[build_slaves(machine.crank_train).cylinder] = 0.0
    return replace(train, reciprocating_mass=own * train.reciprocating_mass)


def slave_forces(
    train: CrankTrain, motion: PistonMotion, machine: Machine, with_torque: bool
) -> Bounded:
    """Forces and couples of the pistons on slave rods, for the orders of `motion`."""
    slaves = build_slaves(machine.crank_train)
    places = train.origin + train.position[slaves.cylinder][:, None] * train.axis
    return slave_excitation(
        slave_rods(train, slaves),
        SlaveMasses(
            train.reciprocating_mass[slaves.cylinder][:, None],
            slaves.knuckle_mass[:, None],
            places,
            slaves.rod_difference[:, None],
        ),
        axis=train.axis,
        stroke=train.stroke,
        across=train.across,
        highest_order=motion.harmonics.shape[-1] - 1,
        with_torque=with_torque,
    )


def emit_slaves(scene: Scene, driven: Bounded, used: int) -> None:
    """Emit the masses at knuckle pins, and the parts of the force that turn either way."""
    train = scene.parts.crank_train
    slaves = build_slaves(scene.case.machine.crank_train)
    names = [train.names[place] for place in slaves.cylinder]
    masses = Masses(knuckle=rounded(slaves.knuckle_mass, 4))
    scene.emit_all(masses, {"slave_rod": names})
    force = forces_of(driven)[:used]
    along, ahead = force @ train.stroke, force @ -train.across
    terms = float(np.max(0.5 * (np.abs(along.value) + np.abs(ahead.value))))

    def turning(sense: float) -> Summed:
        size = 0.5 * abs(along + Bounded(1j * sense * ahead.value, ahead.error))
        return Summed(size.value, size.error + EPSILON * terms, terms)

    found = Turning(with_crank=turning(1.0), against_crank=turning(-1.0))
    scene.emit_all(found, {"order": np.arange(1, used + 1)})
    scene.cite(
        "slave rods on a master rod", "forces and couples on the body",
        "exact motion, docs/theory.md; cf. Biezeno and Grammel (1953), ch. XI",
    )  # fmt: skip
