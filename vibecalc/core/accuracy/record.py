"""Measured topics as results: orders of convergence, what nothing beats, what is cheapest."""

import json
import math
import re
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.accuracy.topic import LEAST_SHARE, Measured, Solver, Topic, Trial
from vibecalc.core.results.layout import (
    ACCURACY,
    ALGEBRAIC,
    BETWEEN,
    GEOMETRIC,
    NOT_FITTED,
    TRIAL_NOT_RUN,
)
from vibecalc.core.results.record import Axis, Method, Quantity, Record
from vibecalc.core.results.trials import extra, on_front
from vibecalc.numerics.rounding import EPSILON

# ----------------------------------------------------------------------------
# The order of convergence that a series of settings shows, fitted above round-off.
# ----------------------------------------------------------------------------

#: trials count that stand this far above what the reference or round-off can tell
_CLEAR, _ROUNDINGS = 30.0, 16

#: relative errors above this say little about the order, and are left out if enough others remain
_COARSE = 0.1

#: an end of the series that falls with less than this order has not begun to converge, or ended
_FLAT = 0.1

_LEAST_TRIALS = 3


class Fit(NamedTuple):
    """What was fitted: `kind` is "order" (error ~ setting^+-p) or "digits" (for each step of 1).

    `value` is p, positive where finer settings have smaller errors, or the digits gained with
    each unit of the setting; `trials` took part.
    """

    kind: str
    value: float
    trials: int


def fitted(trials: Sequence[Trial], agreement: float) -> Fit | None:
    """The order that the trials of a method show, coarse to fine; None with fewer than three.

    Least squares of log error on log setting, and, where settings grow, of log error on the
    setting itself; the one that fits better is taken. `agreement` is that of the reference: trials
    have to be 30 times above it and above 16 roundings.
    """
    floor = _CLEAR * max(agreement, _ROUNDINGS * EPSILON)
    used = [
        (trial.setting, trial.worst_relative)
        for trial in trials
        if trial.done and trial.setting > 0.0 and floor < trial.worst_relative < np.inf
    ]
    fine = [pair for pair in used if pair[1] <= _COARSE]
    used = _falling(fine if len(fine) >= _LEAST_TRIALS else used)
    if len(used) < _LEAST_TRIALS:
        return None
    setting, error = (np.array(column) for column in zip(*used, strict=True))
    digits = np.log10(error)
    slope, misfit = _line(np.log10(setting), digits)
    grows = setting[-1] > setting[0]
    best = Fit(ALGEBRAIC, -slope if grows else slope, len(used))
    if grows:
        steepness, other_misfit = _line(setting, digits)
        if other_misfit < misfit:
            best = Fit(GEOMETRIC, -steepness, len(used))
    return best if best.value > 0.0 else None


