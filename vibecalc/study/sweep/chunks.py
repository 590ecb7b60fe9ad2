"""The folder of a sweep in progress: one file for each chunk of consecutive points.

A chunk file is a plain npz whose comment, its last bytes, is the SHA-256 of all bytes before. It
is written aside, read back and renamed, so that a file under its final name is whole; and one
that no longer is, or that belongs to another sweep, is found out and done again.
"""

import hashlib
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vibecalc.errors import ResultError, UsageError
from vibecalc.results.aside import written_aside
from vibecalc.results.files import is_temporary
from vibecalc.study.sweep.block import Block
from vibecalc.study.sweep.chunk_image import chunk_block, chunk_image

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
