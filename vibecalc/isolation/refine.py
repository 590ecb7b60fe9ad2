"""Bisection of a run-up curve until straight lines between its points are good enough."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.response.singular import Masked

#: no interval is cut below this relative width
_NARROWEST = 1e-14

#: beside a pole without bound the curve is resolved relative to itself
_NEAR_POLE = 0.02


class Curve(NamedTuple):
    """Ascending speeds (speeds,), values (speeds, rows), intervals left unresolved by the cap."""

    speed: np.ndarray
    value: np.ndarray
    unresolved: int


def resolve(
    curve_at: Callable[[np.ndarray], np.ndarray],
    speed: np.ndarray,
    masked: Masked,
    infinite: np.ndarray,
    tolerance: float,
    most_points: int,
) -> Curve:
    """Add midpoints until each is within `tolerance` of the chord, of each row's maximum.

    Parameters
    ----------
    curve_at : rows at speeds, (speeds,) to (speeds, rows).
    speed : ascending first speeds, none inside a masked interval.
    infinite : (rows,) rows that have no bound within the range; the maximum that counts for
        them is that of the speeds well away from the masked intervals.
    """
    value = curve_at(speed)
    left, right = np.arange(len(speed) - 1), np.arange(1, len(speed))
    open_left, open_right = speed[left], speed[right]
    low_value, high_value = value[left], value[right]
    all_speed, all_value = [speed], [value]
    total = len(speed)
    scale = _scale(speed, value, masked, infinite)
    while True:
        wide = open_right - open_left > _NARROWEST * open_right
        if len(masked.centre):
            across = (open_left[:, None] < masked.centre) & (open_right[:, None] > masked.centre)
            wide &= ~np.any(across, axis=1)
        open_left, open_right = open_left[wide], open_right[wide]
        low_value, high_value = low_value[wide], high_value[wide]
        room = most_points - total
        if not len(open_left) or len(open_left) > room:
            break
        middle = 0.5 * (open_left + open_right)
        middle_value = curve_at(middle)
        all_speed.append(middle)
        all_value.append(middle_value)
        total += len(middle)
        scale = np.maximum(scale, np.where(infinite, 0.0, np.max(middle_value, axis=0)))
        chord = 0.5 * (low_value + high_value)
        allowed = tolerance * scale + np.where(infinite, _NEAR_POLE * middle_value, 0.0)
        poor = np.any(np.abs(middle_value - chord) > allowed, axis=1)
        open_left = np.concatenate([open_left[poor], middle[poor]])
        open_right = np.concatenate([middle[poor], open_right[poor]])
        low_value, high_value = (
            np.concatenate([low_value[poor], middle_value[poor]]),
            np.concatenate([middle_value[poor], high_value[poor]]),
        )
    merged = np.concatenate(all_speed)
    ascending = np.argsort(merged, kind="stable")
    return Curve(merged[ascending], np.concatenate(all_value)[ascending], len(open_left))


def _scale(
    speed: np.ndarray, value: np.ndarray, masked: Masked, infinite: np.ndarray
) -> np.ndarray:
    """Largest value of each row that the tolerance is relative to."""
    top: np.ndarray = np.max(value, axis=0)
    if not np.any(infinite):
        return top
    away = np.all(np.abs(speed[:, None] - masked.centre) > 0.01 * masked.centre, axis=1)
    if not np.any(away):
        return top
    return np.where(infinite, np.max(value[away], axis=0), top)
