"""The file of a sweep, opened to read from it what is asked for and no more."""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Self

import numpy as np

from vibecalc.core.results.layout import (
    ERRORS,
    MESSAGE,
    PROVENANCE,
    STANDARD_ERRORS,
    STATUS,
    SWEEP,
    SWEEP_SCHEMA_VERSION,
    TEXT_CHECKSUM,
    VALUES,
    VERSION_ATTRIBUTE,
    text_checksum,
)
from vibecalc.core.results.record import Axis, Quantity, Result
from vibecalc.core.results.steps import step
from vibecalc.core.results.store_read import (
    _checked_size,
    _damaged,
    _integer,
    _json_list,
    _quantity,
    _text,
    bare_result,
    raw_text,
    read_file,
    shown,
)
from vibecalc.errors import ResultError
from vibecalc.units import convert

# ----------------------------------------------------------------------------
# What the file of a sweep says besides its numbers.
# ----------------------------------------------------------------------------


#: two ratios of an axis that differ by no more are equal
_LOG_RTOL = 1e-6


@dataclass(frozen=True, kw_only=True)
class SweptKey:
    """A key of the case that varies; `choices` are the names its values count from 0."""

    key: str
    label: str
    unit: str
    written_unit: str
    choices: tuple[str, ...] = ()

    @property
    def factor(self) -> float:
        """Takes a value in SI to the unit in which the case writes it."""
        return 1.0 if self.choices else convert(1.0, self.unit, self.written_unit)

    def number(self, value: float) -> str:
        """One value in that unit, or the name of a choice."""
        if self.choices:
            return self.choices[round(float(value))]
        return f"{float(value) * self.factor:.6g}"

    def shown(self, value: float) -> str:
        """The same with the unit: `12.5 N/mm`."""
        return f"{self.number(value)} {'' if self.choices else self.written_unit}".rstrip()


@dataclass(frozen=True, kw_only=True)
class SweptAxis:
    """One axis of a sweep, with its keys.

    A sampling has one axis, `sample`, with all keys. `columns` are the values (count,) of each key:
    doubles, whole numbers, or positions in the choices of the key.
    """

    name: str
    keys: tuple[SweptKey, ...]
    columns: tuple[np.ndarray, ...]

    @property
    def count(self) -> int:
        """Number of points along the axis."""
        return len(self.columns[0])

    @property
    def table(self) -> np.ndarray:
        """Values (count, keys) in SI, or the number of a choice."""
        return np.stack(self.columns, axis=1).astype(float)

    @property
    def logarithmic(self) -> bool:
        """Whether its first key goes up, or down, in equal ratios."""
        first = self.columns[0]
        if self.keys[0].choices or first.size < 3 or np.min(first) <= 0.0:
            return False
        steps = np.diff(np.log(first))
        return bool(np.ptp(steps) <= _LOG_RTOL * abs(steps[0]) and steps[0] != 0.0)

    def values(self) -> list[np.ndarray]:
        """All values of each key, choices by their names."""
        return [
            np.array(key.choices)[column] if key.choices else column
            for key, column in zip(self.keys, self.columns, strict=True)
        ]


