"""Texts that anybody may print: what nobody sees, or moves what others see, is spelled out."""

import re
import sys
import unicodedata

from vibecalc.errors import OutputError

_SUSPECT = re.compile(r"[^\t\n\x20-\x7e]")
#: control and format characters, lone surrogates, separators of lines and of paragraphs
_HIDDEN = ("Cc", "Cf", "Cs", "Zl", "Zp")


def hidden(text: str) -> str:
    """The first character of a text that is not to be printed as it is; "" without one.

    Escape and other control characters but tab and new line, directions of writing, other format
    characters without width, and bytes of file names that are no UTF-8.
    """
    found = (one[0] for one in _SUSPECT.finditer(text) if unicodedata.category(one[0]) in _HIDDEN)
    return next(found, "")


def visible(text: str) -> str:
    """The text with such characters as `\\x1b` and `\\u202e`; line ends are new lines."""
    return _SUSPECT.sub(_spelled, text.replace("\r\n", "\n"))


def spelled(character: str) -> str:
    """A character as a TOML or Python text would spell it."""
    code = ord(character)
    if 0xDC80 <= code <= 0xDCFF:  # a byte of a file name
        code -= 0xDC00
    return (
        f"\\x{code:02x}"
        if code < 0x100
        else f"\\u{code:04x}"
        if code < 0x10000
        else f"\\U{code:08x}"
    )


def put(text: str) -> None:
    """Write a text to stdout at once; OutputError where that takes no more."""
    try:
        sys.stdout.write(text)
        sys.stdout.flush()
    except OSError as error:
        raise OutputError(error) from error


def _spelled(found: re.Match[str]) -> str:
    return spelled(found[0]) if unicodedata.category(found[0]) in _HIDDEN else found[0]


#: what programs for spreadsheets take for a formula
_FORMULA = re.compile(r"'*[=+\-@\t]")


def text_cell(text: str) -> str:
    """A text as a cell: with an apostrophe before = + - @, which our reader takes away again.

    Programs for spreadsheets compute what begins so; a text that is a number stays as it is.
    """
    try:
        float(text)
    except ValueError:
        return f"'{text}" if _FORMULA.match(text) else text
    return text
