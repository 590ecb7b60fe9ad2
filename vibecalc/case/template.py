"""Starter cases with a comment on every key, and the JSON schema, both made from the schema."""

import difflib
import json
from collections.abc import Iterator
from typing import Any

from pydantic.fields import FieldInfo

from vibecalc.case.fields import Table
from vibecalc.case.kind_schema import with_kinds
from vibecalc.case.row_files import LISTS
from vibecalc.case.scenes import SCENES
from vibecalc.case.schema import Case
from vibecalc.case.walk import Shape, bound_words, keys_of, shape_of
from vibecalc.errors import UsageError

__all__ = ["SCENES", "json_schema", "starter"]

_COMMENT_COLUMN = 40
_WIDEST = 100


def starter(scene: str) -> str:
    """Return a commented starter case as TOML; UsageError with the list for an unknown scene.

    Keys that the scene leaves out stand there as comments, with their defaults.
    """
    if scene not in SCENES:
        near = difflib.get_close_matches(scene[:60], SCENES, n=1)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        raise UsageError(f"no scene {scene[:60]!r}, there is {', '.join(SCENES)}{hint}")
    about, data = SCENES[scene]
    head = [
        f"# {about[0].upper()}{about[1:]}.",
        "# A value is a number in SI (angles in rad), or a text with its unit.",
        "# Keys and tables behind a # may be left out; they are shown with their defaults.",
    ]
    return "\n".join([*head, *_table_lines(Case, data, ""), ""])


def json_schema() -> dict[str, Any]:
    """Return the JSON schema (draft 2020-12) of case files, for editors."""
    schema: dict[str, Any] = _tidy(Case.model_json_schema(by_alias=True))
    tables = with_kinds(schema["$defs"])
    schema["$defs"] = {name: _or_a_file(table) for name, table in tables.items()}
    rows = schema["$defs"]["ShaftLine"]["properties"]
    for key in (path[-1] for path in LISTS):
        rows[key] = {"anyOf": [rows[key], _CSV_NAME]}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **schema,
        "title": "vibecalc case",
    }


def _or_a_file(table: dict[str, Any]) -> dict[str, Any]:
    """A table of nothing but columns may also be the name of a CSV file (`data_files.py`)."""
    columns = [part.get("items") for part in table.get("properties", {}).values()]
    numbers = [column for column in columns if column and column.get("type") != "array"]
    if not columns or len(numbers) < len(columns):
        return table
    return {"anyOf": [table, _CSV_NAME]}


_CSV_NAME = {"type": "string", "pattern": r"\.csv$"}


def _table_lines(table: type[Table], data: dict[str, Any], name: str) -> Iterator[str]:
    """Yield the keys of one table, then its tables, each under a header of its own."""
    later: list[tuple[str, FieldInfo, Shape]] = []
    for key, field in keys_of(table).items():
        shape = shape_of(field)
        if shape.kind == "table" or (shape.item and shape.item.table and not name):
            later.append((key, field, shape))
        elif key in data:
            yield from _key_lines(key, data[key], field, shape)
        else:
            yield from _left_out(key, field, shape)
    for key, field, shape in later:
        full_name = f"{name}.{key}" if name else key
        about = field.description or ""
        if key not in data:
            brackets = f"[[{full_name}]]" if shape.kind == "list" else f"[{full_name}]"
            yield from ("", *_commented(f"# {brackets}", about))
        elif shape.table:
            yield from ("", *_commented(f"[{full_name}]", about))
            yield from _table_lines(shape.table, data[key], full_name)
        elif shape.item and shape.item.table:
            for position, entry in enumerate(data[key]):
                yield from ("", *_commented(f"[[{full_name}]]", about if position == 0 else ""))
                yield from _entry_lines(shape.item.table, entry, everything=position == 0)


def _entry_lines(table: type[Table], entry: dict[str, Any], everything: bool) -> Iterator[str]:
    if everything:
        yield from _table_lines(table, entry, "-")
    else:
        yield from (f"{key} = {_toml(value)}" for key, value in entry.items())


