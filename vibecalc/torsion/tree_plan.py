"""A shaft line as a tree, and its stations and branches at many frequencies."""

import math
from collections import Counter
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple, TypeAlias, cast

import numpy as np

from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray
from vibecalc.torsion.line import Line

# ----------------------------------------------------------------------------
# A shaft line as a tree, and everything about it that no frequency changes.
# ----------------------------------------------------------------------------

Value: TypeAlias = float | FloatArray | None
Values: TypeAlias = tuple[Value, Value, Value]
NOTHING: Values = (None, None, None)

#: roundings of one reciprocal and two products in complex numbers
ROUNDINGS = 4.5 * EPSILON


class Tree(NamedTuple):
    """`order` has children before parents; `parent` and the `elements` to it are by station.

    A root has the parent -1. Elements side by side between two stations are one branch. Of the
    branches to children, `most` meet at one station.
    """

    order: tuple[int, ...]
    parent: tuple[int, ...]
    elements: tuple[tuple[int, ...], ...]
    most: int


def tree_of(line: Line, root: int) -> Tree | None:
    """The line as a tree attached to `root` (other pieces on their first station); None with loops.

    Elements without stiffness and damping are no connection.
    """
    joined = (line.stiffness != 0.0) | (line.damping != 0.0)
    joins = np.any(joined, axis=tuple(range(joined.ndim - 1))).tolist()
    ends = zip(line.first.tolist(), line.second.tolist(), joins, strict=True)
    return _tree(line.inertia.shape[-1], tuple(ends), root)


@lru_cache(maxsize=64)
def _tree(n: int, ends: tuple[tuple[int, int, bool], ...], root: int) -> Tree | None:
    """The same of n stations and elements between them, that join them or not."""
    parallel: dict[tuple[int, int], list[int]] = {}
    for e, (a, b, joins) in enumerate(ends):
        if a != b and joins:
            parallel.setdefault((min(a, b), max(a, b)), []).append(e)
    near: list[list[tuple[int, tuple[int, ...]]]] = [[] for _ in range(n)]
    for (a, b), group in parallel.items():
        near[a].append((b, tuple(group)))
        near[b].append((a, tuple(group)))
    parent, order = [-2] * n, list[int]()
    elements: list[tuple[int, ...]] = [()] * n
    for start in (root, *range(n)):
        if parent[start] != -2:
            continue
        parent[start] = -1
        reached = [start]
        for a in reached:
            for b, group in near[a]:
                if parent[b] == -2:
                    parent[b], elements[b] = a, group
                    reached.append(b)
        order += reached
    branches = sum(one >= 0 for one in parent)
    if branches != len(parallel):
        return None
    most = max(Counter(one for one in parent if one >= 0).values(), default=0)
    return Tree(tuple(reversed(order)), tuple(parent), tuple(elements), most)


class Plan(NamedTuple):
    """A tree with its values: floats, or arrays of the line's flat leading axis; None where zero.

    Of each station inertia, stiffness and damping to the frame; of the branch to its parent
    stiffness, stiffness times loss factor, and damping. Those that are alike are one object.
    """

    tree: Tree
    damped: bool
    station: list[Values]
    branch: list[Values]

    def cut(self, part: slice) -> "Plan":
        """The entries of a block."""

        def one(values: Values) -> Values:
            if not any(isinstance(v, np.ndarray) for v in values):
                return values
            return cast(Values, tuple(v[part] if isinstance(v, np.ndarray) else v for v in values))

        return Plan(
            self.tree, self.damped, [one(v) for v in self.station], [one(v) for v in self.branch]
        )

    @property
    def unit(self) -> float:
        """Roundings of a step at the station where most branches meet."""
        return ROUNDINGS + 0.5 * EPSILON * self.tree.most


