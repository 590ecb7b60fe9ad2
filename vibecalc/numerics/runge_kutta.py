"""Runge-Kutta steps of order 5 with dense output for rates that change form at borders."""

from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol, TypeAlias

import numpy as np

# ----------------------------------------------------------------------------
# What `runge_kutta_march` integrates: rates that change form where watched values meet borders.
#
# A right-hand side with kinks (tables, friction) is given interval by interval: `interval` says
# which smooth form holds, and that form is continued beyond its borders while a step is tried. The
# march ends a step on every border, tells the system, and goes on with the new one, so that no step
# has a kink inside and the order of the method is kept.
#
# All of it is in plain floats: of a system with few states an array operation costs as much as a
# whole stage.
# ----------------------------------------------------------------------------

#: the states of a member, and the numbers of its intervals
State: TypeAlias = list[float]
Interval: TypeAlias = list[int]


class EventOutcome(NamedTuple):
    """What follows an event: state (n,), interval (p,), and whether the member has finished."""

    state: State
    interval: Interval
    finished: bool


class System(Protocol):
    """Members with n states and w watched values, of which one is marched at a time.

    `closeness` (w,) is how near to a border counts as on it, in the unit of the watched value.
    The watched values hang on the time and on the first `leading` states.
    """

    closeness: Sequence[float]
    leading: int

    def rates(self, time: float, state: State, interval: Interval) -> State:
        """Rates (n,) of the states."""
        ...

    def watched(self, time: float, state: Sequence[float], interval: Interval) -> Sequence[float]:
        """The watched values (w,), of the first `leading` states or more."""
        ...

    def borders(self, interval: Interval) -> tuple[Sequence[float], Sequence[float]]:
        """Least and largest watched values (w,) of the interval, infinite where there is none."""
        ...

    def crossed(
        self,
        member: int,
        time: float,
        state: State,
        interval: Interval,
        which: int,
        direction: int,
    ) -> EventOutcome:
        """Watched value `which` is at its lower (`direction` -1) or upper (+1) border."""
        ...

    def stopped(self, member: int, time: float, state: State, interval: Interval) -> EventOutcome:
        """One of the times at which the march was set to end a step is reached."""
        ...


# ----------------------------------------------------------------------------
# One step of the embedded pair of order 5 and 4 with its dense output.
#
# The pair is that of Dormand and Prince (1980); the polynomial between the ends of a step, of
# fourth degree and a local error of fifth order, is that of Shampine (1986).
# ----------------------------------------------------------------------------

#: order of the solution that is carried on; its error estimate shrinks like the length to this
ORDER = 5

