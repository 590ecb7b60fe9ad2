"""Run every rung of a topic: its error against the truth, its work, its seconds, or its failure."""

import gc
import math
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np

from vibecalc.core.accuracy.topic import Answer, Ladder, Measured, Reference, Rung, Topic, noise_of
from vibecalc.core.results.layout import RUNG_FAILED, RUNG_NOT_RUN
from vibecalc.errors import NumericalFailure

# ----------------------------------------------------------------------------
# The distance of an answer from the truth, in the three norms that an engineer reads.
# ----------------------------------------------------------------------------

#: entries below this share of the largest have no level worth comparing
LEAST_SHARE = 1e-6


class Errors(NamedTuple):
    """Worst relative error, worst level difference in dB, distance of the peak's position."""

    worst_relative: float
    worst_level: float
    position: float | None


def errors_of(
    values: np.ndarray,
    truth: np.ndarray,
    position: float | None = None,
    true_position: float | None = None,
) -> Errors:
    """Errors of `values`, real or complex, against `truth` of the same shape.

    The relative error is max|x - ref| / max|ref|: entries are held against the largest one, and a
    complex entry is a point in the plane. Where the truth is zero altogether it is 0 or infinite.
    The level difference is the largest |20 log10(|x| / |ref|)| over entries of at least
    `LEAST_SHARE` of the largest; a magnitude of zero there is infinitely far off. The position is
    None unless both sides have one.

    Raises ValueError for another shape, which is a mistake in the topic.
    """
    values, truth = np.asarray(values), np.asarray(truth)
    if values.shape != truth.shape:
        raise ValueError(f"an answer of shape {values.shape} for a truth of shape {truth.shape}")
    size = np.abs(truth)
    largest = float(np.max(size, initial=0.0))
    difference = float(np.max(np.abs(values - truth), initial=0.0))
    if largest == 0.0:
        relative = 0.0 if difference == 0.0 else float("inf")
        level = 0.0 if difference == 0.0 else float("inf")
    else:
        relative = difference / largest
        told = size >= LEAST_SHARE * largest
        with np.errstate(divide="ignore"):
            levels = 20.0 * np.log10(np.abs(values[told]) / size[told])
        level = float(np.max(np.abs(levels)))
    away = None
    if position is not None and true_position is not None:
        away = abs(float(position) - float(true_position))
    return Errors(relative, level, away)


# ----------------------------------------------------------------------------
# Run every rung of a topic: its error against the truth, its work, its seconds, or its failure.
#
# Seconds of a rung are those of the processor, which on one thread are the same on an idle and on a
# busy machine; those of a whole topic are the clock's.
# ----------------------------------------------------------------------------

#: what a method may fail with; anything else is a mistake in it and goes up
FAILURES = (NumericalFailure, FloatingPointError, OverflowError, ZeroDivisionError,
            np.linalg.LinAlgError)  # fmt: skip

#: repeats of a rung: at least and at most so many, and no more once they took so long [s]
_LEAST, _MOST, _ENOUGH = 3, 30, 0.2

#: a rung that takes longer [s] is not repeated
_LONG = 1.0


class Timed(NamedTuple):
    """How rungs are timed: `longest` [s] ends a ladder, `repeat` runs short rungs several times."""

    longest: float = 5.0
    repeat: bool = True


def measure(
    topic: Topic,
    timed: Timed | None = None,
    advance: Callable[[], None] | None = None,
) -> Measured:
    """Every rung of every ladder of `topic`, against its reference.

    Parameters
    ----------
    topic : what to measure.
    timed : see `Timed`; with `repeat` off, seconds are those of the one run, warm or not.
    advance : called after each rung, also after those that were not run.

    Raises
    ------
    NumericalFailure : the reference cannot be had.
    ValueError : a mistake in the topic: a wrong shape, work that is not counted, a default that is
        not on its ladder, two methods of one name.
    """
    started = time.perf_counter()
    names = [ladder.name for ladder in topic.ladders]
    if len(set(names)) < len(names):
        raise ValueError(f"{topic.name}: two methods of one name in {names}")
    with _undisturbed():
        reference = topic.reference()
        if not np.isfinite(reference.values).all():
            raise NumericalFailure(f"the reference of {topic.name!r} is not finite")
        noise = noise_of(reference)
        rungs = [
            rung
            for ladder in topic.ladders
            for rung in _climb(topic, ladder, reference, noise, timed or Timed(), advance)
        ]
    return Measured(topic, reference, tuple(rungs), time.perf_counter() - started)


