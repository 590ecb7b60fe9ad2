"""Periodic solutions by other methods than collocation: harmonic balance, marching in time."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.gauss import gauss_rule
from vibecalc.numerics.periodic.panels import Rhs, solve_or_nan
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, BoolArray, ComplexArray, FloatArray, IntArray

# ----------------------------------------------------------------------------
# Periodic solutions by Fourier collocation: equispaced points and trigonometric interpolation.
#
# Exponentially accurate for right-hand sides that are smooth all around; kinks leave an algebraic
# error, which the estimate shows.
# ----------------------------------------------------------------------------

MOST_ITERATIONS = 40
_MOST_HALVINGS = 12
_SAFETY = 2.0


class FourierSolution(NamedTuple):
    """Values (B, N, n) at x (N,), harmonics (B, N // 2 + 1, n), 0-to-peak (mean for order 0).

    y(x) = Re sum_k Y_k exp(i k (x - x_0) 2 pi / period). `error` (B, n) is absolute, for y at any
    x; infinite where `converged` (B,) is false.
    """

    x: FloatArray
    values: FloatArray
    harmonics: ComplexArray
    error: FloatArray
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
        As for panels, called with one panel of `points` points and interval None.
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

    def state_at(at: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        f, jacobian = rhs(grid, at[:, None], None)
        missed = matrix @ at - f[:, 0]
        size = np.abs(missed).max(axis=(1, 2))
        return missed, jacobian[:, 0], np.where(np.isnan(size), np.inf, size)

    with np.errstate(all="ignore"):
        missed, jacobian, size = state_at(values)
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
                tried = state_at(trial)
                good = (tried[2] <= (1.0 - 0.1 * length) * size) | ended | ~active
                if good.all():
                    break
                length = np.where(good, length, 0.5 * length)
            taken = good & active
            values = np.where(taken[:, None, None], trial, values)
            missed, jacobian, size = tried if taken.all() else state_at(values)
            before = np.where(length == 1.0, last, np.inf)
            converged |= ended & taken
            active &= taken & ~ended
        harmonics = _harmonics(values)
        error = _error(rhs, grid, period, values, jacobian, matrix)
    error = np.where(converged[:, None] & np.isfinite(error), error, np.inf)
    return FourierSolution(x, values, harmonics, error, converged)


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


# ----------------------------------------------------------------------------
# Periodic solutions of one scalar equation by marching turn after turn, or the proof of none.
#
# Two solutions of a scalar equation never cross. Marching from above every periodic solution
# therefore comes down to the largest of them, and a march that falls to the floor shows that none
# stays above it, within the error of the integration.
# ----------------------------------------------------------------------------

_MOST_NEWTON = 12
_MOST_DIVISIONS = 6
_NEWTON_TOLERANCE = 1e-12
#: or where the next step would be below this
_AHEAD = 1e-13
#: part of the size by which a turn ends next to its start through rounding alone
_ROUNDING = 4e-15
#: part of the size within which the slopes along a turn are those along its limit
_NEAR = 1e-2


class March(NamedTuple):
    """Outcome of every member; all (B,), `path` (B, P + 1) the values of the last turn at edges.

    `converged`: the value at the first edge repeats; `change` is how far the end of `path` still is
    from the limit, by the rate at which neighbours of the last turn fall upon it and by its
    rounding; its start is off by what the turn moved. `stalled`: the floor was met, in turn `turns`
    in the panel that begins at `stalled_at` (NaN otherwise). Neither: the turns were spent.
    """

    path: FloatArray
    change: FloatArray
    turns: IntArray
    converged: BoolArray
    stalled: BoolArray
    stalled_at: FloatArray


def march_turns(
    rhs: Rhs,
    edges: FloatArray,
    start: ArrayLike,
    *,
    floor: float = -np.inf,
    points: int = 3,
    tolerance: float = 1e-6,
    most_turns: int = 200,
) -> March:
    """March y' = f(x, y), n = 1, from `start` (B,) along edges (P + 1,) or (B, P + 1).

    `floor` is the value at which a member counts as stalled; `tolerance` is relative to the largest
    value of a turn. Each panel is one implicit Gauss step; where Newton's method fails in it, it is
    divided, and a member whose value cannot be carried through a 64th of a panel, or meets the
    floor, has stalled. The right-hand side gets interval None.
    """
    value = np.atleast_1d(np.asarray(start, dtype=np.float64)).copy()
    rows = np.atleast_2d(np.asarray(edges, dtype=np.float64))
    members = max(len(value), len(rows))
    rows = np.broadcast_to(rows, (members, rows.shape[1]))
    value = np.broadcast_to(value, (members,)).copy()
    path = np.repeat(value[:, None], rows.shape[1], axis=1)
    turns = np.zeros(members, dtype=np.int64)
    converged, stalled = np.zeros(members, dtype=bool), np.zeros(members, dtype=bool)
    stalled_at, change = np.full(members, np.nan), np.full(members, np.inf)
    older, growth = np.full(members, np.inf), np.zeros(members)
    with np.errstate(all="ignore"):
        for _ in range(most_turns):
            active = ~converged & ~stalled
            if not active.any():
                break
            turns += active
            growth = np.zeros(members)
            for panel in range(rows.shape[1] - 1):
                low, high = rows[:, panel], rows[:, panel + 1]
                value, lost, grown = _panel(rhs, low, high, value, active, floor, points)
                growth += grown
                stalled |= lost
                stalled_at[lost] = low[lost]
                active = active & ~lost
                path[active, panel + 1] = value[active]
                if not active.any():
                    break
            moved = np.abs(path[:, -1] - path[:, 0])
            # the first turns from far away may fall faster than all later ones: the slope along
            # the last one knows better what a neighbour does
            rate = np.clip(np.maximum(moved / older, np.exp(growth)), 0.0, 1.0 - 1e-12)
            size = np.abs(path).max(axis=1)
            noise = _ROUNDING * size
            left = np.where(np.isfinite(older), (moved * rate + noise) / (1.0 - rate), np.inf)
            change[active] = left[active]
            near = (left <= tolerance * size) & (moved <= np.minimum(older, _NEAR * size))
            converged |= active & (near | (moved <= noise))
            older = np.where(active, moved, older)
            going = active & ~converged
            path[going, 0] = value[going]
    return March(path, change, turns, converged, stalled, stalled_at)


def _panel(
    rhs: Rhs, low: FloatArray, high: FloatArray, value: FloatArray,
    active: BoolArray, floor: float, points: int,
) -> tuple[FloatArray, BoolArray, FloatArray]:  # fmt: skip
    """Values at `high`, which members have stalled on the way, and the slope summed along it."""
    stepped, good, grown = _step(rhs, low, high, value, points)
    good &= stepped > floor
    if (good | ~active).all():
        return np.where(active, stepped, value), np.zeros(len(value), dtype=bool), grown
    # those that fail try ever smaller parts, each from where it stands
    done = good | ~active
    now, at = np.where(good & active, stepped, value), np.where(done, high, low)
    width = (high - low) * 0.5
    smallest = (high - low) * 0.5**_MOST_DIVISIONS
    lost, growth = np.zeros(len(value), dtype=bool), np.where(good, grown, 0.0)
    while not (done | lost).all():
        target = np.where(done | lost, at, np.minimum(at + width, high))
        stepped, good, grown = _step(rhs, at, target, now, points)
        good &= (stepped > floor) & ~done & ~lost
        growth += np.where(good, grown, 0.0)
        now, at = np.where(good, stepped, now), np.where(good, target, at)
        lost |= ~good & ~done & (width <= smallest)
        width = np.where(good | done, width, 0.5 * width)
        done |= at >= high
    return np.where(active & ~lost, now, value), lost & active, growth


def _step(
    rhs: Rhs, low: FloatArray, high: FloatArray, value: FloatArray, points: int
) -> tuple[FloatArray, BoolArray, FloatArray]:
    """One implicit Gauss step of every member, where Newton's method found it, summed slope."""
    rule = gauss_rule(points)
    width = (high - low)[:, None]
    x = (low[:, None] + width * rule.nodes)[:, None]
    stages = np.repeat(value[:, None], points, axis=1)
    good, before = np.zeros(len(value), dtype=bool), np.full(len(value), np.inf)
    f = stages
    for _ in range(_MOST_NEWTON):
        f, jacobian = rhs(x, stages[:, None, :, None], None)
        f, slope = f[:, 0, :, 0], jacobian[:, 0, :, 0, 0]
        gap = stages - value[:, None] - (width * f) @ rule.integration.T
        matrix = np.eye(points) - (width * slope)[:, None, :] * rule.integration
        step = solve_or_nan(matrix, -gap[..., None])[..., 0]
        stages = stages + step
        size = np.abs(step).max(axis=1) / np.abs(stages).max(axis=1)
        # the next step, if steps square as the last two did, and no better than plainly squared:
        # the first from a constant may be small by accident
        ahead = size * size * np.maximum(size / (before * before), 1.0)
        good = (size <= _NEWTON_TOLERANCE) | (ahead <= _AHEAD)
        good |= np.abs(step).max(axis=1) == 0.0
        if (good | ~np.isfinite(size)).all():
            break
        before = size
    f, jacobian = rhs(x, stages[:, None, :, None], None)
    stepped = value + (width * f[:, 0, :, 0]) @ rule.weights
    grown = (width * jacobian[:, 0, :, 0, 0]) @ rule.weights
    return stepped, good & np.isfinite(stepped), grown
