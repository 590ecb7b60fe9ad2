"""All that a crank train does to its body, per crank speed squared: of one case or of many points.

The kernels broadcast over leading axes, so that a train of a single case and one whose numbers
carry an axis of points go the same way.
"""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.excitation.inertia_forces import (
    couple_about_axis,
    inertia_torque,
    reciprocating_excitation,
    rotating_excitation,
)
from vibecalc.kinematics.adapter import PistonMotion
from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.numerics.rounding import FloatArray
from vibecalc.parts.crank_train import CrankTrain, RotatingMasses

if TYPE_CHECKING:
    from vibecalc.parts.weight_tables import Rod
    from vibecalc.schema import Machine


def train_excitation(
    train: CrankTrain,
    rotating: RotatingMasses,
    motion: PistonMotion,
    machine: "Machine",
    with_torque: bool = False,
) -> Bounded:
    """Loads (..., n, 6) on the body of the orders 1 .. n; `train` holds the masses that move.

    Leading axes are those of the train, its motion and the rotor. `with_torque`: the body bears
    minus the torque of the masses.
    """
    rod, rotor = machine.crank_train.rod, machine.rotor
    slaves = None
    if machine.crank_train.has_slave_rods:
        from vibecalc.excitation.articulated import on_crank_pins, slave_forces

        slaves = slave_forces(train, motion, machine, with_torque)
        train = on_crank_pins(train, machine)
    moments = rod_moments(train, rod)
    phases, axis = (train.crank_phase, train.bank_angle), train.axis
    highest = motion.harmonics.shape[-1] - 1
    found = reciprocating_excitation(
        motion.harmonics,
        crank_radius=train.crank_radius,
        reciprocating_mass=train.reciprocating_mass,
        crank_phase=train.crank_phase,
        bank_angle=train.bank_angle,
        position=train.position,
        origin=train.origin[..., None, :],
        axis=axis,
        stroke=train.stroke,
        across=train.across,
        wrist_pin_offset=train.wrist_pin_offset,
    )
    if rotating.names:
        found = found + rotating_part(train, rotating, highest)
    share = rounded(1.0, 0)
    if with_torque and rotor is not None:
        share = rounded(share_of_rotor(train, motion, rotor.inertia, moments), 32)
    if with_torque:
        # the side thrusts of the pistons turn the body with minus their torque, beside r x F
        torque = inertia_torque(
            motion.harmonics, highest, dropped_acceleration=motion.dropped_after_guard
        )[..., 1:]
        square = np.square(train.crank_radius)[..., None]
        turning = couple_about_axis(square * torque, -train.reciprocating_mass, *phases, axis)
        found = found + turning * share[..., None, None]
    if moments is not None:
        # d'Alembert: dJ phi'' w^2, and minus the torque -dJ phi' phi'' w^2 that its energy takes
        turned = _turning_of_rods(train, highest)
        found = found + couple_about_axis(turned.acceleration[..., 1:], moments, *phases, axis)
        if with_torque:
            turning = couple_about_axis(turned.product[..., 1:], moments, *phases, axis)
            found = found + turning * share[..., None, None]
    return found if slaves is None else found + slaves


def rotating_part(train: CrankTrain, rotating: RotatingMasses, highest: int) -> Bounded:
    """Loads (..., highest, 6) of what turns."""
    return rotating_excitation(
        unbalance=rotating.unbalance,
        speed_ratio=rotating.speed_ratio,
        phase=rotating.phase,
        position=rotating.position,
        origin=train.origin[..., None, :],
        stroke=train.stroke,
        across=train.across,
        highest_order=highest,
    )


def rod_difference(train: CrankTrain, rod: "Rod") -> Bounded:
    """Moment (...) of one rod beyond that of its two point masses, in kg m^2.

    Minus that of the point masses where the case does not give the rod's own moment.
    """
    from vibecalc.excitation.rod_inertia import split_inertia

    place = rod.crank_pin_to_mass_centre
    if place is None:
        share = 0.0 if rod.reciprocating_fraction is None else rod.reciprocating_fraction
        place = share * train.rod_length
    own = 0.0 if rod.inertia is None else rod.inertia
    return own - split_inertia(rod.mass, place, train.rod_length)


def rod_moments(train: CrankTrain, rod: "Rod | None") -> Bounded | None:
    """Moment (..., c) of each rod beyond that of its two point masses; one at rest has none.

    None where the case does not give the rod's own moment.
    """
    if rod is None or rod.inertia is None:
        return None
    moves: FloatArray = (train.reciprocating_mass + train.rotating_mass > 0.0).astype(float)
    return rod_difference(train, rod)[..., None] * moves


def share_of_rotor(
    train: CrankTrain, motion: PistonMotion, rotor_inertia: Any, moments: Bounded | None
) -> Any:
    """Share (...) of the torque on the crankshaft that turns what is fixed to it, and the body.

    A rotor of inertia J follows J phi'' = T - m phi'', m the mean over a turn of what moves with
    the pistons: it takes T J / (J + m), and the body has minus that. What the fluctuation of the
    speed mixes between the orders is of relative size m / J and left out. `rotor_inertia` is that
    of all that turns with the crankshaft besides the rotating masses; `moments` are those of
    `rod_moments`.
    """
    highest, square = motion.harmonics.shape[-1] - 1, np.square(train.crank_radius)
    # the mean of m s'^2 is m R^2 sum n^2 |C_n|^2 / 2
    velocity = np.arange(highest + 1) * np.abs(motion.harmonics.value)
    moving = train.reciprocating_mass.sum(-1) * square * 0.5 * np.square(velocity).sum(-1)
    if moments is not None:
        turned = _turning_of_rods(train, highest).acceleration.value[..., 1:]
        swing = 0.5 * np.square(np.abs(turned) / np.arange(1, highest + 1)).sum(-1)
        moving = moving + moments.value.sum(-1) * swing
    turning = rotor_inertia + train.rotating_mass.sum(-1) * square
    return turning / (turning + moving)


def _turning_of_rods(train: CrankTrain, highest: int) -> Any:
    from vibecalc.kinematics.rod_angle import rod_angle_harmonics

    lengths = (train.crank_radius, train.rod_length, train.wrist_pin_offset)
    return rod_angle_harmonics(*lengths, highest_order=highest)
