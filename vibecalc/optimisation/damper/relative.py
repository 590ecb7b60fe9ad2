"""A line with its ring in relative coordinates: one angle, and twists instead of the others.

At low frequency a free line turns as one body, and the twist, a small difference of large angles,
would lose digits. Here the twists are the unknowns, and stiffness enters on the diagonal alone.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import ComplexArray, FloatArray, IntArray
from vibecalc.optimisation.damper.problem import Damper, Problem, harmonics
from vibecalc.response.torsion.line import Line


class System(NamedTuple):
    """n freedoms and the ring: unknowns are one angle, n - 1 twists, and hub less ring (last).

    `angle` (n, n + 1) and `twist` (e, n + 1) give angles and twists from the unknowns, `ring`
    (n + 1,) the ring's angle. `mass`, `loss`, `spring` (n + 1, n + 1) are the line's own.
    """

    problem: Problem
    harmonic: IntArray
    angle: FloatArray
    twist: FloatArray
    ring: FloatArray
    mass: FloatArray
    loss: FloatArray
    spring: ComplexArray

    def dynamic(self, damper: Damper, frequency: FloatArray) -> ComplexArray:
        """Dynamic stiffness (..., n + 1, n + 1) with the damper at frequencies (...) in rad/s."""
        w = frequency[..., None, None]
        mass = self.mass + damper.inertia * np.outer(self.ring, self.ring)
        matrix: ComplexArray = np.asarray(
            self.spring + 1j * w * self.loss - w**2 * mass, dtype=np.complex128
        )
        matrix[..., -1, -1] += damper.stiffness + 1j * frequency * damper.damping
        return matrix


def system_of(problem: Problem) -> System:
    """Raises NumericalFailure for a line in several pieces."""
    line = problem.line
    angle = _spanning(line)
    station = problem.station
    n = line.inertia.size
    angle = np.hstack([angle, np.zeros((n, 1))])
    twist = angle[line.first] - angle[line.second]
    ring = angle[station].copy()
    ring[-1] = -1.0

    def whole(element: FloatArray, ground: FloatArray) -> FloatArray:
        matrix: FloatArray = (twist.T * element) @ twist + (angle.T * ground) @ angle
        return matrix

    none = np.zeros(n)
    return System(
        problem, harmonics(problem), angle, twist, ring,
        whole(np.zeros(line.stiffness.size), line.inertia),
        whole(line.damping, line.absolute_damping),
        whole(line.stiffness, line.ground_stiffness)
        + 1j * whole(line.stiffness * line.loss_factor, none),
    )  # fmt: skip


def _spanning(line: Line) -> FloatArray:
    """Angles (n, n) of the freedoms from the angle of one and n - 1 twists: entries 0, 1, -1.

    That one is held most or heaviest, so that what is summed over the others stays small. The
    stiffest elements are taken into the tree first, so that a loop is measured by the others.
    """
    n = line.inertia.size
    group = np.arange(n)
    beside: list[list[tuple[int, float]]] = [[] for _ in range(n)]
    for e in np.argsort(-line.stiffness, kind="stable"):
        a, b = int(line.first[e]), int(line.second[e])
        if group[a] != group[b]:
            group[group == group[b]] = group[a]
            beside[a].append((b, -1.0))
            beside[b].append((a, 1.0))
    if np.any(group != group[0]):
        raise NumericalFailure("a damper is tuned on one line; this one is in several pieces")
    angle = np.zeros((n, n))
    held = line.ground_stiffness if np.any(line.ground_stiffness > 0.0) else line.inertia
    root = int(np.argmax(held))
    angle[root, 0] = 1.0
    seen, waiting, column = {root}, [root], 1
    while waiting:
        a = waiting.pop()
        for b, sign in beside[a]:
            if b not in seen:
                # twist first - second: phi_b = phi_a - twist where a comes first
                angle[b] = angle[a]
                angle[b, column] += sign
                seen.add(b)
                waiting.append(b)
                column += 1
    return angle
