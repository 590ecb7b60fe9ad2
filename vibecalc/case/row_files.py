"""Long lists of tables in CSV files beside a case: one line for each station or shaft.

A column is a key; a cell left empty is a key left out; names of a list stand in one cell, with
semicolons between them.
"""

from typing import TYPE_CHECKING, Any

from vibecalc.case.csv_table import Column, Columns, Unreadable
from vibecalc.case.raw import listed, nearest
from vibecalc.errors import KeyPath

if TYPE_CHECKING:
    from vibecalc.case.walk import Shape

#: lists of the schema that may be the name of a file
LISTS: tuple[KeyPath, ...] = (
    ("machine", "shaft_line", "stations"),
    ("machine", "shaft_line", "shafts"),
)


def keys_of_rows(path: KeyPath) -> dict[str, "Shape"]:
    """Key -> shape of what a column may hold, of a list that may be a file; otherwise nothing."""
    if path not in LISTS:
        return {}
    from vibecalc.case.walk import keys_of, shape_at, shape_of

    shape = shape_at(path)
    assert shape is not None and shape.item is not None and shape.item.table is not None
    fields = {key: shape_of(field) for key, field in keys_of(shape.item.table).items()}
    return {key: one for key, one in fields.items() if one.kind != "table"}


def rows_of(columns: Columns, path: KeyPath) -> list[dict[str, Any]]:
    """The lines of a file as tables of the list at `path`. Raises Unreadable."""
    from vibecalc.case.data_files import check_numbers, check_unit

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
        kept = [place for place, cell in enumerate(column.cells) if cell]
        cells, lines = [column.cells[p] for p in kept], [column.lines[p] for p in kept]
        if shape.kind == "number":
            check_numbers(name, Column(column.unit, cells, lines))
        for place, cell in zip(kept, cells, strict=True):
            rows[place][name] = _value(cell, column.unit, shape)
    return rows


def _value(cell: str, unit: str, shape: "Shape") -> Any:
    if shape.kind == "number":
        return f"{cell} {unit}".strip()
    if shape.kind == "list":
        return [part.strip() for part in cell.split(";")]
    return cell
