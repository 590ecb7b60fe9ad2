"""Every place of the schema of a case, of one kind of machine or of all, with its field."""

from collections.abc import Iterator
from functools import cache
from typing import Any, NamedTuple

from pydantic.fields import FieldInfo

from vibecalc.core.case.fields import Table
from vibecalc.core.case.raw import EACH
from vibecalc.core.case.walk import Shape, keys_of, shape_of
from vibecalc.json_schema import json_schema
from vibecalc.schema import Case

Pattern = tuple[str, ...]


class Place(NamedTuple):
    """A key with its shape, the table that has it, and its field there."""

    shape: Shape
    model: type[Table]
    field: FieldInfo

    @property
    def innermost(self) -> Shape:
        """What the entries of its lists are."""
        shape = self.shape
        while shape.item is not None:
            shape = shape.item
        return shape


def _having(word: str, part: Any, schema: Any) -> Any:
    """The form with this word that a part of the schema is, or leads to."""
    while word not in part:
        part = schema["$defs"][part["$ref"].split("/")[-1]] if "$ref" in part else part["anyOf"][0]
    return part


def _walk(table: type[Table], above: Pattern, at: Any, schema: Any) -> Iterator[Any]:
    at = _having("properties", at, schema)
    for key, field in keys_of(table).items():
        part = at["properties"].get(key)
        if not part:
            continue
        pattern, shape = (*above, key), shape_of(field)
        yield pattern, Place(shape, table, field)
        if shape.table is not None:
            yield from _walk(shape.table, pattern, part, schema)
        elif shape.item is not None and shape.item.table is not None:
            items = _having("items", part, schema)["items"]
            yield from _walk(shape.item.table, (*pattern, EACH), items, schema)


@cache
def places(kind: str = "") -> dict[Pattern, Place]:
    """Every key that a case of this kind of machine may have, by the schema of this kind."""
    schema = json_schema(kind)
    return dict(_walk(Case, (), schema, schema))


@cache
def keys() -> dict[tuple[type[Table], str], Pattern]:
    """Every key of every table, and its first place."""
    found: dict[tuple[type[Table], str], Pattern] = {}
    for pattern, place in places().items():
        found.setdefault((place.model, pattern[-1]), pattern)
    return found
