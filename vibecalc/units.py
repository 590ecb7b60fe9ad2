"""Values with units. Inside vibecalc everything is SI and radians; conversion happens here, once.

The units that cases use most, and products of them, are read from a small table (held equal to pint
by a test); pint, which takes a good part of a second to import, reads the rest. Hz and rpm are
turns per second and minute, so 1 Hz is 2 pi rad/s, as an engineer means it. An angle is a dimension
of its own here: "30 deg" is not read as a mass ratio of 0.52. Only inside a compound may the radian
stay unwritten ("N*m" for "N*m/rad"), and not beside the second alone: "1/s" may be rad/s or Hz. A
decibel is a dimension of its own, too: what a level refers to is said by the name of the quantity.
"""

import functools
import math
import re
from typing import Any

from vibecalc.errors import UnitError
from vibecalc.unit_table import DIMENSIONS, MEANT, POWERS, TABLE

_LONGEST_TEXT = 120
_CELSIUS, _ICE = ("degC", "°C"), 273.15
SHIFTED = {*_CELSIUS, "celsius", "degF", "°F", "fahrenheit"}

_NUMBER_AND_UNIT = re.compile(r"([+-]?(?:\d[\d_]*\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*)\Z", re.S)
_FACTOR = re.compile(r"([^\W\d]\w*?|%)(?:(?:\^|\*\*)?([+-]?\d))?\Z")
#: products written together, as in MNm/rad, kgm2, Nms/rad
_TOGETHER = re.compile(r"(?<!\w)(?:([kMGm]?N)(mm|cm|m)?(s)?|(kg|g)(mm|cm|m))(?=\W|[\d²³]|\Z)")
_SPELLINGS = str.maketrans(
    {"−": "-", "·": "*", "×": "*", "²": "^2", "³": "^3", "⁻": "^-", "¹": "1"}
)
#: units that a refusal may mean, besides those of the table
OTHER_NAMES = ("ft", "oz", "kgf", "t", "um", "km", "min", "turn", "rev", "kHz",
                "millimeter", "millimetre", "meter", "metre", "inch", "gram", "kilogram",
                "newton", "degree", "radian", "second", "slug", "W")  # fmt: skip


def split_number(text: str) -> tuple[str, str]:
    """Split "2.375 in" into ("2.375", "in"), both as written; UnitError if no number leads."""
    stripped = text.strip().replace("−", "-")
    match = _NUMBER_AND_UNIT.match(stripped) if len(stripped) <= _LONGEST_TEXT else None
    if match is None:
        word = stripped.lower().lstrip("+-").split(" ")[0]
        raise UnitError(
            "not finite" if word in ("nan", "inf", "infinity") else "not a number",
            found=_quoted(text),
            allowed="a finite number, or a text of number and unit such as '200 mm'",
        )
    number, unit = match.groups()
    if unit.startswith(","):
        dotted = stripped.replace(",", ".", 1)
        raise UnitError("not a number", found=_quoted(text), hint=f"write a point: '{dotted}'")
    return number, unit


def parse_quantity(text: str | float, unit: str, *, difference: bool = False) -> float:
    """Read a text such as "200 mm", "4900 rpm", "1e4 N/m" or "400" as a number in an SI unit.

    A text without a unit, and a number, are in the SI unit already. UnitError says what was found,
    its dimension in words and what is allowed; a result that is not finite, or that underflows
    to zero, is refused. Temperatures may be in degC, but for a `difference` of them.
    """
    if not isinstance(text, str):
        number = as_double(text)
        if not math.isfinite(number):
            raise UnitError("not finite", found=repr(number), allowed=allowed_words(unit))
        return number
    try:
        digits, written = split_number(text)
        number = float(digits)
        if unit == "K" and written in _CELSIUS and not difference:
            value = number + _ICE
        else:
            value = number * (_factor(written, unit) if written else 1.0)
    except UnitError as error:
        alone = error.message in ("not a number", "not finite", "unknown unit")
        found = error.found if alone else f"{_quoted(text)}, {error.found}"
        allowed = allowed_words(unit) if alone else error.allowed or allowed_words(unit)
        raise UnitError(error.message, found=found, allowed=allowed, hint=error.hint) from None
    except ValueError:
        raise UnitError("not a number", found=_quoted(text), allowed=allowed_words(unit)) from None
    vanished = value == 0.0 and re.search("[1-9]", digits.lower().split("e")[0])
    if vanished or not math.isfinite(value):
        size, allowed = "small" if value == 0.0 else "large", allowed_words(unit)
        raise UnitError(f"too {size} for a double", found=_quoted(text), allowed=allowed)
    return value


