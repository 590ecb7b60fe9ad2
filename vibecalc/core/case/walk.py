"""The schema, asked by key path: what may stand at `machine.crank_train.cylinders[0].position`?

Messages, the optimiser's variables and the tests of starter cases all read it from here.
"""

import functools
import math
import operator
import re
import types
from typing import Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin

from pydantic.fields import FieldInfo

from vibecalc.core.case.fields import DeferredTable, Kind, Table, Unit
from vibecalc.core.results.named import named
from vibecalc.errors import KeyPath, Problem, UnitError
from vibecalc.unit_table import DIMENSIONS
from vibecalc.units import allowed_words, describe, parse_quantity

BOUND_SIGNS = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
COMPARE = {"gt": operator.gt, "ge": operator.ge, "lt": operator.lt, "le": operator.le}


class Shape(NamedTuple):
    """What a place in a case may hold.

    `kind` is table, list, number, whole, flag, choice, text, value (a number, or a text with a
    unit) or labels; `table` belongs to a table, `item` to a list, `unit`, `noun` (what it is),
    `examples` (in quotes) and `bounds` to a number; `lengths` are the fewest and the most entries
    of a list or letters of a text. `or_three` marks a number that may also be three, `difference`
    one of temperatures.
    """

    kind: str
    unit: str | None = None
    bounds: tuple[tuple[str, float], ...] = ()
    choices: tuple[Any, ...] = ()
    table: type[Table] | None = None
    item: "Shape | None" = None
    lengths: tuple[int, int | None] = (0, None)
    or_three: bool = False
    noun: str = ""
    examples: str = ""
    difference: bool = False

    def number(self, written: float | str) -> float:
        """A value of such a place in SI, as its field reads it. Raises UnitError."""
        return parse_quantity(written, self.unit or "", difference=self.difference)

    def allows(self, value: float) -> bool:
        """Whether a number in SI keeps the bounds of this place."""
        return all(COMPARE[name](value, bound) for name, bound in self.bounds)


def keys_of(table: type[Table]) -> dict[str, FieldInfo]:
    """Fields of a table under the keys that a case writes (`from`, not `start`)."""
    return {field.alias or name: field for name, field in table.model_fields.items()}


def shape_of(field: FieldInfo) -> Shape:
    """Return the shape of one field."""
    return _shape(field.annotation, tuple(field.metadata))


@functools.lru_cache(maxsize=4096)
def shape_at(path: KeyPath) -> Shape | None:
    """Return what may stand at a key path, or None if the schema has no such place."""
    shape = Shape(kind="table", table=named("vibecalc.schema:Case"))
    for part in path:
        if shape.table is not None and isinstance(part, str):
            field = keys_of(shape.table).get(part)
            if field is None:
                return None
            shape = shape_of(field)
        elif shape.item is not None and isinstance(part, int):
            shape = shape.item
        elif shape.or_three and isinstance(part, int):
            shape = shape._replace(or_three=False)
        else:
            return None
    return shape


def with_names(shape: Shape | None, value: Any) -> Any:
    """A list of names, where a shell was given whole numbers for some: [1, 3, 2] of cylinders."""
    of_texts = shape is not None and shape.item is not None and shape.item.kind == "text"
    if of_texts and isinstance(value, list | tuple):
        return [str(one) if type(one) is int else one for one in value]
    return value


def words(shape: Shape) -> str:
    """Say in a line what a place may hold: "a length > 0 m, e.g. '0.2 m' or '200 mm'"."""
    fewest, most = shape.lengths
    if shape.kind == "number":
        bounds = bound_words(shape)
        written = " or ".join(f"'{one}'" for one in examples_of(shape))
        example = f", e.g. {written}" if shape.unit in DIMENSIONS else ""
        three = ", or a list of three" if shape.or_three else ""
        return f"{noun(shape)} {bounds}".rstrip() + three + example
    if shape.kind == "whole":
        return f"a whole number {bound_words(shape)}".strip()
    if shape.kind == "choice":
        listed = ", ".join(repr(choice) for choice in shape.choices)
        return f"one of {listed}" if len(shape.choices) > 1 else listed
    if shape.kind == "list":
        plain = shape.item and shape.item.kind != "table"
        each = f"each {words(shape.item)}" if shape.item and plain else ""
        size = f"{fewest} or more" if most is None else f"{fewest} to {most}"
        size = f"a list of {fewest if fewest == most else size} entries"
        return ", ".join(filter(None, (size, each)))
    if shape.kind == "text":
        return "a text" if most is None else f"a text of {fewest} to {most} characters"
    if shape.kind == "table":
        return f"a table with {', '.join(keys_of(shape.table))}" if shape.table else "a table"
    if shape.kind == "flag":
        return "true or false"
    if shape.kind == "labels":
        return "up to 8 names of axes, each with a number or text"
    return "a finite number, or a text with a unit such as '100 N'"


