"""Files next to a case: tables in CSV and catalogues, read and put where their names stand.

A table of the schema whose keys are all lists of numbers may be given as the name of a CSV file:
its columns become the keys of the table, a unit stands in brackets behind the name of its column.
Some lists of tables may be a file as well, one line for each table (`row_files.py`). A coupling or
a stock takes its values from a catalogue: a TOML file of tables by name. Everything after this sees
the numbers only, so that hash, resolved case and studies need no file.
"""

import copy
import re
import tomllib
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

from vibecalc.core.case.csv_files import (
    Column,
    Unreadable,
    excerpt,
    label,
    numbers_of,
    read_columns,
    read_text,
    some_cells,
    values_of,
    with_point,
)
from vibecalc.core.case.fields import Table
from vibecalc.core.case.raw import Data, get_key, listed, nearest, table_at, tables_at
from vibecalc.core.case.row_files import LISTS, key_of, rows_of
from vibecalc.core.results.named import named
from vibecalc.errors import KeyPath, Problem, leaves

#: a text that may be meant as the name of a file
_FILE_NAME = re.compile(r"[^\n]*\.(csv|tsv|txt|dat|xlsx?|ods)\Z", re.IGNORECASE)


def attach_files(data: Data, folder: Path) -> list[Problem]:
    """Replace, in `data`, every file name that stands for a table by what the file holds.

    Returns the problems of the files; their places keep the name, for the schema to pass over.
    """
    problems: list[Problem] = []
    for path, holder, attach in _names(data):
        try:
            attach(holder, folder)
        except Unreadable as error:
            key = error.key or path[-1]
            name = str(holder.get(key, "") if isinstance(holder, dict) else holder[key])
            problems.append(_problem((*path[:-1], key), name, error, folder))
    return problems + _of_subjects(data, folder)


def _problem(path: KeyPath, name: str, error: Unreadable, folder: Path) -> Problem:
    line = f", line {error.line}: {excerpt(folder, name, error.line)}" if error.line else ""
    return Problem(
        path,
        f"{path[-1]}: {error}",
        repr(name[:80]) + line,
        error.allowed or "the name of a CSV file next to the case",
        error.hint,
    )


def _names(data: Data) -> Iterator[tuple[KeyPath, Any, Callable[[Any, Path], None]]]:
    """Places of the names of files, with the table that holds each and what fills that."""
    texts = [(path, text) for path, text in leaves(data) if isinstance(text, str)]
    for path, text in texts:  # where the schema has a table of columns
        if _FILE_NAME.match(text) and (path in LISTS or _columns_at(path)):
            yield path, get_key(data, path[:-1]), partial(_attach_table, path=path)
    shafts = ("machine", "shaft_line", "shafts")
    for place, shaft in tables_at(data, *shafts):
        coupling = table_at(shaft, "coupling")
        if _is_name(coupling.get("catalogue")) and _is_name(coupling.get("type")):
            yield (*shafts, place, "coupling", "catalogue"), coupling, _attach_catalogue
    for place, stock in tables_at(data, "optimisation", "stock"):
        if _is_name(stock.get("catalogue")) and not stock.get("items"):
            yield ("optimisation", "stock", place, "catalogue"), stock, _attach_stock
    for place, row in tables_at(data, "reference_table"):
        if _is_name(row.get("file")):
            yield ("reference_table", place, "file"), row, _attach_reference


def _is_name(value: Any) -> bool:
    return isinstance(value, str) and bool(value)


