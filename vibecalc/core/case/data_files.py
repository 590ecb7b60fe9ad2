"""Long tables in CSV files next to a case: read, checked, put where their file name stands."""

import copy
import csv
import math
import re
import tomllib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from vibecalc.core.case.raw import Data, listed, nearest, tables_at
from vibecalc.errors import KeyPath, Problem, UnitError
from vibecalc.units import convert, split_number

if TYPE_CHECKING:
    from vibecalc.core.case.walk import Shape

# ----------------------------------------------------------------------------
# A table in a CSV file: columns with names and units, cells as written.
# ----------------------------------------------------------------------------

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
    lines_with_data = [
        (number, line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.startswith("#")
    ]
    if not lines_with_data:
        raise Unreadable("the file is empty", "a line of column names, then lines of values")
    reader = csv.reader((line for _, line in lines_with_data), skipinitialspace=True)
    rows: list[list[str]] = []
    lines: list[int] = []
    try:
        for row in reader:
            rows.append([cell.strip() for cell in row])
            lines.append(lines_with_data[reader.line_num - 1][0])
    except csv.Error as error:
        raise Unreadable(f"the file is no CSV: {error}") from None
    if len(rows) < 2:
        raise Unreadable(
            "the file has a line of names and no values", "lines of values below the names"
        )
    if len(rows) - 1 > MOST_ROWS:
        raise Unreadable(f"the file has {len(rows) - 1} lines of values", f"up to {MOST_ROWS}")
    head = _head(rows[0], lines_with_data[0][1])
    for row, line in zip(rows[1:], lines[1:], strict=True):
        if len(row) != len(head):
            raise Unreadable(
                f"line {line} of the file has {len(row)} cell{'' if len(row) == 1 else 's'}",
                f"{len(head)}, as in the line of names",
                _separator(lines_with_data[0][1]),
            )
    return {
        column: Column(unit, [row[place] for row in rows[1:]], lines[1:])
        for place, (column, unit) in enumerate(head)
    }


def _read(
    folder: Path, name: str, example: str = "a name like gas.csv", like: str = "*.csv"
) -> str:
    path = folder / name
    try:
        inside = path.resolve().is_relative_to(folder.resolve())
        if Path(name).is_absolute() or not inside:
            raise Unreadable("a table has to lie in the folder of its case", example)
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
        raise Unreadable("there is no such file", hint=_similar(folder, name, like)) from None
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
        name, bracket, bracketed = cell.partition("[")
        unit = bracketed.removesuffix("]")
        if not name.strip():
            raise Unreadable(f"column {place} has no name", "a name, or a name and a [unit]")
        odd = unit == bracketed or "[" in unit or "]" in unit or len(unit) > LONGEST_UNIT
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


def _similar(folder: Path, name: str, like: str) -> str:
    try:
        there = (folder / name).parent.glob(like)
        return nearest(Path(name).name, sorted(entry.name for entry in there))
    except OSError:
        return ""


# ----------------------------------------------------------------------------
# Long tables in CSV files next to a case: read, and put where their file name stands.
#
# A table of the schema whose keys are all lists of numbers may be given as the name of a CSV file:
# its columns become the keys of the table, a unit stands in brackets behind the name of its column.
# Some lists of tables may be a file as well, one line for each table (`row_files.py`).
# Everything after this sees the numbers only, so that hash, resolved case and studies need no file.
# ----------------------------------------------------------------------------

#: a text that may be meant as the name of a file
_FILE_NAME = re.compile(r"[^\n]*\.(csv|tsv|txt|dat|xlsx?|ods)\Z", re.IGNORECASE)
_WHOLE = re.compile(r"[+-]?\d{1,18}\Z")


def attach_files(data: Data, folder: Path) -> list[Problem]:
    """Replace, in `data`, every file name that stands for a table by what the file holds.

    Returns the problems of the files; their places keep the name, for the schema to pass over.
    """
    problems: list[Problem] = []
    for path, place in _catalogued(data):
        try:
            _attach_catalogue(place, folder)
        except Unreadable as error:
            key = error.key or "catalogue"
            problems.append(_problem((*path, key), str(place.get(key, "")), error))
    for path, place, key in _named_tables(data, ()):
        try:
            columns = read_columns(folder, place[key])
            place[key] = rows_of(columns, path) if path in LISTS else _table(columns, path)
        except Unreadable as error:
            problems.append(_problem(path, place[key], error))
    rows = data.get("reference_table")
    for index, row in enumerate(rows if isinstance(rows, list) else ()):
        if isinstance(row, dict) and isinstance(row.get("file"), str) and row["file"]:
            try:
                _attach_reference(row, folder)
            except Unreadable as error:
                path = ("reference_table", index, error.key or "file")
                problems.append(_problem(path, str(row.get(path[-1], "")), error))
    return problems


def _named_tables(data: Any, above: KeyPath) -> Iterator[tuple[KeyPath, Any, Any]]:
    """Places of texts where the schema has a table of columns: path, what holds it, its key."""
    if not isinstance(data, dict | list):
        return
    entries = data.items() if isinstance(data, dict) else enumerate(data)
    for key, value in list(entries):
        path = (*above, key)
        if isinstance(value, str):
            if _FILE_NAME.match(value) and (path in LISTS or _columns_of(path)):
                yield path, data, key
        else:
            yield from _named_tables(value, path)


def _columns_of(path: KeyPath) -> dict[str, Any]:
    """Column -> shape of its numbers, if the schema has a table of nothing but columns there."""
    from vibecalc.core.case.walk import keys_of, shape_at, shape_of

    shape = shape_at(path)
    if shape is None or shape.table is None or shape.kind != "table":
        return {}
    columns = {name: shape_of(field).item for name, field in keys_of(shape.table).items()}
    numbers = all(
        item is not None and item.kind in ("number", "whole") for item in columns.values()
    )
    return columns if numbers else {}


def _table(columns: Columns, path: KeyPath) -> dict[str, list[Any]]:
    """The columns as a case would write them, each number with its unit."""
    shapes, table = _columns_of(path), {}
    for name, column in columns.items():
        shape = shapes.get(name)
        if shape is not None:  # a column that the schema does not know is shown by the schema
            if shape.kind == "whole":
                _check_whole(name, column)
            else:
                check_unit(name, column.unit, shape.unit or "")
                check_numbers(name, column)
        unit = column.unit
        table[name] = [f"{cell} {unit}" if unit else _label(cell) for cell in column.cells]
    return table


def _check_whole(name: str, column: Column) -> None:
    if column.unit:
        raise Unreadable(f"column {name} is of whole numbers and has no unit", f"{name} alone")
    for cell, line in zip(column.cells, column.lines, strict=True):
        if not _WHOLE.match(cell):
            raise Unreadable(
                f"line {line}, column {name}: not a whole number: {cell[:40]!r}",
                "a whole number in every cell",
            )


def check_unit(name: str, unit: str, wanted: str) -> None:
    """Raise Unreadable where the unit of a column does not convert to the wanted one."""
    if not unit:
        return
    try:
        convert(1.0, unit, wanted)
    except UnitError as error:
        found = f", {error.found}" if error.message == "wrong dimension" else ""
        raise Unreadable(
            f"column {name}, unit {unit[:40]!r}: {error.message}{found}",
            error.allowed or (f"a unit that converts to {wanted}" if wanted else "no unit"),
            error.hint,
        ) from None


def check_numbers(name: str, column: Column) -> None:
    """Raise Unreadable at the first cell of a column that is no finite number."""
    for cell, line in zip(column.cells, column.lines, strict=True):
        try:
            number, cell_unit = split_number(cell)
            finite = math.isfinite(float(number))
        except UnitError as error:
            what = f"{error.message}: {cell[:40]!r}" if cell else "no number"
            raise Unreadable(
                f"line {line}, column {name}: {what}", "a finite number in every cell", error.hint
            ) from None
        if not finite:
            raise Unreadable(
                f"line {line}, column {name}: too large for a double: {cell[:40]!r}",
                "a finite number in every cell",
            )
        if column.unit and cell_unit:
            raise Unreadable(
                f"line {line}, column {name}: the unit stands twice: {cell[:40]!r}",
                f"numbers alone in a column of [{column.unit}]",
            )


def _attach_reference(row: Data, folder: Path) -> None:
    twice = [key for key in ("entry", "value") if key in row]
    if twice:
        raise Unreadable(f"{twice[0]} and file exclude each other", "one way or the other")
    columns = read_columns(folder, row["file"])
    first, *others = columns
    if not others:
        raise Unreadable("there is one column only", "a column of entries, then values")
    chosen = row.get("column", others[0] if len(others) == 1 else None)
    if chosen is None:
        raise Unreadable("which column of the file?", f"column = one of {listed(others)}")
    if chosen not in others:
        raise Unreadable(
            f"the file has no such column of values, but {listed(others)}",
            "the name of one of them, without its unit",
            nearest(str(chosen), others),
            key="column",
        )
    column, entries = columns[chosen], columns[first].cells
    given = [place for place, value in enumerate(column.cells) if value]
    if not given:
        raise Unreadable(f"column {chosen} has no values", "a number in one line at least")
    cells = [column.cells[place] for place in given]
    check_numbers(chosen, Column(column.unit, cells, [column.lines[place] for place in given]))
    if column.unit and row.get("unit", column.unit) != column.unit:
        raise Unreadable(
            f"column {chosen} is in {column.unit[:40]}, and unit = {str(row['unit'])[:40]!r}",
            "the unit in one of the two places",
        )
    row["entry"] = [_label(entries[place]) for place in given]
    row["value"] = cells
    if column.unit:
        row["unit"] = column.unit
    row.pop("file")
    row.pop("column", None)


def _label(cell: str) -> int | float | str:
    """A cell as a whole number, a finite number or a text."""
    if _WHOLE.match(cell):
        return int(cell)
    try:
        number = float(cell)
    except ValueError:
        return cell
    return number if math.isfinite(number) and "_" not in cell else cell


def _problem(path: KeyPath, name: str, error: Unreadable) -> Problem:
    return Problem(
        path=path,
        message=f"{path[-1]}: {error}",
        found=repr(name[:80]),
        allowed=error.allowed or "the name of a CSV file next to the case",
        hint=error.hint,
    )


# ----------------------------------------------------------------------------
# Catalogues: TOML files of tables by their names, one of which a table of a case takes over.
# ----------------------------------------------------------------------------

#: lists of the schema, and the table in each of their entries that may be of a catalogue
CATALOGUED: tuple[tuple[KeyPath, str], ...] = ((("machine", "shaft_line", "shafts"), "coupling"),)


def _catalogued(data: Data) -> Iterator[tuple[KeyPath, Data]]:
    """Tables that name a catalogue and an entry of it, with their paths."""
    for path, key in CATALOGUED:
        for place, entry in tables_at(data, *map(str, path)):
            table = entry.get(key)
            if not isinstance(table, dict):
                continue
            if all(isinstance(table.get(one), str) and table[one] for one in ("catalogue", "type")):
                yield (*path, place, key), table


def _attach_catalogue(table: Data, folder: Path) -> None:
    """Fill in what the catalogue says and the table does not; takes away the name of the file."""
    text = _read(folder, table["catalogue"], "a name like couplings.toml", "*.toml")
    try:
        entries = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise Unreadable(f"the file is no TOML: {error}") from None
    entries = {name: one for name, one in entries.items() if isinstance(one, dict)}
    if not entries:
        raise Unreadable("the catalogue has no tables", "a table for each type, as ['type 1']")
    found = entries.get(table["type"])
    if found is None:
        names = list(entries)
        raise Unreadable(
            f"the catalogue has no such type, but {listed(names)}",
            "the name of one of its tables",
            nearest(table["type"], names),
            key="type",
        )
    nested = next((key for key in ("catalogue", "type") if key in found), None)
    if nested is not None:
        raise Unreadable(f"the entry of the catalogue has a {nested} of its own", "its values")
    del table["catalogue"]
    for key, value in found.items():
        table.setdefault(key, copy.deepcopy(value))


# ----------------------------------------------------------------------------
# Long lists of tables in CSV files next to a case: one line for each station or shaft.
#
# A column is a key; a cell left empty is a key left out; names of a list stand in one cell, with
# semicolons between them.
# ----------------------------------------------------------------------------

#: lists of the schema that may be the name of a file
LISTS: tuple[KeyPath, ...] = (
    ("machine", "shaft_line", "stations"),
    ("machine", "shaft_line", "shafts"),
)


def keys_of_rows(path: KeyPath) -> dict[str, "Shape"]:
    """Key -> shape of what a column may hold, of a list that may be a file; otherwise nothing."""
    if path not in LISTS:
        return {}
    from vibecalc.core.case.walk import keys_of, shape_at, shape_of

    shape = shape_at(path)
    assert shape is not None and shape.item is not None and shape.item.table is not None
    fields = {key: shape_of(field) for key, field in keys_of(shape.item.table).items()}
    return {key: one for key, one in fields.items() if one.kind != "table"}


def rows_of(columns: Columns, path: KeyPath) -> list[dict[str, Any]]:
    """The lines of a file as tables of the list at `path`. Raises Unreadable."""

    shapes = keys_of_rows(path)
    strange = next((name for name in columns if name not in shapes), None)
    if strange is not None:
        raise Unreadable(
            f"column {strange[:40]!r} is no key of {path[-1]}",
            listed(list(shapes)),
            nearest(strange, list(shapes)),
        )
    count = max(len(column.cells) for column in columns.values())
    rows: list[dict[str, Any]] = [{} for _ in range(count)]
    for name, column in columns.items():
        shape = shapes[name]
        if shape.kind == "number":
            check_unit(name, column.unit, shape.unit or "")
        filled = [place for place, cell in enumerate(column.cells) if cell]
        cells, lines = [column.cells[p] for p in filled], [column.lines[p] for p in filled]
        if shape.kind == "number":
            check_numbers(name, Column(column.unit, cells, lines))
        for place, cell in zip(filled, cells, strict=True):
            rows[place][name] = _value(cell, column.unit, shape)
    return rows


def _value(cell: str, unit: str, shape: "Shape") -> Any:
    if shape.kind == "number":
        return f"{cell} {unit}".strip()
    if shape.kind == "list":
        return [part.strip() for part in cell.split(";")]
    return cell
