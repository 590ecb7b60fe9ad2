"""What an instrument on a rigid plate reads of its translation, roll and pitch.

The plate lies in the plane of x and y and moves little, along z: a point accelerates by

    a(x, y) = a_0 + y alpha_x - x alpha_y

with a_0 at the origin, the roll alpha_x about x and the pitch alpha_y about y, both right-handed
(Herold 1977, eq. 43). For one harmonic they are complex amplitudes, the *motion* (a_0, alpha_x,
alpha_y) in m/s^2 and rad/s^2. Every reading is a real *row* times the motion.
"""

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.typing import FloatArray

#: parts of the motion that are kept: name -> factors of translation, roll and pitch
PARTS: dict[str, tuple[float, float, float]] = {
    "standard": (1.0, 1.0, 1.0),
    "no_roll": (1.0, 0.0, 1.0),
    "no_pitch": (1.0, 1.0, 0.0),
    "only_roll": (0.0, 1.0, 0.0),
    "only_pitch": (0.0, 0.0, 1.0),
    "only_translation": (1.0, 0.0, 0.0),
}


def point_row(x: ArrayLike, y: ArrayLike) -> FloatArray:
    """Rows (..., 3) of the acceleration of points at x, y (m)."""
    across, along = np.broadcast_arrays(np.asarray(y, dtype=float), np.asarray(x, dtype=float))
    return np.stack([np.ones_like(across), across, -along], axis=-1)


def difference_row(first: ArrayLike, second: ArrayLike) -> FloatArray:
    """Rows (..., 3) of the acceleration of the second point less that of the first.

    Points are (..., 2) in m. Over its distance this is the angular accelerometer of Herold's
    eqs. 1 to 3: the translation has no part in it.
    """
    way = np.asarray(second, dtype=float) - np.asarray(first, dtype=float)
    return np.stack([np.zeros_like(way[..., 0]), way[..., 1], -way[..., 0]], axis=-1)


def rotation_row(direction: ArrayLike) -> FloatArray:
    """Rows (..., 3) of the angular acceleration about a direction (..., 2) in the plane."""
    axis = np.asarray(direction, dtype=float)
    axis = axis / np.linalg.norm(axis, axis=-1, keepdims=True)
    return np.stack([np.zeros_like(axis[..., 0]), axis[..., 0], axis[..., 1]], axis=-1)


def span_of(rows: FloatArray) -> float:
    """A length that makes rows of points comparable: their largest coordinate, or 1 m."""
    levers = np.abs(rows[..., 1:][rows[..., 0] != 0.0])
    largest = float(np.max(levers)) if levers.size else 0.0
    return largest if largest > 0.0 else 1.0


def scaled(rows: FloatArray, span: float) -> FloatArray:
    """Rows for the motion (a_0, span alpha_x, span alpha_y), all in m/s^2."""
    return np.asarray(rows / np.array([1.0, span, span]))
