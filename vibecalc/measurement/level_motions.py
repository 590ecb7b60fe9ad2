"""All motions that the levels of one harmonic allow, by least squares in dB, with spread."""

from collections.abc import Iterator
from itertools import combinations, islice
from math import comb
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.measurement.plate import scaled, span_of
from vibecalc.measurement.second_moments import (
    NO_RANK,
    Line,
    ends,
    least_determined,
    quadratic_rank,
)
from vibecalc.numerics.level import DECIBEL
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray

# ----------------------------------------------------------------------------
# Least squares in dB: the motion whose levels are nearest to those read, from a start.
# ----------------------------------------------------------------------------

_STEPS, _HALVINGS = 200, 40
#: relative size of a step after which nothing changes any more
_STILL = 8.0 * EPSILON
#: relative size of a step after which whole steps are taken, and how many at most
_NEAR, _WHOLE = 1e-4, 6
#: residuals, in dB, that are nothing but the rounding of levels
_EXACT = 64.0 * EPSILON * DECIBEL
#: a negative curvature larger than this share of the largest marks a saddle
_SADDLE = 1e-9


class Fit(NamedTuple):
    """Motion (3,), residual (r,) in dB (computed less read), sum of squares, and its curvature.

    `hessian` (6, 6) and `jacobian` (r, 6) are those of the residuals over their half widths by
    the real and then the imaginary parts of the motion.
    """

    motion: ComplexArray
    residual: FloatArray
    cost: float
    hessian: FloatArray
    jacobian: FloatArray


def refine(
    rows: FloatArray, amplitudes: FloatArray, half_widths: FloatArray, start: ComplexArray
) -> Fit:
    """Newton's method with the full Hessian, on scaled rows (r, 3) and amplitudes (r,) > 0.

    `half_widths` (r,) in dB weigh the residuals. The full Hessian matters where readings
    contradict each other a little: two phasors then lie along one line, and the residuals have no
    slope across it.

    Raises
    ------
    NumericalFailure : no convergence.
    """
    given = (rows, amplitudes, half_widths)
    fit = evaluate(*given, _clear(rows, amplitudes, start))
    for _ in range(_STEPS):
        if np.max(np.abs(fit.residual)) <= _EXACT:
            return fit
        curvature, vectors = np.linalg.eigh(fit.hessian)
        step = _newton(fit, half_widths, np.abs(curvature), vectors)
        escape = curvature[0] < -_SADDLE * curvature[-1]
        size, length = float(np.linalg.norm(fit.motion)), float(np.linalg.norm(step))
        if length <= _STILL * size:
            if not escape:
                return fit
            step[0] = 1e-2 * size  # off a saddle, to either side
            length = float(np.linalg.norm(step))
        change = vectors @ (step * min(1.0, 0.5 * size / length))
        better = _shorten(*given, fit, change[:3] + 1j * change[3:])
        if better is None:
            near = not escape and length <= _NEAR * size
            return _settled(*given, fit) if near else fit
        fit = better
    raise NumericalFailure("the motion of the plate: least squares in dB did not converge")


def _newton(
    fit: Fit, half_widths: FloatArray, curvature: FloatArray, vectors: FloatArray
) -> FloatArray:
    """A step in terms of the eigenvectors of the Hessian, less what turns all phases alike.

    No level tells that, so that it is rounding over rounding, and being straight it lengthens.
    """
    slope = vectors.T @ (fit.jacobian.T @ (fit.residual / half_widths))
    bent = np.abs(curvature) > _STILL * np.max(np.abs(curvature))
    step = np.where(bent, -slope / np.where(bent, curvature, 1.0), 0.0)
    turn = np.concatenate([-fit.motion.imag, fit.motion.real])
    along = vectors.T @ (turn / max(float(np.linalg.norm(turn)), np.finfo(float).tiny))
    return np.asarray(step - along * float(along @ step))


def _settled(rows: FloatArray, amplitudes: FloatArray, half_widths: FloatArray, fit: Fit) -> Fit:
    """Whole steps of Newton's method as long as they shrink.

    Next to the least sum of squares the sum is flat, and tells half the digits of the place only;
    its slope tells the others.
    """
    last = np.inf
    for _ in range(_WHOLE):
        curvature, vectors = np.linalg.eigh(fit.hessian)
        step = vectors @ _newton(fit, half_widths, curvature, vectors)
        length = float(np.linalg.norm(step))
        motion = fit.motion + step[:3] + 1j * step[3:]
        if length > 0.5 * last or np.min(np.abs(rows @ motion)) == 0.0:
            return fit
        last, fit = length, evaluate(rows, amplitudes, half_widths, motion)
    return fit


