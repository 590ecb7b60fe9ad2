"""Rules of a comparison: which quantities are compared how, and how closely.

A rules file is TOML::

    [default]
    rtol = 1e-7

    [[rule]]
    quantity = "isolation/*/natural_frequency"   # the last rule that fits counts, key by key
    rtol = 1e-6
    atol = "1e-3 rad/s"                          # a number is in the unit of the quantity

    [[rule]]
    quantity = "isolation/masked/*"
    compare = "ignore"
"""

import fnmatch
import math
import tomllib
from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from vibecalc.errors import UnitError, UsageError
from vibecalc.results.select import nearest

#: kind -> what it does, for messages and documents
KINDS = {
    "value": "entry by entry; a complex entry is a point in the plane",
    "vector": "the entries along the last axis are one vector, compared as a whole",
    "phase": "angles modulo one turn; of complex numbers where the amplitude is not too small",
    "spectrum": "along `mode`, after matching modes by frequency and shape",
    "mode_shape": "direction of each mode shape, whatever its sign and scale",
    "curve": "along `speed`, as curves: samples may lie elsewhere",
    "ignore": "not at all",
}


@dataclass(frozen=True, kw_only=True)
class Rule:
    """How one quantity, or all that fit a pattern, is compared; None leaves a key to others.

    rtol
        Tolerance relative to the larger of the reference entry and the scale of the quantity.
    atol
        Absolute tolerance, added; a number in the unit of the quantity, or a text with a unit.
    compare
        One of `KINDS`; without it the quantity decides (complex, axis `mode`, axis `speed`).
    relative_to
        "whole": the scale is the largest magnitude in the quantity; "entry": each entry's own.
    floor
        Amplitude, relative to the largest one, below which a phase says nothing.
    shift
        Half-width of the tube around a curve along its axis, relative to the highest speed.
    repeated
        Modes whose frequencies are this close, relative, are one subspace.
    nan_equal
        Whether NaN equals NaN.
    """

    quantity: str = "*"
    rtol: float | None = None
    atol: float | str | None = None
    compare: str | None = None
    relative_to: str | None = None
    floor: float | None = None
    shift: float | None = None
    repeated: float | None = None
    nan_equal: bool | None = None


#: used where neither a rule nor [default] of a file says otherwise; curves have an rtol of 1e-4
DEFAULT = Rule(
    rtol=1e-7, atol=0.0, relative_to="whole", floor=1e-6, shift=1e-4, repeated=1e-5, nan_equal=False
)
CURVE_RTOL = 1e-4


@dataclass(frozen=True, kw_only=True)
class Rules:
    """Rules in the order of their file; later ones win."""

    default: Rule = Rule()
    rules: tuple[Rule, ...] = ()
    source: str = "built in"

    def given(self, path: str) -> Rule:
        """What the file says about the quantity at `path`, key by key; None where it is silent."""
        found: dict[str, Any] = _said(self.default)
        for rule in self.rules:
            if fnmatch.fnmatchcase(path, rule.quantity):
                found |= _said(rule)
        return Rule(**{**found, "quantity": path})


def completed(rule: Rule, compare: str) -> Rule:
    """`rule` with the built-in defaults for a comparison of kind `compare` in its gaps."""
    standard = _said(DEFAULT)
    if compare == "curve":
        standard["rtol"] = CURVE_RTOL
    return Rule(**{**standard, **_said(rule), "quantity": rule.quantity, "compare": compare})


def absolute_tolerance(rule: Rule, unit: str) -> float:
    """`rule.atol` in `unit`; UsageError names the rule where the dimensions do not agree."""
    if not isinstance(rule.atol, str):
        return float(rule.atol or 0.0)
    from vibecalc.units import parse_quantity

    try:
        return float(parse_quantity(rule.atol, unit))
    except UnitError as error:
        raise UsageError(f"atol = {rule.atol!r} does not fit {rule.quantity}: {error}") from error


def read_rules(path: Path | str) -> Rules:
    """Read a rules file. Raises UsageError that lists all problems of the file at once."""
    try:
        content = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise UsageError(f"cannot read the rules file {path}: {reason}") from error
    except (ValueError, RecursionError) as error:
        raise UsageError(f"{path} is not a TOML file: {error}") from error
    problems = [
        f"unknown table [{name}]; known are {', '.join(nearest(name, ['default', 'rule']))}"
        for name in content
        if name not in ("default", "rule")
    ]
    tables = content.get("rule", [])
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        problems.append("`rule` has to be a list of tables: write [[rule]]")
        tables = []
    default = content.get("default", {})
    if not isinstance(default, dict):
        problems.append("`default` has to be a table: write [default]")
        default = {}
    problems += _problems("[default]", default, _DEFAULT_KEYS)
    for number, table in enumerate(tables, start=1):
        name = f"[[rule]] {number}"
        if "quantity" not in table:
            problems.append(f'{name}: `quantity` is missing, as in quantity = "isolation/*"')
        problems += _problems(name, table, _RULE_KEYS)
    if problems:
        count = f"{len(problems)} problem{'s' if len(problems) > 1 else ''}"
        raise UsageError("\n  ".join([f"{count} in the rules file {path}:", *problems]))
    return Rules(
        default=Rule(**default), rules=tuple(Rule(**table) for table in tables), source=str(path)
    )


def _problems(where: str, table: dict[str, Any], known: tuple[str, ...]) -> list[str]:
    problems = []
    for key, value in table.items():
        if key not in known:
            problems.append(
                f"{where}: unknown key `{key}`; known are {', '.join(nearest(key, known))}"
            )
        elif (wrong := _CHECKS[key](value)) is not None:
            problems.append(f"{where}: {key} = {value!r}: {wrong}")
    return problems


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _tolerance(value: Any) -> str | None:
    return None if _is_number(value) and value >= 0 else "has to be a number, zero or more"


def _absolute(value: Any) -> str | None:
    if isinstance(value, str):
        from vibecalc.units import split_number

        try:
            value = float(split_number(value)[0].replace("_", ""))
        except ValueError:
            return 'has to begin with a number, as in "1e-6 N"'
    return _tolerance(value)


def _one_of(words: tuple[str, ...]) -> Callable[[Any], str | None]:
    def check(value: Any) -> str | None:
        if value in words:
            return None
        return f"has to be one of {', '.join(nearest(str(value), words))}"

    return check


def _pattern(value: Any) -> str | None:
    return None if isinstance(value, str) and value else "has to be a path or pattern"


def _flag(value: Any) -> str | None:
    return None if isinstance(value, bool) else "has to be true or false"


_CHECKS: dict[str, Callable[[Any], str | None]] = {
    "quantity": _pattern,
    "rtol": _tolerance,
    "atol": _absolute,
    "compare": _one_of(tuple(KINDS)),
    "relative_to": _one_of(("whole", "entry")),
    "floor": _tolerance,
    "shift": _tolerance,
    "repeated": _tolerance,
    "nan_equal": _flag,
}
_RULE_KEYS = tuple(_CHECKS)
_DEFAULT_KEYS = tuple(key for key in _CHECKS if key not in ("quantity", "compare"))


def _said(rule: Rule) -> dict[str, Any]:
    """The keys of a rule that say something."""
    pairs = {field.name: getattr(rule, field.name) for field in fields(rule)}
    del pairs["quantity"]
    return {name: value for name, value in pairs.items() if value is not None}
