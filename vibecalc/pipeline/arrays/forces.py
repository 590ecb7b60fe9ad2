"""Forces and couples at many points: as the stage `excitation`, each number with a leading axis."""

from typing import NamedTuple

import numpy as np

from vibecalc.excitation.crank_forces import crank_forces
from vibecalc.excitation.inertia_forces import Excitation
from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.numerics.rounding import EPSILON, WithError
from vibecalc.numerics.typing import IntArray
from vibecalc.parts.firing import shakes_with_torque
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
    turning = turning_masses(columns, train)
    rod = columns.case.machine.crank_train.rod
    own = rod is not None and rod.inertia is not None
    per_square = crank_forces(
        train,
        motion,
        train.origin[:, None, :],
        turning=turning if turning.unbalance.any() else None,
        rod_difference=_rod_difference(columns, train) if own else None,
        with_torque=shakes_with_torque(columns.case),
        rotor_inertia=columns.optional("machine", "rotor", "inertia"),
    )
    orders = np.arange(1, highest + 1)
    return Forces(train, motion, per_square, orders, orders <= motion.kept[:, None])


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


def _rod_difference(columns: Columns, train: Train) -> WithError:
    """Moments (points or 1, 1) of a rod beyond those of its two point masses."""
    from vibecalc.excitation.rod_inertia import split_inertia

    rod = (*TRAIN, "rod")
    place = columns.optional(*rod, "crank_pin_to_mass_centre")
    if place is None:
        place = columns.number(*rod, "reciprocating_fraction") * train.rod_length
    points = split_inertia(columns.number(*rod, "mass"), place, train.rod_length)
    difference = columns.number(*rod, "inertia") - points.value
    doubt = points.error + EPSILON * np.abs(difference)
    return WithError(difference[:, None], doubt[:, None])
