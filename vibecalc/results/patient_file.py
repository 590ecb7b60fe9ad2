"""A file on disk as HDF5 may write it: a full disk is told to us, and HDF5 does not see it.

HDF5 flushes what it holds when it closes a file; if that fails it loses track and crashes the
process (HDF5 1.14 and 2.0). So a write that fails is kept in memory, where it can be read back,
and the caller asks in between, and after closing, whether one did.
"""

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any


class PatientFile(io.RawIOBase):
    """A new file, for reading and writing; once a write has failed, nothing more goes to disk."""

    def __init__(self, path: Path) -> None:
        self._number = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
        self._position = self._size = 0
        self._kept: list[tuple[int, bytes]] = []
        self._failure: OSError | None = None

    def check(self) -> None:
        """Raise the error of the first write that failed, if one did."""
        if self._failure is not None:
            raise self._failure

    def close(self) -> None:
        """Close the file; it may be closed twice."""
        if not self.closed:
            os.close(self._number)
        super().close()

    def readable(self) -> bool:
        """Yes."""
        return True

    def writable(self) -> bool:
        """Yes."""
        return True

    def seekable(self) -> bool:
        """Yes."""
        return True

    def tell(self) -> int:
        """Where the next byte is read or written."""
        return self._position

    def seek(self, offset: int, whence: int = os.SEEK_SET, /) -> int:
        """Go to a place in the file, and return it."""
        origin = {os.SEEK_SET: 0, os.SEEK_CUR: self._position, os.SEEK_END: self._size}
        self._position = origin[whence] + offset
        return self._position

    def readinto(self, buffer: Any, /) -> int:
        """Read what was written, on disk or not; returns how many bytes there were."""
        view = memoryview(buffer).cast("B")
        start = self._position
        wanted = max(0, min(len(view), self._size - start))
        found = b""
        while len(found) < wanted:
            piece = os.pread(self._number, wanted - len(found), start + len(found))
            if not piece:  # written, but not to the disk
                break
            found += piece
        view[:wanted] = found.ljust(wanted, b"\0")
        for place, content in self._kept:
            first, last = max(start, place), min(start + wanted, place + len(content))
            if first < last:
                view[first - start : last - start] = content[first - place : last - place]
        self._position += wanted
        return wanted

    def write(self, buffer: Any, /) -> int:
        """Write everything, and return how much that was; never raises OSError."""
        view = memoryview(buffer).cast("B")
        done = 0
        try:
            while self._failure is None and done < len(view):
                done += os.pwrite(self._number, view[done:], self._position + done)
        except OSError as error:
            self._failure = error
        if done < len(view):
            self._kept.append((self._position + done, bytes(view[done:])))
        self._position += len(view)
        self._size = max(self._size, self._position)
        return len(view)

    def truncate(self, size: int | None = None, /) -> int:
        """Set the size of the file, and return it; never raises OSError."""
        self._size = self._position if size is None else size
        try:
            if self._failure is None:
                os.ftruncate(self._number, self._size)
        except OSError as error:
            self._failure = error
        return self._size


@contextmanager
def new_hdf5(path: Path, cache: int) -> Iterator[tuple[Any, PatientFile]]:
    """A new HDF5 file, in the format of results; OSError on leaving if it is not all on disk.

    `cache` is in bytes for each open dataset.
    """
    import h5py

    with PatientFile(path) as stream:
        with h5py.File(stream, "w", libver=("v108", "v108"), rdcc_nbytes=cache) as file:
            yield file, stream
        stream.check()
