"""A shaft line as a tree, and elimination along it at many frequencies at once."""

import math
from collections import Counter
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple, TypeAlias, cast

import numpy as np

from vibecalc.numerics.rounding import EPSILON, BoolArray, ComplexArray, FloatArray
from vibecalc.torsion.line import Line, walk

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
    near: dict[int, dict[int, list[int]]] = {station: {} for station in range(n)}
    for e, (a, b, joins) in enumerate(ends):
        if a != b and joins:
            near[a].setdefault(b, []).append(e)
            near[b].setdefault(a, []).append(e)
    parent: dict[int, int] = {}
    for start in (root, *range(n)):
        if start not in parent:
            parent |= walk(near, start)
    hung = Counter(one for one in parent.values() if one >= 0)
    if 2 * hung.total() != sum(map(len, near.values())):
        return None
    above = tuple(parent[station] for station in range(n))
    elements = tuple(tuple(near[one].get(other, ())) for one, other in enumerate(above))
    return Tree(tuple(reversed(parent)), above, elements, max(hung.values(), default=0))


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


# ----------------------------------------------------------------------------
# Round-off of an elimination along a tree, as a running bound in magnitudes.
# ----------------------------------------------------------------------------


class Check:
    """Running bound of the round-off, carried along with the elimination in magnitudes.

    All errors are in units of the plan's `unit`. A torque's error is absolute; where none acts the
    angle is that of the parent times t, and its relative error that of the parent and of t.
    `room` (n, f) is what it works in: memory that is asked for once.
    """

    def __init__(
        self, plan: Plan, stations: Stations, room: FloatArray, shape: tuple[int, ...]
    ) -> None:
        n = len(plan.station)
        self.stations, self.share = stations, list(room[:, None])
        self.stiffness: list[FloatArray | None] = [None] * n
        self.torque: list[FloatArray | None] = [None] * n
        self.relative: list[FloatArray | None] = [None] * n
        self.steps = [0] * n
        self.error, self.largest = np.zeros((2, *shape))
        self.turn: list[FloatArray] = [self.error] * n

    def down(
        self, i: int, p: int, r: FloatArray, element: float | FloatArray, passed: ComplexArray,
        alone: ComplexArray | None,
    ) -> None:  # fmt: skip
        """Of k g / (k + g), `passed` to the parent, and of what the torque does `alone`.

        r and `element` are |1 / (k + g)|, which is used up, and a bound of |k|.
        """
        gathered, share = self.stiffness[i], self.share[i][0]
        self.stiffness[i] = None
        uncertainty = self.stations.uncertainty(i) if gathered is None else gathered
        np.multiply(uncertainty, r, out=share)
        if alone is None:
            r *= element * element
            uncertainty = np.multiply(share, r, out=gathered)
        else:
            before = self.torque[i]
            if before is not None:
                before *= r
            r *= element
            self.turn[i] = r[None]
            uncertainty = np.multiply(share, r, out=gathered)
            uncertainty *= element
            share += 1.0
            size = np.abs(alone)
            carried = share * size
            if before is not None:
                carried += before
                size += before
            carried *= element
            above = self.torque[p]
            self.torque[p] = carried if above is None else np.add(above, carried, out=carried)
            self.torque[i] = size
        uncertainty += np.abs(passed)
        above = self.stiffness[p]
        uncertainty += self.stations.uncertainty(p) if above is None else above
        self.stiffness[p] = uncertainty

    def root(self, i: int, x: ComplexArray, r: ComplexArray, load: ComplexArray | None) -> None:
        """Of the angle of a root with the compliance r."""
        size, carried, uncertainty = np.abs(x), self.torque[i], self.stiffness[i]
        bend = np.abs(r)
        wrong = bend * (self.stations.uncertainty(i) if uncertainty is None else uncertainty)
        wrong = size * (wrong + 1.0)
        if load is not None:
            rounded = np.abs(load)
            wrong += bend * (rounded if carried is None else rounded + carried)
        self.turn[i] = wrong
        np.maximum(self.largest, size, out=self.largest)
        np.maximum(self.error, wrong, out=self.error)

    def up(self, i: int, p: int, x: ComplexArray, above: ComplexArray) -> None:
        """Of the angle of any other station, `above` being that of its parent."""
        size, share, turn, carried = np.abs(x), self.share[i], self.turn[i], self.torque[i]
        np.maximum(self.largest, size, out=self.largest)
        # in memory that is at hand, unless several torques are solved together
        single = len(size) == 1
        if carried is None:
            relative = self.relative[p]
            if relative is None:
                # of an angle that is zero by chance nothing is known, and it is solved again
                turn = self.turn[p]
                relative = turn / np.where(turn > 0.0, np.abs(above), 1.0)
                self.relative[p] = relative
            relative = np.add(share, relative, out=share if single else None)
            self.relative[i], self.steps[i] = relative, self.steps[p] + 1
            size *= relative
            np.maximum(self.error, size, out=self.error)
            return
        # the error of a station with a torque takes the place of its turn
        wrong = np.multiply(turn, self.turn[p], out=turn if single else None)
        size = np.multiply(share, size, out=size)
        wrong += size
        wrong += carried
        self.torque[i], self.turn[i] = None, wrong
        np.maximum(self.error, wrong, out=self.error)

    def whole(self) -> tuple[FloatArray, FloatArray]:
        """Error and largest of all angles, (r, f)."""
        # one rounding of each turn on the way from the last station with a torque
        return self.error + max(self.steps) * self.largest, self.largest


