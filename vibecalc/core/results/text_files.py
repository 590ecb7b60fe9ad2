"""Files of users, read with the same guards and refused in the same words wherever one is named."""

import os
import select
import stat
from pathlib import Path

from vibecalc.errors import UsageError

#: bytes of a case, or of a file of rules
LARGEST = 1_000_000
#: how a file of HDF5 begins
HDF5_BEGINS = b"\x89HDF\r\n\x1a\n"
#: seconds within which somebody has to write to a pipe
_PATIENCE = 5.0


class Unfit(Exception):
    """What is wrong with a file, as `is a folder`, and a hint."""

    def __init__(self, message: str, hint: str = ""):
        super().__init__(message)
        self.hint = hint


class Missing(Unfit):
    """A file that is not there."""


class TooLarge(Unfit):
    """A file of more bytes than it may have."""


def content_of(path: Path, largest: int, streams: bool = False) -> bytes:
    """The bytes of a file, `largest` of them at most. Raises Unfit.

    Pipes and devices, as `<(command)` and /dev/stdin, only with `streams`: they give once what they
    have, and a pipe that nobody writes to is not waited for.
    """
    try:
        kind = path.stat().st_mode
        if stat.S_ISDIR(kind):
            raise Unfit("is a folder", "name a file in it")
        if not (stat.S_ISREG(kind) or streams):
            raise Unfit("is no ordinary file")
        if stat.S_ISFIFO(kind):
            content = _of_pipe(path, largest + 1)
        else:
            with path.open("rb") as file:
                content = file.read(largest + 1)
    except FileNotFoundError:
        raise Missing("does not exist") from None
    except OSError as error:
        raise Unfit(f"cannot be read: {(error.strerror or str(error)).lower()}") from None
    except ValueError:
        raise Unfit("has a null character in its name") from None
    return checked(content, largest)


def checked(content: bytes, largest: int) -> bytes:
    """The same bytes; Unfit where there are more of them, and for a result or a text in UTF-16."""
    if content.startswith(HDF5_BEGINS):
        raise Unfit("is a result file (HDF5), which `vibecalc report` reads")
    if len(content) > largest:
        raise TooLarge(f"is larger than {largest / 1e6:g} MB")
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise Unfit("is encoded in UTF-16", "save it in UTF-8")
    return content


def _of_pipe(path: Path, size: int) -> bytes:
    number = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    with open(number, "rb", buffering=0) as pipe:
        in_time, _, _ = select.select([pipe], [], [], _PATIENCE)
        first = pipe.read(1)  # nothing where nobody writes, None where it is yet to come
        if first == b"" and not in_time:
            raise Unfit("is a pipe that nobody writes to")
        os.set_blocking(number, True)
        with open(number, "rb", closefd=False) as rest:
            return (first or b"") + rest.read(size)


def text_of(content: bytes) -> str:
    """The text in the bytes of a file, in UTF-8 with or without its mark. Raises Unfit."""
    if b"\0" in content:
        line = _line(content, content.index(b"\0"))
        raise Unfit(f"is not a text file: null character in line {line}")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise Unfit(
            f"is not text in UTF-8 (line {_line(content, error.start)})",
            "save it in UTF-8, in spreadsheet programs 'CSV UTF-8'",
        ) from None


def _line(content: bytes, place: int) -> int:
    return content.count(b"\n", 0, place) + 1


def text_file(path: Path, largest: int, what: str) -> str:
    """The text of a file that a command names; UsageError, with `what` it is, where it has none."""
    try:
        return text_of(content_of(path, largest, streams=True))
    except Unfit as error:
        hint = f"\n  help: {error.hint}" if error.hint else ""
        raise UsageError(f"{what} {path} {error}{hint}") from None
