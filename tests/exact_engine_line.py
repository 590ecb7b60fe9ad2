"""A shaft line in long arithmetic: own values of the case, speed ratios, modes, poles, response.

Names, freedoms and the order of the sections are those of the built line; every number is formed
anew from the case. Trees are eliminated from their leaves, loops solved as full matrices.
"""

from itertools import pairwise
from typing import Any

import mpmath
import numpy as np
from mpmath import mp, mpc, mpf

from vibecalc.schema import Case
from vibecalc.torsion.model import build_shaft_line
from vibecalc.torsion.shaft_line_tables import Layout


class ExactLine:
    """n freedoms with inertia, damping and stiffness to ground; elements (a, b, k, c, eta, s)."""

    def __init__(self, case: Case) -> None:
        parts, self.built = case.machine.shaft_line, build_shaft_line(case)
        assert parts is not None
        self.parts, built = parts, self.built
        names = [one.name for one in parts.stations]
        at = {name: k for k, name in enumerate(names)}
        self.ratio = exact_ratios(parts)
        n = len(built.freedom_names)
        self.count = n
        self.inertia, self.damped, self.ground = ([mpf(0)] * n for _ in range(3))
        self.station_values = []
        for k, one in enumerate(parts.stations):
            own = [mpf(one.inertia or 0), mpf(one.absolute_damping), mpf(one.ground_stiffness)]
            own = [value * self.ratio[k] ** 2 for value in own]
            self.station_values.append(own)
            f = int(built.freedom[k])
            self.inertia[f] += own[0]
            self.damped[f] += own[1]
            self.ground[f] += own[2]
        self.elements: list[tuple[int, int, mpf, mpf, mpf, mpf]] = []
        self.section_ratio: list[mpf] = []
        for shaft, (first, second) in zip(parts.shafts, Layout(parts).ends, strict=True):
            stiffness = _stiffness(shaft)
            damping = mpf(shaft.damping or 0)
            if shaft.damping_ratio:
                one, two = (mpf(parts.stations[at[name]].inertia) for name in (first, second))
                reduced = one * two / (one + two)
                damping = 2 * mpf(shaft.damping_ratio) * mpmath.sqrt(stiffness * reduced)
            self._add(at[first], at[second], stiffness, damping, mpf(shaft.loss_factor))
        for gear in parts.gears:
            if gear.mesh_stiffness is not None:
                teeth = mpf(gear.mesh_stiffness) * mpf(gear.pitch_radius) ** 2
                self._add(at[gear.between[0]], at[gear.between[1]], teeth, mpf(0), mpf(0))
        for attached, damper in zip(built.dampers, parts.dampers, strict=True):
            inertia, spring = mpf(damper.inertia or 0), mpf(0)
            if damper.order is not None:
                reach = mpf(damper.arm_radius) * (1 + 1 / mpf(damper.order) ** 2)
                inertia = damper.count * mpf(damper.mass) * reach**2
                spring = inertia * mpf(damper.order) ** 2
            self.inertia[attached.ring] += inertia * self.ratio[attached.station] ** 2
            own = (mpf(damper.stiffness or 0), mpf(damper.damping), mpf(damper.loss_factor))
            self._add(attached.station, None, *own, spring, ring=attached.ring)

    def _add(self, first: int, second: int | None, k: mpf, c: mpf, eta: mpf,
             spring: Any = 0, ring: int = -1) -> None:  # fmt: skip
        r = self.ratio[first]
        freedom = self.built.freedom
        end = ring if second is None else int(freedom[second])
        self.elements.append((int(freedom[first]), end, k * r**2, c * r**2, eta, spring * r**4))
        self.section_ratio.append(r)

    def at(self, speed: mpf) -> list[tuple[int, int, mpf, mpf, mpf]]:
        """Elements at a speed."""
        return [(a, b, k + s * speed**2, c, eta) for a, b, k, c, eta, s in self.elements]

    def without_dampers(self) -> "ExactLine":
        """The same without rings; sections keep their order."""
        import copy

        bare = copy.copy(self)
        count = self.count - len(self.built.dampers)
        bare.count = count
        bare.inertia, bare.damped, bare.ground = (
            part[:count] for part in (self.inertia, self.damped, self.ground)
        )
        kept = len(self.elements) - len(self.built.dampers)
        bare.elements, bare.section_ratio = self.elements[:kept], self.section_ratio[:kept]
        return bare