# ----------------------------------------------------------------------------
# Elimination along a tree of freedoms, at many frequencies at once.
#
# A sub-line that hangs on its parent by an element k has the dynamic stiffness g of its station;
# seen from the parent it is k g / (k + g). That form (torque over angle, as in Riccati's transfer
# matrix) never subtracts the large stiffnesses from each other, so that soft modes of stiff lines
# keep their digits. What can go wrong is a resonance of an eliminated sub-line, k + g near zero:
# its growth is measured, and the caller takes another root then.
# ----------------------------------------------------------------------------

#: growth of one step at which four digits are lost
GROWTH = 1e4
#: numbers of a piece of memory from which on numpy asks the system for large pages
LARGE_PAGES = 1 << 19


class LineSolution(NamedTuple):
    """Angles (n, r, f) and, where asked for, their absolute error (r, f).

    `growth` (f,) is set where no error was asked for: elimination lost four digits or more there.
    `largest` (r, f) is the largest magnitude of the angles, with the error.
    """

    angle: ComplexArray
    error: FloatArray
    growth: BoolArray
    largest: FloatArray


class Room(NamedTuple):
    """What blocks work in: `check` (n, f), and `turn` (m, f) complex.

    The m stations to which a torque is carried, and that hand it on, have a turn of their own;
    all others have theirs where their angle will be.
    """

    turn: ComplexArray
    check: FloatArray


def handing_on(tree: Tree, driven: Sequence[bool]) -> list[bool]:
    """Which stations pass a torque to their parent."""
    carried = list(driven)
    for i in tree.order:
        if tree.parent[i] >= 0:
            carried[tree.parent[i]] |= carried[i]
    return [one and p >= 0 for one, p in zip(carried, tree.parent, strict=True)]


