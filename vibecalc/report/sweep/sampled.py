"""Statistics of a sampling: mean, quantiles, and the share of the variance each key brings."""

from typing import Any

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.report.numbers import show, show_error
from vibecalc.report.sweep.view import SweepView
from vibecalc.report.sweep.worst import Worst, numeric, worst
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Estimate
from vibecalc.study.sweep.indices import Indices, sobol_indices
from vibecalc.study.sweep.statistics import LEVELS, Statistic, mean, quantiles

_DIGITS = 4
_STATISTICS = (
    Column("quantity", 23),
    number("mean", 10),
    number("+-", 8),
    *(number(f"{100 * level:g} %", 10) for level in LEVELS),
)
_INDICES = (
    Column("quantity", 38),
    Column("key", 21),
    number("first", 9),
    number("+-", 7),
    number("total", 9),
    number("+-", 7),
)


def statistic_lines(sweep: SweepView) -> list[str]:
    """Mean with its standard error and quantiles of every result; empty for a grid."""
    if sweep.grid:
        return []
    rows, notes = [], []
    for path in numeric(sweep):
        counted = worst(sweep, path)
        name = f"{path} {sweep.kept[path].unit}".rstrip()
        found = sample_statistics(sweep, counted)
        if isinstance(found, str):
            notes.append(f"{path}: {found}")
            continue
        centre, ranks = found
        terms = counted.estimate(0).terms

        def shown(value: Any, error: Any, terms: float = terms) -> str:
            return show(float(value), Estimate(float(error), terms), _DIGITS)

        cells = [shown(value, error) for value, error in _pairs(ranks)]
        middle = shown(centre.value, centre.error)
        rows.append([name, middle, show_error(float(centre.standard_error)), *cells])
    lines = table(_STATISTICS, rows) if rows else []
    if rows:
        lines += paragraph(
            "+-: standard error of the mean, as of independent samples; of several entries at a "
            "point the largest one counts"
        )
    for note in notes:
        lines += paragraph(note)
    return lines


def sample_statistics(sweep: SweepView, counted: Worst) -> tuple[Statistic, Statistic] | str:
    """Mean and quantiles over the samples that were computed, or why there are none."""
    chosen = sweep.independent & sweep.done
    values, errors = counted.values[chosen], counted.errors[chosen]
    try:
        return mean(values, errors), quantiles(values, LEVELS, errors)
    except NumericalFailure as failure:
        return str(failure)


def index_lines(sweep: SweepView) -> list[str]:
    """First-order and total Sobol indices with standard errors; empty without them."""
    if not sweep.indices:
        return []
    names = axis_names(sweep)
    rows: list[list[str]] = []
    notes: list[str] = []
    samples = 0
    for path in numeric(sweep):
        found = indices_of(sweep, worst(sweep, path))
        if isinstance(found, str):
            notes.append(f"{path}: {found}")
            continue
        samples = found.samples
        for place, name in enumerate(names):
            cells = [path if place == 0 else "", name]
            for part in (found.first, found.total):
                cells.append(f"{float(part.value[place]):.3f}")
                cells.append(f"{float(part.standard_error[place]):.3f}")
            rows.append(cells)
    lines = table(_INDICES, rows) if rows else []
    if rows:
        lines += paragraph(
            "share of the variance that a key brings about, first: alone, total: with all its "
            f"interactions; from {samples} sampled points with {len(names) + 2} runs each, +-: "
            "standard error from resampling them"
        )
    for note in notes:
        lines += paragraph(note)
    return lines


def indices_of(sweep: SweepView, counted: Worst) -> Indices | str:
    """Sobol indices of one result, or why there are none."""
    values = np.where(sweep.done, counted.values, 0.0)
    errors = np.where(sweep.done, counted.errors, 0.0)
    columns = len(sweep.together)
    try:
        found = sobol_indices(values[:, None], columns, errors[:, None], sweep.done)
    except NumericalFailure as failure:
        return str(failure)
    first, total = (
        Statistic(*(np.asarray(part).reshape(columns) for part in statistic))
        for statistic in (found.first, found.total)
    )
    return Indices(first, total, found.samples)


def axis_names(sweep: SweepView) -> list[str]:
    """What is drawn together counts as one: the words of its first key."""
    return [sweep.keys[places[0]].words for places in sweep.together]


def _pairs(statistic: Statistic) -> list[tuple[float, float]]:
    value, error = np.ravel(statistic.value), np.ravel(statistic.error)
    return list(zip(value, error, strict=True))
