"""Blocks of points of a sweep in progress, and the folder that keeps one file for each."""

import hashlib
import io
import json
import re
import zipfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.results.files import is_temporary, written_aside
from vibecalc.core.results.record import Axis, Quantity
from vibecalc.errors import ResultError, UsageError

# ----------------------------------------------------------------------------
# What an evaluator hands back for some consecutive points of a sweep.
# ----------------------------------------------------------------------------

#: axis along which a shorter series is continued with zeros
PADDED = "order"


class BlockQuantity(NamedTuple):
    """One quantity at n points.

    values
        (n, own axes...), real or complex; NaN at points that do not have the quantity.
    errors
        (n,) absolute, in `unit`; NaN at points that do not have the quantity.
    standard_errors
        (n,) in `unit`, of a statistic; None of anything else.
    axes
        Own axes of the quantity, shared by all points.
    """

    values: np.ndarray
    errors: np.ndarray
    standard_errors: np.ndarray | None
    axes: tuple[Axis, ...]
    unit: str
    long_name: str
    amplitude: str | None = None


class Block(NamedTuple):
    """n points of a sweep, in ascending order.

    indices
        (n,) int64, numbers of the points.
    status
        (n,) int8, see `vibecalc.core.results.layout`.
    message
        n texts, empty for points that are done.
    quantities
        By path. A path may be absent if none of the points has it.
    left_out
        Paths that these points have and that cannot be stacked, each with its reason.
    """

    indices: np.ndarray
    status: np.ndarray
    message: tuple[str, ...]
    quantities: Mapping[str, BlockQuantity]
    left_out: Mapping[str, str] = {}


def make_block(
    indices: np.ndarray,
    status: Sequence[int] | np.ndarray,
    message: Sequence[str],
    results: Sequence[Mapping[str, Quantity]],
    keep: Sequence[str],
) -> Block:
    """Stack what was found at each point (nothing where it failed) under the paths of `keep`."""
    quantities: dict[str, BlockQuantity] = {}
    left_out: dict[str, str] = {}
    for path in keep:
        found = [(np.array([row]), one[path]) for row, one in enumerate(results) if path in one]
        if any(np.asarray(one.values).dtype.kind not in "fciub" for _, one in found):
            left_out[path] = "its values are texts"
        elif found:
            whole = laid_out([(row, at_one_point(one)) for row, one in found], indices)
            if isinstance(whole, str):
                left_out[path] = whole
            else:
                quantities[path] = whole
    return Block(
        indices=np.asarray(indices, dtype=np.int64),
        status=np.asarray(status, dtype=np.int8),
        message=tuple(message),
        quantities=quantities,
        left_out=left_out,
    )


def at_one_point(quantity: Quantity) -> BlockQuantity:
    """The result of one run as that of a block of one point."""
    spread = quantity.standard_error
    return BlockQuantity(
        values=np.asarray(quantity.values)[None],
        errors=np.array([quantity.error_estimate], dtype=float),
        standard_errors=None if spread is None else np.array([spread], dtype=float),
        axes=quantity.axes,
        unit=quantity.unit,
        long_name=quantity.long_name,
        amplitude=quantity.amplitude,
    )


def laid_out(
    pieces: Sequence[tuple[np.ndarray, BlockQuantity]], numbers: np.ndarray
) -> BlockQuantity | str:
    """One quantity at the points `numbers` (n,), NaN where no piece has it.

    A piece is the rows of its points among the n, and what it has there; a later one counts. A
    text says why they cannot be put together.
    """
    rows, first = pieces[0]
    if len(pieces) == 1 and len(rows) == len(numbers):
        return first
    axes = first.axes
    for others, one in pieces:
        joined = joined_axes(axes, one.axes)
        if isinstance(joined, str):
            return f"{joined} (points {numbers[rows[0]]} and {numbers[others[0]]})"
        axes = joined
    shape = tuple(len(axis.values) for axis in axes)
    dtype = np.result_type(float, *{one.values.dtype for _, one in pieces})
    values = np.full((len(numbers), *shape), np.nan, dtype=dtype)
    errors, spread = np.full(len(numbers), np.nan), np.full(len(numbers), np.nan)
    for others, one in pieces:
        values[others] = padded(one.values, (len(others), *shape))
        values[others[np.isnan(one.errors)]] = np.nan
        errors[others] = one.errors
        if one.standard_errors is not None:
            spread[others] = one.standard_errors
    has_spread = any(one.standard_errors is not None for _, one in pieces)
    return first._replace(
        values=values, errors=errors, standard_errors=spread if has_spread else None, axes=axes
    )


def joined_axes(axes: tuple[Axis, ...], others: tuple[Axis, ...]) -> tuple[Axis, ...] | str:
    """Axes that hold both, or in words why there are none.

    Axes have to be equal, except that one of two axes `order` may go on where the other ends.
    """
    if [axis.name for axis in axes] != [axis.name for axis in others]:
        return "its axes are not the same at all points"
    joined = []
    for axis, other in zip(axes, others, strict=True):
        shared = min(len(axis.values), len(other.values))
        may_go_on = axis.name == PADDED or len(axis.values) == len(other.values)
        if not (may_go_on and np.array_equal(axis.values[:shared], other.values[:shared])):
            return f"its axis {axis.name} is not the same at all points"
        joined.append(axis if len(axis.values) >= len(other.values) else other)
    return tuple(joined)


