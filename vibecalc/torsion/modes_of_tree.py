"""Frequencies and shapes of branched lines and of lines with loops; Holzer's table of any line."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, BoolArray, FloatArray, IntArray
from vibecalc.torsion.line import Line, LinePart, connected_parts, lines_of, walk

# ----------------------------------------------------------------------------
# How many modes of a tree of shafts lie below a frequency (Riccati transfer, sign count).
#
# Leaf by leaf, the ratio of torque to angle is handed along the shafts. With Z what hangs on a
# station (N m/rad, its own inertia included), a shaft of stiffness k hands on k Z / (k + Z). Each
# negative pivot k + Z, and a negative Z at the root, is a natural frequency below (Sylvester). On a
# tree every rounding error is one of a single inertia or stiffness (Demmel and Gragg 1993), so
# that no count is off by more than a few roundings of the frequency asked for.
# ----------------------------------------------------------------------------

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


def rooted(part: LinePart, root: int | None = None) -> Tree:
    """A part without loops as a tree; the root is a station's number in the line."""
    parents = walk(part.spring, next(iter(part.spring)) if root is None else root)
    station = list(parents)
    place = {name: index for index, name in enumerate(station)}
    return Tree(
        station,
        np.array([part.inertia[name] for name in station]),
        np.array([part.ground[name] for name in station]),
        [-1 if parents[name] < 0 else place[parents[name]] for name in station],
        [0.0 if parents[name] < 0 else part.spring[name][parents[name]] for name in station],
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
        pivot, _, passed = handed_on(tree.stiffness[index], hanging[index])
        count += pivot < 0.0
        hanging[tree.parent[index]] += passed
    count += hanging[0] < 0.0
    return count


# ----------------------------------------------------------------------------
# All natural frequencies of a tree of shafts by counting modes and halving brackets.
#
# A bracket holds by its counts, so that no mode is missed however close two of them are. Halving
# the stored numbers instead of their values reaches neighbouring doubles in some 60 steps for
# frequencies of any size.
# ----------------------------------------------------------------------------

#: no natural frequency is sought below this share of the upper bound
_LOWEST = 1e-100


def highest(tree: Tree) -> float:
    """An upper bound (rad/s) of all frequencies: w^2 <= 2 max(K_ii / J_i) (Gershgorin)."""
    diagonal = tree.ground.copy()
    for index in range(1, len(tree.station)):
        diagonal[index] += tree.stiffness[index]
        diagonal[tree.parent[index]] += tree.stiffness[index]
    heavy = tree.inertia > 0.0
    return float(np.sqrt(2.0 * np.max(diagonal[heavy] / tree.inertia[heavy])) * 1.001)


def tree_frequencies(
    tree: Tree, start: FloatArray | None = None, start_error: float | FloatArray = 0.0
) -> FloatArray:
    """Natural frequencies (m,) in rad/s, ascending, of m stations with inertia; rigid exactly 0.

    `start` (m,) with an absolute `start_error` () or (m,) shortens the search where its brackets
    hold.
    Relative error: some roundings (see `relative_error`). Raises `NumericalFailure` if the counts
    contradict the number of modes, which only a range of values beyond 1e100 can do.
    """
    modes = int(np.count_nonzero(tree.inertia))
    rigid = 0 if np.any(tree.ground) else 1
    wanted = np.arange(rigid, modes)
    if not wanted.size:
        return np.zeros(modes)
    top = highest(tree)
    low, high = np.full(wanted.shape, top * _LOWEST), np.full(wanted.shape, top)
    if start is not None:
        below = np.maximum((start - start_error)[rigid:], low)
        above = np.minimum((start + start_error)[rigid:], high)
        low = np.where(modes_below(tree, below) <= wanted, below, low)
        high = np.where(modes_below(tree, above) > wanted, above, high)
    elif np.any(modes_below(tree, low[:1]) != rigid) or np.any(modes_below(tree, high[:1]) < modes):
        raise NumericalFailure(
            "the modes of the shaft line cannot be counted: its stiffnesses and inertias span "
            "too wide a range"
        )
    left, right = low.view(np.int64), high.view(np.int64)
    while np.any(right - left > 1):
        middle = left + (right - left) // 2
        under = modes_below(tree, middle.view(np.float64)) > wanted
        left, right = np.where(under, left, middle), np.where(under, middle, right)
    return np.concatenate([np.zeros(rigid), right.view(np.float64)])


def relative_error(count: int) -> float:
    """Roundings of a frequency: that of each of `count` stations adds up like a random walk."""
    return float((40.0 + 2.0 * np.sqrt(count)) * EPSILON)


# ----------------------------------------------------------------------------
# Natural frequencies by Riccati transfer, mode count and bisection alone: the independent way.
# ----------------------------------------------------------------------------


#: share of a frequency within which its counts are looked for first
_NEAR = 1e-12


def riccati_frequencies(line: Line, near: FloatArray | None = None) -> FloatArray:
    """Natural frequencies (m,) in rad/s, ascending, of a row or branched line; rigid exactly 0.

    Shares no step with the eigenvalue route of rows; where `near` (m,) are they, their counts say
    so, and the search is short. Stations without inertia stay in the recurrence. Raises
    `NumericalFailure` for a closed loop of shafts, which has no leaf to begin at.
    """
    frequencies, parts = [], connected_parts(line)
    for part in parts:
        if not part.is_tree:
            raise NumericalFailure(
                "the transfer matrix follows rows and branches of shafts, not a closed loop: "
                "use the eigenvalues"
            )
        start = near if len(parts) == 1 else None
        around = 0.0 if start is None else _NEAR * start
        frequencies.append(tree_frequencies(rooted(part), start, around))
    return np.sort(np.concatenate(frequencies))


# ----------------------------------------------------------------------------
# Frequencies and shapes of branched lines, and of lines with closed loops of shafts.
#
# A tree: every frequency by counting modes, shapes by handing torque over angle along every shaft
# in both senses and starting at the station of most energy. A loop: singular values of the factor
# sqrt(k) D J^(-1/2), dense, with an absolute error of its largest frequency's roundings.
# ----------------------------------------------------------------------------

#: shapes that are off orthogonal by less (a Frobenius norm) are turned by a short series
NEARLY = 1e-3


def factor_modes(part: LinePart) -> tuple[FloatArray, FloatArray, float]:
    """Frequencies (n,) ascending, shapes (n, n) and one absolute error, of any part with inertia.

    One row of the factor for each shaft and each spring to ground; a rigid mode is exactly 0.
    """
    place = {name: index for index, name in enumerate(part.spring)}
    root = np.sqrt([part.inertia[name] for name in part.spring])
    rows = []
    for a, others in part.spring.items():
        for b, k in others.items():
            if place[a] < place[b]:
                rows.append(np.zeros(len(root)))
                rows[-1][place[a]] = np.sqrt(k) / root[place[a]]
                rows[-1][place[b]] = -np.sqrt(k) / root[place[b]]
        if part.ground[a]:
            rows.append(np.zeros(len(root)))
            rows[-1][place[a]] = np.sqrt(part.ground[a]) / root[place[a]]
    while len(rows) < len(root):
        rows.append(np.zeros(len(root)))
    _, value, vector = np.linalg.svd(np.array(rows), full_matrices=True)
    frequency, shape = value[::-1].copy(), vector[::-1] / root
    error = 2.0 * len(rows) * EPSILON * float(value[0])
    if part.is_free:
        frequency[0], shape[0] = 0.0, 1.0
    return frequency, shape, error


def tree_modes(part: LinePart) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Frequencies (m,), shapes (m, n) by order of the part's stations, absolute errors (m,)."""
    start, dense, error = None, None, 0.0
    if all(part.inertia.values()):
        start, dense, error = factor_modes(part)
    tree = rooted(part)
    frequency = tree_frequencies(tree, start, error)
    inertia = np.array([part.inertia[name] for name in part.spring])
    place = {name: index for index, name in enumerate(part.spring)}
    heavy = np.flatnonzero(inertia > 0.0)
    meeting = np.abs(_driven(part, frequency))
    best = np.asarray(heavy)[np.argmin(meeting[heavy] / inertia[heavy, None], axis=0)]
    shape = _shapes(part, frequency, best, place)
    better = np.argmax(shape**2 * inertia, axis=1)
    shape = _shapes(part, frequency, better, place)
    for first, last in clusters(frequency):
        shape[first:last] = _independent(
            part,
            frequency[first:last],
            shape[first:last],
            place,
            inertia,
            None if dense is None else dense[first:last],
        )
    return frequency, shape, frequency * relative_error(len(inertia))


def _driven(part: LinePart, frequency: FloatArray) -> FloatArray:
    """Torque over angle (n, m) with which each station would have to be driven; 0 at a mode."""
    square = frequency**2
    station_z = {name: part.ground[name] - part.inertia[name] * square for name in part.spring}
    parent = walk(part.spring, next(iter(part.spring)))
    inwards = [(a, b) for a, b in parent.items() if b >= 0][::-1]
    # Z that station b sees through the shaft from a, by (a, b)
    passed: dict[tuple[int, int], FloatArray] = {}
    for a, b in inwards + [(b, a) for a, b in inwards[::-1]]:
        # summed anew without the shaft itself: a difference would cancel
        hanging = station_z[a] + sum(passed[other, a] for other in part.spring[a] if other != b)
        passed[a, b] = handed_on(part.spring[a][b], hanging)[2]
    return np.array([
        z + sum(passed[other, name] for other in part.spring[name]) for name, z in station_z.items()
    ])  # fmt: skip


def _shapes(
    part: LinePart, frequency: FloatArray, start: IntArray, place: dict[int, int]
) -> FloatArray:
    """Shapes (m, n) that are 1 at the station `start` (m,) of each mode."""
    names = list(place)
    shape = np.ones((len(frequency), len(names)))
    for station in set(start.tolist()):
        which = np.flatnonzero(start == station)
        tree = rooted(part, names[station])
        hanging = tree.ground[:, None] - np.outer(tree.inertia, frequency[which] ** 2)
        ratio = np.ones_like(hanging)
        for index in range(len(names) - 1, 0, -1):
            _, ratio[index], passed = handed_on(tree.stiffness[index], hanging[index])
            hanging[tree.parent[index]] += passed
        for index in range(1, len(names)):
            ratio[index] *= ratio[tree.parent[index]]
        column = np.array([place[name] for name in tree.station])
        shape[np.ix_(which, column)] = ratio.T
    return shape


def clusters(frequency: FloatArray, relative: float = 1e-6) -> list[tuple[int, int]]:
    """Runs (first, last + 1) of two or more frequencies with gaps below a share of themselves."""
    close = np.flatnonzero(np.diff(frequency) <= relative * frequency[1:])
    runs: list[tuple[int, int]] = []
    for index in close.tolist():
        if runs and runs[-1][1] == index + 1:
            runs[-1] = (runs[-1][0], index + 2)
        else:
            runs.append((index, index + 2))
    return runs


def _independent(
    part: LinePart,
    frequency: FloatArray,
    shape: FloatArray,
    place: dict[int, int],
    inertia: FloatArray,
    dense: FloatArray | None,
) -> FloatArray:
    """Shapes of a cluster, orthogonal: its own if they are independent, else any that span it.

    Equal branches have as many shapes at one frequency as there are branches less one. Started
    from each station in turn, the recurrences give them all; `dense` ones stand by.
    """
    own = orthogonal(shape, inertia)
    if own is not None:
        return own
    heavy = np.flatnonzero(inertia > 0.0)
    mean = float(np.mean(frequency))
    trial = _shapes(part, np.full(len(heavy), mean), heavy, place)
    trial /= np.sqrt(trial**2 @ inertia)[:, None]
    # a start at rest in the mode gives no mode: what is left to drive it tells

    def lack(shapes: FloatArray) -> FloatArray:
        torque = _residual(part, shapes, mean, place)[:, heavy] / np.sqrt(inertia[heavy])
        largest: FloatArray = np.abs(torque).max(axis=1) / np.sqrt(shapes**2 @ inertia)
        return largest

    size = lack(trial) + 1e-300
    chosen: list[FloatArray] = []
    for _ in frequency:
        remainder = np.sqrt(trial**2 @ inertia)
        basis = trial[np.argmin(size / np.maximum(remainder, 1e-12))]
        for other in chosen:
            basis = basis - (basis * inertia) @ other * other
        basis = basis / np.sqrt(basis**2 @ inertia)
        trial = trial - np.outer(trial @ (basis * inertia), basis)
        chosen.append(basis)
    best = np.array(chosen)
    return best if dense is None or lack(best).max() <= lack(dense).max() else dense


def _residual(
    part: LinePart, shape: FloatArray, frequency: float, place: dict[int, int]
) -> FloatArray:
    """Torques (m, n) that shapes lack to be modes at a frequency."""
    torque = np.zeros_like(shape)
    for a, others in part.spring.items():
        i = place[a]
        torque[:, i] += (part.ground[a] - frequency**2 * part.inertia[a]) * shape[:, i]
        for b, k in others.items():
            torque[:, i] += k * (shape[:, i] - shape[:, place[b]])
    return torque


def orthogonal(shape: FloatArray, inertia: FloatArray) -> FloatArray | None:
    """The nearest set of shapes (m, n) orthogonal in the inertias; None if they are dependent."""
    weighted = shape * np.sqrt(inertia)
    length = np.sqrt(np.einsum("ij,ij->i", weighted, weighted))[:, None]
    weighted /= length
    unit: FloatArray = shape / length
    product = weighted @ weighted.T
    off = product - np.eye(len(product))
    size = float(np.sqrt(np.einsum("ij,ij", off, off)))
    if size < NEARLY:
        # (1 + x)^(-1/2) = 1 - x / 2 (1 - 3 x / 4 (1 - 5 x / 6 ...)), as far as a rounding goes
        terms = 1 + int(np.log(EPSILON) / np.log(max(size, EPSILON)))
        part = off * ((2 * terms - 1) / (2 * terms))
        for k in range(terms - 1, 0, -1):
            part = (off - off @ part) * ((2 * k - 1) / (2 * k))
        unit -= part @ unit
        return unit
    value, vector = np.linalg.eigh(product)
    if value[0] < 0.1:
        return None
    turned: FloatArray = (vector / np.sqrt(value)) @ vector.T
    return turned @ unit


def orthogonal_pairs(
    shape: FloatArray, first: IntArray, inertia: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """As `orthogonal` for the shapes `first` and the next ones, (pairs, 2, n), all pairs at once.

    Sum and difference of two unit vectors are orthogonal: scaled to unit length they span the
    nearest pair. The second value tells which pairs are independent.
    """
    one, two = shape[first], shape[first + 1]
    weighted = one * inertia
    one /= np.sqrt(np.einsum("ij,ij->i", weighted, one))[:, None]
    weighted = two * inertia
    two /= np.sqrt(np.einsum("ij,ij->i", weighted, two))[:, None]
    cosine = np.einsum("ij,ij,j->i", one, two, inertia)
    sound: BoolArray = np.abs(cosine) <= 0.9
    cosine = np.where(sound, cosine, 0.0)[:, None]
    total, apart = 0.5 / np.sqrt(1.0 + cosine), 0.5 / np.sqrt(1.0 - cosine)
    own, other = total + apart, total - apart
    return np.stack([own * one + other * two, other * one + own * two], axis=1), sound


# ----------------------------------------------------------------------------
# Holzer's table of a line at any frequency, branch by branch, with the torque left at the end.
# ----------------------------------------------------------------------------


class HolzerRows(NamedTuple):
    """Order of the n rows of a table: `freedom` (n,) of the line, `below` (n,) the row that each
    one's shaft leads to (-1 for the last), `stiffness` (..., n - 1) of that shaft in N m/rad.

    From the first end along the main row; before the row of a junction stand those of the
    branches on it, each from its own end on. In a plain row `below` is always the next row.
    """

    freedom: IntArray
    below: IntArray
    stiffness: FloatArray


class HolzerTable(NamedTuple):
    """One row for each of n stations in the order of `rows`, leading axes those of the frequency.

    `angle` (..., n) in rad, 1 in the first row; `sum_torque` (..., n) in N m are the torques of the
    inertias J w^2 angle, with the sums of the rows whose shafts lead here, less what springs to
    ground take. The last one keeps the motion going: it is zero at a natural frequency.
    """

    rows: HolzerRows
    angle: FloatArray
    sum_torque: FloatArray


def holzer_rows(line: Line) -> HolzerRows:
    """Rows of the part with most stations, from its end nearest to the first station.

    The main row leads to the end that is farthest from it. Parallel shafts count as one. The line
    may have one leading axis of its stiffness. Raises `NumericalFailure` for closed loops and for a
    part without any inertia.
    """
    if line.stiffness.ndim > 1:
        each = [holzer_rows(one) for one in lines_of(line)]
        return each[0]._replace(stiffness=np.stack([one.stiffness for one in each]))
    part = max(connected_parts(line), key=lambda one: len(one.spring))
    if not part.is_tree:
        raise NumericalFailure("a Holzer table is of a line without closed loops of shafts")
    start = next(s for s, others in part.spring.items() if len(others) < 2)
    towards = walk(part.spring, start)
    end = list(towards)[-1]
    parent = walk(part.spring, end)
    children: dict[int, list[int]] = {station: [] for station in parent}
    size = dict.fromkeys(parent, 1)
    for station in reversed(parent):
        if parent[station] >= 0:
            children[parent[station]].append(station)
            size[parent[station]] += size[station]
    main, station = {start}, start
    while station != end:
        station = parent[station]
        main.add(station)
    # the walk from the end takes the main row last, so that backwards it comes first
    waiting, order = [end], []
    while waiting:
        order.append(waiting.pop())
        waiting += sorted(children[order[-1]], key=lambda s: (s not in main, -size[s]))
    order.reverse()
    place = {station: row for row, station in enumerate(order)}
    return HolzerRows(
        np.array(order),
        np.array([place.get(parent[station], -1) for station in order]),
        np.array([part.spring[station][parent[station]] for station in order[:-1]]),
    )


def holzer_table(line: Line, frequency: ArrayLike) -> HolzerTable:
    """The table at frequencies (...) in rad/s; a branch takes the angle of the junction it is on.

    The line may have the frequencies as a leading axis of its stiffness.

    Far from a natural frequency of a long row the angles grow from station to station; this is a
    table to be read, frequencies are found by counting (`count.py`). Raises `NumericalFailure` as
    `holzer_rows`, for angles beyond the range of numbers, and where a junction that a branch hangs
    on stands still.
    """
    rows = holzer_rows(line)
    inertia, ground = line.inertia[rows.freedom], line.ground_stiffness[rows.freedom]
    rate = np.asarray(frequency, dtype=float)[..., None] ** 2 * inertia - ground
    count = len(inertia)
    angle, total = np.ones(rate.shape), np.zeros(rate.shape)
    above: list[list[int]] = [[] for _ in range(count)]  # rows that lead here
    branch: list[list[int]] = []  # rows that move with each one, itself included
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        for i in range(count):
            branch.append([i])
            for place, j in enumerate(above[i]):
                twist = total[..., j] / rows.stiffness[..., j]
                reached = angle[..., j] - twist
                if place == 0:
                    angle[..., i] = reached
                else:
                    lost = count * EPSILON * (np.abs(twist) + np.abs(angle[..., j]))
                    if np.any(np.abs(reached) <= lost):
                        raise NumericalFailure(
                            "a branch swings against a junction that stands still: its Holzer "
                            "table cannot be joined to that of the line"
                        )
                    factor = angle[..., i] / reached
                    for row in branch[j]:
                        angle[..., row] *= factor
                        total[..., row] *= factor
                total[..., i] += total[..., j]
                branch[i] += branch[j]
            total[..., i] += rate[..., i] * angle[..., i]
            if i < count - 1:
                above[rows.below[i]].append(i)
    if not np.all(np.isfinite(total)):
        raise NumericalFailure("the angles of the Holzer table leave the range of numbers")
    return HolzerTable(rows, angle, total)


def relative_residual(line: Line, frequency: ArrayLike) -> FloatArray:
    """What the last row leaves over the sum of the magnitudes of all inertia torques, (...).

    1 towards frequency zero, where the line turns as a whole, and 0 at a natural frequency: sigma_3
    of eq. 4.12 of Baca (2007), which grows with the frequency over all bounds, as a share. At
    frequencies (...) above 0 in rad/s; raises `NumericalFailure` as `holzer_table`.
    """
    table, square = holzer_table(line, frequency), np.square(frequency)[..., None]
    torque = square * line.inertia[table.rows.freedom] * table.angle
    return np.asarray(table.sum_torque[..., -1] / np.abs(torque).sum(axis=-1))
