"""Output files: folders made on the way, and never half a file under the final name."""

import os
import stat
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
    """Put `content` at `path` in one step, and return where it is.

    The bytes go to a temporary file in the same folder, reach the disk, and are renamed onto the
    target, so a reader sees the old file or the new one. Whatever goes wrong on the way (full
    disk, Ctrl-C), the temporary file is removed and the old file stays as it was. Raises
    UsageError with the reason.
    """
    target = fresh_output(path)
    # A short name of its own: the target's may already be as long as the file system allows.
    temporary = target.parent / f".vibecalc-{os.getpid()}-{os.urandom(4).hex()}.tmp"
    try:
        with open(temporary, "xb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(temporary, target)
    except OSError as error:
        _discard(temporary)
        kept = ", the old one is untouched" if os.path.isfile(target) else ""
        raise UsageError(f"cannot write {target}: {_why(error)}{kept}") from error
    except BaseException:
        _discard(temporary)
        raise
    return target


def _discard(temporary: Path) -> None:
    try:
        temporary.unlink(missing_ok=True)
    except OSError:
        return  # the first error says what is wrong with this folder


def _why(error: OSError) -> str:
    return (error.strerror or str(error)).lower()
