"""How fast two runs part company that start next to each other."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray

#: distance that counts as apart, as a part of the clearance
APART = 0.1
#: distance at which two runs are one to rounding
TOGETHER = 1024.0 * EPSILON


class Parting(NamedTuple):
    """Of each pair (...,): `revolutions` until it is apart, infinite if that is not within the
    run; `rate`, the growth of the logarithm of its distance per revolution until then."""

    revolutions: FloatArray
    rate: FloatArray


def distance(
    gap: FloatArray, velocity: FloatArray, clearance: FloatArray, fastest: FloatArray
) -> FloatArray:
    """Distance (...) of pairs from differences (..., G) of their gaps and gap velocities.

    In parts of the clearance, and of the velocity `fastest` with which it is crossed; the
    largest counts.
    """
    apart = np.maximum(np.abs(gap) / clearance, np.abs(velocity) / fastest)
    return np.asarray(np.max(apart, axis=-1))


def parting(distances: FloatArray) -> Parting:
    """When pairs part, from distances (..., T + 1) at the start and at the ends of T revolutions.

    Between two ends the distance is taken to grow as an exponential. A pair that has become one
    to rounding has a rate that is only a bound: it shrank at least so fast.
    """
    turns = distances.shape[-1] - 1
    level = np.log(np.maximum(distances, TOGETHER))
    beyond = distances >= APART
    parted = np.any(beyond, axis=-1)
    # the first end beyond, or the last end
    end = np.where(parted, np.argmax(beyond, axis=-1), turns)
    before = np.maximum(end - 1, 0)
    at_end = np.take_along_axis(level, end[..., None], axis=-1)[..., 0]
    at_before = np.take_along_axis(level, before[..., None], axis=-1)[..., 0]
    rise = np.where(at_end > at_before, at_end - at_before, 1.0)
    crossed = before + np.clip((np.log(APART) - at_before) / rise, 0.0, 1.0)
    revolutions = np.where(parted, np.where(end == 0, 0.0, crossed), np.inf)
    rate = (at_end - level[..., 0]) / np.maximum(end, 1)
    return Parting(np.asarray(revolutions), np.asarray(rate))
