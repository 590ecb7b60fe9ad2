"""The kinds of field a case is made of: numbers with units, points, names, ranges of speeds."""

import functools
import math
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    Tag,
    TypeAdapter,
)
from pydantic_core import core_schema

from vibecalc.core.results.named import named
from vibecalc.core.results.renamed import current_axis, current_path, current_where
from vibecalc.errors import UnitError
from vibecalc.units import as_double, parse_quantity, split_number

# ----------------------------------------------------------------------------
# The kinds of field a case is made of: a number with a unit, a point, a name.
#
# A value is a number in SI (radians for angles) or a string with a unit. The unit stands here and
# in the catalogue of quantities, nowhere else: messages, the JSON schema and resolved
# cases read it from the field.
# ----------------------------------------------------------------------------


@dataclass(frozen=True)
class Unit:
    """Marks a number with the unit that it has once it is read, and reads texts in any unit.

    Where a unit stands for several things, `noun` says which this is, and `examples` (in quotes)
    what it may look like; a difference of temperatures is not read from a scale with another zero.
    """

    symbol: str
    noun: str = ""
    examples: str = ""
    difference: bool = False

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        number = handler(source)  # a float schema with the bounds of the field
        number.update(strict=True, allow_inf_nan=False)
        return core_schema.no_info_before_validator_function(self._read, number)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        number = handler(schema["schema"])
        return {"anyOf": [number, {"type": "string", "maxLength": 120}], "unit": self.symbol}

    def _read(self, value: Any) -> Any:
        if isinstance(value, str):
            return parse_quantity(value, self.symbol, difference=self.difference)
        return _double(value)


@dataclass(frozen=True)
class Kind:
    """Names a kind of field that its type alone does not tell."""

    name: str


#: the table whose validator is being built
_building: ContextVar[Any] = ContextVar("_building", default=None)


def _none(table: Any) -> list[Any]:
    return []


def _whole_json(whole: Any, handler: Any, name: str = "") -> dict[str, Any]:
    """The JSON schema of what is built elsewhere; under a name a definition of its own."""
    ends = whole["type"] == "definitions"
    inner, others = (whole["schema"], whole["definitions"]) if ends else (whole, [])
    inner = {**inner, "ref": name} if name else inner
    found: dict[str, Any] = handler(core_schema.definitions_schema(inner, others))
    return found


