"""The JSON schema of case files, for editors: made from the schema, as it stands in `schema.py`."""

import copy
import functools
import json
import re
from collections.abc import Iterator
from typing import Any

from vibecalc.core.case.data_files import columns_of
from vibecalc.core.case.fields import Table
from vibecalc.core.case.raw import EACH
from vibecalc.core.case.row_files import LISTS
from vibecalc.core.case.rules import ByKind, barred
from vibecalc.core.case.walk import Shape, keys_of, shape_of
from vibecalc.errors import UsageError
from vibecalc.kinds import FINDING_MOTORS, KINDS, MOTORS, absent_places
from vibecalc.parts.motor_tables import Motor
from vibecalc.schema import SCHEMA_VERSION, Case
from vibecalc.unit_patterns import NUMBERS, SHIFTED, number_pattern, shifted_pattern, unit_pattern
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
    _define_same_keys(schema)
    _put_in_place(schema)
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
# What an editor shows of a key: its description with the unit of a number. The range, choices and
# default stand beside it.
# ----------------------------------------------------------------------------


def _describe(
    schema: Schema, table: type[Table], tables: dict[str, Schema], seen: set[str]
) -> None:
    """End the description of numbers with their unit in SI, in this table and below it."""
    for key, field in keys_of(table).items():
        part, shape = schema["properties"][key], shape_of(field)
        below = shape.table or (shape.item.table if shape.item else None)
        if below is not None:
            name = _table_in(part)
            if name not in seen:
                seen.add(name)
                _describe(tables[name], below, tables, seen)
                about = tables[name].pop("description").split("\n")[0]
                if columns_of(below):
                    tables[name] = {"anyOf": [tables[name], _CSV_NAME]}
                tables[name]["description"] = about
        elif unit := _unit(shape):
            part["description"] += f" [{unit}]"


def _unit(shape: Shape) -> str:
    """The unit in SI of a number, or of the numbers in a list."""
    return _unit(shape.item) if shape.item else shape.unit or ""


def _table_in(part: Schema) -> str:
    """The name of the table that a key leads to."""
    found: set[str] = set()
    _gather(part, {}, found)
    (name,) = found
    return name


def _define_same_keys(schema: Schema) -> None:
    """Put keys that are the same in several tables into a definition, and a reference in place."""
    found: dict[str, list[tuple[Schema, str]]] = {}
    for part in _parts(schema):
        keys = part.get("properties", {}) if "type" in part else {}
        for key, form in keys.items():
            if not form.keys() & {"$ref", "const"}:
                found.setdefault(json.dumps(form, sort_keys=True), []).append((keys, key))
    for places in found.values():
        keys, key = places[0]
        form, name = keys[key], f"key_{key}"
        while name in schema["$defs"]:
            name += "_"
        reference = {"$ref": f"#/$defs/{name}"}
        long, short = (len(json.dumps(one)) for one in (form, reference))
        if len(places) * short + long + len(name) < len(places) * long:
            schema["$defs"][name] = form
            for keys, key in places:
                keys[key] = reference


def _put_in_place(schema: Schema) -> None:
    """Put what one place alone refers to into that place.

    The key there says what its table is, as it does where an editor shows nothing of a table that
    has rules.
    """
    tables = schema["$defs"]
    leading: dict[str, list[Schema]] = {}
    for part in _parts(schema):
        if "$ref" in part:
            leading.setdefault(part["$ref"].split("/")[-1], []).append(part)
    for name, (part, *others) in leading.items():
        if not others or "allOf" in tables[name]:
            tables[name].pop("description", None)
        if not others:
            del part["$ref"]
            part |= tables.pop(name)


def _parts(schema: Any) -> Iterator[Schema]:
    """All objects in a schema."""
    if isinstance(schema, dict):
        yield schema
    for below in schema.values() if isinstance(schema, dict) else schema:
        if isinstance(below, dict | list):
            yield from _parts(below)


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
# Numbers, also as texts with a unit: a definition for each unit and bounds, of one for the number
# and one for its unit. What is defined stands in a list of one (`anyOf`), since some editors do not
# look at a description beside a reference.
# ----------------------------------------------------------------------------

#: a value whose unit is that of a result: any unit
_VALUE = {
    "type": ["number", "string"],
    "pattern": f"^ *{NUMBERS['']}( *[^-\\s0-9.,;:!?+*/_=][^,;:!?=]*| +1 */.*)? *$",
}
#: as pydantic writes it, as the JSON schema does, and in the name of a definition
_BOUNDS = (
    ("gt", "exclusiveMinimum", "above"),
    ("ge", "minimum", "from"),
    ("lt", "exclusiveMaximum", "below"),
    ("le", "maximum", "to"),
)
#: what a number is whose text begins like this
_SIGNS: dict[str, Schema] = {
    "": {},
    "from_0": {"minimum": 0},
    "above_0": {"exclusiveMinimum": 0},
}
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
    bounds = {key: number[key] for _, key, _ in _BOUNDS if key in number}
    names = (f"{word}_{number[key]:g}" for _, key, word in _BOUNDS if key in number)
    examples = re.findall("'([^']*)'", DIMENSIONS[unit].examples) if unit in DIMENSIONS else []
    said = {"examples": examples} if examples else {}  # here once, and not of each key
    if unit in SHIFTED:
        of_unit = "_".join(filter(None, ("unit", name, sign)))
        parts = [_form(of_unit, {"pattern": shifted_pattern(unit, sign), **said}, forms)]
    else:
        parts = [
            _form(sign or "any", {"pattern": number_pattern(sign), **_SIGNS[sign]}, forms),
            _form(f"unit_{name or 'none'}", {"pattern": unit_pattern(unit), **said}, forms),
        ]
        bounds = {
            key: bound for key, bound in bounds.items() if {key: bound} not in _SIGNS.values()
        }
    within = [bounds] if bounds else []
    return _defined("_".join((name or "number", *names)), {"allOf": [*parts, *within]}, forms)


def _form(name: str, form: Schema, forms: Schema) -> Schema:
    """A reference to what a number or a text may be."""
    return _defined(name, {"type": ["number", "string"], **form}, forms)


# ----------------------------------------------------------------------------
# What pydantic writes, in order.
# ----------------------------------------------------------------------------


#: entries of a list and letters of a name that no editor needs to count
_MANY = 64


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
    for most in ("maxItems", "maxLength"):
        if tidy.get(most, 0) >= _MANY:
            del tidy[most]
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
