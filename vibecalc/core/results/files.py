"""Output files: folders made on the way, and never half a file under the final name."""

import io
import os
import stat
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

from vibecalc.core.results.steps import step
from vibecalc.errors import UsageError

#: how names of result files end
SUFFIXES = (".h5", ".hdf5")


def fresh_output(path: Path | str) -> Path:
    """Make sure that a file can be put at `path`: missing parent folders are made.

    Returns the path that a link points to, so that writing through it keeps the link. Raises
    UsageError where a part of the path is a file, a folder cannot be made or written, or the
    path itself is a folder or a device.
    """
    given = str(path)
    if not given or "\0" in given:
        raise UsageError(f"{given!r} cannot be the name of an output file")
    target = Path(os.path.realpath(given))
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"cannot make the output folder {target.parent}: {_why(error)}") from error
    try:
        status = target.stat()
    except FileNotFoundError:
        status = None
    except OSError as error:
        raise UsageError(f"cannot write {given}: {_why(error)}") from error
    if status is not None and stat.S_ISDIR(status.st_mode):
        raise UsageError(f"{given} is a folder: name a file in it")
    if status is not None and not stat.S_ISREG(status.st_mode):
        raise UsageError(f"{given} is not a regular file, and results replace what they overwrite")
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise UsageError(f"the output folder {target.parent} cannot be written")
    return target


def write_atomically(path: Path | str, content: bytes) -> Path:
    """Put `content` at `path` in one step, and return where it is; see `write_together`."""
    return write_together([(path, content)])[0]


def write_together(files: Sequence[tuple[Path | str, bytes]]) -> list[Path]:
    """Put each content at its path in one step, all or none, and return where they are.

    See `written_aside`: all are on the disk before the first has its place. Raises UsageError with
    the reason.
    """
    targets = []
    with ExitStack() as stack:
        for path, content in files:
            targets.append(fresh_output(path))
            with suppress(OSError):  # a folder that cannot be listed can be written
                clear_leftovers(targets[-1].parent)
            stack.enter_context(written_aside(targets[-1])).write_bytes(content)
    return targets


def temporary_name() -> str:
    """A name nobody else takes; short, for file systems that end at 255 characters."""
    return f".vibecalc-{_host()}-{os.getpid()}-{os.urandom(4).hex()}.tmp"


def clear_leftovers(folder: Path) -> None:
    """Remove the temporary files of processes of this host that are no more."""
    begin = f".vibecalc-{_host()}-"
    for name in os.listdir(folder):
        if name.startswith(begin) and name.endswith(".tmp"):
            number = name.removeprefix(begin).partition("-")[0]
            if number.isdigit() and not _is_there(int(number)):
                with suppress(OSError):
                    (folder / name).unlink()


def _host() -> str:
    return f"{zlib.crc32(os.uname().nodename.encode()):08x}"


def _is_there(process: int) -> bool:
    try:
        os.kill(process, 0)
    except (OSError, OverflowError) as error:
        return isinstance(error, PermissionError)
    return True


@contextmanager
def written_aside(target: Path, check: Callable[[Path], None] | None = None) -> Iterator[Path]:
    """Give the name of a temporary file in the folder of `target`, and rename it in the end.

    On leaving, the file reaches the disk, `check` examines it (and raises if it is not what it
    should be), and it replaces `target` in one step, so a reader sees the old file or the new one.
    Whatever goes wrong before (full disk, Ctrl-C), the temporary file is removed and an old
    `target` stays as it was. OSErrors, of the caller too, become UsageError with the reason.
    """
    temporary = target.parent / temporary_name()
    try:
        yield temporary
        _to_disk(temporary)
        if check is not None:
            check(temporary)
        os.replace(temporary, target)
        with suppress(OSError):  # the file is in its place, and some systems cannot do this
            _to_disk(target.parent)
        step(f"wrote {target}")
    except OSError as error:
        untouched = ", the old one is untouched" if os.path.isfile(target) else ""
        raise UsageError(f"cannot write {target}: {_why(error, target)}{untouched}") from error
    finally:
        with suppress(OSError):  # the first error says what is wrong with this folder
            temporary.unlink(missing_ok=True)


@contextmanager
def in_words(what: str, path: Path) -> Iterator[None]:
    """OSErrors as UsageError: `what` cannot be done, the path, and why in the system's words."""
    try:
        yield
    except OSError as error:
        raise UsageError(f"{what} {path}: {_why(error, path)}") from error


def _to_disk(path: Path) -> None:
    """Wait until a file, or the names in a folder, are on the disk."""
    number = os.open(path, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)


def _why(error: OSError, target: Path | None = None) -> str:
    """Why, in the words of the system; HDF5 hides them in a long text of its own."""
    if target is not None and not target.parent.is_dir():
        return f"the folder {target.parent} is not there any more"
    if error.errno is not None:
        return os.strerror(error.errno).lower()
    text = str(error)
    _, matched, remainder = text.partition("error message = '")
    return remainder.partition("'")[0].lower() if matched else text


# ----------------------------------------------------------------------------
# A file on disk as HDF5 may write it: a full disk is reported to us, and HDF5 does not see it.
#
# HDF5 flushes what it holds when it closes a file; if that fails it loses track and crashes the
# process (HDF5 1.14 and 2.0). So a write that fails is kept in memory, where it can be read back,
# and the caller asks in between, and after closing, whether one did.
# ----------------------------------------------------------------------------


class PatientFile(io.FileIO):
    """A new file, for reading and writing; once a write has failed, nothing more goes to disk."""

    def __init__(self, path: Path) -> None:
        super().__init__(path, "x+")
        self._size = 0
        self._pending: list[tuple[int, bytes]] = []
        self._failure: OSError | None = None

    def check(self) -> None:
        """Raise the error of the first write that failed, if one did."""
        if self._failure is not None:
            raise self._failure

    def seek(self, offset: int, whence: int = os.SEEK_SET, /) -> int:
        """Go to a place in the file, and return it; the end is that of what was written."""
        if whence == os.SEEK_END:
            return super().seek(self._size + offset)
        return super().seek(offset, whence)

    def readinto(self, buffer: Any, /) -> int:
        """Read what was written, on disk or not; returns how many bytes there were."""
        start = self.tell()
        view = memoryview(buffer).cast("B")[: max(0, self._size - start)]
        done = 0
        while part := super().readinto(view[done:]):
            done += part
        view[done:] = bytes(len(view) - done)  # written, but not to the disk
        last = start + len(view)
        for place, content in self._pending:
            first, end = max(start, place), min(last, place + len(content))
            if first < end:
                view[first - start : end - start] = content[first - place : end - place]
        self.seek(last)
        return len(view)

    def write(self, buffer: Any, /) -> int:
        """Write everything, and return how much that was; never raises OSError."""
        view, start, done = memoryview(buffer).cast("B"), self.tell(), 0
        try:
            while self._failure is None and done < len(view):
                done += super().write(view[done:])
        except OSError as error:
            self._failure = error
        if done < len(view):
            self._pending.append((start + done, bytes(view[done:])))
        self._size = max(self._size, self.seek(start + len(view)))
        return len(view)

    def truncate(self, size: int | None = None, /) -> int:
        """Set the size of the file, and return it; never raises OSError."""
        self._size = self.tell() if size is None else size
        try:
            if self._failure is None:
                super().truncate(self._size)
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
