"""Where the open loop has gain one, and how far its phase then is from -180 degrees."""

import math
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.response.roll_control.model import Loop

_TURN = 2.0 * math.pi


class Crossings(NamedTuple):
    """Up to two frequencies (..., 2) with |L| = 1, ascending in neither; see `present`.

    `frequency` (rad/s, positive; 1.0 where absent) and its absolute `frequency_error`;
    `critical` in [0, 2 pi): the lag w T of a delay T that would bring L to -1, delay not counted;
    `slack` in [0, 2 pi): lag that is still allowed beside the loop's own delay; `phase_error`
    belongs to both. `outward`: +1 where roots cross to the right as the delay grows, else -1,
    0 where they only touch the axis.
    """

    present: np.ndarray
    frequency: np.ndarray
    frequency_error: np.ndarray
    critical: np.ndarray
    slack: np.ndarray
    phase_error: np.ndarray
    outward: np.ndarray


def crossings(loop: Loop) -> Crossings:
    """Positive roots x = w^2 of |P(i w)|^2 - |Q(i w)|^2, a quadratic that no delay changes."""
    wide = Loop(*(a[..., None] for a in loop))
    p2, p1, p0, q1, q0, delay = wide
    a = p2 * p2
    b = p1 * p1 - 2.0 * p0 * p2 - q1 * q1
    c = p0 * p0 - q0 * q0
    size_b = p1 * p1 + 2.0 * np.abs(p0 * p2) + q1 * q1
    size_c = p0 * p0 + q0 * q0
    unsure = 16.0 * UNIT_ROUNDOFF

    square = b * b - 4.0 * a * c
    doubt = unsure * (size_b * size_b + 4.0 * a * size_c)
    square = np.where(np.abs(square) <= doubt, 0.0, square)
    side = -0.5 * (b + np.where(b < 0.0, -1.0, 1.0) * np.sqrt(np.maximum(square, 0.0)))
    with np.errstate(divide="ignore", invalid="ignore"):
        x = np.concatenate(np.broadcast_arrays(side / a, c / side), axis=-1)
    present = (square >= 0.0) & np.isfinite(x) & (x > 0.0)
    x = np.where(present, x, 1.0)
    w = np.sqrt(x)

    slope = 2.0 * a * x + b
    residual = unsure * ((a * x + size_b) * x + size_c)
    with np.errstate(divide="ignore", invalid="ignore"):
        x_error = np.minimum(
            np.where(slope == 0.0, np.inf, residual / np.abs(slope)),
            np.where(a == 0.0, np.inf, 2.0 * np.sqrt(residual / a)),
        )
    x_error = np.where(present, np.minimum(x_error, x), 0.0)
    w_error = x_error / w + UNIT_ROUNDOFF * w

    own = np.arctan2(q1 * w, q0) - np.arctan2(p1 * w, p0 - p2 * x)
    critical = np.mod(math.pi + own, _TURN)
    slack = np.mod(math.pi + own - w * delay, _TURN)
    turning = np.abs(phase_slope(wide, w))
    phase_error = turning * w_error + 8.0 * UNIT_ROUNDOFF * (_TURN + w * delay)
    outward = np.where(present, np.sign(np.where(square == 0.0, 0.0, slope)), 0.0)
    return Crossings(present, w, w_error, critical, slack, phase_error, outward)


def phase_slope(loop: Loop, w: np.ndarray) -> np.ndarray:
    """Slope by frequency (s) of the phase of the open loop at w (rad/s), which broadcasts."""
    p2, p1, p0, q1, q0, delay = loop
    x = w * w
    with np.errstate(divide="ignore", invalid="ignore"):
        above = np.where(q0 * q1 == 0.0, 0.0, q1 * q0 / (q0 * q0 + q1 * q1 * x))
    below = p1 * (p0 + p2 * x) / (np.square(p0 - p2 * x) + p1 * p1 * x)
    slope: np.ndarray = above - below - delay
    return slope


def open_loop(loop: Loop, frequency: np.ndarray) -> np.ndarray:
    """L(i w) at frequencies (..., m) in rad/s; the loop's own shape is (...)."""
    p2, p1, p0, q1, q0, delay = (a[..., None] for a in loop)
    s = 1j * np.asarray(frequency)
    value: np.ndarray = (q1 * s + q0) * np.exp(-s * delay) / ((p2 * s + p1) * s + p0)
    return value
