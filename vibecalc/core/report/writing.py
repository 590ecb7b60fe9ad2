"""How a report writes: tables of fixed columns, numbers with stable digits."""

import math
import re
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.results.record import ROUNDING, Estimate

# ----------------------------------------------------------------------------
# Tables of fixed columns: widths never follow the values, so that plain `diff` works.
# ----------------------------------------------------------------------------

WIDTH = 100
INDENT = "  "
_GAP = " "


class Block(str):
    """Lines of a report as one text, which knows what it is made of: pages of HTML set it anew."""


class Heading(Block):
    """A title over a rule; level 1 is that of the report."""

    level: int
    words: str


class Paragraph(Block):
    """Words; `mark`, such as `[1]`, stands before them."""

    mark: str
    words: str


class Pairs(Block):
    """Names and values."""

    rows: list[tuple[str, str]]


class Table(Block):
    """Columns that have an entry, rows of cells, and those below a rule."""

    columns: list["Column"]
    rows: list[list[str]]
    totals: list[list[str]]


def heading(title: str, level: int = 2) -> list[str]:
    """A title over its rule, after an empty line but at the beginning."""
    lines = fold(title, WIDTH - len(INDENT))
    rule = ("=" if level == 1 else "-") * max(len(line) for line in lines)
    block = Heading("\n".join([*lines, rule]))
    block.level, block.words = level, title
    return [block] if level == 1 else ["", block]


#: a product of units, which is read with a blank
_PRODUCT = re.compile(r"(?<=[A-Za-z])\*(?=[A-Za-z])")


def read(text: str) -> str:
    """A text with the products of units as they are read: N m."""
    return _PRODUCT.sub(" ", text)


def text_of(lines: Iterable[str]) -> str:
    """The text of the blocks of a report."""
    return read("\n".join(lines)) + "\n"


def height(lines: Iterable[str]) -> int:
    """How many lines of text the blocks take."""
    return sum(line.count("\n") + 1 for line in lines)


def titled(title: str, lines: Sequence[str]) -> list[str]:
    """A part of a report under its heading."""
    return [*heading(title), *lines]


class Column(NamedTuple):
    """Title, width in characters, and whether it is set to the right (numbers)."""

    title: str
    width: int
    right: bool = False


def number(title: str, width: int = 12) -> Column:
    """A column of numbers, set to the right."""
    return Column(title, width, True)


def fold(text: str, width: int) -> list[str]:
    """Lines of at most `width` characters: broken at blanks; a longer word after `/`, else `_.,`.

    A word without such a mark in it is cut where the line ends.
    """
    if len(text) <= width and "\n" not in text:  # nearly every cell of every table
        return [text.rstrip()]
    lines: list[str] = []
    for paragraph_ in text.split("\n"):
        line = ""
        for word in re.findall(r"\s*\S+|\s+$", paragraph_):
            if len(line + word) > width and line.strip():
                lines.append(line.rstrip())
                line = word.lstrip()
            else:
                line += word
            while len(line) > width:
                cut = line.rfind("/", 0, width) + 1
                if cut <= width // 3:
                    cut = max(line.rfind(mark, 0, width) for mark in "_.,") + 1
                cut = cut if cut > width // 3 else width
                lines.append(line[:cut])
                line = line[cut:]
        lines.append(line.rstrip())
    return lines


def table(
    columns: Sequence[Column],
    rows: Iterable[Sequence[str]],
    totals: Iterable[Sequence[str]] = (),
) -> list[str]:
    """One block: a table under its titles and a rule; `totals` stand below another rule.

    A cell that is too wide goes on below, but a number never does: its column is wider then. A
    column without an entry is left out. Columns that the page has no room for stand in a second
    table under the first, with the names of the rows once more.
    """
    whole = [list(rows), list(totals)]
    places = filled([row for part in whole for row in part], len(columns))
    columns = [columns[place] for place in places]
    body, below = ([[row[place] for place in places] for row in part] for part in whole)
    columns = [
        column._replace(width=max(column.width, _whole(column, [row[i] for row in body + below])))
        for i, column in enumerate(columns)
    ]
    lines: list[str] = []
    for group in _on_page([column.width for column in columns]):
        chosen = [columns[i] for i in group]
        lines += [""] * bool(lines) + _row([column.title for column in chosen], chosen)
        lines.append((INDENT + _GAP.join("-" * column.width for column in chosen)).rstrip())
        for row in body:
            lines.extend(_row([row[i] for i in group], chosen))
        if below:
            across = sum(column.width + len(_GAP) for column in chosen) - len(_GAP)
            lines.append(INDENT + "-" * across)
        for row in below:
            lines.extend(_row([row[i] for i in group], chosen))
    block = Table("\n".join(lines))
    block.columns, block.rows, block.totals = columns, body, below
    return [block]


