"""Harmonics of the exact piston motion to full accuracy, and what a truncation leaves out."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import (
    EPSILON,
    ComplexArray,
    FloatArray,
    IntArray,
    compensated_sum,
    two_product,
    two_sum,
)

# ----------------------------------------------------------------------------
# The complex poles that decide how fast the harmonics of a slider-crank fall off.
#
# The rod's projection is a product of two factors under a root, `a -/+ (R/L) sin(angle)`, with a =
# 1 +/- e/L. Each is proportional to |1 -/+ i q exp(i angle)|^2, where q < 1 is the small root of
# (R/L) q^2 - 2 a q + R/L = 0. The harmonic of order n falls like q^n, so that q enters high powers
# and a double alone is not enough: 200 times half a unit in the last place is 2e-14.
# ----------------------------------------------------------------------------


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


# ----------------------------------------------------------------------------
# Harmonics of the exact motion when the cylinder axis passes through the crank axis.
#
# With lam = R/L and lam = 2 kappa / (1 + kappa^2), the projection of the rod over the crank radius
# is
#
#     sqrt(1 - lam^2 sin^2 t) / lam = |1 + kappa^2 exp(2 i t)| / (2 kappa),
#
# and multiplying out the two binomial series gives the coefficient of cos 2kt,
#
#     binomial(1/2, k) kappa^(2k - 1) F(-1/2, k - 1/2; k + 1; kappa^4),
#
# half of it at k = 0. (Closed form of the series in Biezeno and Grammel, Technische Dynamik, XII.)
# No step cancels: F = 1 - (positive terms) and stays above sqrt(1 - kappa^4).
# ----------------------------------------------------------------------------

SMALLEST_NORMAL = float(np.finfo(np.float64).tiny)


def centred_harmonics(
    rod_ratio: FloatArray, highest_order: int, derivative: int
) -> tuple[FloatArray, FloatArray]:
    """Real coefficients n^derivative C_n, s/R = sum C_n cos(n angle), and their absolute errors.

    Parameters
    ----------
    rod_ratio : array (...,)
        R/L, taken as exact, between 0 and 1.
    highest_order : int
        Orders 0 to this one.
    derivative : int
        Power of n, taken in before anything underflows.

    Returns
    -------
    values, error : arrays (..., highest_order + 1)
        Odd orders above 1 are exactly zero; a value below the smallest normal double is zero.

    Raises
    ------
    NumericalFailure
        R/L is so close to 1 that more than a million terms would be needed (1 - R/L < 1e-10).
    """
    near = pole(rod_ratio, np.zeros_like(rod_ratio))
    half_order = np.arange(highest_order // 2 + 1)
    factor, factor_error = _gauss_series(near.radius, near.gap_root, half_order)

    power = np.where(half_order == 0, -1, 2 * half_order - 1)
    lower_power = power // 2
    kappa = near.radius[..., None]
    weight = _binomials(len(half_order)) * (2.0 * half_order) ** derivative
    weight[0] *= 0.5
    lower = weight * np.power(kappa, lower_power.astype(np.float64))
    upper = np.power(kappa, (power - lower_power).astype(np.float64)) * factor
    even = lower * (upper * (1.0 + power * near.correction[..., None]))
    even_error = np.abs(even) * (3.0 * EPSILON + factor_error) + SMALLEST_NORMAL
    even = np.where(np.abs(even) < SMALLEST_NORMAL, 0.0, even)

    values = np.zeros((*rod_ratio.shape, highest_order + 1))
    error = np.zeros_like(values)
    values[..., ::2] = even
    error[..., ::2] = even_error * (weight != 0.0)
    values[..., 1:2] = 1.0
    return values, error


def _gauss_series(
    kappa: FloatArray, gap_root: FloatArray, half_order: np.ndarray
) -> tuple[FloatArray, FloatArray]:
    """F(-1/2, k - 1/2; k + 1; kappa^4), shape (..., k), and its relative error.

    Summed from the smallest term (Horner), so that rounding does not grow with the number of
    terms. Near 1 the argument comes from its distance to 1, which carries more digits.
    """
    distance = 4.0 * gap_root / (1.0 + gap_root) ** 2
    argument = np.where(distance < 0.5, 1.0 - distance, (kappa * kappa) ** 2)[..., None]
    k = half_order.astype(np.float64)
    sum_ = np.ones(np.broadcast_shapes(argument.shape, k.shape))
    for term in range(series_terms(argument, "harmonics"), 0, -1):
        ratio = (term - 1.5) / term * (1.0 - 1.5 / (k + term))
        sum_ = 1.0 + argument * ratio * sum_
    sensitivity = np.minimum(0.5 * argument / distance[..., None], 0.5 * (k + 1.0))
    return sum_, EPSILON * (1.0 + (1.0 + sensitivity) / sum_)


@lru_cache(maxsize=8)
def _binomial_table(count: int) -> tuple[float, ...]:
    """Rounded values of binomial(1/2, k) from exact integers: -(-1)^k C(2k, k) / (4^k (2k - 1))."""
    central, table = 1, []
    for k in range(count):
        sign = 1 if k % 2 else -1
        table.append(sign * central / ((2 * k - 1) << (2 * k)) if k else 1.0)
        central = central * 2 * (2 * k + 1) // (k + 1)
    return tuple(table)


def _binomials(count: int) -> FloatArray:
    return np.array(_binomial_table(count))


# ----------------------------------------------------------------------------
# Harmonics of the exact motion with a wrist pin offset.
#
# The rod's projection is the root of two factors, one from each dead side. With the poles q1 <= q2
# of `poles.py` and the real power series h(y) = sqrt((1 + q1 y)(1 - q2 y)) = sum q2^j G_j y^j,
#
#     sqrt(1 - lam^2 (sin t - e/R)^2) / lam = |h(i exp(i t))|^2 / (2 sqrt(q1 q2)),
#
# so that its coefficient of exp(i n t) is i^n q2^n / sqrt(q1 q2) times the autocorrelation
# S_n = sum_j q2^(2j) G_(j+n) G_j (half of it at n = 0). From (1 + (q1 - q2) y - q1 q2 y^2) h' =
# ((q1 - q2)/2 - q1 q2 y) h follows, with rho = q1/q2 and sigma = 1 - rho,
#
#     (j + 1) G_(j+1) = sigma (j - 1/2) G_j + rho (j - 2) G_(j-1),      G_0 = 1, G_1 = -sigma/2:
#
# all G_j from j = 1 on are negative, nothing cancels in the recurrence, and S_n loses at most the
# factor by which |G_n| exceeds |S_n|. (The derivation is ours.)
# ----------------------------------------------------------------------------


def offset_harmonics(
    rod_ratio: FloatArray, offset_ratio: FloatArray, highest_order: int, derivative: int
) -> tuple[ComplexArray, FloatArray]:
    """Complex coefficients n^derivative C_n, s/R = Re sum C_n exp(i n angle), and absolute errors.

    Parameters
    ----------
    rod_ratio, offset_ratio : arrays (...,) of one shape
        R/L and e/R, taken as exact; a negative offset gives the conjugate coefficients.
    highest_order, derivative : int
        Orders 0 to `highest_order`; power of n, taken in before anything underflows.

    Returns
    -------
    values, error : arrays (..., highest_order + 1)
        Relative accuracy of a few units in the last place, growing with n to about 30 at
        order 200.

    Raises
    ------
    NumericalFailure
        (R + |e|)/L is so close to 1 that more than a million terms would be needed.
    """
    offset = np.abs(offset_ratio)
    near, far = pole(rod_ratio, offset), pole(rod_ratio, -offset)
    shift = rod_ratio * offset
    far_sum = 1.0 + shift + far.gap_root
    ratio = (1.0 - shift + near.gap_root) / far_sum
    difference = 2.0 * shift * (1.0 + 2.0 / (near.gap_root + far.gap_root)) / far_sum

    square = near.radius * near.radius
    count = series_terms(square, "harmonics with an offset")
    series = _root_series(difference, highest_order + count + 1)
    order = np.arange(highest_order + 1)
    tail = _autocorrelation_tail(series, square, highest_order, count)
    first = np.moveaxis(series[: highest_order + 1], 0, -1)
    correlation = first + tail

    q, power = near.radius[..., None], order - 1
    lower_power = power // 2
    weight = order.astype(np.float64) ** derivative
    weight[0] *= 0.5
    lower = weight * np.power(q, lower_power.astype(np.float64))
    upper = np.power(q, (power - lower_power).astype(np.float64)) / np.sqrt(ratio)[..., None]
    scale = upper * (1.0 + power * near.correction[..., None])
    part = lower * (scale * correlation)
    part_error = lower * (scale * (np.abs(first) + np.abs(tail)))
    part_error = part_error * EPSILON * (4.0 + 0.25 * order) + SMALLEST_NORMAL * (weight != 0.0)
    part = np.where(np.abs(part) < SMALLEST_NORMAL, 0.0, part)

    turn = np.array([1.0, 1.0j, -1.0, -1.0j])[order % 4]
    turn = np.where(offset_ratio[..., None] < 0.0, turn.conj(), turn)
    values: ComplexArray = part * turn
    values[..., 1:2] += 1.0
    return values, part_error


def _root_series(difference: FloatArray, length: int) -> FloatArray:
    """G_j of the module's docstring, shape (length, ...).

    sigma and rho have to add up to 1 beyond a double, or G drifts by their mismatch at each step.
    """
    ratio, ratio_low = two_sum(np.ones_like(difference), -difference)
    series = np.empty((max(length, 3), *difference.shape))
    series[0] = 1.0
    series[1] = -0.5 * difference
    for j in range(1, length - 1):
        before = (j - 2) * series[j - 1]
        series[j + 1] = difference * ((j - 0.5) * series[j]) + ratio * before
        series[j + 1] += ratio_low * before
        series[j + 1] /= j + 1
    return series[:length]


def _autocorrelation_tail(
    series: FloatArray, square: FloatArray, highest_order: int, count: int
) -> FloatArray:
    """S_n without its first term: sum over j >= 1 of q^(2j) G_(j+n) G_j, shape (..., n)."""
    # contiguous along j, so that numpy sums in pairs
    along = np.ascontiguousarray(np.moveaxis(series, 0, -1))
    weighted = np.power(square[..., None], np.arange(1.0, count + 1.0)) * along[..., 1 : count + 1]
    tail = np.empty((*square.shape, highest_order + 1))
    for n in range(highest_order + 1):
        tail[..., n] = np.sum(weighted * along[..., n + 1 : n + count + 1], axis=-1)
    return tail


# ----------------------------------------------------------------------------
# Harmonic coefficients of the exact piston motion, to full relative accuracy at every order.
#
# Convention: s/R = Re sum_n C_n exp(i n angle), n = 0, 1, 2 ..., with s the distance of the wrist
# pin from the crank axis along the cylinder axis and the angle from the crank's position along it.
# Order 1 is 1 (cos) plus what an offset adds; without an offset odd orders above 1 are zero.
# ----------------------------------------------------------------------------


class Harmonics(NamedTuple):
    """Complex coefficients (..., n), 0-to-peak in units of R, and the absolute error of each."""

    values: ComplexArray
    error: FloatArray


def motion_harmonics(
    rod_ratio: ArrayLike, highest_order: int, offset_ratio: ArrayLike = 0.0, derivative: int = 0
) -> ComplexArray:
    """Coefficients C_n of s/R, or (i n)^derivative C_n of a derivative by the crank angle.

    Parameters
    ----------
    rod_ratio : array (...,)
        R/L between 0 and 1, taken as exact.
    highest_order : int
        Orders 0 to this one.
    offset_ratio : array that broadcasts with rod_ratio
        Wrist pin offset over crank radius, e/R, positive towards a crank angle of 90 degrees;
        (R/L)(1 + |e/R|) < 1.
    derivative : int
        0 position, 1 velocity over R w, 2 acceleration over R w^2. Formed together with the
        coefficient, so that -n^2 C_n is right where C_n alone has underflowed.

    Returns
    -------
    complex array (..., highest_order + 1)
        Relative error below 1e-14 for R/L up to .99 at orders to 200 (measured: 1e-15 without
        an offset, 7e-15 with one); beyond, see `harmonics_with_error`. Where a value is below the
        smallest normal double, 2.3e-308, it is zero.

    Raises
    ------
    NumericalFailure
        The crank does not turn over (R + |e| >= L), or 1 - R/L is below about 1e-10.
    """
    return harmonics_with_error(rod_ratio, highest_order, offset_ratio, derivative).values


def harmonics_with_error(
    rod_ratio: ArrayLike, highest_order: int, offset_ratio: ArrayLike = 0.0, derivative: int = 0
) -> Harmonics:
    """`motion_harmonics` with the absolute error of every coefficient, for R/L and e/R exact."""
    ratio, offset = np.broadcast_arrays(
        np.asarray(rod_ratio, dtype=np.float64), np.asarray(offset_ratio, dtype=np.float64)
    )
    is_offset = offset != 0.0
    values = np.empty((*ratio.shape, highest_order + 1), dtype=np.complex128)
    error = np.empty(values.shape)
    # entries without an offset take their own route, so that a zero offset changes no bit
    if not np.all(is_offset):
        values[~is_offset], error[~is_offset] = centred_harmonics(
            ratio[~is_offset], highest_order, derivative
        )
    if np.any(is_offset):
        values[is_offset], error[is_offset] = offset_harmonics(
            ratio[is_offset], offset[is_offset], highest_order, derivative
        )
    turn = (1.0, 1.0j, -1.0, -1.0j)[derivative % 4]
    return Harmonics(values * turn, error)


# ----------------------------------------------------------------------------
# What is left out when the harmonics of the exact motion are cut after some order.
#
# At the crank angle where the pole lies nearest (90 or 270 degrees) all harmonics of the rod's
# projection have one sign, so that the sum of their amplitudes in the acceleration is the second
# derivative there, in closed form: y / sqrt(1 - y^2) with y = (R + |e|)/L. (The remark is ours.)
# ----------------------------------------------------------------------------

#: orders beyond which the closed form takes over from summing the tail itself
LONGEST_TAIL = 4096
HIGHEST_ORDER = 16384


class DroppedSums(NamedTuple):
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
) -> DroppedSums:
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
        return DroppedSums(value, error + 2.0 * EPSILON * value)
    harmonics = harmonics_with_error(ratio, max(highest_order, 1), offset, derivative=2)
    retained = np.abs(harmonics.values[..., : highest_order + 1])
    total = _rod_total(ratio, offset)
    # order 1 is the only one that does not come from the rod alone
    first = harmonics.values[..., 1]
    total = total + (np.abs(first) - np.abs(first.imag))
    value = total - np.sum(retained[..., ::-1], axis=-1)
    error = 8.0 * EPSILON * total + np.sum(harmonics.error[..., : highest_order + 1], axis=-1)
    return DroppedSums(value, error)


def order_for_tolerance(
    rod_ratio: ArrayLike, rtol: float, offset_ratio: ArrayLike = 0.0
) -> IntArray:
    """Smallest order (...) after which the rest of the acceleration is below `rtol` of its largest
    part.

    The rest is `dropped_acceleration`, the largest part the greatest n^2 |C_n| (order 1 for every
    R/L of practice). As position and velocity fall off faster, they meet the tolerance too.

    Parameters
    ----------
    rod_ratio, offset_ratio : arrays that broadcast (...)
        R/L and e/R.
    rtol : float
        Relative tolerance, above 0.

    Raises
    ------
    NumericalFailure
        More than 16384 orders would be needed (R/L within about 1e-6 of 1), or the crank does
        not turn over.
    """
    ratio, offset = np.broadcast_arrays(
        np.asarray(rod_ratio, dtype=np.float64), np.asarray(offset_ratio, dtype=np.float64)
    )
    # the rest falls like q^n from the total; ten times less is asked for than this would say
    decay = -np.log(pole(ratio, np.abs(offset)).radius)
    at_least = np.max(np.log(_rod_total(ratio, offset) / (10.0 * rtol)) / decay, initial=0.0)
    highest = 16 if at_least <= HIGHEST_ORDER else 2 * HIGHEST_ORDER
    enough, left = np.zeros(ratio.size, dtype=np.int64), np.arange(ratio.size)
    while left.size and highest <= HIGHEST_ORDER:
        some, moved = ratio.flat[left], offset.flat[left]
        amplitude = np.abs(harmonics_with_error(some, highest, moved, derivative=2).values)
        allowed = rtol * np.max(amplitude, axis=-1)
        dropped = dropped_with_error(some, highest, moved)
        settled = dropped.value + dropped.error <= allowed
        # entry n: what a cut after order n leaves out
        beyond = np.cumsum(amplitude[:, :0:-1], axis=-1)[:, ::-1]
        remainder = np.pad(beyond, ((0, 0), (0, 1))) + dropped.value[:, None]
        first = np.argmax(remainder <= allowed[:, None], axis=-1)
        enough[left[settled]] = first[settled]
        left, highest = left[~settled], highest * 4
    if left.size:
        raise NumericalFailure(
            f"kinematics: more than {HIGHEST_ORDER} harmonics would be needed for a relative "
            f"tolerance of {rtol:.3g} at R/L = {ratio.flat[left[0]]:.17g}, e/R = "
            f"{offset.flat[left[0]]:.17g}; choose the highest order yourself ([excitation] orders),"
            " loosen the tolerance or lengthen the rod"
        )
    return enough.reshape(ratio.shape)


def _rod_total(ratio: FloatArray, offset: FloatArray) -> FloatArray:
    """Sum of n^2 |C_n| over all orders of the rod's projection: y / sqrt(1 - y^2)."""
    shift = ratio * np.abs(offset)
    reach = ratio + shift
    gap_root = pole(ratio, np.abs(offset)).gap_root
    return reach / (gap_root * np.sqrt((1.0 + reach) / (1.0 - shift + ratio)))
