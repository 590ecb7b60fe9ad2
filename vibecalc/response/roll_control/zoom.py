"""Least value over an interval, by grids that close in; for many intervals at once."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

#: points of every grid but the first
FINE = 9


class Zoomed(NamedTuple):
    """Best point, its merit, and the window that is left around it; all (...)."""

    at: np.ndarray
    level: np.ndarray
    low: np.ndarray
    high: np.ndarray


def zoom(
    merit: Callable[[np.ndarray], np.ndarray], low: np.ndarray, high: np.ndarray,
    points: int, rounds: int,
) -> Zoomed:  # fmt: skip
    """Least merit on [low, high] (...), all of them at once, by grids around the best point.

    merit takes (..., points). A window keeps the neighbours of its best point, so that a minimum
    on the edge of what is allowed stays inside as one within does. Grids after the first have
    FINE points.
    """
    for _ in range(rounds):
        share = np.linspace(0.0, 1.0, points)
        x = low[..., None] + (high - low)[..., None] * share
        level = merit(x)
        best = np.argmin(level, axis=-1)[..., None]
        least = np.take_along_axis(level, best, axis=-1)[..., 0]
        at = np.take_along_axis(x, best, axis=-1)[..., 0]
        low = np.take_along_axis(x, np.maximum(best - 1, 0), axis=-1)[..., 0]
        high = np.take_along_axis(x, np.minimum(best + 1, points - 1), axis=-1)[..., 0]
        points = FINE
    return Zoomed(at, least, low, high)
