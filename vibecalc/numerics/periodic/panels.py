"""Periodic problems y' = f(x, y) on panels, and one Newton step of Gauss collocation on them."""

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.gauss import GaussRule, gauss_rule, interpolation_rows
from vibecalc.numerics.rounding import BoolArray, FloatArray, IntArray

# ----------------------------------------------------------------------------
# Periodic problems y' = f(x, y) on panels: what is given, what is found, values in between.
#
# Shapes: B members of a batch, P panels of a turn, s Gauss points in a panel, n states. Panels may
# have any width, also none, and may differ between members; the last edge is one period after the
# first.
# ----------------------------------------------------------------------------


class Rhs(Protocol):
    """Right-hand side: x (B, P, s), y (B, P, s, n) to f (B, P, s, n) and df/dy (B, P, s, n, n).

    With `interval` (B, P) all points of a panel use that interval of the state-dependent curve,
    smoothly continued beyond its ends; with None every point uses the interval it lies on. P and s
    may be any (the same points may come as P s panels of one point). The same x object comes again
    as long as the panels stay, so that what depends on x alone can be kept. Values outside the
    domain may be returned as NaN: the step is then shortened.
    """

    def __call__(
        self, x: FloatArray, y: FloatArray, interval: IntArray | None, /
    ) -> tuple[FloatArray, FloatArray]: ...


class Switch(Protocol):
    """Scalar function of the state that chooses the interval: y (B, P, s, n) to (B, P, s)."""

    def __call__(self, y: FloatArray, /) -> FloatArray: ...


class PeriodicProblem(NamedTuple):
    """`edges` (B, P + 1) or (P + 1,) ascending, every x at which the right-hand side has a kink.

    `switch` and `thresholds` (T,) or (B, T), ascending: interval k holds where k thresholds lie at
    or below the switch. Without a switch `interval` is always None. `scale` (n,): sizes of the
    states to which corrections are compared; by default each state's largest value, which will not
    do for a state that is zero all along.
    """

    rhs: Rhs
    edges: FloatArray
    switch: Switch | None = None
    thresholds: FloatArray | None = None
    scale: FloatArray | None = None

    def batch_edges(self, members: int) -> FloatArray:
        """Edges (B, P + 1), one row for each member."""
        edges = np.atleast_2d(np.asarray(self.edges, dtype=np.float64))
        if len(edges) == members:
            return edges
        return np.ascontiguousarray(np.broadcast_to(edges, (members, edges.shape[1])))


class PeriodicSolution(NamedTuple):
    """Collocation polynomials of degree s on each panel.

    edges (B, P + 1); left (B, P, n) values at the panels' left ends; stages (B, P, s, n) at the
    Gauss points; interval (B, P) or None; transfer (B, P, n, n) derivatives of a panel's right
    value by its left one, at the last iterate but one; edge_error (B,) how far, over the period,
    edges at kinks are from where they belong; converged (B,).
    """

    edges: FloatArray
    left: FloatArray
    stages: FloatArray
    interval: IntArray | None
    transfer: FloatArray
    edge_error: FloatArray
    converged: BoolArray

    @property
    def points(self) -> int:
        """Gauss points in each panel."""
        return int(self.stages.shape[2])

    @property
    def nodes(self) -> FloatArray:
        """x of the Gauss points (B, P, s)."""
        return panel_nodes(self.edges, self.points)

    @property
    def weights(self) -> FloatArray:
        """Weights (B, P, s) of the integral over a period from values at the Gauss points."""
        widths = self.edges[:, 1:] - self.edges[:, :-1]
        return np.asarray(widths[..., None] * gauss_rule(self.points).weights)

    @property
    def ends(self) -> FloatArray:
        """Values (B, P + 1, n) at the edges; the last are the first."""
        return np.concatenate([self.left, self.left[:, :1]], axis=1)


