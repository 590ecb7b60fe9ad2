"""Texts that anybody may print: what nobody sees, or moves what others see, is spelled out."""

import re
import sys
import unicodedata

from vibecalc.errors import OutputError

_SUSPECT = re.compile(r"[^\t\n\x20-\x7e]")
#: control and format characters, lone surrogates, separators of lines and of paragraphs
_HIDDEN = ("Cc", "Cf", "Cs", "Zl", "Zp")
#: format characters that hide and move nothing: what joins and parts the letters of Persian, Indic
#: scripts and emoji, and signs of Arabic, Syriac and Kaithi that are seen
_HARMLESS = re.compile(
    r"[\u200c\u200d\u0600-\u0605\u06dd\u070f\u0890\u0891\u08e2\U000110bd\U000110cd]"
)


def hidden(text: str) -> str:
    """The first character of a text that is not to be printed as it is; "" without one.

    Escape and other control characters but tab and new line, directions of writing, other format
    characters that hide or move what is seen, and bytes of file names that are no UTF-8.
    """
    return next((one[0] for one in _SUSPECT.finditer(text) if _hides(one[0])), "")


def fits_a_line(text: str) -> bool:
    """Whether a text can be printed as it is, in one line."""
    return not hidden(text) and not set(text) & {"\t", "\n"}


def _hides(character: str) -> bool:
    return unicodedata.category(character) in _HIDDEN and not _HARMLESS.match(character)


def visible(text: str) -> str:
    """The text with such characters as `\\x1b` and `\\u202e`; line ends are new lines."""
    return _SUSPECT.sub(_spelled, text.replace("\r\n", "\n"))


def spelled(character: str) -> str:
    """A character as a TOML or Python text would spell it."""
    code = ord(character)
    if 0xDC80 <= code <= 0xDCFF:  # a byte of a file name
        code -= 0xDC00
    letter, width = ("x", 2) if code < 0x100 else ("u", 4) if code < 0x10000 else ("U", 8)
    return f"\\{letter}{code:0{width}x}"


def put(text: str) -> None:
    """Write a text to stdout at once; OutputError where that takes no more."""
    try:
        sys.stdout.write(text)
        sys.stdout.flush()
    except OSError as error:
        raise OutputError(error) from error


def _spelled(found: re.Match[str]) -> str:
    return spelled(found[0]) if _hides(found[0]) else found[0]


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
