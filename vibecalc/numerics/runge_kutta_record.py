"""Every step of a march, kept, and the states between them."""

from typing import NamedTuple, TypeAlias

import numpy as np

from vibecalc.numerics.typing import FloatArray, IntArray

#: what one sweep leaves: members, begin, length, start, dense, piece of the steps taken
Scraps: TypeAlias = list[tuple[IntArray, FloatArray, FloatArray, FloatArray, FloatArray, IntArray]]


class Record(NamedTuple):
    """k steps of all members, sorted by member and time.

    Those of member m are first[m]:first[m + 1]. `begin`, `length` (k,); `start` (k, n); `dense`
    (4, k, n) as in `runge_kutta.Step`; `piece` (k, p) held during the step.
    """

    first: IntArray
    begin: FloatArray
    length: FloatArray
    start: FloatArray
    dense: FloatArray
    piece: IntArray


def assemble(scraps: Scraps, members: int, states: int, pieces: int) -> Record:
    """The record of what the sweeps have left."""
    if not scraps:
        zero = np.zeros(0)
        return Record(
            np.zeros(members + 1, dtype=np.int64), zero, zero, np.zeros((0, states)),
            np.zeros((4, 0, states)), np.zeros((0, pieces), dtype=np.int64),
        )  # fmt: skip
    member, begin, length, start, dense, piece = zip(*scraps, strict=True)
    who = np.concatenate(member)
    order = np.argsort(who, kind="stable")
    first = np.concatenate([[0], np.cumsum(np.bincount(who, minlength=members))])
    return Record(
        first,
        np.concatenate(begin)[order],
        np.concatenate(length)[order],
        np.concatenate(start)[order],
        np.concatenate(dense, axis=1)[:, order],
        np.concatenate(piece)[order],
    )


class Sampled(NamedTuple):
    """States (m, n) at m times, and the step (m,) each of them lies in."""

    state: FloatArray
    step: IntArray


def sample(record: Record, member: int, times: FloatArray) -> Sampled:
    """States of one member at `times` (m,) within its march.

    Where a step ends, the state before the event that followed is given up to that time.
    """
    low, high = int(record.first[member]), int(record.first[member + 1])
    begin = record.begin[low:high]
    place = np.clip(np.searchsorted(begin, times, side="left") - 1, 0, len(begin) - 1) + low
    s = ((times - record.begin[place]) / record.length[place])[:, None]
    a, b, c, d = record.dense[:, place]
    return Sampled(record.start[place] + s * (a + s * (b + s * (c + s * d))), place)


def fine(record: Record, member: int, points: int) -> tuple[FloatArray, Sampled]:
    """Times and states at `points` equal parts of every step of one member, and at its start."""
    low, high = int(record.first[member]), int(record.first[member + 1])
    place = np.arange(low, high)
    s = np.arange(points + 1) / points
    times = record.begin[place, None] + s * record.length[place, None]
    a, b, c, d = record.dense[:, place, None, :]
    f = s[:, None]
    states = record.start[place, None] + f * (a + f * (b + f * (c + f * d)))
    steps = np.repeat(place, points + 1)
    return times.ravel(), Sampled(states.reshape(len(steps), -1), steps)
