"""Steady torque that the elements of a line carry, from the mean torques at its freedoms."""

import numpy as np

from vibecalc.numerics.typing import FloatArray
from vibecalc.response.torsion.line import Line, stiffness_matrix


def steady_shares(line: Line) -> FloatArray:
    """Torque (e, n) of each element for a mean torque of one at each freedom of a line at rest.

    With mean torques M (n,) that balance, shares @ M is k (phi[first] - phi[second]). In a tree
    that nothing holds, or one spring to ground, which has nothing to carry then, equilibrium alone
    tells it (shares of 0 and 1, without rounding), else the stiffnesses do. An element without
    stiffness carries nothing.
    """
    count, elements = len(line.inertia), len(line.stiffness)
    neighbours: list[list[tuple[int, int]]] = [[] for _ in range(count)]
    springs = np.flatnonzero(line.stiffness).tolist()
    for e in springs:
        a, b = int(line.first[e]), int(line.second[e])
        neighbours[a].append((b, e))
        neighbours[b].append((a, e))
    order, above = _walked(neighbours)
    held = np.count_nonzero(line.ground_stiffness)
    if len(springs) > sum(edge >= 0 for _, edge in above) or held > 1:
        inverse = np.linalg.pinv(stiffness_matrix(line), hermitian=True)
        twist = inverse[line.first] - inverse[line.second]
        return np.asarray(line.stiffness[:, None] * twist)
    below = np.eye(count)
    shares = np.zeros((elements, count))
    for station in reversed(order):
        parent, edge = above[station]
        if edge >= 0:
            # what stands below an element is kept in balance by it
            shares[edge] = below[station] * (1.0 if line.first[edge] == station else -1.0)
            below[parent] += below[station]
    return shares


def _walked(
    neighbours: list[list[tuple[int, int]]],
) -> tuple[list[int], list[tuple[int, int]]]:
    """Freedoms, each after the one it hangs on, with that one and the element between (or -1)."""
    above = [(-1, -1)] * len(neighbours)
    seen = [False] * len(neighbours)
    order: list[int] = []
    for root in range(len(neighbours)):
        if seen[root]:
            continue
        seen[root] = True
        queue = [root]
        for station in queue:
            for other, edge in neighbours[station]:
                if not seen[other]:
                    seen[other] = True
                    above[other] = (station, edge)
                    queue.append(other)
        order += queue
    return order, above
