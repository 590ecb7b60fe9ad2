"""Output files: folders made on the way, and never half a file under the final name."""

import os
import stat
import zlib
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from vibecalc.errors import UsageError


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
    """Put each content at its path in one step, and return where they are.

    The bytes go to temporary files in the same folders, reach the disk, and are renamed onto the
    targets one right after the other, so a reader sees the old files or the new ones. Whatever goes
    wrong on the way (full disk, Ctrl-C), the temporary files are removed and the old files stay as
    they were; what a killed process has left of its own is removed now. Raises UsageError with the
    reason; the files before the one that it is about are written all the same.
    """
    aside: list[tuple[Path, Path]] = []
    failure: UsageError | None = None
    try:
        for path, content in files:
            try:
                aside.append(_written_aside(path, content))
            except UsageError as error:
                failure = error
                break
        for temporary, target in aside:
            try:
                os.replace(temporary, target)
            except OSError as error:
                raise _cannot(target, error) from error
    finally:
        for temporary, _ in aside:
            _discard(temporary)
    if failure is not None:
        raise failure
    return [target for _, target in aside]


def temporary_name() -> str:
    """A name nobody else takes; short, for file systems that end at 255 characters."""
    return f".vibecalc-{_host()}-{os.getpid()}-{os.urandom(4).hex()}.tmp"


def is_temporary(path: Path) -> bool:
    """Whether this is a file that somebody has not finished writing."""
    return path.name.startswith(".vibecalc-") and path.suffix == ".tmp"


def clear_leftovers(folder: Path) -> None:
    """Remove the temporary files of processes of this host that are no more."""
    begin = f".vibecalc-{_host()}-"
    for name in os.listdir(folder):
        if name.startswith(begin) and name.endswith(".tmp"):
            number = name.removeprefix(begin).partition("-")[0]
            if number.isdigit() and not _is_there(int(number)):
                _discard(folder / name)


def _written_aside(path: Path | str, content: bytes) -> tuple[Path, Path]:
    """A temporary file with the content, and where it is to go."""
    target = fresh_output(path)
    with suppress(OSError):  # a folder that cannot be listed can be written
        clear_leftovers(target.parent)
    temporary = target.parent / temporary_name()
    try:
        with open(temporary, "xb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
    except OSError as error:
        _discard(temporary)
        raise _cannot(target, error) from error
    except BaseException:
        _discard(temporary)
        raise
    return temporary, target


def _cannot(target: Path, error: OSError) -> UsageError:
    kept = ", the old one is untouched" if os.path.isfile(target) else ""
    return UsageError(f"cannot write {target}: {_why(error)}{kept}")


def _host() -> str:
    return f"{zlib.crc32(os.uname().nodename.encode()):08x}"


def _is_there(process: int) -> bool:
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        return True
    return True


def _discard(temporary: Path) -> None:
    try:
        temporary.unlink(missing_ok=True)
    except OSError:
        return  # the first error says what is wrong with this folder


def _why(error: OSError) -> str:
    return (error.strerror or str(error)).lower()
