"""A table in a CSV file next to a case: columns with names and units, cells as written and read."""

import csv
import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from vibecalc.core.case.inputs import see
from vibecalc.core.case.raw import similar
from vibecalc.core.results.steps import step
from vibecalc.core.results.text_files import Missing, TooLarge, Unfit, content_of, text_of
from vibecalc.errors import UnitError
from vibecalc.units import convert, split_number

if TYPE_CHECKING:
    from vibecalc.core.case.walk import Shape

# ----------------------------------------------------------------------------
# A table in a CSV file: columns with names and units, cells as written.
# ----------------------------------------------------------------------------

LARGEST_FILE = 2_000_000
MOST_ROWS, MOST_COLUMNS = 20_000, 200
LONGEST_UNIT, LONGEST_EXCERPT = 80, 80


class Column(NamedTuple):
    """Unit, cells as written, the line of the file that each stands in and that of the names.

    `decimal` is the sign of decimals in the numbers of the file: a point, a comma, or either as
    long as no cell tells.
    """

    unit: str
    cells: list[str]
    lines: list[int]
    head: int
    decimal: str


Columns = dict[str, Column]


class Unreadable(Exception):
    """What is wrong with a file, what would be right, a hint, the key that says it, its line."""

    def __init__(
        self, message: str, allowed: str = "", hint: str = "", key: str = "", line: int = 0
    ):
        super().__init__(message)
        self.allowed, self.hint, self.key, self.line = allowed, hint, key, line


class TooLong(Unreadable):
    """A table of more lines than a case may have."""


_SEPARATORS = {";": "semicolons", "\t": "tabs", ",": "commas"}
_SAID = re.compile(r"""["']?sep=([;,\t])["']?[;,\s]*\Z""")
#: the apostrophe by which a text that could be a formula is marked, as `export` does
_MARKED = re.compile(r"\A'(?='*[=+\-@])")
_COMMA = re.compile(r"[-+−]?\d+,\d+(?![\d,.])")
_WITH_COMMA = re.compile(r"[-+−]?\d+,\d+([eE][-+]?\d+)?\Z")
_POINT = re.compile(r"[-+−]?\d*\.\d")
_WHOLE = re.compile(r"[+-]?\d{1,18}\Z")
_FLAGS = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False}
#: what stands for no unit
NO_UNIT = ("-", "–", "—")


def read_columns(folder: Path, name: str) -> Columns:
    """Columns of a CSV file in `folder`, see `columns_of`.

    Raises Unreadable for a file that is not there, not in the folder, or no table.
    """
    return columns_of(read_text(folder, name))