def _of_subjects(data: Data, folder: Path) -> list[Problem]:
    """Problems of files that only a subject can read; the subjects are asked where one is named."""
    named_here = any(
        isinstance(row.get("file"), str)
        for name, table in data.items()
        if name != "machine" and isinstance(table, dict)
        for rows in table
        for _, row in tables_at(table, rows)
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


# ----------------------------------------------------------------------------
# Tables of columns, and lists of tables.
# ----------------------------------------------------------------------------


def columns_of(table: type[Table]) -> dict[str, Any]:
    """Column -> shape of its numbers, if the table has nothing but columns of numbers."""
    from vibecalc.core.case.walk import keys_of, shape_of

    columns = {name: shape_of(field).item for name, field in keys_of(table).items()}
    numbers = all(one is not None and one.kind in ("number", "whole") for one in columns.values())
    return columns if numbers else {}


def _columns_at(path: KeyPath) -> dict[str, Any]:
    from vibecalc.core.case.walk import shape_at

    shape = shape_at(path)
    return columns_of(shape.table) if shape is not None and shape.table is not None else {}


def _attach_table(holder: Any, folder: Path, path: KeyPath) -> None:
    """Put what a file holds in place of its name, as a case would write it."""
    columns = read_columns(folder, holder[path[-1]])
    if path in LISTS:
        holder[path[-1]] = rows_of(columns, path, holder[path[-1]])
    else:
        shapes = _columns_at(path)  # a column that the schema does not know is shown by the schema
        table: dict[str, Any] = {}
        for name, column in columns.items():
            key = key_of(name)
            key = key if key in shapes and key not in {**columns, **table} else name
            table[key] = values_of(name, column, shapes[key]) if key in shapes else column.cells
        holder[path[-1]] = table


# ----------------------------------------------------------------------------
# Catalogues: TOML files of tables by name, one of which a table takes over, and stocks.
# ----------------------------------------------------------------------------


def _tables(folder: Path, name: str, like: str) -> Data:
    """The tables of a catalogue by their names."""
    text = read_text(folder, name, like, "*.toml")
    try:
        entries = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise Unreadable(f"the file is not TOML: {error}") from None
    entries = {name: one for name, one in entries.items() if isinstance(one, dict)}
    if not entries:
        raise Unreadable("the catalogue has no tables", "a table for each type, as ['type 1']")
    return entries


def _attach_catalogue(table: Data, folder: Path) -> None:
    """Fill in what the catalogue says and the table does not; takes away the name of the file."""
    entries = _tables(folder, table["catalogue"], "a name like couplings.toml")
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


def _attach_stock(stock: Data, folder: Path) -> None:
    """Put what a catalogue offers in place of its name: tables of TOML, or lines of a CSV file.

    The first column has the names of the items, each further one a key that they settle.
    """
    name = stock["catalogue"]
    if name.lower().endswith(".toml"):
        values = _tables(folder, name, "a name like mounts.toml or mounts.csv")
        items = [{"name": one, "values": table} for one, table in values.items()]
    else:
        columns = read_columns(folder, name)
        first, *keys = columns
        if not keys:
            raise Unreadable(
                "the file has only one column", "a column of names, then one for each key"
            )
        cells = {key: _with_unit(key, columns[key]) for key in keys}
        items = [
            {"name": item, "values": {key: cells[key][place] for key in keys}}
            for place, item in enumerate(columns[first].cells)
        ]
    stock["items"] = items
    del stock["catalogue"]


def _with_unit(name: str, column: Column) -> list[str]:
    """The cells of a column with the unit of it; names and numbers without one as they are."""
    if column.unit:
        return [f"{cell} {column.unit}" for cell in numbers_of(name, column)]
    return [with_point(cell, column) for cell in column.cells]


# ----------------------------------------------------------------------------
# Reference tables: entries in the first column, values in another one.
# ----------------------------------------------------------------------------


def _attach_reference(row: Data, folder: Path) -> None:
    twice = [key for key in ("entry", "value") if key in row]
    if twice:
        raise Unreadable(f"{twice[0]} and file are mutually exclusive", "one of the two")
    columns = read_columns(folder, row["file"])
    first, *others = columns
    if not others:
        raise Unreadable("the file has only one column", "a column of entries, then values")
    if len(others) > 1 and "column" not in row:
        raise Unreadable(
            "the file has several columns of values", f"column = one of {listed(others)}"
        )
    chosen = _chosen(row, "column", "values", others) if "column" in row else others[0]
    column, entries = columns[chosen], columns[first]
    given = [place for place, value in enumerate(column.cells) if value]
    if not given:
        raise Unreadable(f"column {chosen} has no values", "at least one number")
    if column.unit and row.get("unit", column.unit) != column.unit:
        raise Unreadable(
            f"column {chosen} is in {column.unit[:40]}, and unit = {str(row['unit'])[:40]!r}",
            "the unit in one of the two places",
        )
    made = {
        "value": numbers_of(chosen, some_cells(column, given)),
        "entry": [_entry(entries.cells[place], entries) for place in given],
    }
    if "uncertainty_column" in row:
        name = _chosen(row, "uncertainty_column", "uncertainties", list(columns))
        unit = "" if columns[name].unit == column.unit else columns[name].unit
        cells = numbers_of(name, some_cells(columns[name], given))
        made["uncertainties"] = [f"{cell} {unit}".strip() for cell in cells]
    row |= made
    if column.unit:
        row["unit"] = column.unit
    for key in ("file", "column", "uncertainty_column"):
        row.pop(key, None)


def _chosen(row: Data, key: str, what: str, known: list[str]) -> str:
    """The name of a column that a key of the row says."""
    name = str(row[key])
    if name not in known:
        raise Unreadable(
            f"the file has no such column of {what}, but {listed(known)}",
            "the name of one of them, without its unit",
            nearest(name, known),
            key=key,
        )
    return name


def _entry(cell: str, column: Column) -> int | float | str:
    """A cell of entries: a number, also with a decimal comma, or the text as it stands."""
    found = label(with_point(cell, column))
    return cell if isinstance(found, str) else found
