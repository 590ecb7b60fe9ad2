"""Forces and couples at many points: as the stage `excitation`, each number with a leading axis."""

from typing import NamedTuple

import numpy as np

from vibecalc.excitation.inertia_torque import inertia_torque, torque_reaction
from vibecalc.excitation.reciprocating import reciprocating_excitation
from vibecalc.excitation.rotating import rotating_excitation
from vibecalc.excitation.sums import Excitation, add
from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.numerics.rounding import EPSILON, WithError
from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.pipeline.arrays.columns import Columns
from vibecalc.pipeline.arrays.motion import Motion, piston_motion
from vibecalc.pipeline.arrays.train import TRAIN, Train, build_train, turning_masses


class Forces(NamedTuple):
    """Crank train, its motion, and forces and couples (points or 1, h, 3) per speed squared.

    `counts` (points or 1, h) is true for the orders 1 .. h that a point keeps.
    """

    train: Train
    motion: Motion
    per_square: Excitation
    orders: IntArray
    counts: np.ndarray

    @property
    def kept(self) -> int:
        """Highest order that any point keeps."""
        return int(self.motion.kept.max())


def build_forces(columns: Columns) -> Forces:
    """All that the crank train does to the body, per crank speed squared."""
    train = build_train(columns)
    motion = piston_motion(columns, train)
    highest = motion.harmonics.shape[-1] - 1
    parts = [_pistons(train, motion)]
    turning = turning_masses(columns, train)
    if turning.unbalance.any():
        parts.append(
            rotating_excitation(
                unbalance=turning.unbalance,
                speed_ratio=turning.speed_ratio,
                phase=turning.phase,
                position=turning.position,
                origin=train.origin[:, None, :],
                stroke=train.frame.stroke,
                across=train.frame.across,
                highest_order=highest,
            )
        )
    options = columns.case.excitation
    separate = options is not None and options.driven_machine == "separate"
    if separate:
        parts.append(_reaction(train, motion, highest))
    rod = columns.case.machine.crank_train.rod
    if rod is not None and rod.inertia is not None:
        parts += _rods(columns, train, highest, separate)
    orders = np.arange(1, highest + 1)
    return Forces(train, motion, add(*parts), orders, orders <= motion.kept[:, None])


def peak_with_tail(harmonics: WithError, forces: Forces) -> WithError:
    """Peak over the cycle (points, ...) of the orders kept, the dropped ones in its error.

    `harmonics` (points or 1, ..., h) with as many axes in between as the caller likes.
    """
    value, error = harmonics
    between = (1,) * (value.ndim - 2)
    counts = forces.counts.reshape(len(forces.counts), *between, -1)
    tail = forces.motion.tail.reshape(-1, *between)
    within = np.where(counts, value, 0.0)[..., : forces.kept]
    peak = cycle_peak(within, forces.orders[: forces.kept])
    left_out = np.where(counts, error, 0.0).sum(-1)
    left_out = left_out + tail * np.where(counts, 0.0, np.abs(value)).sum(-1)
    return WithError(peak.value, peak.error + left_out)


def _pistons(train: Train, motion: Motion) -> Excitation:
    return reciprocating_excitation(
        motion.harmonics,
        crank_radius=train.crank_radius,
        reciprocating_mass=train.reciprocating_mass,
        crank_phase=train.crank_phase,
        bank_angle=train.bank_angle,
        position=train.position,
        origin=train.origin[:, None, :],
        axis=train.frame.axis,
        stroke=train.frame.stroke,
        across=train.frame.across,
        wrist_pin_offset=train.wrist_pin_offset,
        motion_error=motion.error,
    )


def _reaction(train: Train, motion: Motion, highest: int) -> Excitation:
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
        axis=train.frame.axis,
    )


def _rods(columns: Columns, train: Train, highest: int, separate: bool) -> list[Excitation]:
    """Couples of the rods' own moments beyond those of their two point masses."""
    from vibecalc.excitation.rod_inertia import (
        rod_inertia_excitation,
        rod_torque_reaction,
        split_inertia,
    )
    from vibecalc.kinematics.rod_angle import rod_angle_harmonics

    rod = (*TRAIN, "rod")
    place = columns.optional(*rod, "crank_pin_to_mass_centre")
    if place is None:
        place = columns.number(*rod, "reciprocating_fraction") * train.rod_length
    points = split_inertia(columns.number(*rod, "mass"), place, train.rod_length)
    difference = columns.number(*rod, "inertia") - points.value
    doubt = points.error + EPSILON * np.abs(difference)
    turning = rod_angle_harmonics(
        train.crank_radius, train.rod_length, train.wrist_pin_offset, highest_order=highest
    )
    runs: FloatArray = (train.reciprocating_mass + train.rotating_mass > 0.0).astype(float)
    found = []
    for make, harmonics, wanted in (
        (rod_inertia_excitation, turning.acceleration, True),
        (rod_torque_reaction, turning.product, separate),
    ):
        if wanted:
            found.append(
                make(
                    harmonics.value,
                    inertia_difference=runs * difference[:, None],
                    crank_phase=train.crank_phase,
                    bank_angle=train.bank_angle,
                    axis=train.frame.axis,
                    motion_error=harmonics.error,
                    inertia_error=runs * doubt[:, None],
                )
            )
    return found
