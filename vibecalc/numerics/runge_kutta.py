"""Runge-Kutta steps of order 5 with dense output for rates that change form at borders."""

from collections.abc import Callable
from typing import NamedTuple, Protocol, TypeAlias

import numpy as np

from vibecalc.numerics.rounding import BoolArray, FloatArray, IntArray

# ----------------------------------------------------------------------------
# What `runge_kutta_march` integrates: rates that change form where watched values meet borders.
#
# A right-hand side with kinks (tables, friction) is given interval by interval: `interval` says for
# each member which smooth form holds, and that form is continued beyond its borders while a step is
# tried. The march ends a step on every border, tells the system, and goes on with the new one, so
# that no step has a kink inside and the order of the method is kept.
# ----------------------------------------------------------------------------


class EventOutcome(NamedTuple):
    """What follows an event: states (b, n), intervals (b, p), which members (b,) have finished."""

    state: FloatArray
    interval: IntArray
    finished: BoolArray


class System(Protocol):
    """b members of B, named by their index `member` (b,), with n states and w watched values.

    `closeness` (w,) is how near to a border counts as on it, in the unit of the watched value.
    """

    closeness: FloatArray

    def rates(
        self, member: IntArray, time: FloatArray, state: FloatArray, interval: IntArray
    ) -> FloatArray:
        """Rates (b, n) of the states."""
        ...

    def watched(
        self, member: IntArray, time: FloatArray, state: FloatArray, interval: IntArray
    ) -> FloatArray:
        """The watched values (b, w)."""
        ...

    def borders(self, member: IntArray, interval: IntArray) -> tuple[FloatArray, FloatArray]:
        """Least and largest watched values (b, w) of the intervals."""
        ...

    def crossed(
        self,
        member: IntArray,
        time: FloatArray,
        state: FloatArray,
        interval: IntArray,
        which: IntArray,
        direction: IntArray,
    ) -> EventOutcome:
        """Watched value `which` (b,) is at its lower (`direction` -1) or upper (+1) border."""
        ...

    def stopped(
        self, member: IntArray, time: FloatArray, state: FloatArray, interval: IntArray
    ) -> EventOutcome:
        """One of the times at which the march was set to end a step is reached."""
        ...


# ----------------------------------------------------------------------------
# One step of the embedded pair of order 5 and 4 with its dense output, for many members at once.
#
# The pair is that of Dormand and Prince (1980); the polynomial between the ends of a step, of
# fourth degree and a local error of fifth order, is that of Shampine (1986). `runge_kutta_march`
# repeats the step with a length of its own for each member.
# ----------------------------------------------------------------------------

#: order of the solution that is carried on; its error estimate shrinks like the length to this
ORDER = 5

