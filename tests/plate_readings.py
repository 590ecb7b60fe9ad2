"""Readings on plates whose motion is known, and the source's own closed form."""

from typing import NamedTuple

import numpy as np

from vibecalc.measurement.plate import difference_row, point_row
from vibecalc.numerics.rounding import ComplexArray, FloatArray

#: positions of Herold (1977) in m; the corners are where the source takes 5 and 6 to be
PLACES = {
    "1": (0.5493, -0.2699),
    "2": (0.5493, 0.2699),
    "3": (0.0270, -0.2381),
    "4": (0.0270, 0.2381),
    "5": (-0.5493, -0.2794),
    "6": (-0.5493, 0.2794),
    "corner 5": (-0.5493, -0.2699),
    "corner 6": (-0.5493, 0.2699),
}
#: A1, A2, A5, A12, A15 in dB re 1e-5 m/s^2, by harmonic (Table 1)
LEVELS = {
    1: (104.0, 108.7, 103.0, 111.2, 100.2),
    2: (107.3, 104.2, 101.5, 102.0, 102.3),
    3: (86.9, 81.5, 85.4, 88.5, 80.0),
}


class Plate(NamedTuple):
    """Rows (r, 3), the motion (3,) and the amplitudes (r,) that it gives there."""

    rows: FloatArray
    motion: ComplexArray
    amplitudes: FloatArray


def source_rows(fifth: str = "corner 5") -> FloatArray:
    """Rows of A1, A2, A5, A12, A15."""
    one, two, five = PLACES["1"], PLACES["2"], PLACES[fifth]
    points = [point_row(*place) for place in (one, two, five)]
    return np.stack([*points, difference_row(one, two), difference_row(one, five)])


def by_the_source(levels: FloatArray, sign: float) -> ComplexArray:
    """Motion by Herold's eqs. 11, 21, 27, 32, 33; `sign` is that of the phase of alpha_y."""
    first, second, fifth, across, along = 1e-5 * 10.0 ** (np.asarray(levels) / 20.0)
    y_21 = PLACES["2"][1] - PLACES["1"][1]
    x_15 = PLACES["1"][0] - PLACES["corner 5"][0]
    alpha_x, alpha_y = across / abs(y_21), along / abs(x_15)
    phase_x = np.arccos((second**2 - first**2 - across**2) / (2.0 * first * y_21 * alpha_x))
    phase_y = np.arccos((fifth**2 - first**2 - along**2) / (2.0 * first * x_15 * alpha_y))
    roll, pitch = alpha_x * np.exp(1j * phase_x), alpha_y * np.exp(1j * sign * phase_y)
    x_1, y_1 = PLACES["1"]
    return np.array([first - y_1 * roll + x_1 * pitch, roll, pitch])


def random_plate(seed: int, points: int, differences: int) -> Plate:
    """A motion of random phases, read at random points and between some of them."""
    random = np.random.default_rng(seed)
    places = random.uniform(-1.0, 1.0, (points + differences + 1, 2))
    rows = [point_row(*place) for place in places[:points]]
    rows += [difference_row(places[0], places[1 + n]) for n in range(differences)]
    motion = random.normal(size=3) + 1j * random.normal(size=3)
    stacked = np.stack(rows)
    return Plate(stacked, motion, np.abs(stacked @ motion))


def moments(motion: ComplexArray) -> FloatArray:
    """What levels can tell of a motion."""
    return np.real(np.multiply.outer(motion, np.conj(motion)))


def apart(one: ComplexArray, other: ComplexArray) -> float:
    """Largest difference of second moments, over the largest of them."""
    size = np.max(np.abs(moments(one)))
    return float(np.max(np.abs(moments(one) - moments(other))) / size)
