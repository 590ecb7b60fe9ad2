"""A line with its damper in many digits: readings of one peak, their slopes and curvatures.

Absolute angles, elimination by mpmath, derivatives by differences of 10^-14 in 60 digits: none
of it is shared with the search, which works with twists and derivatives by hand.
"""

from typing import Any, NamedTuple

import mpmath
import numpy as np
from mpmath import mpf

from vibecalc.torsion.damper_design.problem import DamperProblem, harmonics

_STEP = mpf("1e-14")


class Peak(NamedTuple):
    """Reading, speed, phases of crest and trough, and whether the speed is an end of the range."""

    row: int
    speed: Any
    phase: tuple[Any, Any]
    held: bool


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

    def value(self, one: Peak, x: list[Any], speed: Any) -> Any:
        """Reading at logarithms x of J, k, c and at a speed, crest and trough followed."""
        damper = [mpmath.exp(entry) if entry is not None else mpf(0) for entry in x]
        course = self.course(one.row, damper, speed)
        if one.row == self.sections:
            power = sum(
                (order * speed * abs(a)) ** 2 for order, a in zip(self.order, course, strict=True)
            )
            return damper[2] * power / 2
        high, low = (self._extreme(course, phase) for phase in one.phase)
        if one.row == self.sections + 1:
            return high
        return -low if one.row == self.sections + 2 else (high - low) / 2

    def _extreme(self, course: list[Any], phase: Any) -> Any:
        for _ in range(7):
            wave = [a * mpmath.expj(h * phase) for a, h in zip(course, self.harmonic, strict=True)]
            first = -sum(h * u.imag for h, u in zip(self.harmonic, wave, strict=True))
            second = -sum(h**2 * u.real for h, u in zip(self.harmonic, wave, strict=True))
            step = first / second
            phase -= step
            if abs(step) < mpf("1e-35"):
                break
        turned = zip(course, self.harmonic, strict=True)
        return sum((a * mpmath.expj(h * phase)).real for a, h in turned)

    def derivatives(
        self, one: Peak, x: list[Any], free: list[int]
    ) -> tuple[Any, list[Any], list[list[Any]]]:
        """Value, slopes and curvatures by the free logarithms and, last, by speed over speed."""

        def at(move: dict[int, int]) -> Any:
            there, speed = list(x), one.speed
            for place, times in move.items():
                if place < len(free):
                    there[free[place]] += times * _STEP
                else:
                    speed = one.speed * (1 + times * _STEP)
            return self.value(one, there, speed)

        count = len(free) + 1
        middle = at({})
        up, down = ([at({i: side}) for i in range(count)] for side in (1, -1))
        slope = [(a - b) / (2 * _STEP) for a, b in zip(up, down, strict=True)]
        bend = [[mpf(0)] * count for _ in range(count)]
        for i in range(count):
            bend[i][i] = (up[i] - 2 * middle + down[i]) / _STEP**2
            for j in range(i):
                both = at({i: 1, j: 1}) + at({i: -1, j: -1}) + 2 * middle
                bend[i][j] = bend[j][i] = (both - up[i] - down[i] - up[j] - down[j]) / (
                    2 * _STEP**2
                )
        return middle, slope, bend

    def climbed(self, one: Peak, x: list[Any]) -> tuple[Any, Any]:
        """Highest value by speed next to a peak, and its speed."""
        for _ in range(8):
            if one.held:
                break
            _, slope, bend = self.derivatives(one, x, [])
            step = slope[0] / bend[0][0]
            one = one._replace(speed=one.speed * (1 - step))
            if abs(step) < mpf("1e-18"):
                break
        return self.value(one, x, one.speed), one.speed


def _add(matrix: Any, a: int, b: int, k: Any) -> None:
    matrix[a, a] += k
    matrix[b, b] += k
    matrix[a, b] -= k
    matrix[b, a] -= k
