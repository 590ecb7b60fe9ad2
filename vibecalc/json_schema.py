"""The JSON schema of case files, for editors: made from the schema, as it stands in `schema.py`."""

import copy
import functools
import json
from typing import Any

from vibecalc.core.case.fields import Table
from vibecalc.core.case.row_files import LISTS
from vibecalc.core.case.walk import Shape, keys_of, shape_of, words
from vibecalc.errors import KeyPath, UsageError
from vibecalc.kinds import EACH, FINDING_MOTORS, KINDS, MOTORS, of_others, parts_of
from vibecalc.schema import SCHEMA_VERSION, Case
from vibecalc.unit_patterns import NUMBERS, text_pattern

Schema = dict[str, Any]


def json_schema(kind: str = "") -> Schema:
    """Return the JSON schema (draft 2020-12) of case files, of one kind of machine or of all.

    UsageError where there is no such kind.
    """
    if kind and kind not in KINDS:
        raise UsageError(f"no kind of machine {kind[:60]!r}, there is {', '.join(KINDS)}")
    schema = copy.deepcopy(_every_table())
    if kind:
        _of_kind(schema, kind)
    else:
        schema["$defs"]["Machine"]["properties"]["kind"] = _said_of([*KINDS])
        schema["allOf"] = [_without(name) for name in KINDS]
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": ":".join(filter(None, ("urn:vibecalc:case", str(SCHEMA_VERSION), kind))),
        **schema,
        "title": f"vibecalc case of a machine of kind {kind}" if kind else "vibecalc case",
    }


@functools.cache
def _every_table() -> Schema:
    texts: dict[str, Schema] = {}
    schema: Schema = _tidy(Case.model_json_schema(by_alias=True), texts)
    _describe(schema, Case, schema["$defs"], set())
    tables = with_kinds(schema["$defs"])
    schema["$defs"] = {name: _or_a_file(table) for name, table in tables.items()} | texts
    rows = schema["$defs"]["ShaftLine"]["properties"]
    for key in (path[-1] for path in LISTS):
        rows[key] = {"anyOf": [rows[key], _CSV_NAME], "description": rows[key]["description"]}
    return schema


def _or_a_file(table: Schema) -> Schema:
    """A table of nothing but columns may also be the name of a CSV file (`data_files.py`)."""
    columns = [part.get("items") for part in table.get("properties", {}).values()]
    numbers = [column for column in columns if column and column.get("type") != "array"]
    if not columns or len(numbers) < len(columns):
        return table
    return {"anyOf": [table, _CSV_NAME]}


_CSV_NAME = {"type": "string", "pattern": r"\.csv$"}

# ----------------------------------------------------------------------------
# What the kinds of machine need, as conditions of the JSON schema.
# ----------------------------------------------------------------------------


def with_kinds(definitions: dict[str, Schema]) -> dict[str, Schema]:
    """The tables of the JSON schema, that of the machine with a condition for each kind."""
    return {
        name: {**table, "allOf": _machines()} if name == "Machine" else table
        for name, table in definitions.items()
    }


def _said(kind: str) -> Schema:
    return {"properties": {"kind": {"const": kind}}}


def _machines() -> list[Schema]:
    finding = {
        "required": ["motor"],
        "properties": {
            "motor": {
                "required": ["kind"],
                "properties": {"kind": {"enum": list(FINDING_MOTORS)}},
            }
        },
    }
    rules = []
    for name, kind in KINDS.items():
        given = {"required": list(kind.needs)}
        if kind.driven:
            others = [part for part in kind.needs if part != "speed"]
            requirement = {"required": others, "not": {"required": ["speed"]}}
            rules.append(
                {"if": _said(name), "then": {"if": finding, "then": requirement, "else": given}}
            )
        else:
            rules.append({"if": _said(name), "then": {**given, "not": finding}})
    return rules


def _foreign(kind: str) -> list[KeyPath]:
    """Places that a machine of this kind does not have; `check_parts_of_kind` refuses them."""
    every = (*parts_of(kind).foreign, *of_others(kind))
    return [path for path in every if not any(path[:end] in every for end in range(1, len(path)))]


