"""Damped Newton iteration for the collocation equations of a periodic problem, panels fixed.

Every member of the batch has its own step length and its own end of iteration; members that have
ended stay as they are while the others go on.
"""

from typing import NamedTuple, Protocol

import numpy as np

from vibecalc.numerics.gauss import gauss_rule
from vibecalc.numerics.periodic_condense import Gaps, gaps, newton_step
from vibecalc.numerics.periodic_panels import (
    PeriodicProblem,
    PeriodicSolution,
    panel_nodes,
)
from vibecalc.numerics.typing import BoolArray, FloatArray, IntArray

MOST_ITERATIONS = 40
MOST_HALVINGS = 12
#: factor of quadratic convergence assumed before two corrections are known
_RATE = 100.0
#: a correction below this that no longer shrinks is round-off
_STALLED = 1e-7
#: relative residual that round-off alone may leave
_ROUND_OFF = 1e-14


class _State(NamedTuple):
    """Iterate with what the right-hand side says there; `size` (B,) of the relative residual."""

    left: FloatArray
    stages: FloatArray
    jacobian: FloatArray
    missed: Gaps
    size: FloatArray


class _Look(Protocol):
    """Evaluates an iterate."""

    def __call__(self, left: FloatArray, stages: FloatArray, scale: FloatArray, /) -> _State: ...


def newton(
    problem: PeriodicProblem,
    start: PeriodicSolution,
    *,
    tolerance: float = 1e-13,
    most: int = MOST_ITERATIONS,
) -> PeriodicSolution:
    """Solve on the edges and with the pieces of `start`, from its values.

    A member has converged when the correction that would follow is predicted, from the two before,
    to lie below `tolerance` times the scale, or when corrections are down to round-off. Members
    that fail keep their last acceptable iterate and are marked in `converged`; nothing is raised.
    """
    rule, piece = gauss_rule(start.points), start.piece
    widths, x = np.diff(start.edges), panel_nodes(start.edges, start.points)
    members = len(widths)

    def look(left: FloatArray, stages: FloatArray, scale: FloatArray) -> _State:
        f, jacobian = problem.rhs(x, stages, piece)
        missed = gaps(rule, widths, left, stages, f)
        return _State(left, stages, jacobian, missed, _size(missed, scale))

    with np.errstate(all="ignore"):
        scale = _scale(problem, start.stages)
        now = look(start.left, start.stages, scale)
        active = np.isfinite(now.size)
        converged = np.zeros(members, dtype=bool)
        correction = np.full(members, np.inf)
        rate = np.full(members, _RATE)
        transfer, count = start.transfer, 0
        while active.any() and count < most:
            count += 1
            step = newton_step(rule, widths, now.jacobian, now.missed)
            transfer = step.transfer if count == 1 else _pick(active, step.transfer, transfer)
            if problem.scale is None:
                scale = _scale(problem, now.stages, step.stages)
                now = now._replace(size=_size(now.missed, scale))
            last = _largest(step.stages, scale)
            active &= np.isfinite(last)
            known = correction < 1.0
            rate = np.where(known, np.maximum(last / correction**2, 1e-2), rate)
            ended = (last <= tolerance) | ((last < 1e-2) & (rate * last**2 <= tolerance))
            ended |= (last < _STALLED) & (last > 0.25 * correction)
            ended &= active
            correction = np.where(active, last, correction)
            if (ended | ~active).all():
                now = _moved(now, step.left, step.stages, ended.astype(np.float64))
                converged |= ended
                active = np.zeros(members, dtype=bool)
                break
            now, taken = _search(look, now, step.left, step.stages, active, ended, scale)
            converged |= ended
            active &= ~ended & (taken > 0.0)
            # a shortened step says nothing of the quadratic convergence
            correction = np.where(taken < 1.0, np.maximum(correction, 1.0), correction)
    return start._replace(
        left=now.left, stages=now.stages, transfer=transfer, correction=correction,
        residual=now.size, iterations=start.iterations + count, converged=converged,
    )  # fmt: skip


