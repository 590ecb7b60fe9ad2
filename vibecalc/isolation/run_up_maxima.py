"""Every local maximum of a run-up, with the order that makes most of it and the mode next to it."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.isolation.run_up import Range, RunUp, machine_of
from vibecalc.isolation.run_up_peaks import local_maxima, tops_of
from vibecalc.isolation.run_up_samples import Samples
from vibecalc.numerics.maxima import top_errors

# ----------------------------------------------------------------------------
# A local maximum of the curve lies next to a speed whose value is no lower than those of its
# neighbours: the curve has a speed wherever it bends. It is refined as the highest of them all is.
# A gas table has a kink of its own at the end of a part of the run-up, where a maximum may be.
# ----------------------------------------------------------------------------

#: a sample is lower than the maximum next to it by no more than the curve's tolerance
_SAMPLED = 0.97
#: relative: closer ones are one maximum
_ONE = 1e-7
_TINY = np.finfo(float).tiny


class Maxima(NamedTuple):
    """Maxima (n,) by row, then by speed; errors absolute, an infinite one stands for no bound.

    `order` is the whole number of the order that is largest there, `share` its size over the peak
    of all, 1 of an infinite one; `bending` the one that bends the curve downwards most, which is
    the one in resonance where there is one, and at an end of the range the largest. `mode` (from
    1) is the nearest to the frequency of that order, of the modes that the row shows, and `ratio`
    that frequency over that of the mode. `at_end` is 1 at an end of the range.
    """

    row: np.ndarray
    value: np.ndarray
    error: np.ndarray
    speed: np.ndarray
    speed_error: np.ndarray
    order: np.ndarray
    share: np.ndarray
    bending: np.ndarray
    mode: np.ndarray
    ratio: np.ndarray
    at_end: np.ndarray

    def some(self, which: np.ndarray) -> "Maxima":
        """Those that an index names."""
        return Maxima(*(part[which] for part in self))


def all_maxima(parts: Sequence[Range], run: RunUp, share: float) -> Maxima:
    """All local maxima of the rows of `run` from `share` of the highest of each row on.

    `parts` are those of the run-up, one after the other. Speeds next to an interval that is left
    out are none; the unbounded maximum in it is one for the rows that show its mode.
    """
    high = _high(parts[0], run, share)
    ends = np.array([parts[0].start, *(part.stop for part in parts)])
    each = [_of_part(part, run, high, ends[[0, -1]]) for part in parts]
    found = _joined([one for one, *_ in each])
    sample, inner = (np.concatenate(one) for one in zip(*(part[1:] for part in each), strict=True))
    # at a sample next to it the curve goes on upwards, unless the range ends or has a kink
    kink = np.any(np.abs(found.speed[:, None] - ends) <= _ONE * found.speed[:, None], axis=1)
    best = _highest(found.value, sample, found.row)
    found = found.some(best[(inner | kink)[best]])
    found = found.some(np.lexsort((found.speed, found.row)))
    apart = (np.diff(found.row) > 0) | (np.diff(found.speed) > _ONE * found.speed[1:])
    found = found.some(_highest(found.value, np.append(0, np.cumsum(apart))[: len(found.row)]))
    top = np.zeros(run.curve.shape[1])
    np.maximum.at(top, found.row, found.value)
    found = _joined([found.some(found.value >= share * top[found.row]), _unbounded(run, parts[0])])
    return found.some(np.lexsort((found.speed, found.row)))


def _joined(parts: Sequence[Maxima]) -> Maxima:
    return Maxima(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _highest(value: np.ndarray, *groups: np.ndarray) -> np.ndarray:
    """Places of the highest of values (n,) among those that share each of some numbers (n,)."""
    order = np.lexsort((-value, *groups))
    new = np.any([np.diff(group[order], prepend=-1.0) != 0.0 for group in groups], axis=0)
    return np.asarray(order[new])


def _high(part: Range, run: RunUp, share: float) -> np.ndarray:
    """Speeds (speeds, rows) of the curve that are no lower than their neighbours, and high."""
    value, masked = run.curve.value, run.masked
    high = local_maxima(Samples(np.zeros(len(run.speed), int), run.speed, value)) & (value > 0.0)
    for low, mode, top in zip(masked.low, masked.mode, masked.high, strict=True):
        beside = (run.speed >= low) & (run.speed <= top)
        high &= ~(beside[:, None] & part.shows[int(mode) - 1])
    most = np.max(value, axis=0, where=high, initial=0.0)
    return np.asarray(high & (value >= _SAMPLED * share * most))


def _of_part(
    part: Range, run: RunUp, high: np.ndarray, ends: np.ndarray
) -> tuple[Maxima, np.ndarray, np.ndarray]:
    """Maxima in one part, the speeds of the samples that they are next to, and whether no sample
    next to one is higher."""
    within = (run.speed >= part.start) & (run.speed <= part.stop)
    speed, value = run.speed[within], run.curve.value[within]
    samples = Samples(np.zeros(len(speed), int), speed, value)
    tops = tops_of(machine_of(part), samples, high[within], 1, within=True)
    row, place, height, each = tops.row, tops.place, tops.height, np.arange(len(tops.row))
    order = np.asarray(part.orders, dtype=float)
    # of the body: those of a shaft line that passes the torque on come after them
    natural = part.resonances.frequency[: len(part.shows)]
    # the order whose part of the second derivative of the squared length is the most negative
    turn = np.exp(1j * tops.angle[:, None] * order)[:, None]
    length = (tops.jet.value * turn).real.sum(axis=-1)
    bends = np.einsum("nc,nco->no", length, (tops.jet.curvature * turn).real)
    sizes = np.linalg.norm(tops.jet.value, axis=1)
    largest, at_end = np.argmax(sizes, axis=1), np.any(place.value[:, None] == ends, axis=1)
    bending = order[np.where(at_end, largest, np.argmin(bends, axis=1))]
    # the nearest mode by ratio, of those shown
    met = np.maximum(bending * place.value, _TINY)[:, None] / np.maximum(natural, _TINY)
    away = np.where(part.shows[: len(natural), row].T, np.abs(np.log(met)), np.inf)
    mode = np.argmin(away, axis=1)
    off = [
        top_errors(place[i], height[i], run.speed, run.curve[:, row[i]], alone=True)[0]
        for i in each
    ]
    found = Maxima(
        row, height.value, height.error, place.value, np.array(off), order[largest],
        sizes[each, largest] / height.value, bending, mode + 1.0,
        bending * place.value / natural[mode], at_end.astype(float),
    )  # fmt: skip
    return found, speed[tops.sample], tops.inner


def _unbounded(run: RunUp, part: Range) -> Maxima:
    """Those at undamped resonances, of the rows that show these."""
    masked = run.masked
    which, row = np.nonzero(part.shows[masked.mode.astype(int) - 1])
    one, order = np.ones(len(row)), masked.order[which].astype(float)
    return Maxima(
        row, np.inf * one, 0.0 * one, masked.centre[which], masked.centre_error[which], order, one,
        order, masked.mode[which].astype(float), one, 0.0 * one,
    )  # fmt: skip
