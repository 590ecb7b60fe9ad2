"""One pole of a shaft line with any viscous damping, (s^2 J + s C + K) v = 0, from a guess of it.

The guess is mended on the pencil itself, s - v'P(s)v / v'P'(s)v, whose rounding is the error.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.response.torsion.damped_state import Matrices, work_terms

#: most rounds of inverse iteration on the pencil; a good guess takes two
_ROUNDS = 10


class DampedModes(NamedTuple):
    """m poles of n freedoms in rad/s, one for each undamped mode.

    `frequency` (m,) = |pole|; `damping_ratio` (m,) = -Re / |pole|, 0 for a rigid motion; `shape`
    (m, n) complex, largest component 1; `pole_error` (m,) in rad/s, absolute, on real and imaginary
    part together.
    """

    pole: ComplexArray
    frequency: FloatArray
    damping_ratio: FloatArray
    shape: ComplexArray
    pole_error: FloatArray


def mended_pole(matrices: Matrices, guess: complex) -> tuple[complex, ComplexArray, float]:
    """A pole, its shape on the kept stations, and what rounding leaves open of the pole.

    P is symmetric, so the left vector is the right one. A step that goes further than the guess
    may be off is not taken: the pole is then one of a cluster, and the error says so. A last step
    above round-off counts in the error: beside another pole the way is long.
    """
    inertia = matrices.inertia
    pole, moved = guess, 0.0
    shape = np.ones(len(inertia), dtype=complex) * np.exp(1j * np.arange(len(inertia)))
    for _ in range(_ROUNDS):
        shape = _inverse_iteration(matrices, pole, shape)
        shape /= shape[np.argmax(np.abs(shape))]
        if guess.imag == 0.0:
            shape = shape.real.astype(complex)
        work, slope, rounding = work_terms(matrices, pole, shape)
        if abs(work) >= 0.1 * abs(pole * slope):
            moved = 0.0
            break
        pole -= work / slope
        moved = abs(work)
        if moved <= rounding:
            moved = 0.0
            break
    work, slope, rounding = work_terms(matrices, pole, shape)
    curvature = abs(shape**2 @ inertia)
    rest = rounding + abs(work) + moved
    linear = rest / abs(slope) if slope != 0.0 else np.inf
    double = np.sqrt(rest / curvature) if curvature > 0.0 else np.inf
    # two nearly equal poles: the error cannot grow beyond that of a double one
    return pole, shape, float(min(linear, 2.0 * double))


def _inverse_iteration(matrices: Matrices, pole: complex, shape: ComplexArray) -> ComplexArray:
    """A shape after two solves with P a few roundings beside a pole, further off where singular."""
    for roundings in (4.0, 4e3, 4e6, 4e9):
        near = pole + roundings * EPSILON * abs(pole)
        pencil = near**2 * np.diag(matrices.inertia) + near * matrices.damping + matrices.stiffness
        try:
            for _ in range(2):
                shape = np.linalg.solve(pencil, shape / np.max(np.abs(shape)))
                for held, unbraked in matrices.free:
                    if unbraked:  # no momentum: nothing of the rigid motion in it
                        inertia = matrices.inertia[held]
                        shape[held] -= (inertia @ shape[held]) / inertia.sum()
            return shape
        except np.linalg.LinAlgError:
            continue
    raise NumericalFailure(f"the damped line is singular at every frequency near {pole:.6g} rad/s")
