"""Undamped natural frequencies and modes of a rigid body on its mounts, and how alike modes are."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.linear import Linear
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

_NO_MASS = (
    "the mass matrix of the body is not positive definite: every direction needs a positive mass "
    "or moment of inertia, and the mass centre has to fit them"
)


class Modes(NamedTuple):
    """Modes in ascending order of frequency, errors absolute; leading axes as of the matrices.

    `natural_frequency` (modes,) in rad/s; `shape` (6, modes), mass-normalised, the largest
    component (by kinetic energy) positive; `eigenvalue` is the frequency squared. Modes whose
    frequencies agree to rounding span a space in which any basis would do: theirs is the one
    nearest to the coordinates, and their error is that of the space. Nothing holds the body in
    a mode whose eigenvalue is not above its error.
    """

    natural_frequency: np.ndarray
    natural_frequency_error: np.ndarray
    shape: np.ndarray
    shape_error: np.ndarray
    eigenvalue: np.ndarray
    eigenvalue_error: np.ndarray


def modes(matrices: Linear) -> Modes:
    """Solve K v = w^2 M v for all modes.

    The coordinates are scaled to unit mass, so metres and radians may differ by any factor; the
    problem is reduced by Cholesky factors, and a Newton step on all eigenpairs at once, or two,
    recovers the digits that low modes lose next to stiff ones. Raises NumericalFailure if the mass
    matrix is not positive definite. Source of the step: T. Ogita and K. Aishima (2018), Iterative
    refinement for symmetric eigenvalue decomposition, Japan J. Indust. Appl. Math. 35, algorithm 1.
    """
    shape, _ = refined_shapes(matrices)
    eigenvalue, coupling = _eigenvalues(matrices, shape)
    order = np.argsort(eigenvalue, axis=-1, kind="stable")
    eigenvalue = np.take_along_axis(eigenvalue, order, -1)
    shape, coupling = (
        np.take_along_axis(part, order[..., None, :], -1) for part in (shape, coupling)
    )
    coupling = np.take_along_axis(coupling, order[..., :, None], -2)
    uncertainty = _eigenvalue_error(eigenvalue, coupling)
    error = _with_nothing(eigenvalue, uncertainty)
    shape, cluster = _settle_repeated(matrices.mass, shape, eigenvalue, error)
    shape = shape * largest_positive(matrices.mass, shape)[..., None, :]
    frequency = np.sqrt(np.maximum(eigenvalue, 0.0))
    above = np.sqrt(np.maximum(eigenvalue, 0.0) + uncertainty) - frequency
    below = frequency - np.sqrt(np.maximum(eigenvalue - error, 0.0))
    return Modes(
        frequency,
        np.maximum(above, below) + UNIT_ROUNDOFF * frequency,
        shape,
        _shape_error(shape, eigenvalue, coupling, cluster),
        eigenvalue,
        error,
    )


def refined_shapes(matrices: Linear) -> tuple[np.ndarray, int]:
    """Mass-normalised shapes (..., 6, modes) in any order, and the steps of refinement of them.

    Errors and source as `modes`. A second step follows where the first one changed so much that
    the square of it may count.
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
    shape = scale[..., :, None] * np.linalg.solve(lower.mT, vectors)
    shape, corrected = _refine(matrices, shape)
    if corrected <= _REFINED:
        return shape, 1
    shape, corrected = _refine(matrices, shape)
    if corrected > _REFINED:  # rounding alone tells a pair apart, and turns it by chance
        shape = _orthonormal(mass, _orthonormal(mass, shape))
    return shape, 2


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
    refined: np.ndarray = shape + shape @ correction
    return refined, float(np.max(np.abs(correction)))


