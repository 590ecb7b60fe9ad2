"""Adapter: a crank train, what turns and a rod's moment to the forces of one way of running it."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.excitation.sums import Excitation
from vibecalc.machine.crank_train import CrankTrain, RotatingMasses
from vibecalc.numerics.rounding import EPSILON, WithError
from vibecalc.pipeline.crank_forces import Turning, crank_forces, turning_forces
from vibecalc.pipeline.stages.kinematics import PistonMotion

if TYPE_CHECKING:
    from vibecalc.case import parts
    from vibecalc.case.schema import Machine


def train_excitation(
    train: CrankTrain,
    rotating: RotatingMasses,
    motion: PistonMotion,
    machine: "Machine",
    with_torque: bool = False,
) -> Excitation:
    """Forces and couples of orders 1 .. n; `train` holds the masses that move.

    `with_torque`: the body bears minus the torque of the masses.
    """
    rod, rotor = machine.crank_train.rod, machine.rotor
    own = rod is not None and rod.inertia is not None
    return crank_forces(
        train,
        motion,
        train.origin,
        turning=_turning(rotating) if rotating.names else None,
        rod_difference=rod_difference(train, rod) if rod is not None and own else None,
        with_torque=with_torque,
        rotor_inertia=None if rotor is None else rotor.inertia,
    )


def rotating_part(train: CrankTrain, rotating: RotatingMasses, highest: int) -> Excitation:
    """Forces and couples of what turns, orders 1 .. highest."""
    return turning_forces(train, _turning(rotating), train.origin, highest)


def _turning(rotating: RotatingMasses) -> Turning:
    return Turning(rotating.unbalance, rotating.speed_ratio, rotating.phase, rotating.position)


def rod_difference(train: CrankTrain, rod: "parts.Rod") -> WithError:
    """Moment of one rod beyond that of its two point masses, in kg m^2.

    Minus that of the point masses where the case does not give the rod's own moment.
    """
    from vibecalc.excitation.rod_inertia import split_inertia

    place = rod.crank_pin_to_mass_centre
    if place is None:
        place = (rod.reciprocating_fraction or 0.0) * train.rod_length
    points = split_inertia(rod.mass, place, train.rod_length)
    value = (rod.inertia or 0.0) - points.value
    return WithError(value, points.error + EPSILON * np.abs(value))
