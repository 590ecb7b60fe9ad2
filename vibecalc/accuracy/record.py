"""Measured topics as results with paths, units and axes, and the part that changes by the run."""

import json
import math
import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibecalc.accuracy.cheapest import cheapest_in_seconds, cheapest_in_work
from vibecalc.accuracy.errors import LEAST_SHARE
from vibecalc.accuracy.front import extra_seconds, extra_work, front_in_seconds, front_in_work
from vibecalc.accuracy.order import fitted
from vibecalc.accuracy.rung import Measured, Rung
from vibecalc.accuracy.topic import Ladder, Topic
from vibecalc.results.accuracy_layout import BETWEEN, NOT_FITTED, NOT_RUN, ROOT, TARGETS
from vibecalc.results.record import Axis, Method, Quantity, Record

#: a level changes by so many dB with a small relative change
_DECIBELS = 20.0 / math.log(10.0)


def folder_of(topic: Topic) -> str:
    """`accuracy/<stage>/<topic>`, in letters, digits and underscores."""
    return "/".join((ROOT, _slug(topic.stage), _slug(topic.name)))


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
            "seconds": [None if rung.status == NOT_RUN else rung.seconds for rung in rungs],
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
