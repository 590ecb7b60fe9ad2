"""What the kinds of machine and motor need, as conditions of the JSON schema."""

from typing import Any

from vibecalc.case.kinds import FINDING_MOTORS, HARMONICS, KINDS
from vibecalc.parts.drive_rules import KEYS

Schema = dict[str, Any]


def with_kinds(definitions: dict[str, Schema]) -> dict[str, Schema]:
    """The tables of the JSON schema, those of machine and motor with a condition for each kind."""
    more = {"Machine": _machines(), "Motor": _motors()}
    return {
        name: {**table, "allOf": more[name]} if name in more else table
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
            found = {"required": others, "not": {"required": ["speed"]}}
            rules.append({"if": _said(name), "then": {"if": finding, "then": found, "else": given}})
        else:
            rules.append({"if": _said(name), "then": {**given, "not": finding}})
    return rules


def _motors() -> list[Schema]:
    """A motor that does not say its kind has torque by order; the others say it."""
    keys = sorted({key for row in KEYS.values() for key in (*row.needed, *row.other)})
    rules: list[Schema] = []
    for name, row in KEYS.items():
        foreign = [key for key in keys if key not in (*row.needed, *row.other)]
        rule: Schema = {"required": list(row.needed), "properties": dict.fromkeys(foreign, False)}
        said = _said(name) if name == HARMONICS else {**_said(name), "required": ["kind"]}
        rules.append({"if": said, "then": rule})
    return rules
