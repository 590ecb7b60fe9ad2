"""The JSON schema of case files, for editors: made from the schema, as it stands in `schema.py`."""

import copy
import functools
import json
import re
from typing import Any

from vibecalc.core.case.data_files import columns_of
from vibecalc.core.case.fields import Table
from vibecalc.core.case.raw import EACH
from vibecalc.core.case.row_files import LISTS
from vibecalc.core.case.rules import ByKind, barred
from vibecalc.core.case.walk import Shape, keys_of, shape_of, words
from vibecalc.errors import UsageError
from vibecalc.kinds import FINDING_MOTORS, KINDS, MOTORS, absent_places
from vibecalc.parts.motor_tables import Motor
from vibecalc.schema import SCHEMA_VERSION, Case
from vibecalc.unit_patterns import LESS, NUMBER, SHIFTED, text_pattern
from vibecalc.unit_table import DIMENSIONS

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
    forms: Schema = {}
    schema: Schema = _tidy(Case.model_json_schema(by_alias=True), forms)
    tables = schema["$defs"]
    _describe(schema, Case, tables, set())
    tables["Machine"]["allOf"] = [{"if": _said(kind), "then": _needs(kind)} for kind in KINDS]
    schema["$defs"] = tables | forms
    rows = tables["ShaftLine"]["properties"]
    for key in (path[-1] for path in LISTS):
        rows[key] = {"anyOf": [rows[key], _CSV_NAME], "description": rows[key]["description"]}
    return schema


#: the name of a file in place of a table of nothing but columns, or of one of `LISTS`
_CSV_NAME = {"type": "string", "pattern": r"\.csv$"}

# ----------------------------------------------------------------------------
# What the kinds of machine need, as conditions of the JSON schema.
# ----------------------------------------------------------------------------


def _said(kind: str) -> Schema:
    return {"properties": {"kind": {"const": kind}}}


def _needs(kind: str) -> Schema:
    """What [machine] of this kind has to have; no speed where its motor finds that."""
    finding_motor = {"required": ["kind"], "properties": {"kind": {"enum": [*FINDING_MOTORS]}}}
    finding = {"required": ["motor"], "properties": {"motor": finding_motor}}
    needs = [*KINDS[kind].needs]
    if not KINDS[kind].driven:
        return {"required": needs, "not": finding}
    others = [part for part in needs if part != "speed"]
    found = {"required": others, "not": {"required": ["speed"]}}
    return {"if": finding, "then": found, "else": {"required": needs}}


def _without(kind: str) -> Schema:
    """That a machine of this kind has none of these places."""
    machine = {"required": ["kind"], **_said(kind)}
    then = barred(absent_places(kind))
    return {"if": {"required": ["machine"], "properties": {"machine": machine}}, "then": then}


# ----------------------------------------------------------------------------
# The schema of one kind of machine: without the places that it does not have.
# ----------------------------------------------------------------------------


def _of_kind(schema: Schema, kind: str) -> None:
    """Leave in the schema what a machine of this kind may have."""
    tables = schema["$defs"]
    for path in absent_places(kind):
        at = schema
        for part in path[:-1]:
            at = at["properties"][part] if part != EACH else at["items"]
            while "$ref" in at or ("properties" not in at and "anyOf" in at):
                at = tables[at["$ref"].split("/")[-1]] if "$ref" in at else at["anyOf"][0]
        at["properties"].pop(path[-1], None)
    tables["Machine"]["allOf"] = [_needs(kind)]
    tables["Machine"]["properties"]["kind"] = _said_of([kind])
    if not KINDS[kind].driven:
        motor = tables["Motor"]["properties"]
        motor["kind"]["enum"] = [one for one in MOTORS if one not in FINDING_MOTORS]
        for key in _keys_of_motors() - _keys_of_motors(*motor["kind"]["enum"]):
            del motor[key]
    needed: set[str] = set()
    _gather(schema["properties"], tables, needed)
    schema["$defs"] = {name: table for name, table in tables.items() if name in needed}


def _keys_of_motors(*kinds: str) -> set[str]:
    """Keys that motors of these kinds have, or those of any."""
    rows = next(rule.kinds for rule in Motor.RULES if isinstance(rule, ByKind))
    return {key for kind in kinds or rows for keys in rows[kind] for key in keys}


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
                if columns_of(below):
                    tables[name] = {"anyOf": [tables[name], _CSV_NAME]}
        elif shape.kind not in ("text", "flag"):
            part["description"] += f"; {words(shape, brief=True)}"
        if below is None and "default" in part:
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
# Numbers, also as texts with a unit: a definition for each unit and bounds, with one for the texts
# of each unit. What is defined stands in a list of one (`anyOf`), since some editors do not look at
# a description beside a reference.
# ----------------------------------------------------------------------------

