"""How a report writes: tables as wide as their cells, numbers with stable digits."""

import math
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from itertools import zip_longest
from shutil import get_terminal_size
from typing import Any, NamedTuple, Self

import numpy as np

from vibecalc.core.results.record import ROUNDING, Estimate

# ----------------------------------------------------------------------------
# Blocks of a report: texts that know what they are made of, so that pages of HTML and screens of
# other widths set them anew.
# ----------------------------------------------------------------------------

WIDTH = 100
#: columns of the narrowest screen that reports are set for
_NARROW = 40
INDENT = _GAP = "  "


class Block(str):
    """A part of a report: the text that it is at `WIDTH`, with what that is made of."""

    def __new__(cls, **parts: Any) -> Self:
        """Of its parts by name."""
        draft = super().__new__(cls)
        draft.__dict__.update(parts)
        made = super().__new__(cls, draft.at(WIDTH))
        made.__dict__.update(parts)
        return made

    def at(self, width: int) -> str:
        """Its lines, in that width."""
        raise NotImplementedError


class Heading(Block):
    """A title over a rule; level 1 is that of the report."""

    level: int
    words: str

    def at(self, width: int) -> str:
        """The title folded, and the rule as long as its longest line."""
        lines = fold(self.words, width - len(INDENT))
        return "\n".join([*lines, ("=" if self.level == 1 else "-") * max(map(len, lines))])


class Paragraph(Block):
    """Words; `mark`, such as `[1]`, stands before them."""

    mark: str
    words: str

    def at(self, width: int) -> str:
        """Folded and indented."""
        lead = INDENT + (f"{self.mark} " if self.mark else "")
        lines = fold(self.words, width - len(lead))
        return "\n".join(f"{' ' * len(lead) if i else lead}{line}".rstrip()
                         for i, line in enumerate(lines))  # fmt: skip