def evaluate(
    rows: FloatArray, amplitudes: FloatArray, half_widths: FloatArray, motion: ComplexArray
) -> Fit:
    """Residuals, their derivatives and the curvature of half their sum of squares."""
    signal = rows @ motion
    residual = DECIBEL * np.log(np.abs(signal) / amplitudes)
    inverse = 1.0 / signal
    slope = DECIBEL * inverse[:, None] * rows / half_widths[:, None]
    jacobian = np.concatenate([slope.real, -slope.imag], axis=1)
    weight = residual / half_widths**2
    bend = -DECIBEL * np.einsum("r,r,ri,rj->ij", weight, inverse**2, rows, rows)
    curved = np.block([[bend.real, -bend.imag], [-bend.imag, -bend.real]])
    cost = float(np.sum((residual / half_widths) ** 2))
    return Fit(motion, residual, cost, jacobian.T @ jacobian + curved, jacobian)


def _clear(rows: FloatArray, amplitudes: FloatArray, start: ComplexArray) -> ComplexArray:
    """The start, moved a little where one of the signals is zero and has no level."""
    shift = 1e-6 * np.max(amplitudes) / np.max(np.abs(rows)) * np.array([1.0, 0.7j, 0.4])
    for _ in range(20):
        if np.min(np.abs(rows @ start) / amplitudes) > 1e-9:
            return start
        start, shift = start + shift, 2.0 * shift
    return start


def _shorten(
    rows: FloatArray,
    amplitudes: FloatArray,
    half_widths: FloatArray,
    fit: Fit,
    change: ComplexArray,
) -> Fit | None:
    """The first of ever shorter steps that lowers the cost; None if none does."""
    for halving in range(_HALVINGS):
        motion = fit.motion + change * 0.5**halving
        if np.min(np.abs(rows @ motion)) == 0.0:
            continue
        trial = evaluate(rows, amplitudes, half_widths, motion)
        if trial.cost < fit.cost:
            return trial
    return None


# ----------------------------------------------------------------------------
# How far a motion moves when its readings move a little: from readings to any result.
#
# To first order. Everything is real here: the parts of a motion are its three real, then its three
# imaginary parts, and a result is a gradient by them.
# ----------------------------------------------------------------------------

#: share of the largest curvature below which the motion hangs on rounding alone
_FLAT = 1e-13


class MotionSpread(NamedTuple):
    """`slopes` (6, n) of the parts of a motion by its readings; how far these may be off.

    `half_widths` (n,) bound a reading's error, `deviations` (n,) are its standard uncertainty.
    An infinite slope says that first order does not hold. `uncertainty` is the relative error of
    the slopes from rounding.
    """

    slopes: FloatArray
    half_widths: FloatArray
    deviations: FloatArray
    uncertainty: float = 0.0

    def deviation(self, gradient: FloatArray) -> FloatArray:
        """Standard uncertainty (...) of results with gradients (..., 6)."""
        return np.asarray(np.linalg.norm(self._moves(gradient) * self.deviations, axis=-1))

    def bound(self, gradient: FloatArray) -> FloatArray:
        """Largest change (...) of results with gradients (..., 6), all readings at their ends."""
        return np.asarray(np.abs(self._moves(gradient)) @ self.half_widths)

    def _moves(self, gradient: FloatArray) -> FloatArray:
        if not np.isfinite(self.slopes).all():
            return np.where(np.any(gradient != 0.0, axis=-1)[..., None], np.inf, 0.0) * np.ones(
                self.slopes.shape[1]
            )
        return np.asarray(gradient @ self.slopes)