def panel_nodes(edges: FloatArray, points: int) -> FloatArray:
    """Gauss points of every panel, (B, P, s)."""
    left = edges[:, :-1, None]
    return np.asarray(left + (edges[:, 1:, None] - left) * gauss_rule(points).nodes)


def constant_start(problem: PeriodicProblem, points: int, guess: ArrayLike) -> PeriodicSolution:
    """A state (n,) or (B, n) that does not vary, as a solution to start from."""
    values = np.atleast_2d(np.asarray(guess, dtype=np.float64))
    members = max(len(values), len(np.atleast_2d(problem.edges)))
    edges = problem.batch_edges(members)
    panels, states = edges.shape[1] - 1, values.shape[1]
    left = np.broadcast_to(values[:, None], (members, panels, states)).copy()
    stages = np.broadcast_to(values[:, None, None], (members, panels, points, states)).copy()
    none = np.full(members, np.inf)
    transfer = np.broadcast_to(np.eye(states), (members, panels, states, states))
    yes = np.ones(members, dtype=bool)
    return PeriodicSolution(edges, left, stages, None, transfer, none, yes)


def evaluate(solution: PeriodicSolution, x: ArrayLike) -> FloatArray:
    """Values (B, k, n) at any x (k,) or (B, k), periodically continued.

    Between the edges the error is that of a polynomial of degree s (order s + 1), at the edges it
    is smaller (order 2 s).
    """
    edges = solution.edges
    members, panels = edges.shape[0], edges.shape[1] - 1
    at = np.broadcast_to(np.asarray(x, dtype=np.float64), (members, np.shape(x)[-1]))
    first, period = edges[:, :1], edges[:, -1:] - edges[:, :1]
    outside = (at < first) | (at > edges[:, -1:])
    if outside.any():
        at = np.where(outside, first + np.mod(at - first, period), at)
    # one search for all members: each is shifted by two of the longest periods
    shift = (2.0 * period.max()) * np.arange(members)[:, None] - first
    index = np.searchsorted((edges + shift).ravel(), (at + shift).ravel(), side="right")
    panel = index.reshape(at.shape) - np.arange(members)[:, None] * (panels + 1) - 1
    panel = np.minimum(np.maximum(panel, 0), panels - 1)
    row = np.arange(members)[:, None]
    width = edges[row, panel + 1] - edges[row, panel]
    position = (at - edges[row, panel]) / np.where(width > 0.0, width, 1.0)
    rule = gauss_rule(solution.points)
    basis = interpolation_rows(rule.dense_nodes, rule.dense_weights, position)
    values = np.concatenate([solution.left[:, :, None], solution.stages], axis=2)
    if values.shape[-1] == 1:
        return np.asarray(np.vecdot(basis, values[..., 0][row, panel])[..., None])
    return np.asarray((basis[..., None, :] @ values[row, panel])[..., 0, :])


