"""Poles of a shaft line with any viscous damping: (s^2 J + s C + K) v = 0.

First guesses from a standard eigenvalue problem without the rigid motion: positions count from
one station of each ungrounded piece, and where nothing brakes a piece its momentum is zero. Each
guess is then mended on the pencil itself, s - v'P(s)v / v'P'(s)v, whose rounding is the error.
A slow real pole that the first guesses lose is sought at the elements that all but lock.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.response.torsion.damped_creep import creep_poles
from vibecalc.response.torsion.damped_state import (
    Matrices,
    line_matrices,
    resting,
    state_matrix,
    work_terms,
)
from vibecalc.response.torsion.line import Line

#: most rounds of inverse iteration on the pencil; a good guess takes two
_ROUNDS = 10


class DampedModes(NamedTuple):
    """m poles of n freedoms in rad/s: of each pair the one of positive imaginary part, and each
    real one.

    `pole` (m,) complex; `frequency` (m,) = its magnitude in rad/s, ascending, for a real pole
    too; `damping_ratio` (m,) = -Re / |pole|, 1 for a real pole that decays; a rigid motion has
    pole, frequency and ratio exactly 0, and so has a part that only dashpots hold, as a ring in
    oil: it stays where it is. `shape` (m, n) complex, largest component 1; `pole_error`
    (m,) in rad/s, absolute, on real and imaginary part together.
    """

    pole: ComplexArray
    frequency: FloatArray
    damping_ratio: FloatArray
    shape: ComplexArray
    pole_error: FloatArray


def damped_modes(line: Line) -> DampedModes:
    """Poles and complex shapes of a line without leading axes.

    Stations without inertia: undamped ones follow statics, damped ones add a real pole. An
    overdamped pair gives its two real poles. Raises `NumericalFailure` for loss factors, which
    make no real system in time; for a piece without inertia; for stations without inertia whose
    dampers only join each other; and for a pole that cannot be pinned down to four digits.
    """
    if np.any(line.loss_factor):
        raise NumericalFailure(
            "loss factors have no free motion in time: use the forced response, or give each "
            "shaft the viscous damping that equals its loss factor at one frequency"
        )
    count = len(line.inertia)
    matrices, rigid = line_matrices(line)
    guess = np.linalg.eigvals(state_matrix(matrices))
    still = resting(line)
    # what only dashpots hold stays where it is: poles of exactly zero, the smallest found
    guess = guess[np.argsort(np.abs(guess), kind="stable")][len(still) :]
    guess = guess[guess.imag >= 0.0]
    poles, shapes, errors = [], [], []
    lost = 0
    for value in guess.tolist():
        try:
            pole, shape, error = mended_pole(matrices, value)
        except NumericalFailure:
            if complex(value).imag:
                raise
            lost += 1
            continue
        if error > 1e-4 * abs(pole):
            if complex(value).imag == 0.0:
                lost += 1
                continue
            raise NumericalFailure(
                f"the pole near {pole:.6g} rad/s of the damped line cannot be pinned down: two "
                "poles nearly agree, or the damping is too strong for the stiffness"
            )
        nearest = int(np.argmin(np.abs(guess - pole)))
        if abs(guess[nearest] - value) > 1e-4 * abs(value):
            raise NumericalFailure(
                f"the pole near {value:.6g} rad/s of the damped line was lost to another one"
            )
        poles.append(pole)
        shapes.append(matrices.full @ shape)
        errors.append(error)
    for pole, shape, error in _slow(line, lost, poles):
        poles.append(pole)
        shapes.append(shape)
        errors.append(error)
    motions = [piece.astype(complex) for piece in (*rigid, *still)]
    all_poles = np.array([0.0j] * len(motions) + poles)
    every = np.array(motions + shapes).reshape(len(all_poles), count)
    largest = np.argmax(np.abs(every), axis=1)
    every /= every[np.arange(len(all_poles)), largest][:, None]
    size = np.abs(all_poles)
    ratio = np.divide(-all_poles.real, size, out=np.zeros_like(size), where=size > 0.0)
    order = np.lexsort((all_poles.imag, size))
    all_errors = np.array([0.0] * len(motions) + errors)
    return DampedModes(all_poles[order], size[order], ratio[order], every[order], all_errors[order])


def _slow(line: Line, lost: int, known: list[complex]) -> list[tuple[complex, ComplexArray, float]]:
    """So many poles of elements that all but lock, beside those known already."""
    if not lost:
        return []
    new = [one for one in creep_poles(line) if all(abs(one[0] - p) > 1e-4 * abs(p) for p in known)]
    if len(new) != lost:
        raise NumericalFailure(
            f"{lost} real poles of the damped line cannot be pinned down: some nearly agree, or "
            "the damping is too strong for the stiffness"
        )
    return new


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
