"""A line with its damper in many digits: absolute angles, elimination by mpmath.

None of it is shared with the search, which works with twists.
"""

from typing import Any

import mpmath
import numpy as np
from mpmath import mpf

from vibecalc.torsion.damper_design.problem import DamperProblem, harmonics


class ExactLine:
    """`problem` with exact arithmetic on its own numbers."""

    def __init__(self, problem: DamperProblem) -> None:
        self.problem, self.harmonic = problem, [int(h) for h in harmonics(problem)]
        self.order = [mpf(float(one)) for one in problem.order]
        self.sections = problem.line.stiffness.size

    def amplitudes(self, damper: list[Any], speed: Any) -> list[tuple[list[Any], Any]]:
        """Twist of every element, and hub less ring, for each order."""
        line, n = self.problem.line, self.problem.line.inertia.size
        found = []
        torque = self._torque(speed)
        for order, load in zip(self.order, torque, strict=True):
            w = order * speed
            matrix = mpmath.matrix(n + 1, n + 1)
            for i in range(n):
                ground, own = mpf(line.ground_stiffness[i]), mpf(line.absolute_damping[i])
                matrix[i, i] = ground + 1j * w * own - w**2 * mpf(line.inertia[i])
            matrix[n, n] = -(w**2) * damper[0]
            for e in range(self.sections):
                k = mpf(line.stiffness[e]) * (1 + 1j * mpf(line.loss_factor[e]))
                k += 1j * w * mpf(line.damping[e])
                _add(matrix, int(line.first[e]), int(line.second[e]), k)
            _add(matrix, self.problem.station, n, damper[1] + 1j * w * damper[2])
            angle = mpmath.lu_solve(matrix, mpmath.matrix([*load, 0]))
            twist = [
                angle[int(a)] - angle[int(b)] for a, b in zip(line.first, line.second, strict=True)
            ]
            found.append((twist, angle[self.problem.station] - angle[n]))
        return found

    def _torque(self, speed: Any) -> list[list[Any]]:
        torque = self.problem.torque
        piece = int(np.searchsorted(torque.knot, float(speed), side="right")) - 1
        piece = min(max(piece, 0), len(torque.coefficient) - 1)
        beyond = speed - mpf(float(torque.knot[piece]))
        parts = torque.coefficient[piece]
        return [
            [sum(mpmath.mpc(parts[j, m, i]) * beyond**j for j in range(len(parts)))
             for i in range(parts.shape[2])]
            for m in range(parts.shape[1])
        ]  # fmt: skip

    def course(self, row: int, damper: list[Any], speed: Any) -> list[Any]:
        """Amplitudes by order of what a section or the travel reads."""
        found = self.amplitudes(damper, speed)
        if row >= self.sections:
            return [relative for _, relative in found]
        line, weight = self.problem.line, mpf(float(self.problem.weight[row]))
        result = []
        for order, (twist, _) in zip(self.order, found, strict=True):
            factor = mpmath.mpc(1)
            if self.problem.quantity == "torque":
                k = mpf(line.stiffness[row]) * (1 + 1j * mpf(line.loss_factor[row]))
                factor = k + 1j * order * speed * mpf(line.damping[row])
            result.append(weight * factor * twist[row])
        return result


def _add(matrix: Any, a: int, b: int, k: Any) -> None:
    matrix[a, a] += k
    matrix[b, b] += k
    matrix[a, b] -= k
    matrix[b, a] -= k