def running_integral(edges: FloatArray, integrand: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Integral of values at the Gauss points (B, P, s) from the first edge.

    Returns it at the Gauss points (B, P, s) and at the edges (B, P + 1); the last of these is the
    integral over the period. Exact for polynomials of degree s - 1 at the points, 2 s - 1 at the
    edges.
    """
    rule = gauss_rule(integrand.shape[2])
    scaled = (edges[:, 1:] - edges[:, :-1])[..., None] * integrand
    ends = np.zeros(edges.shape)
    np.cumsum(scaled @ rule.weights, axis=1, out=ends[:, 1:])
    return ends[:, :-1, None] + scaled @ rule.integration.T, ends


# ----------------------------------------------------------------------------
# Cyclic recursions d[p + 1] = transfer[p] d[p] + offset[p], d[P] = d[0], solved stably.
#
# A scalar recursion is run in the direction in which it does not grow over the whole turn. Blocks
# with growing and decaying directions mixed are eliminated in pairs by orthogonal matrices.
# ----------------------------------------------------------------------------


def solve_scalar(transfer: FloatArray, offset: FloatArray) -> FloatArray:
    """d (B, P) from transfer and offset (B, P); not finite where the product of transfers is 1."""
    members, panels = transfer.shape
    product = np.multiply.reduce(transfer, axis=1)
    back = np.abs(product) > 1.0
    turned = bool(back.any())
    if turned:
        flipped = transfer[:, ::-1]
        safe = np.where(back[:, None], flipped, 1.0)
        offset = np.where(back[:, None], -offset[:, ::-1] / safe, offset)
        transfer = np.where(back[:, None], 1.0 / safe, transfer)
    if members == 1:
        solution = _one_member(transfer[0].tolist(), offset[0].tolist())
    else:
        solution = _many_members(transfer, offset)
    if turned:
        # from the last edge backwards: 0, P - 1, ..., 1
        order = np.concatenate([[0], np.arange(panels - 1, 0, -1)])
        solution = np.where(back[:, None], solution[:, order], solution)
    return solution


def _one_member(transfer: list[float], offset: list[float]) -> FloatArray:
    product, total = 1.0, 0.0
    for factor, shift in zip(transfer, offset, strict=True):
        product *= factor
        total = factor * total + shift
    if product == 1.0:
        return np.full((1, len(transfer)), np.nan)
    value = total / (1.0 - product)
    found = []
    for factor, shift in zip(transfer, offset, strict=True):
        found.append(value)
        value = factor * value + shift
    return np.array([found])


def _many_members(transfer: FloatArray, offset: FloatArray) -> FloatArray:
    factors, shifts = np.ascontiguousarray(transfer.T), np.ascontiguousarray(offset.T)
    total = np.zeros(factors.shape[1])
    for factor, shift in zip(factors, shifts, strict=True):
        total = factor * total + shift
    value = total / (1.0 - np.multiply.reduce(factors, axis=0))
    found = np.empty_like(factors)
    for place, (factor, shift) in enumerate(zip(factors, shifts, strict=True)):
        found[place] = value
        value = factor * value + shift
    return found.T


def solve_blocks(transfer: FloatArray, offset: FloatArray) -> FloatArray:
    """d (B, P, n) from transfer (B, P, n, n) and offset (B, P, n).

    Equations of neighbouring panels are combined by a QR factorisation of the block column of the
    value between them, level by level, until one remains for d[0]; d is not finite where that one
    is singular (a multiplier 1).

    Source: Wright (1992), Stable parallel algorithms for two-point boundary value problems.
    """
    panels, states = offset.shape[1:]
    before = -transfer
    after = np.broadcast_to(np.eye(states), transfer.shape)
    right = offset[..., None]
    levels: list[tuple[FloatArray, ...]] = []
    while panels > 1:
        pairs = panels // 2
        first, second = slice(0, 2 * pairs, 2), slice(1, 2 * pairs, 2)
        column = np.concatenate([after[:, first], before[:, second]], axis=2)
        turn, triangle = np.linalg.qr(column, mode="complete")
        share = np.concatenate([before[:, first], right[:, first]], axis=3)
        other = np.concatenate([after[:, second], right[:, second]], axis=3)
        both = turn.swapaxes(2, 3)
        from_first = both @ np.concatenate([share, np.zeros_like(share)], axis=2)
        from_second = both @ np.concatenate([np.zeros_like(other), other], axis=2)
        top, low = slice(0, states), slice(states, 2 * states)
        levels.append((
            triangle[:, :, top],
            from_first[:, :, top, :states],
            from_second[:, :, top, :states],
            from_first[:, :, top, states:] + from_second[:, :, top, states:],
        ))  # fmt: skip
        unpaired = slice(2 * pairs, panels)
        before = np.concatenate([from_first[:, :, low, :states], before[:, unpaired]], axis=1)
        after = np.concatenate([from_second[:, :, low, :states], after[:, unpaired]], axis=1)
        joined = from_first[:, :, low, states:] + from_second[:, :, low, states:]
        right = np.concatenate([joined, right[:, unpaired]], axis=1)
        panels = pairs + panels % 2
    return _unfold(before[:, 0], after[:, 0], right[:, 0], levels)


def _unfold(
    before: FloatArray, after: FloatArray, right: FloatArray, levels: list[tuple[FloatArray, ...]]
) -> FloatArray:
    """The last equation solved, then the values between, level by level."""
    closing = before + after
    try:
        inverse = np.linalg.inv(closing)
    except np.linalg.LinAlgError:
        inverse = np.stack([_inverse_or_nan(one) for one in closing])
    solution = (inverse @ right)[:, None, :, :]
    for triangle, first, second, value in reversed(levels):
        pairs = triangle.shape[1]
        following = np.concatenate([solution[:, 1:], solution[:, :1]], axis=1)[:, :pairs]
        known = value - first @ solution[:, :pairs] - second @ following
        between = np.linalg.solve(triangle, known)
        whole = np.empty((len(solution), pairs + solution.shape[1], *solution.shape[2:]))
        whole[:, 0 : 2 * pairs : 2] = solution[:, :pairs]
        whole[:, 1 : 2 * pairs : 2] = between
        whole[:, 2 * pairs :] = solution[:, pairs:]
        solution = whole
    return np.asarray(solution[..., 0])


def _inverse_or_nan(matrix: FloatArray) -> FloatArray:
    try:
        return np.asarray(np.linalg.inv(matrix))
    except np.linalg.LinAlgError:
        return np.full(matrix.shape, np.nan)


# ----------------------------------------------------------------------------
# One Newton step of Gauss collocation on all panels: stages condensed, then the cyclic recursion.
#
# The equations of a panel of width h are Y = y_left + h A F and y_left + h b F = next y_left, with
# F = f(x, Y). The step solves them linearised about given values.
#
# Source: Ascher, Mattheij and Russell (1995), Numerical solution of boundary value problems for
# ordinary differential equations, chapter 5 (collocation, condensation).
# ----------------------------------------------------------------------------

#: from so many panels on, elimination over all panels at once is faster than one after the other
MANY_PANELS = 150
_CHUNK = 512
#: below this |h df/dy| the panel matrices are diagonally dominant, so that no pivoting is needed
_DOMINANT = 0.9


class Gaps(NamedTuple):
    """By how much the equations are missed: stages (B, P, s, n), ends (B, P, n)."""

    stages: FloatArray
    ends: FloatArray


class PanelStep(NamedTuple):
    """Corrections left (B, P, n) and stages (B, P, s, n); transfer (B, P, n, n)."""

    left: FloatArray
    stages: FloatArray
    transfer: FloatArray


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


def newton_step(
    rule: GaussRule, widths: FloatArray, jacobian: FloatArray, missed: Gaps
) -> PanelStep:
    """Step that makes the linearised equations hold; jacobian (B, P, s, n, n).

    Not finite for a member whose linearised problem has no single solution.
    """
    if jacobian.shape[-1] == 1:
        return _scalar_step(rule, widths, jacobian[..., 0, 0], missed)
    return _system_step(rule, widths, jacobian, missed)


def _scalar_step(
    rule: GaussRule, widths: FloatArray, jacobian: FloatArray, missed: Gaps
) -> PanelStep:
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
    return PanelStep(left[..., None], stages[..., None], transfer[..., None, None])


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


def _system_step(
    rule: GaussRule, widths: FloatArray, jacobian: FloatArray, missed: Gaps
) -> PanelStep:
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
    left = solve_blocks(transfer, missed.ends + ahead[..., states])
    stages = (solved[..., :states] @ left[..., None])[..., 0] + solved[..., states]
    return PanelStep(left, stages.reshape(missed.stages.shape), transfer)


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
