"""Measured topics as results: orders of convergence, what nothing beats, what is cheapest."""

import json
import math
import re
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.accuracy.topic import LEAST_SHARE, Ladder, Measured, Rung, Topic
from vibecalc.core.results.layout import (
    ACCURACY,
    ALGEBRAIC,
    BETWEEN,
    GEOMETRIC,
    NOT_FITTED,
    RUNG_NOT_RUN,
    TARGETS,
)
from vibecalc.core.results.record import Axis, Method, Quantity, Record
from vibecalc.numerics.rounding import EPSILON

# ----------------------------------------------------------------------------
# The order of convergence that a ladder shows, fitted above round-off.
# ----------------------------------------------------------------------------

#: rungs count that stand this far above what the reference or round-off can tell
_CLEAR, _ROUNDINGS = 30.0, 16

#: relative errors above this say little about the order, and are left out if enough others remain
_COARSE = 0.1

#: an end of the ladder that falls with less than this order has not begun to converge, or ended
_FLAT = 0.1

_LEAST_RUNGS = 3


class Fit(NamedTuple):
    """What was fitted: `kind` is "order" (error ~ setting^+-p) or "digits" (for each step of 1).

    `value` is p, positive where finer settings have smaller errors, or the digits gained with
    each unit of the setting; `rungs` of the ladder took part.
    """

    kind: str
    value: float
    rungs: int


def fitted(rungs: Sequence[Rung], agreement: float) -> Fit | None:
    """The order shown by the rungs of one ladder, from coarse to fine; None with fewer than three.

    Least squares of log error on log setting, and, where settings grow, of log error on the
    setting itself; the one that fits better is taken. `agreement` is that of the reference: rungs
    have to be 30 times above it and above 16 roundings.
    """
    floor = _CLEAR * max(agreement, _ROUNDINGS * EPSILON)
    used = [
        (rung.setting, rung.worst_relative)
        for rung in rungs
        if rung.done and rung.setting > 0.0 and floor < rung.worst_relative < np.inf
    ]
    fine = [pair for pair in used if pair[1] <= _COARSE]
    used = _falling(fine if len(fine) >= _LEAST_RUNGS else used)
    if len(used) < _LEAST_RUNGS:
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
# Which rungs nothing beats: the Pareto front between error and cost.
# ----------------------------------------------------------------------------


def front(rungs: Sequence[Rung], cost: Callable[[Rung], float]) -> tuple[bool, ...]:
    """Whether each rung is on the front: none is cheaper and as accurate, or as cheap and better.

    Errors within the noise of the topic count as equal, so that of several rungs at round-off
    only the cheapest stays. Rungs that were not measured are never on it.
    """
    return tuple(
        one.done and not any(_beats(other, one, cost) for other in rungs if other.done)
        for one in rungs
    )


def front_in_work(rungs: Sequence[Rung]) -> tuple[bool, ...]:
    """The front in counted work, the same on every machine."""
    return front(rungs, lambda rung: rung.work)


def front_in_seconds(rungs: Sequence[Rung]) -> tuple[bool, ...]:
    """The front in seconds, of this machine and this day."""
    return front(rungs, lambda rung: rung.seconds)


def extra_work(topic: Topic, rungs: Sequence[Rung]) -> float:
    """Work of the default over the least work of any rung that is as accurate; 1 on the front.

    Of several defaults (a topic may have more than one) the worst counts; infinite where a default
    failed or was not run, 1 where the topic has none. To be held against `topic.default_extra`.
    """
    return _extra(topic, rungs, lambda rung: rung.work)


def extra_seconds(topic: Topic, rungs: Sequence[Rung]) -> float:
    """The same in seconds."""
    return _extra(topic, rungs, lambda rung: rung.seconds)


def _extra(topic: Topic, rungs: Sequence[Rung], cost: Callable[[Rung], float]) -> float:
    asked = any(ladder.default is not None for ladder in topic.ladders)
    defaults = [rung for rung in rungs if rung.is_default]
    if asked and not defaults:
        raise ValueError(f"{topic.name}: the rungs are not of this topic, no default among them")
    worst = 1.0
    for default in defaults:
        if not default.done:
            return float("inf")
        equals = (cost(rung) for rung in rungs if rung.done and rung.error <= default.error)
        worst = max(worst, cost(default) / min(equals))
    return worst


def _beats(other: Rung, one: Rung, cost: Callable[[Rung], float]) -> bool:
    no_worse = cost(other) <= cost(one) and other.error <= one.error
    return no_worse and (cost(other) < cost(one) or other.error < one.error)


# ----------------------------------------------------------------------------
# The cheapest method and setting that reaches an error.
# ----------------------------------------------------------------------------


def cheapest(rungs: Sequence[Rung], target: float, cost: Callable[[Rung], float]) -> int | None:
    """Place of the cheapest rung whose worst relative error is at most `target`, None without one.

    Of equally cheap ones the more accurate is taken, then the first.
    """
    reaching = [
        (cost(rung), rung.error, place)
        for place, rung in enumerate(rungs)
        if rung.done and rung.worst_relative <= target
    ]
    return min(reaching)[2] if reaching else None


