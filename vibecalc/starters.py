"""Starter cases with a comment on every key, and the JSON schema, both made from the schema."""

import difflib
import json
from collections.abc import Iterator
from typing import Any, NamedTuple

from pydantic.fields import FieldInfo

from vibecalc.absorber import starters as absorber_scenes
from vibecalc.core.case.data_files import LISTS
from vibecalc.core.case.fields import Table
from vibecalc.core.case.walk import Shape, bound_words, keys_of, shape_of
from vibecalc.errors import UsageError
from vibecalc.kinds import FINDING_MOTORS, HARMONICS, KINDS
from vibecalc.parts import starters as compressor_scenes
from vibecalc.parts import starters as engine_scenes
from vibecalc.parts import starters as pump_scenes
from vibecalc.parts.drive_rules import KEYS
from vibecalc.roll import starters as roll_scenes
from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# What the starter cases say: plain dicts; comments, units and bounds come from the schema.
# ----------------------------------------------------------------------------


class Scene(NamedTuple):
    """A starter case: one line about it, and its keys as a case writes them."""

    about: str
    data: dict[str, Any]


def _machine(train: dict[str, Any], speed: str = "1500 rpm") -> dict[str, Any]:
    return {"kind": "generator", "speed": speed, "crank_train": train}


def _cylinders(pitch: float, phases: list[int]) -> list[dict[str, Any]]:
    first = -pitch * (len(phases) - 1) / 2.0
    return [
        {
            "name": str(number + 1),
            "position": f"{first + number * pitch:g} mm",
            "crank_phase": f"{phase} deg",
        }
        for number, phase in enumerate(phases)
    ]


def _train(pitch: float, phases: list[int]) -> dict[str, Any]:
    return {
        "crank_radius": "55 mm",
        "rod_length": "190 mm",
        "reciprocating_mass": "900 g",
        "cylinders": _cylinders(pitch, phases),
    }


_CORNERS = [[f"{x} m", f"{y} m", f"{z} m"] for x, y, z in
            ((-0.45, -0.25, 0), (-0.45, 0.25, 0), (0.45, -0.25, 0), (0.45, 0.25, 0))]  # fmt: skip
_BOX = {"length": "0.9 m", "width": "0.5 m", "height": "0.6 m"}
_MOUNTS = {"each": {"stiffness": "60 N/mm", "damping": "150 N*s/m"}, "positions": _CORNERS}

_GENERATOR = Scene(
    "a three-cylinder generator set that pitches on four mounts, with a run-up and a limit",
    {
        "schema": 1,
        "title": "Three-cylinder generator set on four mounts",
        "machine": {
            **_machine(_train(110.0, [0, 120, 240])),
            "body": {"mass": "180 kg", "box": _BOX},
            "mounts": _MOUNTS,
        },
        "isolation": {"model": "pitch", "run_up": {"from": "0 rpm", "to": "1800 rpm"}},
        "limit": [
            {
                "quantity": "isolation/support_force/steady_peak",
                "max": "200 N",
                "source": "specification of the foundation",
            }
        ],
    },
)

_RIGID_BODY = Scene(
    "a single-cylinder set with counterweight and balance shaft, all six freedoms",
    {
        "schema": 1,
        "title": "Single-cylinder generator set, balanced, on four tilted mounts",
        "machine": {
            **_machine(
                {
                    "crank_radius": "40 mm",
                    "rod_length": "140 mm",
                    "piston_mass": "350 g",
                    "pin_mass": "90 g",
                    "rod": {"mass": "450 g", "crank_pin_to_mass_centre": "42 mm"},
                    "rotating_mass": "300 g",
                    "origin": ["0 m", "0 m", "-50 mm"],
                    "cylinders": [{"name": "1"}],
                    "counterweights": [
                        {"name": "web", "unbalance": "0.03 kg*m", "phase": "180 deg"}
                    ],
                    "balance_shafts": [
                        {
                            "name": "opposite",
                            "unbalance": "0.011 kg*m",
                            "speed_ratio": -1,
                            "phase": "180 deg",
                            "position": ["0 m", "60 mm", "-50 mm"],
                        }
                    ],
                },
                speed="3000 rpm",
            ),
            "rotor": {"inertia": "0.08 kg*m^2"},
            "body": {"mass": "60 kg", "inertia": ["1.6 kg*m^2", "2.1 kg*m^2", "1.9 kg*m^2"]},
            "mounts": {
                "each": {
                    "stiffness": ["20 N/mm", "20 N/mm", "35 N/mm"],
                    "loss_factor": 0.1,
                },
                "individual": [
                    {
                        "name": f"{end} {side}",
                        "position": [f"{x} m", f"{y} m", "-0.15 m"],
                        "orientation": [f"{tilt} deg", "0 deg", "0 deg"],
                    }
                    for end, x in (("rear", -0.25), ("front", 0.25))
                    for side, y, tilt in (("right", -0.2, -30), ("left", 0.2, 30))
                ],
            },
        },
        "excitation": {"driven_machine": "on_body"},
        "isolation": {"model": "rigid_body", "run_up": {"from": "0 rpm", "to": "3600 rpm"}},
        "limit": [
            {
                "quantity": "isolation/support_force/steady_peak",
                "max": "500 N",
                "source": "specification of the foundation",
            }
        ],
    },
)

