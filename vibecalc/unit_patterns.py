"""The units of each dimension as regular expressions, for the JSON schema.

A regular expression cannot count powers, so that it is a list of ways to write a dimension: those
of `unit_table.py`, with every name that pint has for the units in them, and every prefix. What is
matched here is read by `units.py` (a test generates texts from the patterns); `units.py` reads
products in other orders, and units that engineers seldom use, besides.
"""

import functools
import re

from vibecalc.errors import UnitError
from vibecalc.unit_table import TABLE
from vibecalc.units import OTHER_NAMES, convert, read_unit, registry

# ----------------------------------------------------------------------------
# Numbers. An exponent of two digits keeps every product finite.
# ----------------------------------------------------------------------------

_DIGITS = "[0-9]+(?:_[0-9]+)*"
_UNSIGNED = rf"(?:{_DIGITS}(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]{{1,2}})?"
NUMBER = f"[-+−]?{_UNSIGNED}"
_ZERO = r"(?:0(?:_?0)*(?:\.0*)?|\.0+)(?:[^0-9._]|$)"
#: how a text begins whose number is not from, or not above zero
LESS = {"from_0": "^ *[-−]", "above_0": rf"^ *(?:[-−]|\+?{_ZERO})"}
#: what stands before a unit whose zero is not that of the SI unit, and before the SI unit itself,
#: where that is not below zero, or above it
SHIFTED = {"K": ("(?:degC|°C)", rf"(?:\+?{_UNSIGNED}|[-−]1?[0-9]{{1,2}}(?:\.[0-9]*)?)")}
_ABOVE_ZERO = (
    r"(?:(?:0_?)*[1-9][0-9]*(?:_[0-9]+)*(?:\.[0-9]*)?|(?:0(?:_?0)*)?\.0*[1-9][0-9]*)"
    "(?:[eE][-+]?[0-9]{1,2})?"
)
_BEFORE = {"": NUMBER, "from_0": rf"\+?{_UNSIGNED}", "above_0": rf"\+?{_ABOVE_ZERO}"}


def text_pattern(unit: str, least: str = "") -> str:
    """What a text may be that is read in this SI unit.

    `least` says of a unit in `SHIFTED` that the number in SI is not below zero, or above it.
    """
    text = f"{_BEFORE[least]}(?:{_units(unit)})?"
    if unit in SHIFTED:
        shifted, above = SHIFTED[unit]
        text = f"(?:{text}|{above if least else NUMBER} *{shifted})"
    return f"^ *{text} *$"


# ----------------------------------------------------------------------------
# Names of single units, by their dimension.
# ----------------------------------------------------------------------------

_SYMBOLS = ["n", "u", "µ", "μ", "m", "c", "d", "h", "k", "M", "G", "T"]
_WORDS = ["micro", "milli", "centi", "kilo", "mega", "giga"]
#: units that pint has and `unit_table.py` has not
_FURTHER = ("hp", "hour")
#: read as they are, and in no other way
_ALONE = ("%", "dB", "°")

Dimension = tuple[tuple[str, float], ...]


@functools.cache
def _dimension(name: str) -> Dimension | None:
    """The powers of a single unit; None for what is none."""
    try:
        return tuple(sorted(read_unit(name)[1].items()))
    except UnitError:
        return None


@functools.cache
def _names() -> dict[Dimension, str]:
    """What a single unit of a dimension may be called, as a regular expression."""
    factors = {one for unit in TABLE for one, _ in _factors(unit)}
    plain: dict[str, None] = {}
    for name in (*sorted(factors - {"%", "dB"}), *OTHER_NAMES, *_FURTHER):
        prefix, base, _ = registry().parse_unit_name(name)[0]
        definition = registry()._units[base]
        aliases = (base, definition.symbol, *definition.aliases, *(() if prefix else (name,)))
        plain |= dict.fromkeys(one for one in aliases if re.fullmatch(r"[^\W\d_]+", one))
    found: dict[Dimension, dict[str, list[str]]] = {}
    for name in plain:
        dimension = _dimension(name)
        if dimension is None:
            continue
        word = len(name) > 3 and name.islower()
        known = _WORDS if word else _SYMBOLS
        prefixes = [one for one in known if _dimension(one + name) == dimension]
        many = "s?" if word and name[-1] not in "shz" else ""
        found.setdefault(dimension, {}).setdefault(_any_of(prefixes, "?"), []).append(name + many)
    for name in _ALONE:
        found.setdefault(_dimension(name) or (), {}).setdefault("", []).append(name)
    return {
        dimension: "|".join(prefix + _any_of(names) for prefix, names in forms.items())
        for dimension, forms in found.items()
    }


