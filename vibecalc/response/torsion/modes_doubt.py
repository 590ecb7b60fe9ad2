"""Errors of the shapes of a shaft line, measured: what one more step would correct, and what a
rounding of each inertia and stiffness moves.

A bound on all angles of a shape alike is far too large for angles in which a mode fades, and for
what has them in common. Here any weighted sum of angles has an error of its own.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.response.torsion.line import Line, network_matrix, stiffness_matrix
from vibecalc.response.torsion.line_modes import LineModes
from vibecalc.response.torsion.modes import Modes

#: roundings of an inertia or a stiffness on its way from a case into a line, and times a correction
ROUNDINGS, CORRECTIONS = 4.0, 2.0
#: freedoms up to which the answers to all of them are formed: they cost the fourth power
FREEDOMS = 48


class ShapeDoubt(NamedTuple):
    """Of m modes of n freedoms, with the largest angle of each held.

    `bound` (m,) is what holds for each angle; `moved` (m, n + 1, p) are p moves of the angles and,
    last, of the squared frequency as a share of itself: first what is corrected, then those that
    have no common sign. p is 0 where they are not known: where modes lie closer than a correction
    tells, or for a long line. `moving` (m,) is 0 for rigid modes, which have no errors, else 1.
    """

    bound: FloatArray
    moved: FloatArray | ComplexArray
    moving: FloatArray


def shape_doubt(line: Line, modes: Modes) -> ShapeDoubt:
    """From the equations of motion of the shapes as they are, by twists, which do not cancel.

    The moves have the order: correction, inertias (n,), elements (e,), springs to ground (n,).
    """
    moving = modes.frequency > 0.0
    known = len(line.inertia) <= FREEDOMS and bool(np.any(moving))
    counted = np.where(moving, 1.0, 0.0)
    if not known:
        none = np.zeros((len(moving), len(line.inertia) + 1, 0))
        return ShapeDoubt(modes.shape_error, none, counted)
    count, (first, second) = len(line.inertia), (line.first, line.second)
    shape, square = modes.shape[moving], modes.frequency[moving] ** 2
    inert = square[:, None] * line.inertia
    twist = line.stiffness * (shape[:, first] - shape[:, second])
    held = line.ground_stiffness * shape
    answer = _answers(line, inert, shape)
    moved = np.zeros((len(modes.frequency), count + 1, 1 + 2 * count + len(first)))
    of_element = answer[..., first] - answer[..., second]
    own = answer * (inert * shape)[:, None, :]
    element, ground = of_element * twist[:, None, :], answer * held[:, None, :]
    left = own.sum(axis=-1) - element.sum(axis=-1) - ground.sum(axis=-1)
    parts = np.concatenate([own, element, ground], axis=-1)
    found = np.concatenate([CORRECTIONS * left[..., None], ROUNDINGS * EPSILON * parts], axis=-1)
    moved[moving] = np.where(np.isfinite(found), found, np.inf)
    return ShapeDoubt(modes.shape_error, moved, counted)


def damped_shape_doubt(line: Line, modes: LineModes, stations: int) -> ShapeDoubt:
    """The same of the shapes of poles: the largest angle of the first `stations` freedoms is held.

    The moves have the order: correction, inertias (n,), stiffnesses and dampings of elements
    (e, e), then of springs and dashpots to ground (n, n).
    """
    moving = modes.frequency > 0.0
    counted = np.where(moving, 1.0, 0.0)
    count = len(line.inertia)
    if count > FREEDOMS or not np.any(moving):
        return ShapeDoubt(modes.shape_error, np.zeros((len(moving), count + 1, 0)), counted)
    first, second = line.first, line.second
    shape, pole = modes.shape[moving], modes.pole[moving][:, None]
    dashpot = line.damping + line.loss_factor * line.stiffness / np.abs(pole)
    twist = shape[:, first] - shape[:, second]
    own, braked = pole**2 * line.inertia, pole * line.absolute_damping
    matrix = np.zeros((len(shape), count + 1, count + 1), dtype=np.complex128)
    element: ComplexArray = np.asarray(line.stiffness + pole * dashpot, dtype=np.complex128)
    ground: ComplexArray = np.asarray(own + braked + line.ground_stiffness, dtype=np.complex128)
    dynamic = network_matrix(line, element, ground)
    place = np.arange(count)
    scale = 1.0 / np.sqrt(np.abs(dynamic[:, place, place]) + np.abs(own) + 1e-300)
    element = np.asarray(dashpot, dtype=np.complex128)
    ground = np.asarray(2.0 * pole * line.inertia + line.absolute_damping, dtype=np.complex128)
    slope = network_matrix(line, element, ground)
    matrix[:, :count, :count] = dynamic * scale[:, :, None] * scale[:, None, :]
    matrix[:, :count, count] = np.einsum("mij,mj->mi", slope, shape) * scale
    top = np.argmax(np.abs(shape[:, :stations]), axis=1)
    matrix[np.arange(len(shape)), count, top] = 1.0
    size = 1 + 3 * count + 2 * len(first)
    moved = np.zeros((len(moving), count + 1, size), dtype=np.complex128)
    try:
        answer = np.linalg.inv(matrix)[..., :count]
    except np.linalg.LinAlgError:
        moved[moving] = np.inf
        return ShapeDoubt(modes.shape_error, moved, counted)
    answer[:, :count] *= scale[:, :, None]
    answer = answer * scale[:, None, :]
    of_element = answer[..., first] - answer[..., second]
    torques = (
        (answer, own * shape), (of_element, line.stiffness * twist),
        (of_element, pole * dashpot * twist), (answer, line.ground_stiffness * shape),
        (answer, braked * shape),
    )  # fmt: skip
    parts = np.concatenate([moves * torque[:, None, :] for moves, torque in torques], axis=-1)
    left = CORRECTIONS * parts.sum(axis=-1, keepdims=True)
    found = np.concatenate([left, ROUNDINGS * EPSILON * parts], axis=-1)
    moved[moving] = np.where(np.isfinite(found), found, np.inf)
    return ShapeDoubt(modes.shape_error, moved, counted)


def doubt_of(doubt: ShapeDoubt, weight: FloatArray | ComplexArray) -> FloatArray:
    """Errors (m, q) of sums of the angles with weights (m, q, n) or (q, n) of no common sign."""
    size = np.abs(weight)
    bound = doubt.bound[:, None] * np.sqrt(np.sum(np.square(size), axis=-1))
    if doubt.moved.shape[-1]:
        measured = spread(weight @ doubt.moved[:, :-1])
        bound = np.minimum(bound, measured)
    return np.asarray(bound * doubt.moving[:, None])


def angle_doubt(doubt: ShapeDoubt) -> FloatArray:
    """Errors (m, n) of the angles."""
    bound = np.broadcast_to(doubt.bound[:, None], (len(doubt.bound), doubt.moved.shape[1] - 1))
    if doubt.moved.shape[-1]:
        bound = np.minimum(bound, spread(doubt.moved[:, :-1]))
    return np.asarray(bound * doubt.moving[:, None])


def spread(moved: FloatArray | ComplexArray) -> FloatArray:
    """Size of moves (..., p): the first in full, the others as what has no common sign."""
    rest = np.sqrt(np.sum(np.square(np.abs(moved[..., 1:])), axis=-1))
    found = np.abs(moved[..., 0]) + rest
    return np.asarray(np.where(np.isfinite(found), found, np.inf))


def _answers(line: Line, inert: FloatArray, shape: FloatArray) -> FloatArray:
    """Moves (m, n + 1, n) of angles and frequency under torques, largest angles held."""
    modes, count = shape.shape
    stiffness, place = stiffness_matrix(line), np.arange(count)
    matrix = np.zeros((modes, count + 1, count + 1))
    matrix[:, :count, :count] = stiffness
    matrix[:, place, place] -= inert
    # rows and columns of one size
    scale = 1.0 / np.sqrt(np.diag(stiffness) + inert)
    matrix[:, :count, :count] *= scale[:, :, None] * scale[:, None, :]
    matrix[:, :count, count] = -inert * shape * scale
    matrix[np.arange(modes), count, np.argmax(np.abs(shape), axis=1)] = 1.0
    try:
        inverse = np.linalg.inv(matrix)[..., :count]
    except np.linalg.LinAlgError:  # equal frequencies: their shapes are any of a space
        return np.full((modes, count + 1, count), np.inf)
    inverse[:, :count] *= scale[:, :, None]
    return np.asarray(inverse * scale[:, None, :])
