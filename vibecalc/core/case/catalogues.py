"""Catalogues next to a case: TOML files of tables by name, one of which a table takes over."""

import copy
import tomllib
from collections.abc import Iterator
from pathlib import Path

from vibecalc.core.case.csv_files import Unreadable, numbers_of, read_columns, read_text, with_point
from vibecalc.core.case.raw import Data, listed, nearest, tables_at
from vibecalc.errors import KeyPath

#: lists of the schema, and the table in each of their entries that may be of a catalogue
CATALOGUED: tuple[tuple[KeyPath, str], ...] = ((("machine", "shaft_line", "shafts"), "coupling"),)


def catalogued(data: Data) -> Iterator[tuple[KeyPath, Data]]:
    """Tables that name a catalogue and an entry of it, with their paths."""
    for path, key in CATALOGUED:
        for place, entry in tables_at(data, *map(str, path)):
            table = entry.get(key)
            if not isinstance(table, dict):
                continue
            if all(isinstance(table.get(one), str) and table[one] for one in ("catalogue", "type")):
                yield (*path, place, key), table


def _tables(folder: Path, name: str, like: str) -> Data:
    """The tables of a catalogue by their names."""
    text = read_text(folder, name, like, "*.toml")
    try:
        entries = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise Unreadable(f"the file is no TOML: {error}") from None
    entries = {name: one for name, one in entries.items() if isinstance(one, dict)}
    if not entries:
        raise Unreadable("the catalogue has no tables", "a table for each type, as ['type 1']")
    return entries


def attach_stock(stock: Data, folder: Path) -> None:
    """Put what a catalogue offers in place of its name: tables of TOML, or lines of a CSV file."""
    name = stock["catalogue"]
    if name.lower().endswith(".toml"):
        tables = _tables(folder, name, "a name like mounts.toml or mounts.csv")
        stock["items"] = [{"name": one, "values": values} for one, values in tables.items()]
    else:
        stock["items"] = _lines(folder, name)
    del stock["catalogue"]


def _lines(folder: Path, name: str) -> list[Data]:
    """The items of a CSV file: their names in the first column, the keys that they settle next."""
    columns = read_columns(folder, name)
    first, *keys = columns
    if not keys:
        raise Unreadable("there is one column only", "a column of names, then one for each key")
    values = {
        key: [f"{cell} {column.unit}" for cell in numbers_of(key, column)]
        if column.unit
        else [with_point(cell, column) for cell in column.cells]
        for key, column in columns.items()
        if key != first
    }
    return [
        {"name": item, "values": {key: values[key][place] for key in keys}}
        for place, item in enumerate(columns[first].cells)
    ]


def attach_catalogue(table: Data, folder: Path) -> None:
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
