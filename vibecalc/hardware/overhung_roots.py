"""Roots between given ends by inverse quadratic steps, each with halving as its net.

Chandrupatla, Advances in Engineering Software 28 (1997) 145: a quadratic through the last three
values for the inverse function where it is sure to be monotonic, a halving elsewhere.
"""

from collections.abc import Callable

import numpy as np

from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.numerics.typing import FloatArray

#: a halving every second step at worst
_MOST_STEPS = 200


def closed_in(
    value: Callable[[FloatArray], FloatArray],
    low: FloatArray,
    high: FloatArray,
    at_low: FloatArray,
    at_high: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Roots (...) > 0 between ends whose values differ in sign, to rounding, and steps taken (...).

    `value` takes and gives arrays (...). Every root ends by itself, so that its last bit does not
    depend on the others.
    """
    new, old = low, high
    at_new, at_old = np.asarray(at_low), np.asarray(at_high)
    share = np.full(np.shape(low), 0.5)
    root, steps = np.where(np.abs(at_new) < np.abs(at_old), new, old), np.zeros(np.shape(low))
    live = (at_new != 0.0) & (at_old != 0.0)
    for _ in range(_MOST_STEPS):
        if not np.any(live):
            break
        place = np.where(live, new + share * (old - new), new)
        there = value(place)
        steps = steps + live
        same = np.sign(there) == np.sign(at_new)
        third, at_third = np.where(same, new, old), np.where(same, at_new, at_old)
        old, at_old = np.where(live & ~same, new, old), np.where(live & ~same, at_new, at_old)
        new, at_new = np.where(live, place, new), np.where(live, there, at_new)
        nearer = np.abs(at_new) < np.abs(at_old)
        root = np.where(live, np.where(nearer, new, old), root)
        reach = 2.0 * UNIT_ROUNDOFF * np.abs(root)
        width = np.abs(old - new)
        live = live & (width > 2.0 * reach) & (there != 0.0)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            along = (new - old) / (third - old)
            level = (at_new - at_old) / (at_third - at_old)
            smooth = (1.0 - np.sqrt(1.0 - along) < level) & (level < np.sqrt(along))
            inverse = at_new / (at_old - at_new) * at_third / (at_old - at_third) + (
                third - new
            ) / (old - new) * at_new / (at_third - at_new) * at_old / (at_third - at_old)
            least = np.minimum(reach / np.where(width > 0.0, width, 1.0), 0.5)
        share = np.where(smooth & np.isfinite(inverse), inverse, 0.5)
        share = np.clip(share, least, 1.0 - least)
    return root, steps
