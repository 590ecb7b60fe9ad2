"""Undamped natural frequencies and modes of a rigid body on its mounts, and how alike modes are."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.linear import Linear, bounded_parts
from vibecalc.numerics.rounding import UNIT_ROUNDOFF

# ----------------------------------------------------------------------------
# Undamped natural frequencies and modes of a rigid body on its mounts.
# ----------------------------------------------------------------------------

#: eigenvalues closer than this many error estimates count as one, repeated
CLUSTER = 16.0
#: an eigenvalue below this share of the largest is what rounding leaves of nothing
_NOTHING = 4.0 * UNIT_ROUNDOFF
#: correction of the shapes whose square is nothing, even for the lowest mode next to the stiffest
_REFINED = 1e-10

#: a smaller coupling of repeated modes, relative to the largest loss, is round-off
_COUPLED = 1e-13

_NO_MASS = (
    "the mass matrix of the body is not positive definite: every direction needs a positive mass "
    "or moment of inertia, and the mass centre has to fit them"
)


class Modes(NamedTuple):
    """Modes in ascending order of frequency, errors absolute; leading axes as of the matrices.

    `natural_frequency` (modes,) in rad/s; `shape` (f, modes), mass-normalised, the largest
    component (by kinetic energy) positive; `eigenvalue` is the frequency squared. Modes whose
    frequencies agree to rounding span a space in which any basis would do: theirs is one that the
    damping does not couple, else the one nearest to the coordinates, and their error is that of
    the space.
    """

    natural_frequency: np.ndarray
    natural_frequency_error: np.ndarray
    shape: np.ndarray
    shape_error: np.ndarray
    eigenvalue: np.ndarray
    eigenvalue_error: np.ndarray

    @property
    def held(self) -> np.ndarray:
        """Which modes (modes,) any stiffness holds: their eigenvalue is above its error."""
        return np.asarray(self.eigenvalue > self.eigenvalue_error)

    @property
    def bounded_frequency(self) -> Bounded:
        """Natural frequencies with their errors."""
        return Bounded(self.natural_frequency, self.natural_frequency_error)

    @property
    def bounded_shape(self) -> Bounded:
        """Shapes with their errors."""
        return Bounded(self.shape, self.shape_error)


def modes(matrices: Linear) -> Modes:
    """Solve K v = w^2 M v for all modes.

    The coordinates are scaled to unit mass, so metres and radians may differ by any factor; the
    problem is reduced by Cholesky factors, and a Newton step on all eigenpairs at once, or two,
    recovers the digits that low modes lose next to stiff ones. Raises NumericalFailure if the mass
    matrix is not positive definite. Source of the step: T. Ogita and K. Aishima (2018), Iterative
    refinement for symmetric eigenvalue decomposition, Japan J. Indust. Appl. Math. 35, algorithm 1.
    """
    shape = _refined_shapes(matrices)
    quotient = _squares(shape, matrices.stiffness) / _squares(shape, matrices.mass)
    rising = np.argsort(quotient, axis=-1, kind="stable")
    shape = np.take_along_axis(shape, rising[..., None, :], -1)
    eigenvalue, coupling = _eigenvalues(matrices, shape)
    gap = np.abs(eigenvalue[..., :, None] - eigenvalue[..., None, :])
    apart = gap > coupling
    mixing = np.where(apart, coupling / np.where(apart, gap, 1.0), 1.0) * _off_diagonal(gap)
    uncertainty = np.linalg.diagonal(coupling) + np.sum(coupling * mixing, axis=-1)
    # what the rounding of the stiffest mode would hide is no stiffness at all, however little
    # uncertainty there is of it: where rows of it are zero, a quotient of rounding errors remains
    size = np.abs(eigenvalue)
    nothing = _NOTHING * np.max(size, axis=-1, keepdims=True)
    error = np.where(size <= nothing, np.maximum(uncertainty, nothing), uncertainty)
    rises = np.diff(eigenvalue, axis=-1) > CLUSTER * (error[..., 1:] + error[..., :-1])
    cluster = np.cumsum(np.insert(rises, 0, False, axis=-1), axis=-1)
    shape = _settled(matrices, shape, eigenvalue, cluster)
    shape = shape * _largest_positive(matrices.mass, shape)
    # modes of one cluster span a space, into which others may mix
    mixing = mixing * (cluster[..., :, None] != cluster[..., None, :])
    frequency = np.sqrt(np.maximum(eigenvalue, 0.0))
    above = np.sqrt(np.maximum(eigenvalue, 0.0) + uncertainty) - frequency
    below = frequency - np.sqrt(np.maximum(eigenvalue - error, 0.0))
    return Modes(
        frequency,
        np.maximum(above, below) + UNIT_ROUNDOFF * frequency,
        shape,
        np.abs(shape) @ mixing + 32.0 * UNIT_ROUNDOFF * np.abs(shape),
        eigenvalue,
        error,
    )


def _squares(shape: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """v A v (..., modes) of each mode."""
    return np.asarray(np.sum(shape * (matrix @ shape), axis=-2))


def _refined_shapes(matrices: Linear) -> np.ndarray:
    """Mass-normalised shapes (..., f, modes) in any order; errors and source as `modes`.

    A second step follows where the first one changed so much that the square of it may count.
    """
    mass, stiffness = matrices.mass, matrices.stiffness
    diagonal = np.linalg.diagonal(mass)
    if not np.all(diagonal > 0.0):
        raise NumericalFailure(_NO_MASS)
    scale = 1.0 / np.sqrt(diagonal)
    weight = scale[..., :, None] * scale[..., None, :]
    try:
        lower = np.linalg.cholesky(mass * weight)
    except np.linalg.LinAlgError:
        raise NumericalFailure(_NO_MASS) from None
    half = np.linalg.solve(lower, stiffness * weight)
    reduced = np.linalg.solve(lower, half.mT)
    _, vectors = np.linalg.eigh(0.5 * (reduced + reduced.mT))
    shape, corrected = _refine(matrices, scale[..., :, None] * np.linalg.solve(lower.mT, vectors))
    if corrected > _REFINED:
        shape, corrected = _refine(matrices, shape)
    if corrected > _REFINED:  # rounding alone tells a pair apart, and turns it by chance
        shape = np.linalg.solve(np.linalg.cholesky(shape.mT @ mass @ shape), shape.mT).mT
    return shape


def _refine(matrices: Linear, shape: np.ndarray) -> tuple[np.ndarray, float]:
    """One Ogita-Aishima step for the pencil (K, M): quadratic where eigenvalues are apart.

    Returns the largest correction, as a share of a shape, too.
    """
    gram = shape.mT @ matrices.mass @ shape
    energy = shape.mT @ matrices.stiffness @ shape
    defect = np.eye(gram.shape[-1]) - gram
    eigenvalue = np.linalg.diagonal(energy) / np.linalg.diagonal(gram)
    gap = eigenvalue[..., None, :] - eigenvalue[..., :, None]
    numerator = energy + eigenvalue[..., None, :] * defect
    # a pair too close to be distinguished is only made orthonormal
    close = np.abs(numerator) >= 1e-3 * np.abs(gap)
    close |= close.mT
    correction = np.where(close, 0.5 * defect, numerator / np.where(close, 1.0, gap))
    return shape + shape @ correction, float(np.max(np.abs(correction)))


def _eigenvalues(matrices: Linear, shape: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rayleigh quotients, and how strongly the modes are still coupled, errors included."""
    mass, stiffness, *_ = bounded_parts(matrices)
    gram, energy = (shape.mT @ part @ shape for part in (mass, stiffness))
    eigenvalue = np.linalg.diagonal(energy.value) / np.linalg.diagonal(gram.value)
    rows, columns = eigenvalue[..., :, None], eigenvalue[..., None, :]
    off = np.abs(energy.value - 0.5 * (rows + columns) * gram.value) * _off_diagonal(gram.value)
    larger = np.maximum(np.abs(rows), np.abs(columns))
    return eigenvalue, off + energy.error + larger * gram.error


