"""Dead centres of the slider-crank, its stroke, and the way of the piston from top dead centre.

At a dead centre crank and rod lie along one line through the crank axis: stretched at the top,
folded at the bottom. With an offset e neither is at a multiple of 180 degrees, and the stroke is a
little longer than 2 R.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.kinematics.slider_crank import rod_projection
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray


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
    radius, length, offset = _floats(crank_radius, rod_length, wrist_pin_offset)
    return _dead_centre(length + radius, offset, np.zeros_like(offset))


def bottom_dead_centre(
    crank_radius: ArrayLike, rod_length: ArrayLike, wrist_pin_offset: ArrayLike = 0.0
) -> DeadCentre:
    """Where the piston is farthest in: pi + arcsin(e/(L - R))."""
    radius, length, offset = _floats(crank_radius, rod_length, wrist_pin_offset)
    return _dead_centre(length - radius, offset, np.full_like(offset, np.pi))


def stroke(
    crank_radius: ArrayLike, rod_length: ArrayLike, wrist_pin_offset: ArrayLike = 0.0
) -> FloatArray:
    """Way between the dead centres, m: 4 L R over the sum of both positions, 2 R without offset.

    Relative error 1e-15, unless R + |e| is within a few per cent of L.
    """
    radius, length, offset = _floats(crank_radius, rod_length, wrist_pin_offset)
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
    angle, radius, length, offset = _floats(crank_angle, crank_radius, rod_length, wrist_pin_offset)
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


def _floats(*values: ArrayLike) -> tuple[FloatArray, ...]:
    arrays = (np.asarray(value, dtype=np.float64) for value in values)
    return tuple(np.broadcast_arrays(*arrays))
