"""A shaft line as a network that is eliminated freedom by freedom, closed loops of shafts too."""

import heapq
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations
from typing import NamedTuple, TypeAlias

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray, IntArray
from vibecalc.torsion.elimination import ROUNDINGS, LineSolution
from vibecalc.torsion.line import Line, columns, complex_stiffness, equivalent_line, hand_over

#: of each step the reciprocal of its sum, and the share of the sum that each neighbour has
Factors: TypeAlias = list[tuple[ComplexArray, list[ComplexArray]]]


class Step(NamedTuple):
    """A freedom to eliminate, its neighbours with their edges, the edges between these after it."""

    freedom: int
    around: list[tuple[int, int]]
    fill: list[tuple[int, int, int]]


@dataclass(frozen=True)
class Network:
    """n freedoms, the edge of each element (e,), -1 for none, and the steps of elimination.

    Star to mesh: a freedom with edges k_a to its neighbours and g to ground leaves k_a g / s to
    ground at each of them and k_a k_b / s between them, s the sum of all. A tree never fills, a
    loop fills by the edge that closes it; what a soft branch adds is no difference of large values.
    """

    n: int
    edge: IntArray
    edges: int
    steps: list[Step]

    def factorised(
        self, ground: Sequence[ComplexArray], element: ComplexArray, least: float = 0.0
    ) -> Factors:
        """From values (...) to ground of each freedom and of each element.

        A sum is at least that share of its edges; a freedom with nothing at all is held.
        """
        g = list(ground)
        k: list[ComplexArray] = [np.zeros((), dtype=np.complex128)] * self.edges
        for place, value in zip(self.edge.tolist(), element, strict=True):
            if place >= 0:
                k[place] = k[place] + value
        factors: Factors = []
        for i, around, fill in self.steps:
            total = sum((k[e] for _, e in around), start=g[i])
            if least:
                size = least * sum(np.abs(k[e]) for _, e in around)
                total = np.where(np.abs(total) < size, size, total)
                total = np.where(total == 0.0, np.inf, total)
            inverse = 1.0 / total
            share = [k[e] * inverse for _, e in around]
            for (j, _), part in zip(around, share, strict=True):
                g[j] = g[j] + part * g[i]
            for p, q, e in fill:
                k[e] = k[e] + share[p] * k[around[q][1]]
            factors.append((inverse, share))
        return factors

    def solved(self, factors: Factors, load: ComplexArray) -> ComplexArray:
        """Angles (n, ...) under torques (n, ...)."""
        angle = load.copy()
        # one piece of memory for all products
        t, product, multiply = list(angle), np.empty(load.shape[1:], np.complex128), np.multiply
        for (i, around, _), (_, share) in zip(self.steps, factors, strict=True):
            for (j, _), part in zip(around, share, strict=True):
                t[j] += multiply(part, t[i], product)
        for (i, around, _), (inverse, share) in zip(
            reversed(self.steps), reversed(factors), strict=True
        ):
            here = t[i]
            here *= inverse
            for (j, _), part in zip(around, share, strict=True):
                here += multiply(part, t[j], product)
        return angle


def lost_digits(factors: Factors) -> bool:
    """Whether some sum of edges is nearly zero next to them, or is zero."""
    shares = [one for _, share in factors for one in share]
    if not np.all(np.isfinite([inverse for inverse, _ in factors])):
        return True
    return bool(shares) and not np.all(np.abs(shares) <= 1.0 / LEAST)


def network_of(line: Line) -> Network:
    """The network of a line, whatever its values."""
    return _network(line.inertia.shape[-1], tuple(line.first.tolist()), tuple(line.second.tolist()))


@lru_cache(maxsize=16)
def _network(n: int, first: tuple[int, ...], second: tuple[int, ...]) -> Network:
    """Those with the fewest neighbours are eliminated first."""
    beside: list[dict[int, int]] = [{} for _ in range(n)]
    names: dict[tuple[int, int], int] = {}

    def edge(a: int, b: int) -> int:
        number = names.setdefault((min(a, b), max(a, b)), len(names))
        beside[a][b] = beside[b][a] = number
        return number

    edges = [edge(a, b) if a != b else -1 for a, b in zip(first, second, strict=True)]
    waiting = [(len(others), i) for i, others in enumerate(beside)]
    heapq.heapify(waiting)
    left, steps = set(range(n)), list[Step]()
    while waiting:
        count, i = heapq.heappop(waiting)
        if i not in left or count != len(beside[i]):
            continue
        left.remove(i)
        around = list(beside[i].items())
        for j, _ in around:
            del beside[j][i]
        pairs = combinations(range(len(around)), 2)
        fill = [(p, q, edge(around[p][0], around[q][0])) for p, q in pairs]
        steps.append(Step(i, around, fill))
        for j, _ in around:
            heapq.heappush(waiting, (len(beside[j]), j))
    return Network(n, np.array(edges, dtype=np.int64), len(names), steps)


