"""Levels as linear readings of a matrix: what they determine, and the two motions they leave.

A level gives |c u|^2 = c' G c with the row c and G = Re(u u^H), the real symmetric matrix of
second moments of the motion u. G forgets of u a common phase and the sign of all phases, which no
level can tell, and nothing else. It is positive semidefinite of rank two (or one). So levels are
*linear* in the six entries of G. Five independent ones leave a line G_0 + t N; it enters and
leaves the convex cone of semidefinite matrices once each, and there the rank is two: two motions,
at most (see `cone_ends`), whatever the places of the accelerometers. For three points and two
differences they are the pairs (+/+) and (+/-) of Herold (1977), eqs. 32 and 33.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import FloatArray

#: entries of a symmetric matrix, as vectors of six hold them
_I, _J = (0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)
_TWICE = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
#: singular values below this share of the largest count as zero
NO_RANK = 1e-9


class Line(NamedTuple):
    """Second moments that fit the levels: origin (3, 3) and direction (3, 3) of unit size."""

    origin: FloatArray
    direction: FloatArray


def quadratic_rows(rows: FloatArray) -> FloatArray:
    """Rows (r, 6) on the entries of G, of scaled rows (r, 3), each row brought to unit length."""
    return moment_rows(rows / np.linalg.norm(rows, axis=-1, keepdims=True))


def moment_rows(rows: FloatArray) -> FloatArray:
    """Rows (..., 6) on the entries of G whose products with them are the squared amplitudes."""
    return np.asarray(rows[..., _I] * rows[..., _J] * _TWICE)


def quadratic_rank(rows: FloatArray) -> int:
    """How many of the levels of scaled rows are independent; six is the most."""
    if not len(rows):
        return 0
    size = np.linalg.svd(quadratic_rows(rows), compute_uv=False)
    return int(np.sum(size > NO_RANK * size[0]))


def least_determined(rows: FloatArray, amplitudes: FloatArray) -> Line:
    """Line of second moments through the least-squares fit, along what the levels tell least.

    With five independent levels every point of the line has exactly these amplitudes.
    """
    weights = 1.0 / amplitudes**2
    left = quadratic_rows(rows) * (np.linalg.norm(rows, axis=1) ** 2 * weights)[:, None]
    moments = np.linalg.lstsq(left, np.ones(len(rows)), rcond=NO_RANK)[0]
    direction = np.linalg.svd(quadratic_rows(rows))[2][-1]
    across = symmetric(direction)
    return Line(symmetric(moments), across / np.linalg.norm(across))


def symmetric(entries: FloatArray) -> FloatArray:
    """The matrix (3, 3) of six entries."""
    matrix = np.empty((3, 3))
    matrix[_I, _J] = entries
    matrix[_J, _I] = entries
    return matrix