def as_double(number: float) -> float:
    """A number as a double; UnitError for a whole number that is too large for one."""
    try:
        return float(number)
    except OverflowError:
        raise UnitError("too large for a double", found="a huge whole number") from None


def si_value(text: str | float) -> float:
    """Read a value of any dimension in SI base units (a text without a unit is in them already)."""
    if not isinstance(text, str):
        return parse_quantity(text, "")
    number, unit = split_number(text)
    return float(number) * (TABLE[unit][0] if unit in TABLE else read_unit(unit)[0])


def convert(value: float, from_unit: str, to_unit: str) -> float:
    """Convert a number between two units; UnitError if their dimensions differ."""
    return value * _factor(from_unit, to_unit)


def describe(unit: str) -> str:
    """Say the dimension of an SI unit in words: "m" is "a length"."""
    return DIMENSIONS[unit].words if unit in DIMENSIONS else f"a value in {unit}"


def allowed_words(unit: str) -> str:
    """What may be written for an SI unit: "a length, e.g. '0.2 m' or '200 mm'"."""
    examples = f", e.g. {DIMENSIONS[unit].examples}" if unit in DIMENSIONS else ""
    return describe(unit) + examples


def _quoted(text: str) -> str:
    return repr(text if len(text) <= 40 else text[:37] + "...")


@functools.lru_cache(maxsize=512)
def _factor(unit: str, wanted: str) -> float:
    """Return what a number in unit `unit` is multiplied with to be in unit `wanted`."""
    unit = _apart(unit)
    meant = MEANT.get(re.sub(r"\s", "", unit).translate(_SPELLINGS).replace("*min^-1", "/min"))
    if meant:
        raise UnitError("unknown unit", found=_quoted(unit), hint=f"did you mean {meant}?")
    if {unit, wanted} & SHIFTED:
        name = unit if unit in SHIFTED else wanted
        hint = "20 degC are 293.15 K"
        raise UnitError("a scale with a zero of its own", found=name, hint=hint)
    if unit in TABLE and wanted in TABLE:
        (factor, si), (wanted_factor, wanted_si) = TABLE[unit], TABLE[wanted]
        same = si == wanted_si or si == wanted_si.removesuffix("/rad")
        if same or {si, wanted_si} == {"J", "N*m"}:
            return factor / wanted_factor
        raise _mismatch(describe(si), unit, wanted)
    factor, dimension = read_unit(unit)
    wanted_factor, wanted_dimension = read_unit(wanted)
    unwritten_radian = "radian" not in dimension and len(wanted_dimension) > 1
    without_angle = {name: power for name, power in wanted_dimension.items() if name != "radian"}
    if dimension == wanted_dimension:
        return factor / wanted_factor
    if unwritten_radian and dimension == without_angle:
        if without_angle.keys() == {"second"}:
            raise UnitError(
                "turns or radians?",
                found="which does not say of what",
                hint=_turns_and_radians(wanted, factor),
            )
        return factor / wanted_factor
    words = " or ".join(describe(si) for si in DIMENSIONS if read_unit(si)[1] == dimension)
    terms = (
        f"{name}^{power:g}" if power != 1 else name for name, power in sorted(dimension.items())
    )
    raise _mismatch(words or f"a value in {'*'.join(terms)}", unit, wanted)


