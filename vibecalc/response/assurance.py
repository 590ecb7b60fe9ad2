"""How alike two sets of mode shapes are, and how much of a rigid motion each mode carries."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.response.matrices import Matrices
from vibecalc.response.modes import Modes


class Participation(NamedTuple):
    """Part of each mode in unit motions of the whole body, both (modes, 6), errors absolute.

    `factor` is v M e / (v M v) for a unit motion e along x, y, z (1) or about them (rad).
    `effective_mass` is (v M e)^2 / (v M v), in kg or kg m^2: over all modes it adds up to the
    diagonal of the mass matrix.
    """

    factor: np.ndarray
    factor_error: np.ndarray
    effective_mass: np.ndarray
    effective_mass_error: np.ndarray


def metres_and_radians(length: float) -> np.ndarray:
    """Weight (6, 6) under which a turn counts as the way it makes at a distance `length`, in m."""
    return np.diag([1.0, 1.0, 1.0, length**2, length**2, length**2])


def modal_assurance(first: WithError, second: WithError, weight: WithError) -> WithError:
    """MAC matrix (m, k) of shapes (6, m) and (6, k), real or complex; and its error.

        MAC = |v* W u|^2 / ((v* W v) (u* W u))

    1 for shapes that differ by a factor only, 0 for shapes that are orthogonal. Coordinates in
    metres and in radians can be compared under a weight only. The mass matrix makes the answer
    independent of units and reference point, and the modes of one machine orthogonal; with
    `metres_and_radians` no masses are needed, and the length is a choice.

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

    def product(a: WithError, b: WithError) -> tuple[np.ndarray, np.ndarray]:
        size, other, matrix = np.abs(a.value).T, np.abs(b.value), np.abs(weight.value)
        doubt = size @ rounded @ other + a.error.T @ matrix @ other
        return a.value.conj().T @ weight.value @ b.value, doubt + (
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
    (v_square, v_doubt), (u_square, u_doubt) = lengths
    scale = np.outer(v_square, u_square)
    size = np.abs(cross)
    value = size**2 / scale
    spread = (2.0 * size + cross_error) * cross_error / scale
    relative = np.add.outer(v_doubt, u_doubt) + 8.0 * UNIT_ROUNDOFF
    return WithError(np.minimum(value, 1.0), spread + value * relative)


def participation(matrices: Matrices, shapes: Modes) -> Participation:
    """Part of every mode in the rigid motions along and about the axes of the reference point.

    Source: R. W. Clough and J. Penzien, Dynamics of Structures, on the effective modal mass.
    """
    vector, size = shapes.shape.T, np.abs(shapes.shape).T
    spread, mass = shapes.shape_error.T, np.abs(matrices.mass)
    along = vector @ matrices.mass
    rounded = matrices.mass_error + 16.0 * UNIT_ROUNDOFF * mass
    along_error = size @ rounded + spread @ mass
    own = np.sum(along * vector, axis=1, keepdims=True)
    own_error = np.sum((size @ rounded) * size, axis=1, keepdims=True) / own
    own_error = own_error + 2.0 * np.sum(np.abs(along) * spread, axis=1, keepdims=True) / own
    factor, effective = along / own, along**2 / own
    return Participation(
        factor,
        along_error / own + np.abs(factor) * own_error,
        effective,
        (2.0 * np.abs(along) + along_error) * along_error / own + effective * own_error,
    )
