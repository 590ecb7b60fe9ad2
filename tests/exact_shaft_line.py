"""Forced response of a shaft line in long arithmetic, from the plain equations of motion."""

from typing import Any

import mpmath as mp
import numpy as np

from vibecalc.torsion.line import Line


def exact_angles(line: Line, frequency: float, torque: np.ndarray) -> np.ndarray:
    """Angles (n,) rounded from the caller's digits."""
    return np.array([complex(one) for one in _angles(line, frequency, torque)])


def exact_twists(line: Line, frequency: float, torque: np.ndarray) -> np.ndarray:
    """Twists (e,) of the elements, rounded after the difference."""
    angle = _angles(line, frequency, torque)
    ends = zip(line.first.tolist(), line.second.tolist(), strict=True)
    return np.array([complex(angle[a] - angle[b]) for a, b in ends])


def _angles(line: Line, frequency: float, torque: np.ndarray) -> list[Any]:
    w = mp.mpf(float(frequency))
    elements = zip(
        *(part.tolist() for part in (line.first, line.second)),
        *(part.tolist() for part in (line.stiffness, line.loss_factor, line.damping)),
        strict=True,
    )
    links = [(a, b, mp.mpf(k) * mp.mpc(1, eta) + mp.mpc(0, w) * c) for a, b, k, eta, c in elements]
    stations = zip(
        *(p.tolist() for p in (line.ground_stiffness, line.absolute_damping, line.inertia)),
        strict=True,
    )
    own = [mp.mpc(mp.mpf(k) - w**2 * j, w * c) for k, c, j in stations]
    right = [mp.mpc(complex(one)) for one in torque]
    return _solve(own, links, right)


def _solve(own: list[Any], links: list[tuple[int, int, Any]], right: list[Any]) -> list[Any]:
    """x of (diag(own) + sum over links z (e_a - e_b)(e_a - e_b)') x = right."""
    around = [dict[int, Any]() for _ in own]
    diagonal = list(own)
    for a, b, z in links:
        diagonal[a] += z
        diagonal[b] += z
        around[a][b] = around[a].get(b, 0) + z
        around[b][a] = around[b].get(a, 0) + z
    order, parent = _forest(around)
    if sum(map(len, around)) // 2 > sum(p >= 0 for p in parent):
        return _by_matrix(own, links, right)
    x = list(right)
    for s in reversed(order):
        p = parent[s]
        if p >= 0:
            if diagonal[s] == 0:  # a pendulum on its own order
                return _by_matrix(own, links, right)
            share = around[s][p] / diagonal[s]
            diagonal[p] -= share * around[s][p]
            x[p] = x[p] + share * x[s]
    for s in order:
        p = parent[s]
        x[s] = (x[s] + (around[s][p] * x[p] if p >= 0 else 0)) / diagonal[s]
    return x


def _by_matrix(own: list[Any], links: list[tuple[int, int, Any]], right: list[Any]) -> list[Any]:
    matrix = mp.diag(own)
    for a, b, z in links:
        matrix[a, a] += z
        matrix[b, b] += z
        matrix[a, b] -= z
        matrix[b, a] -= z
    return list(mp.lu_solve(matrix, mp.matrix(right)))


def _forest(around: list[dict[int, Any]]) -> tuple[list[int], list[int]]:
    """Freedoms from the roots on, and the parent of each (-1)."""
    parent, seen, order = [-1] * len(around), [False] * len(around), []
    for root in range(len(around)):
        if seen[root]:
            continue
        seen[root] = True
        queue = [root]
        for s in queue:
            for other in around[s]:
                if not seen[other]:
                    seen[other], parent[other] = True, s
                    queue.append(other)
        order += queue
    return order, parent
