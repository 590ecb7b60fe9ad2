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
    """The matrix (3, 3) of six entries."""
    matrix = np.empty((3, 3))
    matrix[_I, _J] = entries
    matrix[_J, _I] = entries
    return matrix


# ----------------------------------------------------------------------------
# The two motions of a line of second moments: where it enters and leaves the semidefinite ones.
#
# Between the ends of G_0 + t N all eigenvalues are positive, so that all roots of its determinant,
# a cubic in t, are real, and the ends are neighbours among them: the upper two where N has two
# positive eigenvalues, the lower two where it has one. The lowest eigenvalue is a concave function
# of t with the slope v' N v of its vector v. Newton's method on it mends the last digits of the
# roots; where these cannot be trusted, halving finds its maximum, and Brent's method the ends.
# ----------------------------------------------------------------------------

#: lowest eigenvalues, over the size of the matrix, that are nothing but rounding, well or badly met
_ZERO, _COARSE = 4.0 * UNIT_ROUNDOFF, 64.0 * UNIT_ROUNDOFF
#: steps over the distance of both ends: below this the roots were good, beyond it ends meet
_CLOSE, _FAR = 1e-6, 1e-2
_POLISH = 8
#: distance of two places, of a matrix of size one, that makes none; relative error of a root
_STILL = 0.25 * UNIT_ROUNDOFF
_ROOT = 4.0 * float(np.finfo(float).eps)


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
    found = _by_roots(unit) or _by_search(unit)
    return [math.sqrt(size) * motion for motion in found]


def _by_roots(line: Line) -> list[ComplexArray] | None:
    """From the roots of the determinant; None where the ends meet, or where the line misses."""
    at = _root_pair(line)
    if at is None:
        return None
    for _ in range(_POLISH):
        lowest = _lowest(line, at)
        if not (lowest.slope[0] > 0.0 > lowest.slope[1]):
            return None
        step = -lowest.values[:, 0] / lowest.slope
        off, gap = float(np.max(np.abs(step))), float(at[1] - at[0])
        small = np.max(np.abs(lowest.values[:, 0] / lowest.values[:, 2]))
        if off > _FAR * gap:
            return None
        if small <= _ZERO:
            break
        at = at + step
    # else rounding no longer shrinks
    if small <= _ZERO or (off <= _CLOSE * gap and small <= _COARSE):
        return [_factor(lowest, place) for place in range(2)]
    return None


def _root_pair(line: Line) -> FloatArray | None:
    """The two of the three roots of det(G_0 + t N) between which the matrix can be positive.

    None where not all are real, or too large to be distinguished from infinite ones.
    """
    from scipy.linalg import eigvals

    roots = -eigvals(line.origin, line.direction)
    low, high = _bracket(line)
    within = (roots.imag == 0.0) & (roots.real >= low) & (roots.real <= high)
    finite = np.sort(roots.real[within])
    if finite.size < 2:
        return None
    # the cubic is positive between the upper two of three where it falls at last
    last = finite.size == 3 and np.linalg.det(line.direction) < 0.0
    return finite[1:] if last else finite[:2]


def _by_search(line: Line) -> list[ComplexArray]:
    """From the largest lowest eigenvalue outwards, where that is positive."""
    from scipy.optimize import brentq

    def value(place: float) -> float:
        return float(_lowest(line, np.asarray(place)).values[0])

    outside = _bracket(line)
    low, high = outside
    peak = _lowest(line, np.asarray(low))
    while high - low > _STILL and low < (middle := 0.5 * (low + high)) < high:
        lowest = _lowest(line, np.asarray(middle))
        if lowest.values[0] > peak.values[0]:
            peak = lowest
        # the slope of a concave function falls
        low, high = (middle, high) if lowest.slope > 0.0 else (low, middle)
    if not peak.values[0] > 0.0:
        return [_factor(peak)]
    roots = (brentq(value, end, float(peak.place), xtol=1e-300, rtol=_ROOT) for end in outside)
    return [_factor(_lowest(line, np.asarray(root))) for root in roots]


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
