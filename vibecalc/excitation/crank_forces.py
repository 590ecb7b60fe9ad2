"""All that a crank train does to its body, per crank speed squared: of one case or of many points.

The kernels broadcast over leading axes, so that a train of a single case and one whose numbers
carry an axis of points go the same way.
"""

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import numpy as np

from vibecalc.excitation.inertia_forces import (
    Excitation,
    add,
    reciprocating_excitation,
    rotating_excitation,
)
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, FloatArray


class TurningWeights(NamedTuple):
    """Unbalances (..., m) in kg m, whole speed ratios (m,), phases in rad, places (..., m, 3)."""

    unbalance: Any
    speed_ratio: Any
    phase: Any
    position: Any


class Pistons(Protocol):
    """What the kernels read of a train: a `CrankTrain`, or the `Train` of many points."""

    @property
    def crank_radius(self) -> Any: ...
    @property
    def rod_length(self) -> Any: ...
    @property
    def wrist_pin_offset(self) -> Any: ...
    @property
    def position(self) -> FloatArray: ...
    @property
    def crank_phase(self) -> FloatArray: ...
    @property
    def bank_angle(self) -> FloatArray: ...
    @property
    def reciprocating_mass(self) -> FloatArray: ...
    @property
    def rotating_mass(self) -> FloatArray: ...
    @property
    def axis(self) -> FloatArray: ...
    @property
    def stroke(self) -> FloatArray: ...
    @property
    def across(self) -> FloatArray: ...


class PistonSeries(Protocol):
    """Harmonics C_n of s / R (..., h + 1), their errors, and what the guard orders leave out."""

    @property
    def harmonics(self) -> Any: ...
    @property
    def error(self) -> Any: ...
    @property
    def dropped_after_guard(self) -> Any: ...


def crank_forces(
    train: Pistons,
    motion: PistonSeries,
    origin: FloatArray,
    *,
    turning: TurningWeights | None = None,
    rod_difference: Bounded | None = None,
    with_torque: bool = False,
    rotor_inertia: Any = None,
) -> Excitation:
    """Forces and couples of orders 1 .. h of `motion`.

    Parameters
    ----------
    train : the masses that move, at their cranks.
    origin : of the positions, from the body's reference point, m; broadcasts against (..., m, 3).
    turning : what turns; None without it.
    rod_difference : moment of a rod beyond that of its two point masses, kg m^2, (..., 1) or a
        number; None for rods that are two point masses. A rod that stands still has none.
    with_torque : the body bears minus the torque of the masses on the crankshaft.
    rotor_inertia : of all that turns with the crankshaft besides the rotating masses, kg m^2, a
        number or (...); None for a crank that turns steadily.
    """
    highest = motion.harmonics.shape[-1] - 1
    parts = [
        reciprocating_excitation(
            motion.harmonics,
            crank_radius=train.crank_radius,
            reciprocating_mass=train.reciprocating_mass,
            crank_phase=train.crank_phase,
            bank_angle=train.bank_angle,
            position=train.position,
            origin=origin,
            axis=train.axis,
            stroke=train.stroke,
            across=train.across,
            wrist_pin_offset=train.wrist_pin_offset,
            motion_error=motion.error,
        )
    ]
    if turning is not None:
        parts.append(turning_forces(train, turning, origin, highest))
    share = 1.0
    if with_torque and rotor_inertia is not None:
        share = share_of_rotor(train, motion, rotor_inertia, rod_difference)
    if with_torque:
        parts.append(_scaled(_reaction(train, motion, highest), share))
    if rod_difference is not None:
        parts += _rods(train, rod_difference, highest, with_torque, share)
    return add(*parts)


def share_of_rotor(
    train: Pistons, motion: PistonSeries, rotor_inertia: Any, rod_difference: Bounded | None
) -> Any:
    """Share (...) of the torque on the crankshaft that turns what is fixed to it, and the body."""
    from vibecalc.excitation.inertia_forces import mean_inertia, rotor_share

    moving = mean_inertia(motion.harmonics, train.crank_radius, train.reciprocating_mass)
    if rod_difference is not None:
        from vibecalc.kinematics.rod_angle import rod_angle_harmonics

        highest = motion.harmonics.shape[-1] - 1
        turned = rod_angle_harmonics(
            train.crank_radius, train.rod_length, train.wrist_pin_offset, highest_order=highest
        ).acceleration.value[..., 1:]
        square = 0.5 * np.square(np.abs(turned) / np.arange(1, highest + 1)).sum(-1)
        moving = moving + (_runs(train) * rod_difference.value).sum(-1) * square
    turning = rotor_inertia + train.rotating_mass.sum(-1) * np.square(train.crank_radius)
    return rotor_share(turning, moving)


def _runs(train: Pistons) -> FloatArray:
    return (train.reciprocating_mass + train.rotating_mass > 0.0).astype(float)


def _scaled(excitation: Excitation, share: Any) -> Excitation:
    """The excitation times a share (...) of some roundings."""
    factor = np.asarray(share, dtype=float)[..., None, None]
    return Excitation(
        factor * excitation.force,
        factor * excitation.couple,
        factor * excitation.force_error,
        factor * (excitation.couple_error + 16.0 * EPSILON * np.abs(excitation.couple)),
    )


def turning_forces(
    train: Pistons, turning: TurningWeights, origin: FloatArray, highest: int
) -> Excitation:
    """Forces and couples of what turns, orders 1 .. highest."""
    return rotating_excitation(
        **turning._asdict(),
        origin=origin,
        stroke=train.stroke,
        across=train.across,
        highest_order=highest,
    )


def _reaction(train: Pistons, motion: PistonSeries, highest: int) -> Excitation:
    from vibecalc.excitation.inertia_forces import inertia_torque, torque_reaction

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


def _rods(
    train: Pistons, difference: Bounded, highest: int, with_torque: bool, share: Any
) -> list[Excitation]:
    """Couples of the rods' own moments beyond those of their two point masses."""
    from vibecalc.excitation.rod_inertia import rod_inertia_excitation, rod_torque_reaction
    from vibecalc.kinematics.rod_angle import rod_angle_harmonics

    turned = rod_angle_harmonics(
        train.crank_radius, train.rod_length, train.wrist_pin_offset, highest_order=highest
    )
    runs = _runs(train)
    kernels: list[tuple[Callable[..., Excitation], Bounded]] = [
        (rod_inertia_excitation, turned.acceleration)
    ]
    if with_torque:
        kernels.append((rod_torque_reaction, turned.product))
    made = [
        make(
            harmonics.value,
            inertia_difference=runs * difference.value,
            crank_phase=train.crank_phase,
            bank_angle=train.bank_angle,
            axis=train.axis,
            motion_error=harmonics.error,
            inertia_error=runs * np.asarray(difference.error),
        )
        for make, harmonics in kernels
    ]
    return [made[0], *(_scaled(each, share) for each in made[1:])]
