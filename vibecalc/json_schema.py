"""The JSON schema of case files, for editors: made from the schema, as it stands in `schema.py`."""

import re
from typing import Any

from vibecalc.core.case.row_files import LISTS
from vibecalc.errors import UnitError
from vibecalc.kinds import FINDING_MOTORS, KINDS
from vibecalc.schema import Case
from vibecalc.unit_table import TABLE, WORDS
from vibecalc.units import convert

Schema = dict[str, Any]


def json_schema() -> Schema:
    """Return the JSON schema (draft 2020-12) of case files, for editors."""
    texts: dict[str, Schema] = {}
    schema: Schema = _tidy(Case.model_json_schema(by_alias=True), texts)
    tables = with_kinds(schema["$defs"])
    schema["$defs"] = {name: _or_a_file(table) for name, table in tables.items()} | texts
    rows = schema["$defs"]["ShaftLine"]["properties"]
    for key in (path[-1] for path in LISTS):
        rows[key] = {"anyOf": [rows[key], _CSV_NAME]}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **schema,
        "title": "vibecalc case",
    }


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


# ----------------------------------------------------------------------------
# Numbers written as texts: a number and a unit, once for each unit that a key has in SI.
#
# Any unit that pint knows may follow the number. The units of `unit_table.py` are known here, so
# that those of another dimension are refused.
# ----------------------------------------------------------------------------

_NUMBER = r"\s*[-+−]?(\d[\d_]*\.?\d*|\.\d+)([eE][-+]?\d+)?\s*"
_UNIT = r"([^-\s\d.,;:!?+*/_=][^,;:!?=]*|1\s*/.*)?"
_VALUE = {"type": "string", "pattern": f"^{_NUMBER}{_UNIT}$"}


def _text_in(unit: str) -> Schema:
    """A number as a text, in any unit of this dimension."""
    others = "|".join(re.escape(name) for name in TABLE if name and not _fits(name, unit))
    pattern = f"^(?!{_NUMBER}({others})\\s*$){_NUMBER}{_UNIT}$"
    text = {"type": "string", "maxLength": 120, "pattern": pattern}
    if unit in WORDS:
        text["description"] = "{}, e.g. {}".format(*WORDS[unit])
    return text


def _fits(name: str, unit: str) -> bool:
    try:
        convert(1.0, name, unit)
    except UnitError:
        return False
    return True


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
            unit = tidy["unit"]
            name = "Text_" + unit.replace("/", "_per_").replace("*", "_").replace("^", "")
            texts[name] = texts.get(name) or _text_in(unit)
            choices = [
                {"$ref": f"#/$defs/{name}"} if o.get("type") == "string" else o for o in choices
            ]
        tidy.pop("anyOf")
        tidy = {**tidy, "anyOf": choices} if len(choices) > 1 else {**choices[0], **tidy}
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
