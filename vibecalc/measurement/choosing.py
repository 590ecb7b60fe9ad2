"""Which of the motions that levels allow is the right one: uncertainty of each, what decides."""

from collections.abc import Iterator, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from vibecalc.measurement.level_motions import NEEDED, LevelMotion, level_gradient
from vibecalc.measurement.plate import scaled, span_of
from vibecalc.measurement.second_moments import ends, least_determined, moment_rows, symmetric
from vibecalc.numerics.level import DECIBEL
from vibecalc.numerics.rounding import ComplexArray, FloatArray

# ----------------------------------------------------------------------------
# All motions within the rounding of their levels at once: how loud and how quiet a place can be.
#
# Levels within their half widths are linear bounds on the second moments G of a motion, and G is
# positive semidefinite. Both together are a convex set that holds every motion that the readings
# allow (and, between motions, mixtures of them). The largest and the least c' G c over it, for all
# places at once, are the ends of paths of centres: with the weight w of a logarithmic barrier and n
# conditions, next to a centre a dual point proves that no G has less than the value there less
# 2 n w (Boyd and Vandenberghe, Convex Optimization, 2004, ch. 11). Steps of Newton's method, those
# far from a centre divided by one and their length in the metric of the barrier, never leave the
# set and always end there (Nesterov and Nemirovskii, Interior-Point Polynomial Algorithms in Convex
# Programming, 1994, ch. 2).
# ----------------------------------------------------------------------------

#: relative width granted to levels, so that those which are met exactly leave a set with an inside
_WIDTH = 1e-7
#: weights of the barrier, in turn; the last leaves some 1e-8 of the loudest reading's square
_WEIGHTS = 0.1 ** np.arange(10.0)
#: Newton steps to one centre at most; as short as this they are next to it
_STEPS, _NEXT = 200, 0.25


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
    size = float(np.max(amplitudes))
    left = moment_rows(rows) * (size / amplitudes[:, None]) ** 2
    share = np.exp(2.0 * half_widths / DECIBEL)
    slope = np.concatenate([-left, left])
    offset = np.concatenate([share * (1.0 + _WIDTH), -(1.0 - _WIDTH) / share])
    inside = _inside(slope, offset)
    if inside is None:
        return None
    length = np.linalg.norm(targets, axis=1)
    aim = moment_rows(targets / np.where(length > 0.0, length, 1.0)[:, None])
    start = np.broadcast_to(inside, (2 * len(aim), len(inside)))
    *_, (place, beyond) = _centres(np.concatenate([aim, -aim]), slope, offset, start)
    values = np.sum(np.concatenate([aim, aim]) * place, axis=1)
    least = np.maximum(values[: len(aim)] - beyond[: len(aim)], 0.0)
    most = values[len(aim) :] + beyond[len(aim) :]
    return Extremes(*(size * length * np.sqrt(square) for square in (least, most)))


def _inside(slope: FloatArray, offset: FloatArray) -> FloatArray | None:
    """Second moments (6,) of a matrix > 0 with slope (n, 6) G + offset (n,) > 0, None without.

    All of these conditions are loosened by one number, which is made small.
    """
    even = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    even = even / np.max(slope @ even)
    loose = 1.0 - np.min(slope @ even + offset)
    more = np.column_stack([slope, np.ones(len(slope))])
    start = np.append(even, loose)[None]
    for place, _ in _centres(np.eye(7)[6:], more, offset, start):
        if place[0, 6] < 0.0:
            return np.asarray(place[0, :6])
    return None


def _centres(
    aim: FloatArray, slope: FloatArray, offset: FloatArray, start: FloatArray
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Centres x (k, n) ever nearer to the least of `aim` (k, n) x, and how far above it (k,).

    Of slope (m, n) x + offset (m,) > 0 where the first six unknowns are moments of a matrix > 0;
    `start` (k, n) is such a place. The distance is infinite where Newton's method has not ended.
    """
    place, basis = start, symmetric(np.eye(6))
    for weight in _WEIGHTS:
        for _ in range(_STEPS):
            pull = slope / (place @ slope.T + offset)[..., None]
            half = np.linalg.inv(np.linalg.cholesky(symmetric(place[:, :6])))[:, None]
            bent = half @ basis @ half.swapaxes(2, 3)
            gradient = aim / weight - np.sum(pull, axis=1)
            gradient[:, :6] -= np.trace(bent, axis1=2, axis2=3)
            table = np.zeros((len(place), 9, place.shape[1]))
            table[..., :6] = bent.reshape(-1, 6, 9).swapaxes(1, 2)
            # of the curvature, whose own numbers would be twice as far apart, the root
            root = np.asarray(np.linalg.qr(np.concatenate([pull, table], axis=1), mode="r"))
            across = np.linalg.solve(root.swapaxes(1, 2), -gradient[..., None])
            length = np.linalg.norm(across, axis=(1, 2))
            there = length <= _NEXT
            step = np.linalg.solve(root, across)[..., 0]
            place = place + step / np.where(there, 1.0, 1.0 + length)[:, None]
            if there.all():
                break
        yield place, np.where(there, 2.0 * (3 + len(offset)) * weight, np.inf)


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
