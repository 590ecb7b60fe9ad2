"""What is measured of a method: topics, methods at a series of settings, the measuring of them."""

import gc
import math
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np

from vibecalc.core.results.layout import TRIAL_DONE, TRIAL_FAILED, TRIAL_NOT_RUN
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON

# ----------------------------------------------------------------------------
# A topic: one question of a stage, the methods that answer it, and the truth they are held to.
# ----------------------------------------------------------------------------

#: the settings of a method that has nothing to set
NOTHING_TO_SET = (1.0,)


class Answer(NamedTuple):
    """What one method gave at one setting.

    `values` : real or complex, the shape of the reference's values, same unit.
    `work` : what it took, counted in the unit of the topic (evaluations, solves, multiplications).
    `position` : where the peak sits, for topics that ask it; None without one.
    `seconds` : what it took when it was made, for an answer that is kept; None for a fresh one.
    """

    values: np.ndarray
    work: float
    position: float | None = None
    seconds: float | None = None


class Reference(NamedTuple):
    """The trusted values: mpmath, or two independent methods that agree.

    `agreement` : relative to the largest magnitude, how well the independent ways agree; errors
        below it are not distinguished.
    `words` : how the values were found and what they were held against.
    """

    values: np.ndarray
    agreement: float
    words: str
    position: float | None = None


class Solver(NamedTuple):
    """One method with its settings, from coarse to fine.

    `solve` : setting to answer; raises NumericalFailure where it cannot.
    `setting` : what is stepped ("panels", "time step [s]"); empty with nothing to set.
    `default` : the setting that vibecalc takes for this case; None for a method it does not take.
    `theory` : what the theory says of the convergence ("order 4", "geometric"), empty without.
    """

    name: str
    words: str
    setting: str
    settings: tuple[float, ...]
    solve: Callable[[float], Answer]
    default: float | None = None
    theory: str = ""
    citation: str = ""


class Topic(NamedTuple):
    """One question of a stage and everything that answers it.

    `quantity` : the result path (or the beginning of several) that the values stand for.
    `work` : the unit in which all its methods count their work, in the plural.
    `position` : what the position of the peak is and its unit ("crank angle [rad]"), empty without.
    `default_extra` : by how much more work the default may take than the cheapest method that is as
        accurate, and why (1.0 and no words: it is on the front itself).
    """

    stage: str
    name: str
    words: str
    quantity: str
    unit: str
    work: str
    reference: Callable[[], Reference]
    solvers: tuple[Solver, ...]
    position: str = ""
    default_extra: float = 1.0
    default_why: str = ""


# ----------------------------------------------------------------------------
# What measuring one topic gives: a trial for each setting of each method.
# ----------------------------------------------------------------------------

#: errors below so many roundings are not distinguished, however well the reference is known
_LEAST_ROUNDINGS = 64


class Trial(NamedTuple):
    """One method at one setting.

    `worst_relative` is over the largest magnitude, `worst_level` in dB, `position_error` in the
    unit of the position; infinite for a trial that was not measured. `position_error` is None where
    the topic asks no position or the method gives none. `noise` is the relative error below which
    this topic does not tell methods apart. `seconds` is the least of the repeats.
    """

    solver: str
    setting: float
    is_default: bool
    noise: float
    status: int = TRIAL_DONE
    cause: str = ""
    work: float = 0.0
    seconds: float = 0.0
    worst_relative: float = float("inf")
    worst_level: float = float("inf")
    position_error: float | None = None

    @property
    def done(self) -> bool:
        """Whether there is an error to speak of."""
        return self.status == TRIAL_DONE

    @property
    def error(self) -> float:
        """Worst relative error, not below the noise of the topic."""
        return max(self.worst_relative, self.noise)


class Measured(NamedTuple):
    """A topic with its truth and its trials, method by method, each from coarse to fine."""

    topic: Topic
    reference: Reference
    trials: tuple[Trial, ...]
    seconds: float = 0.0


def noise_of(reference: Reference) -> float:
    """Relative error below which trials count as equally accurate."""
    return max(reference.agreement, _LEAST_ROUNDINGS * EPSILON)


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
        large = size >= LEAST_SHARE * largest
        with np.errstate(divide="ignore"):
            levels = 20.0 * np.log10(np.abs(values[large]) / size[large])
        level = float(np.max(np.abs(levels)))
    away = None
    if position is not None and true_position is not None:
        away = abs(float(position) - float(true_position))
    return Errors(relative, level, away)


