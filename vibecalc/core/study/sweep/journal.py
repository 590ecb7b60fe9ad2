"""The journal of a sweep in progress: one file, to which each finished chunk is appended.

The first line names the sweep. A record is the number of a chunk, the length of what follows, a
SHA-256 of both and of the content, and the content: what became of its points, as a line of JSON
and the numbers behind it. A chunk that is half written, or no longer as it was, is found out; the
journal then ends before it.
"""

import hashlib
import json
import os
import struct
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from vibecalc.core.results.files import in_words
from vibecalc.core.results.layout import DONE
from vibecalc.core.results.record import Axis
from vibecalc.core.study.sweep.blocks import Block, BlockQuantity
from vibecalc.errors import ResultError, UsageError

_FORMAT = "vibecalc sweep 2"
_RECORD = struct.Struct("<qq32s")
_ARRAYS = ("values", "errors", "standard_errors")


def packed(block: Block) -> bytes:
    """A block of consecutive points as bytes; equal for equal blocks."""
    texts: dict[str, list[int]] = {}  # many points tell the same
    for row in np.flatnonzero(block.status != DONE).tolist():
        texts.setdefault(block.message[row], []).append(row)
    arrays, rows = [block.status], []
    for path, one in block.quantities.items():
        shapes = {}
        for name in _ARRAYS:
            array = getattr(one, name)
            if array is not None:
                shapes[name] = array.dtype.str, array.shape
                arrays.append(array)
        axes = [[a.name, a.unit, a.long_name, a.values.tolist()] for a in one.axes]
        rows.append([path, one.unit, one.long_name, one.amplitude, axes, shapes])
    about = {
        "points": [int(block.indices[0]), len(block.indices)],
        "texts": texts,
        "left_out": dict(block.left_out),
        "quantities": rows,
    }
    # lone surrogates in a message are no reason to lose a chunk
    line = json.dumps(about).encode("ascii")
    return b"\n".join([line, b"".join(array.tobytes() for array in arrays)])


def unpacked(content: bytes) -> Block:
    """The block of such bytes."""
    line, _, _ = content.partition(b"\n")
    about, place = json.loads(line), len(line) + 1
    first, count = about["points"]

    def array(kind: str, shape: list[int]) -> np.ndarray:
        nonlocal place
        values = np.frombuffer(content, kind, int(np.prod(shape)), place).reshape(shape)
        place += values.nbytes
        return values.copy()

    status, message = array("i1", [count]), [""] * count
    for words, rows in about["texts"].items():
        for row in rows:
            message[row] = words
    quantities = {}
    for path, unit, long_name, amplitude, axes, shapes in about["quantities"]:
        parts: dict[str, Any] = {name: array(*shapes[name]) for name in _ARRAYS if name in shapes}
        quantities[path] = BlockQuantity(
            **{"standard_errors": None, **parts},
            axes=tuple(
                Axis(name=name, unit=unit_of, long_name=words, values=np.array(values))
                for name, unit_of, words, values in axes
            ),
            unit=unit,
            long_name=long_name,
            amplitude=amplitude,
        )
    indices = np.arange(first, first + count)
    return Block(indices, status, tuple(message), quantities, about["left_out"])


def records(path: Path) -> Iterator[tuple[int, int, int]]:
    """Number of the chunk of each record of a journal, its place, and the length of its content.

    A record of which something is missing is not among them.
    """
    with open(path, "rb") as stream:
        size = os.fstat(stream.fileno()).st_size
        place = len(stream.readline())
        while place + _RECORD.size <= size:
            stream.seek(place)
            number, length, _ = _RECORD.unpack(stream.read(_RECORD.size))
            if number < 0 or not 0 < length <= size - place - _RECORD.size:
                return
            yield number, place, length
            place += _RECORD.size + length