def _turns_and_radians(wanted: str, factor: float) -> str:
    if wanted == "rad/s":
        turns = "'Hz' or 'rev/s'" if factor == 1.0 else "'rpm'"
    else:
        turns = repr(wanted.replace("rad", "rev"))
    return f"did you mean {turns} (turns, cycles, samples) or {wanted!r} (radians)?"


def _apart(unit: str) -> str:
    """A unit with signs between all its factors, which engineers leave out: "kN*m" for "kNm"."""
    apart = _TOGETHER.sub(lambda match: "*".join(part for part in match.groups() if part), unit)
    return re.sub(r"\b(m|mm|cm|s)([2-9])(?!\d)", r"\1^\2", apart) if apart != unit else unit


def _mismatch(words: str, unit: str, wanted: str) -> UnitError:
    twins = [name for name in TABLE if name != unit and name.lower() == unit.lower()]
    hint = f"did you mean '{twins[0]}'?" if twins else ""
    return UnitError("wrong dimension", found=words, allowed=allowed_words(wanted), hint=hint)


@functools.lru_cache(maxsize=512)
def read_unit(unit: str) -> tuple[float, dict[str, float]]:
    """Read a product of named units: factor to SI, and the powers of the SI base units.

    The expression is taken apart here, since pint's own parser would also evaluate 9^9^9^9.
    """
    factor, dimension = 1.0, dict[str, float]()
    tidy = _apart(unit).translate(_SPELLINGS).replace("**", "^").replace("°", " deg ").strip()
    tidy = tidy.replace("^-^", "^-")
    tidy = re.sub(r"\s*([*/^()])\s*", r"\1", tidy)
    signs, sign, operand_next = [1], 1, True
    for token in re.findall(r"[()*/]|\s+|[^()*/\s]+", tidy):
        if operand_next is (token in ("*", "/", ")") or token.isspace()):
            raise _unknown(unit, unit)
        if token == "(":
            signs.append(sign)
        elif token == ")":
            signs.pop()
            operand_next = False
        elif token == "/":
            sign, operand_next = -signs[-1], True
        elif token == "*" or token.isspace():
            sign, operand_next = signs[-1], True
        else:
            operand_next = False
            if token == "1":
                continue
            match = _FACTOR.match(token)
            if match is None:
                raise _unknown(token, unit)
            power = sign * int(match[2] or 1)
            base, powers = _atom(match[1], unit)
            try:
                factor *= base**power
            except OverflowError:
                raise UnitError("too large for a double", found=_quoted(unit)) from None
            for name, exponent in powers.items():
                dimension[name] = dimension.get(name, 0) + exponent * power
        if not signs:
            raise _unknown(unit, unit)
    if len(signs) != 1 or (operand_next and tidy):
        raise _unknown(unit, unit)
    return factor, {name: power for name, power in dimension.items() if power}


def _atom(name: str, unit: str) -> tuple[float, dict[str, float]]:
    known = TABLE.get(name)
    if known is not None and known[1] in POWERS:
        return known[0], POWERS[known[1]]
    asked = re.sub(r"(Hz|hertz)\Z", "turn_per_second", name)
    try:
        base = registry().Quantity(1.0, asked).to_base_units()
    except Exception as error:  # pint raises errors of many kinds; all of them mean: not a unit
        raise _unknown(name, unit) from error
    powers = {str(key): float(power) for key, power in base.unit_items()}
    return float(base.magnitude), powers


def _unknown(name: str, unit: str) -> UnitError:
    import difflib

    known = {key.lower(): key for key in (*OTHER_NAMES, *TABLE) if key}
    near = difflib.get_close_matches(name.lower()[:40], known, n=1, cutoff=0.5)
    hint = f"did you mean '{known[near[0]]}'?" if near else "units are written like 'N*s/m'"
    inside = "" if name == unit else f" in {_quoted(unit)}"
    return UnitError("unknown unit", found=_quoted(name) + inside, hint=hint)


@functools.cache
def registry() -> Any:
    import pint

    registry: Any = pint.UnitRegistry()
    registry.define("turn_per_second = turn / second")
    registry.define("@alias turn = rev")
    return registry
