"""Long tables in CSV files next to a case: read, checked, put where their file name stands."""

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from vibecalc.core.case.catalogues import attach_catalogue, attach_stock, catalogued
from vibecalc.core.case.csv_files import (
    Column,
    Columns,
    Unreadable,
    check_unit,
    excerpt,
    numbers_of,
    read_columns,
    some_cells,
    with_point,
)
from vibecalc.core.case.raw import Data, listed, nearest, table_at, tables_at
from vibecalc.core.case.row_files import LISTS, rows_of
from vibecalc.core.results.named import named
from vibecalc.errors import KeyPath, Problem

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
    for path, place, key in _named_tables(data, ()):
        try:
            columns = read_columns(folder, place[key])
            if path in LISTS:
                place[key] = rows_of(columns, path, place[key])
            else:
                place[key] = _table(columns, path)
        except Unreadable as error:
            problems.append(_problem(path, place[key], error, folder))
    for path, place in catalogued(data):
        try:
            attach_catalogue(place, folder)
        except Unreadable as error:
            key = error.key or "catalogue"
            problems.append(_problem((*path, key), str(place.get(key, "")), error, folder))
    for index, stock in tables_at(data, "optimisation", "stock"):
        if (
            isinstance(stock.get("catalogue"), str)
            and stock["catalogue"]
            and not stock.get("items")
        ):
            try:
                attach_stock(stock, folder)
            except Unreadable as error:
                path = ("optimisation", "stock", index, "catalogue")
                problems.append(_problem(path, stock["catalogue"], error, folder))
    problems += _of_subjects(data, folder)
    rows = data.get("reference_table")
    for index, row in enumerate(rows if isinstance(rows, list) else ()):
        if isinstance(row, dict) and isinstance(row.get("file"), str) and row["file"]:
            try:
                _attach_reference(row, folder)
            except Unreadable as error:
                path = ("reference_table", index, error.key or "file")
                problems.append(_problem(path, str(row.get(path[-1], "")), error, folder))
    return problems


def _of_subjects(data: Data, folder: Path) -> list[Problem]:
    """Problems of files that only a subject can read; the subjects are asked where one is named."""
    named_here = any(
        isinstance(row, dict) and isinstance(row.get("file"), str)
        for name, table in data.items()
        if name != "machine" and isinstance(table, dict)
        for rows in table.values()
        for row in (rows if isinstance(rows, list) else ())
    )
    if not named_here:
        return []
    from vibecalc.core.run.stage import subjects

    readers = {
        reader: None
        for subject in subjects().values()
        for path, reader in subject.files.items()
        if path[-1] in table_at(data, *path[:-1])
    }
    return [problem for reader in readers for problem in named(reader)(data, folder)]


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
        shape, unit, cells = shapes.get(name), column.unit, column.cells
        if shape is not None:  # a column that the schema does not know is shown by the schema
            if shape.kind == "whole":
                _check_whole(name, column)
            else:
                check_unit(name, column, shape.unit or "")
                cells = numbers_of(name, column)
        table[name] = [f"{cell} {unit}" if unit else _label(cell) for cell in cells]
    return table


def _check_whole(name: str, column: Column) -> None:
    if column.unit:
        raise Unreadable(f"column {name} is of whole numbers and has no unit", f"{name} alone")
    for cell, line in zip(column.cells, column.lines, strict=True):
        if not _WHOLE.match(cell):
            raise Unreadable(
                f"line {line}, column {name}: not a whole number: {cell[:40]!r}",
                "a whole number in every cell",
                line=line,
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
    column, entries = columns[chosen], columns[first]
    given = [place for place, value in enumerate(column.cells) if value]
    if not given:
        raise Unreadable(f"column {chosen} has no values", "a number in one line at least")
    cells = numbers_of(chosen, some_cells(column, given))
    if column.unit and row.get("unit", column.unit) != column.unit:
        raise Unreadable(
            f"column {chosen} is in {column.unit[:40]}, and unit = {str(row['unit'])[:40]!r}",
            "the unit in one of the two places",
        )
    if "uncertainty_column" in row:
        row["uncertainties"] = _uncertainties(row, columns, column, given)
    row["entry"] = [_entry(entries.cells[place], entries) for place in given]
    row["value"] = cells
    if column.unit:
        row["unit"] = column.unit
    row.pop("file")
    row.pop("column", None)
    row.pop("uncertainty_column", None)


def _uncertainties(row: Data, columns: Columns, values: Column, given: list[int]) -> list[str]:
    """What a column has next to the values, each with its unit where that is not theirs."""
    name = str(row["uncertainty_column"])
    if name not in columns:
        raise Unreadable(
            f"the file has no such column of uncertainties, but {listed(list(columns))}",
            "the name of one of them, without its unit",
            nearest(name, list(columns)),
            key="uncertainty_column",
        )
    column = columns[name]
    unit = "" if column.unit == values.unit else column.unit
    return [f"{cell} {unit}".strip() for cell in numbers_of(name, some_cells(column, given))]


def _entry(cell: str, column: Column) -> int | float | str:
    """A cell of entries: a number, also with a decimal comma, or the text as it stands."""
    found = _label(with_point(cell, column))
    return cell if isinstance(found, str) else found


def _label(cell: str) -> int | float | str:
    """A cell as a whole number, a finite number or a text."""
    if _WHOLE.match(cell):
        return int(cell)
    try:
        number = float(cell)
    except ValueError:
        return cell
    return number if math.isfinite(number) and "_" not in cell else cell


def _problem(path: KeyPath, name: str, error: Unreadable, folder: Path) -> Problem:
    line = f", line {error.line}: {excerpt(folder, name, error.line)}" if error.line else ""
    return Problem(
        path=path,
        message=f"{path[-1]}: {error}",
        found=repr(name[:80]) + line,
        allowed=error.allowed or "the name of a CSV file next to the case",
        hint=error.hint,
    )