def level_spread(
    fit: Fit, reference: FloatArray, half_widths: FloatArray, deviations: FloatArray
) -> MotionSpread:
    """Spread of a motion found from levels, its phase held at a reference row (3,)."""
    values, vectors = np.linalg.eigh(fit.hessian)
    turn = np.concatenate([-fit.motion.imag, fit.motion.real])
    turn = turn / np.linalg.norm(turn)
    # the common phase is free: it is the one direction without curvature
    free = int(np.argmax(np.abs(vectors.T @ turn)))
    resolved = np.delete(np.arange(6), free)
    widths = (half_widths, deviations)
    if np.min(values[resolved]) <= _FLAT * np.max(values):
        return MotionSpread(np.full((6, len(half_widths)), np.inf), *widths)
    uncertainty = 16.0 * EPSILON * float(np.max(values) / np.min(values[resolved]))
    inverse = (vectors[:, resolved] / values[resolved]) @ vectors[:, resolved].T
    slopes = inverse @ (fit.jacobian / half_widths[:, None]).T
    signal = complex(reference @ fit.motion)
    across = _phase_gradient(reference, signal)
    along = float(across @ turn)
    slopes = slopes - np.multiply.outer(turn, across @ slopes) / along
    return MotionSpread(slopes, *widths, uncertainty)


def level_gradient(rows: FloatArray, motion: ComplexArray) -> FloatArray:
    """Gradients (..., 6) of levels in dB at rows (..., 3); zero where the signal is zero."""
    slope = DECIBEL * rows * _inverse(rows @ motion)[..., None]
    return np.concatenate([slope.real, -slope.imag], axis=-1)


def phase_gradient(rows: FloatArray, motion: ComplexArray) -> FloatArray:
    """Gradients (..., 6) of phases in rad at rows (..., 3); zero where the signal is zero."""
    return _phase_gradient(rows, rows @ motion)


def _phase_gradient(rows: FloatArray, signal: ComplexArray | complex) -> FloatArray:
    slope = rows * np.asarray(_inverse(signal))[..., None]
    return np.concatenate([slope.imag, slope.real], axis=-1)


def _inverse(signal: ComplexArray | complex) -> ComplexArray:
    value = np.asarray(signal, dtype=complex)
    there = np.abs(value) > 0.0
    return np.asarray(np.where(there, 1.0, 0.0) / np.where(there, value, 1.0))


# ----------------------------------------------------------------------------
# All motions that levels of one harmonic allow, exactly or as local minima of least squares.
# ----------------------------------------------------------------------------

#: independent levels that leave no more than two motions
NEEDED = 5
#: sets of five levels, of more, from whose motions the search starts
_MOST_STARTS = 24
#: second moments nearer than this, relative to the largest, are one motion
_SAME = 1e-6
#: dB; a larger residual of five levels says that no motion has them
_MISSED = 1e-7


class LevelMotion(NamedTuple):
    """One motion, in SI: complex (3,), zero-phase at the reference row, roll with a phase >= 0.

    `residual` (r,) in dB is computed less read; `misfit` the least factor by which the half
    widths of the readings would have to grow for such a motion to lie within all of them (to first
    order; 0 where the levels are met exactly); `clipped` marks five levels that no motion has.
    """

    motion: ComplexArray
    residual: FloatArray
    cost: float
    misfit: float
    clipped: bool
    spread: MotionSpread


def level_motions(
    rows: FloatArray,
    amplitudes: FloatArray,
    half_widths: FloatArray,
    reference: FloatArray,
    deviations: FloatArray,
) -> list[LevelMotion]:
    """Motions whose amplitudes at `rows` (r, 3) are `amplitudes` (r,) > 0, the best first.

    `half_widths` (r,) in dB are how far a reading may be off, `deviations` its standard
    uncertainty; `reference` (3,) is the row whose phase is zero. Levels leave a common phase and
    the sign of all phases open: one of each pair is given.

    Raises
    ------
    NumericalFailure : fewer than five independent levels; or just five (or as many as are
        independent) that contradict each other by more than their half widths, said in dB.
    """
    span = span_of(rows)
    plain, size = scaled(rows, span), float(np.max(amplitudes))
    rank = quadratic_rank(plain)
    if rank < NEEDED:
        raise NumericalFailure(
            f"the levels determine {rank} of the {NEEDED} numbers of the motion: "
            "more points or differences have to be read"
        )
    heights = amplitudes / size
    fits: list[Fit] = []
    for start in (motion for line in lines(plain, heights) for motion in ends(line)):
        try:
            fit = refine(plain, heights, half_widths, start)
        except NumericalFailure:
            continue
        if not any(_same(fit.motion, other.motion) for other in fits):
            fits.append(fit)
    if not fits:
        raise NumericalFailure("the motion of the plate: least squares in dB did not converge")
    place, units = scaled(reference, span), size / np.array([1.0, span, span])
    motions = [
        _motion(fit, half_widths, place, deviations, units)
        for fit in sorted(fits, key=lambda fit: fit.cost)
    ]
    if len(rows) == NEEDED:
        motions = [one for one in motions if not one.clipped] or motions[:1]
        best, granted = motions[0], float(np.max(half_widths))
        if best.clipped and best.misfit > 1.0:
            raise NumericalFailure(
                "the levels contradict each other: no rigid plate moves so, unless a reading is "
                f"off by {best.misfit * granted:.2g} dB or more, and {granted:.2g} dB is granted"
            )
    return motions


