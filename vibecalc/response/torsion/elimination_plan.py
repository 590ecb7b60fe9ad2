"""A shaft line as a tree, and everything about it that no frequency changes."""

from typing import NamedTuple, TypeAlias

import numpy as np

from vibecalc.numerics.typing import FloatArray
from vibecalc.response.torsion.line import Line

Value: TypeAlias = float | FloatArray | None


class Tree(NamedTuple):
    """`order` has children before parents; `parent` and the `elements` to it are by station.

    A root has the parent -1. Elements side by side between two stations are one branch.
    """

    order: tuple[int, ...]
    parent: tuple[int, ...]
    elements: tuple[tuple[int, ...], ...]


def tree_of(line: Line, root: int) -> Tree | None:
    """The line as a tree hung on `root` (other pieces on their first station); None with loops.

    Elements without stiffness and damping are no connection.
    """
    n = line.inertia.shape[-1]
    parallel: dict[tuple[int, int], list[int]] = {}
    joined = (line.stiffness != 0.0) | (line.damping != 0.0)
    joins = np.any(joined, axis=tuple(range(joined.ndim - 1))).tolist()
    for e, (a, b) in enumerate(zip(line.first.tolist(), line.second.tolist(), strict=True)):
        if a != b and joins[e]:
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
    return Tree(tuple(reversed(order)), tuple(parent), tuple(elements))


class Plan(NamedTuple):
    """Values by station as floats, or as arrays of the line's flat leading axis; None where zero.

    `stiffness`, `loss` (stiffness times loss factor) and `damping` are of the branch to the parent.
    """

    tree: Tree
    damped: bool
    inertia: list[Value]
    ground_stiffness: list[Value]
    absolute_damping: list[Value]
    stiffness: list[Value]
    loss: list[Value]
    damping: list[Value]

    def cut(self, part: slice) -> "Plan":
        """The entries of a block."""

        def one(values: list[Value]) -> list[Value]:
            return [v[part] if isinstance(v, np.ndarray) else v for v in values]

        return Plan(self.tree, self.damped, *(one(values) for values in self[2:]))


def plan_of(line: Line, root: int) -> Plan | None:
    """Everything about a line that no frequency changes; None for a line with loops."""
    tree = tree_of(line, root)
    if tree is None:
        return None

    def value(values: FloatArray) -> Value:
        if values.ndim == 0:
            return float(values) or None
        return values if np.any(values) else None

    def branches(values: FloatArray) -> list[Value]:
        return [value(sum((values[..., e] for e in one), np.zeros(()))) for one in tree.elements]

    own = (line.inertia, line.ground_stiffness, line.absolute_damping)
    stations = [[value(one[..., i]) for i in range(line.inertia.shape[-1])] for one in own]
    between = [
        branches(one) for one in (line.stiffness, line.stiffness * line.loss_factor, line.damping)
    ]
    imaginary = (*stations[2], *between[1], *between[2])
    damped = any(one is not None for one in imaginary)
    return Plan(tree, damped, *stations, *between)
