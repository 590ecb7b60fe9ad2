"""Forced response of a shaft line in long arithmetic, from the plain equations of motion."""

import mpmath as mp
import numpy as np

from vibecalc.torsion.line import Line


def exact_angles(line: Line, frequency: float, torque: np.ndarray) -> np.ndarray:
    """Angles (n,) rounded from 40 digits; long chains by recurrence, all else by LU."""
    n = line.inertia.shape[-1]
    w = mp.mpf(float(frequency))
    element = [
        mp.mpf(k) * mp.mpc(1, eta) + mp.mpc(0, 1) * w * mp.mpf(c)
        for k, eta, c in zip(
            line.stiffness.tolist(), line.loss_factor.tolist(), line.damping.tolist(), strict=True
        )
    ]
    diagonal = [
        mp.mpf(k) + mp.mpc(0, 1) * w * mp.mpf(c) - w**2 * mp.mpf(inertia)
        for k, c, inertia in zip(
            line.ground_stiffness.tolist(),
            line.absolute_damping.tolist(),
            line.inertia.tolist(),
            strict=True,
        )
    ]
    for e, (a, b) in enumerate(zip(line.first.tolist(), line.second.tolist(), strict=True)):
        diagonal[a] += element[e]
        diagonal[b] += element[e]
    right = [mp.mpc(complex(one)) for one in torque]
    if (
        n > 20
        and line.first.tolist() == list(range(n - 1))
        and line.second.tolist() == list(range(1, n))
    ):
        for i in range(1, n):
            ratio = element[i - 1] / diagonal[i - 1]
            diagonal[i] -= ratio * element[i - 1]
            right[i] += ratio * right[i - 1]
        right[-1] /= diagonal[-1]
        for i in range(n - 2, -1, -1):
            right[i] = (right[i] + element[i] * right[i + 1]) / diagonal[i]
        return np.array([complex(one) for one in right])
    matrix = mp.diag(diagonal)
    for e, (a, b) in enumerate(zip(line.first.tolist(), line.second.tolist(), strict=True)):
        matrix[a, b] -= element[e]
        matrix[b, a] -= element[e]
    return np.array([complex(one) for one in mp.lu_solve(matrix, mp.matrix(right))])
