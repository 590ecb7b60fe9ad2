"""Least squares in dB: the motion whose levels are nearest to those read, from a start."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.measurement.level import DECIBEL
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import ComplexArray, FloatArray

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
    the real and then the imaginary parts of the motion. `looks` counts the motions that were
    evaluated on the way.
    """

    motion: ComplexArray
    residual: FloatArray
    cost: float
    hessian: FloatArray
    jacobian: FloatArray
    looks: int = 1


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
    motion = _clear(rows, amplitudes, start)
    fit = evaluate(rows, amplitudes, half_widths, motion)
    for _ in range(_STEPS):
        if np.max(np.abs(fit.residual)) <= _EXACT:
            return fit
        gradient = fit.jacobian.T @ (fit.residual / half_widths)
        curvature, vectors = np.linalg.eigh(fit.hessian)
        slope = vectors.T @ gradient
        floor = _STILL * float(np.max(np.abs(curvature)))
        turned = np.abs(curvature) > floor
        step = np.where(turned, -slope / np.where(turned, np.abs(curvature), 1.0), 0.0)
        step = _without_phase(step, vectors, fit.motion)
        escape = curvature[0] < -_SADDLE * curvature[-1]
        size = float(np.linalg.norm(fit.motion))
        if np.linalg.norm(step) <= _STILL * size:
            if not escape:
                return fit
            step[0] = 1e-2 * size  # off a saddle, to either side
        longest = 0.5 * size / max(float(np.linalg.norm(step)), np.finfo(float).tiny)
        change = vectors @ (step * min(1.0, longest))
        better = _shorten(rows, amplitudes, half_widths, fit, change[:3] + 1j * change[3:])
        if better is None:
            near = not escape and np.linalg.norm(step) <= _NEAR * size
            return _settled(rows, amplitudes, half_widths, fit) if near else fit
        fit = better
    raise NumericalFailure("the motion of the plate: least squares in dB did not converge")


def _settled(rows: FloatArray, amplitudes: FloatArray, half_widths: FloatArray, fit: Fit) -> Fit:
    """Whole steps of Newton's method as long as they shrink.

    Beside the least sum of squares the sum is flat, and tells half the digits of the place only;
    its slope tells the others.
    """
    last = np.inf
    for _ in range(_WHOLE):
        gradient = fit.jacobian.T @ (fit.residual / half_widths)
        curvature, vectors = np.linalg.eigh(fit.hessian)
        turned = np.abs(curvature) > _STILL * float(np.max(np.abs(curvature)))
        slope = vectors.T @ gradient
        step = np.where(turned, -slope / np.where(turned, curvature, 1.0), 0.0)
        step = vectors @ _without_phase(step, vectors, fit.motion)
        length = float(np.linalg.norm(step))
        motion = fit.motion + step[:3] + 1j * step[3:]
        if length > 0.5 * last or np.min(np.abs(rows @ motion)) == 0.0:
            return fit
        last, looks = length, fit.looks + 1
        fit = evaluate(rows, amplitudes, half_widths, motion)._replace(looks=looks)
    return fit


def _without_phase(step: FloatArray, vectors: FloatArray, motion: ComplexArray) -> FloatArray:
    """A step, in terms of `vectors`, less what turns all phases alike.

    No level tells that, so that it is rounding over rounding, and being straight it lengthens.
    """
    turn = np.concatenate([-motion.imag, motion.real])
    along = vectors.T @ (turn / max(float(np.linalg.norm(turn)), np.finfo(float).tiny))
    return np.asarray(step - along * float(along @ step))


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
            return trial._replace(looks=fit.looks + halving + 1)
    return None