def _stiffness(shaft: Any) -> mpf:
    if shaft.stiffness is not None:
        return mpf(shaft.stiffness)
    part = shaft.section
    polar = mp.pi * (mpf(part.outer_diameter) ** 4 - mpf(part.inner_diameter) ** 4) / 32
    return mpf(part.shear_modulus) * polar / mpf(part.length)


def exact_ratios(parts: Any) -> list[mpf]:
    """Own speed over crank speed, walking from the first station with a cylinder."""
    at = {one.name: k for k, one in enumerate(parts.stations)}
    layout = Layout(parts)
    links = [(j.first, j.second, mpf(1)) for j in layout.joints[: len(parts.shafts)]]
    for gear in parts.gears:
        size = mpf(gear.ratio) if gear.ratio is not None else mpf(gear.teeth[0]) / gear.teeth[1]
        first, second = (at[name] for name in gear.between)
        links.append((first, second, -size if gear.reverses else size))
    start = layout.crank
    ratio: dict[int, mpf] = {start: mpf(1)}
    while len(ratio) < len(parts.stations):
        before = len(ratio)
        for a, b, r in links:
            if a in ratio and b not in ratio:
                ratio[b] = ratio[a] * r
            elif b in ratio and a not in ratio:
                ratio[a] = ratio[b] / r
        if len(ratio) == before:
            raise AssertionError("a line in two pieces")
    return [ratio[k] for k in range(len(parts.stations))]


def solve(own: list[Any], links: list[tuple[int, int, Any]], right: list[Any]) -> list[Any]:
    """x of (diag(own) + sum over links z (e_a - e_b)(e_a - e_b)') x = right."""
    around = [dict[int, Any]() for _ in own]
    diagonal = list(own)
    for a, b, z in links:
        diagonal[a] += z
        diagonal[b] += z
        around[a][b] = around[a].get(b, 0) + z
        around[b][a] = around[b].get(a, 0) + z
    order, parent = forest(around)
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
    matrix = mpmath.diag(own)
    for a, b, z in links:
        matrix[a, a] += z
        matrix[b, b] += z
        matrix[a, b] -= z
        matrix[b, a] -= z
    return list(mpmath.lu_solve(matrix, mpmath.matrix(right)))


def forest(around: list[dict[int, Any]]) -> tuple[list[int], list[int]]:
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


class ExactModes:
    """Undamped modes at a speed: frequencies, shapes with the sign rule of the results."""

    def __init__(self, line: ExactLine, speed: mpf) -> None:
        elements = [(a, b, k) for a, b, k, _, _ in line.at(speed) if k != 0]
        n = line.count
        matrix = np.diag([float(g) for g in line.ground])
        for a, b, k in elements:
            matrix[a, a] += float(k)
            matrix[b, b] += float(k)
            matrix[a, b] -= float(k)
            matrix[b, a] -= float(k)
        root = np.sqrt([float(j) for j in line.inertia])
        _, vectors = np.linalg.eigh(matrix / root[:, None] / root)
        pieces = self._pieces(n, elements)
        rigid = [p for p in pieces if not any(line.ground[s] for s in p)]
        found: list[tuple[mpf, list[mpf]]] = []
        for k in range(len(rigid), n):
            start = [mpf(v) for v in (vectors[:, k] / root).tolist()]
            found.append(_iterated(line, elements, start))
        found.sort(key=lambda one: one[0])
        for (low, _), (high, _) in pairwise(found):
            assert high - low > mpf(10) ** -25 * high, "two starts led to one mode"
        shapes = [[mpf(int(s in p)) for s in range(n)] for p in rigid]
        self.frequency = [mpf(0)] * len(rigid) + [mpmath.sqrt(one[0]) for one in found]
        self.shape = shapes + [_signed(one[1]) for one in found]
        self.inertia = [
            mpmath.fsum(j * x**2 for j, x in zip(line.inertia, shape, strict=True))
            for shape in self.shape
        ]

    @staticmethod
    def _pieces(n: int, elements: list[tuple[int, int, mpf]]) -> list[list[int]]:
        around: list[dict[int, Any]] = [{} for _ in range(n)]
        for a, b, k in elements:
            around[a][b] = around[b][a] = k
        order, parent = forest(around)
        found: list[list[int]] = []
        for s in order:
            if parent[s] < 0:
                found.append([])
            found[-1].append(s)
        return found


