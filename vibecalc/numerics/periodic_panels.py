"""Periodic problems y' = f(x, y) on panels: what is given, what is found, values in between.

Shapes: B members of a batch, P panels of a turn, s Gauss points in a panel, n states. Panels may
have any width, also none, and may differ between members; the last edge is one period after the
first.
"""

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.gauss import gauss_rule, interpolation_rows
from vibecalc.numerics.typing import BoolArray, FloatArray, IntArray


class Rhs(Protocol):
    """Right-hand side: x (B, P, s), y (B, P, s, n) to f (B, P, s, n) and df/dy (B, P, s, n, n).

    With `piece` (B, P) all points of a panel use that piece of the state-dependent curve, smoothly
    continued beyond its ends; with None every point uses the piece it lies on. P and s may be any
    (the same points may come as P s panels of one point). The same x object comes again as long as
    the panels stay, so that what depends on x alone can be kept. Values outside the domain may be
    returned as NaN: the step is then shortened.
    """

    def __call__(
        self, x: FloatArray, y: FloatArray, piece: IntArray | None, /
    ) -> tuple[FloatArray, FloatArray]: ...


class Switch(Protocol):
    """Scalar function of the state that chooses the piece: y (B, P, s, n) to (B, P, s)."""

    def __call__(self, y: FloatArray, /) -> FloatArray: ...


class PeriodicProblem(NamedTuple):
    """`edges` (B, P + 1) or (P + 1,) ascending, every x at which the right-hand side has a kink.

    `switch` and `thresholds` (T,) or (B, T), ascending: piece k holds where k thresholds lie at or
    below the switch. Without a switch `piece` is always None. `scale` (n,): sizes of the states to
    which corrections are compared; by default each state's largest value, which will not do for a
    state that is zero all along.
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
    Gauss points; piece (B, P) or None; transfer (B, P, n, n) derivatives of a panel's right value
    by its left one, at the last iterate but one; correction (B,) the last Newton correction
    relative to the scale; residual (B,) of the last equations evaluated, likewise; edge_error (B,)
    how far, over the period, edges at kinks are from where they belong; iterations of Newton in
    total; converged (B,).
    """

    edges: FloatArray
    left: FloatArray
    stages: FloatArray
    piece: IntArray | None
    transfer: FloatArray
    correction: FloatArray
    residual: FloatArray
    edge_error: FloatArray
    iterations: int
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
        return np.asarray(np.diff(self.edges)[..., None] * gauss_rule(self.points).weights)

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
    return PeriodicSolution(edges, left, stages, None, transfer, none, none, none, 0, yes)


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
    own = index.reshape(at.shape) - np.arange(members)[:, None] * (panels + 1) - 1
    own = np.clip(own, 0, panels - 1)
    row = np.arange(members)[:, None]
    width = edges[row, own + 1] - edges[row, own]
    position = (at - edges[row, own]) / np.where(width > 0.0, width, 1.0)
    rule = gauss_rule(solution.points)
    basis = interpolation_rows(rule.dense_nodes, rule.dense_weights, position)
    values = np.concatenate([solution.left[:, :, None], solution.stages], axis=2)
    return np.asarray((basis[..., None, :] @ values[row, own])[..., 0, :])


def running_integral(edges: FloatArray, integrand: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Integral of values at the Gauss points (B, P, s) from the first edge.

    Returns it at the Gauss points (B, P, s) and at the edges (B, P + 1); the last of these is the
    integral over the period. Exact for polynomials of degree s - 1 at the points, 2 s - 1 at the
    edges.
    """
    rule = gauss_rule(integrand.shape[2])
    scaled = np.diff(edges)[..., None] * integrand
    ends = np.zeros(edges.shape)
    np.cumsum(scaled @ rule.weights, axis=1, out=ends[:, 1:])
    return ends[:, :-1, None] + scaled @ rule.integration.T, ends


def require_converged(solution: PeriodicSolution, what: str = "periodic solution") -> None:
    """Raise NumericalFailure naming the members without a solution, if there are any."""
    lost = np.flatnonzero(~solution.converged)
    if len(lost):
        worst = float(np.max(solution.residual[lost]))
        some = ", ".join(str(one) for one in lost[:8].tolist())
        raise NumericalFailure(
            f"{what}: Newton's method found none for {len(lost)} of {len(solution.converged)} "
            f"members ({some}); relative residual {worst:.1e} after {solution.iterations} "
            "iterations. Start nearer to it, use more panels, or march to see whether one exists"
        )
