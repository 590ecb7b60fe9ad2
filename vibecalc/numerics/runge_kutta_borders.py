"""Where within a step a watched value first comes to a border of its piece."""

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from vibecalc.numerics.runge_kutta import Step
from vibecalc.numerics.runge_kutta_system import System
from vibecalc.numerics.typing import BoolArray, FloatArray, IntArray

# a value that leaves and returns between two of these is not seen: its kink is hardly touched
_LOOKS = np.array((0.25, 0.5, 0.75, 1.0))

#: so near to its end, the polynomial of a step is as good as the end itself
NEAR = 0.02

_HINT, _ROUNDS = 1e-3, 12

#: a gap within this many closenesses outside is still inside
_SLACK = 2.0

NOTHING, LANDED, SHORTEN, AT_ONCE, HALVE = range(5)

#: distances (m, 2 w) inside the lower and upper borders, of members (m,) at fractions (m,)
_Gaps: TypeAlias = Callable[[IntArray, FloatArray], FloatArray]


class Look(NamedTuple):
    """What each member (b,) finds in a step.

    `finding`: nothing; a border at `fraction` of the step, within NEAR of its end; shorten the
    step to `fraction` of it; a border is crossed at the very start; or halve the step to see more.
    `which` watched value, and `way` -1 for its lower, +1 for its upper border.
    """

    finding: IntArray
    fraction: FloatArray
    which: IntArray
    way: IntArray

    def mark(
        self, who: IntArray, finding: IntArray | int, gap: IntArray, fraction: FloatArray
    ) -> None:
        self.finding[who], self.fraction[who] = finding, fraction
        self.which[who], self.way[who] = gap // 2, 2 * (gap % 2) - 1


def predict(
    system: System,
    member: IntArray,
    time: FloatArray,
    state: FloatArray,
    rate: FloatArray,
    piece: IntArray,
    length: FloatArray,
) -> FloatArray:
    """Lengths (b,) after which the present rates meet a border; infinite where they do not.

    `length` (b,) is about that of the next step.
    """
    if not len(system.closeness):
        return np.full(len(member), np.inf)
    lower, upper = system.borders(member, piece)
    here = system.watched(member, time, state, piece)
    ahead = _HINT * length
    there = system.watched(member, time + ahead, state + ahead[:, None] * rate, piece)
    moved = there - here
    room = np.where(moved > 0.0, upper - here, lower - here)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = _HINT * room / moved
    useful = (np.abs(room) > _SLACK * system.closeness) & (share > 0.0)
    return np.asarray(length * np.min(np.where(useful, share, np.inf), axis=1))


def look(
    system: System,
    member: IntArray,
    time: FloatArray,
    length: FloatArray,
    start: FloatArray,
    piece: IntArray,
    taken: Step,
    fixed: BoolArray,
) -> Look:
    """Look along the steps `taken` of b members from `start` (b, n).

    `fixed` (b,) are those that must not be lengthened.
    """
    count = len(member)
    none = np.zeros(count, dtype=np.int64)
    result = Look(none, np.ones(count), none.copy(), none.copy())
    closeness = np.repeat(system.closeness, 2)
    if not len(closeness) or not count:
        return result
    lower, upper = system.borders(member, piece)

    def gaps(who: IntArray, fraction: FloatArray) -> FloatArray:
        a, b, c, d = taken.dense[:, who]
        s = fraction[:, None]
        states = start[who] + s * (a + s * (b + s * (c + s * d)))
        there = time[who] + fraction * length[who]
        value = system.watched(member[who], there, states, piece[who])
        both = np.empty((len(who), value.shape[1], 2))
        both[:, :, 0], both[:, :, 1] = value - lower[who], upper[who] - value
        return both.reshape(len(who), -1)

    every = np.tile(np.arange(count), 1 + len(_LOOKS))
    places = np.repeat(np.concatenate([[0.0], _LOOKS]), count)
    seen = gaps(every, places).reshape(1 + len(_LOOKS), count, -1)
    at_start, seen = seen[0], seen[1:]
    outside = seen < -_SLACK * closeness
    leaves = outside.any(axis=(0, 2))

    # about to arrive: the rest of the way is as good as a part of this step
    ahead = (at_start > _SLACK * closeness) & ~(leaves | fixed)[:, None]
    with np.errstate(invalid="ignore"):
        closing = 0.25 * seen[-1] < NEAR * (seen[-2] - seen[-1])
    who, gap = np.nonzero(ahead & closing)
    if len(who):
        end = seen[-1][who, gap]
        beyond = gaps(who, np.full(len(who), 1.0 + NEAR))[np.arange(len(who)), gap]
        arrives = beyond <= 0.0
        who, gap, end, beyond = who[arrives], gap[arrives], end[arrives], beyond[arrives]
        _first_roots(
            result, gaps, who, gap, np.ones(len(who)), np.full(len(who), 1.0 + NEAR), end, beyond,
            closeness,
        )  # fmt: skip
    out = np.nonzero(leaves)[0]
    if len(out):
        _leaving(result, gaps, out, at_start, seen, outside, closeness)
    return result


