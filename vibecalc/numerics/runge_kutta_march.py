"""Batch march with steps of each member's own length, and the record of its steps."""

from typing import NamedTuple, TypeAlias

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, BoolArray, FloatArray, IntArray
from vibecalc.numerics.runge_kutta import (
    AT_ONCE,
    HALVE,
    LANDED,
    NOTHING,
    ORDER,
    SHORTEN,
    RungeKuttaStep,
    System,
    at_fraction,
    first_crossings,
    predict,
    step,
)

# ----------------------------------------------------------------------------
# Every step of a march, kept, and the states between them.
# ----------------------------------------------------------------------------

#: what one sweep leaves: members, begin, length, start, dense, interval of the steps taken
Scraps: TypeAlias = list[tuple[IntArray, FloatArray, FloatArray, FloatArray, FloatArray, IntArray]]


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


def assemble(scraps: Scraps, members: int, states: int, intervals: int) -> Record:
    """The record of what the sweeps have left."""
    if not scraps:
        zero = np.zeros(0)
        return Record(
            np.zeros(members + 1, dtype=np.int64), zero, zero, np.zeros((0, states)),
            np.zeros((4, 0, states)), np.zeros((0, intervals), dtype=np.int64),
        )  # fmt: skip
    member, begin, length, start, dense, interval = zip(*scraps, strict=True)
    who = np.concatenate(member)
    order = np.argsort(who, kind="stable")
    first = np.concatenate([[0], np.cumsum(np.bincount(who, minlength=members))])
    return Record(
        first,
        np.concatenate(begin)[order],
        np.concatenate(length)[order],
        np.concatenate(start)[order],
        np.concatenate(dense, axis=1)[:, order],
        np.concatenate(interval)[order],
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
# Batch march with steps of each member's own length that end on given times and on borders.
#
# One sweep takes one step of every member that has not finished, in one pass of the arrays. The
# error of a step, fifth order less fourth, is held below the tolerance; the fifth order goes on.
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
    change for ever at one time, and after `sweeps` sweeps.
    """
    time, state, interval = time.astype(float), state.astype(float), interval.copy()
    count = len(time)
    end = np.broadcast_to(np.asarray(end, dtype=float), (count,))
    bounds = np.full((count, 1), np.inf) if stops is None else np.asarray(stops, dtype=float)
    bounds = np.concatenate([bounds, np.full((count, 1), np.inf)], axis=1)
    following = np.sum(bounds <= time[:, None], axis=1)
    everyone = np.arange(count)
    rate = system.rates(everyone, time, state, interval)
    guess = _first_length(state, rate, absolute, relative)
    wish = guess if first_length is None else np.full(count, first_length)
    wish = np.minimum(wish, longest)
    trial = wish.copy()
    finished, stale = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
    steps, rejected = np.zeros(count, dtype=np.int64), np.zeros(count, dtype=np.int64)
    idle = np.zeros(count, dtype=np.int64)
    scraps: Scraps = []
    widest = np.full(count, np.inf)

    def settle(who: IntArray, which: IntArray | None, direction: IntArray | None) -> None:
        """Let the system answer an event of the members `who`, at their present states."""
        place = (who, time[who], state[who], interval[who])
        if which is None or direction is None:
            change = system.stopped(*place)
        else:
            change = system.crossed(*place, which, direction)
        state[who], interval[who] = change.state, change.interval
        finished[who] |= change.finished
        stale[who] = True
        idle[who] += 1
        trial[who] = wish[who]
        if np.any(idle[who] > _CHATTER):
            stuck = who[np.argmax(idle[who])]
            raise NumericalFailure(
                f"the form of the equations changes for ever at time {time[stuck]:.9g}"
            )

    for _ in range(sweeps):
        active = np.nonzero(~finished & (time < end))[0]
        if not len(active):
            break
        old = active[stale[active]]
        if len(old):
            rate[old] = system.rates(old, time[old], state[old], interval[old])
        start, form, began = state[active], interval[active], time[active]
        slope, tried = rate[active], trial[active]
        limit = np.minimum(end[active], bounds[active, following[active]])
        length = predict(system, active, began, start, slope, form, tried)
        if parts > 1:
            widest[old] = (length / parts)[stale[active]]
            allowed = widest[active]
            length = np.where(length > 1.2 * allowed, allowed, length)
        length = np.minimum(length, tried)
        stale[old] = False
        left = limit - began
        reaches = length >= left * (1.0 - 4.0 * EPSILON)
        length = np.where(reaches, left, length)

        def rates(there: FloatArray, states: FloatArray, who=active, form=form) -> FloatArray:  # type: ignore[no-untyped-def]
            return system.rates(who, there, states, form)

        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            taken = step(rates, began, start, slope, length)
            size = absolute + relative * np.maximum(np.abs(start), np.abs(taken.state))
            error = np.max(np.abs(taken.error) / size, axis=1)
            error = np.where(np.isfinite(error), error, np.inf)
            factor = np.clip(_SAFETY * error ** (-1.0 / ORDER), _SMALLEST, _LARGEST)
        good = error <= 1.0
        bad = active[~good]
        wish[bad] = trial[bad] = (length * np.minimum(factor, _SAFETY))[~good]
        rejected[bad] += 1
        _resolves(bad, trial, time)

        keepers = np.nonzero(good)[0]
        who = active[keepers]
        taken = RungeKuttaStep(
            taken.state[keepers], taken.rate[keepers], taken.error[keepers], taken.dense[:, keepers]
        )
        length, start, form, began = length[keepers], start[keepers], form[keepers], began[keepers]
        reaches, limit = reaches[keepers], limit[keepers]
        cut = reaches | (length < tried[keepers])
        wanted = length * factor[keepers]
        border = first_crossings(system, who, began, length, start, form, taken, reaches)
        again = (border.finding == SHORTEN) | (border.finding == HALVE)
        share = np.where(border.finding == HALVE, 0.5, border.fraction)
        trial[who[again]] = (length * share)[again]
        rejected[who[again]] += 1
        _resolves(who[again], trial, time)

        rows = np.nonzero((border.finding == NOTHING) | (border.finding == LANDED))[0]
        done = who[rows]
        landed = border.finding == LANDED
        if np.any(landed):
            taken, length = _to_fraction(
                taken, start, length, np.where(landed, border.fraction, 1.0)
            )
            reaches &= ~landed
        steps[done] += 1
        time[done] = np.where(reaches[rows], limit[rows], began[rows] + length[rows])
        state[done], rate[done] = taken.state[rows], taken.rate[rows]
        idle[done] = 0
        # a step cut short by a border or a stop says little of what comes next: it may only grow
        next_length = np.where(cut | landed, np.maximum(wish[who], wanted), wanted)
        wish[done] = np.minimum(next_length, longest)[rows]
        trial[done] = wish[done]
        if keep:
            scraps.append(
                (done, began[rows], length[rows], start[rows], taken.dense[:, rows], form[rows])
            )
        event = landed | (border.finding == AT_ONCE)
        if np.any(event):
            settle(who[event], border.which[event], border.direction[event])
        met = rows[reaches[rows]]
        met = who[met[time[who[met]] >= bounds[who[met], following[who[met]]]]]
        if len(met):
            following[met] += 1
            settle(met, None, None)
    else:
        raise NumericalFailure(f"not at the end after {sweeps} sweeps; the step is too short")
    record = assemble(scraps, count, state.shape[1], interval.shape[1]) if keep else None
    return MarchEnd(time, state, interval, finished, steps, rejected, record)


def _first_length(
    state: FloatArray, rate: FloatArray, absolute: FloatArray | float, relative: float
) -> FloatArray:
    size = absolute + relative * np.abs(state)
    with np.errstate(divide="ignore"):
        # the length over which the rate alone would move by a hundredth of tolerance^(1/5)
        fastest = np.max(np.abs(rate) / size, axis=1)
        scale = float(np.min(absolute)) + relative
        found = 0.01 * scale ** (1.0 / ORDER - 1.0) / fastest
    return np.where(np.isfinite(found), found, 1e-3)


def _to_fraction(
    taken: RungeKuttaStep, start: FloatArray, length: FloatArray, fraction: FloatArray
) -> tuple[RungeKuttaStep, FloatArray]:
    """The steps up to (or a little beyond) their ends; where the fraction is 1 they stay."""
    moved = fraction != 1.0
    there = at_fraction(start, taken.dense, fraction[:, None])[:, 0]
    power = fraction ** np.arange(1, 5)[:, None]
    state = np.where(moved[:, None], there, taken.state)
    return taken._replace(state=state, dense=taken.dense * power[..., None]), length * fraction


def _resolves(who: IntArray, trial: FloatArray, time: FloatArray) -> None:
    """Refuse a step that rounding of the time would swallow."""
    if not len(who):
        return
    small = trial[who] <= 16.0 * EPSILON * np.maximum(np.abs(time[who]), 1e-9)
    if np.any(small):
        raise NumericalFailure(
            f"no step is short enough at time {time[who[np.argmax(small)]]:.9g}: the rates jump "
            f"or grow without bound"
        )
