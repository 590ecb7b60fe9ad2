"""Second moments of a motion from levels, and the two motions that a line of them leaves."""

import math
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import UNIT_ROUNDOFF, ComplexArray, FloatArray

# ----------------------------------------------------------------------------
# Levels as linear readings of a matrix: what they determine, and the two motions they leave.
#
# A level gives |c u|^2 = c' G c with the row c and G = Re(u u^H), the real symmetric matrix of
# second moments of the motion u. G forgets of u a common phase and the sign of all phases, which no
# level can tell, and nothing else. It is positive semidefinite of rank two (or one). So levels are
# *linear* in the six entries of G. Five independent ones leave a line G_0 + t N; it enters and
# leaves the convex cone of semidefinite matrices once each, and there the rank is two: two motions,
# at most (see `cone_ends`), whatever the places of the accelerometers. For three points and two
# differences they are the pairs (+/+) and (+/-) of Herold (1977), eqs. 32 and 33.
# ----------------------------------------------------------------------------

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
    """The matrices (..., 3, 3) of six entries (..., 6)."""
    matrix = np.empty((*entries.shape[:-1], 3, 3))
    matrix[..., _I, _J] = entries
    matrix[..., _J, _I] = entries
    return matrix


# ----------------------------------------------------------------------------
# The two motions of a line of second moments: where it enters and leaves the semidefinite ones.
#
# The lowest eigenvalue of G_0 + t N is a concave function of t with the slope v' N v of its vector
# v. Newton's method from surely outside stays outside, since a tangent of a concave function lies
# above it, and comes to the ends from both sides. Where it passes the highest place there are no
# ends: halving then finds that place, the nearest approach.
# ----------------------------------------------------------------------------

#: lowest eigenvalue, over the largest, that is nothing but rounding
_ZERO = 4.0 * UNIT_ROUNDOFF
#: steps at most; where both ends meet each one halves the distance only
_MOST = 100
#: distance of two places, of a matrix of size one, that makes none
_STILL = 0.25 * UNIT_ROUNDOFF


class _Lowest(NamedTuple):
    """Eigenvalues (..., 3) and vectors (..., 3, 3) at places (...), and the slope of the lowest."""

    place: FloatArray
    values: FloatArray
    vectors: FloatArray
    slope: FloatArray


def ends(line: Line) -> list[ComplexArray]:
    """Motions (3,) at the two ends of the line's way through the semidefinite matrices.

    Where it misses them there is one, of the nearest approach: no motion has these amplitudes.
    """
    size = float(np.linalg.norm(line.origin))
    if not size > 0.0:
        return [np.zeros(3, dtype=complex)]
    unit = Line(line.origin / size, line.direction / float(np.linalg.norm(line.direction)))
    at = np.array(_bracket(unit))
    for _ in range(_MOST):
        lowest = _lowest(unit, at)
        if not (lowest.slope[0] > 0.0 > lowest.slope[1]):
            return [math.sqrt(size) * _factor(_highest(unit))]
        if np.all(np.abs(lowest.values[:, 0]) <= _ZERO * lowest.values[:, 2]):
            break
        at = at - lowest.values[:, 0] / lowest.slope
    return [math.sqrt(size) * _factor(lowest, place) for place in range(2)]


def _highest(line: Line) -> _Lowest:
    """The place where the lowest eigenvalue is largest, by halving: its slope falls."""
    low, high = _bracket(line)
    peak = _lowest(line, np.asarray(low))
    while high - low > _STILL and low < (middle := 0.5 * (low + high)) < high:
        lowest = _lowest(line, np.asarray(middle))
        if lowest.values[0] > peak.values[0]:
            peak = lowest
        low, high = (middle, high) if lowest.slope > 0.0 else (low, middle)
    return peak


def _bracket(line: Line) -> tuple[float, float]:
    """Places on either side where the matrix is surely indefinite."""
    spread = np.linalg.eigvalsh(line.direction)
    return -1.01 / float(spread[-1]), -1.01 / float(spread[0])


def _lowest(line: Line, place: FloatArray) -> _Lowest:
    values, vectors = np.linalg.eigh(line.origin + place[..., None, None] * line.direction)
    first = vectors[..., 0]
    slope = np.einsum("...i,ij,...j->...", first, line.direction, first)
    return _Lowest(place, values, vectors, slope)


def _factor(lowest: _Lowest, place: int | None = None) -> ComplexArray:
    """The motion whose second moments are nearest to those at a place of the line."""
    values, vectors = lowest.values, lowest.vectors
    if place is not None:
        values, vectors = values[place], vectors[place]
    size = np.sqrt(np.maximum(values[1:], 0.0))
    return np.asarray(vectors[:, 2] * size[1] + 1j * vectors[:, 1] * size[0])