def inverse_iteration(line: Line, pole: ComplexArray, x: ComplexArray) -> ComplexArray:
    """Unit shapes (n, g) after one step of inverse iteration at each pole (g,)."""
    law = columns(equivalent_line(line, np.abs(pole)))
    near = pole * (1.0 + 16.0 * EPSILON)
    # in place: of thousands of poles, memory for sums on the way takes longer than these
    load = 2.0 * near * law.inertia
    load += law.absolute_damping
    load *= x
    torque = x[law.second]
    torque -= x[law.first]
    torque *= law.damping
    hand_over(load, law, torque)
    ground = near * law.absolute_damping
    ground += law.ground_stiffness
    ground += near**2 * law.inertia
    element = near * law.damping
    element += law.stiffness
    network = network_of(line)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        x = network.solved(network.factorised(list(ground), element), load)
        square = np.square(x.real)
        square += np.square(x.imag)
        x /= np.sqrt(np.add.reduce(square, axis=0))
    if not np.all(np.isfinite(x)):
        raise NumericalFailure("the poles of the damped line leave the range of numbers")
    return x


# ----------------------------------------------------------------------------
# Forced response of any network, with refinement, and with the error that its roundings make by the
# line's own compliances.
#
# What resonates by itself on the way makes a sum of edges nearly zero. There it is kept from zero,
# and what is left of the equations, formed by twists, is solved again until it corrects nothing.
#
# Rounded are then the torques of elements, which act on both of their ends, and those at the
# freedoms. With the compliances G = 1 / A of the line, D the sizes of these roundings and B the
# freedoms that they act on, no angle is wrong by more than the largest sum of a row of |G B D|.
# That sum is found by a few solves, as the largest of a column of its transpose (W. W. Hager 1984,
# N. J. Higham 1988).
# ----------------------------------------------------------------------------

#: share of its edges that a sum of them has at least
LEAST = 2.0**-40
#: columns that are summed up: a mean of all, and those that each one points at as the largest
COLUMNS = 2


def network_solution(
    line: Line, frequency: FloatArray, torque: list[ComplexArray | None], angle: ComplexArray
) -> LineSolution:
    """As `eliminate` with its estimate, for any network and next to resonances of its parts."""
    n, copies, count = angle.shape
    network, first, second = network_of(line), line.first, line.second
    w = frequency[:, None]
    ground = line.ground_stiffness + 1j * w * line.absolute_damping - w**2 * line.inertia
    ground = np.broadcast_to(ground, (count, n)).T
    element = np.broadcast_to(complex_stiffness(line, frequency), (count, len(first))).T
    load = np.zeros((n, copies, count), dtype=np.complex128)
    for i, one in enumerate(torque):
        if one is not None:
            load[i] = one
    by_freedom = list(ground.astype(np.complex128))
    factors = network.factorised(by_freedom, element)
    if lost_digits(factors):
        factors = network.factorised(by_freedom, element, LEAST)
    angle[...] = 0.0
    change, left, error = angle, load, np.zeros((copies, count))
    # torques that elements pull with, and that the freedoms themselves take
    carried, held = np.zeros((len(first), copies, count), np.complex128), angle

    def spread(at_freedom: ComplexArray, in_element: ComplexArray) -> ComplexArray:
        """Torques on all freedoms from those on each and those that elements pull with."""
        whole = at_freedom.copy()
        hand_over(whole, line, in_element)
        return whole

    def corrected(beside: ComplexArray) -> ComplexArray:
        """Correct the angles, and solve for torques `beside` what is left (n, r, f)."""
        nonlocal change, left, carried, held
        left = spread(load - held, carried)
        both = network.solved(factors, np.concatenate([left, beside], axis=1))
        change, answer = both[:, :copies], both[:, copies:]
        np.add(angle, change, out=angle)
        carried = element[:, None] * (angle[first] - angle[second])
        held = ground[:, None] * angle
        return answer

    # in phases of no symmetry, so that no mode is left out
    column = np.broadcast_to(np.exp(1j * np.arange(n))[:, None, None] / n, angle.shape)
    for number in range(COLUMNS):
        answer = corrected(column)
        rounded = 4.0 * EPSILON * np.abs(carried)
        summed = 2.0 * EPSILON * (np.abs(held) + np.abs(load))
        for a, b, one in zip(first.tolist(), second.tolist(), 0.5 * rounded, strict=True):
            summed[a] += one
            summed[b] += one
        twist = answer[first] - answer[second]
        moved, twisted = np.abs(answer), np.abs(twist)
        total = np.sum(summed * moved, axis=0) + np.sum(rounded * twisted, axis=0)
        error = np.fmax(error, total)
        if number + 1 == COLUMNS:
            break
        # a torque of each size in the phase that turns this column on most
        summed /= np.where(moved > 0.0, moved, np.inf)
        rounded /= np.where(twisted > 0.0, twisted, np.inf)
        turning = np.asarray(summed * np.conj(answer), dtype=complex)
        slope = corrected(spread(turning, np.asarray(-rounded * np.conj(twist), dtype=complex)))
        column = np.zeros_like(slope)
        np.put_along_axis(column, np.argmax(np.abs(slope), axis=0)[None], 1.0, axis=0)
    largest = np.max(np.abs(angle), axis=0)
    # another column may have a sum that is larger, but seldom twice as large
    error = 2.0 * (error + np.max(np.abs(change), axis=0) + EPSILON * largest)
    # what nothing else holds needs torques that balance
    least = 2.0 * n * ROUNDINGS * np.abs(load).sum(axis=0)
    for (i, _, _), (inverse, _) in zip(network.steps, factors, strict=True):
        error[(np.abs(left[i]) > least) & (inverse == 0.0)] = np.inf
    error[~np.isfinite(error)] = np.inf
    return LineSolution(angle, error, np.zeros(count, dtype=bool), largest)
