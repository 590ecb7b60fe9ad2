"""The complex poles that decide how fast the harmonics of a slider-crank fall off.

The rod's projection is a product of two factors under a root, `a -/+ (R/L) sin(angle)`, with
a = 1 +/- e/L. Each is proportional to |1 -/+ i q exp(i angle)|^2, where q < 1 is the small root of
(R/L) q^2 - 2 a q + R/L = 0. The harmonic of order n falls like q^n, so that q enters high powers
and a double alone is not enough: 200 times half a unit in the last place is 2e-14.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.twofold import compensated_sum, two_product
from vibecalc.numerics.typing import FloatArray


class Pole(NamedTuple):
    """A radius q with what its rounding left out.

    `radius * (1 + correction)` is q to about 30 digits; `gap_root` is the root of a^2 - (R/L)^2.
    """

    radius: FloatArray
    correction: FloatArray
    gap_root: FloatArray


def pole(rod_ratio: FloatArray, offset_ratio: FloatArray) -> Pole:
    """Radius of the pole on the side towards which the wrist pin is offset.

    Parameters
    ----------
    rod_ratio, offset_ratio : array, any shapes that broadcast
        R/L and e/R, taken as exact. A negative offset gives the pole of the far side.

    Returns
    -------
    Pole
        Solution of (R/L) q^2 - 2 (1 - e/L) q + R/L = 0, by the stable quadratic formula and one
        Newton step on a residual taken in twofold precision.

    Raises
    ------
    NumericalFailure
        R/L is not between 0 and 1, or the crank does not turn over: R + |e| >= L.
    """
    shift, shift_low = two_product(rod_ratio, offset_ratio)
    gap = compensated_sum((np.ones_like(rod_ratio), -rod_ratio, -shift, -shift_low))
    half = compensated_sum((np.ones_like(rod_ratio), -shift, -shift_low))
    turns = (rod_ratio > 0) & (gap > 0)
    if not np.all(turns):
        ratios, offsets = np.broadcast_arrays(rod_ratio, offset_ratio)
        raise NumericalFailure(
            "kinematics: the crank cannot turn over at R/L = "
            f"{ratios[~turns].flat[0]:.17g} with e/R = {offsets[~turns].flat[0]:.17g}; "
            "R/L must be above 0 and R + |e| below L"
        )
    gap_root = np.sqrt(gap * (half + rod_ratio))
    radius = rod_ratio / (half + gap_root)
    once, once_low = two_product(rod_ratio, radius)
    twice, twice_low = two_product(once, radius)
    moved, moved_low = two_product(2.0 * shift, radius)
    residual = compensated_sum(
        (
            rod_ratio,
            -2.0 * radius,
            twice,
            moved,
            twice_low,
            moved_low,
            once_low * radius,
            2.0 * shift_low * radius,
        )
    )
    return Pole(radius, residual / (2.0 * gap_root * radius), gap_root)


def series_terms(decay: FloatArray, what: str, limit: int = 1_000_000) -> int:
    """Terms after which a power series in `decay` is exact to rounding, for the slowest entry.

    The rest is bounded by decay^n / (1 - decay), which has to be below 2^-54 of a sum that is
    itself no smaller than sqrt(1 - decay).
    """
    slowest = float(np.max(decay, initial=0.0))
    if slowest <= 2.0**-54:
        return 1
    distance = max(1.0 - slowest, 2.0**-60)
    needed = (54.0 * np.log(2.0) - 1.5 * np.log(distance)) / -np.log1p(-distance)
    if needed > limit:
        raise NumericalFailure(
            f"kinematics: the {what} would take {needed:.2g} terms, more than {limit}, because R/L "
            "(with the offset) is within rounding of 1, where the acceleration of the piston "
            "jumps; lengthen the rod"
        )
    return int(np.ceil(needed))
