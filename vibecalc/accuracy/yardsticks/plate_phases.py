"""The motion of a plate from complex amplitudes: weighted least squares, done in several ways."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibecalc.measurement.complex_motion import Phasors, along_and_across, complex_motion
from vibecalc.numerics.typing import ComplexArray, FloatArray

_DIGITS = 40


def by_singular_values(given: Phasors) -> ComplexArray:
    """As a run does: scaled by the largest lever, by singular values."""
    return complex_motion(given).motion


def by_lstsq(given: Phasors) -> ComplexArray:
    """numpy's least squares, one unit beside another."""
    return _motion(np.linalg.lstsq(*_weighed(given), rcond=None)[0])


def by_normal_equations(given: Phasors) -> ComplexArray:
    """The textbook's way, which squares the condition number."""
    left, right = _weighed(given)
    return _motion(np.linalg.solve(left.T @ left, left.T @ right))


def _weighed(given: Phasors) -> tuple[FloatArray, FloatArray]:
    """Rows (2 r, 6) on the parts of the motion, and what is read, both over deviations."""
    weights = 1.0 / np.ravel(given.deviations)
    read = np.concatenate([np.abs(given.readings), np.zeros(len(given.rows))])
    return along_and_across(given.rows, given.readings) * weights[:, None], read * weights


def _motion(parts: NDArray[np.floating[Any]]) -> ComplexArray:
    return np.asarray(parts[:3] + 1j * parts[3:])


def in_digits(given: Phasors) -> ComplexArray:
    """The same in 40 digits, of which the squares may well take half."""
    import mpmath as mp

    with mp.workdps(_DIGITS):
        left, right = mp.matrix(6, 6), mp.matrix(6, 1)
        for row, reading, deviations in zip(
            given.rows, given.readings, given.deviations.T, strict=True
        ):
            phasor = mp.mpc(complex(reading))
            unit = phasor / abs(phasor) if phasor else mp.mpf(1)
            entries = [mp.mpf(float(c)) for c in row]
            along = [c * unit.real for c in entries] + [c * unit.imag for c in entries]
            across = [-c * unit.imag for c in entries] + [c * unit.real for c in entries]
            for slopes, read, deviation in (
                (along, abs(phasor), deviations[0]), (across, mp.mpf(0), deviations[1]),
            ):  # fmt: skip
                weight = 1 / mp.mpf(float(deviation)) ** 2
                for i, c in enumerate(slopes):
                    right[i] += weight * c * read
                    for j, d in enumerate(slopes):
                        left[i, j] += weight * c * d
        found = mp.lu_solve(left, right)
        return np.array([complex(found[k] + 1j * found[3 + k]) for k in range(3)])
