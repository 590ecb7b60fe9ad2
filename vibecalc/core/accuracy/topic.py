"""What is measured of a method: topics, methods at a series of settings, the measuring of them."""

import math
import time
import timeit
import warnings
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.results.layout import BETWEEN, TRIAL_FAILED, TRIAL_NOT_RUN
from vibecalc.core.results.trials import Trial, noise_of
from vibecalc.errors import NumericalFailure

# ----------------------------------------------------------------------------
# A topic: one question of a stage, the methods that answer it, and the truth they are held to.
# ----------------------------------------------------------------------------


class Answer(NamedTuple):
    """What one method gave at one setting.

    `values` : real or complex, one or an array, the shape of the reference's values, same unit.
    `work` : what it took, counted in the unit of the topic (evaluations, solves, multiplications).
    `position` : where the peak sits, for topics that ask it.
    `seconds` : what it took when it was made, for an answer that is kept; None for a fresh one.
    """

    values: Any
    work: float
    position: float | None = None
    seconds: float | None = None


class Reference(NamedTuple):
    """The trusted values: mpmath, or two independent methods that agree.

    `agreement` : relative to the largest magnitude, how well the independent ways agree; errors
        below it are not distinguished.
    `words` : how the values were found and what they were held against.
    """

    values: Any
    agreement: float
    words: str
    position: float | None = None

    @property
    def noise(self) -> float:
        """Relative error below which trials count as equally accurate."""
        return noise_of(self.agreement)


class Solver(NamedTuple):
    """One method with its settings, from coarse to fine.

    `solve` : setting to `Answer`; raises NumericalFailure where it cannot.
    `setting` : what is stepped ("panels", "time step [s]"); empty with nothing to set.
    `default` : the setting that vibecalc takes for this case; None for a method it does not take.
    `theory` : what the theory says of the convergence ("order 4", "geometric"), empty without.
    """

    name: str
    solve: Callable[[float], Any]
    setting: str = ""
    settings: Sequence[float] = (1.0,)
    default: float | None = 1.0
    theory: str = ""

    @property
    def steps(self) -> list[float]:
        """All settings from coarse to fine, the default among them."""
        given, ours = list(self.settings), () if self.default is None else (self.default,)
        return sorted({float(one) for one in (*given, *ours)}, reverse=given[:1] > given[-1:])


class Ask(NamedTuple):
    """What is asked: name, in words, the result path (or beginning of several) it stands for.

    `extra` is by how much the default's work may exceed the least of any that is as accurate, and
    `why` (1.0 and no words: it is on the front itself).
    """

    name: str
    words: str
    quantity: str
    extra: float = 1.0
    why: str = ""


class Topic(NamedTuple):
    """One question of a stage and everything that answers it.

    `work` : the unit in which all its methods count their work, in the plural.
    `position` : what the position of the peak is and its unit ("crank angle [rad]"), empty without.
    """

    ask: Ask
    work: str
    reference: Callable[[], Reference]
    solvers: Sequence[Solver]
    position: str = ""
    stage: str = ""


class Measured(NamedTuple):
    """A topic with its truth and its trials, method by method, each from coarse to fine."""

    topic: Topic
    reference: Reference
    trials: tuple[Trial, ...]
    seconds: float


# ----------------------------------------------------------------------------
# The distance of an answer from the truth, in the three norms that an engineer reads.
# ----------------------------------------------------------------------------

#: entries below this share of the largest have no level worth comparing
LEAST_SHARE = 1e-6


def errors_of(answer: Answer, reference: Reference) -> tuple[float, float, float]:
    """Worst relative error, worst level difference in dB, distance of the peak's position.

    The relative error is max|x - ref| / max|ref|: entries are held against the largest one, and a
    complex entry is a point in the plane. Where the truth is zero altogether it is 0 or infinite.
    The level difference is the largest |20 log10(|x| / |ref|)| over entries of at least
    `LEAST_SHARE` of the largest; a magnitude of zero there is infinitely far off. The distance is
    infinite unless both sides have a position.

    Raises ValueError for another shape, which is a mistake in the topic.
    """
    values, truth = np.atleast_1d(answer.values), np.atleast_1d(reference.values)
    if values.shape != truth.shape:
        raise ValueError(f"an answer of shape {values.shape} for a truth of shape {truth.shape}")
    size = np.abs(truth)
    largest, difference = (float(np.max(one, initial=0.0)) for one in (size, abs(values - truth)))
    away = math.inf
    if answer.position is not None and reference.position is not None:
        away = abs(answer.position - reference.position)
    if largest == 0.0:
        wrong = math.inf if difference > 0.0 else 0.0
        return wrong, wrong, away
    large = size >= LEAST_SHARE * largest
    with np.errstate(divide="ignore"):
        levels = 20.0 * np.log10(np.abs(values[large]) / size[large])
    return difference / largest, float(np.max(np.abs(levels))), away


