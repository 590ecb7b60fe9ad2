"""Numbers of a case and results at many points: arrays over the points."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibecalc.core.results.catalogue import AXES, CATALOGUE
from vibecalc.core.results.record import Axis
from vibecalc.errors import KeyPath, NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import FloatArray

if TYPE_CHECKING:
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Numbers of a case that may differ from point to point, as arrays over the points.
# ----------------------------------------------------------------------------


class Columns:
    """A case with some of its numbers set to arrays.

    `varied` maps key paths to values (points,). What varies is read as (points,), all else as (1,),
    so that what does not vary is computed once and broadcast.
    """

    def __init__(self, case: "Case", varied: Mapping[KeyPath, np.ndarray], count: int):
        self.case, self.count = case, count
        self.varied = {path: np.asarray(values, dtype=float) for path, values in varied.items()}

    def rows(self, chosen: np.ndarray) -> "Columns":
        """The same case at some of the points only."""
        varied = {path: values[chosen] for path, values in self.varied.items()}
        return Columns(self.case, varied, len(chosen))

    def varies(self, *path: str | int) -> bool:
        """Whether anything at a place, or below it, varies."""
        return any(key[: len(path)] == path for key in self.varied)

    def written(self, *path: str | int) -> Any:
        """What the case has at a place; None where it, or a table above it, is absent."""
        part_of_case: Any = self.case
        for part in path:
            if part_of_case is None:
                return None
            part_of_case = (
                part_of_case[part] if isinstance(part, int) else getattr(part_of_case, part)
            )
        return part_of_case

    def optional(self, *path: str | int) -> FloatArray | None:
        """A number (points,) or (1,), or None where the case has none."""
        if path in self.varied:
            return self.varied[path]
        found = self.written(*path)
        return None if found is None else np.array([found], dtype=float)

    def number(self, *path: str | int) -> FloatArray:
        """A number (points,) or (1,); zero where the case has none."""
        found = self.optional(*path)
        return np.zeros(1) if found is None else found

    def vector(self, *path: str | int) -> FloatArray:
        """A list of numbers (points or 1, entries)."""
        return together([self.number(*path, place) for place in range(len(self.written(*path)))])


def together(parts: Sequence[FloatArray]) -> FloatArray:
    """Arrays (points or 1,) as columns of one array (points or 1, entries)."""
    if not parts:
        return np.zeros((1, 0))
    return np.stack(np.broadcast_arrays(*parts), axis=-1)


# ----------------------------------------------------------------------------
# Results at many points, collected under their paths.
# ----------------------------------------------------------------------------


class Column(NamedTuple):
    """One quantity: values (points, own axes...), the largest error (points,), and its axes."""

    values: np.ndarray
    errors: FloatArray
    axes: tuple[Axis, ...]


class Sheet:
    """What is wanted of some points, and what has been computed of it."""

    def __init__(self, count: int, wanted: frozenset[str]):
        self._count, self._wanted = count, wanted
        self.columns: dict[str, Column] = {}

    def wants(self, *paths: str) -> bool:
        """Whether any of these results is asked for."""
        return not self._wanted.isdisjoint(paths)

    def emit(self, path: str, result: Bounded, axes: Mapping[str, Any] | None = None) -> None:
        """Take values and errors (points or 1, own axes...); NumericalFailure for a NaN."""
        if path not in self._wanted:
            return
        values, error = np.asarray(result.value), np.asarray(result.error, dtype=float)
        if np.isnan(values).any():
            raise NumericalFailure(f"{path} has no defined value at some points")
        largest = error.reshape(len(error), -1).max(axis=1, initial=0.0)
        given = axes or {}
        self.columns[path] = Column(
            np.broadcast_to(values, (self._count, *values.shape[1:])).copy(),
            np.broadcast_to(largest, self._count).copy(),
            tuple(_axis(name, given[name]) for name in CATALOGUE[path].axes),
        )


def counted_only(result: Bounded, counts: np.ndarray, axis: int = -1) -> Bounded:
    """Zero where an order does not count; `counts` (points or 1, orders) lies along `axis`."""
    value, error = result
    shape = [1] * value.ndim
    shape[0], shape[axis] = counts.shape
    mask = counts.reshape(shape)
    return Bounded(np.where(mask, value, 0.0), np.where(mask, error, 0.0))


def _axis(name: str, values: Any) -> Axis:
    unit, long_name = AXES[name]
    array = np.asarray(values)
    if array.dtype.kind in "US":
        array = array.astype(object)
    return Axis(name=name, values=array, unit=unit, long_name=long_name)
