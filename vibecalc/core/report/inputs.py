"""The input of a calculation as tables: what each key is, and its value with a unit."""

import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pydantic.fields import FieldInfo

from vibecalc.core.case.walk import Shape, keys_of, shape_at, shape_of
from vibecalc.core.report.sections import LONGEST
from vibecalc.core.report.writing import Heading, many, paragraph, table
from vibecalc.core.results.record import READ, Result
from vibecalc.errors import KeyPath, UnitError
from vibecalc.units import convert

#: tables of a case that are not the machine and what is asked of it
_APART = ("schema", "title", "source", "document", "reference", "reference_table", "limit")
_NUMBERS = ("number", "whole", "value")
#: what the words on a key have for its author: how values are written, and its default
_FOR_AUTHORS = re.compile(r"(,? (as )?([\d.]+ or )?'|; (default|needed )).*$", re.DOTALL)
_DIGITS, _WRITTEN = 6, 10


def inputs(result: Result) -> list[str]:
    """A table for each table of the case, below its name; defaults that nobody wrote are left out.

    A value stands as it was written, or in the unit that people read where a search or an override
    has changed it.
    """
    written = tomllib.loads(result.case_toml) if result.case_toml else {}
    case = {key: value for key, value in result.case.items() if key not in _APART}
    lines = paragraph("Keys that are not listed have their defaults.")
    for title, block in _blocks(case, written, ()):
        lines += ["", Heading(level=4, words=title), *block]
    return lines


Table = Mapping[str, Any]
Titled = Iterator[tuple[str, list[str]]]


def _blocks(given: Table, written: Table, path: KeyPath) -> Titled:
    """The tables at a path and below it, each with its title."""
    fields = _fields(shape_at(path)) if path else {}
    rows, below = list[tuple[str, str, str]](), list[tuple[str, Any]]()
    for key, value in given.items():
        place = shape_at((*path, key))
        if place is None or _is_empty(value):
            continue
        if place.kind == "table" or _is_list_of_tables(value):
            below.append((key, value))
        elif key in written or _is_given(value, fields[key]):
            shown = _value(value, written.get(key), place)
            words = _FOR_AUTHORS.sub("", fields[key].description or "")
            rows.append((key.replace("_", " "), shown, words))
    if rows:
        yield _title(path), table(("key", "value", "meaning"), rows)
    for key, value in below:
        known = written.get(key)
        if isinstance(value, Mapping):
            yield from _blocks(value, _as_table(known), (*path, key))
        else:
            same = isinstance(known, list) and len(known) == len(value)
            each = [_as_table(one) for one in (known if same and known else [{}] * len(value))]
            yield from _rows(value, each, (*path, key))


def _rows(rows: Sequence[Table], written: Sequence[Table], path: KeyPath) -> Titled:
    """A list of tables: a row for each and a column for each key that one of them has."""
    fields = _fields(shape_at((*path, 0)))
    shapes = {key: shape_of(field) for key, field in fields.items()}
    columns = [
        key
        for key, field in fields.items()
        if shapes[key].kind != "table"
        and not any(_is_list_of_tables(row.get(key)) for row in rows)
        and any(
            key in known or _is_given(row.get(key), field)
            for row, known in zip(rows, written, strict=True)
        )
    ]
    cells = [
        [_value(row.get(key), known.get(key), shapes[key]) for key in columns]
        for row, known in zip(rows, written, strict=True)
    ]
    if columns:
        yield _title(path), table([key.replace("_", " ") for key in columns], cells)
    for i, (row, known) in enumerate(zip(rows, written, strict=True)):
        inner = {key: value for key, value in row.items() if key not in columns}
        yield from _blocks(inner, known, (*path, i))


def _fields(shape: Shape | None) -> dict[str, FieldInfo]:
    return keys_of(shape.table) if shape is not None and shape.table is not None else {}


def _as_table(written: Any) -> Table:
    return written if isinstance(written, Mapping) else {}


def _title(path: KeyPath) -> str:
    """`machine, crank train, rod`; an entry of a list by its place from 1."""
    parts = (str(one + 1) if isinstance(one, int) else one.replace("_", " ") for one in path)
    return ", ".join(parts) or "case"


def _is_list_of_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and isinstance(value[0], Mapping)


def _is_empty(value: Any) -> bool:
    return value is None or value in ("", [], {})


def _is_given(value: Any, field: FieldInfo) -> bool:
    """Whether a value is there and no default."""
    default = list(field.default) if isinstance(field.default, tuple) else field.default
    return not _is_empty(value) and value != default


def _value(value: Any, written: Any, shape: Shape) -> str:
    """As it was written where that is what was computed with, else in the unit that people read."""
    if _is_empty(value):
        return ""
    if isinstance(value, list):
        known = written if isinstance(written, list) and len(written) == len(value) else None
        item = shape.item or shape._replace(or_three=False)
        some = [
            _value(one, known[i] if known else None, item) for i, one in enumerate(value[:LONGEST])
        ]
        more = f" ... ({many(len(value), 'value')})" if len(value) > LONGEST else ""
        return ("; " if isinstance(value[0], list) else ", ").join(some) + more
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {_bare(one)}" for name, one in value.items())
    if isinstance(value, bool):
        return "yes" if value else "no"
    if shape.kind not in _NUMBERS or isinstance(value, str):
        return _bare(value)
    if isinstance(written, str) and _same(written, value, shape):
        return written
    turns = shape.noun == "an angular speed"
    unit = "rpm" if turns else READ.get(shape.unit or "", shape.unit or "")
    return f"{convert(float(value), shape.unit or '', unit):.{_DIGITS}g} {unit}".rstrip()


def _bare(value: Any) -> str:
    """A value whose unit is not known, with no more digits than somebody may have written."""
    return f"{value:.{_WRITTEN}g}" if isinstance(value, float) else str(value)


def _same(written: str, value: float, shape: Shape) -> bool:
    try:
        return shape.number(written) == value
    except UnitError:
        return False
