"""March with steps that end on borders, and the record of its steps."""

from collections.abc import Sequence
from math import isfinite
from typing import NamedTuple, TypeAlias

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, BoolArray, FloatArray, IntArray
from vibecalc.numerics.runge_kutta import (
    AT_ONCE,
    DENSE,
    HALVE,
    LANDED,
    ORDER,
    SHORTEN,
    EventOutcome,
    Interval,
    State,
    System,
    at_fraction,
    borders_of,
    first_crossing,
    predict,
    step,
)

# ----------------------------------------------------------------------------
# Every step of a march, kept, and the states between them.
# ----------------------------------------------------------------------------

#: what a step leaves: begin, length, the fraction of it that counts, start, its rates, interval
_Scrap: TypeAlias = tuple[float, float, float, State, Sequence[State], Interval]


class Record(NamedTuple):
    """k steps of all members, sorted by member and time.

    Those of member m are first[m]:first[m + 1]. `begin`, `length` (k,); `start` (k, n); `dense`
    (4, k, n) as in `runge_kutta.RungeKuttaStep`; `interval` (k, p) held during the step.
    """

    first: IntArray
    begin: FloatArray
    length: FloatArray
    start: FloatArray
    dense: FloatArray
    interval: IntArray


def assemble(scraps: list[list[_Scrap]], states: int, intervals: int) -> Record:
    """The record of what the steps of each member have left."""
    first = np.cumsum([0, *(len(steps) for steps in scraps)])
    every = [one for steps in scraps for one in steps]
    if not every:
        zero = np.zeros(0)
        return Record(
            first, zero, zero, np.zeros((0, states)), np.zeros((4, 0, states)),
            np.zeros((0, intervals), dtype=np.int64),
        )  # fmt: skip
    begin, full, fraction, start, slopes, interval = (
        np.array(column) for column in zip(*every, strict=True)
    )
    dense = np.tensordot(np.array(DENSE), slopes, axes=(1, 1)) * full[:, None]
    power = fraction ** np.arange(1, 5)[:, None]
    return Record(
        first, begin, full * fraction, start, dense * power[..., None], interval.astype(np.int64)
    )


class SampledStates(NamedTuple):
    """States (m, n) at m times, and the step (m,) each of them lies in."""

    state: FloatArray
    step: IntArray


def sample(record: Record, member: int, times: FloatArray) -> SampledStates:
    """States of one member at `times` (m,) within its march.

    Where a step ends, the state before the event that followed is given up to that time.
    """
    low, high = int(record.first[member]), int(record.first[member + 1])
    begin = record.begin[low:high]
    place = np.clip(np.searchsorted(begin, times, side="left") - 1, 0, len(begin) - 1) + low
    s = ((times - record.begin[place]) / record.length[place])[:, None]
    a, b, c, d = record.dense[:, place]
    return SampledStates(record.start[place] + s * (a + s * (b + s * (c + s * d))), place)


def fine(record: Record, member: int, points: int) -> tuple[FloatArray, SampledStates]:
    """Times and states at `points` equal parts of every step of one member, and at its start."""
    low, high = int(record.first[member]), int(record.first[member + 1])
    place = np.arange(low, high)
    s = np.arange(points + 1) / points
    times = record.begin[place, None] + s * record.length[place, None]
    a, b, c, d = record.dense[:, place, None, :]
    f = s[:, None]
    states = record.start[place, None] + f * (a + f * (b + f * (c + f * d)))
    steps = np.repeat(place, points + 1)
    return times.ravel(), SampledStates(states.reshape(len(steps), -1), steps)


# ----------------------------------------------------------------------------
# March of each member with steps of its own length, which end on given times and on borders.
#
# The error of a step, fifth order less fourth, is held below the tolerance; the fifth order is
# carried on.
# ----------------------------------------------------------------------------

_SAFETY, _SMALLEST, _LARGEST = 0.9, 0.2, 5.0

