"""Long lists of tables in CSV files next to a case: one line for each station, shaft or gear."""

import csv
import io
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from vibecalc.core.case.csv_files import (
    NO_UNIT,
    Column,
    Columns,
    Unreadable,
    columns_of,
    some_cells,
    values_of,
)
from vibecalc.core.case.raw import Data, listed, nearest, table_at
from vibecalc.core.results.visible import text_cell
from vibecalc.errors import KeyPath, Problem, UsageError

if TYPE_CHECKING:
    from vibecalc.core.case.walk import Shape

# ----------------------------------------------------------------------------
# Long lists of tables in CSV files next to a case: one line for each station, shaft or gear.
#
# A column is a key, in any order, capitals and blanks apart ("Outer diameter [mm]"); its unit
# stands in square or round brackets. Keys of a table below (a section) are columns, too, and lists
# of two have a column for each. A cell left empty is a key left out; names of a list stand in one
# cell, with semicolons between them.
# ----------------------------------------------------------------------------

#: lists of the schema that may be the name of a file
LISTS: tuple[KeyPath, ...] = (
    ("machine", "shaft_line", "stations"),
    ("machine", "shaft_line", "shafts"),
    ("machine", "shaft_line", "gears"),
)
#: columns of lists of two
PAIRS = {"between": ("from", "to"), "teeth": ("teeth_from", "teeth_to")}
_UNIT_BEHIND = re.compile(r"([^()]+)\((.{1,80})\)\Z")


class Place(NamedTuple):
    """Where the cells of a column stand in the table of their row, and what they may be."""

    keys: KeyPath
    shape: "Shape"


def columns_of_rows(path: KeyPath) -> dict[str, Place]:
    """Places of the columns that a list may have as a file, by name; {} for other lists."""
    if path not in LISTS:
        return {}
    from vibecalc.core.case.walk import keys_of, shape_at, shape_of

    shape = shape_at(path)
    assert shape is not None and shape.item is not None and shape.item.table is not None
    found: dict[str, Place] = {}
    below: dict[str, Place] = {}
    for key, field in keys_of(shape.item.table).items():
        one = shape_of(field)
        for name, inner in keys_of(one.table).items() if one.table else ():
            if _plain(shape_of(inner)):
                below[f"{key}.{name}"] = Place((key, name), shape_of(inner))
        if _plain(one):
            found[key] = Place((key,), one)
        for place, name in enumerate(PAIRS.get(key, ())):
            assert one.item is not None
            found[name] = Place((key, place), one.item)
    for place_of in below.values():  # of two tables with such a key, that of the first
        found.setdefault(str(place_of.keys[1]), place_of)
    return found | below


def _plain(shape: "Shape") -> bool:
    """Whether a cell can hold it."""
    item = shape.item if shape.kind == "list" else shape
    return item is not None and item.kind in ("number", "whole", "text", "choice", "flag")


class Rows(list[dict[str, Any]]):
    """Tables of a list that stands in a file, with its name and the line of each."""

    def __init__(self, rows: Iterable[dict[str, Any]], file: str, lines: Sequence[int]):
        super().__init__(rows)
        self.file, self.lines = file, lines


def with_line(problem: Problem, files: Mapping[KeyPath, Rows]) -> Problem:
    """A problem of a table that stands in one of `files`, with its line there."""
    for depth in range(1, len(problem.path)):
        rows, place = files.get(problem.path[:depth]), problem.path[depth]
        if rows is not None and isinstance(place, int) and place < len(rows.lines):
            line = f"line {rows.lines[place]} of {rows.file!r}"
            return problem._replace(found=f"{problem.found}, {line}" if problem.found else line)
    return problem


def files_of_rows(data: Data) -> dict[KeyPath, Rows]:
    """The lists of a case that stand in files, by their path."""
    found = {path: table_at(data, *path[:-1]).get(path[-1]) for path in LISTS}
    return {path: rows for path, rows in found.items() if isinstance(rows, Rows)}


def rows_of(columns: Columns, path: KeyPath, file: str) -> Rows:
    """The lines of a file as tables of the list at `path`. Raises Unreadable."""
    known = columns_of_rows(path)
    placed = [_named(name, column) for name, column in columns.items()]
    seen: dict[KeyPath, str] = {}
    for name, column in placed:
        key = key_of(name)
        if key not in known:
            raise Unreadable(
                f"column {name[:40]!r} is no key of {path[-1]}",
                listed([one for one in known if "." not in one]),
                nearest(key, list(known)),
                line=column.head,
            )
        keys = known[key].keys
        twice = [one for one in seen if one == keys[: len(one)] or keys == one[: len(keys)]]
        if twice:
            raise Unreadable(
                f"columns {seen[twice[0]][:40]!r} and {name[:40]!r} mean the same",
                "one of the two",
                line=column.head,
            )
        seen[keys] = name
    _check_pairs({key_of(name): column for name, column in placed}, known)
    count = max(len(column.cells) for column in columns.values())
    rows: list[dict[str, Any]] = [{} for _ in range(count)]
    for name, column in placed:
        place_of = known[key_of(name)]
        filled = [place for place, cell in enumerate(column.cells) if cell]
        cells = values_of(name, some_cells(column, filled), place_of.shape)
        for place, cell in zip(filled, cells, strict=True):
            _put(rows[place], place_of.keys, cell)
    return Rows(rows, file, next(iter(columns.values())).lines)