def room_for(plan: Plan, driven: Sequence[bool], count: int, estimate: bool) -> Room:
    """Memory for blocks of so many frequencies: fresh memory takes longer than the arithmetic.

    All in one piece, and for long blocks in one for which the system hands out large pages: of
    what is asked for, only what is used is then taken, in a few steps.
    """
    n, turns = len(plan.station), sum(handing_on(plan.tree, driven))
    entries, checks = 2 * turns * count, n * count if estimate else 0
    whole = entries + checks
    memory = np.empty(max(whole, LARGE_PAGES) if whole > LARGE_PAGES // 4 else whole)
    turn: ComplexArray = memory[:entries].view(np.complex128)
    check = memory[entries:whole].reshape(n, count if estimate else 0)
    return Room(turn.reshape(turns, count), check)


def eliminate(
    plan: Plan,
    frequency: FloatArray,
    torque: list[ComplexArray | None],
    estimate: bool,
    angle: ComplexArray,
    room: Room | None = None,
) -> LineSolution:
    """Angles at frequencies (f,), written into `angle` (n, r, f); `room` is memory used again.

    `torque` has for each station an array that broadcasts to (r, f), or None where there is none;
    the plan is cut to the block. A root without any stiffness, as of a free line at rest, is held
    if the torques balance.
    """
    tree = plan.tree
    n, count = len(plan.station), len(frequency)
    branches, stations = Branches(plan, frequency), Stations(plan, frequency)
    room = room or room_for(plan, [one is not None for one in torque], count, estimate)
    own_turns = iter(room.turn[:, None, :count])
    turn: list[ComplexArray] = [angle[i, :1] for i in range(n)]
    carried = [False] * n
    real: FloatArray | None = None if plan.damped else np.empty(count)
    check = Check(plan, stations, room.check[:, :count], angle.shape[1:]) if estimate else None
    acting, torque = torque, list(torque)
    ground: list[ComplexArray | None] = [None] * n
    compliance: dict[int, ComplexArray] = {}
    lost = np.zeros(count, dtype=bool)
    growth = np.zeros(count, dtype=bool)
    meeting: dict[int, FloatArray] = {}
    for i in tree.order:
        p, attached, load = tree.parent[i], ground[i], torque[i]
        dynamic_stiffness = stations.dynamic_stiffness(i) if attached is None else attached
        if p < 0:
            compliance[i], free = at_root(dynamic_stiffness)
            if load is not None and np.any(free):
                lost |= free & ~balanced(load, acting)
            if i in meeting:
                growth |= ~(meeting[i] * np.abs(compliance[i]) <= GROWTH)
            continue
        element, bound, largest = branches.element(i)
        if load is not None:
            carried[i], turn[i] = True, next(own_turns)
        whole = np.add(dynamic_stiffness, element, out=turn[i][0] if real is None else real)
        np.reciprocal(whole, out=whole)
        size, most = (None, largest_part(whole)) if check is None else (np.abs(whole), 0.0)
        if load is not None:
            # what the torque does by itself waits where the angle will be
            np.multiply(whole, load, out=angle[i])
        t = np.multiply(whole, element, out=whole)
        if real is not None:
            turn[i][...] = t
        passed = np.multiply(dynamic_stiffness, t, out=attached)
        if check is not None and size is not None:
            check.down(i, p, size, bound, passed, None if load is None else angle[i])
        else:
            if tree.parent[p] < 0:
                # what cancels at a root is a resonance of the whole line
                meeting[p] = np.maximum(meeting.get(p, 0.0), np.abs(passed))
            if not most * largest <= GROWTH:
                growth |= ~(np.abs(t) <= GROWTH)
        above = ground[p]
        ground[p] = np.add(
            passed, stations.dynamic_stiffness(p) if above is None else above, out=passed
        )
        ground[i] = None
        if load is not None:
            moved, acted = np.multiply(element, angle[i]), torque[p]
            torque[p] = moved if acted is None else np.add(moved, acted, out=moved)
            # memory that is free again is still in the cache
            torque[i] = None
    for i in reversed(tree.order):
        p, load, out = tree.parent[i], torque[i], angle[i]
        if p < 0:
            out[...] = 0.0
            if load is not None:
                np.multiply(compliance[i], load, out=out)
        elif carried[i]:
            out += np.multiply(turn[i], angle[p], out=turn[i] if len(out) == 1 else None)
        else:
            np.multiply(turn[i], angle[p], out=out)
        if check is not None:
            if p < 0:
                check.root(i, out, compliance[i], load)
            else:
                check.up(i, p, out, angle[p])
    if check is None:
        nothing = np.zeros((0, 0))
        return LineSolution(angle, nothing, growth | lost, nothing)
    error, highest = check.whole()
    error *= plan.unit
    if lost.any():
        error[:, lost] = np.inf
    if not np.isfinite(np.max(error, initial=0.0)):
        error[np.isnan(error)] = np.inf
    return LineSolution(angle, error, growth, highest)


def largest_part(values: ComplexArray) -> float:
    """A bound of the largest magnitude, sooner than by magnitudes."""
    parts = values.view(np.float64)
    return float(1.5 * max(np.maximum.reduce(parts), -np.minimum.reduce(parts)))


def at_root(dynamic_stiffness: ComplexArray) -> tuple[ComplexArray, BoolArray]:
    """Compliance of a root, 0 where it is free, and where that is."""
    free: BoolArray = dynamic_stiffness == 0.0
    return np.divide(
        1.0, np.where(free, np.inf, dynamic_stiffness) if free.any() else dynamic_stiffness
    ), free


def balanced(load: ComplexArray, acting: list[ComplexArray | None]) -> BoolArray:
    """Whether the torques (r, f) that meet at a free root are zero to rounding."""
    size = np.zeros(())
    for one in acting:
        if one is not None:
            size = size + np.abs(one)
    balanced: BoolArray = np.all(np.abs(load) <= 2.0 * len(acting) * ROUNDINGS * size, axis=0)
    return balanced
