"""A result of many entries at each point of a sweep, reduced to its worst entry, which is named."""

from collections.abc import Mapping
from typing import Any, Literal, NamedTuple

import numpy as np

from vibecalc.report.sweep.view import SweepView
from vibecalc.results.record import Estimate, Quantity
from vibecalc.results.select import select

Side = Literal["max", "min"]


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
        return Estimate(float(self.errors[point]), largest)

    def label(self, point: int) -> str:
        """Name of the entry that counts at a point, empty for a single number."""
        return self.labels[int(self.entry[point])]


def numeric(sweep: SweepView) -> list[str]:
    """Paths of kept results that are numbers, those that the case asks to keep in its order."""
    asked: Any = (sweep.case.get("sweep") or {}).get("keep") or ()
    paths = [str(path) for path in asked if str(path) in sweep.kept]
    paths += [path for path in sweep.kept if path not in paths]
    spreads = {f"{path}_standard_error" for path in paths}
    return [path for path in paths if path not in spreads and _is_number(sweep.kept[path])]


def worst(
    sweep: SweepView, path: str, where: Mapping[str, Any] | None = None, side: Side = "max"
) -> Worst:
    """The largest ("max") or smallest entry at each point that `where` leaves of a result.

    Complex entries count by magnitude. Of entries that are the same within their errors the
    first one counts, so that round-off does not choose the name. Raises ResultError where an axis
    or entry does not exist.
    """
    quantity = sweep.kept[path]
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
    places, labels = _places(sweep.kept[path], {})
    values = _chosen(sweep.read(path).values, places)
    return np.where(sweep.done[:, None], values, np.nan), labels


def _places(quantity: Quantity, where: Mapping[str, Any]) -> tuple[np.ndarray, tuple[str, ...]]:
    shape = _shape(quantity)
    count = int(np.prod(shape))
    numbered = Quantity(
        path=quantity.path,
        values=np.arange(count).reshape(shape),
        unit=quantity.unit,
        long_name=quantity.long_name,
        axes=quantity.axes,
    )
    chosen = select(numbered, where)
    return np.ravel(chosen.values), chosen.labels


def _chosen(values: np.ndarray, places: np.ndarray) -> np.ndarray:
    flat = values.reshape(len(values), -1)[:, places]
    return np.abs(flat) if np.iscomplexobj(flat) else flat.astype(float)


def _reduced(values: np.ndarray, errors: np.ndarray, side: Side) -> tuple[np.ndarray, np.ndarray]:
    if values.shape[1] == 1:
        return values[:, 0], np.zeros(len(values), dtype=np.int64)
    signed = values if side == "max" else -values
    known = np.where(np.isnan(signed), -np.inf, signed)
    largest = known.max(axis=1)
    slack = np.where(np.isfinite(errors), 2.0 * errors, 0.0)
    with np.errstate(invalid="ignore"):
        level = np.where(np.isfinite(largest), largest - slack, largest)
    entry = np.argmax(known >= level[:, None], axis=1)
    return (largest if side == "max" else -largest), entry


def _spread(
    sweep: SweepView, path: str, own: np.ndarray | None, places: np.ndarray, entry: np.ndarray
) -> np.ndarray | None:
    """Standard error of the entry that counts: its own result if kept, else one for all."""
    twin = f"{path}_standard_error"
    if twin in sweep.kept and _shape(sweep.kept[twin]) == _shape(sweep.kept[path]):
        values = _chosen(sweep.read(twin).values, places)
        return np.asarray(np.where(sweep.done, values[np.arange(len(values)), entry], np.nan))
    return None if own is None else np.where(sweep.done, own, np.nan)


def _is_number(quantity: Quantity) -> bool:
    return quantity.values.dtype.kind in "biufc" and all(len(a.values) for a in quantity.axes)


def _shape(quantity: Quantity) -> tuple[int, ...]:
    return tuple(len(axis.values) for axis in quantity.axes)