#: a value whose unit is that of a result: any unit
_VALUE = {
    "oneOf": [
        {"type": "number"},
        {
            "type": "string",
            "pattern": f"^ *{NUMBER}(?: *[^-\\s0-9.,;:!?+*/_=][^,;:!?=]*| +1 */.*)? *$",
        },
    ]
}
#: as pydantic writes it, as the JSON schema does, and in the name of a definition
_BOUNDS = (
    ("gt", "exclusiveMinimum", "above"),
    ("ge", "minimum", "from"),
    ("lt", "exclusiveMaximum", "below"),
    ("le", "maximum", "to"),
)
_BOUND_NAMES = {written: name for written, name, _ in _BOUNDS}


def _defined(name: str, form: Schema, forms: Schema) -> Schema:
    """A reference to a form, which is entered under its name."""
    forms.setdefault(name, form)
    return {"$ref": f"#/$defs/{name}"}


def _number(unit: str, number: Schema, forms: Schema) -> Schema:
    """A number in SI within bounds, or a text with a number and a unit of this dimension."""
    above, least = number.get("exclusiveMinimum", -1), number.get("minimum", -1)
    sign = "above_0" if above >= 0 or least > 0 else "from_0" if least == 0 else ""
    name = unit.replace("/", "_per_").replace("*", "_").replace("^", "")
    shifted = sign if unit in SHIFTED else ""
    pattern: Schema = {"type": "string", "pattern": text_pattern(unit, shifted)}
    if unit in DIMENSIONS:  # said here once, and not of each key
        pattern["examples"] = re.findall("'([^']*)'", DIMENSIONS[unit].examples)
    text = _defined("_".join(filter(None, ("Text", name, shifted))), pattern, forms)
    form: Schema = {"anyOf": [{**number, "type": "number"}, text]}
    if sign and not shifted:
        form["not"] = _defined(f"Text_not_{sign}", {"type": "string", "pattern": LESS[sign]}, forms)
    bounds = (f"{word}_{number[key]:g}" for _, key, word in _BOUNDS if key in number)
    return _defined("_".join((name or "number", *bounds)), form, forms)


# ----------------------------------------------------------------------------
# What pydantic writes, in order.
# ----------------------------------------------------------------------------


def _tidy(schema: Any, forms: Schema) -> Any:
    """Move what pydantic leaves next to its place; drop titles, and null, which TOML has not.

    `forms` gathers the definitions of numbers.
    """
    if isinstance(schema, list):
        return [_tidy(entry, forms) for entry in schema]
    if not isinstance(schema, dict):
        return schema
    rows: Schema = {key: _tidy(entry, forms) for key, entry in schema.items()}
    tidy = {_BOUND_NAMES.get(key, key): entry for key, entry in rows.items()}
    if "$ref" in tidy.get("allOf", [{}])[0]:  # what `Table` wraps, to remain a reference
        tidy.update(tidy.pop("allOf")[0])
    if isinstance(tidy.get("title"), str):
        del tidy["title"]
    if len(tidy.get("enum", ())) > 1 and tidy.get("type") == "string":
        del tidy["type"]  # the choices are texts
    if tidy.get("default", 0) in (None, [], {}, ""):
        del tidy["default"]
    if isinstance(tidy.get("unit"), str):
        number = tidy.pop("anyOf")[0]
        number |= {key: tidy.pop(key) for _, key, _ in _BOUNDS if key in tidy}
        return _with(_number(tidy.pop("unit"), number, forms), tidy, forms)
    if tidy.get("oneOf") == [{"type": "number"}, {"type": "string"}]:
        del tidy["oneOf"]
        return _with(_defined("Value", _VALUE, forms), tidy, forms)
    if tidy.get("anyOf") == [{"type": one} for one in ("integer", "number", "string")]:
        del tidy["anyOf"]  # what names an entry of an axis
        tidy["type"] = ["number", "string"]
    entries = tidy.get("prefixItems", [])
    if entries and all(entry == entries[0] for entry in entries):
        tidy["items"] = tidy.pop("prefixItems")[0]
    if {"type": "null"} in tidy.get("anyOf", ()):
        choices = [option for option in tidy.pop("anyOf") if option != {"type": "null"}]
        return _with(choices[0], tidy, forms) if len(choices) == 1 else {**tidy, "anyOf": choices}
    return tidy


def _with(form: Schema, about: Schema, forms: Schema) -> Schema:
    """A form with what is said of a key of it."""
    is_number = form.get("$ref", "").split("/")[-1] in forms
    return {"anyOf": [form], **about} if is_number and about else {**form, **about}
