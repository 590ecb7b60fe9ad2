"""Elimination in the equations of a shaft line at many frequencies: along a tree, or dense."""

from functools import lru_cache
from typing import NamedTuple, TypeAlias, cast

import numpy as np

from vibecalc.numerics.rounding import EPSILON, BoolArray, ComplexArray, FloatArray
from vibecalc.torsion.line import Line

# ----------------------------------------------------------------------------
# A shaft line as a tree, and everything about it that no frequency changes.
# ----------------------------------------------------------------------------

Value: TypeAlias = float | FloatArray | None


class Tree(NamedTuple):
    """`order` has children before parents; `parent` and the `elements` to it are by station.

    A root has the parent -1. Elements side by side between two stations are one branch.
    """

    order: tuple[int, ...]
    parent: tuple[int, ...]
    elements: tuple[tuple[int, ...], ...]


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

    def parts(values: FloatArray) -> list[float] | list[FloatArray]:
        if values.ndim == 1:
            return cast("list[float]", values.tolist())
        return [values[..., i] for i in range(values.shape[-1])]

    def value(one: float | FloatArray) -> Value:
        if isinstance(one, np.ndarray):
            return one if np.any(one) else None
        return one or None

    def branches(values: FloatArray) -> list[Value]:
        each = parts(values)
        return [value(sum((each[e] for e in one), 0.0)) for one in tree.elements]

    of_stations = (line.inertia, line.ground_stiffness, line.absolute_damping)
    stations = [[value(part) for part in parts(one)] for one in of_stations]
    between = [
        branches(one) for one in (line.stiffness, line.stiffness * line.loss_factor, line.damping)
    ]
    imaginary = (*stations[2], *between[1], *between[2])
    damped = any(one is not None for one in imaginary)
    return Plan(tree, damped, *stations, *between)


# ----------------------------------------------------------------------------
# The stations and elements of a tree at the frequencies of a block.
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
        self.last: tuple[float, ...] = ()
        self.stored: Element = (self.space, 0.0, 0.0)

    def element(self, i: int) -> Element:
        plan = self.plan
        stiffness, loss, damping = (
            0.0 if one is None else one
            for one in (plan.stiffness[i], plan.loss[i], plan.damping[i])
        )
        if (
            isinstance(stiffness, np.ndarray)
            or isinstance(loss, np.ndarray)
            or isinstance(damping, np.ndarray)
        ):
            self.last = ()
            return self._varied(stiffness, loss, damping)
        if (stiffness, loss, damping) != self.last:
            self.last = (stiffness, loss, damping)
            self.stored = self._constant(stiffness, loss, damping)
        return self.stored

    def _constant(self, stiffness: float, loss: float, damping: float) -> Element:
        imaginary = abs(loss) + self.highest * damping
        largest = float(np.hypot(stiffness, imaginary))
        if imaginary == 0.0:
            return np.asarray(stiffness), largest, largest
        self.space.real = stiffness
        np.multiply(self.frequency, damping, out=self.space.imag)
        if loss != 0.0:
            self.space.imag += loss
        # where damping adds next to nothing one bound will do, even along many stations
        little = largest <= stiffness * (1.0 + 0.4 / len(self.plan.inertia))
        return self.space, largest if little else np.abs(self.space), largest

    def _varied(
        self, stiffness: float | FloatArray, loss: float | FloatArray, damping: float | FloatArray
    ) -> Element:
        if not np.any(loss) and not np.any(damping):
            size = np.abs(stiffness)
            return np.asarray(stiffness), size, float(np.max(size))
        self.space.real = stiffness
        self.space.imag = loss + self.frequency * damping
        size = np.abs(self.space)
        return self.space, size, float(np.max(size))