class Pairs(Block):
    """Names, in a column of `most` characters at most, and values, folded into what is left."""

    rows: list[tuple[str, str]]
    most: int

    def at(self, width: int) -> str:
        """The column of names takes no more than half of it."""
        wide = min(max(len(name) for name, _ in self.rows), self.most, width // 2)
        both, room = (Column(""), Column("")), width - len(INDENT) - wide - len(_GAP)
        return "\n".join(line for row in self.rows for line in _row(row, both, (wide, room)))


class Table(Block):
    """Columns that have an entry, rows of cells, and those below a rule."""

    columns: list["Column"]
    rows: list[list[str]]
    totals: list[list[str]]

    def at(self, width: int) -> str:
        """Cells folded, and columns under each other, as that asks for."""
        heads, lines = self.columns, list[str]()
        cells = [[row[i] for row in self.rows + self.totals] for i in range(len(heads))]
        for group, wide in _groups(heads, cells, width - len(INDENT)):
            chosen = [heads[i] for i in group]
            rule = (INDENT + _GAP.join("-" * one for one in wide)).rstrip()
            lines += [""] * bool(lines) + _row([one.title for one in chosen], chosen, wide) + [rule]
            for part in (self.rows, self.totals):
                below = part is self.totals and part
                lines += [INDENT + "-" * (len(rule) - len(INDENT))] if below else []
                for row in part:
                    lines += _row([row[i] for i in group], chosen, wide)
        return "\n".join(lines)


def heading(title: str, level: int = 2) -> list[str]:
    """A title over its rule, after an empty line but at the beginning."""
    return [*([] if level == 1 else [""]), Heading(level=level, words=title)]


def paragraph(text: str, mark: str = "") -> list[str]:
    """A folded, indented block; `mark` (such as `[1]`) stands before its first line."""
    return [Paragraph(mark=mark, words=text)]


def pairs(rows: Iterable[tuple[str, str]], most: int = 48) -> list[str]:
    """One block: `name   value`; none without rows."""
    listed = list(rows)
    return [Pairs(rows=listed, most=most)] if listed else []


#: a product of units, which is read with a blank
_PRODUCT = re.compile(r"(?<=[A-Za-z])\*(?=[A-Za-z])")


def read(text: str) -> str:
    """A text with the products of units as they are read: N m."""
    return _PRODUCT.sub(" ", text)


def text_of(lines: Iterable[str], width: int = WIDTH) -> str:
    """The text of the blocks of a report in that width."""
    set_ = (line.at(width) if isinstance(line, Block) else line for line in lines)
    return read("\n".join(set_)) + "\n"


def screen() -> int:
    """Columns of the terminal that stdout is, `WIDTH` at most; `WIDTH` for a pipe or a file."""
    if not sys.stdout.isatty():
        return WIDTH
    return min(WIDTH, max(_NARROW, get_terminal_size((WIDTH, 24)).columns))


def height(lines: Iterable[str]) -> int:
    """How many lines of text the blocks take."""
    return sum(line.count("\n") + 1 for line in lines)


def titled(title: str, lines: Sequence[str]) -> list[str]:
    """A part of a report under its heading."""
    return [*heading(title), *lines]


class Column(NamedTuple):
    """A title, and whether it is set to the right (numbers); columns are as wide as their cells."""

    title: str
    right: bool = False


def number(title: str) -> Column:
    """A column of numbers, set to the right."""
    return Column(title, right=True)


#: where a word that is too long is broken: behind these, but never within a number
_BREAK = re.compile(r"(?<=[_/.,])(?!(?<=\d[.,])\d)")


#: what stays together on a line: a word, or a number with its unit
_WORDS = re.compile(
    r"\s*[-+]?\d[\d.e+-]* "
    r"(?:rpm|[kM]?Hz|k?N(?: m)?|[km]?m|deg|[kM]?W|[km]?J|[kM]?Pa|m?s|K|dB|%)[.,;:)]*(?=\s|$)"
    r"|\s*\S+|\s+$"
)


def fold(text: str, width: int) -> list[str]:
    """Lines of at most `width` characters: broken at blanks; a longer word after `/`, else `_.,`.

    A number and its unit stay on one line, where that has room for both.
    A word without such a mark in it is cut where the line ends. What begins with blanks goes on so.
    """
    if len(text) <= width and "\n" not in text:  # nearly every cell of every table
        return [text.rstrip()]
    lines: list[str] = []
    for paragraph_ in text.split("\n"):
        line, lead = "", " " * min(len(paragraph_) - len(paragraph_.lstrip(" ")), width // 3)
        for word in _WORDS.findall(paragraph_):
            if len(line + word) > width and line.strip():
                lines.append(line.rstrip())
                line = lead + word.lstrip()
            else:
                line += word
            while len(line) > width:
                marks = [at.start() for at in _BREAK.finditer(line, 0, width + 1)]
                far = [at for at in marks if width // 3 < at <= width]
                cut = max(
                    (at for at in far if line[at - 1] == "/"), default=max(far, default=width)
                )
                lines.append(line[:cut])
                line = line[cut:]
        lines.append(line.rstrip())
    return lines


#: a word that is a number, or several with `/` between them, and a cell of a column of numbers
_NUMBER = re.compile(r"(\+-)?[-+]?\d[\d.,/e+-]*")
_NUMERIC = re.compile(
    r"\*?[-+]?\d[\d.,]*(e[-+]?\d+)?( \+-[\d.e+-]+)?( ?%)?|-|zero|-?unbounded|undefined|"
)
#: the length of words from which on they are broken anyhow
_LONG = 16


def table(
    columns: Sequence[Column | str],
    rows: Iterable[Sequence[str]],
    totals: Iterable[Sequence[str]] = (),
) -> list[str]:
    """One block: a table under its titles and a rule; `totals` stand below another rule.

    Columns after the first that hold numbers alone are set to the right. A column without an entry
    is left out, a table without a row is none. In a table that is wider than the page the cells go
    on below, the widest first, but a number never does; columns that even so find no room stand in
    a second table under the first, with the names of the rows once more.
    """
    whole = [list(rows), list(totals)]
    every = [row for part in whole for row in part]
    if not every:
        return []
    places = [i for i in range(len(columns)) if any(row[i].strip() for row in every)]
    heads = [_column(columns[i], [row[i] for row in every if i]) for i in places]
    body, below = ([[row[i] for i in places] for row in part] for part in whole)
    return [Table(columns=heads, rows=body, totals=below)]


def _column(head: Column | str, cells: Sequence[str]) -> Column:
    if isinstance(head, Column):
        return head
    return Column(head, right=bool(cells) and all(_NUMERIC.fullmatch(one.strip()) for one in cells))


def _longest(text: str) -> int:
    return max(map(len, text.split("\n")))


def _title_width(title: str) -> int:
    """Of the title in two lines, or as it is broken."""
    if "\n" in title:
        return _longest(title)
    least = max(map(len, title.split()), default=0)
    return next((n for n in range(least, len(title)) if len(fold(title, n)) <= 2), len(title))


def _least(head: Column, cells: Sequence[str]) -> int:
    """The width that no number, and no word of a column of numbers, is broken at."""
    least = 1
    for word in {word for text in (head.title, *cells) for word in text.split()}:
        whole = _NUMBER.fullmatch(word) or (head.right and word not in head.title)
        least = max(least, len(word) if whole else min(_LONG, max(map(len, _BREAK.split(word)))))
    return least


def _groups(
    heads: Sequence[Column], cells: Sequence[Sequence[str]], room: int
) -> Iterator[tuple[list[int], list[int]]]:
    """Places of columns that stand beside each other, with their widths.

    As wide as cells and titles in two lines; the widest less where there is no room for that. The
    first one and as many others as there is room for stand together.
    """
    both = list(zip(heads, cells, strict=True))
    wide = [max(1, _title_width(one.title), *map(_longest, each)) for one, each in both]
    if sum(wide) + len(_GAP) * (len(wide) - 1) <= room:
        yield [*range(len(wide))], wide
        return
    least = [_least(*one) for one in both]
    wide = [max(*pair) for pair in zip(wide, least, strict=True)]
    groups: list[list[int]] = [[0]]
    for i in range(1, len(wide)):
        if len(groups[-1]) > 1 and sum(least[j] + len(_GAP) for j in groups[-1]) + least[i] > room:
            groups.append([0])
        groups[-1].append(i)
    for group in groups:
        over = sum(wide[i] + len(_GAP) for i in group) - len(_GAP) - room
        set_ = {i: wide[i] for i in group}
        while over > 0 and (able := [i for i in group if set_[i] > least[i]]):
            set_[max(able, key=set_.__getitem__)] -= 1
            over -= 1
        yield group, [*set_.values()]


def _row(cells: Sequence[str], columns: Sequence[Column], wide: Sequence[int]) -> list[str]:
    folded = [fold(cell, width) for cell, width in zip(cells, wide, strict=True)]
    lines = []
    for parts in zip_longest(*folded, fillvalue=""):
        set_ = [part.rjust(width) if column.right else part.ljust(width)
                for part, column, width in zip(parts, columns, wide, strict=True)]  # fmt: skip
        lines.append((INDENT + _GAP.join(set_)).rstrip())
    return lines


# ----------------------------------------------------------------------------
# Numbers as the report prints them: stable digits, 0 for zeros, the error where it is larger.
# ----------------------------------------------------------------------------

DIGITS = 4
#: share of a single value from which on its error is shown; digits of both, and below which share
#: of the error a value says nothing
_SHOWN_FROM, _ROUGH, _LEAST_SHOWN = 0.1, 3, 1e-3
_LOWEST_FIXED = 1e-4
_HIGHEST_FIXED = 1e7
_TURN = 2.0 * math.pi


#: relative: what rounding may have taken of a half; from here on more would be infinite
_HALF, _LARGEST = 1e-13, 1e308


def show(value: Any, error: float = 0.0, digits: int = DIGITS) -> str:
    """One number with a fixed count of significant digits.

    A complex number shows its magnitude, an integer all its digits. What is zero to rounding of
    the terms it is summed from is `0`: its digits would change from machine to machine. What does
    not exceed its `error` (absolute, same unit) for another reason is shown with it, `196 +-722`,
    and so is a single value of which it is a tenth. An error without terms counts as rounding. An
    infinite value is `unbounded`, an undefined one `undefined`.
    """
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, int | np.integer):
        return str(int(value))
    number: float = abs(value) if np.iscomplexobj(value) else float(value)
    if math.isnan(number):
        return "undefined"
    if math.isinf(number):
        return "unbounded" if number > 0 else "-unbounded"
    if isinstance(error, Estimate):
        if error.is_zero(number):
            return "0"
        least_error = abs(number) * (_SHOWN_FROM if error.own else 1.0)
        rough = math.isfinite(error) and error >= least_error
        if rough and error > ROUNDING * error.terms:
            least = number if abs(number) > _LEAST_SHOWN * error else 0.0
            return f"{show(least, digits=_ROUGH)} +-{show(float(error), digits=_ROUGH)}"
    # An error that is not known hides nothing: the accuracy section says so instead.
    elif number == 0.0 or (abs(number) <= error and math.isfinite(error)):
        return "0"
    # a half is rounded away from zero, also where the last bit would say no
    number *= 1.0 + _HALF * (abs(number) < _LARGEST)
    mantissa, exponent = f"{number:.{digits - 1}e}".split("e")
    if _LOWEST_FIXED <= abs(float(f"{mantissa}e{exponent}")) < _HIGHEST_FIXED:
        return f"{number:.{max(digits - 1 - int(exponent), 0)}f}"
    return f"{mantissa}e{exponent}"


def show_in(value: Any, unit: str, error: float = 0.0, digits: int = DIGITS) -> str:
    """A number as `show` writes it, with its unit."""
    return f"{show(value, error, digits)} {unit}".rstrip()


def many(count: int, noun: str, plural: str = "") -> str:
    """`1 point`, `2 points`."""
    return f"{count} {noun if count == 1 else plural or f'{noun}s'}"


def finite(value: float) -> float | None:
    """A number as JSON has a word for it; None for what is not finite."""
    return value if math.isfinite(value) else None


def show_error(error: float) -> str:
    """An error estimate with two digits; 0 is `exact`."""
    return "exact" if error == 0.0 else f"{error:.1e}"


#: of percentages below so many
_DECIMALS = ((4, 0.99995), (2, 99.995), (1, 999.95), (0, 1e4))


def show_percent(fraction: float | None) -> str:
    """A relative difference in percent with its sign, `-` where it is undefined.

    From a hundredfold on it is the factor between both.
    """
    if fraction is None or math.isnan(fraction) or math.isinf(fraction):
        return "-"
    percent = 100.0 * fraction
    if abs(percent) < 5e-5:
        return "0.0000 %"
    if percent >= 1e4:
        return f"factor {show(1.0 + fraction, digits=2)}"
    if percent <= -1e4:
        return f"{percent:+.1e} %"
    decimals = next(n for n, most in _DECIMALS if abs(percent) < most)
    return f"{percent:+.{decimals}f} %"


def show_phase(value: complex, error: float = 0.0) -> str:
    """Phase of a complex amplitude in degrees, (-180, 180], `-` where the amplitude is zero.

    A positive phase leads. The half turn is printed as +180, whichever side round-off put it on.
    """
    if not abs(value) > error or not math.isfinite(abs(value)):
        return "-"
    degrees = round(math.degrees(math.atan2(value.imag, value.real)), 2)
    if degrees == -180.0:
        degrees = 180.0
    return f"{degrees + 0.0:.2f}"


def rpm(speed: float) -> float:
    """Turns per minute of a speed in rad/s."""
    return speed * 60.0 / _TURN


def turns(speed: float) -> str:
    """A speed in rad/s as rpm, short: `300`, `859.9`."""
    return short(rpm(speed))


def short(value: float) -> str:
    """Four significant digits, without zeros at the end."""
    text = show(float(value), digits=4)
    return text.rstrip("0").rstrip(".") if "." in text and "e" not in text else text


def as_text(value: float, unit: str) -> str:
    """Four digits; of turns without zeros at the end."""
    return short(value) if unit == "rpm" else show(value)


def hertz(frequency: float) -> float:
    """Cycles per second of a frequency in rad/s."""
    return frequency / _TURN


#: what a level or a lag of nothing is called
ZERO = "zero"


def decibels(level: float, acts: bool | np.bool_ = True, digits: int = 2) -> str:
    """A level with a fixed count of decimals, `zero` for that of nothing."""
    if not acts or not math.isfinite(level):
        return ZERO if not acts or level < 0 else show(level)
    return f"{round(level, digits) + 0.0:.{digits}f}"
