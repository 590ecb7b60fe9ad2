"""A couple on the body over a range of speeds, and which of its orders come near a mode."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.isolation.rows import HarmonicsAt, Jet
from vibecalc.numerics.bounded import Bounded, where
from vibecalc.response.modes import Modes
from vibecalc.response.torque_reaction import SLOWEST

if TYPE_CHECKING:
    from vibecalc.response.adapters.torque_couple import TorqueLaw

#: relative step of speed of numerical derivatives
STEP = 1e-4
#: share of the largest modal force from which on an order is said to drive a mode
DRIVES = 1e-3


def couple_between(law: "TorqueLaw", low: float, high: float) -> HarmonicsAt:
    """Couple (speeds, m) that the shaking lacks, between two speeds of gas cards."""
    by_law = linear_couple if law.passing is None else couple_by_differences
    return by_law(law.lacking_at, low, high)


def linear_couple(
    by_speed: Callable[[np.ndarray], Bounded], low: float, high: float
) -> HarmonicsAt:
    """Couple (speeds, m) of a law (speeds,) to (speeds, m) that is linear between two speeds."""
    span, ends = high - low, by_speed(np.array([low, high]))
    slope = (ends.value[1] - ends.value[0]) / span
    uncertainty = ends.error.sum(0) / span

    def couple_at(speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Jet:
        share = ((speed - low) / span)[:, None]
        value, error = ends[0] * (1.0 - share) + ends[1] * share
        empty = np.zeros_like(value)
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
            return Jet(value, error)
        step = np.minimum(STEP * at, 0.25 * (high - low))
        middle = np.clip(at, low + 2.0 * step, high - 2.0 * step)
        far_before, before, here, after, far_after = (
            by_speed(np.clip(middle + steps * step, low, high)) for steps in range(-2, 3)
        )
        step, moved = step[:, None], (at - middle)[:, None]
        slope, uncertainty = (after - before) / (2.0 * step)
        wider = (far_after.value - far_before.value) / (4.0 * step)
        curvature = (after.value - 2.0 * here.value + before.value) / np.square(step)
        uncertainty = uncertainty + np.abs(wider - slope)
        return Jet(value, error, slope + curvature * moved, uncertainty, curvature)

    return couple_at


def nearest_driven(
    shapes: Modes, loads: Bounded, order: np.ndarray, speed: float
) -> tuple[np.ndarray, Bounded]:
    """Of each mode the order nearest to it, of those of the loads (m, 6) that drive it, 0 if none
    does; and the frequency of that order over the natural frequency, less 1, or infinite.

    An order drives a mode if its modal force is no rounding, and a thousandth of the largest one.
    """
    force = loads @ shapes.bounded_shape
    size = np.abs(force.value)
    drives = (size > 4.0 * force.error) & (size >= DRIVES * size.max(axis=0))
    ratio = (order * speed)[:, None] / shapes.bounded_frequency
    away = np.where(drives, np.abs(ratio.value - 1.0), np.inf)
    place = np.argmin(away, axis=0)
    modes = np.arange(len(place))
    none = np.isinf(away[place, modes])
    margin = where(none, np.inf, ratio[place, modes] - 1.0)
    return np.where(none, 0.0, order[place]), margin