class Stations:
    """k - w^2 J + i w c of the stations against the frame; real on a line without damping.

    As with `Branches` the last one is kept for neighbours that are alike; not to be written into.
    """

    def __init__(self, plan: Plan, frequency: FloatArray, negative: ComplexArray):
        self.plan, self.frequency, self.negative = plan, frequency, negative
        self.last: tuple[float, ...] = ()
        self.stored = negative

    def dynamic_stiffness(self, i: int) -> ComplexArray:
        """(f,), `negative` being -w^2."""
        inertia, stiffness, damping = (
            0.0 if one is None else one
            for one in (
                self.plan.inertia[i], self.plan.ground_stiffness[i], self.plan.absolute_damping[i],
            )
        )  # fmt: skip
        if (
            isinstance(inertia, np.ndarray)
            or isinstance(stiffness, np.ndarray)
            or isinstance(damping, np.ndarray)
        ):
            self.last = ()
            self.stored = self._formed(inertia, stiffness, damping)
        elif (inertia, stiffness, damping) != self.last:
            self.last = (inertia, stiffness, damping)
            self.stored = self._formed(inertia, stiffness, damping)
        return self.stored

    def _formed(
        self,
        inertia: float | FloatArray,
        stiffness: float | FloatArray,
        damping: float | FloatArray,
    ) -> ComplexArray:
        dynamic_stiffness = np.asarray(self.negative * inertia)
        if np.any(stiffness):
            dynamic_stiffness.real += stiffness
        if np.any(damping):
            np.multiply(self.frequency, damping, out=dynamic_stiffness.imag)
        return dynamic_stiffness


# ----------------------------------------------------------------------------
# Round-off of an elimination along a tree, as a running bound in magnitudes.
# ----------------------------------------------------------------------------

#: roundings of one reciprocal and two products in complex numbers
ROUNDINGS = 4.5 * EPSILON