def _without(kind: str) -> Schema:
    """That a machine of this kind has none of these places."""
    then: Schema = {}
    for path in _foreign(kind):
        at = then
        for part in path[:-1]:
            below = at.setdefault("properties", {}) if part != EACH else at
            at = below.setdefault("items" if part == EACH else str(part), {})
        at.setdefault("properties", {})[path[-1]] = False
    machine = {"required": ["kind"], **_said(kind)}
    return {"if": {"required": ["machine"], "properties": {"machine": machine}}, "then": then}


# ----------------------------------------------------------------------------
# The schema of one kind of machine: without the places that it does not have.
# ----------------------------------------------------------------------------


def _of_kind(schema: Schema, kind: str) -> None:
    """Leave in the schema what a machine of this kind may have."""
    tables = schema["$defs"]
    for path in _foreign(kind):
        at = schema
        for part in path[:-1]:
            at = at["properties"][part] if part != EACH else at["items"]
            while "$ref" in at or ("properties" not in at and "anyOf" in at):
                at = tables[at["$ref"].split("/")[-1]] if "$ref" in at else at["anyOf"][0]
        at["properties"].pop(path[-1], None)
    _settle(tables["Machine"], [kind])
    tables["Machine"]["properties"]["kind"] = _said_of([kind])
    if not KINDS[kind].driven:
        motors = [motor for motor in MOTORS if motor not in FINDING_MOTORS]
        _settle(tables["Motor"], motors)
        tables["Motor"]["properties"]["kind"]["enum"] = motors
    needed: set[str] = set()
    _gather(schema["properties"], tables, needed)
    schema["$defs"] = {name: table for name, table in tables.items() if name in needed}


def _settle(table: Schema, kinds: list[str]) -> None:
    """Leave in a table what goes with these kinds: conditions, and keys that one of them has."""
    left = [one for one in table["allOf"] if _kind_of(one) in (None, *kinds)]
    of_kinds = [one["then"].get("properties", {}) for one in left if _kind_of(one)]
    for key in [*table["properties"]] if of_kinds else ():
        if all(keys.get(key) is False for keys in of_kinds):
            del table["properties"][key]
    table["allOf"] = [one["then"] if len(kinds) == 1 and _kind_of(one) else one for one in left]


def _kind_of(condition: Schema) -> str | None:
    """The kind that a condition is about, if it is about one."""
    kind: str | None = condition.get("if", {}).get("properties", {}).get("kind", {}).get("const")
    return kind


def _gather(part: Any, tables: dict[str, Schema], names: set[str]) -> None:
    """Gather the names of all tables that a part of the schema leads to."""
    if isinstance(part, dict):
        name = part.get("$ref", "").split("/")[-1] if isinstance(part.get("$ref"), str) else ""
        if name and name not in names:
            names.add(name)
            _gather(tables.get(name), tables, names)
    if isinstance(part, dict | list):
        for below in part.values() if isinstance(part, dict) else part:
            _gather(below, tables, names)


# ----------------------------------------------------------------------------
# What an editor shows of a key: its description, what it may be, its default.
# ----------------------------------------------------------------------------


def _describe(
    schema: Schema, table: type[Table], tables: dict[str, Schema], seen: set[str]
) -> None:
    """End the description of every key with what may stand there, in this table and below it."""
    for key, field in keys_of(table).items():
        part, shape = schema["properties"][key], shape_of(field)
        below = shape.table or (shape.item.table if shape.item else None)
        if below is not None:
            name = _table_in(part)
            if name not in seen:
                seen.add(name)
                _describe(tables[name], below, tables, seen)
        elif shape.kind not in ("text", "flag"):
            part["description"] = f"{part['description']}; {words(shape)}"
        if below is None and part.get("default") not in (None, [], {}, ""):
            part["description"] += f"; default {_shown(part['default'], shape)}"


def _table_in(part: Schema) -> str:
    """The name of the table that a key leads to."""
    found: set[str] = set()
    _gather(part, {}, found)
    (name,) = found
    return name