@dataclass(frozen=True, kw_only=True)
class SweepHead:
    """Case, design and provenance of a sweep.

    `result` has the case, plan, warnings and methods, and no quantities; `identity` is the hash of
    the sweep; `design` says in plain values how the points were chosen; `stored` are the paths
    asked for.
    """

    result: Result
    axes: tuple[SweptAxis, ...]
    sampling: str
    design: Mapping[str, Any]
    stored: tuple[str, ...]
    identity: str

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of points along each axis."""
        return tuple(axis.count for axis in self.axes)


# ----------------------------------------------------------------------------
# Consecutive points of a grid, in C order, as boxes of the array that holds the grid.
# ----------------------------------------------------------------------------

_CHUNK_ENTRIES = 1 << 14


def columns_of(path: str) -> tuple[str, str, str]:
    """Names of the columns of a quantity: values, errors and standard errors."""
    return path, f"{ERRORS}/{path}", f"{STANDARD_ERRORS}/{path}"


Box = tuple[tuple[slice, ...], int, int]


def boxes(first: int, last: int, shape: Sequence[int]) -> Iterator[Box]:
    """Cut the points first to last - 1 into boxes, ascending.

    Gives for each its place in the grid, its first point and the one after its last. There are at
    most two for each axis but the first, and one more.
    """
    steps = [math.prod(shape[axis + 1 :]) for axis in range(len(shape))]
    while first < last:
        place = [int(at) for at in np.unravel_index(first, shape)]
        axis = next(k for k, one in enumerate(steps) if not first % one and first + one <= last)
        many = min(shape[axis] - place[axis], (last - first) // steps[axis])
        above = (slice(at, at + 1) for at in place[:axis])
        below = (slice(0, size) for size in shape[axis + 1 :])
        after = first + many * steps[axis]
        yield (*above, slice(place[axis], place[axis] + many), *below), first, after
        first = after


def read_points(dataset: Any, first: int, last: int, shape: Sequence[int]) -> np.ndarray:
    """Rows (last - first, own axes...) of a dataset (grid..., own axes...)."""
    lengths = dataset.shape[len(shape) :]
    rows = np.empty((last - first, *lengths), dtype=dataset.dtype)
    for place, start, stop in boxes(first, last, shape):
        rows[start - first : stop - first] = dataset[place].reshape(stop - start, *lengths)
    return rows


def write_points(dataset: Any, values: np.ndarray, first: int, shape: Sequence[int]) -> None:
    """Put rows (n, own axes...) at the points from `first` on."""
    for place, start, stop in boxes(first, first + len(values), shape):
        sizes = [part.stop - part.start for part in place]
        rows = values[start - first : stop - first]
        dataset[place] = rows.reshape(*sizes, *values.shape[1:])


def chunk_shape(shape: Sequence[int]) -> tuple[int, ...]:
    """Chunks of consecutive entries in C order, so that consecutive points touch few of them."""
    sizes: list[int] = []
    room = _CHUNK_ENTRIES
    for size in reversed(shape):
        sizes.append(min(size, max(room, 1)))
        room //= size
    return tuple(reversed(sizes))


# ----------------------------------------------------------------------------
# What the file of a sweep says of itself: whose it is, for which case and which points.
# ----------------------------------------------------------------------------


def check_origin(file: Any, path: Path) -> None:
    if VERSION_ATTRIBUTE not in file.attrs:
        what = "the result of a single run" if "schema_version" in file.attrs else "an HDF5 file"
        raise ResultError(f"{path} is {what}, not of a sweep")
    version = _integer(file, path, VERSION_ATTRIBUTE)
    if version > SWEEP_SCHEMA_VERSION:
        raise ResultError(
            f"{path} has layout {version} of a sweep, "
            f"this vibecalc reads up to {SWEEP_SCHEMA_VERSION}"
        )
    # HDF5 has been seen to crash on damaged texts, so they are examined before it sees them
    if _integer(file[PROVENANCE], path, TEXT_CHECKSUM) != text_checksum(path):
        raise ResultError(f"{path} was changed since it was written, or is damaged")


def read_head(file: Any, path: Path) -> SweepHead:
    place = file[SWEEP]
    return SweepHead(
        result=bare_result(file, path),
        axes=tuple(_swept(file, axis) for axis in _json_list(place, path, "axes")),
        sampling=_text(place, path, "sampling"),
        design=_json_table(place, path, "design"),
        stored=tuple(str(name) for name in _json_list(place, path, "kept")),
        identity=_text(place, path, "identity"),
    )


def _swept(file: Any, axis: dict[str, Any]) -> SweptAxis:
    keys = tuple(SweptKey(**{**key, "choices": tuple(key["choices"])}) for key in axis["keys"])
    columns = tuple(np.asarray(file[VALUES][key.key][()]) for key in keys)
    return SweptAxis(name=axis["name"], keys=keys, columns=columns)


def _json_table(place: Any, path: Path, name: str) -> dict[str, Any]:
    content = shown(json.loads(raw_text(place, path, name)))
    if not isinstance(content, dict):
        raise ResultError(f"{path} is damaged: {name} is no table")
    return content


# ----------------------------------------------------------------------------
# The file of a sweep, opened to read from it what is asked for and no more.
# ----------------------------------------------------------------------------


class Swept:
    """What an open file of a sweep and the view of one have alike."""

    head: SweepHead

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of points along each axis."""
        return self.head.shape

    @property
    def count(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    @property
    def case(self) -> Mapping[str, Any]:
        """The case of the sweep in SI, with its limits and references."""
        return self.head.result.case


class SweepResult(Swept):
    """An open file of a sweep; close it, or use it in a `with`.

    `head` has case, axes and design; `quantities` what was stacked, without values and with its own
    axes only, the error estimates and standard errors the largest of all points; `left_out` what
    could not be, with the reason. What is read is of all points (axes of the sweep..., own
    axes...), or of those from `first` to `last` - 1 (last - first, own axes...).
    """

    def __init__(self, file: Any, path: Path) -> None:
        self._file, self.path = file, path
        self.head = read_head(file, path)
        self.left_out: Mapping[str, str] = _json_table(file[SWEEP], path, "left_out")
        names = [str(name) for name in _json_list(file, path, "quantities")]
        over, size, known = len(self.shape), path.stat().st_size, dict[Any, Axis]()
        found = {name: _quantity(file, path, size, name, known, over) for name in names}
        self.quantities: Mapping[str, Quantity] = MappingProxyType(found)
        for name in (STATUS, *names, *(f"{ERRORS}/{name}" for name in names)):
            if file[name].shape[:over] != self.shape:
                raise ResultError(f"{path} is damaged: {name} does not fit the axes of the sweep")

    def read(self, name: str, first: int = 0, last: int | None = None) -> np.ndarray:
        """A dataset over the points, of all or of some; NaN at points without it.

        ResultError where its checksum is wrong.
        """
        try:
            dataset = self._file[name]
            if last is None:
                return np.asarray(dataset[()])
            return read_points(dataset, first, last, self.shape)
        except (OSError, KeyError) as error:
            raise _damaged(self.path, error) from error

    def stored(self, path: str) -> tuple[str, ...]:
        """Names of what is there of a quantity: values, errors, and of a statistic its standard
        errors at each point."""
        return columns_of(path)[: 2 + (self.quantities[path].standard_error is not None)]

    def status(self, first: int = 0, last: int | None = None) -> np.ndarray:
        """What became of each point (axes of the sweep...), or of some (last - first,)."""
        return self.read(STATUS, first, last)

    def counts(self) -> dict[int, int]:
        """How many points have which status."""
        statuses, many = np.unique(self.status(), return_counts=True)
        return dict(zip(statuses.tolist(), many.tolist(), strict=True))

    def reasons(self) -> dict[int, str]:
        """Why points that were run have no result, by their numbers, ascending."""
        points, causes = (self.read(f"{MESSAGE}/{name}").tolist() for name in ("point", "cause"))
        texts = [str(text) for text in self._file[MESSAGE]["text"].asstr()[()]]
        return {point: texts[cause] for point, cause in zip(points, causes, strict=True)}

    def close(self) -> None:
        """Close the file; nothing can be read any more."""
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
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
        step(f"opened {where}")
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


@contextmanager
def opened(source: Path | Result) -> Iterator[SweepResult | Result]:
    """A file, or what was read of one: of a sweep open, to look for more in it.

    Raises ResultError also where the file of a sweep has changed since it was read.
    """
    if isinstance(source, Path) and not is_sweep(source):
        source = read_file(source)
    if isinstance(source, Result) and source.swept is None:
        yield source
        return
    path = source.swept if isinstance(source, Result) else source
    with open_sweep(path or "") as sweep:
        now = sweep.head.result
        if isinstance(source, Result) and (now.case_sha256, now.provenance) != (
            source.case_sha256,
            source.provenance,
        ):
            raise ResultError(f"{path} has changed since it was read: read it again")
        yield sweep


def check_sweep(path: Path) -> None:
    """Open a file and close it again; ResultError if it is not the whole file of a sweep."""
    open_sweep(path).close()
