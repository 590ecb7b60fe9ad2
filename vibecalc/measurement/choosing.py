"""Which of the motions that levels allow is the right one: uncertainty of each, what decides."""

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from vibecalc.measurement.level_motions import NEEDED, LevelMotion, level_gradient
from vibecalc.measurement.plate import scaled, span_of
from vibecalc.measurement.second_moments import (
    ends,
    least_determined,
    moment_rows,
    quadratic_rows,
    symmetric,
)
from vibecalc.numerics.level import DECIBEL
from vibecalc.numerics.rounding import ComplexArray, FloatArray

# ----------------------------------------------------------------------------
# All motions within the rounding of their levels at once: how loud and how quiet a place can be.
#
# Levels within their half widths are linear bounds on the second moments G of a motion, and G is
# positive semidefinite. Both together are a convex set that holds every motion that the readings
# allow (and, between motions, mixtures of them). The largest and the least c' G c over it are found
# by cutting planes: G is semidefinite if z' G z >= 0 for all z, and a few z are enough. Each linear
# program on the way has too large a set, so that its extremes are bounds wherever the search stops.
# ----------------------------------------------------------------------------

_CUTS = 40
#: lowest eigenvalue over the largest, at which G counts as semidefinite
_SEMIDEFINITE = 1e-7
#: absolute error granted to a linear program whose numbers are of size one
_PROGRAM = 1e-7


class Extremes(NamedTuple):
    """Least and largest amplitudes (m,) at some rows; zero and infinity where nothing bounds."""

    low: FloatArray
    high: FloatArray


def extremes(
    rows: FloatArray, amplitudes: FloatArray, half_widths: FloatArray, targets: FloatArray
) -> Extremes | None:
    """Amplitudes that motions within `half_widths` (r,) dB of `amplitudes` (r,) have at `targets`.

    Rows (r, 3) and targets (m, 3) are scaled to one unit. None if no motion is within all half
    widths.
    """
    from scipy.optimize import linprog

    size = float(np.max(amplitudes))
    left = moment_rows(rows) * (size / amplitudes[:, None]) ** 2
    share = np.exp(2.0 * half_widths / DECIBEL)
    upper, lower = share * (1.0 + _PROGRAM), (1.0 - _PROGRAM) / share
    # what the levels do not tell is bounded by these two directions of it alone
    across = np.linalg.eigh(symmetric(np.linalg.svd(quadratic_rows(rows))[2][-1]))[1]
    cuts = [*moment_rows(across.T), *moment_rows(targets[np.any(targets != 0.0, axis=1)])]
    low, high = np.zeros(len(targets)), np.full(len(targets), np.inf)
    for place, target in enumerate(targets):
        length = float(np.linalg.norm(target))
        if length == 0.0:
            high[place] = 0.0
            continue
        aim = moment_rows(target / length)
        for side in (1.0, -1.0):
            value = np.nan
            for _ in range(_CUTS):
                end = linprog(
                    side * aim,
                    A_ub=np.vstack([left, -left, -np.array(cuts)]),
                    b_ub=np.concatenate([upper, -lower, np.zeros(len(cuts))]),
                    bounds=(None, None),
                )
                if end.status == 2:
                    return None
                if end.status != 0:
                    break
                value = float(aim @ end.x)
                values, vectors = np.linalg.eigh(symmetric(end.x))
                if values[0] >= -_SEMIDEFINITE * values[-1]:
                    break
                cuts.append(moment_rows(vectors[:, 0]))
            if np.isfinite(value):
                margin = value - side * 10.0 * _PROGRAM
                amplitude = size * length * max(margin, 0.0) ** 0.5
                (low if side > 0.0 else high)[place] = amplitude
    return Extremes(low, high)


# ----------------------------------------------------------------------------
# How far the amplitudes of a motion may be off while its levels are off by their rounding.
#
# Five levels leave a line of second moments, and a motion where it leaves the semidefinite ones.
# The place of that end is a concave or convex function of the squared amplitudes read, so that the
# largest change of any squared amplitude is at a corner of the rounding, or bounded by the tangent.
# If the line of some corner misses the semidefinite matrices, signals come into line within the
# rounding (the fold): both motions are then one family, and no slope tells how large it is. Its
# size is that of `level_family`, and so it is for more than five levels.
# ----------------------------------------------------------------------------

