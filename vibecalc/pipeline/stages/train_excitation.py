"""All that a crank train does to its body, per crank speed squared, for one way of running it."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.excitation.reciprocating import reciprocating_excitation
from vibecalc.excitation.rotating import rotating_excitation
from vibecalc.excitation.sums import Excitation, add
from vibecalc.machine.crank_train import CrankTrain, RotatingMasses
from vibecalc.numerics.rounding import EPSILON, WithError
from vibecalc.pipeline.stages.kinematics import PistonMotion

if TYPE_CHECKING:
    from vibecalc.case import parts
    from vibecalc.case.tables import Excitation as Options


def train_excitation(
    train: CrankTrain,
    rotating: RotatingMasses,
    motion: PistonMotion,
    options: "Options | None",
    rod: "parts.Rod | None" = None,
) -> Excitation:
    """Forces and couples of orders 1 .. n; `train` holds the masses that move."""
    return add(*_parts(train, rotating, motion, options, rod))


def rotating_part(train: CrankTrain, rotating: RotatingMasses, highest: int) -> Excitation:
    """Forces and couples of what turns, orders 1 .. highest."""
    return rotating_excitation(
        unbalance=rotating.unbalance,
        speed_ratio=rotating.speed_ratio,
        phase=rotating.phase,
        position=rotating.position,
        origin=train.origin,
        stroke=train.stroke,
        across=train.across,
        highest_order=highest,
    )


def _parts(
    train: CrankTrain,
    rotating: RotatingMasses,
    motion: PistonMotion,
    options: "Options | None",
    rod: "parts.Rod | None",
) -> list[Excitation]:
    highest = motion.harmonics.shape[-1] - 1
    found = [_pistons(train, motion)]
    if rotating.names:
        found.append(rotating_part(train, rotating, highest))
    separate = options is not None and options.driven_machine == "separate"
    if separate:
        found.append(_reaction(train, motion, highest))
    if rod is not None and rod.inertia is not None:
        found += _rods(train, rod, highest, separate)
    return found


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


def _rods(train: CrankTrain, rod: "parts.Rod", highest: int, separate: bool) -> list[Excitation]:
    """Couples of the rods' own moments; a rod that stands still has none."""
    from vibecalc.excitation.rod_inertia import rod_inertia_excitation, rod_torque_reaction
    from vibecalc.kinematics.rod_angle import rod_angle_harmonics

    turning = rod_angle_harmonics(
        train.crank_radius, train.rod_length, train.wrist_pin_offset, highest_order=highest
    )
    runs = (train.reciprocating_mass + train.rotating_mass > 0.0).astype(float)
    difference = rod_difference(train, rod)
    found = []
    for make, harmonics, wanted in (
        (rod_inertia_excitation, turning.acceleration, True),
        (rod_torque_reaction, turning.product, separate),
    ):
        if wanted:
            part = make(
                harmonics.value,
                inertia_difference=runs * difference.value,
                crank_phase=train.crank_phase,
                bank_angle=train.bank_angle,
                axis=train.axis,
                motion_error=harmonics.error,
                inertia_error=runs * difference.error,
            )
            found.append(part)
    return found


def _pistons(train: CrankTrain, motion: PistonMotion) -> Excitation:
    return reciprocating_excitation(
        motion.harmonics,
        crank_radius=train.crank_radius,
        reciprocating_mass=train.reciprocating_mass,
        crank_phase=train.crank_phase,
        bank_angle=train.bank_angle,
        position=train.position,
        origin=train.origin,
        axis=train.axis,
        stroke=train.stroke,
        across=train.across,
        wrist_pin_offset=train.wrist_pin_offset,
        motion_error=motion.error,
    )


def _reaction(train: CrankTrain, motion: PistonMotion, highest: int) -> Excitation:
    from vibecalc.excitation.inertia_torque import inertia_torque, torque_reaction

    torque = inertia_torque(
        motion.harmonics,
        highest,
        dropped_acceleration=motion.dropped_after_guard,
        motion_error=motion.error,
    )
    return torque_reaction(
        torque,
        crank_radius=train.crank_radius,
        reciprocating_mass=train.reciprocating_mass,
        crank_phase=train.crank_phase,
        bank_angle=train.bank_angle,
        axis=train.axis,
    )
