"""Every local maximum of a run-up, with the order that makes most of it and the mode next to it."""

from collections.abc import Iterator, Sequence
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


def all_maxima(parts: Sequence[Range], run: RunUp, share: float) -> Maxima:
    """All local maxima of the rows of `run` from `share` of the highest of each row on.

    `parts` are those of the run-up, one after the other. Speeds next to an interval that is left
    out are none; the unbounded maximum in it is one for the rows that show its mode.
    """
    high = _high(parts[0], run, share)
    best: dict[tuple[float, float], _Maximum] = {}
    for part in parts:
        for sample, one in _of_part(part, run, high, (parts[0].start, parts[-1].stop)):
            key = one.row, sample
            best[key] = max(best.get(key, one), one, key=lambda each: each.value)
    ends = np.array([parts[0].start, *(part.stop for part in parts)])
    found: list[_Maximum] = []
    for one in sorted(best.values()):
        # at a sample next to it the curve goes on upwards, unless the range ends or has a kink
        if not (one.inner or np.any(np.abs(one.speed - ends) <= _ONE * one.speed)):
            continue
        if found and one.row == found[-1].row and one.speed - found[-1].speed <= _ONE * one.speed:
            found[-1] = max(found[-1], one, key=lambda each: each.value)
        else:
            found.append(one)
    top = np.zeros(run.curve.shape[1])
    for one in found:
        top[int(one.row)] = max(top[int(one.row)], one.value)
    found = [one for one in found if one.value >= share * top[int(one.row)]]
    columns = np.array(sorted([*found, *_unbounded(run, parts[0])])).reshape(-1, 12).T[:-1]
    order = ("row", "speed", "value", "error", "speed_error")
    return Maxima(**dict(zip((*order, *Maxima._fields[5:]), columns, strict=True)))


class _Maximum(NamedTuple):
    """One of `Maxima`; `inner` where no sample next to it is the highest."""

    row: float
    speed: float
    value: float
    error: float
    speed_error: float
    order: float
    share: float
    bending: float
    mode: float
    ratio: float
    at_end: float
    inner: float


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
    part: Range, run: RunUp, high: np.ndarray, ends: tuple[float, float]
) -> Iterator[tuple[float, _Maximum]]:
    """Maxima in one part, each with the speed of the sample that it is next to."""
    within = (run.speed >= part.start) & (run.speed <= part.stop)
    speed, value = run.speed[within], run.curve.value[within]
    samples = Samples(np.zeros(len(speed), int), speed, value)
    tops = tops_of(machine_of(part), samples, high[within], 1, within=True)
    order, natural = np.asarray(part.orders, dtype=float), part.resonances.frequency
    # the order whose part of the second derivative of the squared length is the most negative
    turn = np.exp(1j * tops.angle[:, None] * order)[:, None]
    length = (tops.jet.value * turn).real.sum(axis=-1)
    bends = np.einsum("nc,nco->no", length, (tops.jet.curvature * turn).real)
    sizes = np.linalg.norm(tops.jet.value, axis=1)
    for i, row in enumerate(tops.row.tolist()):
        place, height = tops.place[i], tops.height[i]
        off, _ = top_errors(place, height, run.speed, run.curve[:, row], alone=True)
        at_end, largest = place.value in ends, int(np.argmax(sizes[i]))
        bending = order[largest if at_end else int(np.argmin(bends[i]))]
        # the nearest mode by ratio, of those shown
        ratio = np.maximum(bending * place.value, _TINY) / np.maximum(natural, _TINY)
        away = np.where(part.shows[: len(natural), row], np.abs(np.log(ratio)), np.inf)
        mode = int(np.argmin(away))
        share = sizes[i, largest] / height.value
        yield speed[tops.sample[i]], _Maximum(
            row, *(float(one) for one in (
                place.value, height.value, height.error, off, order[largest], share, bending,
                mode + 1, bending * place.value / natural[mode], at_end, tops.inner[i],
            ))
        )  # fmt: skip


def _unbounded(run: RunUp, part: Range) -> Iterator[_Maximum]:
    masked = run.masked
    for i, (place, order, mode) in enumerate(zip(*masked[1::2], masked.mode, strict=True)):
        for row in np.flatnonzero(part.shows[int(mode) - 1]).tolist():
            off = masked.centre_error[i]
            yield _Maximum(row, place, np.inf, 0.0, off, order, 1.0, order, mode, 1.0, 0.0, 1.0)