#: dB; a bound of one motion of five levels beyond this is compared with that of its family
_WIDE = 0.5
#: a bound of so many times that of first order says that first order does not hold
_HOLDS = 3.0


class Reach(NamedTuple):
    """What bounds the motions of one set of levels: rows (r, 3), amplitudes and half widths (r,).

    `folded` says that signals come into line within the half widths. Otherwise `corners` holds,
    for five levels, the motions (2, 32, 3) of the two ends with all readings at the ends of theirs.
    """

    rows: FloatArray
    amplitudes: FloatArray
    half_widths: FloatArray
    folded: bool
    corners: ComplexArray

    def bound(self, motion: LevelMotion, targets: FloatArray) -> FloatArray:
        """Largest error (m,) in dB of the levels of a motion at rows (m, 3).

        Infinite where the amplitude may be zero. Where more than five levels contradict each other
        beyond their half widths nothing bounds anything: then it is that of first order.
        """
        if self.folded or len(self.rows) > NEEDED:
            family = self._family(motion, targets)
            return self._tangent(motion, targets)[0] if family is None else family
        bound = np.maximum(self._tangent(motion, targets)[1], self._corner(motion, targets))
        wide = bound > _WIDE
        if np.any(wide):
            family = self._family(motion, targets[wide])
            if family is not None:
                bound[wide] = np.minimum(bound[wide], family)
        return bound

    def deviation(self, motion: LevelMotion, targets: FloatArray) -> FloatArray:
        """Standard uncertainty (m,) in dB of the levels of a motion at rows (m, 3).

        That of first order; where this does not hold, the bound over the root of three, as for an
        error of which nothing but its limits is known (JCGM 100:2008, 4.3.7).
        """
        gradient = level_gradient(targets, motion.motion)
        bound, first = self.bound(motion, targets), motion.spread.bound(gradient)
        holds = (not self.folded) & (bound <= _HOLDS * first)
        return np.where(holds, motion.spread.deviation(gradient), bound / 3.0**0.5)

    def _family(self, motion: LevelMotion, targets: FloatArray) -> FloatArray | None:
        span = span_of(self.rows)
        found = extremes(
            scaled(self.rows, span), self.amplitudes, self.half_widths, scaled(targets, span)
        )
        if found is None:
            return None
        size = np.abs(targets @ motion.motion)
        with np.errstate(divide="ignore", invalid="ignore"):
            off = np.maximum(np.log(found.high / size), np.log(size / found.low)) * DECIBEL
        return np.where(np.isfinite(off), np.maximum(off, 0.0), np.inf)

    def _tangent(self, motion: LevelMotion, targets: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Bounds (m,) of first order in dB, and of the tangent in squared amplitudes."""
        first = motion.spread.bound(level_gradient(targets, motion.motion))
        slopes = motion.spread.slopes
        if not np.isfinite(slopes).all():
            return first, first
        share = level_gradient(targets, motion.motion) @ slopes
        grown, shrunk = (np.expm1(side * self.half_widths * 2.0 / DECIBEL) for side in (1, -1))
        above = 1.0 + np.sum(np.maximum(share * grown, share * shrunk), axis=-1)
        below = 1.0 + np.sum(np.minimum(share * grown, share * shrunk), axis=-1)
        up = 0.5 * DECIBEL * np.log(above)
        down = np.full_like(up, np.inf)
        np.log(below, out=down, where=below > 0.0)
        down = np.where(below > 0.0, -0.5 * DECIBEL * down, np.inf)
        return first, np.maximum(up, down)

    def _corner(self, motion: LevelMotion, targets: FloatArray) -> FloatArray:
        """Largest change (m,) in dB over the corners, of the end that the motion is."""
        branch = min(self.corners, key=lambda one: _apart(motion.motion, one[0]))
        size, moved = np.abs(targets @ motion.motion), np.abs(branch[1:] @ targets.T)
        with np.errstate(divide="ignore", invalid="ignore"):
            off = DECIBEL * np.abs(np.log(moved / size))
        return np.asarray(np.max(np.where(np.isfinite(off), off, 0.0), axis=0))


def reach(rows: FloatArray, amplitudes: FloatArray, half_widths: FloatArray) -> Reach:
    """What bounds the motions that levels allow: rows (r, 3), amplitudes > 0, half widths in dB."""
    none = np.zeros((0, 0, 3), dtype=complex)
    plain = Reach(rows, amplitudes, half_widths, False, none)
    if len(rows) > NEEDED:
        return plain
    span = span_of(rows)
    size = float(np.max(amplitudes))
    found = []
    # the readings themselves come first
    for signs in ((0.0,) * NEEDED, *product((1.0, -1.0), repeat=NEEDED)):
        moved = amplitudes * np.exp(np.array(signs) * half_widths / DECIBEL) / size
        both = ends(least_determined(scaled(rows, span), moved))
        if len(both) < 2:
            return plain._replace(folded=True)
        found.append(np.stack(both) * size / np.array([1.0, span, span]))
    return plain._replace(corners=np.stack(found, axis=1))


def _apart(one: ComplexArray, other: ComplexArray) -> float:
    """Largest difference of the second moments of two motions, over the size of each."""
    moments = [np.real(np.multiply.outer(u, np.conj(u))) for u in (one, other)]
    scale = np.sqrt(np.outer(*(2 * [np.abs(one) ** 2 + np.abs(other) ** 2])))
    return float(np.max(np.abs(moments[0] - moments[1]) / np.maximum(scale, 1e-300)))


# ----------------------------------------------------------------------------
# Which of the motions that levels leave is the one: by further readings, and how surely.
# ----------------------------------------------------------------------------

#: a local minimum whose misfit is no more than so many times that of the best is as good
_AS_GOOD = 2.0


class MotionChoice(NamedTuple):
    """`ranking` of the motions, best first, and their `residuals` (c, k) at the choosing readings.

    `decided` says that the best stands out: by more than the choosing readings and what the motions
    predict for them may be off; or, without such readings, that no other motion lies within the
    readings it was found from, nor nearly as near to them.
    """

    ranking: tuple[int, ...]
    residuals: FloatArray
    decided: bool


def choose(
    motions: Sequence[LevelMotion],
    rows: FloatArray,
    amplitudes: FloatArray,
    half_widths: FloatArray,
    reach: Reach,
) -> MotionChoice:
    """Rank motions (best first by their own cost) by the levels of further readings.

    Rows (k, 3), amplitudes (k,) > 0 and half widths (k,) in dB are those of the further readings,
    of which there may be none. `reach` bounds what the motions may be off. Motions that are one
    family within the rounding are never decided on.
    """
    sizes = np.abs(np.stack([rows @ one.motion for one in motions]))
    # a node of a motion lies 6000 dB below the reading: it is surely not the one
    residuals = DECIBEL * np.log(np.maximum(sizes / amplitudes, np.finfo(float).tiny))
    worst = np.max(np.abs(residuals), axis=1, initial=0.0)
    ranking = tuple(np.argsort(worst, kind="stable").tolist())
    if reach.folded or len(motions) == 1:
        return MotionChoice(ranking, residuals, not reach.folded)
    first, second = ranking[:2]
    if not len(rows):
        misfit = max(1.0, _AS_GOOD * motions[first].misfit)
        return MotionChoice(ranking, residuals, bool(motions[second].misfit > misfit))
    at = int(np.argmax(np.abs(residuals[first] - residuals[second])))
    uncertain = half_widths[at] + sum(
        float(reach.bound(motions[place], rows[at][None])[0]) for place in (first, second)
    )
    more = abs(residuals[second, at]) - abs(residuals[first, at])
    return MotionChoice(ranking, residuals, bool(more > uncertain))


# ----------------------------------------------------------------------------
# Which further reading would tell two motions apart that the readings so far allow.
# ----------------------------------------------------------------------------


def most_telling(motions: ComplexArray, rows: FloatArray, quietest: float = 0.0) -> int | None:
    """The place in rows (m, 3) where the levels of two motions (2, 3) differ most; None if nowhere.

    Rows where either amplitude does not exceed `quietest` are passed over: a reading next to a node
    tells two motions apart on paper only.
    """
    sizes = np.abs(rows @ motions.T)
    loud = np.min(sizes, axis=1, initial=np.inf) > quietest
    if not np.any(loud):
        return None
    safe = np.where(loud[:, None], sizes, 1.0)
    return int(np.argmax(np.where(loud, np.abs(np.log(safe[:, 0] / safe[:, 1])), -1.0)))