def _orthonormal(mass: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """Shapes whose products with the mass are off those of an orthonormal basis by the square."""
    gram = shape.mT @ mass @ shape
    refined: np.ndarray = shape + shape @ (0.5 * (np.eye(gram.shape[-1]) - gram))
    return refined


def _eigenvalues(matrices: Linear, shape: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rayleigh quotients, and how strongly the modes are still coupled, errors included."""
    gram = shape.mT @ matrices.mass @ shape
    energy = shape.mT @ matrices.stiffness @ shape
    eigenvalue = np.linalg.diagonal(energy) / np.linalg.diagonal(gram)
    rows, columns = eigenvalue[..., :, None], eigenvalue[..., None, :]
    size = np.abs(shape)
    rounding = 14.0 * UNIT_ROUNDOFF
    uncertainty_k = matrices.stiffness_error + rounding * np.abs(matrices.stiffness)
    uncertainty_m = matrices.mass_error + rounding * np.abs(matrices.mass)
    mean = np.sqrt(np.abs(rows) * np.abs(columns))
    larger = np.maximum(np.abs(rows), np.abs(columns))
    off = np.abs(energy - 0.5 * (rows + columns) * gram) * _off_diagonal(gram)
    uncertainty = size.mT @ uncertainty_k @ size + np.maximum(mean, larger) * (
        size.mT @ uncertainty_m @ size
    )
    return eigenvalue, off + uncertainty


def _off_diagonal(matrix: np.ndarray) -> np.ndarray:
    """One (n, n) beside the diagonal, zero on it."""
    return np.asarray(1.0 - np.eye(matrix.shape[-1]))


def _eigenvalue_error(eigenvalue: np.ndarray, coupling: np.ndarray) -> np.ndarray:
    """First-order uncertainty of each quotient plus the second-order effect of the coupling."""
    gap = np.abs(eigenvalue[..., :, None] - eigenvalue[..., None, :])
    apart = gap > coupling
    second = coupling * np.divide(coupling, gap, out=np.ones_like(gap), where=apart)
    second = second * _off_diagonal(second)
    error: np.ndarray = np.linalg.diagonal(coupling) + np.sum(second, axis=-1)
    return error


def _with_nothing(eigenvalue: np.ndarray, error: np.ndarray) -> np.ndarray:
    """The errors, at least `_NOTHING` of the largest eigenvalue for those that are not above it.

    What the rounding of the stiffest mode would hide is no stiffness at all, however little
    uncertainty there is of it: where rows of the stiffness are zero, a quotient of rounding errors
    remains.
    """
    size = np.abs(eigenvalue)
    nothing = _NOTHING * np.max(size, axis=-1, keepdims=True)
    floored: np.ndarray = np.where(size <= nothing, np.maximum(error, nothing), error)
    return floored


def _settle_repeated(
    mass: np.ndarray, shape: np.ndarray, eigenvalue: np.ndarray, error: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Give repeated modes the basis nearest to the coordinates; also each mode's cluster number."""
    cluster = clusters(eigenvalue, error)
    size = shape.shape[-1]
    settled = shape.copy().reshape(-1, *shape.shape[-2:])
    masses = np.broadcast_to(mass, shape.shape).reshape(settled.shape)
    flat = cluster.reshape(-1, size)
    # machines whose modes repeat alike are settled together
    alike: dict[bytes, list[int]] = {}
    for place in np.flatnonzero(flat[:, -1] < size - 1).tolist():
        alike.setdefault(flat[place].tobytes(), []).append(place)
    for places in alike.values():
        for _, members in repeated(flat[places[0]]):
            pick = np.asarray(places)[:, None], members
            # an index before and behind a slice puts its axes first
            basis = settled[pick[0], :, pick[1]].mT
            settled[pick[0], :, pick[1]] = _nearest_basis(masses[places], basis).mT
    return settled.reshape(shape.shape), cluster


def clusters(eigenvalue: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Numbers (..., modes) from 0 on, the same for eigenvalues that agree within their errors."""
    apart = np.diff(eigenvalue, axis=-1) > CLUSTER * (error[..., 1:] + error[..., :-1])
    first = np.zeros((*apart.shape[:-1], 1), dtype=int)
    return np.concatenate([first, np.cumsum(apart, axis=-1)], axis=-1)


def repeated(cluster: np.ndarray) -> Iterator[tuple[tuple[int, ...], np.ndarray]]:
    """Leading place and modes of every cluster (..., modes) that has more than one."""
    for place in map(tuple, np.argwhere(cluster[..., -1] < cluster.shape[-1] - 1).tolist()):
        for number in range(cluster[place][-1] + 1):
            members = np.flatnonzero(cluster[place] == number)
            if len(members) > 1:
                yield place, members


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


def largest_positive(mass: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """+1 or -1 (..., modes) so that the largest component, weighed by energy, is positive."""
    weighed = shape * np.sqrt(np.linalg.diagonal(mass))[..., :, None]
    size = np.abs(weighed)
    # ties within rounding go to the first coordinate, so that the sign never flickers
    largest = np.argmax(
        size > (1.0 - 1e-6) * np.max(size, axis=-2, keepdims=True), axis=-2, keepdims=True
    )
    return np.where(np.take_along_axis(weighed, largest, -2)[..., 0, :] < 0.0, -1.0, 1.0)


def _shape_error(
    shape: np.ndarray, eigenvalue: np.ndarray, coupling: np.ndarray, cluster: np.ndarray
) -> np.ndarray:
    """First-order mixing with the modes outside of the own cluster, plus rounding."""
    gap = np.abs(eigenvalue[..., :, None] - eigenvalue[..., None, :])
    outside = cluster[..., :, None] != cluster[..., None, :]
    mixing = np.where(outside, coupling / np.where(outside, gap, 1.0), 0.0)
    size = np.abs(shape)
    error: np.ndarray = size @ np.minimum(mixing, 1.0) + 32.0 * UNIT_ROUNDOFF * size
    return error


# ----------------------------------------------------------------------------
# How alike two sets of mode shapes are.
# ----------------------------------------------------------------------------


def modal_assurance(first: Bounded, second: Bounded, weight: Bounded) -> Bounded:
    """MAC matrix (m, k) of shapes (6, m) and (6, k), real or complex; and its error.

        MAC = |v* W u|^2 / ((v* W v) (u* W u))

    1 for shapes that differ by a factor only, 0 for shapes that are orthogonal. Coordinates in
    metres and in radians can be compared under a weight only. The mass matrix makes the answer
    independent of units and reference point, and the modes of one machine orthogonal; under
    a diagonal of 1 (m) and a length squared (rad) no masses are needed, and the length is a choice.

    Parameters
    ----------
    first, second : modes in columns, any scale and sign.
    weight : (6, 6) symmetric, positive definite.

    Raises
    ------
    NumericalFailure
        A shape is zero under the weight, to within its error.

    Source: R. J. Allemang (2003), The modal assurance criterion, Sound and Vibration 37 (8);
    with a weight, the same as the square of the normalised cross-orthogonality.
    """
    rounded = weight.error + 16.0 * UNIT_ROUNDOFF * np.abs(weight.value)

    def product(a: Bounded, b: Bounded) -> tuple[np.ndarray, np.ndarray]:
        size, other, matrix = np.abs(a.value).T, np.abs(b.value), np.abs(weight.value)
        uncertainty = size @ rounded @ other + a.error.T @ matrix @ other
        return a.value.conj().T @ weight.value @ b.value, uncertainty + (
            (size + a.error.T) @ matrix @ b.error
        )

    cross, cross_error = product(first, second)
    lengths = []
    for name, shapes in (("first", first), ("second", second)):
        square, error = (np.diagonal(part).real for part in product(shapes, shapes))
        if not np.all(square > error):
            number = int(np.argmax(~(square > error))) + 1
            raise NumericalFailure(
                f"shape {number} of the {name} set is zero to rounding: it has no assurance"
            )
        lengths.append((square, error / square))
    (v_square, v_uncertainty), (u_square, u_uncertainty) = lengths
    scale = np.outer(v_square, u_square)
    size = np.abs(cross)
    value = size**2 / scale
    spread = (2.0 * size + cross_error) * cross_error / scale
    relative = np.add.outer(v_uncertainty, u_uncertainty) + 8.0 * UNIT_ROUNDOFF
    return Bounded(np.minimum(value, 1.0), spread + value * relative)
