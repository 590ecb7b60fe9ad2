"""What is left out when the harmonics of the exact motion are cut after some order.

At the crank angle where the pole lies nearest (90 or 270 degrees) all harmonics of the rod's
projection have one sign, so that the sum of their amplitudes in the acceleration is the second
derivative there, in closed form: y / sqrt(1 - y^2) with y = (R + |e|)/L. (The remark is ours.)
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.kinematics.harmonics import harmonics_with_error
from vibecalc.kinematics.poles import pole, series_terms
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray

#: orders beyond which the closed form takes over from summing the tail itself
LONGEST_TAIL = 4096
HIGHEST_ORDER = 16384


class Dropped(NamedTuple):
    """Sums (...) in units of R w^2 and their absolute errors."""

    value: FloatArray
    error: FloatArray


def dropped_acceleration(
    rod_ratio: ArrayLike, highest_order: int, offset_ratio: ArrayLike = 0.0
) -> FloatArray:
    """Sum of n^2 |C_n| over all orders above `highest_order`, in units of R w^2.

    It bounds the error of the acceleration at every crank angle when the exact harmonics are cut
    there; without an offset the bound is attained at 90 degrees.

    Parameters
    ----------
    rod_ratio, offset_ratio : arrays that broadcast
        R/L and e/R, as in `motion_harmonics`.
    highest_order : int
        Last order kept.

    Raises
    ------
    NumericalFailure
        As `motion_harmonics`.
    """
    return dropped_with_error(rod_ratio, highest_order, offset_ratio).value


def dropped_with_error(
    rod_ratio: ArrayLike, highest_order: int, offset_ratio: ArrayLike = 0.0
) -> Dropped:
    """`dropped_acceleration` with its absolute error."""
    ratio, offset = np.broadcast_arrays(
        np.asarray(rod_ratio, dtype=np.float64), np.asarray(offset_ratio, dtype=np.float64)
    )
    near = pole(ratio, np.abs(offset))
    tail = series_terms(near.radius, "sum of the dropped orders", limit=10**9)
    if tail <= LONGEST_TAIL:
        harmonics = harmonics_with_error(ratio, highest_order + tail, offset, derivative=2)
        part = np.abs(harmonics.values[..., highest_order + 1 :])
        value = np.sum(part[..., ::-1], axis=-1)
        error = np.sum(harmonics.error[..., highest_order + 1 :], axis=-1)
        return Dropped(value, error + 2.0 * EPSILON * value)
    harmonics = harmonics_with_error(ratio, max(highest_order, 1), offset, derivative=2)
    kept = np.abs(harmonics.values[..., : highest_order + 1])
    total = _rod_total(ratio, offset)
    # order 1 is the only one that does not come from the rod alone
    first = harmonics.values[..., 1]
    total = total + (np.abs(first) - np.abs(first.imag))
    value = total - np.sum(kept[..., ::-1], axis=-1)
    error = 8.0 * EPSILON * total + np.sum(harmonics.error[..., : highest_order + 1], axis=-1)
    return Dropped(value, error)


def order_for_tolerance(rod_ratio: float, rtol: float, offset_ratio: float = 0.0) -> int:
    """Smallest order after which the rest of the acceleration is below `rtol` of its largest part.

    The rest is `dropped_acceleration`, the largest part the greatest n^2 |C_n| (order 1 for every
    R/L of practice). As position and velocity fall off faster, they meet the tolerance too.

    Parameters
    ----------
    rod_ratio, offset_ratio : float
        R/L and e/R.
    rtol : float
        Relative tolerance, above 0.

    Raises
    ------
    NumericalFailure
        More than 16384 orders would be needed (R/L within about 1e-6 of 1), or the crank does
        not turn over.
    """
    ratio, offset = np.asarray(rod_ratio), np.asarray(offset_ratio)
    # the rest falls like q^n from the total; ten times less is asked for than this would say
    decay = -np.log(pole(ratio, np.abs(offset)).radius)
    at_least = np.log(_rod_total(ratio, offset) / (10.0 * rtol)) / decay
    highest = 16 if at_least <= HIGHEST_ORDER else 2 * HIGHEST_ORDER
    while highest <= HIGHEST_ORDER:
        amplitude = np.abs(
            harmonics_with_error(rod_ratio, highest, offset_ratio, derivative=2).values
        )
        allowed = rtol * float(np.max(amplitude))
        dropped = dropped_with_error(rod_ratio, highest, offset_ratio)
        if dropped.value + dropped.error <= allowed:
            # entry n: what a cut after order n leaves out
            rest = np.append(np.cumsum(amplitude[:0:-1])[::-1], 0.0) + dropped.value
            return int(np.argmax(rest <= allowed))
        highest *= 4
    raise NumericalFailure(
        f"kinematics: more than {HIGHEST_ORDER} harmonics would be needed for a relative tolerance "
        f"of {rtol:.3g} at R/L = {rod_ratio:.17g}, e/R = {offset_ratio:.17g}; choose the highest "
        "order yourself ([excitation] orders), loosen the tolerance or lengthen the rod"
    )


def _rod_total(ratio: FloatArray, offset: FloatArray) -> FloatArray:
    """Sum of n^2 |C_n| over all orders of the rod's projection: y / sqrt(1 - y^2)."""
    shift = ratio * np.abs(offset)
    reach = ratio + shift
    gap_root = pole(ratio, np.abs(offset)).gap_root
    return reach / (gap_root * np.sqrt((1.0 + reach) / (1.0 - shift + ratio)))