_BALANCE = Scene(
    "the balance of a four-cylinder crank train: sums, residual, motion of the pistons",
    {
        "schema": 1,
        "title": "Balance of a four-cylinder crank train",
        "machine": _machine(_train(100.0, [0, 180, 180, 0])),
        "kinematics": {"series": "exact"},
        "excitation": {
            "balance": {"orders": [1, 2, 4]},
            "residual": {"force_weight": 1.0, "couple_weight": 1.0, "reference_length": "300 mm"},
        },
    },
)

_MOUNT_DESIGN = Scene(
    "stiffness and damping of mounts that keep two force limits with the least excursion",
    {
        "schema": 1,
        "title": "Mounts for a generator set within its force limits",
        "machine": {
            **_machine(
                {
                    "crank_radius": "60 mm",
                    "rod_length": "200 mm",
                    "reciprocating_mass": "400 g",
                    "cylinders": _cylinders(300.0, [120, 0, 240]),
                },
                speed="4900 rpm",
            ),
            "body": {"mass": "100 kg", "box": _BOX},
            "mounts": {
                "each": {"stiffness": "10 N/mm", "damping": "50 N*s/m"},
                "positions": _CORNERS,
            },
        },
        "isolation": {"model": "pitch", "run_up": {"from": "0 rpm", "to": "4900 rpm"}},
        "optimisation": {
            "variables": [
                {
                    "key": "machine.mounts.each.stiffness",
                    "lower": "5 N/mm",
                    "upper": "500 N/mm",
                },
                {
                    "key": "machine.mounts.each.damping",
                    "lower": "5 N*s/m",
                    "upper": "1000 N*s/m",
                },
            ],
            "objective": {"quantity": "isolation/support_displacement/excursion", "sense": "min"},
        },
        "limit": [
            {
                "quantity": "isolation/support_force/steady_peak",
                "max": "100 N",
                "source": "specification, steady state",
            },
            {
                "quantity": "isolation/support_force/run_up_peak",
                "max": "400 N",
                "source": "specification, run-up",
            },
        ],
    },
)

_CRANK_ANGLES = Scene(
    "crank angles of a three-cylinder train with the least weighted residual",
    {
        "schema": 1,
        "title": "Crank angles of a three-cylinder train with the least residual",
        "machine": _machine(_train(110.0, [0, 100, 200])),
        "excitation": {
            "balance": {"orders": [1, 2]},
            "residual": {"force_weight": 1.0, "couple_weight": 0.1, "reference_length": "220 mm"},
        },
        "optimisation": {
            "variables": [
                {
                    "key": f"machine.crank_train.cylinders[{number}].crank_phase",
                    "lower": "0 deg",
                    "upper": "360 deg",
                }
                for number in (1, 2)
            ],
            "objective": {"quantity": "excitation/residual", "sense": "min"},
            "starts": 8,
        },
    },
)

SCENES: dict[str, Scene] = {
    "generator": _GENERATOR,
    "rigid_body": _RIGID_BODY,
    "balance": _BALANCE,
    "mount_design": _MOUNT_DESIGN,
    "crank_angles": _CRANK_ANGLES,
    "compressor": Scene(
        "a compressor on one or two cylinders: modes, motion, energies of every operation",
        compressor_scenes.COMPRESSOR,
    ),
    "switching": Scene(
        "the change of a compressor from two cylinders to one, through its resonances",
        compressor_scenes.SWITCHING,
    ),
    "impact": Scene(
        "impacts in a wrist pin with play, as statistics over many runs",
        compressor_scenes.IMPACT,
    ),
    "counterweight": Scene(
        "a counterweight with angle that brings the energies of two operations down",
        compressor_scenes.BALANCE,
    ),
    "roll": Scene(
        "rotor, pistons and shell of a compressor, with the speed that its motor finds",
        roll_scenes.ROLL,
    ),
    "roll_control": Scene(
        "control of a compressor's motor against the roll of its shell",
        roll_scenes.ROLL_CONTROL,
    ),
    "plate": Scene(
        "translation, roll and pitch of a rigid plate, from levels measured on it",
        roll_scenes.PLATE,
    ),
    "absorber": Scene(
        "an absorber in ratios: the spring and the damper that keep the primary stillest",
        absorber_scenes.ABSORBER,
    ),
    "absorber_rig": Scene(
        "a torsional rig with an absorber: rod, springs, gap and oils, and which of them to buy",
        absorber_scenes.ABSORBER_RIG,
    ),
    "pendulum": Scene(
        "pendulums on a rotor that follow an order of its speed",
        absorber_scenes.PENDULUM,
    ),
    "engine": Scene(
        "torsional vibration of the shaft line of an engine with damper, flywheel and generator",
        engine_scenes.ENGINE,
    ),
    "pump": Scene(
        "a plunger pump on two mounts: valves, torque of the liquid, motion in the crank plane",
        pump_scenes.PUMP,
    ),
}

# ----------------------------------------------------------------------------
# What the kinds of machine and motor need, as conditions of the JSON schema.
# ----------------------------------------------------------------------------

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


# ----------------------------------------------------------------------------
# Starter cases with a comment on every key, and the JSON schema, both made from the schema.
# ----------------------------------------------------------------------------

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