FRACTION = (0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0)
_STAGE = tuple(
    np.array(row)
    for row in (
        (1 / 5,),
        (3 / 40, 9 / 40),
        (44 / 45, -56 / 15, 32 / 9),
        (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
        (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
        (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
    )
)
# fifth order less fourth, over the seven rates
_ERROR = np.array((71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40))
# at the fraction s of a step of length h: y + h sum_j s^(j+1) (row j of this) @ rates
_DENSE = np.array(
    (
        (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        (
            -8048581381 / 2820520608,
            0.0,
            131558114200 / 32700410799,
            -1754552775 / 470086768,
            127303824393 / 49829197408,
            -282668133 / 205662961,
            40617522 / 29380423,
        ),
        (
            8663915743 / 2820520608,
            0.0,
            -68118460800 / 10900136933,
            14199869525 / 1410260304,
            -318862633887 / 49829197408,
            2019193451 / 616988883,
            -110615467 / 29380423,
        ),
        (
            -12715105075 / 11282082432,
            0.0,
            87487479700 / 32700410799,
            -10690763975 / 1880347072,
            701980252875 / 199316789632,
            -1453857185 / 822651844,
            69997945 / 29380423,
        ),
    )
)

#: rates (b, n) of the states (b, n) at the times (b,)
Rates = Callable[[FloatArray, FloatArray], FloatArray]


class RungeKuttaStep(NamedTuple):
    """State and rate (b, n) at the end of a step, the error (b, n) of the step, and between.

    `dense` (4, b, n): the state at the fraction s is start + sum_j dense[j] s^(j + 1).
    """

    state: FloatArray
    rate: FloatArray
    error: FloatArray
    dense: FloatArray


def step(
    rates: Rates, time: FloatArray, state: FloatArray, rate: FloatArray, length: FloatArray
) -> RungeKuttaStep:
    """Take one step of `length` (b,) from `state` (b, n), whose rate is `rate`, at `time` (b,)."""
    shape = state.shape
    slopes = np.empty((7, *shape))
    slopes[0] = rate
    flat = slopes.reshape(7, -1)
    long = length[:, None]
    for number, row in enumerate(_STAGE, start=1):
        state_there = state + long * (row @ flat[:number]).reshape(shape)
        slopes[number] = rates(time + FRACTION[number] * length, state_there)
    error = long * (_ERROR @ flat).reshape(shape)
    dense = long * (_DENSE @ flat).reshape(4, *shape)
    return RungeKuttaStep(state_there, slopes[6], error, dense)


def at_fraction(start: FloatArray, dense: FloatArray, fraction: FloatArray) -> FloatArray:
    """States (b, m, n) at the fractions (b, m) or (m,) of steps from `start` (b, n)."""
    s = fraction[..., None]
    a, b, c, d = dense[:, :, None, :]
    return np.asarray(start[:, None, :] + s * (a + s * (b + s * (c + s * d))))


# ----------------------------------------------------------------------------
# Where within a step a watched value first comes to a border of its interval.
# ----------------------------------------------------------------------------

# a value that leaves and returns between two of these is not seen: its kink is hardly touched
_SAMPLES = np.array((0.25, 0.5, 0.75, 1.0))

#: so near to its end, the polynomial of a step is as good as the end itself
NEAR = 0.02

_HINT, _ROUNDS = 1e-3, 12

#: a gap within this many closenesses outside is still inside
_SLACK = 2.0

NOTHING, LANDED, SHORTEN, AT_ONCE, HALVE = range(5)

#: distances (m, 2 w) inside the lower and upper borders, of members (m,) at fractions (m,)
_Gaps: TypeAlias = Callable[[IntArray, FloatArray], FloatArray]


class BorderCrossings(NamedTuple):
    """What each member (b,) finds in a step.

    `finding`: nothing; a border at `fraction` of the step, within NEAR of its end; shorten the
    step to `fraction` of it; a border is crossed at the very start; or halve the step to see more.
    `which` watched value, and `direction` -1 for its lower, +1 for its upper border.
    """

    finding: IntArray
    fraction: FloatArray
    which: IntArray
    direction: IntArray

    def mark(
        self, who: IntArray, finding: IntArray | int, gap: IntArray, fraction: FloatArray
    ) -> None:
        self.finding[who], self.fraction[who] = finding, fraction
        self.which[who], self.direction[who] = gap // 2, 2 * (gap % 2) - 1


def predict(
    system: System,
    member: IntArray,
    time: FloatArray,
    state: FloatArray,
    rate: FloatArray,
    interval: IntArray,
    length: FloatArray,
) -> FloatArray:
    """Lengths (b,) after which the present rates meet a border; infinite where they do not.

    `length` (b,) is about that of the next step.
    """
    if not len(system.closeness):
        return np.full(len(member), np.inf)
    lower, upper = system.borders(member, interval)
    here = system.watched(member, time, state, interval)
    ahead = _HINT * length
    there = system.watched(member, time + ahead, state + ahead[:, None] * rate, interval)
    moved = there - here
    room = np.where(moved > 0.0, upper - here, lower - here)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = _HINT * room / moved
    useful = (np.abs(room) > _SLACK * system.closeness) & (share > 0.0)
    return np.asarray(length * np.min(np.where(useful, share, np.inf), axis=1))


def first_crossings(
    system: System,
    member: IntArray,
    time: FloatArray,
    length: FloatArray,
    start: FloatArray,
    interval: IntArray,
    taken: RungeKuttaStep,
    fixed: BoolArray,
) -> BorderCrossings:
    """First crossings along the steps `taken` of b members from `start` (b, n).

    `fixed` (b,) are those that must not be lengthened.
    """
    count = len(member)
    none = np.zeros(count, dtype=np.int64)
    result = BorderCrossings(none, np.ones(count), none.copy(), none.copy())
    closeness = np.repeat(system.closeness, 2)
    if not len(closeness) or not count:
        return result
    lower, upper = system.borders(member, interval)

    def gaps(who: IntArray, fraction: FloatArray) -> FloatArray:
        a, b, c, d = taken.dense[:, who]
        s = fraction[:, None]
        states = start[who] + s * (a + s * (b + s * (c + s * d)))
        there = time[who] + fraction * length[who]
        value = system.watched(member[who], there, states, interval[who])
        both = np.empty((len(who), value.shape[1], 2))
        both[:, :, 0], both[:, :, 1] = value - lower[who], upper[who] - value
        return both.reshape(len(who), -1)

    every = np.tile(np.arange(count), 1 + len(_SAMPLES))
    places = np.repeat(np.concatenate([[0.0], _SAMPLES]), count)
    gap_at = gaps(every, places).reshape(1 + len(_SAMPLES), count, -1)
    at_start, gap_at = gap_at[0], gap_at[1:]
    outside = gap_at < -_SLACK * closeness
    leaves = outside.any(axis=(0, 2))

    # about to arrive: what is left is as good as a part of this step
    ahead = (at_start > _SLACK * closeness) & ~(leaves | fixed)[:, None]
    with np.errstate(invalid="ignore"):
        closing = 0.25 * gap_at[-1] < NEAR * (gap_at[-2] - gap_at[-1])
    who, gap = np.nonzero(ahead & closing)
    if len(who):
        end = gap_at[-1][who, gap]
        beyond = gaps(who, np.full(len(who), 1.0 + NEAR))[np.arange(len(who)), gap]
        arrives = beyond <= 0.0
        who, gap, end, beyond = who[arrives], gap[arrives], end[arrives], beyond[arrives]
        _first_roots(
            result, gaps, who, gap, np.ones(len(who)), np.full(len(who), 1.0 + NEAR), end, beyond,
            closeness,
        )  # fmt: skip
    out = np.nonzero(leaves)[0]
    if len(out):
        _leaving(result, gaps, out, at_start, gap_at, outside, closeness)
    return result


def _leaving(
    result: BorderCrossings,
    gaps: _Gaps,
    out: IntArray,
    at_start: FloatArray,
    gap_at: FloatArray,
    outside: BoolArray,
    closeness: FloatArray,
) -> None:
    """Fill in the first crossing of the members `out`, which have a gap below zero at a sample."""
    first = np.argmax(np.any(outside[:, out], axis=2), axis=0)
    row, gap = np.nonzero(outside[first, out])
    who, place = out[row], first[row]
    beginning = place == 0
    low = np.where(beginning, 0.0, _SAMPLES[place - 1])
    f_low = np.where(beginning, at_start[who, gap], gap_at[place - 1, who, gap])
    f_high = gap_at[place, who, gap]
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
    _first_roots(result, gaps, who, gap, low, _SAMPLES[place], f_low, f_high, closeness)


def _first_roots(
    result: BorderCrossings,
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
