"""Torque on the stations of a line as a smooth function of speed, with its slope."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import ComplexArray, FloatArray


class SpeedTorque(NamedTuple):
    """Piecewise polynomials: `knot` (p + 1,) in rad/s, `coefficient` (p, d + 1, m, n) in N m.

    In the piece that begins at knot[i] the torque of order m on freedom n is
    sum_j coefficient[i, j, m, n] (speed - knot[i])^j; complex, 0-to-peak.
    """

    knot: FloatArray
    coefficient: ComplexArray


def torque_at(torque: SpeedTorque, speed: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """Torque and its derivative by speed, (s, m, n) each, at speeds (s,)."""
    piece = np.searchsorted(torque.knot, speed, side="right") - 1
    piece = np.clip(piece, 0, len(torque.coefficient) - 1)
    beyond = (speed - torque.knot[piece])[:, None, None]
    parts = torque.coefficient[piece]
    value, slope = np.zeros_like(parts[:, 0]), np.zeros_like(parts[:, 0])
    for power in range(parts.shape[1] - 1, -1, -1):
        slope = slope * beyond + value
        value = value * beyond + parts[:, power]
    return value, slope
