"""The file of a sweep, opened to read from it what is asked for and no more."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType, TracebackType
from typing import Any, NamedTuple, Self

import numpy as np

from vibecalc.errors import ResultError
from vibecalc.results.record import Axis
from vibecalc.results.store_read import _axis, _checked_size, _damaged, _real, _text
from vibecalc.results.sweep_boxes import read_points
from vibecalc.results.sweep_head import check_origin, json_table, listed, read_head
from vibecalc.results.sweep_layout import (
    ERRORS,
    MESSAGE,
    STANDARD_ERRORS,
    STATUS,
    SWEEP,
    VERSION_ATTRIBUTE,
)


class Failures(NamedTuple):
    """Points without a result: their numbers (m,), ascending, and for each a row of `texts`."""

    points: np.ndarray
    causes: np.ndarray
    texts: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class StackedQuantity:
    """One quantity of a sweep; `axes` are its own, those of the sweep come before them.

    `error_estimate` and `standard_error` are the largest of all points, in `unit`.
    """

    path: str
    unit: str
    long_name: str
    amplitude: str | None
    axes: tuple[Axis, ...]
    error_estimate: float
    standard_error: float | None
    _data: "_Data"

    def values(self) -> np.ndarray:
        """Everything: (axes of the sweep..., own axes...); NaN at points without it."""
        return self._data.whole(self.path)

    def errors(self) -> np.ndarray:
        """Error estimate of each point (axes of the sweep...)."""
        return self._data.whole(f"{ERRORS}/{self.path}")

    def standard_errors(self) -> np.ndarray | None:
        """Standard error of each point (axes of the sweep...); None if it is no statistic."""
        statistic = self.standard_error is not None
        return self._data.whole(f"{STANDARD_ERRORS}/{self.path}") if statistic else None

    def points(self, first: int, last: int) -> np.ndarray:
        """Values (last - first, own axes...) at consecutive points."""
        return self._data.points(self.path, first, last)

    def errors_of(self, first: int, last: int) -> np.ndarray:
        """Error estimates (last - first,) of consecutive points."""
        return self._data.points(f"{ERRORS}/{self.path}", first, last)

    def standard_errors_of(self, first: int, last: int) -> np.ndarray | None:
        """Standard errors (last - first,) of consecutive points; None if it is no statistic."""
        if self.standard_error is None:
            return None
        return self._data.points(f"{STANDARD_ERRORS}/{self.path}", first, last)


@dataclass(frozen=True)
class _Data:
    """Datasets of an open file; ResultError where HDF5 finds their checksums wrong."""

    file: Any
    path: Path
    shape: tuple[int, ...]

    def whole(self, name: str) -> np.ndarray:
        try:
            return np.asarray(self.file[name][()])
        except (OSError, KeyError) as error:
            raise _damaged(self.path, error) from error

    def points(self, name: str, first: int, last: int) -> np.ndarray:
        try:
            return read_points(self.file[name], first, last, self.shape)
        except (OSError, KeyError) as error:
            raise _damaged(self.path, error) from error


class SweepResult:
    """An open file of a sweep; close it, or use it in a `with`.

    `head` has case, axes and design; `quantities` those that were stacked, `left_out` those that
    could not be, each with its reason.
    """

    def __init__(self, file: Any, path: Path) -> None:
        self._file, self.path = file, path
        self.head = read_head(file, path)
        self._data = _Data(file, path, self.head.shape)
        place = file[SWEEP]
        self.left_out: Mapping[str, str] = json_table(place, path, "left_out")
        found = {str(name): _quantity(self._data, str(name)) for name in listed(file, path)}
        self.quantities: Mapping[str, StackedQuantity] = MappingProxyType(found)
        if file[STATUS].shape != self.head.shape:
            raise ResultError(f"{path} is damaged: {STATUS} does not fit the axes")

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of points along each axis."""
        return self.head.shape

    @property
    def count(self) -> int:
        """Number of points."""
        return int(np.prod(self.shape, dtype=np.int64))

    @property
    def case(self) -> Mapping[str, Any]:
        """The case of the sweep in SI, with its limits and references."""
        return self.head.result.case

    def status(self) -> np.ndarray:
        """What became of each point (axes of the sweep...)."""
        return self._data.whole(STATUS)

    def status_of(self, first: int, last: int) -> np.ndarray:
        """What became of consecutive points (last - first,)."""
        return self._data.points(STATUS, first, last)

    def failures(self) -> Failures:
        """Points that were run and have no result, with the reasons."""
        return Failures(
            points=self._data.whole(f"{MESSAGE}/point"),
            causes=self._data.whole(f"{MESSAGE}/cause"),
            texts=tuple(str(text) for text in self._file[MESSAGE]["text"].asstr()[()]),
        )

    def close(self) -> None:
        """Close the file; nothing can be read any more."""
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def open_sweep(path: Path | str) -> SweepResult:
    """Open the file of a sweep.

    Raises ResultError, in words, for a file that is missing, foreign, of a later layout, the
    result of a single run, changed since it was written, or damaged.
    """
    import h5py

    where = Path(path)
    _checked_size(where)
    try:
        file = h5py.File(where, "r", locking=False)
    except Exception as error:
        raise _damaged(where, error) from error
    try:
        check_origin(file, where)
        return SweepResult(file, where)
    except ResultError:
        file.close()
        raise
    except Exception as error:
        file.close()
        raise _damaged(where, error) from error


def is_sweep(path: Path | str) -> bool:
    """Whether this is the file of a sweep, as far as its first lines tell."""
    import h5py

    try:
        with h5py.File(path, "r", locking=False) as file:
            return VERSION_ATTRIBUTE in file.attrs
    except Exception:  # whatever HDF5 makes of another file
        return False


def check_sweep(path: Path) -> None:
    """Open a file and close it again; ResultError if it is not the whole file of a sweep."""
    open_sweep(path).close()


def _quantity(data: _Data, name: str) -> StackedQuantity:
    file, path, shape = data.file, data.path, data.shape
    dataset, errors = file[name], file[f"{ERRORS}/{name}"]
    if dataset.shape[: len(shape)] != shape or errors.shape != shape:
        raise ResultError(f"{path} is damaged: {name} does not fit the axes of the sweep")
    statistic = "standard_error" in dataset.attrs
    size = path.stat().st_size
    return StackedQuantity(
        path=name,
        unit=_text(dataset, path, "units"),
        long_name=_text(dataset, path, "long_name"),
        amplitude=_text(dataset, path, "amplitude") if "amplitude" in dataset.attrs else None,
        axes=tuple(
            _axis(dataset, path, size, position, {}) for position in range(len(shape), dataset.ndim)
        ),
        error_estimate=_real(dataset, path, "error_estimate"),
        standard_error=_real(dataset, path, "standard_error") if statistic else None,
        _data=data,
    )