def _iterated(
    line: ExactLine, elements: list[tuple[int, int, mpf]], shape: list[mpf]
) -> tuple[mpf, list[mpf]]:
    """Inverse iteration with the quotient of the vector, until nothing moves any more."""
    square = mpf(0)
    for _ in range(12):
        top = max(map(abs, shape))
        shape = [x / top for x in shape]
        energy = mpmath.fsum(k * (shape[a] - shape[b]) ** 2 for a, b, k in elements)
        energy += mpmath.fsum(g * x**2 for g, x in zip(line.ground, shape, strict=True))
        inertia = mpmath.fsum(j * x**2 for j, x in zip(line.inertia, shape, strict=True))
        last, square = square, energy / inertia
        if abs(square - last) <= mpf(10) ** (10 - mp.dps) * square:
            return square, shape
        right = [j * x for j, x in zip(line.inertia, shape, strict=True)]
        try:
            shape = solve(_nearby(line, square, 4), elements, right)
        except ZeroDivisionError:  # the square is exact to the last digit
            shape = solve(_nearby(line, square, 6), elements, right)
    raise AssertionError("a mode did not settle")


def _nearby(line: ExactLine, square: mpf, digits: int) -> list[mpf]:
    """What acts on the freedoms a few digits above the rounding of a squared frequency."""
    near = square * (1 + mpf(10) ** (digits - mp.dps))
    return [g - near * j for g, j in zip(line.ground, line.inertia, strict=True)]


def _signed(shape: list[mpf]) -> list[mpf]:
    """Largest magnitude 1; of several within a thousandth the first is positive."""
    top = max(map(abs, shape))
    first = next(x for x in shape if abs(x) >= (1 - mpf(1) / 1000) * top)
    return [x / (top if first > 0 else -top) for x in shape]


def exact_pole(
    line: ExactLine, elements: list[tuple[int, int, mpf, mpf]], damped: list[mpf], guess: mpc
) -> tuple[mpc, list[mpc]]:
    """The pole next to a guess, and its shape, by inverse iteration on the symmetric pencil."""
    s, n = guess, line.count
    shape = [mpmath.expj(mpf(k)) for k in range(n)]
    for _ in range(40):
        near = s * (1 + mpf(10) ** (6 - mp.dps))
        for _ in range(2):
            own = [
                near**2 * j + near * c + g
                for j, c, g in zip(line.inertia, damped, line.ground, strict=True)
            ]
            links = [(a, b, k + near * c) for a, b, k, c in elements]
            shape = solve(own, links, shape)
            top = max(map(abs, shape))
            shape = [x / top for x in shape]
        kinetic = mpmath.fsum(j * x**2 for j, x in zip(line.inertia, shape, strict=True))
        work = mpmath.fsum(c * x**2 for c, x in zip(damped, shape, strict=True))
        work += mpmath.fsum(c * (shape[a] - shape[b]) ** 2 for a, b, _, c in elements)
        elastic = mpmath.fsum(k * (shape[a] - shape[b]) ** 2 for a, b, k, _ in elements)
        elastic += mpmath.fsum(g * x**2 for g, x in zip(line.ground, shape, strict=True))
        step = (s**2 * kinetic + s * work + elastic) / (2 * s * kinetic + work)
        s -= step
        if abs(step) <= mpf(10) ** (10 - mp.dps) * abs(s):
            return s, shape
    raise AssertionError("a pole did not settle")