def _any_of(texts: list[str], after: str = "") -> str:
    if not texts:
        return ""
    if len(texts) == 1 and not after:
        return texts[0]
    if all(len(one) == 1 for one in texts):
        return f"[{''.join(texts)}]{after}"
    return f"(?:{'|'.join(texts)}){after}"


# ----------------------------------------------------------------------------
# Products of them.
# ----------------------------------------------------------------------------

_TIMES = "(?: *[*·×] *| +)"
_OVER = " */ *"
#: what engineers write together, as in kNm, Nms/rad, kgm2, Ns/m
_TOGETHER = {"N": "[kMGm]?N", "m": "(?:mm|cm|m)", "s": "s", "kg": "k?g"}
_ORDERS = ("N", "m", "s"), ("kg", "m")

Factors = tuple[tuple[str, int], ...]


def _factors(unit: str) -> Factors:
    """The single units of a product, with their powers; below a line negative."""
    above, _, below = unit.partition("/")
    parts = [(one, 1) for one in above.split("*") if one not in ("", "1")]
    parts += [(one, -1) for one in below.split("*") if one]
    named = [(*one.partition("^")[::2], sign) for one, sign in parts]
    return tuple((name, sign * int(power or 1)) for name, power, sign in named)


def _units(unit: str) -> str:
    """The units that a value of this SI unit may be written in, after a number."""
    same = [name for name in (unit, *TABLE) if name and name != "dB" and _fits(name, unit)]
    ways = {_of_dimensions(_factors(name)): None for name in same}
    if unit == "dB":
        return " *dB"
    beside = {name for name, _ in _factors(unit)} - {"rad"}
    unwritten = _dimension("rad") if beside and beside != {"s"} else None  # turns or radians?
    once = [way for way in ways if (*way, (unwritten, -1)) not in ways]
    texts = [text for way in once for text in _written(way, unwritten)]
    apart = [text for text in texts if text.startswith("1")]  # else a digit of the number
    close = [text for text in texts if text not in apart]
    groups = ((" *", close), (" +", apart))
    return "|".join(f"{space}(?:{'|'.join(group)})" for space, group in groups if group)


def _fits(name: str, unit: str) -> bool:
    try:
        convert(1.0, name, unit)
    except UnitError:
        return False
    return True


Way = tuple[tuple[Dimension | None, int], ...]


def _of_dimensions(factors: Factors) -> Way:
    return tuple((_dimension(name), power) for name, power in factors)


def _written(way: Way, unwritten: Dimension | None) -> list[str]:
    """How a product of dimensions is written: its factors in either order, and together.

    What is `unwritten` need not stand below the line.
    """
    above = [factor for factor in way if factor[1] > 0]
    parts = [(one, f"{_OVER}{_one(one, -power)}") for one, power in way if power < 0]
    below = "".join(f"(?:{text})?" if one == unwritten else text for one, text in parts)
    if not above:
        return [f"1{below}"]
    orders = [above, [above[1], above[0], *above[2:]]] if len(above) > 1 else [above]
    texts = [_TIMES.join(_one(*factor) for factor in order) + below for order in orders]
    return [*texts, *(together + below for together in _together(above))]


def _one(dimension: Dimension | None, power: int) -> str:
    names = _names()[dimension or ()]
    return f"(?:{names if power == 1 else names.removesuffix('|°')})" + _power(power)


def _power(power: int) -> str:
    return rf"(?:(?:\^|\*\*)?{power}|{' ²³'[power - 1]})" if power > 1 else ""


def _together(above: list[tuple[Dimension | None, int]]) -> list[str]:
    symbols = {_dimension(name): name for name in _TOGETHER}
    names = [symbols.get(dimension, "") for dimension, _ in above]
    for order in _ORDERS:
        if len(names) > 1 and [name for name in order if name in names] == names:
            parts = [
                _TOGETHER[one] + _power(power) for one, (_, power) in zip(names, above, strict=True)
            ]
            return [f"{_TIMES}?".join(("".join(parts[:2]), *parts[2:]))]
    return []