def padded(values: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """`values` continued with zeros to a shape that is at least as large along every axis."""
    if values.shape == shape:
        return values
    return np.pad(values, [(0, size - old) for size, old in zip(shape, values.shape, strict=True)])


# ----------------------------------------------------------------------------
# A block of points as the bytes of a file, and back.
# ----------------------------------------------------------------------------

_FORMAT = 1
_DIGITS = 64  # of a SHA-256


def chunk_image(block: Block, identity: str) -> bytes:
    """Bytes of an npz file that ends with the SHA-256 of the rest; equal for equal blocks."""
    arrays: dict[str, np.ndarray] = {
        "indices": block.indices,
        "status": block.status,
        # many points tell the same, and an array of texts takes the room of the longest for each
        "cause": np.zeros(len(block.message), dtype=np.int32),
    }
    causes: dict[str, int] = {}
    if len(set(block.message)) <= 1:  # as of points that are all done
        causes.update(dict.fromkeys(block.message, 0))
    else:
        numbers = (causes.setdefault(message, len(causes)) for message in block.message)
        arrays["cause"][:] = np.fromiter(numbers, dtype=np.int32, count=len(block.message))
    rows = []
    for number, (path, one) in enumerate(block.quantities.items()):
        arrays[f"values_{number}"] = one.values
        arrays[f"errors_{number}"] = one.errors
        if one.standard_errors is not None:
            arrays[f"standard_errors_{number}"] = one.standard_errors
        for place, axis in enumerate(one.axes):
            # never as Python objects, which numpy would pickle
            is_text = axis.values.dtype.kind in "UOT"
            arrays[f"axis_{number}_{place}"] = axis.values.astype(np.str_ if is_text else None)
        rows.append(
            {
                "path": path,
                "unit": one.unit,
                "long_name": one.long_name,
                "amplitude": one.amplitude,
                "axes": [[axis.name, axis.unit, axis.long_name] for axis in one.axes],
            }
        )
    about = {
        "format": _FORMAT,
        "identity": identity,
        "causes": list(causes),
        "quantities": rows,
        "left_out": dict(block.left_out),
    }
    # lone surrogates in a message are no reason to lose a chunk
    arrays["about"] = np.frombuffer(json.dumps(about).encode("ascii"), dtype=np.uint8)
    stream = io.BytesIO()
    np.savez(stream, **arrays)  # type: ignore[arg-type]
    with zipfile.ZipFile(stream, "a") as archive:
        archive.comment = b"0" * _DIGITS
    content = stream.getvalue()[:-_DIGITS]
    return content + hashlib.sha256(content).hexdigest().encode()


def chunk_block(content: bytes, path: Path, identity: str) -> Block:
    """The block in the bytes of a file; ResultError if they are not those once written."""
    body, checksum = content[:-_DIGITS], content[-_DIGITS:]
    if hashlib.sha256(body).hexdigest().encode() != checksum:
        raise ResultError(f"{path} is damaged: its checksum does not fit")
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
            return _block(arrays, path, identity)
    except ResultError:
        raise
    except Exception as error:  # the checksum fits, so somebody else made this file
        raise ResultError(f"{path} is not a chunk of a sweep: {error}") from error


def _block(arrays: Any, path: Path, identity: str) -> Block:
    about = json.loads(arrays["about"].tobytes())
    if about["format"] != _FORMAT:
        raise ResultError(f"{path} was written by another version of vibecalc")
    if about["identity"] != identity:
        raise ResultError(f"{path} belongs to another sweep")
    causes = about["causes"]
    return Block(
        indices=arrays["indices"],
        status=arrays["status"],
        message=tuple(map(causes.__getitem__, arrays["cause"].tolist())),
        quantities={
            row["path"]: _quantity(arrays, number, row)
            for number, row in enumerate(about["quantities"])
        },
        left_out=about["left_out"],
    )


def _quantity(arrays: Any, number: int, row: dict[str, Any]) -> BlockQuantity:
    return BlockQuantity(
        values=arrays[f"values_{number}"],
        errors=arrays[f"errors_{number}"],
        standard_errors=arrays.get(f"standard_errors_{number}"),
        axes=tuple(
            Axis(name=name, unit=unit, long_name=long_name, values=arrays[f"axis_{number}_{place}"])
            for place, (name, unit, long_name) in enumerate(row["axes"])
        ),
        unit=row["unit"],
        long_name=row["long_name"],
        amplitude=row["amplitude"],
    )


# ----------------------------------------------------------------------------
# The folder of a sweep in progress: one file for each chunk of consecutive points.
#
# A chunk file is a plain npz whose comment, its last bytes, is the SHA-256 of all bytes before. It
# is written aside, read back and renamed, so that a file under its final name is whole; and one
# that no longer is, or that belongs to another sweep, is found out and done again.
# ----------------------------------------------------------------------------

_NAME = re.compile(r"chunk_(\d{6,})_([0-9a-f]{12})\.npz")


def parts_folder(output: Path) -> Path:
    """Where the chunks of the sweep that becomes `output` are kept."""
    return output.with_name(f"{output.name}.parts")


@dataclass(frozen=True, kw_only=True)
class Survey:
    """What a folder of chunks holds: numbers of valid chunks, and files that are none.

    damaged
        Files of this sweep that are not whole, each with what is wrong with it.
    foreign
        Chunks of another sweep, or of this one cut in another way.
    unfinished
        Files that somebody was writing when he was stopped.
    """

    finished: frozenset[int]
    damaged: tuple[tuple[Path, str], ...] = ()
    foreign: tuple[Path, ...] = ()
    unfinished: tuple[Path, ...] = ()


@dataclass(frozen=True, kw_only=True)
class ChunkFolder:
    """The chunks of one sweep: `count` points, `size` in each chunk but the last.

    `identity` is the hash of the sweep, with everything that changes its numbers.
    """

    folder: Path
    identity: str
    count: int
    size: int

    @property
    def chunks(self) -> int:
        """Number of chunks of the whole sweep."""
        return -(-self.count // self.size)

    def points(self, number: int) -> np.ndarray:
        """Numbers of the points in one chunk."""
        return np.arange(number * self.size, min((number + 1) * self.size, self.count))

    def hash_of(self, number: int) -> str:
        """Hash (hexadecimal SHA-256) of the input of one chunk."""
        points = self.points(number)
        text = f"{self.identity} {number} {points[0]} {points[-1]}"
        return hashlib.sha256(text.encode()).hexdigest()

    def path(self, number: int) -> Path:
        """Where one chunk is, or will be."""
        return self.folder / f"chunk_{number:06d}_{self.hash_of(number)[:12]}.npz"

    def make(self) -> None:
        """Make the folder; UsageError with the reason if that cannot be done."""
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise UsageError(f"cannot make the folder {self.folder}: {reason}") from error

    def write(self, number: int, block: Block) -> Path:
        """Store one chunk, read it back, and only then give it its name.

        UsageError for a full disk, a folder that was removed, and a disk that does not give back
        what was written; ValueError for a block of other points (a mistake of ours).
        """
        if not np.array_equal(block.indices, self.points(number)):
            raise ValueError(f"chunk {number} has other points than this block")
        content = chunk_image(block, self.hash_of(number))
        target = self.path(number)

        def check(path: Path) -> None:
            if path.read_bytes() != content:
                raise UsageError(f"cannot write {target}: the disk does not give back what it got")

        with written_aside(target, check) as temporary:
            temporary.write_bytes(content)
        return target

    def read(self, number: int) -> Block:
        """One chunk; ResultError if it is missing, damaged or of another sweep."""
        path = self.path(number)
        try:
            content = path.read_bytes()
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise ResultError(f"cannot read {path}: {reason}") from error
        block = chunk_block(content, path, self.hash_of(number))
        if not np.array_equal(block.indices, self.points(number)):
            raise ResultError(f"{path} is damaged: it has other points")
        return block

    def survey(self) -> Survey:
        """Look at every file in the folder; a folder that is not there holds nothing."""
        finished, damaged, foreign, unfinished = set(), [], [], []
        for path in self._files():
            named = _NAME.fullmatch(path.name)
            if is_temporary(path):
                unfinished.append(path)
            if named is None:
                continue
            number = int(named[1])
            if number >= self.chunks or path != self.path(number):
                foreign.append(path)
                continue
            try:
                self.read(number)
                finished.add(number)
            except ResultError as error:
                damaged.append((path, str(error)))
        return Survey(
            finished=frozenset(finished),
            damaged=tuple(damaged),
            foreign=tuple(foreign),
            unfinished=tuple(unfinished),
        )

    def finished(self) -> frozenset[int]:
        """Numbers of the chunks that are there, whole and of this sweep."""
        return self.survey().finished

    def blocks(self, numbers: Iterable[int]) -> Iterator[Block]:
        """Read chunks one after the other, in ascending order."""
        for number in sorted(numbers):
            yield self.read(number)

    def clear(self) -> None:
        """Remove all chunks and unfinished files, and the folder if nothing else is in it.

        UsageError with the reason if a file cannot be removed.
        """
        try:
            for path in self._files():
                if is_temporary(path) or _NAME.fullmatch(path.name):
                    path.unlink(missing_ok=True)
            if self.folder.is_dir() and not any(self.folder.iterdir()):
                self.folder.rmdir()
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise UsageError(f"cannot empty {self.folder}: {reason}") from error

    def _files(self) -> list[Path]:
        try:
            return sorted(self.folder.iterdir())
        except FileNotFoundError:
            return []
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise UsageError(f"cannot look into {self.folder}: {reason}") from error