def _climb(
    topic: Topic,
    ladder: Ladder,
    reference: Reference,
    noise: float,
    timed: Timed,
    advance: Callable[[], None] | None,
) -> Iterator[Rung]:
    if ladder.default is not None and ladder.default not in ladder.settings:
        raise ValueError(
            f"{topic.name}, {ladder.name}: the default {ladder.default!r} is not on the ladder "
            f"{ladder.settings}"
        )
    slow = ""
    for setting in ladder.settings:
        blank = Rung(ladder.name, setting, setting == ladder.default, noise)
        if slow:
            rung = blank._replace(status=RUNG_NOT_RUN, cause=slow)
        else:
            rung, took = _rung(topic, ladder, blank, reference, timed)
            if took > timed.longest:
                slow = f"the setting before took longer than {timed.longest:g} s"
        if advance is not None:
            advance()
        yield rung


def _rung(
    topic: Topic, ladder: Ladder, blank: Rung, reference: Reference, timed: Timed
) -> tuple[Rung, float]:
    """A rung and the seconds that its first run took."""
    started = time.process_time()
    try:
        answer = ladder.solve(blank.setting)
    except FAILURES as failure:
        took = time.process_time() - started
        return blank._replace(status=RUNG_FAILED, cause=_cause(failure), seconds=took), took
    took = time.process_time() - started
    place = f"{topic.name}, {ladder.name}, {blank.setting:g}"
    _check(place, answer, reference)
    wrong = _undefined(answer)
    if wrong:
        return blank._replace(status=RUNG_FAILED, cause=wrong, work=answer.work, seconds=took), took
    found = errors_of(answer.values, reference.values, answer.position, reference.position)
    least = took
    if timed.repeat and took <= _LONG:
        least = min(least, _least_seconds(ladder.solve, blank.setting))
    rung = blank._replace(
        work=float(answer.work),
        seconds=least,
        worst_relative=found.worst_relative,
        worst_level=found.worst_level,
        position_error=found.position,
    )
    return rung, took


def _least_seconds(solve: Callable[[float], Answer], setting: float) -> float:
    least, used, count = math.inf, 0.0, 0
    while count < _LEAST or (count < _MOST and used < _ENOUGH):
        started = time.process_time()
        solve(setting)
        took = time.process_time() - started
        least, used, count = min(least, took), used + took, count + 1
    return least


def _check(place: str, answer: Answer, reference: Reference) -> None:
    shapes = np.shape(answer.values), np.shape(reference.values)
    if shapes[0] != shapes[1]:
        raise ValueError(f"{place}: an answer of shape {shapes[0]} for a truth of {shapes[1]}")
    if not (math.isfinite(answer.work) and answer.work > 0.0):
        raise ValueError(f"{place}: work has to be counted, found {answer.work!r}")


def _undefined(answer: Answer) -> str:
    values = np.asarray(answer.values)
    if np.isnan(values).any():
        return "the answer is not a number"
    if not np.isfinite(values).all():
        return "the answer is infinite"
    if answer.position is not None and not math.isfinite(answer.position):
        return "the position of the peak is not a finite number"
    return ""


def _cause(failure: Exception) -> str:
    words = " ".join(str(failure).split())
    if isinstance(failure, NumericalFailure):
        return words
    return f"{type(failure).__name__}: {words}" if words else type(failure).__name__


@contextmanager
def _undisturbed() -> Iterator[None]:
    """No garbage collection, no warnings; an overflow ends a method, a NaN is found in its answer.

    What diverges overflows sooner or later, and a march that goes on with infinities only takes
    time.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        with (
            warnings.catch_warnings(),
            np.errstate(over="raise", divide="ignore", invalid="ignore", under="ignore"),
        ):
            warnings.simplefilter("ignore")
            yield
    finally:
        if was_on:
            gc.enable()