def _leaving(
    result: Look,
    gaps: _Gaps,
    out: IntArray,
    at_start: FloatArray,
    seen: FloatArray,
    outside: BoolArray,
    closeness: FloatArray,
) -> None:
    """Fill in the first crossing of the members `out`, which have a gap below zero at a look."""
    first = np.argmax(np.any(outside[:, out], axis=2), axis=0)
    row, gap = np.nonzero(outside[first, out])
    who, place = out[row], first[row]
    beginning = place == 0
    low = np.where(beginning, 0.0, _LOOKS[place - 1])
    f_low = np.where(beginning, at_start[who, gap], seen[place - 1, who, gap])
    f_high = seen[place, who, gap]
    on_it = beginning & (f_low <= _SLACK * closeness[gap])
    if np.any(on_it):
        some = np.nonzero(on_it)[0]
        hint = gaps(who[some], np.full(len(some), _HINT))[np.arange(len(some)), gap[some]]
        leaving = hint <= f_low[some]
        for finding, chosen in ((HALVE, some[~leaving]), (AT_ONCE, some[leaving])):
            result.mark(who[chosen], finding, gap[chosen], np.zeros(len(chosen)))
        # who leaves at once or halves is not to be shortened by another gap
        left = ~np.isin(who, who[some])
        who, gap, low, place = who[left], gap[left], low[left], place[left]
        f_low, f_high = f_low[left], f_high[left]
    _first_roots(result, gaps, who, gap, low, _LOOKS[place], f_low, f_high, closeness)


def _first_roots(
    result: Look,
    gaps: _Gaps,
    who: IntArray,
    gap: IntArray,
    low: FloatArray,
    high: FloatArray,
    f_low: FloatArray,
    f_high: FloatArray,
    closeness: FloatArray,
) -> None:
    """Mark the members `who` with the first roots of their gaps, between `low` and `high`.

    Regula falsi that halves the value of an end that stays twice (Illinois).
    """
    if not len(who):
        return
    rows, close = np.arange(len(who)), 0.5 * closeness[gap]
    root, side = high, np.zeros(len(who), dtype=np.int64)
    for _ in range(_ROUNDS):
        with np.errstate(divide="ignore", invalid="ignore"):
            root = (low * f_high - high * f_low) / (f_high - f_low)
        root = np.where((root > low) & (root < high), root, 0.5 * (low + high))
        value = gaps(who, root)[rows, gap]
        if np.all(np.abs(value) <= close):
            break
        below = value < 0.0
        f_low = np.where(below, np.where(side < 0, 0.5 * f_low, f_low), value)
        f_high = np.where(below, value, np.where(side > 0, 0.5 * f_high, f_high))
        side = np.where(below, -1, 1)
        low, high = np.where(below, low, root), np.where(below, root, high)
    # of several borders the first wins: it is written last
    order = np.argsort(-root, kind="stable")
    who, gap, root = who[order], gap[order], root[order]
    result.mark(who, np.where(root < 1.0 - NEAR, SHORTEN, LANDED), gap, root)