#: events one after another without any time between them, after which nothing moves on
_CHATTER = 30


class MarchEnd(NamedTuple):
    """Where each member (B,) ended, and what it took.

    `time` (B,), `state` (B, n), `interval` (B, p) at the end; `finished` whether an event ended it
    before its time; `steps` and `rejected` (B,) steps taken and thrown away; `record` (None
    unless kept) holds every step.
    """

    time: FloatArray
    state: FloatArray
    interval: IntArray
    finished: BoolArray
    steps: IntArray
    rejected: IntArray
    record: Record | None


def march(
    system: System,
    time: FloatArray,
    state: FloatArray,
    interval: IntArray,
    end: FloatArray,
    *,
    absolute: FloatArray | float,
    relative: float = 0.0,
    stops: FloatArray | None = None,
    first_length: float | None = None,
    longest: float = np.inf,
    parts: int = 1,
    keep: bool = True,
    sweeps: int = 1_000_000,
) -> MarchEnd:
    """March B members from `state` (B, n), `interval` (B, p) at `time` (B,) to `end` (B,).

    The error of each step is held below `absolute` (a number or (n,)) plus `relative` times the
    state. `stops` (B, k), ascending and filled up with infinity, are times at which a step ends
    and `system.stopped` is asked. No step is longer than `longest`, nor than about the distance
    between two borders over `parts`: where borders and not the tolerance set the steps, a march
    with more parts tells the error of one with fewer.

    Raises NumericalFailure where the step falls below what rounding resolves, where the intervals
    change for ever at one time, and after `sweeps` trials of a step of one member.
    """
    count, states = state.shape
    ends = np.broadcast_to(np.asarray(end, dtype=float), (count,)).tolist()
    bounds = [[]] * count if stops is None else np.asarray(stops, dtype=float).tolist()
    sizes = np.broadcast_to(np.asarray(absolute, dtype=float), (states,)).tolist()
    scraps: list[list[_Scrap]] = [[] for _ in range(count)]
    reached = [
        _march_one(
            system, member, float(time[member]), state[member].tolist(), interval[member].tolist(),
            ends[member], bounds[member], sizes, relative, first_length, longest, parts, sweeps,
            scraps[member] if keep else None,
        )
        for member in range(count)
    ]  # fmt: skip
    times, last, held, finished, steps, rejected = zip(*reached, strict=True)
    record = assemble(scraps, states, interval.shape[1]) if keep else None
    return MarchEnd(
        np.array(times),
        np.array(last, dtype=float).reshape(count, states),
        np.array(held, dtype=np.int64).reshape(interval.shape),
        np.array(finished),
        np.array(steps),
        np.array(rejected),
        record,
    )


