"""The motion of a plate from complex amplitudes: weighted least squares, done in several ways."""

from typing import NamedTuple

import numpy as np

from vibecalc.machine.measurement import Harmonic
from vibecalc.measurement.complex_motion import complex_motion
from vibecalc.numerics.typing import ComplexArray, FloatArray

_DIGITS = 40


class Phasors(NamedTuple):
    """Rows (r, 3), readings (r,) complex, half widths and deviations (r,) of each part of them."""

    rows: FloatArray
    readings: ComplexArray
    half_widths: FloatArray
    deviations: FloatArray


def phasors_of(harmonic: Harmonic) -> Phasors:
    """What one harmonic reads with phases."""
    solving = harmonic.solving
    return Phasors(
        np.array([read.row for read in solving]),
        np.array([read.amplitude * np.exp(1j * (read.phase or 0.0)) for read in solving]),
        np.array([read.half_width for read in solving]),
        np.array([read.deviation for read in solving]),
    )


def by_singular_values(given: Phasors) -> ComplexArray:
    """As a run does: scaled by the largest lever, by singular values."""
    return complex_motion(*given).motion


def by_lstsq(given: Phasors) -> ComplexArray:
    """numpy's least squares, one unit beside another."""
    left = given.rows / given.deviations[:, None]
    return np.asarray(np.linalg.lstsq(left, given.readings / given.deviations, rcond=None)[0])


def by_normal_equations(given: Phasors) -> ComplexArray:
    """The textbook's way, which squares the condition number."""
    weighed = given.rows.T / given.deviations**2
    return np.asarray(np.linalg.solve(weighed @ given.rows, weighed @ given.readings))


def in_digits(given: Phasors) -> ComplexArray:
    """The same in 40 digits, of which the squares may well take half."""
    import mpmath as mp

    with mp.workdps(_DIGITS):
        left, right = mp.matrix(3, 3), mp.matrix(3, 1)
        for row, reading, deviation in zip(
            given.rows, given.readings, given.deviations, strict=True
        ):
            weight = 1 / mp.mpf(float(deviation)) ** 2
            entries = [mp.mpf(float(c)) for c in row]
            for i, c in enumerate(entries):
                right[i] += weight * c * mp.mpc(complex(reading))
                for j, d in enumerate(entries):
                    left[i, j] += weight * c * d
        found = mp.lu_solve(left, right)
        return np.array([complex(found[k]) for k in range(3)])
