"""The end of the report: warnings, methods, accuracy, and what changes from run to run."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from vibecalc.pipeline.tolerance import CHECKS, UNRESOLVED
from vibecalc.report.lookup import START, magnitudes
from vibecalc.report.numbers import show, show_error
from vibecalc.report.sections.section import Section
from vibecalc.report.sections.tolerance import stage_times
from vibecalc.report.tables import Column, number, pairs, paragraph, table
from vibecalc.results.record import Quantity, Result

_WORST = 8


def warnings(result: Result) -> Section | None:
    """Warnings of the run, equal ones once with their count."""
    counts: dict[str, int] = {}
    for text in result.record.warnings:
        counts[text] = counts.get(text, 0) + 1
    lines: list[str] = []
    for text, count in counts.items():
        lines += paragraph(text + (f" ({count} times)" if count > 1 else ""), "-")
    return Section("Warnings", lines, frozenset()) if lines else None


def plan(result: Result) -> Section | None:
    """Which stages ran and why, as planned before anything was computed."""
    lines: list[str] = []
    for row in result.plan:
        lines += pairs([(row.get("stage", "stage"), _planned(row))], 16)
    return Section("Plan", lines, frozenset()) if lines else None


def methods(result: Result) -> Section | None:
    """Methods that took part, with where they are published."""
    lines: list[str] = []
    for i, method in enumerate(result.record.methods):
        lines += paragraph(f"{method.name}: {method.purpose}. {method.citation}", f"[{i + 1}]")
    return Section("Methods", lines, frozenset()) if lines else None


def accuracy(result: Result, full: bool = False) -> Section | None:
    """Largest magnitude, error estimate and their ratio, the worst first unless `full`."""
    quantities = [
        quantity
        for path, quantity in result.record.items()
        if np.size(quantity.values) and (full or not path.startswith(START))
    ]
    if not quantities:
        return None
    chosen = quantities
    if not full:
        # Equal ratios keep the order of the record, so that the table is stable.
        chosen = sorted(quantities, key=lambda quantity: -_ratio(quantity))[:_WORST]
    columns = (
        Column("quantity", 48),
        number("largest", 13),
        Column("unit", 10),
        number("error", 11),
        number("relative", 11),
    )
    rows = [
        [
            quantity.path,
            show(_largest(quantity), quantity.error_estimate),
            quantity.unit,
            show_error(quantity.error_estimate),
            _shown_ratio(quantity),
        ]
        for quantity in chosen
    ]
    lines = table(columns, rows)
    rest = len(quantities) - len(chosen)
    if rest:
        lines += paragraph(f"and {rest} more that are known better; all are in the result file")
    dial = _dial(result.case)
    title = "Accuracy: error estimates" + (f" (asked for: rtol = {dial})" if dial else "")
    return Section(title, lines, frozenset())


def provenance(result: Result) -> Section:
    """Time per stage, versions, and how to run the case again. Nothing stable stands below."""
    rows = [(str(key), str(value)) for key, value in result.provenance.items() if key != "command"]
    wide = max(24, *(len(name) for name, _ in rows)) if rows else 24
    lines = [*stage_times(result), *pairs([*rows, ("rerun", rerun(result))], wide)]
    return Section("Provenance (changes from run to run)", lines, frozenset())


def rerun(result: Result) -> str:
    """The command that makes this result again."""
    return str(result.provenance.get("command") or f"vibecalc run {result.name}.toml")


def _planned(row: Mapping[str, str]) -> str:
    parts = [row["why"]] if row.get("why") else []
    parts += [f"{key}: {row[key]}" for key in ("parts", "orders", "cost") if row.get(key)]
    return "; ".join(parts)


def _dial(case: Mapping[str, Any]) -> str:
    table_ = case.get("accuracy")
    rtol = table_.get("rtol") if isinstance(table_, Mapping) else None
    return "" if rtol is None else f"{rtol:g}"


def _largest(quantity: Quantity) -> float:
    values = magnitudes(quantity)
    if values.dtype.kind not in "biuf":
        return 0.0
    return float(np.max(np.abs(values)))


def _ratio(quantity: Quantity) -> float:
    largest = _largest(quantity)
    if quantity.error_estimate == 0.0 or np.isinf(largest):
        return 0.0
    # Where all cancels the estimate is all there is; that is no loss of accuracy.
    if quantity.estimate.is_zero(largest) or quantity.path.endswith(CHECKS):
        return 0.0
    return float(quantity.error_estimate) / largest if largest else float("inf")


def _shown_ratio(quantity: Quantity) -> str:
    largest = _largest(quantity)
    if np.isinf(largest):
        return "unbounded"
    if quantity.error_estimate and largest <= quantity.error_estimate:
        if quantity.path.endswith(CHECKS):
            return "a check"
        return "zero" if quantity.estimate.is_zero(largest) else UNRESOLVED
    return show_error(_ratio(quantity))