def lines(rows: FloatArray, amplitudes: FloatArray) -> Iterator[Line]:
    """The line that all levels leave, then those that five of them leave; rows (r, 3) scaled."""
    yield least_determined(rows, amplitudes)
    count = len(rows)
    if count == NEEDED:
        return
    stride = max(1, comb(count, NEEDED) // _MOST_STARTS)
    for chosen in islice(combinations(range(count), NEEDED), 0, None, stride):
        some = list(chosen)
        if quadratic_rank(rows[some]) == NEEDED:
            yield least_determined(rows[some], amplitudes[some])


def _motion(
    fit: Fit,
    half_widths: FloatArray,
    reference: FloatArray,
    deviations: FloatArray,
    units: FloatArray,
) -> LevelMotion:
    """A fit in SI, with phase zero at the reference and a roll that leads it."""
    signal = complex(reference @ fit.motion)
    if abs(signal) == 0.0:
        raise NumericalFailure(
            "the reading that phases refer to is zero: name another reference position"
        )
    factor = np.conj(signal / abs(signal))
    motion = fit.motion * factor
    sides = motion.imag[[1, 2, 0]]
    meant = np.flatnonzero(np.abs(sides) > 1e-12 * np.max(np.abs(motion)))
    side = -1.0 if meant.size and sides[meant[0]] < 0.0 else 1.0
    motion = motion.real + 1j * side * motion.imag
    spread = level_spread(fit, reference, half_widths, deviations)
    if np.isfinite(spread.slopes).all():
        moves = (spread.slopes[:3] + 1j * spread.slopes[3:]) * factor
        slopes = np.concatenate([moves.real, side * moves.imag])
        spread = spread._replace(slopes=slopes * np.tile(units, 2)[:, None])
    clipped = bool(np.max(np.abs(fit.residual)) > _MISSED) and len(half_widths) == NEEDED
    total = float(np.sum(np.abs(fit.residual) / half_widths))
    misfit = fit.cost / total if total > 0.0 else 0.0
    return LevelMotion(motion * units, fit.residual, fit.cost, misfit, clipped, spread)


def _same(one: ComplexArray, other: ComplexArray) -> bool:
    moments = [np.real(np.multiply.outer(u, np.conj(u))) for u in (one, other)]
    off = float(np.max(np.abs(moments[0] - moments[1])))
    return off <= _SAME * float(np.max(np.abs(moments[0])))


# ----------------------------------------------------------------------------
# What readings can tell of the motion of a plate, from their places alone.
# ----------------------------------------------------------------------------


class Observable(NamedTuple):
    """Motions that no reading sees, and how many of the levels are independent.

    `unseen` (k, 3) holds real motions (a_0, alpha_x, alpha_y), with angular accelerations times
    the span of the plate, that are zero at every reading; `levels` counts to six, of which five
    leave at most two motions.
    """

    unseen: FloatArray
    levels: int
    span: float


def observable(rows: FloatArray) -> Observable:
    """What rows (r, 3), r >= 1, tell."""
    span = span_of(rows)
    plain = scaled(rows, span)
    unit = plain / np.linalg.norm(plain, axis=1, keepdims=True)
    size, right = np.linalg.svd(unit)[1:]
    seen = int(np.sum(size > NO_RANK * size[0]))
    return Observable(right[seen:], quadratic_rank(plain), span)


def helpful(rows: FloatArray, further: FloatArray) -> list[int]:
    """Places, in `further` (m, 3), of readings whose levels are independent of those at `rows`."""
    span = span_of(np.concatenate([rows, further]))
    plain, more = scaled(rows, span), scaled(further, span)
    rank = quadratic_rank(plain)
    if rank > NEEDED:
        return []
    return [
        place
        for place, row in enumerate(more)
        if np.any(row) and quadratic_rank(np.vstack([plain, row])) > rank
    ]
