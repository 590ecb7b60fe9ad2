"""Frequencies of a row of inertias as singular values of a bidiagonal factor.

K = L P L' with pivots p_i = k_i + S_i, where S_i is the stiffness to ground of all that lies
before shaft i: S_1 = g_1, S_(i+1) = g_(i+1) + S_i k_i / (S_i + k_i). Nothing is subtracted, so
every entry of the upper bidiagonal factor P^(1/2) L' J^(-1/2), with sqrt(p_i / J_i) on and
-k_i / sqrt(p_i J_(i+1)) above the diagonal, is right to a few roundings, and so are all its
singular values, the smallest like the largest (Demmel and Kahan 1990). LAPACK finds them by the
differential qd algorithm (Fernando and Parlett 1994), which keeps that accuracy; its reduction
to bidiagonal form leaves a matrix that has this form as it is. A free row ends with the pivot 0.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import FloatArray
from vibecalc.response.torsion.modes_qd import bidiagonal_singular_values


class Row(NamedTuple):
    """Inertias (n,), springs to ground (n,), and shafts (n - 1,) between neighbours."""

    inertia: FloatArray
    ground: FloatArray
    stiffness: FloatArray


def bidiagonal_factor(row: Row) -> FloatArray:
    """The upper bidiagonal factor (n, n) in rad/s; its singular values are the frequencies."""
    count = len(row.inertia)
    root = np.sqrt(row.inertia)
    pivot, above = np.empty(count), row.stiffness
    if row.ground.any():
        before = 0.0
        for index, (k, g) in enumerate(zip(row.stiffness.tolist(), row.ground.tolist()[:-1])):  # noqa: B905
            before += g
            pivot[index] = k + before
            before *= k / pivot[index]
        pivot[-1] = before + row.ground[-1]
        above = row.stiffness / np.sqrt(pivot[:-1]) if count > 1 else above
    else:
        pivot[:-1], pivot[-1] = row.stiffness, 0.0
        above = np.sqrt(row.stiffness)
    factor = np.zeros((count, count))
    factor.reshape(-1)[:: count + 1] = np.sqrt(pivot) / root
    factor.reshape(-1)[1 :: count + 1] = -above / root[1:]
    return factor


def row_frequencies(factor: FloatArray, free: bool) -> FloatArray:
    """Frequencies (n,) in rad/s, ascending, of a bidiagonal factor; the rigid one exactly 0."""
    frequency: FloatArray = bidiagonal_singular_values(factor)[::-1].copy()
    if free:
        frequency[0] = 0.0
    return frequency
