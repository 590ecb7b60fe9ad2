"""The journal of a sweep in progress: one file, to which each finished chunk is appended.

The first line names the sweep. A record is the number of a chunk, the length of what follows, a
SHA-256 of both and of the content, and the content: what became of its points, as a line of JSON
and the numbers behind it. A chunk that is half written, or no longer as it was, is found out; the
journal then ends before it.
"""

import hashlib
import json
import math
import os
import struct
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

import numpy as np

from vibecalc.core.results.files import in_words
from vibecalc.core.results.layout import STATUS
from vibecalc.core.results.record import Axis, Quantity
from vibecalc.core.study.sweep.blocks import Block
from vibecalc.errors import ResultError

_FORMAT = "vibecalc sweep 4"
#: what a chunk says of a quantity and of an axis
_DESCRIBED = ("path", "unit", "long_name", "amplitude")
_AXIS = ("name", "unit", "long_name", "values")
_RECORD = struct.Struct("<qq32s")


def packed(block: Block) -> bytes:
    """A block of consecutive points as bytes; equal for equal blocks."""
    texts = {words: n for n, words in enumerate(dict.fromkeys(block.message))}
    columns = {STATUS: block.status, **block.columns}
    about = {
        "first": int(block.indices[0]),
        "texts": list(texts),
        "message": [texts[words] for words in block.message],
        "left_out": dict(block.left_out),
        "columns": [(name, one.dtype.str, one.shape) for name, one in columns.items()],
        "described": [
            {name: getattr(one, name) for name in _DESCRIBED}
            | {"axes": [[getattr(axis, name) for name in _AXIS] for axis in one.axes]}
            for one in block.described.values()
        ],
    }
    # lone surrogates in a message are no reason to lose a chunk
    line = json.dumps(about, default=np.ndarray.tolist).encode("ascii")
    return b"\n".join([line, b"".join(one.tobytes() for one in columns.values())])


def unpacked(content: bytes) -> Block:
    """The block of such bytes."""
    line, _, numbers = content.partition(b"\n")
    about, place, columns = json.loads(line), 0, dict[str, np.ndarray]()
    for name, kind, shape in about["columns"]:
        one = np.frombuffer(numbers, kind, math.prod(shape), place).reshape(shape)
        columns[name], place = one, place + one.nbytes
    status, described = columns.pop(STATUS), dict[str, Quantity]()
    for said in about["described"]:
        axes = [dict(zip(_AXIS, axis, strict=True)) for axis in said["axes"]]
        said["axes"] = tuple(Axis(**one | {"values": np.array(one["values"])}) for one in axes)
        described[said["path"]] = Quantity(**said, values=columns[said["path"]][:0])
    return Block(
        about["first"] + np.arange(len(status)),
        status,
        tuple(about["texts"][n] for n in about["message"]),
        columns,
        described,
        about["left_out"],
    )


def records(path: Path) -> Iterator[tuple[int, int, int]]:
    """Number of the chunk of each record of a journal, its place, and the length of its content.

    They end before the first that is not whole, or not as it was written.
    """
    with open(path, "rb") as stream:
        place = len(stream.readline())
        while found := _record(stream, place):
            yield found[0], place, len(found[1])
            place += _RECORD.size + len(found[1])


def _record(stream: BinaryIO, place: int) -> tuple[int, bytes] | None:
    """Number and content of the record at a place; None if it is damaged, or there is none."""
    stream.seek(place)
    head = stream.read(_RECORD.size)
    number, length, checksum = _RECORD.unpack(head) if len(head) == _RECORD.size else (0, 0, b"")
    content = stream.read(min(max(length, 0), os.fstat(stream.fileno()).st_size))
    return (number, content) if checksum == _checksum(number, content) else None


def _checksum(number: int, content: bytes) -> bytes:
    return hashlib.sha256(b"%d %d " % (number, len(content)) + content).digest()


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
    places: dict[int, int] = field(default_factory=dict)
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

    def foreign(self) -> bool:
        """Whether the file is the journal of another sweep."""
        if not self.path.exists():
            return False
        with in_words("cannot read", self.path), open(self.path, "rb") as stream:
            return not self.title.startswith(stream.readline())

    def look(self) -> str:
        """Find the chunks that are there, whole and of this sweep; say what else is there."""
        self.places, self.end = {}, len(self.title)
        if not self.path.exists() or self.foreign():
            return ""
        for number, place, length in records(self.path):
            self.places[number], self.end = place, place + _RECORD.size + length
        if self.path.stat().st_size <= self.end:
            return ""
        return f"a chunk in {self.path} is damaged or not whole; it is computed again"

    def start(self) -> None:
        """Make the file, or cut off what is no whole chunk; UsageError if that cannot be done."""
        with in_words("cannot write", self.path), open(self.path, "ab", buffering=0) as stream:
            stream.truncate(self.end if self.places else 0)
            if not self.places:
                self.end = stream.write(self.title)

    def write(self, number: int, block: Block) -> None:
        """Append one chunk, and wait until it is on the disk.

        UsageError for a full disk and a folder that was removed; the journal is then as it was.
        """
        content = packed(block)
        record = _RECORD.pack(number, len(content), _checksum(number, content)) + content
        with in_words("cannot write", self.path), open(self.path, "r+b", buffering=0) as stream:
            stream.seek(self.end)
            rest = memoryview(record)
            try:
                while rest:
                    rest = rest[stream.write(rest) :]
                os.fsync(stream.fileno())
            except BaseException:
                with suppress(OSError):
                    stream.truncate(self.end)
                raise
        self.places[number], self.end = self.end, self.end + len(record)

    def read(self, number: int) -> Block:
        """One chunk; ResultError if it is damaged, UsageError if it cannot be read."""
        with in_words("cannot read", self.path), open(self.path, "rb") as stream:
            found = _record(stream, self.places[number])
        if found is None:
            raise ResultError(
                f"chunk {number} in {self.path} is damaged: its checksum does not fit"
            )
        return unpacked(found[1])

    def clear(self) -> None:
        """Remove the file; UsageError with the reason if that cannot be done."""
        with in_words("cannot remove", self.path):
            self.path.unlink(missing_ok=True)
        self.places, self.end = {}, 0
