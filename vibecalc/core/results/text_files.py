"""Text files of users, read with the same guards wherever one is named."""

from pathlib import Path

from vibecalc.errors import UsageError

#: what the first bytes of a text in UTF-16 are
_UTF_16 = (b"\xff\xfe", b"\xfe\xff")


def text_file(path: Path, largest: int, what: str) -> str:
    """The text of an ordinary file in UTF-8, with or without its mark, of `largest` bytes at most.

    `what` names it in the words of the UsageError for a file that is missing, no ordinary file
    (a pipe would be waited for, a device never ends), too large, or no text.
    """
    try:
        if path.exists() and not path.is_file():
            kind = "a folder" if path.is_dir() else "no ordinary file"
            raise UsageError(f"cannot read {what} {path}: this is {kind}")
        with path.open("rb") as file:
            content = file.read(largest + 1)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise UsageError(f"cannot read {what} {path}: {reason}") from None
    except ValueError:  # a null character
        raise UsageError(f"{str(path)!r} is no name of a file") from None
    if len(content) > largest:
        raise UsageError(f"cannot read {what} {path}: it is larger than {largest / 1e6:g} MB")
    if content.startswith(_UTF_16):
        raise UsageError(f"cannot read {what} {path}: a text in UTF-16, save it in UTF-8")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise UsageError(f"cannot read {what} {path}: no text in UTF-8 (line {line})") from None
    if "\0" in text:
        line = text.count("\n", 0, text.index("\0")) + 1
        raise UsageError(f"cannot read {what} {path}: a null character in line {line}")
    return text
