"""Elimination in the equations of a shaft line along a tree, at many frequencies at once."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import BoolArray, ComplexArray, FloatArray
from vibecalc.torsion.tree_plan import ROUNDINGS, Branches, Plan, Stations, Tree

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
