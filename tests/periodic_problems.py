"""Periodic problems whose solutions are known, or can be had by another method, and random ones."""

from collections.abc import Callable

import numpy as np

from vibecalc.numerics.periodic.panels import PeriodicProblem

TURN = 2.0 * np.pi
Forcing = Callable[[np.ndarray], np.ndarray]


def linear_rhs(a: Forcing, b: Forcing):
    """y' = a(x) - b(x) y."""

    def rhs(x, y, piece):
        slope = -b(x) * np.ones_like(x)
        return (a(x) + slope * y[..., 0])[..., None], slope[..., None, None]

    return rhs


def friction_rhs(a: Forcing, bounds, slopes):
    """y' = a(x) - g(y), g(0) = 0 and piecewise linear: slopes between bounds ascending."""
    bounds, slopes = np.asarray(bounds, dtype=float), np.asarray(slopes, dtype=float)
    offsets = np.concatenate([[0.0], np.cumsum((slopes[:-1] - slopes[1:]) * bounds)])
    offsets = offsets - offsets[np.searchsorted(bounds, 0.0, side="right")]

    def rhs(x, y, piece):
        v = y[..., 0]
        at = np.searchsorted(bounds, v, side="right") if piece is None else piece[..., None]
        slope = slopes[at] * np.ones_like(v)
        return (a(x) - slope * v - offsets[at])[..., None], -slope[..., None, None]

    return rhs


def friction_problem(a: Forcing, bounds, slopes, edges) -> PeriodicProblem:
    return PeriodicProblem(
        friction_rhs(a, bounds, slopes), edges, lambda y: y[..., 0], np.asarray(bounds)
    )


def random_forcing(rng: np.random.Generator, size: float = 1.0) -> Forcing:
    """A trigonometric polynomial of up to six orders."""
    order = np.arange(1, 7)
    weight = size * rng.normal(size=(2, 6)) / order**1.5
    mean = size * rng.normal()

    def forcing(x):
        turns = x[..., None] * order
        return mean + np.cos(turns) @ weight[0] + np.sin(turns) @ weight[1]

    return forcing


def random_smooth(rng: np.random.Generator) -> PeriodicProblem:
    """Scalar, nonlinear, with one stable solution: y' = a(x) - b(x) y - c y^3, b > 0."""
    a, ripple = random_forcing(rng), random_forcing(rng, 0.2)
    level, cubic = np.exp(rng.uniform(-2.0, 1.5)), rng.uniform(0.0, 1.0)

    def rhs(x, y, piece):
        v, b = y[..., 0], level * np.exp(0.5 * np.tanh(ripple(x)))
        return (a(x) - b * v - cubic * v**3)[..., None], (-b - 3.0 * cubic * v**2)[..., None, None]

    return PeriodicProblem(rhs, random_edges(rng))


def random_edges(rng: np.random.Generator) -> np.ndarray:
    """6 to 40 panels, of widths that differ by up to 3."""
    widths = rng.uniform(1.0, 3.0, int(rng.integers(6, 41)))
    edges = np.concatenate([[0.0], np.cumsum(widths)])
    return TURN * edges / edges[-1]


def halved(edges: np.ndarray) -> np.ndarray:
    """Every panel in two."""
    return np.sort(np.concatenate([edges, 0.5 * (edges[1:] + edges[:-1])]))