def _off_diagonal(matrix: np.ndarray) -> np.ndarray:
    """One (n, n) beside the diagonal, zero on it."""
    return np.asarray(1.0 - np.eye(matrix.shape[-1]))


def _settled(
    matrices: Linear, shape: np.ndarray, eigenvalue: np.ndarray, cluster: np.ndarray
) -> np.ndarray:
    """Shapes of which repeated modes, alike in `cluster` (..., modes), have a basis of their own.

    It is the one nearest to the coordinates, unless the loss H + w C at their frequency w couples
    that: then one which it does not couple. Where some combination of them has no damping, an
    order on that frequency has no bound, though each mode of another basis seems damped.
    """
    size = shape.shape[-1]
    settled = shape.copy().reshape(-1, size, size)
    mass, damping, structural = (
        np.broadcast_to(part, shape.shape).reshape(settled.shape)
        for part in (matrices.mass, matrices.damping, matrices.structural)
    )
    flat, square = cluster.reshape(-1, size), eigenvalue.reshape(-1, size)
    # machines whose modes repeat alike are settled together
    alike: dict[bytes, list[int]] = {}
    for place in np.flatnonzero(flat[:, -1] < size - 1).tolist():
        alike.setdefault(flat[place].tobytes(), []).append(place)
    for places in alike.values():
        for number in np.flatnonzero(np.bincount(flat[places[0]]) > 1).tolist():
            members = np.flatnonzero(flat[places[0]] == number)
            pick = np.asarray(places)[:, None], members
            # an index before and behind a slice puts its axes first
            basis = _nearest_basis(mass[places], settled[pick[0], :, pick[1]].mT)
            rate = np.sqrt(np.maximum(square[pick].mean(axis=-1), 0.0))[:, None, None]
            loss = basis.mT @ (structural[places] + rate * damping[places]) @ basis
            between = np.max(np.abs(loss * _off_diagonal(loss)), axis=(-2, -1))
            coupled = between > _COUPLED * np.max(np.linalg.diagonal(loss), axis=-1)
            _, turn = np.linalg.eigh(0.5 * (loss + loss.mT))
            basis = np.where(coupled[:, None, None], basis @ turn, basis)
            settled[pick[0], :, pick[1]] = basis.mT
    return settled.reshape(shape.shape)