def _march_one(
    system: System,
    member: int,
    time: float,
    state: State,
    interval: Interval,
    end: float,
    bounds: Sequence[float],
    absolute: list[float],
    relative: float,
    first_length: float | None,
    longest: float,
    parts: int,
    sweeps: int,
    scraps: list[_Scrap] | None,
) -> tuple[float, State, Interval, bool, int, int]:
    """Time, state and interval at the end of one member; finished, steps taken, steps rejected."""
    waiting = [bound for bound in bounds if time < bound < np.inf][::-1]
    rate = system.rates(time, state, interval)
    wish = _first_length(state, rate, absolute, relative) if first_length is None else first_length
    trial = wish = min(wish, longest)
    borders = borders_of(system, interval)
    finished = stale = False
    steps = rejected = idle = 0
    widest = np.inf

    for _ in range(sweeps):
        if finished or time >= end:
            break
        if stale:
            rate = system.rates(time, state, interval)
            borders = borders_of(system, interval)
        here: Sequence[float] = ()
        length = np.inf
        if borders:
            here = system.watched(time, state, interval)
            length = predict(system, borders, here, time, state, rate, interval, trial)
        if parts > 1:
            if stale:
                widest = length / parts
            if length > 1.2 * widest:
                length = widest
        stale = False
        length = min(length, trial)
        limit = min(end, waiting[-1]) if waiting else end
        left = limit - time
        reaches = length >= left * (1.0 - 4.0 * EPSILON)
        if reaches:
            length = left

        def rates(there: float, states: State, form: Interval = interval) -> State:
            return system.rates(there, states, form)

        try:
            taken = step(rates, time, state, rate, length)
            error = _size(taken.error, state, taken.state, absolute, relative)
        except ArithmeticError:
            error = np.inf
        factor = _LARGEST
        if error > 0.0:
            factor = max(_SMALLEST, min(_LARGEST, _SAFETY * error ** (-1.0 / ORDER)))
        if error > 1.0:
            wish = trial = length * min(factor, _SAFETY)
            rejected += 1
            _resolves(trial, time)
            continue

        border = first_crossing(
            system, borders, here, time, length, state, interval, taken, reaches
        )
        finding = border.finding
        if finding in (SHORTEN, HALVE):
            trial = length * border.fraction
            rejected += 1
            _resolves(trial, time)
            continue

        event: EventOutcome | None = None
        if finding != AT_ONCE:
            landed = finding == LANDED
            part = border.fraction if landed else 1.0
            if scraps is not None:
                scraps.append((time, length, part, state, taken.slopes, interval))
            # a step cut short by a border or a stop says little of what comes next: it may only
            # grow
            wanted = length * factor
            if landed or reaches or length < trial:
                wanted = max(wish, wanted)
            trial = wish = min(wanted, longest)
            if landed:
                state = at_fraction(state, taken, length, part) if part != 1.0 else taken.state
                time += length * part
            else:
                state, rate = taken.state, taken.slopes[6]
                time = limit if reaches else time + length
                if reaches and waiting and time >= waiting[-1]:
                    waiting.pop()
                    event = system.stopped(member, time, state, interval)
            steps += 1
            idle = 0
        if finding in (AT_ONCE, LANDED):
            event = system.crossed(member, time, state, interval, border.which, border.direction)
        if event is not None:
            state, interval, over = event
            finished = finished or over
            stale = True
            idle += 1
            trial = wish
            if idle > _CHATTER:
                raise NumericalFailure(
                    f"the form of the equations changes for ever at time {time:.9g}"
                )
    else:
        raise NumericalFailure(f"not at the end after {sweeps} sweeps; the step is too short")
    return time, state, interval, finished, steps, rejected


def _size(
    error: State, start: State, there: State, absolute: list[float], relative: float
) -> float:
    """The largest error of a state over what is allowed; infinite where it is not a number."""
    if relative:
        shares = [
            abs(e) / (a + relative * max(abs(y), abs(z)))
            for e, y, z, a in zip(error, start, there, absolute, strict=True)
        ]
    else:
        shares = [abs(e) / a for e, a in zip(error, absolute, strict=True)]
    # the sum shows what is not a number, which the largest hides
    return max(shares) if isfinite(sum(shares)) else np.inf


def _first_length(state: State, rate: State, absolute: list[float], relative: float) -> float:
    fastest = max(
        abs(r) / (a + relative * abs(y)) for r, y, a in zip(rate, state, absolute, strict=True)
    )
    if not (fastest > 0.0 and isfinite(fastest)):
        return 1e-3
    # the length over which the rate alone would move by a hundredth of tolerance^(1/5)
    scale = min(absolute) + relative
    return float(0.01 * scale ** (1.0 / ORDER - 1.0) / fastest)


def _resolves(trial: float, time: float) -> None:
    """Refuse a step that rounding of the time would swallow."""
    if trial <= 16.0 * EPSILON * max(abs(time), 1e-9):
        raise NumericalFailure(
            f"no step is short enough at time {time:.9g}: the rates jump or grow without bound"
        )
