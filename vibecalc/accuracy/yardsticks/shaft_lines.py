"""Shaft lines by plain methods, and in long arithmetic from their equations of motion."""

from typing import Any

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.response.torsion.graph import path_order, pieces
from vibecalc.response.torsion.line import (
    Line,
    damping_matrix,
    dynamic_stiffness,
    stiffness_matrix,
)
from vibecalc.response.torsion.modes import Modes

#: decimal digits of long arithmetic
DIGITS = 40


def exact_modes(line: Line) -> tuple[FloatArray, FloatArray]:
    """Frequencies (n,) in rad/s, ascending, and shapes (n, n), rounded from 40 digits.

    From the symmetric form of K and J; every freedom needs an inertia. Shapes as `as_shown`.
    """
    import mpmath

    n = len(line.inertia)
    with mpmath.workdps(DIGITS):
        root = [mpmath.sqrt(mpmath.mpf(j)) for j in line.inertia.tolist()]
        matrix = mpmath.zeros(n)
        for i, k in enumerate(line.ground_stiffness.tolist()):
            matrix[i, i] += mpmath.mpf(k)
        for a, b, k in zip(
            line.first.tolist(), line.second.tolist(), line.stiffness.tolist(), strict=True
        ):
            for i, j, sign in ((a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)):
                matrix[i, j] += sign * mpmath.mpf(k)
        for i in range(n):
            for j in range(n):
                matrix[i, j] /= root[i] * root[j]
        square, vector = mpmath.eigsy(matrix)
        frequency = [float(mpmath.sqrt(abs(one))) for one in square]
        shape = [[float(vector[i, m] / root[i]) for i in range(n)] for m in range(n)]
    return np.array(frequency), as_shown(np.array(shape))


def as_shown(shape: FloatArray) -> FloatArray:
    """Shapes (m, n) with a largest angle of 1; of several within a thousandth the first counts."""
    size = np.abs(shape)
    top = size.max(axis=1)
    first = np.argmax(size >= (1.0 - 1e-3) * top[:, None], axis=1)
    row = np.arange(len(shape))
    return np.asarray(shape / np.copysign(top, shape[row, first])[:, None])


def exact_angles(line: Line, frequency: FloatArray, torque: ComplexArray) -> ComplexArray:
    """Angles (m, n) for torques (m, n) at frequencies (m,) in rad/s, rounded from 40 digits.

    Elimination of one freedom after the other, whatever the network.
    """
    import mpmath

    rows = []
    with mpmath.workdps(DIGITS):
        for w, load in zip(frequency.tolist(), torque, strict=True):
            rows.append([complex(one) for one in _exact_row(line, mpmath.mpf(w), load)])
    return np.array(rows)


def _exact_row(line: Line, w: Any, load: ComplexArray) -> list[Any]:
    """One frequency, all in the numbers of mpmath; `rest` holds rows of what is not eliminated."""
    import mpmath

    turn = mpmath.mpc(0, 1)
    rest: list[dict[int, Any]] = []
    for j, c, k in zip(
        line.inertia.tolist(), line.absolute_damping.tolist(), line.ground_stiffness.tolist(),
        strict=True,
    ):  # fmt: skip
        rest.append({len(rest): mpmath.mpf(k) + turn * w * mpmath.mpf(c) - w * w * mpmath.mpf(j)})
    for a, b, k, c, loss in zip(
        line.first.tolist(), line.second.tolist(), line.stiffness.tolist(), line.damping.tolist(),
        line.loss_factor.tolist(), strict=True,
    ):  # fmt: skip
        element = mpmath.mpf(k) * (1 + turn * mpmath.mpf(loss)) + turn * w * mpmath.mpf(c)
        for i, j, sign in ((a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)):
            rest[i][j] = rest[i].get(j, mpmath.mpc(0)) + sign * element
    right = [mpmath.mpc(complex(one)) for one in load]
    for i, row in enumerate(rest):
        for j in [one for one in row if one > i]:
            factor = rest[j][i] / row[i]
            for column, value in row.items():
                if column > i:
                    rest[j][column] = rest[j].get(column, mpmath.mpc(0)) - factor * value
            right[j] -= factor * right[i]
    for i in range(len(rest) - 1, -1, -1):
        total = right[i] - sum(value * right[j] for j, value in rest[i].items() if j > i)
        right[i] = total / rest[i][i]
    return right


