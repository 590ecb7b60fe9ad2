"""One Newton step of Gauss collocation on all panels: stages condensed, then the cyclic recursion.

The equations of a panel of width h are Y = y_left + h A F and y_left + h b F = next y_left, with
F = f(x, Y). The step solves them linearised about given values.

Source: Ascher, Mattheij and Russell (1995), Numerical solution of boundary value problems for
ordinary differential equations, chapter 5 (collocation, condensation).
"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.gauss import GaussRule
from vibecalc.numerics.periodic_cyclic import solve_blocks, solve_scalar
from vibecalc.numerics.typing import FloatArray

#: from so many panels on, elimination over all panels at once is faster than one after the other
MANY_PANELS = 150
_CHUNK = 512
#: below this |h df/dy| the panel matrices are diagonally dominant, so that no pivoting is needed
_DOMINANT = 0.9


class Gaps(NamedTuple):
    """By how much the equations are missed: stages (B, P, s, n), ends (B, P, n)."""

    stages: FloatArray
    ends: FloatArray


class Step(NamedTuple):
    """Corrections left (B, P, n) and stages (B, P, s, n); transfer (B, P, n, n).

    `condition` (B,): how much an error of one panel can grow around the turn; None for one state,
    where `scalar_condition` says it.
    """

    left: FloatArray
    stages: FloatArray
    transfer: FloatArray
    condition: FloatArray | None


def gaps(
    rule: GaussRule, widths: FloatArray, left: FloatArray, stages: FloatArray, f: FloatArray
) -> Gaps:
    """Residuals of the collocation equations for widths (B, P) and f at the stages."""
    following = np.concatenate([left[:, 1:], left[:, :1]], axis=1)
    if left.shape[2] == 1:
        scaled = widths[..., None] * f[..., 0]
        stage = stages[..., 0] - left - scaled @ rule.integration.T
        return Gaps(stage[..., None], left + (scaled @ rule.weights)[..., None] - following)
    scaled = widths[..., None, None] * f
    stage = stages - left[:, :, None] - rule.integration @ scaled
    return Gaps(stage, left + rule.weights @ scaled - following)


def newton_step(rule: GaussRule, widths: FloatArray, jacobian: FloatArray, missed: Gaps) -> Step:
    """Step that makes the linearised equations hold; jacobian (B, P, s, n, n).

    Not finite for a member whose linearised problem has no single solution.
    """
    if jacobian.shape[-1] == 1:
        return _scalar_step(rule, widths, jacobian[..., 0, 0], missed)
    return _system_step(rule, widths, jacobian, missed)


def _scalar_step(rule: GaussRule, widths: FloatArray, jacobian: FloatArray, missed: Gaps) -> Step:
    scaled = widths[..., None] * jacobian
    gap = missed.stages[..., 0]
    if len(rule.nodes) == 1:
        response = 1.0 / (1.0 - rule.integration[0, 0] * scaled)
        offset = -gap * response
    elif scaled[..., 0].size >= MANY_PANELS and np.abs(scaled).max() < _DOMINANT:
        response, offset = _eliminate(rule.integration, scaled, gap)
    else:
        matrix = scaled[..., None, :] * -rule.integration
        count = len(rule.nodes)
        matrix.reshape(*scaled.shape[:2], -1)[..., :: count + 1] += 1.0
        right = np.ones((*scaled.shape, 2))
        right[..., 1] = -gap
        solved = solve_or_nan(matrix, right)
        response, offset = solved[..., 0], solved[..., 1]
    weighted = scaled * rule.weights
    transfer = 1.0 + np.add.reduce(weighted * response, axis=-1)
    shift = missed.ends[..., 0] + np.add.reduce(weighted * offset, axis=-1)
    left = solve_scalar(transfer, shift)
    stages = response * left[..., None] + offset
    return Step(left[..., None], stages[..., None], transfer[..., None, None], None)


def scalar_condition(transfer: FloatArray) -> FloatArray:
    """Growth (B,) of an error around the turn for one state, from transfer (B, P, 1, 1)."""
    product = np.clip(np.prod(transfer[..., 0, 0], axis=1), -1e300, 1e300)
    return np.asarray((1.0 + np.abs(product)) / np.abs(1.0 - product))


def _eliminate(
    integration: FloatArray, scaled: FloatArray, gap: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Answer of the stages to 1 and to -gap, by elimination with panels along the last axis."""
    shape, count = scaled.shape, scaled.shape[-1]
    rows, gaps_ = scaled.reshape(-1, count), gap.reshape(-1, count)
    answers = np.empty((2, len(rows), count))
    for start in range(0, len(rows), _CHUNK):
        part = slice(start, start + _CHUNK)
        matrix = integration[..., None] * -np.ascontiguousarray(rows[part].T)
        matrix.reshape(count * count, -1)[:: count + 1] += 1.0
        right = np.ones((count, 2, matrix.shape[-1]))
        right[:, 1] = -gaps_[part].T
        for k in range(count - 1):
            factor = (matrix[k + 1 :, k] / matrix[k, k])[:, None]
            matrix[k + 1 :, k + 1 :] -= factor * matrix[k, k + 1 :]
            right[k + 1 :] -= factor * right[k]
        for k in range(count - 1, -1, -1):
            right[k] /= matrix[k, k]
            right[:k] -= matrix[:k, k, None] * right[k]
        answers[:, part] = right.transpose(1, 2, 0)
    return answers[0].reshape(shape), answers[1].reshape(shape)


def _system_step(rule: GaussRule, widths: FloatArray, jacobian: FloatArray, missed: Gaps) -> Step:
    members, panels, count, states = missed.stages.shape
    size = count * states
    scaled = widths[..., None, None, None] * jacobian
    matrix = np.empty((members, panels, count, states, count, states))
    turned = scaled.transpose(0, 1, 3, 2, 4)[:, :, None]
    np.multiply(turned, -rule.integration[:, None, :, None], out=matrix)
    flat = matrix.reshape(members, panels, size, size)
    flat.reshape(members, panels, -1)[..., :: size + 1] += 1.0
    right = np.empty((members, panels, count, states, states + 1))
    right[..., :states] = np.eye(states)
    right[..., states] = -missed.stages
    solved = solve_or_nan(flat, right.reshape(members, panels, size, states + 1))
    weighted = rule.weights[:, None, None] * scaled
    row = weighted.transpose(0, 1, 3, 2, 4).reshape(members, panels, states, size)
    ahead = row @ solved
    transfer = ahead[..., :states] + np.eye(states)
    left, condition = solve_blocks(transfer, missed.ends + ahead[..., states])
    stages = (solved[..., :states] @ left[..., None])[..., 0] + solved[..., states]
    return Step(left, stages.reshape(missed.stages.shape), transfer, condition)


def solve_or_nan(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Linear systems, stacked; NaN for the singular ones and those that are not finite."""
    try:
        return np.asarray(np.linalg.solve(matrix, right))
    except np.linalg.LinAlgError:
        found = np.full(right.shape, np.nan)
        for place in np.ndindex(matrix.shape[:-2]):
            try:
                found[place] = np.linalg.solve(matrix[place], right[place])
            except np.linalg.LinAlgError:
                continue
        return found
