"""A shaft line as degrees of freedom with elastic elements between them: matrices and network."""

from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple, TypeVar

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import BoolArray, ComplexArray, FloatArray, IntArray

# ----------------------------------------------------------------------------
# A shaft line as freedoms and the elastic elements between them.
#
# Everything is referred to the crankshaft: a station that turns r times as fast as the crankshaft
# has the angle r phi, the inertia J r^2 and shafts of stiffness k r^2 here. What two rigid gears
# hold together is one freedom. So a line with gears is a plain network of inertias and springs.
# ----------------------------------------------------------------------------

Values = TypeVar("Values", FloatArray, ComplexArray)


class Line(NamedTuple):
    """n freedoms and e elements; the values may have leading axes, the network is one.

    `inertia` (..., n) in kg m^2, `absolute_damping` (..., n) in N m s/rad and `ground_stiffness`
    (..., n) in N m/rad act between a freedom and the steadily turning frame; `stiffness`, `damping`
    and `loss_factor` (..., e) act on the twist phi[first] - phi[second] of each element, whose
    torque is (k (1 + i loss_factor) + i w c) (phi[first] - phi[second]).
    """

    inertia: FloatArray
    absolute_damping: FloatArray
    ground_stiffness: FloatArray
    first: IntArray
    second: IntArray
    stiffness: FloatArray
    damping: FloatArray
    loss_factor: FloatArray


def mapped(line: Line, function: Callable[[FloatArray], FloatArray]) -> Line:
    """The line with its values changed, its network kept."""
    return line._replace(
        inertia=function(line.inertia),
        absolute_damping=function(line.absolute_damping),
        ground_stiffness=function(line.ground_stiffness),
        stiffness=function(line.stiffness),
        damping=function(line.damping),
        loss_factor=function(line.loss_factor),
    )


def chain(inertia: FloatArray, stiffness: FloatArray) -> Line:
    """An undamped line of n inertias in a row with n - 1 shafts between them."""
    inertia, stiffness = np.asarray(inertia, dtype=float), np.asarray(stiffness, dtype=float)
    start = np.arange(stiffness.shape[-1])
    none, free = np.zeros_like(inertia), np.zeros_like(stiffness)
    return Line(inertia, none, none, start, start + 1, stiffness, free, free)


def lines_of(line: Line) -> list[Line]:
    """The lines of one some values of which have one leading axis; none of one without."""
    count = max(len(one) if one.ndim > 1 else 0 for one in line)
    return [
        mapped(line, lambda one, place=place: one[place] if one.ndim > 1 else one)  # type: ignore[misc]
        for place in range(count)
    ]


def network_matrix(line: Line, element: Values, ground: Values) -> Values:
    """Symmetric matrix (..., n, n) of element values (..., e) and values to ground (..., n)."""
    n = line.inertia.shape[-1]
    leading: tuple[int, ...] = np.broadcast_shapes(element.shape[:-1], ground.shape[:-1])
    matrix: Values = np.zeros((*leading, n, n), dtype=element.dtype)
    index = np.arange(n)
    matrix[..., index, index] += ground
    for e, (a, b) in enumerate(zip(line.first, line.second, strict=True)):
        matrix[..., a, a] += element[..., e]
        matrix[..., b, b] += element[..., e]
        matrix[..., a, b] -= element[..., e]
        matrix[..., b, a] -= element[..., e]
    return matrix


def stiffness_matrix(line: Line) -> FloatArray:
    """K (..., n, n) in N m/rad, without loss factors."""
    return network_matrix(line, line.stiffness, line.ground_stiffness)


def damping_matrix(line: Line) -> FloatArray:
    """C (..., n, n) in N m s/rad."""
    return network_matrix(line, line.damping, line.absolute_damping)


def dynamic_stiffness(line: Line, frequency: FloatArray) -> ComplexArray:
    """K (1 + i loss factor) + i w C - w^2 J, (..., n, n) complex, w (...) in rad/s."""
    w = np.asarray(frequency, dtype=float)[..., None]
    element = line.stiffness * (1.0 + 1j * line.loss_factor) + 1j * w * line.damping
    ground = line.ground_stiffness + 1j * w * line.absolute_damping - w**2 * line.inertia
    return network_matrix(line, element, ground)