def _key_lines(key: str, value: Any, field: FieldInfo, shape: Shape) -> Iterator[str]:
    if shape.item and shape.item.table:
        yield f"# {key}: {field.description}"
        yield from _entry_keys(shape.item.table)
        yield from (f"{key} = [", *(f"  {_toml(entry)}," for entry in value), "]")
    elif isinstance(value, list) and value and isinstance(value[0], list):
        yield f"# {key}: {field.description}{_details(shape.item or shape)}"
        yield from (f"{key} = [", *(f"  {_toml(entry)}," for entry in value), "]")
    else:
        about = (field.description or "") + _details(shape)
        yield from _commented(f"{key} = {_toml(value)}", about)


def _left_out(key: str, field: FieldInfo, shape: Shape) -> Iterator[str]:
    about = (field.description or "") + _details(shape)
    written = f"# {key} = {_toml(_default(field))}" if _default(field) is not None else f"# {key} ="
    yield from _commented(written, about)


def _entry_keys(table: type[Table]) -> Iterator[str]:
    for key, field in keys_of(table).items():
        default = _default(field)
        needed = "" if not field.is_required() else "; needed"
        given = f"; default {_toml(default)}" if default not in (None, "") else needed
        about = f"{field.description or ''}{_details(shape_of(field))}{given}"
        yield from _wrapped(about, f"#   {key:<18} ", "#" + " " * 22)


def _details(shape: Shape) -> str:
    """Say unit, bounds and choices of a key, as they follow its description."""
    if shape.kind == "choice" and len(shape.choices) > 1:
        return ": " + ", ".join(_toml(choice) for choice in shape.choices)
    inner = shape.item if shape.item and not shape.item.table else shape
    inner = inner.item if inner.item and not inner.item.table else inner
    unit = f" [{inner.unit}]" if inner.kind == "number" and inner.unit else ""
    bounds = ", ".join(part for part in bound_words(inner).split(" and ") if part)
    plain = bounds.replace(f" {inner.unit}", "") if inner.unit else bounds
    return unit + (f", {plain}" if plain else "")


def _default(field: FieldInfo) -> Any:
    default = None if field.is_required() else field.get_default(call_default_factory=True)
    if isinstance(default, Table):
        return None
    return None if default in ((), {}) else default


def _commented(written: str, about: str) -> Iterator[str]:
    """Yield a line with its comment behind it, or above it where the line is long."""
    if len(written) >= _COMMENT_COLUMN:
        yield from _wrapped(about, "# ", "# ") if about else ()
        yield written
        return
    behind = " " * _COMMENT_COLUMN
    lines = _wrapped(about, f"{written:<{_COMMENT_COLUMN}}# ", f"{behind}# ") if about else []
    yield from lines or [written]


def _wrapped(text: str, first: str, following: str) -> list[str]:
    import textwrap

    room = _WIDEST - len(first)
    pieces = textwrap.wrap(text, room, break_long_words=False)
    return [(following if number else first) + piece for number, piece in enumerate(pieces)]


def _toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_toml(entry)}" for key, entry in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_toml(entry) for entry in value) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)


def _tidy(schema: Any) -> Any:
    """Move what pydantic leaves beside its place, and drop what means nothing in TOML (null)."""
    if isinstance(schema, list):
        return [_tidy(entry) for entry in schema]
    if not isinstance(schema, dict):
        return schema
    tidy = {key: _tidy(entry) for key, entry in schema.items()}
    options = tidy.get("anyOf")
    if isinstance(options, list):
        bounds = {new: tidy.pop(old) for old, new in _BOUND_NAMES.items() if old in tidy}
        kept = [{**o, **bounds} if o.get("type") == "number" else o for o in options]
        kept = [option for option in kept if option != {"type": "null"}]
        tidy.pop("anyOf")
        tidy = {**tidy, "anyOf": kept} if len(kept) > 1 else {**kept[0], **tidy}
    if tidy.get("default", 0) is None:
        del tidy["default"]
    return tidy


_BOUND_NAMES = {
    "gt": "exclusiveMinimum",
    "ge": "minimum",
    "lt": "exclusiveMaximum",
    "le": "maximum",
}