def _shown(default: Any, shape: Shape) -> str:
    """A default as a case would have it, with its unit."""
    unit = (shape.item or shape).unit or ""
    if isinstance(default, float):
        return f"{default:g} {unit}".strip()
    if isinstance(default, list) and all(isinstance(one, float) for one in default):
        return f"[{', '.join(f'{one:g}' for one in default)}] {unit}".strip()
    return json.dumps(default, ensure_ascii=False)


def _said_of(kinds: list[str]) -> Schema:
    """The key `kind` of the machine, with a line for each."""
    about = [KINDS[kind].about for kind in kinds]
    lines = "\n".join(f"- `{kind}`: {line}" for kind, line in zip(kinds, about, strict=True))
    return {
        "description": f"kind of machine\n\n{lines}",
        "enum": kinds,
        "type": "string",
        "x-taplo": {"docs": {"enumValues": about}},
    }


# ----------------------------------------------------------------------------
# Numbers written as texts: a number and a unit, once for each unit that a key has in SI, and for
# the least that the number may be.
# ----------------------------------------------------------------------------

#: a value whose unit is that of a result: any unit
_VALUE = {
    "type": "string",
    "pattern": f"^ *{NUMBERS['']}(?: *[^-\\s0-9.,;:!?+*/_=][^,;:!?=]*| +1 */.*)? *$",
}


def _text_in(unit: str, number: Schema, texts: dict[str, Schema]) -> Schema:
    """A number as a text, in a unit of this dimension, where this is its form as a number."""
    least = ""
    if max(number.get("exclusiveMinimum", -1), number.get("minimum", -1)) >= 0:
        above = number.get("exclusiveMinimum", -1) >= 0 or number.get("minimum", -1) > 0
        least = "above_0" if above else "from_0"
    name = unit.replace("/", "_per_").replace("*", "_").replace("^", "")
    name = "_".join(("Text", name, least)) if least else f"Text_{name}"
    if name not in texts:
        texts[name] = {"type": "string", "maxLength": 120, "pattern": text_pattern(unit, least)}
    return {"$ref": f"#/$defs/{name}"}


# ----------------------------------------------------------------------------
# What pydantic writes, in order.
# ----------------------------------------------------------------------------


def _tidy(schema: Any, texts: dict[str, Schema]) -> Any:
    """Move what pydantic leaves next to its place; drop titles, and null, which TOML has not.

    `texts` gathers the forms of numbers written as texts, one for each unit.
    """
    if isinstance(schema, list):
        return [_tidy(entry, texts) for entry in schema]
    if not isinstance(schema, dict):
        return schema
    tidy = {key: _tidy(entry, texts) for key, entry in schema.items()}
    if "$ref" in tidy.get("allOf", [{}])[0]:  # what `Table` wraps, to remain a reference
        tidy.update(tidy.pop("allOf")[0])
    if isinstance(tidy.get("title"), str):
        del tidy["title"]
    options = tidy.get("anyOf")
    if isinstance(options, list):
        bounds = {new: tidy.pop(old) for old, new in _BOUND_NAMES.items() if old in tidy}
        choices = [{**o, **bounds} if o.get("type") == "number" else o for o in options]
        choices = [option for option in choices if option != {"type": "null"}]
        if "unit" in tidy:
            number = next(option for option in choices if option.get("type") == "number")
            text = _text_in(tidy.pop("unit"), number, texts)
            choices = [text if option.get("type") == "string" else option for option in choices]
        tidy.pop("anyOf")
        tidy = {**tidy, "anyOf": choices} if len(choices) > 1 else {**choices[0], **tidy}
    elif tidy.get("type") in ("number", "integer"):
        tidy = {_BOUND_NAMES.get(key, key): entry for key, entry in tidy.items()}
    entries = tidy.get("prefixItems", [])
    if entries and all(entry == entries[0] for entry in entries):
        tidy["items"] = tidy.pop("prefixItems")[0]
    if tidy.get("oneOf") == [{"type": "number"}, {"type": "string"}]:
        tidy["oneOf"] = [{"type": "number"}, _VALUE]
    if tidy.get("default", 0) is None:
        del tidy["default"]
    return tidy


_BOUND_NAMES = {
    "gt": "exclusiveMinimum",
    "ge": "minimum",
    "lt": "exclusiveMaximum",
    "le": "maximum",
}
