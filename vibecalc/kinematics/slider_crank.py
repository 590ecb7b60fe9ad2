"""Exact motion of the slider-crank at given crank angles, its dead centres and its stroke."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.rounding import EPSILON, FloatArray, two_sum

# ----------------------------------------------------------------------------
# Exact motion of the slider-crank, at given crank angles, with an optional wrist pin offset.
#
# The wrist pin runs on a line at a distance e (`wrist_pin_offset`) from the crank axis, on the side
# of a crank angle of 90 degrees. Its position counts from the crank axis outwards along that line:
#
#     s = R cos t + sqrt(L^2 - (R sin t - e)^2).
#
# Derivatives are by the crank angle t; times w and w^2 they are velocity and acceleration at a
# constant speed w.
# ----------------------------------------------------------------------------


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


# ----------------------------------------------------------------------------
# Dead centres of the slider-crank, its stroke, and the way of the piston from top dead centre.
#
# At a dead centre crank and rod lie along one line through the crank axis: stretched at the top,
# folded at the bottom. With an offset e neither is at a multiple of 180 degrees, and the stroke is
# a little longer than 2 R.
# ----------------------------------------------------------------------------


class DeadCentre(NamedTuple):
    """Crank angle (rad) and wrist pin position (m) at a dead centre, with absolute errors."""

    angle: FloatArray
    position: FloatArray
    angle_error: FloatArray
    position_error: FloatArray


class Displacement(NamedTuple):
    """Way of the piston from top dead centre, m, and its absolute error."""

    value: FloatArray
    error: FloatArray


def top_dead_centre(
    crank_radius: ArrayLike, rod_length: ArrayLike, wrist_pin_offset: ArrayLike = 0.0
) -> DeadCentre:
    """Where the piston is farthest out: arcsin(e/(L + R)), within 90 degrees of zero."""
    radius, length, offset = _dead_centres_floats(crank_radius, rod_length, wrist_pin_offset)
    return _dead_centre(length + radius, offset, np.zeros_like(offset))


def bottom_dead_centre(
    crank_radius: ArrayLike, rod_length: ArrayLike, wrist_pin_offset: ArrayLike = 0.0
) -> DeadCentre:
    """Where the piston is farthest in: pi + arcsin(e/(L - R))."""
    radius, length, offset = _dead_centres_floats(crank_radius, rod_length, wrist_pin_offset)
    return _dead_centre(length - radius, offset, np.full_like(offset, np.pi))


def stroke(
    crank_radius: ArrayLike, rod_length: ArrayLike, wrist_pin_offset: ArrayLike = 0.0
) -> FloatArray:
    """Way between the dead centres, m: 4 L R over the sum of both positions, 2 R without offset.

    Relative error 1e-15, unless R + |e| is within a few per cent of L.
    """
    radius, length, offset = _dead_centres_floats(crank_radius, rod_length, wrist_pin_offset)
    outer = top_dead_centre(radius, length, offset).position
    inner = bottom_dead_centre(radius, length, offset).position
    return np.asarray(4.0 * length * radius / (outer + inner))


def piston_displacement(
    crank_angle: ArrayLike,
    crank_radius: ArrayLike,
    rod_length: ArrayLike,
    wrist_pin_offset: ArrayLike = 0.0,
) -> Displacement:
    """Way of the piston from top dead centre, positive towards the crank.

    Parameters
    ----------
    crank_angle : array, rad
        Crank angle t.
    crank_radius, rod_length, wrist_pin_offset : arrays that broadcast, m
        R, L and e with R + |e| < L.

    Returns
    -------
    Displacement
        From the turns t - t0 of the crank and psi of the rod since top dead centre t0,
        x = 2 (R sin^2((t - t0)/2) + L sin^2(psi/2)) / cos t0: a sum of squares, so that the
        relative accuracy stays at a tiny way, up to the rounding of t0 itself. (Own derivation.)
    """
    angle, radius, length, offset = _dead_centres_floats(
        crank_angle, crank_radius, rod_length, wrist_pin_offset
    )
    start = top_dead_centre(radius, length, offset)
    sine, cosine = np.sin(angle), np.cos(angle)
    rod = rod_projection(sine, cosine, radius, length, offset)
    rod_angle = np.arctan2(radius * sine - offset, rod)
    half_turn = np.sin(0.5 * (angle - start.angle))
    # L (sin rod_angle - sin rod_angle_0) = R (sin t - sin t0), in half angles
    half_swing = (radius / length) * half_turn * np.cos(0.5 * (angle + start.angle))
    half_swing = half_swing / np.cos(0.5 * (rod_angle - start.angle))
    value = 2.0 * (radius * half_turn**2 + length * half_swing**2) / np.cos(start.angle)
    slope = 2.0 * radius * np.abs(half_turn) / np.cos(start.angle)
    error = 16.0 * EPSILON * value + slope * (start.angle_error + EPSILON * np.abs(start.angle))
    return Displacement(np.asarray(value), np.asarray(error))


def _dead_centre(reach: FloatArray, offset: FloatArray, turned: FloatArray) -> DeadCentre:
    """Dead centre with the wrist pin at the distance `reach` from the crank axis."""
    ratio = offset / reach
    position = np.sqrt((reach - offset) * (reach + offset))
    angle = np.arcsin(ratio)
    angle_error = EPSILON * (np.abs(angle) + 2.0 * np.abs(offset) / position)
    inexact = reach * np.abs(offset) / (position * position)
    return DeadCentre(
        angle=turned + angle,
        position=position,
        angle_error=angle_error + EPSILON * turned,
        position_error=EPSILON * (2.0 * position + inexact * np.abs(offset)),
    )


def _dead_centres_floats(*values: ArrayLike) -> tuple[FloatArray, ...]:
    arrays = (np.asarray(value, dtype=np.float64) for value in values)
    return tuple(np.broadcast_arrays(*arrays))
