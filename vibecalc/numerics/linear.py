"""One linear system, M x'' + C x' + (K + iH) x = f: its matrices, its law, and how it is driven."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure, in_hertz, in_rpm
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.leading import product
from vibecalc.numerics.rounding import DATA_ROUNDINGS, SINGULAR, UNIT_ROUNDOFF, BoolArray

# ----------------------------------------------------------------------------
# What resists a motion of frequency w is K* = K + iH + iwC times the motion: of a mount as of a
# whole system. K* is linear in w, and at s = iw it is what the poles see.
# ----------------------------------------------------------------------------


def law(stiffness: Any, structural: Any, damping: Any) -> tuple[Any, Any]:
    """K* as K0 + w K1: numbers or arrays of k (1 + i loss factor) + i w c, in N/m and N s/m.

    `structural` is loss factor times stiffness.
    """
    return stiffness + 1j * structural, 1j * damping


def resisting(stiffness: Any, structural: Any, damping: Any, frequency: Any) -> Any:
    """K* at frequencies in rad/s that broadcast with the rest."""
    still, rising = law(stiffness, structural, damping)
    return still + frequency * rising


# ----------------------------------------------------------------------------
# A linear machine as matrices, with what rounding may have done to them.
# ----------------------------------------------------------------------------


class Linear(NamedTuple):
    """Mass, stiffness, damping and structural (loss) matrices (..., n, n), with absolute errors.

    Units by block of a rigid body: kg, kg m, kg m^2; N/m, N, N m; N s/m, N s, N m s. The error of
    an entry counts the magnitudes of all terms that were added for it, so it stands where an entry
    cancels to 0.
    """

    mass: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    structural: np.ndarray
    mass_error: np.ndarray
    stiffness_error: np.ndarray
    damping_error: np.ndarray
    structural_error: np.ndarray

    def reduced(self, kept: np.ndarray) -> "Linear":
        """The rows and columns (..., f, f) of some coordinates, all others being zero."""
        return Linear(*(matrix[..., kept[:, None], kept] for matrix in self))

    def with_springs(self, other: "Linear") -> "Linear":
        """The same masses with the springs and dampers of another system beside their own."""
        both = (mine + its for mine, its in zip(self, other, strict=True))
        return Linear(*both)._replace(mass=self.mass, mass_error=self.mass_error)

    def free(self) -> "Linear":
        """The same masses and dampers without any stiffness."""
        none = np.zeros(self.stiffness.shape)
        return self._replace(
            stiffness=none, structural=none, stiffness_error=none, structural_error=none
        )

    def passing(self, frequency: np.ndarray) -> Bounded:
        """K* (..., n, n) at frequencies (...) in rad/s, which follow the axes of the matrices."""
        rate = np.asarray(frequency)[..., None, None]
        value = resisting(self.stiffness, self.structural, self.damping, rate)
        error = self.stiffness_error + self.structural_error + rate * self.damping_error
        size = np.abs(value.real) + np.abs(value.imag)
        return Bounded(value, error + 2.0 * UNIT_ROUNDOFF * size)


def bounded_parts(matrices: Linear) -> tuple[Bounded, Bounded, Bounded, Bounded]:
    """Mass, stiffness, damping and structural matrix with the error of each."""
    mass, stiffness, damping, structural = map(Bounded, matrices[:4], matrices[4:])
    return mass, stiffness, damping, structural


def added_up(
    mass: Bounded,
    stretch: np.ndarray,
    stiffness: np.ndarray,
    damping: np.ndarray,
    structural: np.ndarray,
    relative_error: ArrayLike = 0.0,
) -> Linear:
    """Bodies of mass (..., n, n) on springs; all matrices get the same leading axes.

    Parameters
    ----------
    stretch : (..., springs, d, n) takes the coordinates to the deflection of each spring, m.
    stiffness, damping, structural : (..., springs, d, d) symmetric, in N/m, N s/m and N/m.
    relative_error : (springs,) of stiffness and structural, beside rounding.
    """
    size = np.abs(stretch)
    rounding = (stretch.shape[-3] + 6 + DATA_ROUNDINGS) * UNIT_ROUNDOFF

    def total(blocks: np.ndarray, share: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        found = product(product(stretch.mT, blocks), stretch).sum(axis=-3)
        spread = np.asarray(share)[..., None, None] * np.abs(blocks)
        error = product(product(size.mT, spread), size).sum(axis=-3)
        return 0.5 * (found + found.mT), error

    share = rounding + np.asarray(relative_error)
    k, k_error = total(np.asarray(stiffness, dtype=float), share)
    c, c_error = total(np.asarray(damping, dtype=float), rounding)
    h, h_error = total(np.asarray(structural, dtype=float), share)
    parts = (mass.value, k, c, h, mass.error, k_error, c_error, h_error)
    return Linear(*np.broadcast_arrays(*parts))


# ----------------------------------------------------------------------------
# Forced response, for batches of frequencies at once.
# ----------------------------------------------------------------------------

_CLOSE = 1e-3


class Dynamics(NamedTuple):
    """Dynamic stiffness K + iH + iwC - w^2 M (..., 6, 6), its inverse and its absolute error."""

    stiffness: np.ndarray
    error: np.ndarray
    inverse: np.ndarray


class UndrivenModes(NamedTuple):
    """Modes to leave out: `pairs` (..., orders, modes), with `shape` (..., 6, modes) and
    `eigenvalue` (..., modes).
    """

    pairs: np.ndarray
    shape: np.ndarray
    eigenvalue: np.ndarray


def dynamics(
    matrices: Linear, frequency: np.ndarray, undriven: UndrivenModes | None = None
) -> Dynamics:
    """Dynamic stiffness at excitation frequencies (..., orders), rad/s.

    A mode in `undriven` is moved away from the frequency by a stiffness along itself, which
    changes nothing for a force that does not drive it, and keeps its noise from being magnified.
    Raises NumericalFailure where a matrix has no inverse at all.
    """
    return dynamics_by_order(each_order(matrices), frequency, undriven)


def dynamics_by_order(
    matrices: Linear, frequency: np.ndarray, undriven: UndrivenModes | None = None
) -> Dynamics:
    """`dynamics` of matrices (..., orders, 6, 6) that each order has of its own."""
    passing = matrices.passing(frequency)
    squared = np.square(np.asarray(frequency))[..., None, None]
    stiffness = passing.value - squared * matrices.mass
    mass_error = matrices.mass_error + 4.0 * UNIT_ROUNDOFF * np.abs(matrices.mass)
    error = passing.error + squared * mass_error
    if undriven is not None and np.any(undriven.pairs):
        stiffness = stiffness + _moved(matrices, np.asarray(frequency), undriven)
    inertia = np.linalg.diagonal(matrices.mass)
    if not np.all(inertia):  # coordinates without mass are scaled by what resists them
        resists = np.abs(np.linalg.diagonal(stiffness)) / squared[..., 0]
        inertia = np.where(inertia == 0.0, resists, inertia)
    scale = 1.0 / np.sqrt(inertia)
    weight = scale[..., :, None] * scale[..., None, :]
    try:
        inverse = _inverse(stiffness * weight) * weight
    except np.linalg.LinAlgError:
        raise NumericalFailure(
            f"a dynamic stiffness matrix between {in_hertz(np.min(frequency))} and "
            f"{in_hertz(np.max(frequency))} is exactly singular: an order is on an undamped "
            f"natural frequency; give the mounts damping or a loss factor, or move the speed"
        ) from None
    return Dynamics(stiffness, error, inverse)


def _inverse(matrix: np.ndarray) -> np.ndarray:
    """Inverse (..., n, n), of one coordinate without what a batch of tiny matrices costs."""
    if matrix.shape[-1] > 1:
        return np.asarray(np.linalg.inv(matrix))
    if np.any(matrix == 0.0):
        raise np.linalg.LinAlgError
    return np.asarray(1.0 / matrix)


def each_order(matrices: Linear) -> Linear:
    """With an axis for the orders before rows and columns: (..., 1, 6, 6)."""
    return Linear(*(part[..., None, :, :] for part in matrices))


def _moved(matrices: Linear, frequency: np.ndarray, undriven: UndrivenModes) -> np.ndarray:
    squared, natural = np.square(frequency)[..., None], undriven.eigenvalue[..., None, :]
    close = np.abs(squared - natural) < _CLOSE * natural
    shift = np.where(close & undriven.pairs, squared + natural, 0.0)
    momentum = matrices.mass @ undriven.shape[..., None, :, :]
    moved: np.ndarray = (momentum * shift[..., None, :]) @ momentum.mT
    return moved


def response(system: Dynamics, force: np.ndarray, force_error: np.ndarray) -> Bounded:
    """Complex amplitudes X (..., 6) of D X = F in m and rad, with componentwise errors.

    One step of iterative refinement makes the backward error small in every entry; the bound
    |inv D| (dD |X| + dF) then holds for the forward error (N. J. Higham, Accuracy and Stability
    of Numerical Algorithms, 2nd ed., section 7.2 and chapter 12). F is (..., 6), dF absolute.
    """
    column = force[..., None]
    value = product(system.inverse, column)
    value = value + product(system.inverse, column - product(system.stiffness, value))
    size = np.abs(value)
    off = system.error + 10.0 * UNIT_ROUNDOFF * np.abs(system.stiffness)
    error = product(np.abs(system.inverse), product(off, size) + force_error[..., None])
    return Bounded(value[..., 0], (error + 4.0 * UNIT_ROUNDOFF * size)[..., 0])


# ----------------------------------------------------------------------------
# Is a response known to four digits at least?
# ----------------------------------------------------------------------------


def uncertain(mass: np.ndarray, motion: Bounded) -> BoolArray:
    """Which motions (...) of coordinates (..., f) are known to fewer than four digits.

    Of what is largest in them, each coordinate with the root of its `mass` (..., f, f).
    """
    weight = np.sqrt(np.linalg.diagonal(mass))
    largest = np.maximum(np.max(weight * np.abs(motion.value), axis=-1), np.finfo(float).tiny)
    return np.asarray(~(np.max(weight * motion.error, axis=-1) < SINGULAR * largest))


def require_digits(
    matrices: Linear,
    system: Dynamics,
    force: Bounded,
    motion: Bounded,
    orders: np.ndarray,
    speed: ArrayLike,
) -> None:
    """Refuse a response that the rounding of stiffness, damping and mass alone may change.

    `system` and `force`, `motion` (..., orders, 6) belong to the crank speed (...). The undamped
    modes have been examined before; this also meets nearly coinciding modes whose damping acts on
    a combination of them only. A force that is zero to rounding is not judged.

    Raises
    ------
    NumericalFailure
        If fewer than four digits remain in the response to a driven order.
    """
    moved = product(system.error, np.abs(motion.value)[..., None])
    uncertainty = product(np.abs(system.inverse), moved)[..., 0]
    driven = np.any(np.abs(force.value) > 4.0 * force.error, axis=-1)
    mass = matrices.mass[..., None, :, :]
    lost = driven & uncertain(mass, Bounded(motion.value, uncertainty))
    if np.any(lost):
        *place, row = np.argwhere(lost)[0]
        order = float(orders[row])
        met = float(np.broadcast_to(speed, lost.shape[:-1])[tuple(place)])
        raise NumericalFailure(
            f"order {order:g} at {in_rpm(met)} meets an undamped resonance at "
            f"{in_hertz(order * met)}: of the response fewer than four digits would be certain. "
            "Give the mounts damping or a loss factor in every direction, or move the speed or "
            "the stiffness"
        )
