"""The best of the springs and oils that are to be had, against the best there could be."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.response.absorber.model import Absorber
from vibecalc.response.absorber.peaks import peaks

#: a part that exceeds a bound by less than this share keeps it
_KEPT = 1e-9


class StockChoice(NamedTuple):
    """Every pair of spring (s,) and oil (o,), and the best of them.

    `peak` (s, o) of |H| with absolute `error`, `travel` (s, o) of the spring, `allowed` (s, o)
    within the bounds. `spring`, `oil`: places of the best pair; `order` (p, 2): all allowed
    pairs by rising peak. `penalty` (s, o) = peak / free_peak - 1 against the given `free_peak`.
    `unsure`: the best two differ by less than their errors.
    """

    peak: np.ndarray
    error: np.ndarray
    travel: np.ndarray
    allowed: np.ndarray
    penalty: np.ndarray
    spring: int
    oil: int
    order: np.ndarray
    unsure: bool


def stock_choice(
    primary_damping: float, mass_ratio: float, stiffness_ratios: ArrayLike, dampings: ArrayLike,
    free_peak: float, excitation: str = "force", response: str = "displacement", *,
    stiffness: tuple[float, float] = (0.0, np.inf), damping: tuple[float, float] = (0.0, np.inf),
    travel: float = np.inf,
) -> StockChoice:  # fmt: skip
    """Compare all pairs of stock springs k (s,) and oils z2 (o,) by the largest |H|.

    `dampings` may be (s, o) where an oil's damping depends on the spring beside it. `free_peak` is
    the peak of the free optimum. Raises NumericalFailure where no pair has a finite peak within
    the limit of travel.
    """
    k = np.asarray(stiffness_ratios, dtype=float)
    z = np.broadcast_to(np.asarray(dampings, dtype=float), (len(k), np.shape(dampings)[-1]))
    absorber = Absorber(primary_damping, mass_ratio, k[:, None], z)
    found = peaks(absorber, excitation, response)
    moved = peaks(absorber, excitation, "relative_displacement").largest
    held = [
        (ratio >= low * (1.0 - _KEPT)) & (ratio <= high * (1.0 + _KEPT))
        for ratio, (low, high) in ((k[:, None], stiffness), (z, damping))
    ]
    inside = (moved <= travel * (1.0 + _KEPT)) & np.isfinite(found.largest)
    allowed = inside & held[0] & held[1]
    if not np.any(allowed) and np.any(inside):
        raise NumericalFailure(
            f"none of the {allowed.size} pairs of spring and damper keeps the bounds of stiffness "
            "and damping"
        )
    if not np.any(allowed):
        raise NumericalFailure(
            f"none of the {allowed.size} pairs in stock has a finite peak with a spring "
            f"travel of at most {travel:.6g}; the least travel is {float(np.min(moved)):.6g}"
        )
    height = np.where(allowed, found.largest, np.inf)
    ranking = np.argsort(height, axis=None, kind="stable")[: int(np.sum(allowed))]
    order = np.stack(np.unravel_index(ranking, height.shape), axis=-1)
    spring, oil = (int(place) for place in order[0])
    unsure = False
    if len(order) > 1:
        first, second = tuple(order[0]), tuple(order[1])
        unsure = bool(
            height[second] - height[first]
            <= found.largest_error[first] + found.largest_error[second]
        )
    return StockChoice(
        found.largest, found.largest_error, moved, allowed, found.largest / free_peak - 1.0,
        spring, oil, order, unsure,
    )  # fmt: skip
