"""A rigid plate: what an instrument reads of its motion, amplitude maps, quietest places."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray

# ----------------------------------------------------------------------------
# What an instrument on a rigid plate reads of its translation, roll and pitch.
#
# The plate lies in the plane of x and y and moves little, along z: a point accelerates by
#
#     a(x, y) = a_0 + y alpha_x - x alpha_y
#
# with a_0 at the origin, the roll alpha_x about x and the pitch alpha_y about y, both right-handed
# (Herold 1977, eq. 43). For one harmonic they are complex amplitudes, the *motion* (a_0, alpha_x,
# alpha_y) in m/s^2 and rad/s^2. Every reading is a real *row* times the motion.
# ----------------------------------------------------------------------------

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
    step = np.asarray(second, dtype=float) - np.asarray(first, dtype=float)
    return np.stack([np.zeros_like(step[..., 0]), step[..., 1], -step[..., 0]], axis=-1)


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


# ----------------------------------------------------------------------------
# Where a moving plate moves least: maps, and the quietest point of a rectangle in closed form.
#
# The mean square of the acceleration, sum over harmonics of |a_0 + y alpha_x - x alpha_y|^2, is a
# convex quadratic in x and y: its least value in a rectangle is at its only stationary point or, if
# that lies outside, on one of the sides.
# ----------------------------------------------------------------------------


class Rectangle(NamedTuple):
    """Corners of a plate, m."""

    x_low: float
    x_high: float
    y_low: float
    y_high: float


class QuietPlace(NamedTuple):
    """A place (x, y) in m, and the root of the sum over harmonics of squared amplitudes there.

    `error` in m is that of the place, for the error of the signals that was given.
    """

    x: float
    y: float
    amplitude: float
    error: float


def grid(plate: Rectangle, points: int) -> tuple[FloatArray, FloatArray]:
    """Coordinates x (points,) and y (points,) from edge to edge."""
    x = np.linspace(plate.x_low, plate.x_high, points)
    y = np.linspace(plate.y_low, plate.y_high, points)
    return x, y


def amplitude_map(motions: ComplexArray, x: FloatArray, y: FloatArray) -> FloatArray:
    """Amplitudes (n, y, x) in m/s^2 of the motions (n, 3)."""
    rows = point_row(x[None, :], y[:, None])
    return np.asarray(np.abs(np.einsum("yxk,nk->nyx", rows, motions)))


def quietest(motions: ComplexArray, plate: Rectangle, signal_error: float = 0.0) -> QuietPlace:
    """The point of least mean square under the motions (n, 3) of some harmonics together.

    `signal_error` (m/s^2) is that of the acceleration anywhere on the plate. Where several places
    are as quiet (a roll alone), it is the one nearest to the middle of the plate.
    """
    # lengths count from the middle of the plate, in its half diagonal
    middle = np.array([0.5 * (plate.x_low + plate.x_high), 0.5 * (plate.y_low + plate.y_high)])
    half = np.array([plate.x_high, plate.y_high]) - middle
    length = float(np.hypot(*half))
    parts = np.concatenate([motions.real, motions.imag])
    slopes = np.stack([-parts[:, 2], parts[:, 1]], axis=1) * length
    value = parts @ point_row(*middle)
    solution, _, rank, sizes = np.linalg.lstsq(slopes, value, rcond=64.0 * EPSILON)
    inside, steepness = -solution, float(sizes[max(int(rank) - 1, 0)])
    bound = half / length
    if not np.all(np.abs(inside) <= bound * (1.0 + 8.0 * EPSILON)):
        inside, steepness = min(
            _on_sides(slopes, value, bound),
            key=lambda side: float(np.sum((value + slopes @ side[0]) ** 2)),
        )
    x, y = middle + length * np.clip(inside, -bound, bound)
    x = float(np.clip(x, plate.x_low, plate.x_high))
    y = float(np.clip(y, plate.y_low, plate.y_high))
    amplitude = float(np.linalg.norm(motions @ point_row(x, y)))
    off = signal_error + 4.0 * EPSILON * float(
        np.linalg.norm(parts @ np.array([1, length, length]))
    )
    share = off / steepness if steepness > 0.0 else 0.0
    error = length * share * (1.0 + (amplitude / steepness if steepness > 0.0 else 0.0))
    return QuietPlace(x, y, amplitude, min(error + 8.0 * EPSILON * length, 2.0 * length))


def _on_sides(
    slopes: FloatArray, value: FloatArray, bound: FloatArray
) -> list[tuple[FloatArray, float]]:
    """The quietest point of each side of the rectangle, and how steep the signals are along it."""
    places: list[tuple[FloatArray, float]] = []
    for fixed, free in ((0, 1), (1, 0)):
        steepness = float(slopes[:, free] @ slopes[:, free])
        for end in (-bound[fixed], bound[fixed]):
            at_end = value + slopes[:, fixed] * end
            along = -float(slopes[:, free] @ at_end) / steepness if steepness > 0.0 else 0.0
            place = np.empty(2)
            place[fixed] = end
            place[free] = np.clip(along, -bound[free], bound[free])
            places.append((place, steepness**0.5))
    return places