def plan_of(line: Line, root: int, shape: tuple[int, ...] = ()) -> Plan | None:
    """Everything about a line that no frequency changes; None for a line with loops.

    Its values, of frequencies of that shape if it is given, are flat.
    """
    tree = tree_of(line, root)
    if tree is None:
        return None

    def parts(values: FloatArray) -> list[float | FloatArray]:
        if values.ndim == 1:
            return cast("list[float | FloatArray]", values.tolist())
        rows = values.reshape(-1, values.shape[-1])
        # of many lines most values are alike
        found: list[float | FloatArray] = rows[0].tolist()
        for i in np.flatnonzero(np.any(rows != rows[:1], axis=0)).tolist():
            found[i] = np.broadcast_to(values[..., i], shape or values.shape[:-1]).reshape(-1)
        return found

    def value(one: float | FloatArray) -> Value:
        if isinstance(one, np.ndarray):
            return one if np.any(one) else None
        return one or None

    def branches(values: FloatArray) -> list[float | FloatArray]:
        each = parts(values)
        return [sum((each[e] for e in one), 0.0) for one in tree.elements]

    alike: dict[Values, Values] = {}

    def together(*lists: Sequence[float | FloatArray]) -> list[Values]:
        found = [cast(Values, tuple(map(value, one))) for one in zip(*lists, strict=True)]
        return [
            one if any(isinstance(v, np.ndarray) for v in one) else alike.setdefault(one, one)
            for one in found
        ]

    station = together(
        parts(line.inertia), parts(line.ground_stiffness), parts(line.absolute_damping)
    )
    branch = together(
        branches(line.stiffness),
        branches(line.stiffness * line.loss_factor),
        branches(line.damping),
    )
    damped = any(one[2] is not None for one in station)
    damped |= any(one[1] is not None or one[2] is not None for one in branch)
    return Plan(tree, damped, station, branch)


# ----------------------------------------------------------------------------
# The stations and branches of a tree at the frequencies of a block.
# ----------------------------------------------------------------------------

#: a value (f,), a bound (f,) or () of its magnitude, and the largest of all
Element: TypeAlias = tuple[FloatArray | ComplexArray, float | FloatArray, float]


class Branches:
    """k (1 + i loss factor) + i w c of the branches to the parents, one at a time.

    Neighbours are often alike, as the throws of a crankshaft are; then the last one is kept.
    """

    def __init__(self, plan: Plan, frequency: FloatArray):
        self.plan, self.frequency = plan, frequency
        self.highest = float(np.max(frequency, initial=0.0))
        self.space = np.empty(len(frequency), dtype=np.complex128)
        self.last: Values = NOTHING
        self.stored: Element = (self.space, 0.0, 0.0)

    def element(self, i: int) -> Element:
        own = self.plan.branch[i]
        if own is not self.last:
            self.last = own
            self.stored = self._formed(*own)
        return self.stored

    def _formed(self, stiffness: Value, loss: Value, damping: Value) -> Element:
        stiffness = 0.0 if stiffness is None else stiffness
        if loss is None and damping is None:
            size = np.abs(stiffness)
            return np.asarray(stiffness), size, float(np.max(size))
        self.space.real = stiffness
        if damping is not None:
            np.multiply(self.frequency, damping, out=self.space.imag)
            if loss is not None:
                self.space.imag += loss
        elif loss is not None:
            self.space.imag = loss
        if not any(isinstance(one, np.ndarray) for one in (stiffness, loss, damping)):
            imaginary = self.highest * float(damping or 0.0) + abs(float(loss or 0.0))
            largest = math.hypot(float(stiffness), imaginary)
            # where damping adds next to nothing one bound will do, even along many stations
            if largest <= stiffness * (1.0 + 0.4 / len(self.plan.branch)):
                return self.space, largest, largest
        size = np.abs(self.space)
        return self.space, size, float(np.max(size))


class Stations:
    """k - w^2 J + i w c of the stations against the frame; real on a line without damping.

    As with `Branches` the last one is kept for neighbours that are alike; not to be written into.
    """

    def __init__(self, plan: Plan, frequency: FloatArray):
        self.plan, self.frequency, self.square = plan, frequency, frequency * frequency
        kind: type = np.complex128 if plan.damped else np.float64
        self.negative: ComplexArray = -self.square.astype(kind)
        self.roundings = (1.5 + 0.5 * plan.tree.most) * EPSILON / plan.unit
        self.last: Values = NOTHING
        self.stored: ComplexArray = self.negative
        self.last_uncertain, self.stored_uncertainty = NOTHING, self.square

    def dynamic_stiffness(self, i: int) -> ComplexArray:
        """(f,)."""
        own = self.plan.station[i]
        if own is not self.last:
            inertia, stiffness, damping = self.last = own
            found = np.asarray(self.negative * (0.0 if inertia is None else inertia))
            if stiffness is not None:
                found.real += stiffness
            if damping is not None:
                np.multiply(self.frequency, damping, out=found.imag)
            self.stored = found
        return self.stored

    def uncertainty(self, i: int) -> FloatArray:
        """(f,), its products, and one addition for each branch, in units of the plan's `unit`."""
        own = self.plan.station[i]
        if own is not self.last_uncertain:
            inertia, stiffness, damping = self.last_uncertain = own
            found = np.multiply(self.square, 0.0 if inertia is None else self.roundings * inertia)
            if stiffness is not None:
                found += self.roundings * np.abs(stiffness)
            if damping is not None:
                found += self.frequency * (self.roundings * damping)
            self.stored_uncertainty = found
        return self.stored_uncertainty
