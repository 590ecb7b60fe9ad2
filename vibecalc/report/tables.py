"""Tables of fixed columns: widths never follow the values, so that plain `diff` works."""

import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple

WIDTH = 100
INDENT = "  "
_GAP = " "


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
    """Lines of a table under its titles and a rule; `totals` stand below another rule.

    A cell that is too wide goes on below. A column without an entry is left out.
    """
    used = len(INDENT) + sum(column.width for column in columns) + len(_GAP) * (len(columns) - 1)
    if used > WIDTH:
        raise ValueError(f"a table of {used} columns does not fit into {WIDTH}")
    whole = [list(rows), list(totals)]
    places = filled([row for part in whole for row in part], len(columns))
    columns = [columns[place] for place in places]
    body, below = ([[row[place] for place in places] for row in part] for part in whole)
    lines = _row([column.title for column in columns], columns)
    lines.append((INDENT + _GAP.join("-" * column.width for column in columns)).rstrip())
    for row in body:
        lines.extend(_row(row, columns))
    if below:
        across = sum(column.width + len(_GAP) for column in columns) - len(_GAP)
        lines.append(INDENT + "-" * across)
    for row in below:
        lines.extend(_row(row, columns))
    return lines


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
    """Lines of `name   value`, the value folded into what is left of the page."""
    lines = []
    for name, value in rows:
        folded = fold(value, WIDTH - len(INDENT) - width - 1)
        heads = fold(name, width)
        for i in range(max(len(folded), len(heads))):
            head = heads[i] if i < len(heads) else ""
            tail = folded[i] if i < len(folded) else ""
            lines.append(f"{INDENT}{head.ljust(width)} {tail}".rstrip())
    return lines


def paragraph(text: str, mark: str = "") -> list[str]:
    """A folded, indented paragraph; `mark` (such as `[1]`) stands before its first line."""
    lead = f"{mark} " if mark else ""
    folded = fold(text, WIDTH - len(INDENT) - len(lead))
    return [
        (INDENT + (lead if i == 0 else " " * len(lead)) + line).rstrip()
        for i, line in enumerate(folded)
    ]