class Check:
    """Running bound of the round-off, carried along with the elimination in magnitudes.

    `room` (2, n, f) is what it works in: memory that is asked for once. `error` (r, f) and
    `largest` (r, f) are those of the angles, over the stations so far. All errors are in units of
    `unit`, the roundings of a step at the station where most branches meet.
    """

    def __init__(self, plan: Plan, frequency: FloatArray, square: FloatArray, room: FloatArray):
        n = len(plan.inertia)
        self.room = room
        self.plan, self.frequency, self.square = plan, frequency, square
        self.children = [0] * n
        for p in plan.tree.parent:
            if p >= 0:
                self.children[p] += 1
        self.unit = ROUNDINGS + 0.5 * EPSILON * max(self.children)
        self.waiting = list(self.children)
        self.last: tuple[object, ...] | None = None
        self.stored = square
        self.stiffness: list[FloatArray | None] = [None] * n
        self.torque: list[FloatArray | None] = [None] * n
        self.share: list[FloatArray] = [square] * n
        self.turn: list[FloatArray] = [square] * n
        self.angle: list[FloatArray] = [square] * n
        self.wrong: list[FloatArray] = [square] * n
        self.error: FloatArray = np.zeros(())
        self.largest: FloatArray = np.zeros(())

    def _uncertainty_of(self, i: int) -> FloatArray:
        """Uncertainty of a station's dynamic stiffness: products, and one addition for each branch.

        That of the last station is kept for neighbours that are alike; not to be written into.
        """
        plan, branches = self.plan, self.children[i]
        inertia, stiffness, damping = (
            plan.inertia[i], plan.ground_stiffness[i], plan.absolute_damping[i],
        )  # fmt: skip
        varied = any(isinstance(one, np.ndarray) for one in (inertia, stiffness, damping))
        same = None if varied else (branches, inertia, stiffness, damping)
        if same is None or same != self.last:
            roundings = (2.0 + 0.5 * branches) * EPSILON / self.unit
            self.last = same
            self.stored = self.square * (0.0 if inertia is None else roundings * inertia)
            if stiffness is not None:
                self.stored += roundings * np.abs(stiffness)
            if damping is not None:
                self.stored += self.frequency * (roundings * damping)
        return self.stored

    def down(
        self, i: int, p: int, r: FloatArray, element: float | FloatArray, passed: ComplexArray,
        alone: ComplexArray | None,
    ) -> None:  # fmt: skip
        """Of k g / (k + g), `passed` to the parent, and of what the torque does `alone`.

        r and `element` are |1 / (k + g)| and a bound of |k|.
        """
        gathered = self.stiffness[i]
        self.stiffness[i] = None
        self.turn[i] = t = np.multiply(r, element, out=self.room[0, i])
        uncertainty = np.multiply(
            self._uncertainty_of(i) if gathered is None else gathered, r, out=gathered
        )
        self.share[i] = share = np.add(uncertainty, 1.0, out=self.room[1, i])
        if alone is not None:
            size, dynamic_stiffness = np.abs(alone), self.torque[i]
            carried = share * size
            if dynamic_stiffness is not None:
                dynamic_stiffness *= r
                carried += dynamic_stiffness
                size += dynamic_stiffness
            carried *= element
            above = self.torque[p]
            self.torque[p] = carried if above is None else np.add(above, carried, out=carried)
            self.torque[i] = size
        uncertainty *= t
        uncertainty *= element
        uncertainty += np.abs(passed)
        above = self.stiffness[p]
        uncertainty += self._uncertainty_of(p) if above is None else above
        self.stiffness[p] = uncertainty

    def root(self, i: int, x: ComplexArray, r: ComplexArray, load: ComplexArray | None) -> None:
        """Of the angle of a root with the compliance r."""
        size, dynamic_stiffness, uncertainty = np.abs(x), self.torque[i], self.stiffness[i]
        bend = np.abs(r)
        wrong = bend * (self._uncertainty_of(i) if uncertainty is None else uncertainty)
        wrong = size * (wrong + 1.0)
        if load is not None:
            rounded = np.abs(load)
            wrong += bend * (rounded if dynamic_stiffness is None else rounded + dynamic_stiffness)
        self._keep(i, size, wrong)

    def up(self, i: int, p: int, x: ComplexArray) -> None:
        """Of the angle of any other station; without a torque |x| is that of the parent times t."""
        torque, above = self.torque[i], self.wrong[p]
        t, share = self.turn[i][None], self.share[i][None]
        size = t * self.angle[p] if torque is None else np.abs(x)
        # in the room of t and of the share, unless several torques are solved together
        alone = len(above) == 1
        wrong = np.multiply(t, above, out=t if alone else None)
        wrong += np.multiply(share, size, out=share if alone else None)
        if torque is not None:
            wrong += torque
        self._keep(i, size, wrong)
        self.waiting[p] -= 1
        if self.waiting[p] == 0:
            self.angle[p] = self.square

    def _keep(self, i: int, size: FloatArray, wrong: FloatArray) -> None:
        self.angle[i], self.wrong[i] = size, wrong
        # the first one is kept as it is and must not be written into
        first = self.error.ndim == 0
        self.error = np.maximum(self.error, wrong, out=None if first else self.error)
        self.largest = np.maximum(self.largest, size, out=None if first else self.largest)


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
    """What blocks work in, (n, f) complex (or real without damping) and (2, n, f)."""

    turn: ComplexArray
    check: FloatArray