def spring_twists(line: Line) -> tuple[FloatArray, FloatArray]:
    """Rows (e + g, n) that read the twists of elements, then of ground springs, from angles.

    With the stiffnesses (e + g,) in N m/rad of these; of a line without leading axes.
    """
    e, n = line.stiffness.size, line.inertia.size
    ground = np.flatnonzero(line.ground_stiffness)
    rows = np.zeros((e + ground.size, n))
    rows[np.arange(e), line.first] += 1.0
    rows[np.arange(e), line.second] -= 1.0
    rows[e + np.arange(ground.size), ground] = 1.0
    return rows, np.concatenate([line.stiffness, line.ground_stiffness[ground]])


def complex_stiffness(line: Line, frequency: FloatArray) -> ComplexArray:
    """k (1 + i eta) + i w c of the elements (..., e), N m/rad, at frequencies (...) in rad/s.

    Of torques over twists for x(t) = Re(X exp(i w t)): what damps has a positive imaginary part.
    """
    lossy = loss_stiffness(line, frequency)
    value: ComplexArray = np.empty(np.broadcast_shapes(lossy.shape, line.stiffness.shape), complex)
    value.real, value.imag = line.stiffness, lossy
    return value


def loss_stiffness(line: Line, frequency: FloatArray) -> FloatArray:
    """Imaginary part (..., e) of `complex_stiffness`, N m/rad."""
    loss = line.stiffness * line.loss_factor
    return np.asarray(loss + frequency[..., None] * line.damping)


def equivalent_line(line: Line, frequency: float | FloatArray) -> Line:
    """The line with dashpots eta k / w in place of its loss factors; w (...) in rad/s."""
    if not np.any(line.loss_factor):
        return line
    w = np.asarray(frequency, dtype=float)[..., None]
    dashpot = line.damping + np.abs(line.loss_factor) * line.stiffness / w
    return line._replace(damping=dashpot, loss_factor=np.zeros_like(line.loss_factor))


def columns(line: Line) -> Line:
    """Values (n or e, g), or (n or e, 1) where they are those of all poles."""
    return mapped(line, lambda one: one.T if one.ndim > 1 else one[:, None])


def hand_over(
    load: FloatArray | ComplexArray, line: Line, torque: FloatArray | ComplexArray
) -> None:
    """Take torques (e, ...) of the elements off what acts on their first freedoms, in place, and
    add them to what acts on the second ones; `load` is (n, ...).

    Many times as fast as numpy's `add.at`.
    """
    for first, second, one in zip(line.first.tolist(), line.second.tolist(), torque, strict=True):
        load[first] -= one
        load[second] += one


def damped_elements(line: Line) -> IntArray:
    """Places (k,) of elements whose torque is not in phase with their twist at every order."""
    return np.flatnonzero((line.damping != 0.0) | (line.loss_factor != 0.0))


def part_of(line: Line, joined: BoolArray) -> IntArray:
    """Of each freedom (n,) the first one that the elements which are `joined` (e,) join it to."""
    part = np.arange(line.inertia.shape[-1])
    for a, b in zip(line.first[joined], line.second[joined], strict=True):
        first, other = sorted((part[a], part[b]))
        part[part == other] = first
    return part


def free_parts(line: Line, joined: BoolArray) -> FloatArray:
    """Rows (r, n) of ones and zeros: the freedoms of each part that no ground stiffness holds.

    Parts hang together by the elements that are `joined` (e,).
    """
    part = part_of(line, joined)
    member = part == np.array(sorted(set(part.tolist())))[:, None]
    held = np.any(member & (line.ground_stiffness != 0.0), axis=1)
    return np.asarray(member[~held].astype(float))


def with_ring(line: Line, station: int, inertia: float, stiffness: float, damping: float) -> Line:
    """The line with a ring, in kg m^2, as its last freedom and its damper as its last element.

    On a station, with N m/rad and N m s/rad.
    """
    n = line.inertia.size
    return Line(
        np.append(line.inertia, inertia), np.append(line.absolute_damping, 0.0),
        np.append(line.ground_stiffness, 0.0), np.append(line.first, station),
        np.append(line.second, n), np.append(line.stiffness, stiffness),
        np.append(line.damping, damping), np.append(line.loss_factor, 0.0),
    )  # fmt: skip


