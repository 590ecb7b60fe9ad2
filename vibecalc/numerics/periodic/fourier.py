"""Periodic solutions by Fourier collocation: equispaced points and trigonometric interpolation.

Exponentially accurate for right-hand sides that are smooth all around; kinks leave an algebraic
error, which the estimate shows.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.periodic.panels import Rhs, solve_or_nan
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.numerics.typing import BoolArray, ComplexArray, FloatArray

MOST_ITERATIONS = 40
_MOST_HALVINGS = 12
_SAFETY = 2.0


class FourierSolution(NamedTuple):
    """Values (B, N, n) at x (N,), harmonics (B, N // 2 + 1, n), 0-to-peak (mean for order 0).

    y(x) = Re sum_k Y_k exp(i k (x - x_0) 2 pi / period). `error` (B, n) is absolute, for y at any
    x; infinite where `converged` (B,) is false. `residual` (B,) is absolute, in units of y'.
    """

    x: FloatArray
    values: FloatArray
    harmonics: ComplexArray
    error: FloatArray
    residual: FloatArray
    iterations: int
    converged: BoolArray


def solve_fourier(
    rhs: Rhs,
    points: int,
    guess: ArrayLike,
    *,
    period: float = 2.0 * np.pi,
    tolerance: float = 1e-13,
) -> FourierSolution:
    """Periodic solution of y' = f(x, y), from x = 0 on.

    Parameters
    ----------
    rhs : Rhs
        As for panels, called with one panel of `points` points and piece None.
    points : int
        Odd, at least 3, so that every harmonic has its sine and cosine.
    guess : array (n,), (B, n) or (B, N, n)
        State to start from.

    Members without convergence are marked, nothing is raised but for a wrong number of points.

    Source: Trefethen (2000), Spectral methods in Matlab, chapter 3.
    """
    if points < 3 or points % 2 == 0:
        raise NumericalFailure(
            f"Fourier collocation needs an odd number of points, 3 or more, not {points}"
        )
    given = np.asarray(guess, dtype=np.float64)
    values = np.array(given if given.ndim == 3 else np.atleast_2d(given)[:, None])
    members, states = len(values), values.shape[-1]
    values = np.broadcast_to(values, (members, points, states)).copy()
    x = np.asarray(np.arange(points) * (period / points), dtype=np.float64)
    grid = np.broadcast_to(x, (members, 1, points)).copy()
    matrix = _differentiation(points) * (2.0 * np.pi / period)

    def look(at: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        f, jacobian = rhs(grid, at[:, None], None)
        missed = matrix @ at - f[:, 0]
        size = np.abs(missed).max(axis=(1, 2))
        return missed, jacobian[:, 0], np.where(np.isnan(size), np.inf, size)

    with np.errstate(all="ignore"):
        missed, jacobian, size = look(values)
        active, converged = np.isfinite(size), np.zeros(members, dtype=bool)
        before, count = np.full(members, np.inf), 0
        while active.any() and count < MOST_ITERATIONS:
            count += 1
            step = solve_or_nan(_system(matrix, jacobian), -missed.reshape(members, -1, 1))
            step = step.reshape(values.shape)
            scale = np.abs(values).max(axis=1) + np.abs(step).max(axis=1)
            last = np.max(np.abs(step).max(axis=1) / np.where(scale > 0.0, scale, 1.0), axis=1)
            active &= np.isfinite(last)
            ended = (last <= tolerance) | ((last < 1e-2) & (last**3 <= tolerance * before**2))
            ended |= (last < 1e-7) & (last > 0.25 * before)
            length = active.astype(np.float64)
            for _ in range(_MOST_HALVINGS):
                trial = np.where(length[:, None, None] > 0.0,
                                 values + length[:, None, None] * step, values)  # fmt: skip
                seen = look(trial)
                good = (seen[2] <= (1.0 - 0.1 * length) * size) | ended | ~active
                if good.all():
                    break
                length = np.where(good, length, 0.5 * length)
            taken = good & active
            values = np.where(taken[:, None, None], trial, values)
            missed, jacobian, size = seen if taken.all() else look(values)
            before = np.where(length == 1.0, last, np.inf)
            converged |= ended & taken
            active &= taken & ~ended
        harmonics = _harmonics(values)
        error = _error(rhs, grid, period, values, jacobian, matrix)
    error = np.where(converged[:, None] & np.isfinite(error), error, np.inf)
    residual = np.asarray(size, dtype=np.float64)
    return FourierSolution(x, values, harmonics, error, residual, count, converged)


@lru_cache(maxsize=16)
def _differentiation(points: int) -> FloatArray:
    """Derivative at equispaced points over 2 pi, odd number."""
    step = np.arange(points)[:, None] - np.arange(points)
    sine = np.where(step == 0, 1.0, np.sin(np.pi * step / points))
    matrix = np.where(step == 0, 0.0, 0.5 * np.where(step % 2 == 0, 1.0, -1.0) / sine)
    return np.asarray(matrix)


def _system(matrix: FloatArray, jacobian: FloatArray) -> FloatArray:
    """Derivative less Jacobian (B, N, n, n), as (B, N n, N n)."""
    members, points, states = jacobian.shape[:3]
    whole = np.zeros((members, points, states, points, states))
    for state in range(states):
        whole[:, :, state, :, state] = matrix
    place = np.arange(points)
    whole[:, place, :, place, :] -= jacobian.swapaxes(0, 1)
    return whole.reshape(members, points * states, points * states)


def _harmonics(values: FloatArray) -> ComplexArray:
    spectrum = np.fft.rfft(values, axis=1) / values.shape[1]
    spectrum[:, 1:] *= 2.0
    return np.asarray(spectrum)


def _error(
    rhs: Rhs, grid: FloatArray, period: float,
    values: FloatArray, jacobian: FloatArray, matrix: FloatArray,
) -> FloatArray:  # fmt: skip
    """From the defect midway between the points.

    Its orders that the points can hold pass through the linearised problem; higher ones act through
    their integral alone. Round-off passes through it as well.
    """
    members, points, states = values.shape
    order = np.arange(2 * points // 2 + 1)
    spectrum = np.fft.rfft(values, axis=1)
    doubled = np.zeros((members, points + 1, states), dtype=np.complex128)
    doubled[:, : spectrum.shape[1]] = 2.0 * spectrum
    fine = np.fft.irfft(doubled, n=2 * points, axis=1)
    turn = 2.0j * np.pi / period * order[:, None]
    slope = np.fft.irfft(turn * doubled, n=2 * points, axis=1)
    x = np.concatenate([grid, grid + 0.5 * period / points], axis=2)
    x.sort(axis=2)
    f, _ = rhs(x, fine[:, None], None)
    defect = np.fft.rfft(f[:, 0] - slope, axis=1)
    high = np.abs(defect[:, spectrum.shape[1] :]) / np.abs(turn[spectrum.shape[1] :])
    tail = np.sum(high, axis=1) / points
    low = np.fft.irfft(0.5 * defect[:, : spectrum.shape[1]], n=points, axis=1)
    noise = UNIT_ROUNDOFF * (np.abs(values).max(axis=1, keepdims=True) * points / period * 6.0)
    right = np.stack([low, np.broadcast_to(noise, low.shape)], axis=-1)
    answer = solve_or_nan(_system(matrix, jacobian), right.reshape(members, -1, 2))
    through = np.abs(answer).reshape(members, points, states, 2).max(axis=1)
    return np.asarray(_SAFETY * (through[..., 0] + tail) + through[..., 1])