def room_for(plan: Plan, count: int, estimate: bool) -> Room:
    """Memory for blocks of so many frequencies: fresh memory takes longer than the arithmetic.

    All in one piece, and for long blocks in one for which the system hands out large pages: of
    what is asked for, only what is used is then taken, in a few steps.
    """
    n, width = len(plan.inertia), 2 if plan.damped else 1
    entries, checks = width * n * count, 2 * n * count if estimate else 0
    whole = entries + checks
    memory = np.empty(max(whole, LARGE_PAGES) if whole > LARGE_PAGES // 4 else whole)
    turn: ComplexArray = memory[:entries].view(np.complex128 if plan.damped else np.float64)
    check = memory[entries:whole].reshape(2, n, count if estimate else 0)
    return Room(turn.reshape(n, count), check)


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
    n, count = len(plan.inertia), len(frequency)
    square = frequency * frequency
    kind: type = np.complex128 if plan.damped else np.float64
    negative: ComplexArray = -square.astype(kind)
    room = room or room_for(plan, count, estimate)
    turn = room.turn[:, :count]
    check = Check(plan, frequency, square, room.check[..., :count]) if estimate else None
    acting, torque = torque, list(torque)
    ground: list[ComplexArray | None] = [None] * n
    compliance: dict[int, ComplexArray] = {}
    carried = [False] * n
    lost = np.zeros(count, dtype=bool)
    growth = np.zeros(count, dtype=bool)
    meeting: dict[int, FloatArray] = {}
    branches, stations = Branches(plan, frequency), Stations(plan, frequency, negative)
    for i in tree.order:
        p, attached, load = tree.parent[i], ground[i], torque[i]
        dynamic_stiffness = stations.dynamic_stiffness(i) if attached is None else attached
        if p < 0:
            compliance[i], free = _root(dynamic_stiffness)
            if load is not None and np.any(free):
                lost |= free & ~_balanced(load, acting)
            if i in meeting:
                growth |= ~(meeting[i] * np.abs(compliance[i]) <= GROWTH)
            continue
        element, bound, largest = branches.element(i)
        whole = np.add(dynamic_stiffness, element, out=turn[i])
        np.divide(1.0, whole, out=whole)
        size = np.abs(whole)
        if load is not None:
            # what the torque does by itself waits where the angle will be
            np.multiply(whole, load, out=angle[i])
        t = np.multiply(whole, element, out=whole)
        passed = np.multiply(dynamic_stiffness, t, out=attached)
        if not estimate and tree.parent[p] < 0:
            # what cancels at a root is a resonance of the whole line
            meeting[p] = np.maximum(meeting.get(p, 0.0), np.abs(passed))
        if not estimate and not np.max(size) * largest <= GROWTH:
            growth |= ~(np.abs(t) <= GROWTH)
        if check is not None:
            check.down(i, p, size, bound, passed, None if load is None else angle[i])
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
            carried[i] = True
    for i in reversed(tree.order):
        p, load, out = tree.parent[i], torque[i], angle[i]
        if p < 0:
            out[...] = 0.0
            if load is not None:
                np.multiply(compliance[i], load, out=out)
        elif carried[i]:
            here = turn[i : i + 1] if plan.damped and len(out) == 1 else None
            out += np.multiply(turn[i], angle[p], out=here)
        else:
            np.multiply(turn[i], angle[p], out=out)
        if check is not None:
            if p < 0:
                check.root(i, out, compliance[i], load)
            else:
                check.up(i, p, out)
    if check is None:
        nothing = np.zeros((0, 0))
        return LineSolution(angle, nothing, growth | lost, nothing)
    error = np.broadcast_to(check.error, angle.shape[1:]) * check.unit
    if lost.any():
        error[:, lost] = np.inf
    if not np.isfinite(np.max(error, initial=0.0)):
        error[np.isnan(error)] = np.inf
    return LineSolution(angle, error, growth, np.broadcast_to(check.largest, error.shape))


def _root(dynamic_stiffness: ComplexArray) -> tuple[ComplexArray, BoolArray]:
    """Compliance of a root, 0 where it is free, and where that is."""
    free: BoolArray = dynamic_stiffness == 0.0
    return np.divide(
        1.0, np.where(free, np.inf, dynamic_stiffness) if free.any() else dynamic_stiffness
    ), free


def _balanced(load: ComplexArray, acting: list[ComplexArray | None]) -> BoolArray:
    """Whether the torques (r, f) that meet at a free root are zero to rounding."""
    size = np.zeros(())
    for one in acting:
        if one is not None:
            size = size + np.abs(one)
    balanced: BoolArray = np.all(np.abs(load) <= 2.0 * len(acting) * ROUNDINGS * size, axis=0)
    return balanced
