"""A table in a CSV file: columns with names and units, cells as written."""

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from vibecalc.case.raw import nearest

LARGEST_FILE = 2_000_000
MOST_ROWS, MOST_COLUMNS = 20_000, 200
LONGEST_UNIT = 80


class Column(NamedTuple):
    """Unit, cells as written, and the line of the file that each of them stands in."""

    unit: str
    cells: list[str]
    lines: list[int]


Columns = dict[str, Column]


class Unreadable(Exception):
    """What is wrong with a file, what would be right, a hint, and the key that says it."""

    def __init__(self, message: str, allowed: str = "", hint: str = "", key: str = ""):
        super().__init__(message)
        self.allowed, self.hint, self.key = allowed, hint, key


def read_columns(folder: Path, name: str) -> Columns:
    """Columns of a CSV file in `folder`, in their order. A line that begins with # is none.

    Raises Unreadable for a file that is not there, not in the folder, or no table.
    """
    text = _read(folder, name)
    kept = [
        (number, line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.startswith("#")
    ]
    if not kept:
        raise Unreadable("the file is empty", "a line of column names, then lines of values")
    reader = csv.reader((line for _, line in kept), skipinitialspace=True)
    rows: list[list[str]] = []
    lines: list[int] = []
    try:
        for row in reader:
            rows.append([cell.strip() for cell in row])
            lines.append(kept[reader.line_num - 1][0])
    except csv.Error as error:
        raise Unreadable(f"the file is no CSV: {error}") from None
    if len(rows) < 2:
        raise Unreadable(
            "the file has a line of names and no values", "lines of values below the names"
        )
    if len(rows) - 1 > MOST_ROWS:
        raise Unreadable(f"the file has {len(rows) - 1} lines of values", f"up to {MOST_ROWS}")
    head = _head(rows[0], kept[0][1])
    for row, line in zip(rows[1:], lines[1:], strict=True):
        if len(row) != len(head):
            raise Unreadable(
                f"line {line} of the file has {len(row)} cell{'' if len(row) == 1 else 's'}",
                f"{len(head)}, as in the line of names",
                _separator(kept[0][1]),
            )
    return {
        column: Column(unit, [row[place] for row in rows[1:]], lines[1:])
        for place, (column, unit) in enumerate(head)
    }


def _read(folder: Path, name: str) -> str:
    path = folder / name
    try:
        inside = path.resolve().is_relative_to(folder.resolve())
        if Path(name).is_absolute() or not inside:
            raise Unreadable("a table has to lie in the folder of its case", "a name like gas.csv")
        if path.is_dir():
            raise Unreadable("this is a folder")
        if path.exists() and not path.is_file():
            raise Unreadable("this is no ordinary file")
        if path.stat().st_size > LARGEST_FILE:
            raise Unreadable(
                f"the file is larger than {LARGEST_FILE / 1e6:g} MB", f"up to {MOST_ROWS} lines"
            )
        with path.open("rb") as file:
            return file.read(LARGEST_FILE + 1).decode("utf-8-sig")
    except FileNotFoundError:
        raise Unreadable("there is no such file", hint=_similar(folder, name)) from None
    except UnicodeDecodeError:
        raise Unreadable("the file is not a text in UTF-8") from None
    except OSError as error:
        raise Unreadable(f"the file cannot be read: {(error.strerror or '').lower()}") from None
    except (ValueError, RuntimeError):  # a null character; links in a circle
        raise Unreadable("this is no name of a file") from None


def _head(cells: Sequence[str], line: str) -> list[tuple[str, str]]:
    if len(cells) > MOST_COLUMNS:
        raise Unreadable(f"the file has {len(cells)} columns", f"up to {MOST_COLUMNS}")
    names: list[tuple[str, str]] = []
    for place, cell in enumerate(cells, start=1):
        name, bracket, rest = cell.partition("[")
        unit = rest.removesuffix("]")
        if not name.strip():
            raise Unreadable(f"column {place} has no name", "a name, or a name and a [unit]")
        odd = unit == rest or "[" in unit or "]" in unit or len(unit) > LONGEST_UNIT
        if bracket and odd:
            raise Unreadable(
                f"the name of column {place} cannot be read: {cell[:40]!r}",
                "a name, or a name and a unit as in 'pressure [bar]'",
            )
        if any(name.strip() == known for known, _ in names):
            raise Unreadable(
                f"two columns are named {name.strip()[:40]!r}", "each name once", _separator(line)
            )
        names.append((name.strip(), unit.strip()))
    return names


def _separator(line: str) -> str:
    other = [word for sign, word in ((";", "semicolons"), ("\t", "tabs")) if sign in line]
    return f"cells are parted by commas, not by {other[0]}" if other else ""


def _similar(folder: Path, name: str) -> str:
    try:
        return nearest(name, sorted(entry.name for entry in folder.glob("*.csv")))
    except OSError:
        return ""
