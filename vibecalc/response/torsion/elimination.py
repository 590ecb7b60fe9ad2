"""Elimination along a tree of freedoms, at many frequencies at once.

A sub-line that hangs on its parent by an element k has the dynamic stiffness g of its station;
seen from the parent it is k g / (k + g). That form (torque over angle, as in Riccati's transfer
matrix) never subtracts the large stiffnesses from each other, so that soft modes of stiff lines
keep their digits. What can go wrong is a resonance of an eliminated sub-line, k + g near zero:
its growth is measured, and the caller takes another root then.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import BoolArray, ComplexArray, FloatArray
from vibecalc.response.torsion.elimination_branches import Branches, Stations
from vibecalc.response.torsion.elimination_check import ROUNDINGS, Check
from vibecalc.response.torsion.elimination_plan import Plan

#: growth of one step at which four digits are lost
GROWTH = 1e4
#: numbers of a piece of memory from which on numpy asks the system for large pages
LARGE_PAGES = 1 << 19


class Solution(NamedTuple):
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
    piece = np.empty(max(whole, LARGE_PAGES) if whole > LARGE_PAGES // 4 else whole)
    turn: ComplexArray = piece[:entries].view(np.complex128 if plan.damped else np.float64)
    check = piece[entries:whole].reshape(2, n, count if estimate else 0)
    return Room(turn.reshape(n, count), check)


def eliminate(
    plan: Plan,
    frequency: FloatArray,
    torque: list[ComplexArray | None],
    estimate: bool,
    angle: ComplexArray,
    room: Room | None = None,
) -> Solution:
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
        p, hung, load = tree.parent[i], ground[i], torque[i]
        own = stations.own(i) if hung is None else hung
        if p < 0:
            compliance[i], free = _root(own)
            if load is not None and np.any(free):
                lost |= free & ~_balanced(load, acting)
            if i in meeting:
                growth |= ~(meeting[i] * np.abs(compliance[i]) <= GROWTH)
            continue
        element, bound, largest = branches.element(i)
        whole = np.add(own, element, out=turn[i])
        np.divide(1.0, whole, out=whole)
        size = np.abs(whole)
        if load is not None:
            # what the torque does by itself waits where the angle will be
            np.multiply(whole, load, out=angle[i])
        t = np.multiply(whole, element, out=whole)
        passed = np.multiply(own, t, out=hung)
        if not estimate and tree.parent[p] < 0:
            # what cancels at a root is a resonance of the whole line
            meeting[p] = np.maximum(meeting.get(p, 0.0), np.abs(passed))
        if not estimate and not np.max(size) * largest <= GROWTH:
            growth |= ~(np.abs(t) <= GROWTH)
        if check is not None:
            check.down(i, p, size, bound, passed, None if load is None else angle[i])
        above = ground[p]
        ground[p] = np.add(passed, stations.own(p) if above is None else above, out=passed)
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
        return Solution(angle, nothing, growth | lost, nothing)
    error = np.broadcast_to(check.error, angle.shape[1:]) * check.unit
    if lost.any():
        error[:, lost] = np.inf
    if not np.isfinite(np.max(error, initial=0.0)):
        error[np.isnan(error)] = np.inf
    return Solution(angle, error, growth, np.broadcast_to(check.largest, error.shape))


def _root(own: ComplexArray) -> tuple[ComplexArray, BoolArray]:
    """Compliance of a root, 0 where it is free, and where that is."""
    free: BoolArray = own == 0.0
    return np.divide(1.0, np.where(free, np.inf, own) if free.any() else own), free


def _balanced(load: ComplexArray, acting: list[ComplexArray | None]) -> BoolArray:
    """Whether the torques (r, f) that meet at a free root are zero to rounding."""
    size = np.zeros(())
    for one in acting:
        if one is not None:
            size = size + np.abs(one)
    balanced: BoolArray = np.all(np.abs(load) <= 2.0 * len(acting) * ROUNDINGS * size, axis=0)
    return balanced
