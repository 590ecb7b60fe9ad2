"""The network of a shaft line: connected pieces, paths and trees, massless stations.

Everything here is done on element values, never on an assembled matrix: sums, products and
quotients of positive numbers lose no digits, differences of a matrix do.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.torsion.line import Line


class Piece(NamedTuple):
    """What hangs together: stations by their number in the line, springs (kg m^2, N m/rad).

    `spring[a][b]` = `spring[b][a]` is the stiffness between two stations, parallel elements
    added, elements of zero stiffness absent. `inertia` and `ground` are by station.
    """

    spring: dict[int, dict[int, float]]
    inertia: dict[int, float]
    ground: dict[int, float]

    @property
    def is_tree(self) -> bool:
        """No closed loop of shafts."""
        return sum(map(len, self.spring.values())) == 2 * (len(self.spring) - 1)

    @property
    def is_free(self) -> bool:
        """No spring to ground: the piece has a rigid mode."""
        return not any(self.ground.values())


class Condensed(NamedTuple):
    """A massless station taken out: its angle is the mean of `weight` by station of others."""

    station: int
    weight: dict[int, float]


def pieces(line: Line) -> list[Piece]:
    """The connected pieces of a line without leading axes, the one of station 0 first.

    Raises `NumericalFailure` for a piece that has no inertia at all: it has no modes.
    """
    count = len(line.inertia)
    spring: dict[int, dict[int, float]] = {station: {} for station in range(count)}
    for a, b, k in zip(
        line.first.tolist(), line.second.tolist(), line.stiffness.tolist(), strict=True
    ):
        if k != 0.0 and a != b:
            spring[a][b] = spring[b][a] = spring[a].get(b, 0.0) + k
    inertia, ground = line.inertia.tolist(), line.ground_stiffness.tolist()
    found, left = [], dict.fromkeys(range(count))
    while left:
        reached = list(walk(spring, next(iter(left))))
        for station in reached:
            del left[station]
        part = {station: spring[station] for station in reached}
        piece = Piece(part, {s: inertia[s] for s in reached}, {s: ground[s] for s in reached})
        if not any(piece.inertia.values()):
            raise NumericalFailure(
                f"the shaft line has a piece without any inertia, with station {reached[0] + 1}: "
                "it has no modes"
            )
        found.append(piece)
    return found


def walk(spring: dict[int, dict[int, float]], root: int) -> dict[int, int]:
    """Stations, each after the one it hangs on, with that one (-1 for the root)."""
    parent = {root: -1}
    queue = [root]
    for station in queue:
        for other in spring[station]:
            if other not in parent:
                parent[other] = station
                queue.append(other)
    return parent


def path_order(piece: Piece) -> list[int] | None:
    """Stations of a piece from one end to the other, None if it is no simple row."""
    ends = [station for station, others in piece.spring.items() if len(others) < 2]
    branched = any(len(others) > 2 for others in piece.spring.values())
    return None if branched or not ends else list(walk(piece.spring, ends[0]))


def condense(piece: Piece, most_springs: int) -> tuple[Piece, list[Condensed]]:
    """Take out massless stations that hold at most `most_springs` shafts; exact, in this order.

    Star to mesh: springs k_a to the neighbours and k_g to ground become springs k_a k_b / s
    between them and k_a k_g / s to ground, s the sum. All terms are positive.
    """
    spring = {station: dict(others) for station, others in piece.spring.items()}
    inertia, ground = dict(piece.inertia), dict(piece.ground)
    taken: list[Condensed] = []
    waiting = True
    while waiting:
        waiting = False
        for station in [s for s, value in inertia.items() if value == 0.0]:
            others = spring[station]
            if len(others) > most_springs:
                continue
            total = sum(others.values()) + ground[station]
            taken.append(Condensed(station, {a: k / total for a, k in others.items()}))
            names = list(others)
            for place, a in enumerate(names):
                ground[a] += others[a] * (ground[station] / total)
                del spring[a][station]
                for b in names[:place]:
                    joined = others[a] * (others[b] / total)
                    spring[a][b] = spring[b][a] = spring[a].get(b, 0.0) + joined
            del spring[station], inertia[station], ground[station]
            waiting = True
    return Piece(spring, inertia, ground), taken


def angles_of_condensed(shape: FloatArray, taken: list[Condensed]) -> None:
    """Fill in, in place, the angles (..., n) of the stations that `condense` took out."""
    for station, weight in reversed(taken):
        shape[..., station] = sum(
            (shape[..., a] * part for a, part in weight.items()), np.zeros(())
        )