@dataclass(kw_only=True)
class Journal:
    """The finished chunks of one sweep: `count` points, `size` in each chunk but the last.

    `identity` is the hash of the sweep, with everything that changes its numbers. `places` says
    which chunks are there, and where; `end` is behind the last one.
    """

    path: Path
    identity: str
    count: int
    size: int
    places: dict[int, tuple[int, int]] = field(default_factory=dict)
    end: int = 0

    @property
    def chunks(self) -> int:
        """Number of chunks of the whole sweep."""
        return -(-self.count // self.size)

    @property
    def title(self) -> bytes:
        """The first line."""
        return f"{_FORMAT} {self.identity} {self.count} {self.size}\n".encode()

    def points(self, number: int) -> np.ndarray:
        """Numbers of the points in one chunk."""
        return np.arange(number * self.size, min((number + 1) * self.size, self.count))

    def foreign(self) -> int:
        """How many chunks the file holds if it is the journal of another sweep, else 0."""
        if not self.path.exists():
            return 0
        with in_words("cannot read", self.path):
            with open(self.path, "rb") as stream:
                ours = self.title.startswith(stream.readline())
            return 0 if ours else max(1, sum(1 for _ in records(self.path)))

    def look(self) -> str:
        """Find the chunks that are there, whole and of this sweep; say what else is there."""
        self.places, self.end = {}, len(self.title)
        if not self.path.exists() or self.foreign():
            return ""
        for number, place, length in records(self.path):
            try:
                self._content(number, place, length)
            except ResultError as error:
                return f"{error}; it and what follows are computed again"
            self.places[number] = place, length
            self.end = place + _RECORD.size + length
        whole = self.path.stat().st_size <= self.end
        return "" if whole else f"a chunk in {self.path} is not whole; it is computed again"

    def start(self) -> None:
        """Make the file, or cut off what is no whole chunk; UsageError if that cannot be done."""
        with in_words("cannot write", self.path), open(self.path, "ab", buffering=0) as stream:
            stream.truncate(self.end if self.places else 0)
            if not self.places:
                self.end = stream.write(self.title)

    def write(self, number: int, block: Block) -> None:
        """Append one chunk, and read it back.

        UsageError for a full disk, a folder that was removed, and a disk that does not give back
        what was written; the journal is then as it was. ValueError for a block of other points.
        """
        if not np.array_equal(block.indices, self.points(number)):
            raise ValueError(f"chunk {number} has other points than this block")
        content = packed(block)
        record = _RECORD.pack(number, len(content), _checksum(number, content)) + content
        with in_words("cannot write", self.path), open(self.path, "r+b", buffering=0) as stream:
            try:
                _put(stream, self.end, record)
            except BaseException:
                with suppress(OSError):
                    stream.truncate(self.end)
                raise
        self.places[number] = self.end, len(content)
        self.end += len(record)

    def read(self, number: int) -> Block:
        """One chunk; ResultError if it is damaged, UsageError if it cannot be read."""
        return unpacked(self._content(number, *self.places[number]))

    def _content(self, number: int, place: int, length: int) -> bytes:
        with in_words("cannot read", self.path), open(self.path, "rb") as stream:
            stream.seek(place)
            *_, checksum = _RECORD.unpack(stream.read(_RECORD.size))
            content = stream.read(length)
        if _checksum(number, content) != checksum:
            raise ResultError(
                f"chunk {number} in {self.path} is damaged: its checksum does not fit"
            )
        return content

    def blocks(self, numbers: Iterable[int]) -> Iterator[Block]:
        """Read chunks one after the other, in ascending order."""
        for number in sorted(numbers):
            yield self.read(number)

    def clear(self) -> None:
        """Remove the file; UsageError with the reason if that cannot be done."""
        with in_words("cannot remove", self.path):
            self.path.unlink(missing_ok=True)
        self.places, self.end = {}, 0


def _put(stream: Any, place: int, record: bytes) -> None:
    """Write a record, wait until it is on the disk, and read it back."""
    stream.seek(place)
    rest = memoryview(record)
    while rest:
        rest = rest[stream.write(rest) :]
    os.fsync(stream.fileno())
    stream.seek(place)
    if stream.read(len(record)) != record:
        raise UsageError(f"cannot write {stream.name}: the disk does not give back what it got")


def _checksum(number: int, content: bytes) -> bytes:
    return hashlib.sha256(b"%d %d " % (number, len(content)) + content).digest()