#: each stage from the earlier ones; the last of them is the end of the step
STAGES = (
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
)
# fifth order less fourth, over the seven rates
_ERROR = (71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)
#: at the fraction s of a step of length h: y + h sum_j s^(j+1) (row j of this) @ rates
DENSE = (
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

#: rates (n,) of the states (n,) at a time
Rates = Callable[[float, State], State]


class RungeKuttaStep(NamedTuple):
    """State (n,) at the end of a step, its seven rates (7, n), and the error (n,) of the step.

    The last of the rates is that at the end.
    """

    state: State
    slopes: tuple[State, State, State, State, State, State, State]
    error: State


def step(rates: Rates, time: float, state: State, rate: State, length: float) -> RungeKuttaStep:
    """Take one step of `length` from `state` (n,), whose rate is `rate`, at `time`."""
    h = length
    a = h * STAGES[0][0]
    second = rates(time + 0.2 * h, [y + a * p for y, p in zip(state, rate, strict=True)])
    a, b = (h * c for c in STAGES[1])
    third = rates(
        time + 0.3 * h,
        [y + a * p + b * q for y, p, q in zip(state, rate, second, strict=True)],
    )
    a, b, c = (h * c for c in STAGES[2])
    fourth = rates(
        time + 0.8 * h,
        [y + a * p + b * q + c * r for y, p, q, r in zip(state, rate, second, third, strict=True)],
    )
    a, b, c, d = (h * c for c in STAGES[3])
    fifth = rates(
        time + 8 / 9 * h,
        [
            y + a * p + b * q + c * r + d * s
            for y, p, q, r, s in zip(state, rate, second, third, fourth, strict=True)
        ],
    )
    a, b, c, d, e = (h * c for c in STAGES[4])
    sixth = rates(
        time + h,
        [
            y + a * p + b * q + c * r + d * s + e * t
            for y, p, q, r, s, t in zip(state, rate, second, third, fourth, fifth, strict=True)
        ],
    )
    # the second rate counts neither in the result nor in its error
    a, _, c, d, e, f = (h * c for c in STAGES[5])
    there = [
        y + a * p + c * r + d * s + e * t + f * u
        for y, p, r, s, t, u in zip(state, rate, third, fourth, fifth, sixth, strict=True)
    ]
    last = rates(time + h, there)
    a, _, c, d, e, f, g = (h * c for c in _ERROR)
    error = [
        a * p + c * r + d * s + e * t + f * u + g * v
        for p, r, s, t, u, v in zip(rate, third, fourth, fifth, sixth, last, strict=True)
    ]
    return RungeKuttaStep(there, (rate, second, third, fourth, fifth, sixth, last), error)


def at_fraction(start: State, taken: RungeKuttaStep, length: float, fraction: float) -> State:
    """State (n,) at a fraction of a step of `length` from `start` (n,)."""
    s, scale = fraction, length * fraction
    a, _, c, d, e, f, g = (
        scale * (one + s * (two + s * (three + s * four)))
        for one, two, three, four in zip(*DENSE, strict=True)
    )
    rate, _, third, fourth, fifth, sixth, last = taken.slopes
    return [
        y + a * p + c * r + d * q + e * t + f * u + g * v
        for y, p, r, q, t, u, v in zip(start, rate, third, fourth, fifth, sixth, last, strict=True)
    ]


# ----------------------------------------------------------------------------
# Where within a step a watched value first comes to a border of its interval.
# ----------------------------------------------------------------------------

# a value that leaves and returns between two of these is not seen: its kink is hardly touched
_SAMPLES = (0.25, 0.5, 0.75, 1.0)

#: so near to its end, the polynomial of a step is as good as the end itself
NEAR = 0.02

_HINT, _ROUNDS = 1e-3, 12

#: a gap within this many closenesses outside is still inside
_SLACK = 2.0

NOTHING, LANDED, SHORTEN, AT_ONCE, HALVE = range(5)


class Border(NamedTuple):
    """A border of the watched value `which`, its lower (`direction` -1) or its upper (+1) one.

    `close` is how near counts as on it.
    """

    which: int
    direction: int
    value: float
    close: float


def borders_of(system: System, interval: Interval) -> list[Border]:
    """The borders of an interval that are finite."""
    lower, upper = system.borders(interval)
    found = []
    for which, (low, high, close) in enumerate(zip(lower, upper, system.closeness, strict=True)):
        if low > -np.inf:
            found.append(Border(which, -1, low, close))
        if high < np.inf:
            found.append(Border(which, 1, high, close))
    return found


def predict(
    system: System,
    borders: list[Border],
    here: Sequence[float],
    time: float,
    state: State,
    rate: State,
    interval: Interval,
    length: float,
) -> float:
    """Length after which the present rates meet a border; infinite where they do not.

    `here` are the watched values at `state`, `length` is about that of the next step.
    """
    ahead = _HINT * length
    count = system.leading
    moved = [y + ahead * r for y, r in zip(state[:count], rate[:count], strict=True)]
    there = system.watched(time + ahead, moved, interval)
    share = np.inf
    for which, direction, value, close in borders:
        room, went = direction * (value - here[which]), direction * (there[which] - here[which])
        if went > 0.0 and room > _SLACK * close:
            share = min(share, room / went)
    return ahead * share


class BorderCrossing(NamedTuple):
    """What is found in a step.

    `finding`: nothing; a border at `fraction` of the step, within NEAR of its end; shorten the
    step to `fraction` of it; a border is crossed at the very start; or halve the step to see more.
    `which` watched value, and `direction` -1 for its lower, +1 for its upper border.
    """

    finding: int
    fraction: float
    which: int
    direction: int


_NO_CROSSING = BorderCrossing(NOTHING, 1.0, 0, 0)

#: the watched values (w,) at a fraction of a step
_WatchedAt: TypeAlias = Callable[[float], Sequence[float]]


def first_crossing(
    system: System,
    borders: list[Border],
    here: Sequence[float],
    time: float,
    length: float,
    start: State,
    interval: Interval,
    taken: RungeKuttaStep,
    fixed: bool,
) -> BorderCrossing:
    """First crossing along the step `taken` from `start` (n,), where the values were `here`.

    A `fixed` step must not be lengthened.
    """
    if not borders:
        return _NO_CROSSING
    curves = _curves(start[: system.leading], taken, length)
    watched = system.watched

    def at(s: float) -> Sequence[float]:
        states = [y + s * (a + s * (b + s * (c + s * d))) for y, a, b, c, d in curves]
        return watched(time + s * length, states, interval)

    seen = [here]
    for place, sample in enumerate(_SAMPLES):
        values = at(sample)
        seen.append(values)
        outside = [
            border
            for border in borders
            if border[1] * (values[border[0]] - border[2]) > _SLACK * border[3]
        ]
        if outside:
            before = 0.0 if place == 0 else _SAMPLES[place - 1]
            return _leaving(at, outside, before, sample, seen[-2], values)
    found = _NO_CROSSING
    if fixed:
        return found
    # about to arrive: what is left is as good as a part of this step
    near, end = seen[-2], seen[-1]
    for border in borders:
        which, direction, value, close = border
        gap = direction * (value - end[which])
        closing = 0.25 * gap < NEAR * direction * (end[which] - near[which])
        if closing and direction * (value - here[which]) > _SLACK * close:
            beyond = direction * (value - at(1.0 + NEAR)[which])
            if beyond <= 0.0:
                root = _root(at, border, 1.0, 1.0 + NEAR, gap, beyond)
                if found.finding == NOTHING or root < found.fraction:
                    found = BorderCrossing(LANDED, root, which, direction)
    return found


def _curves(
    start: State, taken: RungeKuttaStep, length: float
) -> list[tuple[float, float, float, float, float]]:
    """Value and four coefficients of the polynomial over the step, of each state of `start`."""
    rate, _, third, fourth, fifth, sixth, last = taken.slopes
    h = length
    _, (a2, _, c2, d2, e2, f2, g2), (a3, _, c3, d3, e3, f3, g3), (a4, _, c4, d4, e4, f4, g4) = DENSE
    return [
        (
            y,
            h * p,
            h * (a2 * p + c2 * r + d2 * s + e2 * t + f2 * u + g2 * v),
            h * (a3 * p + c3 * r + d3 * s + e3 * t + f3 * u + g3 * v),
            h * (a4 * p + c4 * r + d4 * s + e4 * t + f4 * u + g4 * v),
        )
        for y, p, r, s, t, u, v in zip(start, rate, third, fourth, fifth, sixth, last, strict=False)
    ]


def _leaving(
    at: _WatchedAt,
    outside: list[Border],
    low: float,
    high: float,
    at_low: Sequence[float],
    at_high: Sequence[float],
) -> BorderCrossing:
    """The first crossing of the borders `outside` of which the values are at the sample `high`."""
    found = None
    for which, direction, value, close in outside:
        gap = direction * (value - at_low[which])
        if low == 0.0 and gap <= _SLACK * close:
            if direction * (value - at(_HINT)[which]) <= gap:
                return BorderCrossing(AT_ONCE, 0.0, which, direction)
            found = BorderCrossing(HALVE, 0.5, which, direction)
    # who leaves at once or halves is not to be shortened by another border
    if found is not None:
        return found
    first, crossed = np.inf, outside[0]
    for border in outside:
        which, direction, value, _ = border
        root = _root(
            at, border, low, high,
            direction * (value - at_low[which]), direction * (value - at_high[which]),
        )  # fmt: skip
        if root < first:
            first, crossed = root, border
    return BorderCrossing(
        SHORTEN if first < 1.0 - NEAR else LANDED, first, crossed.which, crossed.direction
    )


def _root(
    at: _WatchedAt, border: Border, low: float, high: float, f_low: float, f_high: float
) -> float:
    """The root between `low` and `high` of the gap to a border, with these values there.

    Regula falsi that halves the value of an end that stays twice (Illinois).
    """
    which, direction, level, close = border
    root, side = high, 0
    for _ in range(_ROUNDS):
        root = (low * f_high - high * f_low) / (f_high - f_low) if f_high != f_low else high
        if not low < root < high:
            root = 0.5 * (low + high)
        value = direction * (level - at(root)[which])
        if abs(value) <= 0.5 * close:
            break
        if value < 0.0:
            f_low = 0.5 * f_low if side < 0 else f_low
            high, f_high, side = root, value, -1
        else:
            f_high = 0.5 * f_high if side > 0 else f_high
            low, f_low, side = root, value, 1
    return root