def _search(
    look: _Look, now: _State, left: FloatArray, stages: FloatArray,
    active: BoolArray, ended: BoolArray, scale: FloatArray,
) -> tuple[_State, FloatArray]:  # fmt: skip
    """Step along the correction, halved until the residual shrinks; lengths (B,), 0 if none does.

    Members that have ended take the whole step whatever their residual, which is round-off.
    """
    length = active.astype(np.float64)
    for _ in range(MOST_HALVINGS):
        trial = _moved(now, left, stages, length)
        seen = look(trial.left, trial.stages, scale)
        enough = np.maximum((1.0 - 0.1 * length) * now.size, _ROUND_OFF)
        good = (seen.size <= enough) | ended | ~active
        if good.all():
            return seen, length
        length = np.where(good, length, 0.5 * length)
    length = np.where(good, length, 0.0)
    trial = _moved(now, left, stages, length)
    return look(trial.left, trial.stages, scale), length


def _moved(now: _State, left: FloatArray, stages: FloatArray, length: FloatArray) -> _State:
    if (length == 1.0).all():
        return now._replace(left=now.left + left, stages=now.stages + stages)
    moves = length > 0.0
    shown = length[:, None, None]
    return now._replace(
        left=np.where(moves[:, None, None], now.left + shown * left, now.left),
        stages=np.where(
            moves[:, None, None, None], now.stages + shown[..., None] * stages, now.stages
        ),
    )


def _pick(active: BoolArray, new: FloatArray, old: FloatArray) -> FloatArray:
    return new if active.all() else np.where(active[:, None, None, None], new, old)


def _size(missed: Gaps, scale: FloatArray) -> FloatArray:
    """Residual (B,) relative to the scale, infinite where it is not a number."""
    size = np.maximum(_largest(missed.stages, scale), _largest(missed.ends, scale))
    return np.where(size < np.inf, size, np.inf)


def _largest(values: FloatArray, scale: FloatArray) -> FloatArray:
    """Largest magnitude of every member (B,) of values (B, ..., n) over scale (B, n)."""
    if scale.shape[1] == 1:
        flat = np.abs(values.reshape(len(scale), -1))
        return np.asarray(np.maximum.reduce(flat, axis=1) / scale[:, 0])
    flat = np.abs(values.reshape(len(scale), -1, scale.shape[1]))
    found = np.maximum.reduce(flat, axis=1, initial=0.0)
    return np.asarray(np.maximum.reduce(found / scale, axis=1))


def _scale(
    problem: PeriodicProblem, stages: FloatArray, step: FloatArray | None = None
) -> FloatArray:
    """Sizes of the states (B, n): as given, or the largest value, or else of the correction."""
    members, states = len(stages), stages.shape[-1]
    if problem.scale is not None:
        return np.broadcast_to(np.asarray(problem.scale, dtype=np.float64), (members, states))
    size = np.abs(stages.reshape(members, -1, states)).max(axis=1)
    if size.all():
        return np.asarray(size)
    if step is not None:
        size = np.maximum(size, np.abs(step.reshape(members, -1, states)).max(axis=1))
    return np.where(size > 0.0, size, 1.0)


def pieces_at(problem: PeriodicProblem, y: FloatArray) -> IntArray:
    """Piece of every point: how many thresholds lie at or below the switch; y (B, P, s, n)."""
    if problem.switch is None or problem.thresholds is None:
        return np.zeros(y.shape[:-1], dtype=np.int64)
    return levels(problem.switch(y), problem.thresholds)


def levels(values: FloatArray, thresholds: FloatArray) -> IntArray:
    """Number of thresholds (T,) or (B, T) at or below each value (B, P, s)."""
    bounds = np.asarray(thresholds, dtype=np.float64)
    if bounds.ndim == 1:
        return np.searchsorted(bounds, values, side="right").astype(np.int64)
    count = np.zeros(values.shape, dtype=np.int64)
    for bound in bounds.T:
        count += values >= bound[:, None, None]
    return count
