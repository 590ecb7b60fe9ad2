"""Natural frequencies and shapes of an undamped shaft line, by the method that its shape allows."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.response.torsion.bidiagonal import Row, bidiagonal_factor, row_frequencies
from vibecalc.response.torsion.bisection import relative_error
from vibecalc.response.torsion.general import (
    clusters,
    factor_modes,
    orthogonal,
    orthogonal_pairs,
    tree_modes,
)
from vibecalc.response.torsion.graph import (
    Piece,
    angles_of_condensed,
    condense,
    path_order,
    pieces,
)
from vibecalc.response.torsion.line import Line
from vibecalc.response.torsion.twisted import row_shapes

#: up to this length LAPACK's QR gives shapes as accurate and sooner
_SHORT = 24


class Modes(NamedTuple):
    """m modes of n freedoms, one mode for each freedom with inertia.

    `frequency` (m,) in rad/s, ascending, exactly 0 for the rigid mode of each ungrounded piece;
    `shape` (m, n) angles of largest magnitude 1, the largest positive, of several within a
    thousandth the first; `modal_inertia` (m,) = sum of J shape^2 in kg m^2; `frequency_error` (m,)
    in rad/s and `shape_error` (m,) of its worst component, absolute.
    """

    frequency: FloatArray
    shape: FloatArray
    modal_inertia: FloatArray
    frequency_error: FloatArray
    shape_error: FloatArray


def natural_modes(line: Line) -> Modes:
    """Undamped modes of any shaft line without leading axes; damping and loss are not looked at.

    Rows: qd algorithm on a bidiagonal factor and twisted factorisation; trees: mode counts; loops:
    dense singular values. Rows and trees are right to some roundings in every mode. A freedom
    without inertia moves as statics bids; its infinite frequency is left out. Stiffness zero
    parts a line. Shapes of frequencies that agree to their error are any orthogonal ones of
    their space, and their `shape_error` says so by being 2. Raises `NumericalFailure` for a
    piece without inertia.
    """
    count = len(line.inertia)
    if _is_row(line):
        row = Row(line.inertia, line.ground_stiffness, line.stiffness)
        frequency, shape = _row_modes(row)
        relative = relative_error(count)
        return _finished(line.inertia, frequency, shape, relative * frequency)
    frequencies, errors, shapes = [], [], []
    for piece in pieces(line):
        frequency, shape, error = _piece_modes(piece, count)
        frequencies.append(frequency)
        errors.append(error)
        shapes.append(shape)
    frequency, error = np.concatenate(frequencies), np.concatenate(errors)
    order = np.argsort(frequency, kind="stable")
    shape = np.concatenate(shapes)[order]
    owner = np.repeat(np.arange(len(shapes)), [len(part) for part in shapes])[order]
    return _finished(line.inertia, frequency[order], shape, error[order], owner)


def _is_row(line: Line) -> bool:
    """Stations in a row in their own order, each with inertia, each shaft with stiffness."""
    elements = len(line.stiffness)
    if elements != len(line.inertia) - 1 or not line.inertia.all() or not line.stiffness.all():
        return False
    first, second = line.first.tolist(), line.second.tolist()
    return bool(first == list(range(elements)) and second == list(range(1, elements + 1)))


def _row_modes(row: Row) -> tuple[FloatArray, FloatArray]:
    """Frequencies (n,) and shapes (n, n) of a row in which every station has inertia."""
    free = not row.ground.any()
    factor = bidiagonal_factor(row)
    frequency = row_frequencies(factor, free)
    if len(row.inertia) <= _SHORT:
        shape = np.linalg.svd(factor)[2][::-1] / np.sqrt(row.inertia)
    else:
        shape = row_shapes(row, frequency)
        runs = clusters(frequency)
        pairs = np.array([a for a, b in runs if b == a + 2], dtype=np.int64)
        done = set[int]()
        if len(pairs):
            turned_pairs, sound = orthogonal_pairs(shape, pairs, row.inertia)
            pairs, turned_pairs = pairs[sound], turned_pairs[sound]
            shape[pairs], shape[pairs + 1] = turned_pairs[:, 0], turned_pairs[:, 1]
            done = set(pairs.tolist())
        for first, last in runs:
            if first in done:
                continue
            turned = orthogonal(shape[first:last], row.inertia)
            if turned is None:
                turned = np.linalg.svd(factor)[2][::-1][first:last] / np.sqrt(row.inertia)
            shape[first:last] = turned
    if free:
        shape[0] = 1.0
    return frequency, shape


def _piece_modes(piece: Piece, count: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Frequencies (m,), shapes (m, count) and absolute frequency errors (m,) of one piece."""
    small, taken = condense(piece, 2)
    order = path_order(small)
    if order is not None:
        stiffness = [small.spring[a][b] for a, b in pairwise(order)]
        row = Row(
            np.array([small.inertia[name] for name in order]),
            np.array([small.ground[name] for name in order]),
            np.array(stiffness),
        )
        frequency, part = _row_modes(row)
        error = relative_error(len(piece.spring)) * frequency
    elif small.is_tree:
        order = list(small.spring)
        frequency, part, error = tree_modes(small)
    else:
        small, taken = condense(piece, len(piece.spring))
        order = list(small.spring)
        frequency, part, bound = factor_modes(small)
        error = np.where(frequency > 0.0, bound + relative_error(len(order)) * frequency, 0.0)
    shape = np.zeros((len(frequency), count))
    shape[:, order] = part
    angles_of_condensed(shape, taken)
    return frequency, shape, error


def _finished(
    inertia: FloatArray,
    frequency: FloatArray,
    shape: FloatArray,
    error: FloatArray,
    owner: IntArray | None = None,
) -> Modes:
    """Scale shapes and bound what their error may be; modes of other pieces do not mix."""
    modes = np.arange(len(frequency))
    size = np.abs(shape)
    # within a thousandth stations count as equal: no rounding may choose the sign
    largest = np.argmax(size, axis=1)
    top = size[modes, largest]
    first = np.argmax(size >= (1.0 - 1e-3) * top[:, None], axis=1)
    shape = shape / np.copysign(top, shape[modes, first])[:, None]
    np.multiply(shape, shape, out=size)
    modal = size @ inertia
    # Relative changes h of J and k turn mode i by at most h w_i / |w_i - w_j| towards each j (both
    # at modal inertia 1), squares summed; the error of w_i is such an h w_i.
    away = np.subtract.outer(frequency, frequency)
    away *= away
    if owner is not None:
        away[owner[:, None] != owner] = np.inf
    np.fill_diagonal(away, np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        np.divide(1.0, away, out=away)
        mixed = error * np.sqrt(modal * (away @ (1.0 / modal)))
    rigid = frequency == 0.0
    shape_error = np.where(rigid, 0.0, np.fmin(mixed + 8.0 * EPSILON, 2.0))
    return Modes(frequency, shape, modal, error, shape_error)