# ----------------------------------------------------------------------------
# Run every level of a topic: its error against the truth, its work, its seconds, or its failure.
#
# Seconds of a level are those of the processor, which on one thread are the same on an idle and on
# a busy machine; those of a whole topic are the clock's.
# ----------------------------------------------------------------------------

#: what a method may fail with; anything else is a mistake in it and goes up
FAILURES = (NumericalFailure, FloatingPointError, OverflowError, ZeroDivisionError,
            np.linalg.LinAlgError)  # fmt: skip

#: repeats of a level: at least and at most so many, and no more once they took so long [s]
_LEAST, _MOST, _ENOUGH = 3, 30, 0.2

#: a level that takes longer [s] is not repeated
_LONG = 1.0


class Timed(NamedTuple):
    """How trials are timed: `longest` [s] for a question, `repeat` runs short trials again."""

    longest: float = 5.0
    repeat: bool = True


#: a series ends where the next setting, three times the last, would not end in time
_GROWS = 3.0
_LATE = "the time for its question was used up"


def measure(
    topic: Topic,
    timed: Timed | None = None,
    advance: Callable[[], None] | None = None,
) -> Measured:
    """Every trial of every method of `topic`, against its reference; the default's in any case.

    `advance` is called after each trial, also after those that were not run. Raises
    NumericalFailure where the reference cannot be had, ValueError for a mistake in the topic: a
    wrong shape, work that is not counted, a default not among its settings, two methods of a name.
    """
    timed, started = timed or Timed(), time.perf_counter()
    names = [solver.name for solver in topic.solvers]
    if len(set(names)) < len(names):
        raise ValueError(f"{topic.name}: two methods of one name in {names}")
    for one in topic.solvers:
        if one.default is not None and one.default not in one.settings:
            raise ValueError(
                f"{topic.name}, {one.name}: the default {one.default!r} is not among the settings "
                f"{one.settings}"
            )
    enough = min(_ENOUGH, 0.5 * timed.longest / sum(len(one.settings) for one in topic.solvers))
    trials = []
    with _undisturbed():
        reference = topic.reference()
        if not np.isfinite(reference.values).all():
            raise NumericalFailure(f"the reference of {topic.name!r} is not finite")
        noise, begun = noise_of(reference), time.process_time()
        for solver in topic.solvers:
            took = 0.0
            for setting in solver.settings:
                trial = Trial(solver.name, setting, setting == solver.default, noise)
                left = timed.longest - (time.process_time() - begun)
                if _GROWS * took > left and not trial.is_default:
                    trial = trial._replace(status=TRIAL_NOT_RUN, cause=_LATE)
                else:
                    trial, took = _trial(topic, solver, trial, reference, timed.repeat, enough)
                trials.append(trial)
                if advance is not None:
                    advance()
    return Measured(topic, reference, tuple(trials), time.perf_counter() - started)


def _trial(
    topic: Topic, solver: Solver, blank: Trial, reference: Reference, repeat: bool, enough: float
) -> tuple[Trial, float]:
    """A trial and the seconds that its first run took."""
    started = time.process_time()
    try:
        answer = solver.solve(blank.setting)
    except FAILURES as failure:
        took = time.process_time() - started
        return blank._replace(status=TRIAL_FAILED, cause=_cause(failure), seconds=took), took
    took = time.process_time() - started
    if answer.seconds is not None:
        took, repeat = answer.seconds, False
    if not (math.isfinite(answer.work) and answer.work > 0.0):
        place = f"{topic.name}, {solver.name}, {blank.setting:g}"
        raise ValueError(f"{place}: work has to be counted, found {answer.work!r}")
    found = errors_of(answer.values, reference.values, answer.position, reference.position)
    blank = blank._replace(work=float(answer.work), seconds=took)
    wrong = _undefined(answer)
    if wrong:
        return blank._replace(status=TRIAL_FAILED, cause=wrong), took
    least, used, count = took, 0.0, 0
    while repeat and took <= _LONG and (count < _LEAST or (count < _MOST and used < enough)):
        if count and used > 10.0 * enough:
            break
        started = time.process_time()
        solver.solve(blank.setting)
        again = time.process_time() - started
        least, used, count = min(least, again), used + again, count + 1
    trial = blank._replace(
        seconds=least,
        worst_relative=found.worst_relative,
        worst_level=found.worst_level,
        position_error=found.position,
    )
    return trial, took


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