def _named(name: str, column: Column) -> tuple[str, Column]:
    """The name of a column alone, and the column with a unit from round brackets."""
    behind = None if column.unit else _UNIT_BEHIND.match(name)
    if not behind:
        return name, column
    unit = behind[2].strip()
    return behind[1].strip(), column._replace(unit="" if unit in NO_UNIT else unit)


def key_of(name: str) -> str:
    """The key that the name of a column means."""
    return re.sub(r"[\s-]+", "_", name.lower())


def _check_pairs(columns: Columns, known: dict[str, Place]) -> None:
    """Both columns of a list of two are there, and filled in the same lines."""
    for key, names in PAIRS.items():
        there = [name for name in names if name in columns]
        if not there or names[0] not in known:
            continue
        if len(there) == 1:
            other = names[1 - names.index(there[0])]
            raise Unreadable(
                f"column {there[0]!r} without {other!r}",
                f"both, or one column {key!r} with both and a semicolon between them",
                line=columns[there[0]].head,
            )
        first, second = (columns[name] for name in names)
        for one, other, line in zip(first.cells, second.cells, first.lines, strict=True):
            if bool(one) != bool(other):
                empty = names[bool(one)]
                raise Unreadable(
                    f"line {line}, column {empty}: an empty cell", f"{key} is of two", line=line
                )


def _put(row: dict[str, Any], keys: KeyPath, value: Any) -> None:
    """Set what stands at some keys of a row; tables and lists of two are made on the way."""
    if len(keys) == 1:
        row[str(keys[0])] = value
        return
    inner: Any = row.setdefault(str(keys[0]), [None, None] if keys[1] in (0, 1) else {})
    inner[keys[1]] = value


# ----------------------------------------------------------------------------
# The other way: tables of a list as a CSV file.
# ----------------------------------------------------------------------------


def text_of_rows(path: KeyPath, rows: Sequence[Mapping[str, Any]]) -> tuple[str, list[str]]:
    """A CSV file that reads as these tables, and the keys that no cell can hold.

    `rows` are tables in SI as a validated case has them, without what is left out. Raises
    UsageError for texts that a cell would not give back, as a name that begins with #.
    """
    places = columns_of_rows(path)
    names = {place.keys: name for name, place in reversed(places.items())}
    wanted: list[dict[str, Any]] = []
    table: list[dict[str, str]] = []
    left: set[str] = set()
    for row in rows:
        cells: dict[str, str] = {}
        reads: dict[str, Any] = {}
        for keys, value in _leaves(row):
            name = names.get(keys)
            cell = None if name is None else _cell(value, places[name].shape)
            if name is None or cell is None:
                left.add(".".join(map(str, keys)))
                continue
            cells[name] = cell[0]
            _put(reads, keys, cell[1])
        table.append(cells)
        wanted.append(reads)
    used = [name for name in places if any(name in cells for cells in table)]
    units = [places[name].shape.unit for name in used]
    text = io.StringIO()
    write = csv.writer(text, lineterminator="\n").writerow
    write([f"{name} [{unit}]" if unit else name for name, unit in zip(used, units, strict=True)])
    for cells in table:
        write([text_cell(cells.get(name, "")) for name in used])
    if list(rows_of(columns_of(text.getvalue()), path, "")) != wanted:
        raise UsageError(
            f"{path[-1]} have a name that a CSV file does not give back: without # at its begin, "
            "blanks at its ends, and semicolons where there are several names"
        )
    return text.getvalue(), sorted(left)


def _leaves(row: Mapping[str, Any]) -> Iterator[tuple[KeyPath, Any]]:
    for key, value in row.items():
        if isinstance(value, Mapping):
            yield from (((key, name), one) for name, one in value.items())
        elif key in PAIRS and isinstance(value, Sequence) and len(value) == 2:
            yield from (((key, place), one) for place, one in enumerate(value))
        else:
            yield (key,), value


def _cell(value: Any, shape: "Shape") -> tuple[str, Any] | None:
    """A value as the text of a cell and as it is read back; None for what is no cell."""
    if shape.kind == "list" and shape.item is not None and isinstance(value, Sequence):
        parts = [part for one in value if (part := _cell(one, shape.item)) is not None]
        texts, read = [part[0] for part in parts], [part[1] for part in parts]
        return ("; ".join(texts), read) if len(parts) == len(value) else None
    if isinstance(value, str | bool) or (isinstance(value, int) and shape.kind == "whole"):
        return str(value).lower() if isinstance(value, bool) else str(value), value
    if isinstance(value, int | float):
        text, number = repr(float(value)), float(value)
        return text, f"{text} {shape.unit}" if shape.unit else number
    return None
