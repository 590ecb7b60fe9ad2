"""Results of a sweep in numbers: worst entries, smallest and largest, quantiles, shares."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.report.sections import read_as
from vibecalc.core.report.sweep.view import SweepView
from vibecalc.core.report.writing import number, paragraph, show, show_error, table
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
    return [path for path in paths if path not in spreads and _is_number(sweep.quantities[path])]


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
    quantity = sweep.quantities[path]
    places, labels = _places(quantity, where or {})
    stacked = sweep.read(path)
    values = _chosen(stacked.values, places)
    errors = np.where(sweep.done, stacked.errors, np.nan)
    reduced, entry = _reduced(values, stacked.errors, side)
    reduced = np.where(sweep.done, reduced, np.nan)
    spread = _spread(sweep, path, stacked.standard_errors, places, entry)
    return Worst(reduced, errors, spread, entry, labels)


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


def _reduced(values: np.ndarray, errors: np.ndarray, side: Side) -> tuple[np.ndarray, np.ndarray]:
    if values.shape[1] == 1:
        return values[:, 0], np.zeros(len(values), dtype=np.int64)
    signed = values if side == "max" else -values
    known = np.where(np.isnan(signed), -np.inf, signed)
    largest = known.max(axis=1)
    slack = 2.0 * alike(errors, largest)
    with np.errstate(invalid="ignore"):
        level = np.where(np.isfinite(largest), largest - slack, largest)
    entry = np.argmax(known >= level[:, None], axis=1)
    return (largest if side == "max" else -largest), entry


def _spread(
    sweep: SweepView, path: str, spread: np.ndarray | None, places: np.ndarray, entry: np.ndarray
) -> np.ndarray | None:
    """Standard error of the entry that counts: its own result if kept, else one for all."""
    twin = f"{path}_standard_error"
    if twin in sweep.quantities and _shape(sweep.quantities[twin]) == _shape(
        sweep.quantities[path]
    ):
        values = _chosen(sweep.read(twin).values, places)
        return np.asarray(np.where(sweep.done, values[np.arange(len(values)), entry], np.nan))
    return None if spread is None else np.where(sweep.done, spread, np.nan)


def _is_number(quantity: Quantity) -> bool:
    return quantity.values.dtype.kind in "biufc" and all(len(a.values) for a in quantity.axes)


def _shape(quantity: Quantity) -> tuple[int, ...]:
    return tuple(len(axis.values) for axis in quantity.axes)


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
        for place, order in enumerate(orders):
            title = f"  order {order}" if place else f"{name}\n  order {order}"
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


def first_of(values: np.ndarray, errors: np.ndarray, side: str) -> int:
    """The point of the largest ("max") or smallest value; of equal ones, within errors, the first.

    NaN does not count; ValueError if there is nothing else.
    """
    known = ~np.isnan(values)
    if not known.any():
        raise ValueError("there is no value to choose from")
    signed = np.where(known, values if side == "max" else -values, -np.inf)
    top = signed.max()
    if not np.isfinite(top):
        return int(np.argmax(known & (signed == top)))
    slack = alike(errors, top)
    at = int(np.argmax(signed))
    return int(np.argmax(known & (signed >= top - slack - slack[at])))


def _orders(quantity: Quantity) -> list[int]:
    """Orders of a level: one may fall far below another, and each has its own best place."""
    if quantity.unit != "dB":
        return []
    return [int(n) for axis in quantity.axes if axis.name == "order" for n in axis.values]


def _rows(sweep: SweepView, counted: Worst, name: str, unit: str) -> list[list[str]]:
    if np.all(np.isnan(counted.values)):
        return [[name, "", "none", unit, "no point was computed"]]
    low, high = (first_of(counted.values, counted.errors, side) for side in ("min", "max"))
    if low == high:
        label = counted.label(low)
        everywhere = "at all points" + (f"\n({label})" if label and label not in name else "")
        if counted.estimate(low).unresolved(float(counted.values[low])):
            return [[name, "", _value(counted, low), unit, f"{UNRESOLVED} {everywhere}"]]
        return [[name, "constant", _value(counted, low), unit, everywhere]]
    return [
        [name, "smallest", _value(counted, low), unit, _place(sweep, counted, low, name)],
        ["", "largest", _value(counted, high), unit, _place(sweep, counted, high, name)],
    ]


def _value(counted: Worst, point: int) -> str:
    return show(counted.values[point], counted.estimate(point))


def _place(sweep: SweepView, counted: Worst, point: int, name: str) -> str:
    words = sweep.words_of(point).replace(", ", "\n")
    label = counted.label(point)
    return f"{words}\n({label})" if label and label not in name else words


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
        "+-: standard error of the mean, as of independent samples; of several entries at a "
        "point the largest one counts"
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
    names = axis_names(sweep)
    rows: list[list[str]] = []
    lines: list[str] = []
    samples = 0
    for path in numeric(sweep):
        title, _, counted = read_worst(sweep, path)
        indices = indices_of(sweep, counted)
        if isinstance(indices, str):
            lines += paragraph(f"{title}: {indices}")
            continue
        samples = indices.samples
        parts = [part for one in indices[:2] for part in (one.value, one.standard_error)]
        for place, name in enumerate(names):
            cells = [f"{float(part[place]):.3f}" for part in parts]
            rows.append(["" if place else title, name, *cells])
    if not rows:
        return lines
    heads = "quantity", "key", number("first"), number("+-"), number("total"), number("+-")
    words = (
        "share of the variance that a key brings about, first: alone, total: with all its "
        f"interactions; from {samples} sampled points with {len(names) + 2} runs each, +-: "
        "standard error from resampling them"
    )
    return [*table(heads, rows), *paragraph(words), *lines]


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
