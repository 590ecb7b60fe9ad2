"""The units of each dimension as regular expressions, for the JSON schema.

A regular expression cannot count powers, so that it is a list of ways to write a dimension: those
of `unit_table.py`, with the names and prefixes that engineers use for the units in them. What is
matched here is read by `units.py` (a test generates texts from the patterns); `units.py` reads
products in other orders, and units that engineers seldom use, besides.
"""

import functools

from vibecalc.errors import UnitError
from vibecalc.unit_table import TABLE
from vibecalc.units import convert, read_unit

# ----------------------------------------------------------------------------
# Numbers. An exponent of two digits keeps every product finite.
# ----------------------------------------------------------------------------

_DIGITS = "[0-9]+(_[0-9]+)*"
_EXPONENT = "([eE][-+]?[0-9]{1,2})?"
_UNSIGNED = rf"({_DIGITS}(\.[0-9]*)?|\.[0-9]+){_EXPONENT}"
_ABOVE_ZERO = rf"((0_?)*[1-9][0-9]*(_[0-9]+)*(\.[0-9]*)?|(0(_?0)*)?\.0*[1-9][0-9]*){_EXPONENT}"
#: a number, one from 0 and one above 0
NUMBERS = {"": f"[-+−]?{_UNSIGNED}", "from_0": rf"\+?{_UNSIGNED}", "above_0": rf"\+?{_ABOVE_ZERO}"}
#: what may be a number, for the pattern of its unit; and what follows the number in its own pattern
WRITTEN = f"[-+−0-9._]+{_EXPONENT}"
_REST = "([^-+−0-9._].*)?$"
#: what stands before a unit whose zero is not that of the SI unit, and before the SI unit itself,
#: where that is not below zero, or above it
SHIFTED = {"K": ("(degC|°C)", rf"(\+?{_UNSIGNED}|[-−]1?[0-9]{{1,2}}(\.[0-9]*)?)")}


def number_pattern(least: str = "") -> str:
    """How a text begins with a number, which may be from 0 or above it (`least`)."""
    return f"^ *{NUMBERS[least]}{_REST}"


def unit_pattern(unit: str) -> str:
    """How a text ends with a unit that is read in this SI unit, after what may be a number."""
    return f"^ *{WRITTEN}({_units(unit)})? *$"


def shifted_pattern(unit: str, least: str) -> str:
    """What a text may be that is read in a unit in `SHIFTED`, whose number in SI is `least`."""
    scale, above = SHIFTED[unit]
    text = f"{NUMBERS[least]}({_units(unit)})?"
    return f"^ *({text}|{above if least else NUMBERS['']} *{scale}) *$"


# ----------------------------------------------------------------------------
# Names of single units, by their dimension.
# ----------------------------------------------------------------------------

#: what may stand before symbols, and before words
_SYMBOL, _WORD = "[nuµμmcdhkMGT]?", "(micro|milli|centi|kilo|mega|giga)?"
#: a unit of each dimension -> symbols and words that take these, and symbols and words that stand
#: as they are (a min is no inch, a kt no tonne)
_CALLED: dict[str, tuple[str, str, str, str]] = {
    "": ("", "", "%", ""),
    "N": ("N|lbf|kgf", "newtons?", "", ""),
    "Pa": ("Pa", "pascals?", "[mk]?bar|k?psi", ""),
    "Hz": ("Hz|rpm", "hertz", "", ""),
    "J": ("J", "joules?", "", ""),
    "W": ("W", "watts?", "hp", "horsepower"),
    "V": ("V", "volts?", "", ""),
    "H": ("H", "henrys?", "", ""),
    "ohm": ("ohm|Ω", "ohms?", "", ""),
    "K": ("K", "kelvins?", "", ""),
    "St": ("St", "stokes", "", ""),
    "m": ("m", "met(er|re)s?", "in|ft", "inch|inches|foot|feet"),
    "m^3": ("[lL]", "lit(er|re)s?", "", ""),
    "kg": ("g", "grams?|tonnes?", "t|lb|oz", "pounds?|ounces?|slugs?"),
    "s": ("s", "seconds?", "sec|min|h", "minutes?|hours?"),
    "rad": ("rad", "radians?", "deg|rev|turn|°", "degrees?|turns|revolutions?"),
}

Dimension = tuple[tuple[str, float], ...]


@functools.cache
def _dimension(name: str) -> Dimension:
    """The powers of a single unit."""
    return tuple(sorted(read_unit(name)[1].items()))


def _either(names: str) -> str:
    return f"({names})" if "|" in names else names


@functools.cache
def _names(alone: bool) -> dict[Dimension, str]:
    """What a unit of a dimension may be called, as a regular expression; in words where `alone`."""
    found = {}
    for unit, (symbols, words, others, other_words) in _CALLED.items():
        forms = [_SYMBOL + _either(symbols) if symbols else "", others]
        if alone:
            forms += [_WORD + _either(words) if words else "", other_words]
        found[_dimension(unit)] = "|".join(filter(None, forms))
    return found


# ----------------------------------------------------------------------------
# Products of them.
# ----------------------------------------------------------------------------

_TIMES = "( *[*·×] *| +)"
_OVER = " */ *"
#: what engineers write together, as in kNm, Nms/rad, kgm2, Ns/m
_TOGETHER = {"N": "[kMGm]?N", "m": "(mm|cm|m)", "s": "s", "kg": "k?g"}
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
    return "|".join(f"{space}({'|'.join(group)})" for space, group in groups if group)


def _fits(name: str, unit: str) -> bool:
    try:
        convert(1.0, name, unit)
    except UnitError:
        return False
    return True


Way = tuple[tuple[Dimension, int], ...]


def _of_dimensions(factors: Factors) -> Way:
    return tuple((_dimension(name), power) for name, power in factors)


def _written(way: Way, unwritten: Dimension | None) -> list[str]:
    """How a product of dimensions is written: its factors in either order, and together.

    What is `unwritten` need not stand below the line.
    """
    above = [factor for factor in way if factor[1] > 0]
    if way == (*above[:1],):
        return [_one(*above[0], alone=True)]
    parts = [(one, f"{_OVER}{_one(one, -power)}") for one, power in way if power < 0]
    below = "".join(f"({text})?" if one == unwritten else text for one, text in parts)
    if not above:
        return [f"1{below}"]
    orders = [above, [above[1], above[0], *above[2:]]] if len(above) > 1 else [above]
    texts = [_TIMES.join(_one(*factor) for factor in order) + below for order in orders]
    return [*texts, *(together + below for together in _together(above))]


def _one(dimension: Dimension, power: int, alone: bool = False) -> str:
    names = _names(alone)[dimension]
    return f"({names if power == 1 else names.removesuffix('|°')})" + _power(power)


def _power(power: int) -> str:
    return rf"((\^|\*\*)?{power}|{' ²³'[power - 1]})" if power > 1 else ""


def _together(above: list[tuple[Dimension, int]]) -> list[str]:
    symbols = {_dimension(name): name for name in _TOGETHER}
    names = [symbols.get(dimension, "") for dimension, _ in above]
    for order in _ORDERS:
        if len(names) > 1 and [name for name in order if name in names] == names:
            parts = [
                _TOGETHER[one] + _power(power) for one, (_, power) in zip(names, above, strict=True)
            ]
            return [f"{_TIMES}?".join(("".join(parts[:2]), *parts[2:]))]
    return []
