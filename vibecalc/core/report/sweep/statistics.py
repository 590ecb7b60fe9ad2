"""Results of a sweep in numbers: worst entries, smallest and largest, quantiles, shares."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.report.sections import read_as
from vibecalc.core.report.sweep.view import SweepView
from vibecalc.core.report.writing import decibels, number, paragraph, show, show_error, table
from vibecalc.core.results.record import Estimate, Quantity
from vibecalc.core.results.select import Side, select
from vibecalc.core.results.tolerance import UNRESOLVED
from vibecalc.core.study.sweep.sampling import (
    LEVELS,
    Indices,
    Statistic,
    mean,
    quantiles,
    sobol_indices,
)
from vibecalc.errors import NumericalFailure
from vibecalc.units import convert

# ----------------------------------------------------------------------------
# A result of many entries at each point of a sweep, reduced to its worst entry, which is named.
# ----------------------------------------------------------------------------


class Worst(NamedTuple):
    """One number for each point of a sweep, NaN where there is none, and which entry it is.

    `errors` are absolute, `spread` is the standard error of a statistic or None. `labels` name
    the entries, `entry` (points,) counts them.
    """

    values: np.ndarray
    errors: np.ndarray
    spread: np.ndarray | None
    entry: np.ndarray
    labels: tuple[str, ...]

    def estimate(self, point: int) -> Estimate:
        """The error at a point; the largest value of all points stands for its terms."""
        size = np.abs(self.values)
        largest = float(np.max(size, initial=0.0, where=np.isfinite(size)))
        return Estimate(float(self.errors[point]), largest, own=True)

    def label(self, point: int) -> str:
        """Name of the entry that counts at a point, empty for a single number."""
        return self.labels[int(self.entry[point])].replace("=", " ")

    def times(self, factor: float) -> "Worst":
        """The same in another unit."""
        spread = None if self.spread is None else factor * self.spread
        return self._replace(
            values=factor * self.values, errors=factor * self.errors, spread=spread
        )


def numeric(sweep: SweepView) -> list[str]:
    """Paths of kept results that are numbers, those that the case asks to keep in its order."""
    asked: Any = (sweep.case.get("sweep") or {}).get("keep") or ()
    paths = [str(path) for path in asked if str(path) in sweep.quantities]
    paths += [path for path in sweep.quantities if path not in paths]
    spreads = {f"{path}_standard_error" for path in paths}
    return [path for path in paths if path not in spreads and all(_shape(sweep.quantities[path]))]


def read_worst(
    sweep: SweepView, path: str, where: Mapping[str, Any] | None = None
) -> tuple[str, str, Worst]:
    """Name and unit in which a result is read, and the largest entry at each point in it."""
    own = sweep.quantities[path].unit
    name, unit = read_as(path, own)
    return name, unit, worst(sweep, path, where).times(convert(1.0, own, unit))


def worst(
    sweep: SweepView, path: str, where: Mapping[str, Any] | None = None, side: Side = "max"
) -> Worst:
    """The largest ("max") or smallest entry at each point that `where` leaves of a result.

    Complex entries count by magnitude. Of entries that are the same within their errors the
    first one counts, so that round-off does not choose the name. Raises ResultError where an axis
    or entry does not exist.
    """
    places, labels = _places(sweep.quantities[path], where or {})
    stacked = sweep.read(path)
    values = _chosen(stacked.values, places)
    entry = first_of(values, stacked.errors[:, None], side)
    reduced = (np.fmax if side == "max" else np.fmin).reduce(values, axis=1)
    spread = _spread(sweep, path, places, entry, stacked.standard_errors)

    known = np.where(sweep.done, 0.0, np.nan)
    return Worst(
        reduced + known,
        stacked.errors + known,
        None if spread is None else spread + known,
        entry,
        labels,
    )


def entries(sweep: SweepView, path: str) -> tuple[np.ndarray, tuple[str, ...]]:
    """All entries of a result at each point, (points, entries), and their names."""
    places, labels = _places(sweep.quantities[path], {})
    values = _chosen(sweep.read(path).values, places)
    return np.where(sweep.done[:, None], values, np.nan), labels


def _places(quantity: Quantity, where: Mapping[str, Any]) -> tuple[np.ndarray, tuple[str, ...]]:
    shape = _shape(quantity)
    count = int(np.prod(shape))
    chosen = select(replace(quantity, values=np.arange(count).reshape(shape)), where)
    return np.ravel(chosen.values), chosen.labels


#: relative difference that is none where the error does not tell it, either
_ALIKE = 1e-8


def alike(errors: np.ndarray, size: np.ndarray | float) -> np.ndarray:
    """How far values of a size may be apart that are the same but for rounding.

    What is left out of them, as orders are, is in their errors and makes no two of them the same.
    Of values that do not exceed their errors none tells anything.
    """
    size = np.abs(size)
    known = np.isfinite(errors) & np.isfinite(size)
    with np.errstate(invalid="ignore"):
        slack = np.where(size <= errors, errors, np.minimum(errors, _ALIKE * size))
    return np.where(known, slack, 0.0)


def _chosen(values: np.ndarray, places: np.ndarray) -> np.ndarray:
    flat = values.reshape(len(values), -1)[:, places]
    return np.abs(flat) if np.iscomplexobj(flat) else flat.astype(float)


def first_of(values: np.ndarray, errors: np.ndarray, side: str) -> np.ndarray:
    """Places (...,) of the largest ("max") or smallest of values (..., n) along the last axis.

    Of those that are the same within their errors (..., n) or (..., 1) the first one; NaN does not
    count, unless there is nothing else.
    """
    known = ~np.isnan(values)
    signed = np.where(known, values if side == "max" else -values, -np.inf)
    at = np.argmax(signed, axis=-1)[..., None]
    top = np.take_along_axis(signed, at, -1)
    slack = np.broadcast_to(alike(errors, top), signed.shape)
    with np.errstate(invalid="ignore"):
        level = np.where(np.isfinite(top), top - slack - np.take_along_axis(slack, at, -1), top)
    return np.asarray(np.argmax(known & (signed >= level), axis=-1))


def _spread(
    sweep: SweepView, path: str, places: np.ndarray, entry: np.ndarray, own: np.ndarray | None
) -> np.ndarray | None:
    """Standard error of the entry that counts: its own result if kept, else one for all."""
    twin = sweep.quantities.get(f"{path}_standard_error")
    if twin is None or _shape(twin) != _shape(sweep.quantities[path]):
        return own
    values = _chosen(sweep.read(twin.path).values, places)
    return np.take_along_axis(values, entry[:, None], axis=1)[:, 0]


def _shape(quantity: Quantity) -> tuple[int, ...]:
    return tuple(len(axis.values) for axis in quantity.axes)


# ----------------------------------------------------------------------------
# Results point by point, along a single axis.
# ----------------------------------------------------------------------------

#: points, results and orders of a level that are listed
_MOST_POINTS, _MOST_RESULTS, _MOST_ORDERS = 21, 8, 4


def point_lines(sweep: SweepView) -> list[str]:
    """A row for each point, or every so many, of a grid along one axis; else empty.

    Of several entries at a point the largest one counts, but orders of a level have columns.
    """
    if not sweep.grid or len(sweep.shape) != 1:
        return []
    step = -(-sweep.count // _MOST_POINTS)
    shown, key = np.unique([*range(0, sweep.count, step), sweep.count - 1]), sweep.keys[0]
    heads = [number(f"{key.label} {key.written_unit}".rstrip())]
    columns = [[key.number(value) for value in sweep.values_of(shown)[:, 0]]]
    for path in numeric(sweep)[:_MOST_RESULTS]:
        name, unit, counted = read_worst(sweep, path)
        each = {f"{name} {unit}".rstrip(): counted}
        if orders := _orders(sweep.quantities[path])[:_MOST_ORDERS]:
            level = read_as(path, unit, entry=True)[0]
            each = {f"{level}, order {order:g} {unit}": worst(sweep, path, {"order": order})
                    for order in orders}  # fmt: skip
        for head, one in each.items():
            heads.append(number(head))
            columns.append([_at_point(one, int(point), unit) for point in shown])
    return table(heads, zip(*columns, strict=True))


def _at_point(one: Worst, point: int, unit: str) -> str:
    value = one.values[point]
    if np.isnan(value):
        return "-"
    return decibels(value) if unit == "dB" else show(value, one.estimate(point))


# ----------------------------------------------------------------------------
# Smallest and largest value of every result of a sweep, and where they are.
# ----------------------------------------------------------------------------


def extreme_lines(sweep: SweepView) -> list[str]:
    """A table with two rows for each result: its smallest and its largest value.

    Of several entries at a point the largest one counts, but each order of a level has rows of its
    own. What is the same at all points has one
    row; infinite values are counted below the table.
    """
    rows: list[list[str]] = []
    unbounded: list[str] = []
    for path in numeric(sweep):
        name, unit, counted = read_worst(sweep, path)
        orders = _orders(sweep.quantities[path])
        name = read_as(path, unit, entry=True)[0] if orders else name
        for place, order in enumerate(orders):
            title = f"  order {order:g}" if place else f"{name}\n  order {order:g}"
            rows += _rows(sweep, worst(sweep, path, {"order": order}), title, unit)
        if not orders:
            rows += _rows(sweep, counted, name, unit)
        infinite = int(np.count_nonzero(np.isinf(counted.values)))
        if infinite:
            finite = np.isfinite(counted.values)
            most = show(np.max(counted.values[finite])) if finite.any() else "none"
            unbounded.append(
                f"{name} is unbounded at {infinite} points; the largest finite value is "
                f"{most} {unit}".rstrip()
            )
    if not rows:
        return []
    lines = table(("quantity", "", number("value"), "unit", "at"), rows)
    return [*lines, *(line for words in unbounded for line in paragraph(words))]


def _orders(quantity: Quantity) -> list[float]:
    """Orders of a level: one may fall far below another, and each has its own best place."""
    if quantity.unit != "dB":
        return []
    return [float(n) for axis in quantity.axes if axis.name == "order" for n in axis.values]


def _rows(sweep: SweepView, counted: Worst, name: str, unit: str) -> list[list[str]]:
    values, errors = counted.values, counted.errors
    if np.all(np.isnan(values)):
        return [[name, "", "none", unit, "no point was computed"]]
    low, high = (int(first_of(values, errors, side)) for side in ("min", "max"))

    def row(title: str, kind: str, point: int, where: str = "") -> list[str]:
        label = counted.label(point)
        where = where or sweep.words_of(point).replace(", ", "\n")
        where += f"\n({label})" if label and label not in name else ""
        return [title, kind, show(values[point], counted.estimate(point)), unit, where]

    if low != high:
        largest = row("", "largest", high)
        peaks = [one for one in sweep.crossings if one.peaks(values)]
        if peaks:
            top = max(peaks, key=lambda one: np.nanmax(values[[*one.pair]]))
            where = "between " + "\nand ".join(map(sweep.words_of, top.pair)).replace(", ", "\n")
            why = "has no damping" if top.bare else "may have no damping"
            value = "unbounded" if top.bare else f"> {largest[2]}"
            largest = ["", "largest", value, unit, f"{where}\n({top.words}, which {why})"]
        return [row(name, "smallest", low), largest]
    if counted.estimate(low).unresolved(float(values[low])):
        return [row(name, "", low, f"{UNRESOLVED} at all points")]
    return [row(name, "all points", low, "")]


# ----------------------------------------------------------------------------
# Statistics of a sampling: mean, quantiles, and the share of the variance each key brings.
# ----------------------------------------------------------------------------


def statistic_lines(sweep: SweepView) -> list[str]:
    """Mean with its standard error and quantiles of every result; empty for a grid."""
    if sweep.grid:
        return []
    rows, notes = [], []
    for path in numeric(sweep):
        name, unit, counted = read_worst(sweep, path)
        statistics = sample_statistics(sweep, counted)
        if isinstance(statistics, str):
            notes.append(f"{name}: {statistics}")
            continue
        terms, shown = counted.estimate(0).terms, []
        for one in statistics:
            pairs = zip(np.ravel(one.value), np.ravel(one.error), strict=True)
            shown += [show(float(value), Estimate(float(error), terms)) for value, error in pairs]
        spread = show_error(float(statistics[0].standard_error))
        rows.append([f"{name} {unit}".rstrip(), shown[0], spread, *shown[1:]])
    heads = "quantity", "mean", "+-", *(f"{100 * level:g} %" for level in LEVELS)
    words = (
        "+-: standard error of the mean for independent samples; the largest of several "
        "entries at a point is used"
    )
    notes = [words] * bool(rows) + notes
    lines = table([heads[0], *map(number, heads[1:])], rows) if rows else []
    return [*lines, *(line for note in notes for line in paragraph(note))]


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
    names, rows, lines = axis_names(sweep), list[list[str]](), list[str]()
    for path in numeric(sweep):
        title, _, counted = read_worst(sweep, path)
        indices = indices_of(sweep, counted)
        if isinstance(indices, str):
            lines += paragraph(f"{title}: {indices}")
            continue
        samples = indices.samples
        parts = indices[:4]
        for place, name in enumerate(names):
            cells = [f"{float(part[place]):.3f}" for part in parts]
            rows.append(["" if place else title, name, *cells])
    if not rows:
        return lines
    heads = "quantity", "key", number("first"), number("+-"), number("total"), number("+-")
    words = (
        "share of the variance due to a key; first: alone, total: with all interactions; "
        f"from {samples} sampled points with {len(names) + 2} runs each, +-: standard error by "
        "resampling"
    )
    return [*table(heads, rows), *paragraph(words), *lines]


def indices_of(sweep: SweepView, counted: Worst) -> Indices | str:
    """Sobol indices of one result, or why there are none."""
    values, errors = (np.where(sweep.done, one, 0.0) for one in (counted.values, counted.errors))
    try:
        return sobol_indices(values, len(sweep.together), errors, sweep.done)
    except NumericalFailure as failure:
        return str(failure)


def axis_names(sweep: SweepView) -> list[str]:
    """What is drawn together counts as one: the words of its first key."""
    return [sweep.keys[places[0]].label for places in sweep.together]