def _falling(pairs: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Without the flat ends: from the largest error on, as far as errors still fall."""
    if pairs:
        pairs = pairs[max(range(len(pairs)), key=lambda place: pairs[place][1]) :]
    while len(pairs) > 1 and not _falls(pairs[-2], pairs[-1]):
        pairs = pairs[:-1]
    while len(pairs) > 1 and not _falls(pairs[0], pairs[1]):
        pairs = pairs[1:]
    return pairs


def _falls(before: tuple[float, float], after: tuple[float, float]) -> bool:
    apart = abs(np.log(after[0] / before[0]))
    return bool(np.log(before[1] / after[1]) > _FLAT * apart)


def _line(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Slope and sum of squares of the misfit; a constant x fits nothing."""
    centred = x - x.mean()
    spread = float(centred @ centred)
    if spread == 0.0:
        return 0.0, float("inf")
    slope = float(centred @ (y - y.mean())) / spread
    rest = y - y.mean() - slope * centred
    return slope, float(rest @ rest)


# ----------------------------------------------------------------------------
# Which trials nothing beats in counted work, and what the default takes over the least.
# ----------------------------------------------------------------------------


def _errors(trials: Sequence[Trial]) -> list[float]:
    """Errors not below the noise, so that of several at round-off only the cheapest counts."""
    return [trial.error if trial.done else math.inf for trial in trials]


def front_in_work(trials: Sequence[Trial]) -> list[bool]:
    """The front in counted work, the same on every machine."""
    return on_front(_errors(trials), [trial.work for trial in trials])


def extra_work(topic: Topic, trials: Sequence[Trial]) -> float:
    """Work of the default over the least as accurate, to be held against `default_extra`."""
    default = [trial.is_default for trial in trials]
    if any(solver.default is not None for solver in topic.solvers) and not any(default):
        raise ValueError(f"{topic.name}: the trials are not of this topic, no default among them")
    return extra(_errors(trials), [trial.work for trial in trials], default)


# ----------------------------------------------------------------------------
# Measured topics as results with paths, units and axes, and the part that changes by the run.
# ----------------------------------------------------------------------------

#: a level changes by so many dB with a small relative change
_DECIBELS = 20.0 / math.log(10.0)


def folder_of(topic: Topic) -> str:
    """`accuracy/<stage>/<topic>`, in letters, digits and underscores."""
    return "/".join((ACCURACY, _slug(topic.stage), _slug(topic.name)))


def as_record(measured: Sequence[Measured], notes: Sequence[str]) -> Record:
    """Everything that is the same in every run, notes as warnings."""
    record = Record(warnings=list(notes))
    for one in measured:
        _add_trials(record, one)
        _add_methods(record, one)
        for solver in one.topic.solvers:
            method = Method(name=solver.name, purpose=one.topic.name, citation=solver.citation)
            if solver.citation and method not in record.methods:
                record.methods.append(method)
    return record


def measured_text(measured: Sequence[Measured]) -> str:
    """Seconds, which change from run to run, as JSON by the folder of the topic."""
    return json.dumps({
        folder_of(one.topic): [
            None if trial.status == TRIAL_NOT_RUN else trial.seconds for trial in one.trials
        ]
        for one in measured
    })  # fmt: skip


def plan_rows(measured: Sequence[Measured]) -> tuple[dict[str, str], ...]:
    """The words of each topic, followed by those of its methods."""
    rows: list[dict[str, str]] = []
    for one in measured:
        topic, folder = one.topic, folder_of(one.topic)
        of_topic = ("stage", "name", "quantity", "unit", "work", "position", "default_why")
        words = {name: getattr(topic, name) for name in of_topic}
        more = {"reference": one.reference.words, "default_extra": f"{topic.default_extra:g}"}
        rows.append({"folder": folder, "why": topic.words, **words, **more})
        for solver in topic.solvers:
            words = {name: getattr(solver, name) for name in ("setting", "theory", "citation")}
            about = {"stage": topic.stage, "method": solver.name, "why": solver.words}
            rows.append({"folder": folder, **about, **words})
    return tuple(rows)


def _add_trials(record: Record, one: Measured) -> None:
    topic, trials, folder = one.topic, one.trials, folder_of(one.topic)
    noise = trials[0].noise if trials else 0.0
    solvers = {solver.name: solver for solver in topic.solvers}
    names = [_label(solvers[trial.solver], trial) for trial in trials]
    axis = Axis(name="trial", values=np.array(names, dtype=object), long_name="method and setting")
    level_noise = _DECIBELS * noise / LEAST_SHARE
    rows: list[tuple[str, Any, str, str, float]] = [
        ("worst_relative", [trial.worst_relative for trial in trials], "",
         "largest error over the largest magnitude", noise),
        ("worst_level", [trial.worst_level for trial in trials], "dB",
         "largest difference of level", level_noise),
        ("work", [trial.work for trial in trials], "", f"work, in {topic.work}", 0.0),
        ("status", [trial.status for trial in trials], "", "0 done, 1 failed, 2 not run", 0.0),
        ("cause", np.array([trial.cause for trial in trials], dtype=object), "",
         "why a level failed or was not run", 0.0),
        ("setting", [trial.setting for trial in trials], "", "setting of the method", 0.0),
        ("is_default", [int(trial.is_default) for trial in trials], "",
         "1: what vibecalc takes", 0.0),
        ("on_front", [int(mark) for mark in front_in_work(trials)], "",
         "1: no other is as accurate with less work", 0.0),
    ]  # fmt: skip
    if topic.position:
        away = [
            math.inf if trial.position_error is None else trial.position_error for trial in trials
        ]
        at = abs(one.reference.position or 0.0)
        rows.insert(2, ("position_error", away, "", f"distance from the true {topic.position}",
                        noise * at))  # fmt: skip
    for name, values, unit, words, error in rows:
        record.add(
            Quantity(
                path=f"{folder}/{name}",
                values=np.asarray(values),
                unit=unit,
                long_name=f"{topic.name}: {words}",
                axes=(axis,),
                error_estimate=error,
            )
        )


def _add_methods(record: Record, one: Measured) -> None:
    topic, folder = one.topic, folder_of(one.topic)
    fits = [
        fitted(
            [trial for trial in one.trials if trial.solver == solver.name],
            one.reference.agreement,
        )
        for solver in topic.solvers
    ]
    names = np.array([solver.name for solver in topic.solvers], dtype=object)
    method = Axis(name="method", values=names, long_name="method")
    for name, values, axes, words in (
        ("order", [fit.value if fit else 0.0 for fit in fits], (method,), "fitted order"),
        (
            "order_kind",
            np.array([fit.kind if fit else NOT_FITTED for fit in fits], dtype=object),
            (method,),
            "order: of the setting; digits: gained with each unit of it",
        ),
        ("agreement", one.reference.agreement, (), "relative agreement of the reference"),
        (
            "extra_work",
            extra_work(topic, one.trials),
            (),
            "work of the default over the least",
        ),
    ):
        record.add(
            Quantity(
                path=f"{folder}/{name}",
                values=np.asarray(values),
                unit="",
                long_name=f"{topic.name}: {words}",
                axes=axes,
            )
        )


def _label(solver: Solver, trial: Trial) -> str:
    return f"{solver.name}{BETWEEN}{trial.setting:.12g}" if solver.setting else solver.name


def _slug(text: str) -> str:
    return re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_")
