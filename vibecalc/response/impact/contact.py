"""Which contact a gap is in, and the straight-line force law that holds there."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.response.impact.model import Gaps

#: sides of a gap: in the lower contact (z < 0), free, in the upper contact (z > clearance)
LOWER, FREE, UPPER = -1, 0, 1


class Law(NamedTuple):
    """F = spring (z - rest) + damper z' for lower < z < upper; arrays (G, B)."""

    spring: FloatArray
    rest: FloatArray
    damper: FloatArray
    lower: FloatArray
    upper: FloatArray


def side_of(gaps: Gaps, gap: FloatArray) -> IntArray:
    """Side of each gap (G, B) from its place alone; a gap on a face counts as free."""
    return (gap > gaps.clearance).astype(np.int64) - (gap < 0.0).astype(np.int64)


def law_of(gaps: Gaps, side: IntArray) -> Law:
    """Force law and its limits (G, B) on the given sides."""
    free, above = side == FREE, side == UPPER
    return Law(
        spring=np.where(free, 0.0, gaps.stiffness),
        rest=np.where(above, gaps.upper_rest, 0.0),
        damper=np.where(free, gaps.film_damping, gaps.contact_damping),
        lower=np.where(above, gaps.clearance, np.where(free, 0.0, -np.inf)),
        upper=np.where(above, np.inf, np.where(free, gaps.clearance, 0.0)),
    )


def spring_energy(gaps: Gaps, gap: FloatArray) -> FloatArray:
    """Energy in the contact springs, J, arrays (G, B); continuous at the faces by definition."""
    over = np.maximum(gap - gaps.clearance, 0.0)
    # (z - r)^2 - (c - r)^2 as a product, which keeps its digits near the face
    beyond = over * (over + 2.0 * (gaps.clearance - gaps.upper_rest))
    energy = 0.5 * gaps.stiffness * (beyond + np.square(np.minimum(gap, 0.0)))
    return np.asarray(energy)
