"""Minimax tuning where spring or damper is given, or both come from stock."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.absorber.peaks import maxima, peaks
from vibecalc.absorber.squared_magnitude import columns, excess_derivatives, measure
from vibecalc.absorber.transfer import Absorber, Coupling, Transfer, coupling, transfer_of
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF

# ----------------------------------------------------------------------------
# Tunings with one of spring and damper given: viscous damper, undamped spring, stock parts.
# ----------------------------------------------------------------------------

#: range of ln (free ratio / m) searched, wide enough for both limits to be felt
_REACH = (-30.0, 12.0)
#: places examined first, closer together where absorbers are tuned
_FIRST_PLACES = np.unique(np.concatenate([np.linspace(*_REACH, 15), np.linspace(-4.0, 2.0, 19)]))
#: halvings that leave the rest to Newton's method
_HALVINGS = 22


class RestrictedTuning(NamedTuple):
    """Best tunings (...) along one line, sup |H| there and errors of both.

    `value` of the free ratio; `held_by` the number of active peaks: 1 where one peak is stationary
    in the free ratio, 2 where two peaks are equal, 0 where the best is a limit: then `value` is
    zero or infinite. Where the floor is reached, `value` is one of many.
    """

    value: np.ndarray
    largest: np.ndarray
    value_error: np.ndarray
    largest_error: np.ndarray
    held_by: np.ndarray
    evaluations: np.ndarray


def pure_viscous(
    primary_damping: ArrayLike, mass_ratio: ArrayLike, excitation: str = "force",
    response: str = "displacement",
) -> RestrictedTuning:  # fmt: skip
    """Best z2 of a damper without a spring (type B of Baca Vasquez, 2007; Houdaille)."""
    return given_stiffness(primary_damping, mass_ratio, 0.0, excitation, response)


def undamped_spring(
    primary_damping: ArrayLike, mass_ratio: ArrayLike, excitation: str = "force",
    response: str = "displacement",
) -> RestrictedTuning:  # fmt: skip
    """Best k of a secondary without damping. Raises NumericalFailure for an undamped primary."""
    if np.any(np.asarray(primary_damping) == 0.0):
        raise NumericalFailure("without any damping the response is infinite whatever the spring")
    return given_damping(primary_damping, mass_ratio, 0.0, excitation, response)


def given_stiffness(
    primary_damping: ArrayLike, mass_ratio: ArrayLike, stiffness_ratio: ArrayLike,
    excitation: str = "force", response: str = "displacement",
) -> RestrictedTuning:  # fmt: skip
    """Best z2 for a given k >= 0."""
    return _along(primary_damping, mass_ratio, stiffness_ratio, True, (excitation, response))


def given_damping(
    primary_damping: ArrayLike, mass_ratio: ArrayLike, secondary_damping: ArrayLike,
    excitation: str = "force", response: str = "displacement",
) -> RestrictedTuning:  # fmt: skip
    """Best k for a given z2 >= 0."""
    return _along(primary_damping, mass_ratio, secondary_damping, False, (excitation, response))


def _along(
    primary_damping: ArrayLike, mass_ratio: ArrayLike, ratio: ArrayLike, damping_free: bool,
    asked: tuple[str, str],
) -> RestrictedTuning:  # fmt: skip
    """Halve the interval by the sign of the slope of the highest peak, then Newton's method."""
    transfer = transfer_of(*asked)
    if transfer.motion not in ("primary", "ground"):
        raise NumericalFailure(f"no tuning makes {asked[1]} least: it vanishes with the absorber")
    z1, m, given = np.broadcast_arrays(
        *(np.asarray(one, dtype=float) for one in (primary_damping, mass_ratio, ratio))
    )
    if not np.all((m > 0.0) & np.isfinite(m) & (z1 >= 0.0) & np.isfinite(z1)):
        raise NumericalFailure("a tuning needs 0 < mass ratio < infinity and 0 <= primary damping")
    if not np.all((given >= 0.0) & np.isfinite(given)):
        raise NumericalFailure("the given ratio must be zero or above, and finite")
    shape = m.shape
    z1, m, given = (np.array(one).reshape(-1) for one in (z1, m, given))
    count = len(m)

    def top(logs: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return _top(z1, m, given, logs, damping_free, transfer)

    # the largest peak may have humps far from tune: sample the whole range once
    first_places = _FIRST_PLACES
    if not damping_free and np.any(given == 0.0):
        # the peak that a very soft spring without damper adds is too sharp to be seen
        first_places = first_places[first_places >= -9.0]
    many = len(first_places)
    places = (np.log(m) + first_places[:, None]).reshape(-1)
    levels = _top(
        np.tile(z1, many), np.tile(m, many), np.tile(given, many), places, damping_free, transfer
    )[1][0].reshape(many, count)
    # without a damped primary there always is a peak: one that is not seen is too high
    levels = np.where((levels == -np.inf) & (z1 == 0.0), np.inf, levels)
    best = np.argmin(levels, axis=0)
    low = np.log(m) + first_places[np.maximum(best - 1, 0)]
    high = np.log(m) + first_places[np.minimum(best + 1, len(first_places) - 1)]
    rises = best < len(first_places) - 1
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        y, level, slope = top(middle)
        up = (slope > 0.0) | (level[0] <= 0.0)
        high, low = np.where(up, middle, high), np.where(up, low, middle)
    middle = 0.5 * (low + high)
    y, level, _ = top(middle)
    middle, y, held = _finish(z1, m, given, middle, y, level, damping_free, transfer)
    free = np.exp(middle)
    # a level that falls to the far end of the range has its least in that limit
    free = np.where(~rises & (middle - np.log(m) > _REACH[1] - 1.0), np.inf, free)
    k, z2 = (given, free) if damping_free else (free, given)
    # nothing at all can be better than any of it: a light spring without a damper is worse
    none = (given, np.zeros(count)) if damping_free else (np.zeros(count), given)
    bare = peaks(Absorber(z1, m, *none), *asked).largest
    free = np.where(bare <= peaks(Absorber(z1, m, k, z2), *asked).largest, 0.0, free)
    inside = np.isfinite(free) & (free > 0.0)
    k, z2 = (given, free) if damping_free else (free, given)
    there = peaks(Absorber(z1, m, k, z2), *asked)
    slack = np.where(inside & (held == 2), there.largest * (1.0 + there.largest), there.largest)
    error = there.largest_error + 16.0 * UNIT_ROUNDOFF * np.where(np.isfinite(slack), slack, 0.0)
    # where two peaks are equal their difference has their rounding, over a slope of order one
    steep = np.where(held == 2, there.largest, 0.0)
    wrong = np.where(inside, free * 64.0 * UNIT_ROUNDOFF * (1.0 + steep), 0.0)
    held = np.where(inside, held, 0)
    used = np.full(count, _HALVINGS + len(_FIRST_PLACES) + 8)
    columns = (free, there.largest, wrong, error, held, used)
    return RestrictedTuning(*(np.reshape(a, shape) for a in columns))


def _top(
    z1: np.ndarray, m: np.ndarray, given: np.ndarray, logs: np.ndarray, damping_free: bool,
    transfer: Transfer,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """ln u (2, n) and excess (2, n) of the two highest peaks, and the slope of the highest."""
    free = np.exp(logs)
    k, z2 = (given, free) if damping_free else (free, given)
    coupled = coupling(Absorber(z1, m, k, z2))
    tops = maxima(coupled, measure(coupled, transfer))
    rows, u, value = tops.row, tops.place.value, tops.height.value
    y, level = np.zeros((2, len(m))), np.full((2, len(m)), -np.inf)
    order = np.lexsort((-value, rows))
    rank = np.arange(len(rows)) - np.searchsorted(rows[order], rows[order])
    for i in range(2):
        pick = order[rank == i]
        y[i, rows[pick]], level[i, rows[pick]] = np.log(u[pick]), value[pick]
    return y, level, _slope(z1, m, given, logs, y, damping_free, transfer)[1][0]


def _slope(
    z1: np.ndarray, m: np.ndarray, given: np.ndarray, logs: np.ndarray, y: np.ndarray,
    damping_free: bool, transfer: Transfer,
) -> tuple[np.ndarray, ...]:  # fmt: skip
    """Of w = ln (excess) at y (2, n): value, slopes by the free logarithm and by y, bends."""
    free = np.exp(logs)
    k, z2 = (given, free) if damping_free else (free, given)
    coupled = Coupling(z1, m, m, k, 2.0 * z2, np.zeros(len(m), dtype=int))
    floor, *weights = measure(coupled, transfer)
    u = np.exp(y)
    with np.errstate(all="ignore"):
        above, below = excess_derivatives(
            z1, m, m, k, 2.0 * z2, u, floor, [columns(weight) for weight in weights]
        )
        first, mixed, second = (4, 6, 9) if damping_free else (3, 5, 7)
        ratio = 2.0 * free if damping_free else free
        a, q = ([slot / side[0] for slot in side] for side in (above, below))
        slope = (a[first] - q[first]) * ratio
        along = (a[1] - q[1]) * u
        yy = (a[2] - a[1] ** 2 - q[2] + q[1] ** 2) * u * u + along
        yp = (a[mixed] - a[1] * a[first] - q[mixed] + q[1] * q[first]) * u * ratio
        pp = (a[second] - a[first] ** 2 - q[second] + q[first] ** 2) * ratio**2 + slope
        level = np.log(above[0] / below[0])
    return level, slope, along, yy, yp, pp


def _finish(
    z1: np.ndarray, m: np.ndarray, given: np.ndarray, logs: np.ndarray, y: np.ndarray,
    level: np.ndarray, damping_free: bool, transfer: Transfer,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """Newton on equal peaks where two are level, on a stationary peak elsewhere."""
    with np.errstate(all="ignore"):
        two = (level[1] > 0.0) & (level[1] / level[0] > 1.0 - 1e-3)
        slopes = _slope(z1, m, given, logs, y, damping_free, transfer)[1]
        two &= slopes[0] * slopes[1] < 0.0
        for _ in range(6):
            w, slope, along, yy, yp, pp = _slope(z1, m, given, logs, y, damping_free, transfer)
            flat = slope - yp * along / yy
            height = w - 0.5 * along**2 / yy
            bend = pp - yp**2 / yy
            equal = -(height[0] - height[1]) / (flat[0] - flat[1])
            smooth = -flat[0] / bend[0]
            step = np.where(two, equal, smooth)
            step = np.where(np.isfinite(step) & (np.abs(step) < 1e-2), step, 0.0)
            shift = -(along + yp * step) / yy
            y = y + np.where(np.isfinite(shift) & (np.abs(shift) < 0.1), shift, 0.0)
            logs = logs + step
    return logs, y, np.where(two, 2, 1)


# ----------------------------------------------------------------------------
# The best of the springs and oils that are to be had, against the best there could be.
# ----------------------------------------------------------------------------

#: a part that exceeds a bound by less than this share keeps it
_WITHIN = 1e-9


#: k and z2 (s, o), a response -> largest |H| (s, o) and its error
Read = Callable[[np.ndarray, np.ndarray, str], tuple[np.ndarray, np.ndarray]]


#: heights (n,) of pairs of k (n,) and z (n,)
Heights = Callable[[np.ndarray, np.ndarray], np.ndarray]
#: pairs that are examined together
_AT_ONCE = 50


def leading_pairs(
    spring: np.ndarray, damper: np.ndarray, allowed: np.ndarray, read: Heights, below: Heights,
    most: int,
) -> list[tuple[int, int]]:  # fmt: skip
    """Places of the `most` best of all allowed pairs (s, d) of k (s,) and z (d,), the best first.

    `below` gives a height that the peak of a pair cannot be below, which is cheap; `read` its peak.
    Pairs are examined by rising bounds, until the next one is above the last that is kept.
    """
    first, second = np.nonzero(allowed)
    bound = below(spring[first], damper[second])
    order = np.argsort(bound, kind="stable")
    found: list[tuple[float, int, int]] = []
    for start in range(0, len(order), _AT_ONCE):
        some = order[start : start + _AT_ONCE]
        if len(found) == most and bound[some[0]] > found[-1][0]:
            break
        peaks_of = read(spring[first[some]], damper[second[some]])
        found += zip(peaks_of.tolist(), first[some].tolist(), second[some].tolist(), strict=True)
        found = sorted(one for one in found if np.isfinite(one[0]))[:most]
    return [(i, j) for _, i, j in found]


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
    stiffness_ratios: np.ndarray, dampings: np.ndarray, free_peak: float, read: Read,
    response: str = "displacement", *, stiffness: tuple[float, float] = (0.0, np.inf),
    damping: tuple[float, float] = (0.0, np.inf), travel: float = np.inf,
) -> StockChoice:  # fmt: skip
    """Compare all pairs of stock springs k (s,) and oils z2 (o,) by the largest |H|.

    `read` gives the largest |H| of pairs and its error where not all frequencies count.

    `dampings` may be (s, o) where an oil's damping depends on the spring next to it. `free_peak` is
    the peak of the free optimum. Raises NumericalFailure where no pair has a finite peak within
    the limit of travel.
    """
    k, z = np.broadcast_arrays(stiffness_ratios[:, None], dampings)
    largest, slack = read(k, z, response)
    moved = read(k, z, "travel")[0]
    held = [
        (ratio >= low * (1.0 - _WITHIN)) & (ratio <= high * (1.0 + _WITHIN))
        for ratio, (low, high) in ((k, stiffness), (z, damping))
    ]
    inside = (moved <= travel * (1.0 + _WITHIN)) & np.isfinite(largest)
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
    height = np.where(allowed, largest, np.inf)
    ranking = np.argsort(height, axis=None, kind="stable")[: int(np.sum(allowed))]
    order = np.stack(np.unravel_index(ranking, height.shape), axis=-1)
    spring, oil = (int(place) for place in order[0])
    unsure = False
    if len(order) > 1:
        first, second = tuple(order[0]), tuple(order[1])
        unsure = bool(height[second] - height[first] <= slack[first] + slack[second])
    return StockChoice(
        largest, slack, moved, allowed, largest / free_peak - 1.0,
        spring, oil, order, unsure,
    )  # fmt: skip