def without_freedom(line: Line, freedom: int, element: int) -> tuple[Line, IntArray, IntArray]:
    """The line without a freedom and the one element that holds it.

    With the places of the elements (e,) and of the freedoms (n,) that it still has.
    """
    n, e = line.inertia.size, line.stiffness.size
    left_freedoms, between = (
        np.flatnonzero(np.arange(n) != freedom),
        np.flatnonzero(np.arange(e) != element),
    )
    number = np.cumsum(np.arange(n) != freedom) - 1
    left = Line(
        line.inertia[left_freedoms], line.absolute_damping[left_freedoms],
        line.ground_stiffness[left_freedoms], number[line.first[between]],
        number[line.second[between]], line.stiffness[between], line.damping[between],
        line.loss_factor[between],
    )  # fmt: skip
    return left, between, left_freedoms


# ----------------------------------------------------------------------------
# The network of a shaft line: connected parts, paths and trees, massless stations.
#
# Everything here is done on element values, never on an assembled matrix: sums, products and
# quotients of positive numbers lose no digits, differences of a matrix do.
# ----------------------------------------------------------------------------


class LinePart(NamedTuple):
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
        """No spring to ground: the part has a rigid mode."""
        return not any(self.ground.values())


class CondensedStation(NamedTuple):
    """A massless station taken out: its angle is the mean of `weight` by station of others."""

    station: int
    weight: dict[int, float]


def connected_parts(line: Line) -> list[LinePart]:
    """The connected parts of a line without leading axes, the one of station 0 first.

    Raises `NumericalFailure` for a part that has no inertia at all: it has no modes.
    """
    count = len(line.inertia)
    spring: dict[int, dict[int, float]] = {station: {} for station in range(count)}
    for a, b, k in zip(
        line.first.tolist(), line.second.tolist(), line.stiffness.tolist(), strict=True
    ):
        if k != 0.0 and a != b:
            spring[a][b] = spring[b][a] = spring[a].get(b, 0.0) + k
    inertia, ground = line.inertia.tolist(), line.ground_stiffness.tolist()
    parts, left = [], dict.fromkeys(range(count))
    while left:
        reached = list(walk(spring, next(iter(left))))
        for station in reached:
            del left[station]
        springs = {station: spring[station] for station in reached}
        part = LinePart(springs, {s: inertia[s] for s in reached}, {s: ground[s] for s in reached})
        if not any(part.inertia.values()):
            raise NumericalFailure(
                f"the shaft line has a piece without any inertia, with station {reached[0] + 1}: "
                "it has no modes"
            )
        parts.append(part)
    return parts


def walk(spring: Mapping[int, Iterable[int]], root: int) -> dict[int, int]:
    """Stations, each after the one it hangs on, with that one (-1 for the root)."""
    parent = {root: -1}
    queue = [root]
    for station in queue:
        for other in spring[station]:
            if other not in parent:
                parent[other] = station
                queue.append(other)
    return parent


def path_order(part: LinePart) -> list[int] | None:
    """Stations of a part from one end to the other, None if it is no simple row."""
    ends = [station for station, others in part.spring.items() if len(others) < 2]
    branched = any(len(others) > 2 for others in part.spring.values())
    return None if branched or not ends else list(walk(part.spring, ends[0]))


def condense(part: LinePart, most_springs: int) -> tuple[LinePart, list[CondensedStation]]:
    """Take out massless stations that hold at most `most_springs` shafts; exact, in this order.

    Star to mesh: springs k_a to the neighbours and k_g to ground become springs k_a k_b / s
    between them and k_a k_g / s to ground, s the sum. All terms are positive.
    """
    spring = {station: dict(others) for station, others in part.spring.items()}
    inertia, ground = dict(part.inertia), dict(part.ground)
    taken: list[CondensedStation] = []
    waiting = True
    while waiting:
        waiting = False
        for station in [s for s, value in inertia.items() if value == 0.0]:
            others = spring[station]
            if len(others) > most_springs:
                continue
            total = sum(others.values()) + ground[station]
            taken.append(CondensedStation(station, {a: k / total for a, k in others.items()}))
            names = list(others)
            for place, a in enumerate(names):
                ground[a] += others[a] * (ground[station] / total)
                del spring[a][station]
                for b in names[:place]:
                    joined = others[a] * (others[b] / total)
                    spring[a][b] = spring[b][a] = spring[a].get(b, 0.0) + joined
            del spring[station], inertia[station], ground[station]
            waiting = True
    return LinePart(spring, inertia, ground), taken


def angles_of_condensed(shape: FloatArray, taken: list[CondensedStation]) -> None:
    """Fill in, in place, the angles (..., n) of the stations that `condense` took out."""
    for station, weight in reversed(taken):
        shape[..., station] = sum(
            (shape[..., a] * part for a, part in weight.items()), np.zeros(())
        )
