"""Harmonic balance of small deviations with periodic coefficients: all orders in one system.

With d = sum_p d_p exp(i p w t) over orders p = k / turns of both signs, row p of the system is

    (K_p + i p w C) d_p + sum_q [-(q w)^2 a_{p-q} + i q w b_{p-q} + s_{p-q}] d_q = gap_p,

a, b and s the harmonics of inertia, its rate and the stiffness (variable_inertia_motion). About
uniform turning the bracket is -w^2 (p^2 + q^2) / 2 J_{p-q}, symmetric in the two orders. A piece
without ground stiffness has its mean angle at zero (that sets the origin of the time) and a steady
torque of the load as the unknown instead.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import ComplexArray, FloatArray, IntArray
from vibecalc.response.torsion.line import damping_matrix, network_matrix
from vibecalc.response.torsion.variable_inertia import VariableLine, free_pieces
from vibecalc.response.torsion.variable_inertia_motion import Terms

_PATTERNS = 4
_SAFETY = 4.0


class Blocks(NamedTuple):
    """Steps k (P,) of both signs, matrix (P, m, P, m), right side (P, m), border (m, r) twice.

    `size` (P, m, m) is how large the terms are that the diagonal blocks were formed of.
    """

    step: IntArray
    matrix: ComplexArray
    gap: ComplexArray
    load: FloatArray
    origin: FloatArray
    size: FloatArray


class Solved(NamedTuple):
    """Inner d (Q, m); round-off and truncation (Q, m), absolute; orders just beyond (P - Q, m)."""

    value: ComplexArray
    rounding: FloatArray
    truncation: FloatArray
    beyond: ComplexArray


def two_sided(samples: FloatArray, highest: int) -> ComplexArray:
    """Harmonics (2 highest + 1, n), -highest first, of samples (S, n) over one cycle."""
    spectrum = np.fft.fft(samples, axis=0) / len(samples)
    return np.asarray(spectrum[np.arange(-highest, highest + 1)])


def two_sided_angle(angle: ComplexArray, highest: int) -> ComplexArray:
    """The same from one-sided 0-to-peak harmonics (N + 1, n)."""
    both = np.zeros((2 * highest + 1, angle.shape[1]), dtype=np.complex128)
    count = len(angle)
    both[highest : highest + count] = 0.5 * angle
    both[highest - count + 1 : highest + 1][::-1] += 0.5 * angle.conj()
    return both


def shaft_matrices(system: VariableLine, speed: float, step: IntArray) -> ComplexArray:
    """K (1 + i loss factor sign p) + i p w C (P, n, n) at the orders p = step / turns."""
    line = system.line
    loss = line.stiffness * (1.0 + 1j * np.sign(step)[:, None] * line.loss_factor)
    elastic = network_matrix(line, loss, line.ground_stiffness.astype(np.complex128))
    frequency = (1j * speed / system.turns) * step[:, None, None]
    return np.asarray(elastic + frequency * damping_matrix(line))


def station_values(
    system: VariableLine, speed: float, parts: Terms, step: IntArray
) -> ComplexArray:
    """The bracket (P, P, n) of the rows and columns `step`, from samples over the cycle."""
    span = int(step[-1] - step[0])
    inertia, rate, stiffness = (two_sided(part, span) for part in parts[:3])
    apart = step[:, None] - step + span
    turn = (1j * speed / system.turns * step)[:, None]
    return np.asarray(turn**2 * inertia[apart] + turn * rate[apart] + stiffness[apart])


def blocks(
    system: VariableLine,
    speed: float,
    parts: Terms,
    angle: ComplexArray,
    step: IntArray,
    basis: FloatArray,
) -> Blocks:
    """The system of the steps (P,), rising and of both signs, in the shapes `basis` (m, n).

    Steps left out must not be coupled with those taken.
    """
    highest = max(int(np.abs(step).max()), len(angle) - 1)
    shafts = shaft_matrices(system, speed, step)
    about = two_sided_angle(angle, highest)[step + highest]
    gap = two_sided(parts.gap, highest)[step + highest] - (shafts @ about[..., None])[..., 0]
    pairs = (basis[:, None] * basis).reshape(-1, basis.shape[1])
    values = station_values(system, speed, parts, step) @ pairs.T
    count = len(basis)
    matrix = values.reshape(*values.shape[:2], count, count).transpose(0, 2, 1, 3)
    place = np.arange(len(step))
    matrix = np.ascontiguousarray(matrix)
    matrix[place, :, place, :] += basis @ shafts @ basis.T
    free = free_pieces(system.line)[: len(basis[0]) if np.any(step == 0) else 0]
    load, origin = (basis @ (free * part).T for part in (system.load, system.line.inertia))
    inertial = (speed / system.turns * step)[:, None] ** 2 * np.abs(parts.inertia).max(axis=0)
    large, wide = np.abs(shafts), np.abs(basis)
    index = np.arange(basis.shape[1])
    large[:, index, index] += inertial
    return Blocks(step, matrix, gap @ basis.T, load, origin, wide @ large @ wide.T)


def solve(found: Blocks, highest: int, size: FloatArray) -> Solved | None:
    """Orders to `highest` (steps), what rounding does to them, and what the orders beyond do.

    Orders beyond are driven by those inside and act back on them once: three times that is the
    estimate of the truncation. `size` (Q, m) says how large the terms of the right side are.
    None if the matrix is singular to working precision.
    """
    inside = np.abs(found.step) <= highest
    matrix, count = _bordered(found, inside)
    inner, outer = found.matrix[inside], found.matrix[~inside]
    solver = _factored(matrix)
    if solver is None:
        return None

    def answer(right: ComplexArray) -> ComplexArray:
        padded = np.zeros((len(matrix), right.shape[1]), dtype=np.complex128)
        padded[:count] = right
        found_ = solver(padded)
        return np.asarray(found_ + solver(padded - matrix @ found_))

    shape = (int(inside.sum()), found.gap.shape[1])
    value = answer(found.gap[inside].reshape(-1, 1))[:, 0]
    own_size = found.size[inside] @ np.abs(value[:count]).reshape(*shape, 1)
    size = size + own_size[..., 0]
    term = EPSILON * (
        np.abs(matrix) @ np.abs(value) + np.append(size, np.zeros(len(value) - count))
    )
    index = np.arange(1, count + 1)[:, None]
    signs = np.where(np.sin(index * np.sqrt([2.0, 3.0, 5.0, 7.0][:_PATTERNS])) > 0.0, 1.0, -1.0)
    spread = answer((signs * term[:count, None]).astype(np.complex128))[:count]
    rounding = _SAFETY * np.sqrt((np.abs(spread) ** 2).sum(axis=1)).reshape(shape)
    value = value[:count]
    if not outer.size:
        return Solved(value.reshape(shape), rounding, np.zeros(shape), found.gap[:0])
    driven = found.gap[~inside].reshape(-1) - outer[:, :, inside].reshape(-1, count) @ value
    own = outer[:, :, ~inside].reshape(len(driven), -1)
    beyond = np.asarray(np.linalg.solve(own, driven), dtype=np.complex128)
    back = inner[:, :, ~inside].reshape(count, -1) @ beyond
    truncation = 3.0 * np.abs(answer(back[:, None])[:count, 0])
    return Solved(
        value.reshape(shape), rounding, truncation.reshape(shape), beyond.reshape(-1, shape[1])
    )


def _bordered(found: Blocks, inside: np.ndarray) -> tuple[ComplexArray, int]:
    """Inner matrix with the load's torque and the origin of the time at order 0."""
    inner = found.matrix[inside][:, :, inside]
    count = inner.shape[0] * inner.shape[1]
    pieces = found.load.shape[1]
    matrix = np.zeros((count + pieces, count + pieces), dtype=np.complex128)
    matrix[:count, :count] = inner.reshape(count, count)
    if pieces:
        start = int(np.flatnonzero(found.step[inside] == 0)[0]) * inner.shape[1]
        place = slice(start, start + inner.shape[1])
        scale = np.abs(matrix).max()
        matrix[place, count:] = -scale * found.load / np.abs(found.load).max(axis=0)
        matrix[count:, place] = scale * (found.origin / np.abs(found.origin).max(axis=0)).T
    return matrix, count


def _factored(matrix: ComplexArray):  # type: ignore[no-untyped-def]
    """A solver by LU with pivoting, or None if a pivot is zero."""
    from scipy.linalg.lapack import zgetrf, zgetrs

    factor, pivot, wrong = zgetrf(matrix)
    if wrong:
        return None

    def solver(right: ComplexArray) -> ComplexArray:
        return np.asarray(zgetrs(factor, pivot, right)[0])

    return solver
