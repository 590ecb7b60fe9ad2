"""The object that `vibecalc accuracy --json` prints."""

import math
from pathlib import Path
from typing import Any

from vibecalc.report.accuracy.view import RungView, TopicView, topics_of
from vibecalc.report.sections.closing import rerun
from vibecalc.results.accuracy_layout import STATUS_WORDS, TARGETS
from vibecalc.results.record import Result


def accuracy_object(result: Result, path: Path) -> dict[str, Any]:
    """Topics with their rungs as plain objects; what is not finite is None."""
    found = result.provenance
    return {
        "case": result.name,
        "result": str(path),
        "topics": [_topic(topic) for topic in topics_of(result)],
        "left_out": list(result.record.warnings),
        "machine": {name: found.get(name) for name in ("machine", "versions", "threads", "time")},
        "rerun": rerun(result),
    }


def _topic(topic: TopicView) -> dict[str, Any]:
    words = topic.words
    return {
        "stage": words["stage"],
        "name": words["name"],
        "words": words["why"],
        "quantity": words["quantity"] or None,
        "work": words["work"],
        "reference": {"words": words["reference"], "agreement": _finite(topic.agreement)},
        "rungs": [_rung(rung, bool(words["position"])) for rung in topic.rungs],
        "methods": [
            {"method": method.name, "shown": method.shown or None, "theory": method.theory or None}
            for method in topic.methods
        ],
        "cheapest": [
            {"error": target, "in_work": _place(topic, work), "in_seconds": _place(topic, seconds)}
            for target, work, seconds in zip(
                TARGETS, topic.cheapest_in_work, topic.cheapest_in_seconds, strict=True
            )
        ],
        "extra_work": _finite(topic.extra_work),
        "extra_seconds": _finite(topic.extra_seconds),
    }


def _rung(rung: RungView, with_position: bool) -> dict[str, Any]:
    position = {"position_error": _finite(rung.position)} if with_position else {}
    return {
        "method": rung.method,
        "setting": float(rung.setting) if rung.setting else None,
        "status": STATUS_WORDS[rung.status],
        "cause": rung.cause or None,
        "work": rung.work,
        "seconds": rung.seconds,
        "worst_relative": _finite(rung.relative),
        "worst_level": _finite(rung.level),
        **position,
        "default": rung.is_default,
        "front_in_work": rung.in_work,
        "front_in_seconds": rung.in_seconds,
    }


def _place(topic: TopicView, rung: RungView | None) -> int | None:
    """Place in the list of rungs."""
    return None if rung is None else topic.rungs.index(rung)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
