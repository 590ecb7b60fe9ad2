"""Large files, written piece by piece beside their place and put there when they are whole."""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from vibecalc.errors import UsageError
from vibecalc.results.files import temporary_name


@contextmanager
def written_aside(target: Path, check: Callable[[Path], None] | None = None) -> Iterator[Path]:
    """Give the name of a temporary file in the folder of `target`, and rename it in the end.

    On leaving, the file reaches the disk, `check` looks at it (and raises if it is not what it
    should be), and it replaces `target` in one step. Whatever goes wrong before, the temporary
    file is removed and an old `target` stays as it was. OSErrors, of the caller too, become
    UsageError with the reason.
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
    except OSError as error:
        _discard(temporary)
        raise UsageError(f"cannot write {target}: {_reason(error, target)}") from error
    except BaseException:
        _discard(temporary)
        raise


def _to_disk(path: Path) -> None:
    """Wait until a file, or the names in a folder, are on the disk."""
    number = os.open(path, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)


def _discard(temporary: Path) -> None:
    try:
        temporary.unlink(missing_ok=True)
    except OSError:
        return  # the first error says what is wrong with this folder


def _reason(error: OSError, target: Path) -> str:
    """Why, in the words of the system; HDF5 hides them in a long text of its own."""
    if not target.parent.is_dir():
        return f"the folder {target.parent} is not there any more"
    if error.errno is not None:
        return os.strerror(error.errno).lower()
    text = str(error)
    _, found, rest = text.partition("error message = '")
    return rest.partition("'")[0].lower() if found else text
