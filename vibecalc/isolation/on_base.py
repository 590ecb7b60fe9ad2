"""Bodies on a base through springs: what they send into it, and how far they follow it."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.linear import Dynamics, Linear, dynamics, law, resisting, response
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.parts.mounts import Mounts

# ----------------------------------------------------------------------------
# One body or several on a base that is rigid.
#
# With the motion X (n,) of all coordinates, the motion U (f,) of the base as a rigid body and R
# (n, f), which says how all coordinates move with the base where no spring is deformed, the springs
# see X - R U only:
#
#     D X = F + K* R U,   D = K* - w^2 M,   K* = K + i (H + w C)
#
# The base feels R^T K* (X - R U); what acts between the bodies cancels in that sum. Without U it is
# R^T K* inv(D) F, and without F the bodies move by inv(D) K* R U: as all matrices are symmetric,
# one is the transpose of the other.
# ----------------------------------------------------------------------------

#: around each natural frequency, relative distances of samples; none is on it
_NEAR = np.geomspace(1.0e-3, 0.3, 12)
_FAR = 240


class OnBase(NamedTuple):
    """`matrices` (n, n) of bodies on a base, and `rigid` (n, f), their motion with the base.

    The first f coordinates are those of the body that is loaded, about its reference point, and
    those of the base: f is 6, or less for a model that keeps fewer motions.
    """

    matrices: Linear
    rigid: np.ndarray


class Stand(NamedTuple):
    """A machine on its mounts, and what these stand on: bodies on a base, with each mount.

    `stretch` (mounts, 3, n) takes the motion of all coordinates to the deflection of each mount, of
    its upper end against its lower one.
    """

    system: OnBase
    mounts: Mounts
    stretch: np.ndarray

    def passing(self, frequency: np.ndarray) -> Bounded:
        """Dynamic stiffness (frequencies, mounts, 3, 3) of each mount at rad/s."""
        return mount_stiffness(self.mounts, frequency)


def mount_stiffness(mounts: Mounts, frequency: np.ndarray) -> Bounded:
    """Dynamic stiffness (frequencies, mounts, 3, 3) of each mount at rad/s.

    Its error is rounding, and what the load at rest leaves uncertain of the stiffness.
    """
    rate = np.asarray(frequency)[:, None, None, None]
    value = resisting(mounts.stiffness, mounts.structural, mounts.damping, rate)
    error = 8.0 * UNIT_ROUNDOFF * np.abs(value)
    if mounts.relative_error is not None:
        still, _ = law(mounts.stiffness, mounts.structural, mounts.damping)
        error = error + mounts.relative_error[:, None, None] * np.abs(still)
    return Bounded(value, error)


def alone(matrices: Linear) -> OnBase:
    """One body (f, f) whose mounts stand on the base."""
    return OnBase(matrices, np.eye(matrices.mass.shape[-1]))


def passing_stiffness(system: OnBase, frequency: np.ndarray) -> Bounded:
    """R^T K* (frequencies, f, n): load on the base for a motion, N and N m, at rad/s."""
    return Bounded(system.rigid.T.astype(complex), np.zeros(())) @ system.matrices.passing(
        frequency
    )


def ground_load(system: OnBase, motion: Bounded, frequency: np.ndarray) -> Bounded:
    """Forces and couples (orders, f) on the base by motions (orders, n) in complex amplitude.

    Couples are about the reference point of the loaded body, N m.
    """
    found = passing_stiffness(system, frequency) @ Bounded(
        motion.value[..., None], motion.error[..., None]
    )
    return found[..., 0]


def transmissibility(system: OnBase, frequency: np.ndarray) -> Bounded:
    """Loads on the base over loads on the body, (frequencies, f, f) complex: [i, j] is i by j.

    Of a load of one size at all frequencies (rad/s), at the reference point. Transposed it is the
    motion of that body over the motion of the base.
    """
    system_at = dynamics(system.matrices, frequency)
    count, kept = system.rigid.shape
    unit = np.eye(kept, count, dtype=complex)
    each = Dynamics(*(part[..., None, :, :] for part in system_at))
    motion = response(each, unit, np.zeros((kept, count)))
    columns = Bounded(np.swapaxes(motion.value, -1, -2), np.swapaxes(motion.error, -1, -2))
    return passing_stiffness(system, frequency) @ columns


def moved_by_base(system: OnBase, base: Bounded, frequency: np.ndarray) -> tuple[Bounded, Bounded]:
    """Motion against the base and motion (frequencies, n), the base moving by (frequencies, f).

    D (X - R U) = w^2 M R U has no difference of large terms where the base moves slowly.
    """
    carried = base @ system.rigid.T.astype(complex)
    one, squared = system.matrices, np.square(frequency)[:, None]
    load = (carried @ one.mass.astype(complex)) * squared
    spread = np.abs(carried.value) @ one.mass_error
    found = response(dynamics(one, frequency), load.value, load.error + squared * spread)
    return found, found + carried


def frequency_grid(natural: np.ndarray, lowest: float = 0.0, highest: float = 0.0) -> np.ndarray:
    """Frequencies for a curve, rad/s: even by ratio, dense around each natural frequency.

    From a fifth of the lowest natural frequency to five times the highest, further where `lowest`
    or `highest` lie outside.
    """
    known = natural[natural > 1.0e-6 * natural.max()]
    start, stop = 0.2 * known.min(), 5.0 * known.max()
    start, stop = min(start, lowest or start), max(stop, highest)
    around = known[:, None] * (1.0 + np.concatenate([-_NEAR, _NEAR]))
    even = np.geomspace(start, stop, _FAR)
    # two natural frequencies may be one to rounding, and so may samples around them
    clear = np.all(np.abs(even[:, None] / known - 1.0) > 0.5 * _NEAR[0], axis=1)
    grid = np.sort(np.concatenate([even[clear], around.ravel()]))
    apart = np.concatenate([[True], np.diff(grid) > 1.0e-9 * grid[1:]])
    return np.asarray(grid[apart])