def cheapest_in_work(rungs: Sequence[Rung]) -> tuple[int | None, ...]:
    """For each of `TARGETS`, by counted work."""
    return tuple(cheapest(rungs, target, lambda rung: rung.work) for target in TARGETS)


def cheapest_in_seconds(rungs: Sequence[Rung]) -> tuple[int | None, ...]:
    """For each of `TARGETS`, by seconds."""
    return tuple(cheapest(rungs, target, lambda rung: rung.seconds) for target in TARGETS)


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
        _add_rungs(record, one)
        _add_methods(record, one)
        for ladder in one.topic.ladders:
            method = Method(name=ladder.name, purpose=one.topic.name, citation=ladder.citation)
            if ladder.citation and method not in record.methods:
                record.methods.append(method)
    return record


def measured_text(measured: Sequence[Measured]) -> str:
    """What changes from run to run, as JSON by the folder of the topic."""
    found: dict[str, Any] = {}
    for one in measured:
        rungs = one.rungs
        extra = extra_seconds(one.topic, rungs)
        found[folder_of(one.topic)] = {
            "seconds": [None if rung.status == RUNG_NOT_RUN else rung.seconds for rung in rungs],
            "on_front": [int(mark) for mark in front_in_seconds(rungs)],
            "cheapest": [_number(place) for place in cheapest_in_seconds(rungs)],
            "extra": extra if math.isfinite(extra) else None,
        }
    return json.dumps(found)


def plan_rows(measured: Sequence[Measured]) -> tuple[dict[str, str], ...]:
    """The words of each topic, followed by those of its methods."""
    rows: list[dict[str, str]] = []
    for one in measured:
        topic, folder = one.topic, folder_of(one.topic)
        rows.append(
            {
                "folder": folder,
                "stage": topic.stage,
                "name": topic.name,
                "why": topic.words,
                "quantity": topic.quantity,
                "unit": topic.unit,
                "work": topic.work,
                "position": topic.position,
                "reference": one.reference.words,
                "default_extra": f"{topic.default_extra:g}",
                "default_why": topic.default_why,
            }
        )
        rows += [
            {
                "folder": folder,
                "stage": topic.stage,
                "method": ladder.name,
                "why": ladder.words,
                "setting": ladder.setting,
                "theory": ladder.theory,
                "citation": ladder.citation,
            }
            for ladder in topic.ladders
        ]
    return tuple(rows)


def _add_rungs(record: Record, one: Measured) -> None:
    topic, rungs, folder = one.topic, one.rungs, folder_of(one.topic)
    noise = rungs[0].noise if rungs else 0.0
    ladders = {ladder.name: ladder for ladder in topic.ladders}
    names = [_label(ladders[rung.ladder], rung) for rung in rungs]
    axis = Axis(name="rung", values=np.array(names, dtype=object), long_name="method and setting")
    level_noise = _DECIBELS * noise / LEAST_SHARE
    rows: list[tuple[str, Any, str, str, float]] = [
        ("worst_relative", [rung.worst_relative for rung in rungs], "",
         "largest error over the largest magnitude", noise),
        ("worst_level", [rung.worst_level for rung in rungs], "dB",
         "largest difference of level", level_noise),
        ("work", [rung.work for rung in rungs], "", f"work, in {topic.work}", 0.0),
        ("status", [rung.status for rung in rungs], "", "0 done, 1 failed, 2 not run", 0.0),
        ("cause", np.array([rung.cause for rung in rungs], dtype=object), "",
         "why a rung failed or was not run", 0.0),
        ("setting", [rung.setting for rung in rungs], "", "setting of the method", 0.0),
        ("is_default", [int(rung.is_default) for rung in rungs], "",
         "1: what vibecalc takes", 0.0),
        ("on_front", [int(mark) for mark in front_in_work(rungs)], "",
         "1: no other is as accurate with less work", 0.0),
    ]  # fmt: skip
    if topic.position:
        away = [math.inf if rung.position_error is None else rung.position_error for rung in rungs]
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
        fitted([rung for rung in one.rungs if rung.ladder == ladder.name], one.reference.agreement)
        for ladder in topic.ladders
    ]
    names = np.array([ladder.name for ladder in topic.ladders], dtype=object)
    method = Axis(name="method", values=names, long_name="method")
    target = Axis(name="target", values=np.array(TARGETS), long_name="worst relative error asked")
    extra = extra_work(topic, one.rungs)
    for name, values, axes, words in (
        ("order", [fit.value if fit else 0.0 for fit in fits], (method,), "fitted order"),
        (
            "order_kind",
            np.array([fit.kind if fit else NOT_FITTED for fit in fits], dtype=object),
            (method,),
            "order: of the setting; digits: gained with each unit of it",
        ),
        (
            "cheapest_in_work",
            [_number(place) for place in cheapest_in_work(one.rungs)],
            (target,),
            "number of the rung with the least work, 0 for none",
        ),
        ("agreement", one.reference.agreement, (), "relative agreement of the reference"),
        ("extra_work", extra, (), "work of the default over the least as accurate"),
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


def _label(ladder: Ladder, rung: Rung) -> str:
    return f"{ladder.name}{BETWEEN}{rung.setting:.12g}" if ladder.setting else ladder.name


def _number(place: int | None) -> int:
    return 0 if place is None else place + 1


def _slug(text: str) -> str:
    return re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_")