#: a word that is a number, or several with `/` between them
_NUMBER = re.compile(r"(\+-)?[-+]?\d[\d.,/e+-]*")


def _whole(column: Column, cells: Iterable[str]) -> int:
    """The width that no number, and no word of a column of numbers, is broken at."""
    words = {word for cell in cells if len(cell) > column.width for word in cell.split()}
    whole = (len(word) for word in words if column.right or _NUMBER.fullmatch(word))
    return max(whole, default=0)


def _on_page(widths: Sequence[int]) -> list[list[int]]:
    """Places of columns, the first one and as many others as the page has room for at a time."""
    groups: list[list[int]] = [[0]]
    used = len(INDENT) + widths[0]
    for place in range(1, len(widths)):
        used += len(_GAP) + widths[place]
        if used > WIDTH and len(groups[-1]) > 1:
            groups.append([0])
            used = len(INDENT) + widths[0] + len(_GAP) + widths[place]
        groups[-1].append(place)
    return groups


def filled(rows: Sequence[Sequence[str]], count: int) -> list[int]:
    """Places of those of `count` columns that have an entry in any row; all where none has."""
    return [i for i in range(count) if any(row[i].strip() for row in rows)] or list(range(count))


def _row(cells: Sequence[str], columns: Sequence[Column]) -> list[str]:
    folded = [fold(cell, column.width) for cell, column in zip(cells, columns, strict=True)]
    height = max(len(cell) for cell in folded)
    lines = []
    for i in range(height):
        parts = []
        for cell, column in zip(folded, columns, strict=True):
            text = cell[i] if i < len(cell) else ""
            parts.append(text.rjust(column.width) if column.right else text.ljust(column.width))
        lines.append((INDENT + _GAP.join(parts)).rstrip())
    return lines


def pairs(rows: Iterable[tuple[str, str]], width: int = 24) -> list[str]:
    """One block: `name   value`, the value folded into what is left of the page."""
    lines, rows = [], list(rows)
    for name, value in rows:
        folded = fold(value, WIDTH - len(INDENT) - width - 1)
        heads = fold(name, width)
        for i in range(max(len(folded), len(heads))):
            head = heads[i] if i < len(heads) else ""
            tail = folded[i] if i < len(folded) else ""
            lines.append(f"{INDENT}{head.ljust(width)} {tail}".rstrip())
    block = Pairs("\n".join(lines))
    block.rows = rows
    return [block] if rows else []


def paragraph(text: str, mark: str = "") -> list[str]:
    """A folded, indented block; `mark` (such as `[1]`) stands before its first line."""
    lead = f"{mark} " if mark else ""
    folded = fold(text, WIDTH - len(INDENT) - len(lead))
    block = Paragraph(
        "\n".join(
            (INDENT + (lead if i == 0 else " " * len(lead)) + line).rstrip()
            for i, line in enumerate(folded)
        )
    )
    block.mark, block.words = mark, text
    return [block]


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


def show_error(error: float) -> str:
    """An error estimate with two digits; 0 is `exact`."""
    return "exact" if error == 0.0 else f"{error:.1e}"


def show_percent(fraction: float | None) -> str:
    """A relative difference in percent with its sign, `-` where it is undefined."""
    if fraction is None or math.isnan(fraction) or math.isinf(fraction):
        return "-"
    percent = 100.0 * fraction
    if abs(percent) < 5e-5:
        return "0.0000 %"
    if abs(percent) >= 1e4:
        return f"{percent:+.1e} %"
    decimals = 4 if abs(percent) < 1.0 else 2
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


def hertz(frequency: float) -> float:
    """Cycles per second of a frequency in rad/s."""
    return frequency / _TURN


def is_speed(path: str) -> bool:
    """Whether a quantity in rad/s is a speed of rotation, shown by its path."""
    return path.rsplit("/", 1)[-1].endswith("speed")


#: what a level or a lag of nothing is called
ZERO = "zero"


def decibels(level: float, acts: bool | np.bool_ = True, digits: int = 2) -> str:
    """A level with a fixed count of decimals, `zero` for that of nothing."""
    if not acts or not math.isfinite(level):
        return ZERO if not acts or level < 0 else show(level)
    return f"{round(level, digits) + 0.0:.{digits}f}"
