"""What to change, from what to what, what that brings, and what a small error in it costs."""

from collections.abc import Mapping
from typing import Any

from vibecalc.report.lookup import labels, scalar_of, table_of
from vibecalc.report.numbers import show, show_percent
from vibecalc.report.sections.key_start import start_of
from vibecalc.report.tables import paragraph
from vibecalc.results.record import Record, Result

_PREFIX = "optimisation/"


def advice(result: Result) -> list[str]:
    """One paragraph for each variable and one for all; nothing without computed slopes.

    Every number is a result or a value of the case.
    """
    record = result.record
    study: Mapping[str, Any] = table_of(result.case, "optimisation")
    keys = [str(variable["key"]) for variable in study.get("variables") or ()]
    said = [(key, _words(result, key)) for key in keys]
    lines = []
    for key, words in said:
        if words:
            lines += paragraph(f"{key}: {words}", "-")
    if not lines:
        return []
    return ["", *paragraph("advice:"), *lines, *_gain(record, study)]


def _words(result: Result, key: str) -> str:
    record = result.record
    if not any(f"{_PREFIX}{part}/{key}" in record for part in ("sensitivity", "deviation/loss")):
        return ""
    optimum = record.quantities.get(f"{_PREFIX}variable/{key}")
    if optimum is None:
        return ""
    start, end = start_of(result, key), float(optimum.values)
    value = f"{show(end, optimum.error_estimate)} {optimum.unit}".rstrip()
    if start is None:
        parts = [f"{value} is best"]
    elif abs(end - start) <= optimum.error_estimate:
        parts = [f"leave it at {value}"]
    else:
        verb = "raise" if end > start else "lower"
        parts = [f"{verb} it from {show(start)} to {value}"]
    slope = record.quantities.get(f"{_PREFIX}sensitivity/{key}")
    goal = record.quantities.get(_PREFIX + "objective")
    if slope is not None:
        for place, one in zip(labels(slope.axes[0]), slope.values, strict=True):
            shown = show(one, slope.error_estimate, digits=4)
            unit = goal.unit if goal is not None else ""
            each = f" per {optimum.unit}" if optimum.unit else ""
            parts.append(f"slope at the {place} {shown} {unit}".rstrip() + each)
    return "; ".join([*parts, *_deviation(record, key)])


def _deviation(record: Record, key: str) -> list[str]:
    size = record.quantities.get(f"{_PREFIX}deviation/size/{key}")
    loss = record.quantities.get(f"{_PREFIX}deviation/loss/{key}")
    if size is None or loss is None:
        return []
    moved, lost = float(size.values), float(loss.values)
    way = "more" if moved > 0 else "less"
    amount = f"{show(abs(moved), digits=4)} {size.unit}".rstrip()
    objective = scalar_of(record, _PREFIX + "objective")
    if abs(lost) <= loss.error_estimate:
        effect = "changes the objective by nothing that can be seen"
    else:
        share = f" ({show_percent(abs(lost / objective)).lstrip('+')})" if objective else ""
        verb = "costs" if lost > 0 else "gains"
        effect = f"{verb} {show(abs(lost), digits=4)} {loss.unit}".rstrip() + share
    words = [f"at the optimum {amount} {way} {effect}"]
    margin = record.quantities.get(f"{_PREFIX}deviation/margin/{key}")
    if margin is not None and float(margin.values) < -margin.error_estimate:
        broken = show_percent(-float(margin.values)).removeprefix("+")
        words.append(f"a deviation of that size may break a limit by {broken} of its bound")
    return words


def _gain(record: Record, study: Mapping[str, Any]) -> list[str]:
    gain = record.quantities.get(_PREFIX + "gain")
    if gain is None:
        return []
    value = float(gain.values)
    sense = "lower" if table_of(study, "objective").get("sense", "min") == "min" else "higher"
    amount = f"{show(abs(value), gain.error_estimate)} {gain.unit}".rstrip()
    if value < -gain.error_estimate:
        sense = "higher" if sense == "lower" else "lower"
        return paragraph(f"together: the objective becomes {sense} by {amount}, to keep the limits")
    return paragraph(f"together: the objective becomes {sense} by {amount}")