def columns_of(text: str) -> Columns:
    """Columns of a CSV file, in their order, as programs for spreadsheets write them.

    Semicolons, tabs or commas part the cells, as in the line of names; with the former two numbers
    may have decimal commas. A line that begins with # is none, nor are a row and a column that have
    nothing in them; a first line `sep=;` says what parts the cells.

    Raises Unreadable for what is no table.
    """
    numbered = [
        (number, line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith(("#", '"#'))
    ]
    said = _SAID.match(numbered[0][1]) if numbered else None
    if said:
        del numbered[0]
    bare = re.sub(r'"[^"]*"', "", numbered[0][1]) if numbered else ""
    separator = said[1] if said else next((sign for sign in _SEPARATORS if sign in bare), ",")
    rows = _rows(numbered, separator)
    (first, names), rows = rows[0], rows[1:]
    if not rows:
        raise Unreadable(
            "the file has column names but no values", "lines of values below the names"
        )
    if len(rows) > MOST_ROWS:
        raise TooLong(f"the file has {len(rows)} lines of values", f"up to {MOST_ROWS}")
    if len(names) > MOST_COLUMNS:
        raise Unreadable(f"the file has {len(names)} columns", f"up to {MOST_COLUMNS}")
    for line, row in rows:
        if len(row) < len(names) or any(row[len(names) :]):
            raise Unreadable(
                f"line {line} of the file has {len(row)} cell{'' if len(row) == 1 else 's'}",
                f"{len(names)}, as in the header line",
                _parted(row, separator),
                line=line,
            )
    filled = [p for p, cell in enumerate(names) if cell or any(row[p] for _, row in rows)]
    head = _head([(place + 1, names[place]) for place in filled], first)
    lines, decimal = [line for line, _ in rows], "." if separator == "," else ".,"
    if decimal == ".," and any(_WITH_COMMA.match(cell) for _, row in rows for cell in row):
        decimal = ","
    return {
        column: Column(unit, [row[place] for _, row in rows], lines, first, decimal)
        for place, (column, unit) in zip(filled, head, strict=True)
    }


def some_cells(column: Column, places: Sequence[int]) -> Column:
    """A column with the cells at some places only."""
    cells, lines = [column.cells[p] for p in places], [column.lines[p] for p in places]
    return column._replace(cells=cells, lines=lines)


def excerpt(folder: Path, name: str, line: int) -> str:
    """A line of a file that was read, in quotes; cut where it is long."""
    text = read_text(folder, name).splitlines()[line - 1].strip()
    return repr(text if len(text) <= LONGEST_EXCERPT else text[: LONGEST_EXCERPT - 3] + "...")


def _parted(row: Sequence[str], separator: str) -> str:
    """A hint where another sign seems to part the cells of a row."""
    others = (sign for sign in _SEPARATORS if sign != separator)
    if not any(sign in cell for sign in others for cell in row):
        return ""
    return f"cells are separated by {_SEPARATORS[separator]}, as in the header line"


def _rows(numbered: Sequence[tuple[int, str]], separator: str) -> list[tuple[int, list[str]]]:
    """Cells of each row that has some, with the line that it ends in."""
    reader = csv.reader(
        (line for _, line in numbered), delimiter=separator, skipinitialspace=separator != "\t"
    )
    rows = []
    try:
        for row in reader:
            cells = [_MARKED.sub("", cell.strip(), count=1) for cell in row]
            if any(cells):
                rows.append((numbered[reader.line_num - 1][0], cells))
    except csv.Error as error:
        raise Unreadable(f"the file is not a CSV file: {error}") from None
    if not rows:
        raise Unreadable("the file is empty", "a line of column names, then lines of values")
    return rows


def read_text(
    folder: Path, name: str, example: str = "a name like gas.csv", like: str = "*.csv"
) -> str:
    """A text file next to a case, see `content_beside`."""
    content = content_beside(folder, name, LARGEST_FILE, example, like)
    try:
        text = text_of(content)
    except Unfit as error:
        raise Unreadable(f"the file {error}", hint=error.hint) from None
    step(f"read {folder / name}: {len(text.splitlines())} lines")
    return text


def content_beside(folder: Path, name: str, largest: int, example: str, like: str) -> bytes:
    """A file next to a case, such as the `example`; those `like` it are what names are near.

    Raises Unreadable for one that is not there, not in the folder, too large, or no ordinary file.
    """
    path = folder / name
    try:
        inside = path.resolve().is_relative_to(folder.resolve())
    except (OSError, ValueError, RuntimeError):  # a null character; links in a circle
        inside = True  # which reading says
    if Path(name).is_absolute() or not inside:
        raise Unreadable("the file has to be in the folder of its case", example)
    try:
        content = content_of(path, largest)
    except Missing as error:
        raise Unreadable(f"the file {error}", hint=similar(path, like)) from None
    except TooLarge as error:
        raise TooLong(f"the file {error}", f"up to {largest / 1e6:g} MB") from None
    except Unfit as error:
        raise Unreadable(f"the file {error}", hint=error.hint) from None
    see(name, content)
    return content


def _head(cells: Sequence[tuple[int, str]], line: int) -> list[tuple[str, str]]:
    """Name and unit of each column, from its place and its cell in the line of names."""
    names: list[tuple[str, str]] = []
    for place, cell in cells:
        name, bracket, bracketed = cell.partition("[")
        unit = bracketed.removesuffix("]")
        if not name.strip():
            raise Unreadable(
                f"column {place} has no name", "a name, or a name and a [unit]", line=line
            )
        odd = unit == bracketed or "[" in unit or "]" in unit or len(unit) > LONGEST_UNIT
        if bracket and odd:
            raise Unreadable(
                f"the name of column {place} cannot be read: {cell[:40]!r}",
                "a name, or a name and a unit as in 'pressure [bar]'",
                line=line,
            )
        if any(name.strip() == known for known, _ in names):
            raise Unreadable(
                f"two columns are named {name.strip()[:40]!r}", "each name once", line=line
            )
        names.append((name.strip(), "" if unit.strip() in NO_UNIT else unit.strip()))
    return names


# ----------------------------------------------------------------------------
# Cells as a case would have them: numbers with units, whole numbers, names, lists of them.
# ----------------------------------------------------------------------------


def check_unit(name: str, column: Column, wanted: str) -> None:
    """Raise Unreadable where the unit of a column does not convert to the wanted one."""
    if not column.unit:
        return
    try:
        convert(1.0, column.unit, wanted)
    except UnitError as error:
        found = f", {error.found}" if error.message == "wrong dimension" else ""
        raise Unreadable(
            f"column {name}, unit {column.unit[:40]!r}: {error.message}{found}",
            error.allowed or (f"a unit that converts to {wanted}" if wanted else "no unit"),
            error.hint,
            line=column.head,
        ) from None


def numbers_of(name: str, column: Column) -> list[str]:
    """The cells of a column with decimal points; Unreadable at the first that is no number."""

    def read(cell: str) -> str:
        if column.decimal == "," and _POINT.match(cell):
            raise Unreadable(
                f"a decimal point, where other numbers of the file have commas: {cell[:40]!r}",
                "one decimal sign in a file, and no thousands separator",
            )
        written = with_point(cell, column)
        try:
            digits, unit = split_number(written)
        except UnitError as error:
            what = f"{error.message}: {written[:40]!r}" if cell else "empty cell"
            raise Unreadable(what, "a finite number in every cell", error.hint) from None
        if not math.isfinite(float(digits)):
            what = f"too large for a double: {written[:40]!r}"
            raise Unreadable(what, "a finite number in every cell")
        if column.unit and unit:
            what = f"the unit is given twice: {written[:40]!r}"
            raise Unreadable(what, f"numbers without a unit in a column of [{column.unit}]")
        return written

    return _each(name, column, read)


def _each(name: str, column: Column, read: Callable[[str], Any]) -> list[Any]:
    """All cells of a column as read; what cannot be read is said with its line and column."""
    values = []
    for cell, line in zip(column.cells, column.lines, strict=True):
        try:
            values.append(read(cell))
        except Unreadable as error:
            where = f"line {line}, column {name}: {error}"
            raise Unreadable(where, error.allowed, error.hint, line=line) from None
    return values


def with_point(cell: str, column: Column) -> str:
    """A number of a column with a decimal point; other texts as they are."""
    return cell.replace(",", ".", 1) if "," in column.decimal and _COMMA.match(cell) else cell


def label(cell: str) -> int | float | str:
    """A cell as a whole number, a finite number or a text."""
    if _WHOLE.match(cell):
        return int(cell)
    try:
        number = float(cell)
    except ValueError:
        return cell
    return number if math.isfinite(number) and "_" not in cell else cell


def values_of(name: str, column: Column, shape: "Shape") -> list[Any]:
    """The cells of a column as a case would write them at such a place. Raises Unreadable."""
    if shape.kind == "list":
        assert shape.item is not None
        parts = [cell.split(";") for cell in column.cells]
        flat = [part.strip() for cell in parts for part in cell]
        lines = [line for line, cell in zip(column.lines, parts, strict=True) for _ in cell]
        values = iter(values_of(name, column._replace(cells=flat, lines=lines), shape.item))
        return [[next(values) for _ in cell] for cell in parts]
    if shape.kind == "number":
        check_unit(name, column, shape.unit or "")
        numbers = numbers_of(name, column)
        return [f"{one} {column.unit}" if column.unit else label(one) for one in numbers]
    if column.unit:
        raise Unreadable(
            f"column {name} takes no unit, but has one: {column.unit[:40]!r}",
            "its name alone",
            line=column.head,
        )
    if shape.kind == "whole":
        return _each(name, column, lambda cell: _whole(with_point(cell, column)))
    return _each(name, column, _flag) if shape.kind == "flag" else list(column.cells)


def _whole(cell: str) -> int:
    """A whole number, also as 40.0."""
    digits = re.sub(r"\.0*\Z", "", cell)
    if not _WHOLE.match(digits):
        raise Unreadable(f"not a whole number: {cell[:40]!r}", "a whole number in every cell")
    return int(digits)


def _flag(cell: str) -> bool:
    if cell.lower() not in _FLAGS:
        raise Unreadable(f"found {cell[:40]!r}", "true or false")
    return _FLAGS[cell.lower()]