def _nearest_basis(mass: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """Mass-orthonormal bases (n, f, m) of the same spaces, from projections of the coordinates."""
    remaining = basis
    found = []
    while size := remaining.shape[-1]:
        # energy that a unit motion along each coordinate puts into the space
        share = np.sum(np.square(mass @ remaining), axis=-1) / np.diagonal(mass, axis1=1, axis2=2)
        highest = np.max(share, axis=-1, keepdims=True)
        pivot = np.argmax(share > (1.0 - 1e-6) * highest, axis=-1)
        column = np.take_along_axis(mass, pivot[:, None, None], -1)
        unit = np.broadcast_to(np.eye(size), (len(mass), size, size))
        directions = np.concatenate([remaining.mT @ column, unit], axis=-1)
        rotation, _ = np.linalg.qr(directions, mode="reduced")
        turned = remaining @ rotation
        found.append(turned[..., :1])
        remaining = turned[..., 1:]
    return np.concatenate(found, axis=-1)


def _largest_positive(mass: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """+1 or -1 (..., 1, modes) so that the largest component, weighed by energy, is positive."""
    weighed = shape * np.sqrt(np.linalg.diagonal(mass))[..., :, None]
    size = np.abs(weighed)
    # ties within rounding go to the first coordinate, so that the sign never flickers
    largest = np.argmax(
        size > (1.0 - 1e-6) * np.max(size, axis=-2, keepdims=True), axis=-2, keepdims=True
    )
    return np.where(np.take_along_axis(weighed, largest, -2) < 0.0, -1.0, 1.0)


# ----------------------------------------------------------------------------
# How alike mode shapes are.
# ----------------------------------------------------------------------------


def modal_assurance(shape: Bounded, weight: Bounded) -> Bounded:
    """MAC matrix (modes, modes) of shapes (f, modes), none of them zero, under a diagonal (f,).

        MAC = |v W u|^2 / ((v W v) (u W u))

    1 for shapes that differ by a factor only, 0 for shapes that are orthogonal. Coordinates in
    metres and in radians can be compared under a weight only; under the whole mass matrix the
    modes of one machine are orthogonal.

    Source: R. J. Allemang (2003), The modal assurance criterion, Sound and Vibration 37 (8).
    """
    cross = shape.T @ (weight[:, None] * shape)
    size, square = np.abs(cross.value), Bounded(*map(np.diagonal, cross))
    alike = Bounded(np.square(size), (2.0 * size + cross.error) * cross.error)
    return alike / (square[:, None] * square)