def dense_angles(line: Line, frequency: FloatArray, torque: ComplexArray) -> ComplexArray:
    """The same in double precision: one full matrix for each frequency."""
    try:
        found = np.linalg.solve(dynamic_stiffness(line, frequency), torque[..., None])
    except np.linalg.LinAlgError:
        raise NumericalFailure("the matrix of an order is singular") from None
    return np.asarray(found[..., 0])


def transfer_angles(line: Line, frequency: FloatArray, torque: ComplexArray) -> ComplexArray:
    """The same by 2 x 2 transfer matrices along a row, from a free end to the other.

    Angle and torque of each station are sums of what an angle of one at the first end does and of
    what the torques do; no torque may be left at the other end. Raises NumericalFailure for
    branches.
    """
    (piece, *others) = pieces(line)
    order = path_order(piece)
    if others or order is None:
        raise NumericalFailure("2 x 2 transfer matrices follow a row; this line has branches")
    place = {
        frozenset((a, b)): e
        for e, (a, b) in enumerate(zip(line.first.tolist(), line.second.tolist(), strict=True))
    }
    w = np.asarray(frequency)
    angle = np.zeros((2, *torque.shape), dtype=np.complex128)
    moved, held = np.zeros((2, 2, len(w)), dtype=np.complex128)
    moved[0] = 1.0
    for k, station in enumerate(order):
        angle[:, :, station] = moved
        own = line.ground_stiffness[station] + 1j * w * line.absolute_damping[station]
        held = held + (own - w**2 * line.inertia[station]) * moved
        held[1] -= torque[:, station]
        if k + 1 < len(order):
            e = place[frozenset((station, order[k + 1]))]
            shaft = line.stiffness[e] * (1.0 + 1j * line.loss_factor[e]) + 1j * w * line.damping[e]
            moved = moved + held / shaft
    return np.asarray(angle[1] - (held[1] / held[0])[:, None] * angle[0])


def modal_angles(
    line: Line, modes: Modes, count: int, frequency: FloatArray, torque: ComplexArray
) -> ComplexArray:
    """The same as a sum over the first `count` modes, what damping couples them by left out."""
    shape, w = modes.shape[:count], np.asarray(frequency)[:, None]
    loss = line._replace(damping=line.stiffness * line.loss_factor)
    loss = loss._replace(absolute_damping=np.zeros_like(line.inertia))
    own, lost = (
        np.einsum("mi,ij,mj->m", shape, damping_matrix(one), shape) for one in (line, loss)
    )
    natural = modes.frequency[:count]
    stiffness = modes.modal_inertia[:count] * (natural - w) * (natural + w)
    return np.asarray((torque @ shape.T / (stiffness + 1j * (w * own + lost))) @ shape)


def pole_angles(line: Line, frequency: FloatArray, torque: ComplexArray) -> ComplexArray:
    """The same by the eigenvalues and vectors of the state matrix, for dashpots alone."""
    if np.any(line.loss_factor):
        raise NumericalFailure("loss factors have no state matrix: it holds dashpots alone")
    n = len(line.inertia)
    matrix = np.zeros((2 * n, 2 * n))
    matrix[:n, n:] = np.eye(n)
    matrix[n:, :n] = -stiffness_matrix(line) / line.inertia[:, None]
    matrix[n:, n:] = -damping_matrix(line) / line.inertia[:, None]
    pole, right = np.linalg.eig(matrix)
    drive = np.linalg.solve(right, np.vstack([np.zeros((n, n)), np.diag(1.0 / line.inertia)]))
    part = (torque @ drive.T) / (1j * np.asarray(frequency)[:, None] - pole)
    return np.asarray(part @ right[:n].T)
