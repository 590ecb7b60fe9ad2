"""Forced response of a shaft line by dense elimination: any network, loops too, and as a check."""

import numpy as np

from vibecalc.numerics.rounding import EPSILON, BoolArray, ComplexArray, FloatArray
from vibecalc.torsion.elimination import LineSolution
from vibecalc.torsion.line import Line, dynamic_stiffness

# ----------------------------------------------------------------------------
# Forced response by dense elimination with pivoting: any network, loops too, and as a check.
# ----------------------------------------------------------------------------

#: roundings of a row's sum in the residual, for the few elements that meet at a station
DENSE_ROUNDINGS = 16.0 * EPSILON


def dense_solution(
    line: Line,
    frequency: FloatArray,
    torque: list[ComplexArray | None],
    angle: ComplexArray,
) -> LineSolution:
    """As `eliminate`, by inverting the dynamic stiffness; one step of refinement.

    The error is |inverse| (|residual| + round-off of data and residual), row by row. Frequencies
    whose matrix is singular have an infinite error.
    """
    n, copies, count = angle.shape
    matrix = dynamic_stiffness(line, frequency)
    load = np.zeros((count, n, copies), dtype=np.complex128)
    for i, one in enumerate(torque):
        if one is not None:
            load[:, i, :] = np.broadcast_to(one, (copies, count)).T
    # one scale for each station makes stiff and soft stations alike
    scale = np.sqrt(np.max(np.abs(matrix), axis=-1))
    scale = np.where(
        scale > 0.0, np.exp2(np.round(np.log2(np.where(scale > 0.0, scale, 1.0)))), 1.0
    )
    scaled = matrix / (scale[:, :, None] * scale[:, None, :])
    inverse, singular = _inverse(scaled)
    right = load / scale[..., None]
    solution = inverse @ right
    solution += inverse @ (right - scaled @ solution)
    size, right_size = np.abs(scaled), np.abs(right)
    if np.any(frequency == 0.0):
        _held(line, frequency, scaled, right, inverse, solution, singular)
    residual = np.abs(right - scaled @ solution)
    data = _data_size(line, frequency) / (scale[:, :, None] * scale[:, None, :])
    uncertainty = residual + DENSE_ROUNDINGS * ((size + data) @ np.abs(solution) + right_size)
    error = np.abs(inverse) @ uncertainty / scale[..., None]
    angle[...] = (solution / scale[..., None]).transpose(1, 2, 0)
    angle[:, :, singular] = 0.0
    largest = np.max(np.abs(angle), axis=0)
    worst = np.max(error, axis=1).T + 2.0 * EPSILON * largest
    worst[:, singular] = np.inf
    worst[~np.isfinite(worst)] = np.inf
    return LineSolution(angle, worst, np.zeros(count, dtype=bool), largest)


def _data_size(line: Line, frequency: FloatArray) -> FloatArray:
    """Sizes of what is added up on the diagonal: cancelling sums lose that much."""
    n = line.inertia.shape[-1]
    w = frequency[:, None]
    diagonal = np.abs(line.ground_stiffness) + w**2 * line.inertia + w * line.absolute_damping
    element = line.stiffness * (1.0 + np.abs(line.loss_factor)) + w * line.damping
    diagonal = np.broadcast_to(diagonal, (len(frequency), n)).copy()
    for e, (a, b) in enumerate(zip(line.first, line.second, strict=True)):
        diagonal[:, a] += element[:, e]
        diagonal[:, b] += element[:, e]
    return diagonal[:, :, None] * np.eye(n)


def _inverse(matrix: ComplexArray) -> tuple[ComplexArray, BoolArray]:
    """Inverses, zero for the exactly singular ones, and which those are."""
    singular: BoolArray = np.zeros(len(matrix), dtype=np.bool_)
    try:
        return np.asarray(np.linalg.inv(matrix), dtype=np.complex128), singular
    except np.linalg.LinAlgError:
        inverse = np.zeros_like(matrix)
        for i, one in enumerate(matrix):
            try:
                inverse[i] = np.linalg.inv(one)
            except np.linalg.LinAlgError:
                singular[i] = True
    return inverse, singular


def _held(
    line: Line,
    frequency: FloatArray,
    matrix: ComplexArray,
    right: ComplexArray,
    inverse: ComplexArray,
    solution: ComplexArray,
    singular: BoolArray,
) -> None:
    """At rest: the least twist that meets balanced torques, where a piece is free to turn."""
    if np.all(np.any(line.ground_stiffness, axis=-1)):
        return
    for i in np.flatnonzero(frequency == 0.0).tolist():
        inverse[i] = np.linalg.pinv(matrix[i], rcond=1e-12, hermitian=False)
        solution[i] = inverse[i] @ right[i]
        left = np.abs(right[i] - matrix[i] @ solution[i])
        size = np.abs(matrix[i]) @ np.abs(solution[i]) + np.abs(right[i])
        singular[i] = bool(np.any(left > 1e-10 * np.max(size)))