def unit_problem(error: UnitError, path: KeyPath, shape: Shape | None, of: str) -> Problem:
    """What is wrong with the value at a place; `of` comes before the words of the error.

    Where the error says no more than the unit does of what is allowed, the place says it.
    """
    bounds = f", {bound_words(shape)}" if shape and shape.bounds else ""
    allowed = error.allowed + bounds
    if shape is not None and error.allowed in ("", allowed_words(shape.unit or "")):
        allowed = words(shape)
    return Problem(path, of + error.message, error.found, allowed, error.hint)


def noun(shape: Shape) -> str:
    """What a number is, in words: "a length", "a frequency"."""
    return shape.noun or describe(shape.unit or "")


def examples_of(shape: Shape) -> list[str]:
    """What may be written for a number: examples of its kind within its bounds, or one between."""
    unit = shape.unit or ""
    known = DIMENSIONS[unit].examples if unit in DIMENSIONS else ""
    written = re.findall("'([^']*)'", shape.examples or known)
    within = [one for one in written if shape.allows(parse_quantity(one, unit))]
    if within:
        return within
    bounds = dict(shape.bounds)
    low, high = bounds.get("gt", bounds.get("ge")), bounds.get("lt", bounds.get("le"))
    if low is not None and high is not None:
        far = low > 0.0 and high > 1e3 * low
        between = math.sqrt(low * high) if far else 0.5 * (low + high) or 0.5 * high
    elif low is not None:
        between = 2.0 * low if low > 0.0 else low + 1.0
    else:
        between = min(1.0, 0.0 if high is None else high - 1.0)
    return [f"{between:.4g} {unit}".strip()]


def bound_words(shape: Shape) -> str:
    """Say the bounds of a number: "> 0 m and <= 2 m", or nothing."""
    unit = f" {shape.unit}" if shape.unit else ""
    return " and ".join(f"{BOUND_SIGNS[name]} {bound:g}{unit}" for name, bound in shape.bounds)


def _shape(annotation: Any, metadata: tuple[Any, ...]) -> Shape:
    named = next((mark.name for mark in metadata if isinstance(mark, Kind)), None)
    if named is not None:
        return Shape(kind=named)
    origin = get_origin(annotation)
    for mark in metadata if annotation is Any else ():
        if isinstance(mark, DeferredTable):
            return _shape(mark.target, ())
    if origin is Annotated:
        inner, *marks = get_args(annotation)
        return _shape(inner, (*_flat(marks), *metadata))
    if origin in (Union, types.UnionType):
        members = [member for member in get_args(annotation) if member is not type(None)]
        first = _shape(members[0], metadata)
        return first._replace(or_three=True) if len(members) > 1 else first
    limits = {name: value for mark in metadata for name, value in _marks(mark)}
    lengths = (int(limits.get("min_length", 0)), limits.get("max_length"))
    if origin is tuple:
        members = [member for member in get_args(annotation) if member is not Ellipsis]
        if get_args(annotation)[-1] is not Ellipsis:
            lengths = (len(members), len(members))
        return Shape(kind="list", item=_shape(members[0], ()), lengths=lengths)
    if origin is Literal:
        return Shape(kind="choice", choices=get_args(annotation))
    if isinstance(annotation, type) and issubclass(annotation, Table):
        return Shape(kind="table", table=annotation)
    if annotation is str:
        return Shape(kind="text", lengths=lengths)
    if annotation is bool:
        return Shape(kind="flag")
    bounds = _stricter({name: float(limits[name]) for name in BOUND_SIGNS if name in limits})
    unit = next((mark for mark in metadata if isinstance(mark, Unit)), Unit(""))
    return Shape(
        kind="whole" if annotation is int else "number",
        unit=unit.symbol,
        bounds=bounds,
        noun=unit.noun,
        examples=unit.examples,
        difference=unit.difference,
    )


def _stricter(limits: dict[str, float]) -> tuple[tuple[str, float], ...]:
    """One bound for each side: a field may sharpen that of its type, as in > 0 next to >= 0."""
    for excluding, including, sharper in (("gt", "ge", 1.0), ("lt", "le", -1.0)):
        if excluding in limits and including in limits:
            excluded = sharper * (limits[excluding] - limits[including]) >= 0.0
            del limits[including if excluded else excluding]
    return tuple(limits.items())


def _flat(marks: list[Any]) -> list[Any]:
    nested = [mark.metadata if isinstance(mark, FieldInfo) else [mark] for mark in marks]
    return [mark for group in nested for mark in group]


def _marks(mark: Any) -> list[tuple[str, Any]]:
    names = (*BOUND_SIGNS, "min_length", "max_length")
    return [(name, getattr(mark, name)) for name in names if getattr(mark, name, None) is not None]