# ----------------------------------------------------------------------------
# Run every level of a topic: its error against the truth, its work, its seconds, or its failure.
#
# Seconds of a level are those of the processor, which on one thread are the same on an idle and on
# a busy machine; those of a whole topic are the clock's.
# ----------------------------------------------------------------------------

#: what a method may fail with; anything else is a mistake in it and goes up
FAILURES = (NumericalFailure, FloatingPointError, OverflowError, ZeroDivisionError,
            np.linalg.LinAlgError)  # fmt: skip

#: repeats of a level: at least and at most so many, and no more than what takes so long [s]
_LEAST, _MOST, _ENOUGH = 3, 30, 0.2

#: a level that takes longer [s], or ten times as long as is enough, is not repeated
_LONG = 1.0

#: a series ends where the next setting, three times the last, would not end in time
_GROWS = 3.0
_LATE = "the time limit of its topic was reached"


def measure(
    topic: Topic,
    longest: float = 5.0,
    repeats: int = _MOST,
    advance: Callable[[str], None] = lambda _: None,
) -> Measured:
    """Every trial of every method of `topic`, against its reference; the default's in any case.

    `longest` is for all trials, in s, `repeats` the most of a short one. `advance` is called with
    the name of each trial. No warning is given; an overflow ends a method, since what diverges
    overflows sooner or later, and a NaN is found in its answer. Raises NumericalFailure where the
    reference cannot be had.
    """
    started, trials = time.perf_counter(), []
    enough = min(_ENOUGH, 0.5 * longest / sum(len(one.steps) for one in topic.solvers))
    with (
        warnings.catch_warnings(action="ignore"),
        np.errstate(over="raise", divide="ignore", invalid="ignore", under="ignore"),
    ):
        reference = topic.reference()
        if not topic.position:
            reference = reference._replace(position=None)
        if not np.isfinite(reference.values).all():
            raise NumericalFailure(f"the reference of {topic.ask.name!r} is not finite")
        end = time.process_time() + longest
        for solver in topic.solvers:
            took = 0.0
            for setting in solver.steps:
                name = f"{solver.name}{BETWEEN}{setting:.12g}" if solver.setting else solver.name
                trial = Trial(name, setting, setting == solver.default)
                if _GROWS * took > end - time.process_time() and not trial.is_default:
                    trial = trial._replace(status=TRIAL_NOT_RUN, cause=_LATE)
                else:
                    trial = _tried(solver, trial, reference, repeats, enough)
                    took = trial.seconds
                trials.append(trial)
                advance(name)
    return Measured(topic, reference, tuple(trials), time.perf_counter() - started)


def _tried(
    solver: Solver, trial: Trial, reference: Reference, repeats: int, enough: float
) -> Trial:
    started = time.process_time()
    try:
        answer: Answer = solver.solve(trial.setting)
    except FAILURES as failure:
        took = time.process_time() - started
        return trial._replace(status=TRIAL_FAILED, cause=_cause(failure), seconds=took)
    took = time.process_time() - started if answer.seconds is None else answer.seconds
    trial = trial._replace(work=float(answer.work), seconds=took)
    if not np.isfinite(answer.values).all():
        wrong = "not a number" if np.isnan(answer.values).any() else "infinite"
        return trial._replace(status=TRIAL_FAILED, cause=f"the answer is {wrong}")
    if answer.seconds is None and took <= min(_LONG, 10.0 * enough):
        again = partial(solver.solve, trial.setting)
        count = min(max(_LEAST, math.ceil(enough / max(took, 1e-9))), repeats)
        took = min([took, *timeit.repeat(again, timer=time.process_time, repeat=count, number=1)])
    relative, level, away = errors_of(answer, reference)
    return trial._replace(
        seconds=took, worst_relative=relative, worst_level=level, position_error=away
    )


def _cause(failure: Exception) -> str:
    words = " ".join(str(failure).split())
    if isinstance(failure, NumericalFailure):
        return words
    return f"{type(failure).__name__}: {words}" if words else type(failure).__name__
