"""Statistics of an ensemble: C clearances, M members each, R revolutions of each member.

Members start apart and are independent; the revolutions of one member follow from each other.
So every standard error comes from the scatter of members, and none of them depends on the order
in which members stand.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import FloatArray


class Statistic(NamedTuple):
    """A statistic and its standard error, arrays of one shape, in the unit of what it is made of.

    The standard error of a quantity that is the same in all revolutions is zero.
    """

    value: FloatArray
    standard_error: FloatArray


def mean_over_runs(values: FloatArray) -> Statistic:
    """Mean (C, ...) of values (C, M, R, ...); its error from the M means of members."""
    of_member = np.mean(values, axis=2)
    return Statistic(np.mean(of_member, axis=1), standard_error(of_member))


def standard_error(of_member: FloatArray) -> FloatArray:
    """Standard error (C, ...) of a mean over members (C, M, ...), M at least 2."""
    members = of_member.shape[1]
    return np.asarray(np.std(of_member, axis=1, ddof=1) / np.sqrt(members))


def quantiles(values: FloatArray, shares: tuple[float, ...]) -> tuple[Statistic, ...]:
    """Quantiles (C, ...) of values (C, M, R, ...) over members and revolutions, one per share.

    The error of a quantile q: the share of values below q has a standard error s between members,
    and q moves by half the distance of the quantiles at share - s and share + s. Source: R. S.
    Woodruff (1952), for samples that come in clusters. Values may be infinite.
    """
    shape = values.shape
    count = shape[1] * shape[2]
    ordered = np.sort(values.reshape(shape[0], count, *shape[3:]), axis=1)
    found = []
    for share in shares:
        middle = _at(ordered, np.full((shape[0], *shape[3:]), share))
        below = np.mean(values <= middle[:, None, None], axis=2)
        doubt = standard_error(below)
        low, high = (_at(ordered, np.clip(share + s * doubt, 0.0, 1.0)) for s in (-1.0, 1.0))
        found.append(Statistic(middle, _half_distance(low, high)))
    return tuple(found)


def _at(ordered: FloatArray, share: FloatArray) -> FloatArray:
    """Quantiles (C, ...) of ordered values (C, n, ...) at shares (C, ...), straight between."""
    place = share * (ordered.shape[1] - 1)
    first = np.floor(place).astype(np.int64)
    second = np.minimum(first + 1, ordered.shape[1] - 1)
    low = np.take_along_axis(ordered, first[:, None], axis=1)[:, 0]
    high = np.take_along_axis(ordered, second[:, None], axis=1)[:, 0]
    weight = place - first
    # an infinite neighbour counts only with a weight of its own
    step = np.zeros_like(low)
    np.subtract(high, low, out=step, where=np.isfinite(low) & (weight > 0.0))
    return np.asarray(low + np.multiply(weight, step, where=weight > 0.0, out=np.zeros_like(low)))


def _half_distance(low: FloatArray, high: FloatArray) -> FloatArray:
    """(high - low) / 2, zero between infinities and infinite beside one."""
    step = np.zeros_like(low)
    np.subtract(high, low, out=step, where=np.isfinite(low))
    return 0.5 * step
