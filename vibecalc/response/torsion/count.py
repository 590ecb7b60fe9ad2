"""How many modes of a tree of shafts lie below a frequency (Riccati transfer, sign count).

Leaf by leaf, the ratio of torque to angle is handed along the shafts. With Z what hangs on a
station (N m/rad, its own inertia included), a shaft of stiffness k hands on k Z / (k + Z). Each
negative pivot k + Z, and a negative Z at the root, is a natural frequency below (Sylvester). On a
tree every rounding error is one of a single inertia or stiffness (Demmel and Gragg 1993), so
that no count is off by more than a few roundings of the frequency asked for.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.response.torsion.graph import Piece, walk

#: a pivot that vanishes is replaced by this share of the stiffness, far below its rounding
_NUDGE = 2.0**-60


class Tree(NamedTuple):
    """A tree with its stations numbered so that each comes after the one it hangs on.

    `station` their numbers in the line, `inertia`, `ground` (n,), `parent` and `stiffness` of the
    shaft to it (entry 0, the root, unused).
    """

    station: list[int]
    inertia: FloatArray
    ground: FloatArray
    parent: list[int]
    stiffness: list[float]


def rooted(piece: Piece, root: int | None = None) -> Tree:
    """A piece without loops as a tree; the root is a station's number in the line."""
    parents = walk(piece.spring, next(iter(piece.spring)) if root is None else root)
    station = list(parents)
    place = {name: index for index, name in enumerate(station)}
    return Tree(
        station,
        np.array([piece.inertia[name] for name in station]),
        np.array([piece.ground[name] for name in station]),
        [-1 if parents[name] < 0 else place[parents[name]] for name in station],
        [0.0 if parents[name] < 0 else piece.spring[name][parents[name]] for name in station],
    )


def handed_on(stiffness: float, hanging: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Pivot k + Z, angle of the far end over that of the near one, and Z seen at the near end."""
    pivot = hanging + stiffness
    pivot[pivot == 0.0] = stiffness * _NUDGE
    ratio = stiffness / pivot
    return pivot, ratio, ratio * hanging


def modes_below(tree: Tree, frequency: FloatArray) -> IntArray:
    """Number (m,) of natural frequencies below each frequency (m,) in rad/s, rigid ones too."""
    hanging = tree.ground[:, None] - np.outer(tree.inertia, frequency**2)
    count = np.zeros(frequency.shape, dtype=np.int64)
    for index in range(len(tree.station) - 1, 0, -1):
        pivot, _, seen = handed_on(tree.stiffness[index], hanging[index])
        count += pivot < 0.0
        hanging[tree.parent[index]] += seen
    count += hanging[0] < 0.0
    return count
