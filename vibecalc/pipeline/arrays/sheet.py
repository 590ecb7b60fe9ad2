"""Results at many points, collected under their paths."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import WithError
from vibecalc.numerics.typing import FloatArray
from vibecalc.pipeline.catalogue import AXES, CATALOGUE
from vibecalc.results.record import Axis


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

    def emit(self, path: str, found: WithError, axes: Mapping[str, Any] | None = None) -> None:
        """Take values and errors (points or 1, own axes...); NumericalFailure for a NaN."""
        if path not in self._wanted:
            return
        values, error = np.asarray(found.value), np.asarray(found.error, dtype=float)
        if np.isnan(values).any():
            raise NumericalFailure(f"{path} has no defined value at some points")
        largest = error.reshape(len(error), -1).max(axis=1, initial=0.0)
        given = axes or {}
        self.columns[path] = Column(
            np.broadcast_to(values, (self._count, *values.shape[1:])).copy(),
            np.broadcast_to(largest, self._count).copy(),
            tuple(_axis(name, given[name]) for name in CATALOGUE[path].axes),
        )


def kept_only(found: WithError, counts: np.ndarray, axis: int = -1) -> WithError:
    """Zero where an order does not count; `counts` (points or 1, orders) lies along `axis`."""
    value, error = found
    shape = [1] * value.ndim
    shape[0], shape[axis] = counts.shape
    mask = counts.reshape(shape)
    return WithError(np.where(mask, value, 0.0), np.where(mask, error, 0.0))


def _axis(name: str, values: Any) -> Axis:
    unit, long_name = AXES[name]
    array = np.asarray(values)
    if array.dtype.kind in "US":
        array = array.astype(object)
    return Axis(name=name, values=array, unit=unit, long_name=long_name)
