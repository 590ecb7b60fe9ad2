"""Exact motion of the slider-crank, at given crank angles, with an optional wrist pin offset.

The wrist pin runs on a line at a distance e (`wrist_pin_offset`) from the crank axis, on the side
of a crank angle of 90 degrees. Its position counts from the crank axis outwards along that line:

    s = R cos t + sqrt(L^2 - (R sin t - e)^2).

Derivatives are by the crank angle t; times w and w^2 they are velocity and acceleration at a
constant speed w.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.twofold import two_sum
from vibecalc.numerics.typing import FloatArray


class Motion(NamedTuple):
    """Wrist pin position and its derivatives by the crank angle, in metres, with errors.

    The errors are absolute, one per entry, for the inputs as stored.
    """

    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    position_error: FloatArray
    velocity_error: FloatArray
    acceleration_error: FloatArray


class Path(NamedTuple):
    """Wrist pin position and its derivatives by the crank angle, with the rod's projection, m."""

    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    rod: FloatArray


def piston_path(
    crank_angle: ArrayLike,
    crank_radius: ArrayLike,
    rod_length: ArrayLike,
    wrist_pin_offset: ArrayLike = 0.0,
) -> Path:
    """As `piston_motion`, without the errors: for what evaluates it many times."""
    angle, radius, length, offset = _floats(crank_angle, crank_radius, rod_length, wrist_pin_offset)
    sine, cosine = np.sin(angle), np.cos(angle)
    height, lever = radius * sine, radius * cosine
    if offset.any():
        rod = rod_projection(sine, cosine, radius, length, offset)
        pull = (height - offset) / rod
    else:
        # L^2 - R^2 sin^2 as a sum: nothing cancels, whatever R/L
        rod = np.sqrt((length - radius) * (length + radius) + lever * lever)
        pull = height / rod
    swing = lever * length
    return Path(
        position=lever + rod,
        velocity=-height - lever * pull,
        acceleration=height * pull - lever - swing * swing / (rod * rod * rod),
        rod=rod,
    )


def piston_motion(
    crank_angle: ArrayLike,
    crank_radius: ArrayLike,
    rod_length: ArrayLike,
    wrist_pin_offset: ArrayLike = 0.0,
) -> Motion:
    """Position of the wrist pin, and its first two derivatives by the crank angle.

    Parameters
    ----------
    crank_angle : array, rad
        From the crank's position along the cylinder axis.
    crank_radius, rod_length, wrist_pin_offset : arrays that broadcast, m
        R, L and e with R + |e| < L.

    Returns
    -------
    Motion
        Arrays of the common shape. Errors are some units in the last place of the largest term of
        each formula. The rod's projection keeps its relative accuracy where it almost vanishes
        (R/L near 1, crank near 90 degrees), so that the large accelerations there keep theirs.
    """
    angle, radius, length, offset = _floats(crank_angle, crank_radius, rod_length, wrist_pin_offset)
    sine, cosine = np.sin(angle), np.cos(angle)
    across = radius * sine - offset
    rod = rod_projection(sine, cosine, radius, length, offset)
    lever = radius * cosine
    pull = across / rod
    tilt = radius * sine * pull
    swing = (lever * length) * (lever * length) / (rod * rod * rod)
    pull_size = (np.abs(radius * sine) + np.abs(offset)) / rod
    return Motion(
        position=lever + rod,
        velocity=-radius * sine - lever * pull,
        acceleration=-lever + tilt - swing,
        position_error=4.0 * EPSILON * (np.abs(lever) + rod),
        velocity_error=4.0 * EPSILON * (np.abs(radius * sine) + np.abs(lever) * pull_size),
        acceleration_error=8.0
        * EPSILON
        * (np.abs(lever) + np.abs(radius * sine) * pull_size + swing),
    )


def rod_projection(
    sine: FloatArray,
    cosine: FloatArray,
    radius: FloatArray,
    length: FloatArray,
    offset: FloatArray,
) -> FloatArray:
    """Length of the rod along the cylinder axis, sqrt(L^2 - (R sin t - e)^2), without cancellation.

    L -/+ (R sin t - e) is formed as (L - R +/- e) + R (1 -/+ sin t), with 1 - |sin t| as
    cos^2 t / (1 + |sin t|).
    """
    clearance, clearance_low = two_sum(length, -radius)
    shorter = radius * cosine * cosine / (1.0 + np.abs(sine))
    longer = radius * (1.0 + np.abs(sine))
    behind = clearance + offset + clearance_low + np.where(sine > 0.0, shorter, longer)
    ahead = clearance - offset + clearance_low + np.where(sine > 0.0, longer, shorter)
    return np.asarray(np.sqrt(behind * ahead))


def _floats(*values: ArrayLike) -> tuple[FloatArray, ...]:
    return tuple(np.asarray(value, dtype=np.float64) for value in values)