class Table(BaseModel):
    """A table of a case: unknown keys are errors, nothing changes after reading."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)
    #: rules between its keys (`rules.py`), or `module:name` of one that is imported with the table
    RULES: ClassVar[tuple[Any, ...]] = ()

    @classmethod
    def model_rebuild(cls, **options: Any) -> bool | None:
        """Build what validates this table, and not what validates the tables below it."""
        before = _building.set(cls)
        try:
            return super().model_rebuild(**options)
        finally:
            _building.reset(before)

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: Any) -> core_schema.CoreSchema:
        if _building.get() is cls:
            built: core_schema.CoreSchema = handler(source)
            return built
        return core_schema.no_info_plain_validator_function(cls.model_validate)

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema: Any, handler: Any) -> dict[str, Any]:
        if core_schema["type"] == "function-plain":
            name = f"{cls.__module__}.{cls.__qualname__}:{id(cls)}"
            return {"allOf": [_whole_json(cls.__pydantic_core_schema__, handler, name)]}
        schema: dict[str, Any] = handler(core_schema)
        rules = [one for rule in cls.RULES for one in getattr(rule, "schema", _none)(cls)]
        if rules:
            handler.resolve_ref_schema(schema)["allOf"] = rules
        return schema


def key(words: str, default: Any = ..., **bounds: Any) -> Any:
    """A key of a table: its description, its default (without one it is required), its bounds."""
    return Field(default, description=words, **bounds)


@dataclass(frozen=True)
class DeferredTable:
    """A table that is imported, and its schema built, where a case has it: `later` names it."""

    where: str

    @functools.cached_property
    def target(self) -> Any:
        """The annotation that stands at `module:name`."""
        return named(self.where)

    @functools.cached_property
    def adapter(self) -> "TypeAdapter[Any]":
        """What validates it."""
        return TypeAdapter(self.target)

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self._read)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        return _whole_json(self.adapter.core_schema, handler)

    def _read(self, value: Any) -> Any:
        return self.adapter.validate_python(value)


def later(names: dict[str, str]) -> dict[str, Any]:
    """Stand-ins for tables in annotations, by their name; `names` lists them for each module."""
    return {
        name: Annotated[Any, DeferredTable(f"{module}:{name}")]
        for module, listed in names.items()
        for name in listed.split()
    }


def _double(value: Any) -> Any:
    """A whole number as a double; UnitError where it is too large for one."""
    return as_double(value) if type(value) is int else value


def _read_value(value: Any) -> Any:
    if isinstance(value, str):
        number, _ = split_number(value)
        if not math.isfinite(float(number)):
            raise UnitError("too large for a double", found=repr(value))
        return value
    return _double(value)


def _read_whole(value: Any) -> Any:
    # 1.0 and true equal 1, but neither is what a person means who writes a whole number
    if isinstance(value, bool) or not isinstance(value, int):
        raise UnitError("not a whole number", found=str(value).lower()[:40])
    return value


def _read_label(value: Any) -> None:
    small = isinstance(value, int | float) and abs(value) < 1e300  # false for nan, inf
    if isinstance(value, bool) or not (isinstance(value, str) or small):
        raise UnitError("not a label", found=str(value).lower()[:40])


def read_labels(value: Any, swept: bool = False) -> Any:
    """Numbers and texts as they are; of what is `swept` also true and false, lists and tables."""
    rows = value.values() if isinstance(value, dict) else value
    for one in rows if isinstance(value, dict | list | tuple) else ():
        if swept and isinstance(one, dict | list | tuple):
            read_labels(one, swept)
        elif not (swept and isinstance(one, bool)):
            _read_label(one)
    return value


def _one_or_three(value: Any) -> str:
    return THREE_TAG if isinstance(value, list | tuple) else ONE_TAG


def _number_or_text(value: Any) -> str:
    return TEXT_TAG if isinstance(value, str) else ONE_TAG


ONE_TAG, THREE_TAG, TEXT_TAG = "one-number", "three-numbers", "text"
UNION_TAGS = frozenset({ONE_TAG, THREE_TAG, TEXT_TAG})

Number = Annotated[float, Unit("")]
Length = Annotated[float, Unit("m")]
Mass = Annotated[float, Unit("kg")]
Inertia = Annotated[float, Unit("kg*m^2")]
Unbalance = Annotated[float, Unit("kg*m")]
Angle = Annotated[float, Unit("rad")]
AngularSpeed = Annotated[float, Unit("rad/s", "an angular speed", "'513 rad/s' or '4900 rpm'")]
Frequency = Annotated[float, Unit("rad/s", "a frequency", "'50 Hz' or '314 rad/s'")]
Acceleration = Annotated[float, Unit("m/s^2")]
Moment = Annotated[float, Unit("N*m", "a torque")]
Pressure = Annotated[float, Unit("Pa", "a pressure")]
Stress = Annotated[float, Unit("Pa", "a stress", "'80 MPa' or '80 N/mm^2'")]
Force = Annotated[float, Unit("N")]
AngularStiffness = Annotated[float, Unit("N*m/rad")]
AngularDamping = Annotated[float, Unit("N*m*s/rad")]
Voltage = Annotated[float, Unit("V")]
Resistance = Annotated[float, Unit("ohm")]
Modulus = Annotated[float, Field(gt=0), Unit("Pa", "an elastic modulus", "'80 GPa'")]
Density = Annotated[float, Field(gt=0), Unit("kg/m^3")]
Level = Annotated[float, Unit("dB")]
Time = Annotated[float, Unit("s")]
Stiffness = Annotated[float, Field(ge=0), Unit("N/m")]
Damping = Annotated[float, Field(ge=0), Unit("N*s/m")]

Whole = BeforeValidator(_read_whole)
WholeNumber = Annotated[int, Field(strict=True, ge=0, le=2000)]
Where = Annotated[
    dict[str, int | float | str],
    Field(max_length=8),
    AfterValidator(current_where),
    BeforeValidator(read_labels),
    Kind("labels"),
]
Labels = Annotated[
    tuple[int | float | str, ...],
    Field(max_length=20_000),
    BeforeValidator(read_labels),
    Kind("labels"),
]
#: as a list of labels, and true or false, lists and tables in it
Swept = Annotated[
    tuple[Any, ...],
    Field(max_length=20_000),
    BeforeValidator(functools.partial(read_labels, swept=True)),
    Kind("labels"),
]
Point = tuple[Length, Length, Length]
Name = Annotated[str, Field(min_length=1, max_length=80)]
ResultPath = Annotated[Name, AfterValidator(current_path)]
ResultAxis = Annotated[Name, AfterValidator(current_axis)]

#: one number for all directions, or three along the mount's own axes
StiffnessOrThree = Annotated[
    Annotated[Stiffness, Tag(ONE_TAG)]
    | Annotated[tuple[Stiffness, Stiffness, Stiffness], Tag(THREE_TAG)],
    Discriminator(_one_or_three),
]
DampingOrThree = Annotated[
    Annotated[Damping, Tag(ONE_TAG)] | Annotated[tuple[Damping, Damping, Damping], Tag(THREE_TAG)],
    Discriminator(_one_or_three),
]

#: a number or a text with a unit, kept as written: its unit is that of a result
Value = Annotated[
    Annotated[float, Field(strict=True, allow_inf_nan=False), Tag(ONE_TAG)]
    | Annotated[str, Tag(TEXT_TAG)],
    Discriminator(_number_or_text),
    BeforeValidator(_read_value),
    Kind("value"),
]

# ----------------------------------------------------------------------------
# A range of crank speeds.
# ----------------------------------------------------------------------------


class RunUp(Table):
    """A slow run-up: at each speed the peak over the cycle."""

    model_config = ConfigDict(validate_by_alias=True, validate_by_name=False)

    start: AngularSpeed = key("lowest speed", 0.0, alias="from", ge=0)
    stop: AngularSpeed = key("highest speed", alias="to", gt=0)
    RULES: ClassVar[tuple[Any, ...]] = ("vibecalc.core.case.rules:upwards",)
