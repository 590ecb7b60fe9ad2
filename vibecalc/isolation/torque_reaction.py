"""A couple on the body over a range of speeds, and which of its orders come near a mode."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.isolation.rows import EMPTY, HarmonicsAt, Jet
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, UNIT_ROUNDOFF
from vibecalc.response.modes import Modes
from vibecalc.response.torque_reaction import SLOWEST

#: relative step of speed of numerical derivatives
STEP = 1e-4
#: share of the largest modal force from which on an order is said to drive a mode
DRIVES = 1e-3


class NearestOrder(NamedTuple):
    """Of each mode the order nearest to it of those that drive it; 0 and infinite if none does.

    `margin` (modes,) is the frequency of that order over the natural frequency, less 1.
    """

    order: np.ndarray
    margin: np.ndarray
    margin_error: np.ndarray


def linear_couple(ends: np.ndarray, low: Bounded, high: Bounded) -> HarmonicsAt:
    """Couple (speeds, m) that is linear in the speed between two `ends`, given there (m,)."""
    span = ends[1] - ends[0]
    slope = (high.value - low.value) / span
    uncertainty = (low.error + high.error) / span

    def couple_at(speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Jet:
        share = ((speed - ends[0]) / span)[:, None]
        value = (1.0 - share) * low.value + share * high.value
        empty = np.zeros_like(value)
        error = (1.0 - share) * low.error + share * high.error + 4.0 * EPSILON * np.abs(value)
        return Jet(value, error, empty + slope, empty.real + uncertainty, empty)

    return couple_at


def couple_by_differences(
    by_speed: Callable[[np.ndarray], Bounded], low: float, high: float
) -> HarmonicsAt:
    """Couple of any law (speeds,) to (speeds, m) between two speeds, derivatives by differences.

    The differences are central, and next to the ends those of the nearest place that has room for
    them: the law is asked at no speed beyond `low` and `high`. The derivatives only lead a search
    for maxima: what they are off is in the error of the slope.
    """

    def couple_at(speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Jet:
        at = np.maximum(speed, SLOWEST)
        value, error = by_speed(at)
        if not slopes:
            return Jet(value, error, EMPTY, EMPTY, EMPTY)
        step = np.minimum(STEP * at, 0.25 * (high - low))
        middle = np.clip(at, low + 2.0 * step, high - 2.0 * step)
        far_before, before, here, after, far_after = (
            by_speed(np.clip(middle + steps * step, low, high)) for steps in range(-2, 3)
        )
        step, moved = step[:, None], (at - middle)[:, None]
        slope = (after.value - before.value) / (2.0 * step)
        curvature = (after.value - 2.0 * here.value + before.value) / np.square(step)
        wider = far_after.value - far_before.value
        uncertainty = np.abs(wider / (4.0 * step) - slope) + (after.error + before.error) / (
            2.0 * step
        )
        return Jet(value, error, slope + curvature * moved, uncertainty, curvature)

    return couple_at


def nearest_driven(
    shapes: Modes, loads: Bounded, half_order: np.ndarray, speed: float
) -> NearestOrder:
    """Which order comes nearest to each mode, of those of the loads (m, 6) that drive it.

    An order drives a mode if its modal force is no rounding, and a thousandth of the largest one.
    """
    force = loads @ shapes.bounded_shape
    size = np.abs(force.value)
    drives = (size > 4.0 * force.error) & (size >= DRIVES * size.max(axis=0))
    ratio = half_order[:, None] * speed / shapes.natural_frequency
    away = np.where(drives, np.abs(ratio - 1.0), np.inf)
    place = np.argmin(away, axis=0)
    modes = np.arange(len(place))
    none = np.isinf(away[place, modes])
    nearest = ratio[place, modes]
    uncertainty = shapes.natural_frequency_error / shapes.natural_frequency
    error = nearest * (uncertainty + 4.0 * UNIT_ROUNDOFF)
    return NearestOrder(
        np.where(none, 0.0, half_order[place]),
        np.where(none, np.inf, nearest - 1.0),
        np.where(none, 0.0, error),
    )
