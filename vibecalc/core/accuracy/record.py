"""Measured topics as results: orders of convergence, what nothing beats, what is cheapest."""

import json
import math
import re
from collections.abc import Sequence

import numpy as np

from vibecalc.core.accuracy.topic import LEAST_SHARE, Measured, Topic
from vibecalc.core.results.layout import ACCURACY, ALGEBRAIC, GEOMETRIC, NOT_FITTED
from vibecalc.core.results.record import Entry, Record
from vibecalc.core.results.trials import Trial, extra, on_front
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


def fitted(trials: Sequence[Trial], agreement: float) -> tuple[str, float]:
    """The order that the trials of a method show, coarse to fine; none with fewer than three.

    Least squares of log error on log setting, and, where settings grow, of log error on the
    setting itself; the one that fits better is taken. `agreement` is that of the reference: trials
    have to be 30 times above it and above 16 roundings.

    Returns "order" and p of error ~ setting^+-p, positive where finer settings have smaller errors;
    "digits" and those gained with each unit of the setting; or "none" and 0.
    """
    floor = _CLEAR * max(agreement, _ROUNDINGS * EPSILON)
    used = [
        (trial.setting, trial.worst_relative)
        for trial in trials
        if trial.setting > 0.0 and floor < trial.worst_relative < np.inf
    ]
    fine = [pair for pair in used if pair[1] <= _COARSE]
    used = fine if len(fine) >= _LEAST_TRIALS else used
    if len(used) < _LEAST_TRIALS:
        return NOT_FITTED, 0.0
    # without the flat ends: from the largest error on, as far as errors still fall
    start = int(np.argmax([error for _, error in used]))
    setting, error = np.array(used[start:]).T
    drop, step = (np.abs(np.diff(np.log(one))) for one in (error, setting))
    falls = np.flatnonzero((np.diff(error) < 0.0) & (drop > _FLAT * step))
    if not falls.size or falls[-1] - falls[0] + 2 < _LEAST_TRIALS:
        return NOT_FITTED, 0.0
    setting, error = (one[falls[0] : falls[-1] + 2] for one in (setting, error))
    grows = setting[-1] > setting[0]
    fits = []
    for kind, steps in ((ALGEBRAIC, np.log10(setting)), (GEOMETRIC, setting))[: 1 + int(grows)]:
        line, misfit, *_ = np.polyfit(steps, np.log10(error), 1, full=True)
        fits.append((float(misfit[0]), kind, float(-line[0] if grows else line[0])))
    _, kind, value = min(fits)
    return (kind, value) if value > 0.0 else (NOT_FITTED, 0.0)


# ----------------------------------------------------------------------------
# Measured topics as results with paths, units and axes, and the part that changes by the run.
# ----------------------------------------------------------------------------

#: a level changes by so many dB with a small relative change
_DECIBELS = 20.0 / math.log(10.0)


def folder_of(topic: Topic) -> str:
    """`accuracy/<stage>/<topic>`, in letters, digits and underscores."""
    return "/".join((ACCURACY, _slug(topic.stage), _slug(topic.ask.name)))


def as_record(measured: Sequence[Measured], notes: Sequence[str]) -> Record:
    """Everything that is the same in every run, notes as warnings."""
    record = Record(warnings=list(notes))
    for one in measured:
        _add(record, one)
    return record


def measured_text(measured: Sequence[Measured]) -> str:
    """Seconds, which change from run to run, as JSON by the folder of the topic."""
    seconds = {folder_of(one.topic): [trial.seconds for trial in one.trials] for one in measured}
    return json.dumps(
        {folder: [s if s < math.inf else None for s in every] for folder, every in seconds.items()}
    )


def plan_rows(measured: Sequence[Measured]) -> tuple[dict[str, str], ...]:
    """The words of each topic, followed by those of its methods."""
    rows: list[dict[str, str]] = []
    for one in measured:
        topic, ask = one.topic, one.topic.ask
        of = {"folder": folder_of(topic), "stage": topic.stage}
        rows.append({
            **of, "name": ask.name, "why": ask.words, "quantity": ask.quantity,
            "work": topic.work, "position": topic.position, "reference": one.reference.words,
            "default_extra": f"{ask.extra:g}", "default_why": ask.why,
        })  # fmt: skip
        for solver in topic.solvers:
            about = {"setting": solver.setting, "theory": solver.theory}
            rows.append({**of, "method": solver.name, **about})
    return tuple(rows)


#: results of a topic: name, axis, unit and words
_RESULTS = (
    ("worst_relative", "trial", "", "largest error over the largest magnitude"),
    ("worst_level", "trial", "dB", "largest difference of level"),
    ("position_error", "trial", "", "distance from the true {position}"),
    ("work", "trial", "", "work, in {work}"),
    ("status", "trial", "", "0 done, 1 failed, 2 not run"),
    ("cause", "trial", "", "why a level failed or was not run"),
    ("setting", "trial", "", "setting of the method"),
    ("is_default", "trial", "", "1: what vibecalc takes"),
    ("on_front", "trial", "", "1: no other is as accurate with less work"),
    ("order", "method", "", "fitted order"),
    ("order_kind", "method", "", "order: of the setting; digits: gained with each unit of it"),
    ("agreement", "", "", "relative agreement of the reference"),
    ("extra_work", "", "", "work of the default over the least"),
)


def _add(record: Record, one: Measured) -> None:
    topic, reference, noise = one.topic, one.reference, one.reference.noise
    trials = [trial._asdict() for trial in one.trials]
    methods = [solver.name for solver in topic.solvers]
    axes = {"trial": np.array([trial.name for trial in one.trials], dtype=object),
            "method": np.array(methods, dtype=object)}  # fmt: skip
    kinds, orders = zip(*(
        fitted([trial for trial in one.trials if trial.method == name], reference.agreement)
        for name in methods
    ), strict=True)  # fmt: skip
    of_topic = {
        "on_front": np.array(on_front(one.trials, noise, "work"), dtype=int),
        "order": orders, "order_kind": np.array(kinds, dtype=object),
        "agreement": reference.agreement, "extra_work": extra(one.trials, noise, "work"),
    }  # fmt: skip
    errors = {
        "worst_relative": noise,
        "worst_level": _DECIBELS * noise / LEAST_SHARE,
        "position_error": noise * abs(reference.position or 0.0),
    }
    for name, axis, unit, words in _RESULTS:
        if name != "position_error" or topic.position:
            values = of_topic.get(name, [trial.get(name) for trial in trials])
            kind = {"cause": object, "is_default": int}.get(name)
            said = f"{topic.ask.name}: {words.format(position=topic.position, work=topic.work)}"
            entry = Entry(f"{folder_of(topic)}/{name}", (axis,) if axis else (), unit, said)
            record.add(entry.quantity(np.array(values, dtype=kind), errors.get(name, 0.0), axes))


def _slug(text: str) -> str:
    return re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_")
