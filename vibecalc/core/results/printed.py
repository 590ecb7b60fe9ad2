"""Values as a source prints them: number, unit, what their last digit leaves open."""

import math
from collections.abc import Mapping
from decimal import Decimal
from typing import Any, NamedTuple

from vibecalc.units import convert, split_number

# ----------------------------------------------------------------------------
# Values as a source prints them: number, unit, and half a unit of the last printed digit.
# ----------------------------------------------------------------------------


class PrintedValue(NamedTuple):
    """A printed value: `number` and `half_unit` are in `unit`, `text` has the digits as written."""

    number: float
    unit: str
    half_unit: float
    text: str


def read_printed(value: float | str, unit: str = "", default_unit: str = "") -> PrintedValue:
    """Read a reference value.

    The unit is the one in the text, else `unit`, else `default_unit` (that of the quantity).
    Half a unit of the last digit counts the digits of the text: "93 N" gives .5, "0.079" .0005,
    "1e-3" .0005, "1.20e-3" 5e-6. A number that is not a text counts as Python prints it, without
    the ".0" of a whole one; whoever means a zero after the point writes a text.
    """
    if isinstance(value, str):
        digits, printed_unit = split_number(value)
        digits = digits.replace("_", "")
        unit = printed_unit or unit
    else:
        digits = repr(float(value)).removesuffix(".0")
    unit = unit or default_unit
    exponent = Decimal(digits).as_tuple().exponent
    if not isinstance(exponent, int):
        raise ValueError(f"not a finite number: {value!r}")
    half_unit = float(Decimal((0, (5,), exponent - 1)))
    return PrintedValue(float(digits), unit, half_unit, digits)


# ----------------------------------------------------------------------------
# How far off a reference may be: what the case says of it, else its last digit.
# ----------------------------------------------------------------------------


def tolerance_of(entry: Mapping[str, Any], printed: PrintedValue) -> float:
    """How far off the value of a [[reference]] may be, in its unit.

    That is `atol`, else `rtol` times the value, else half a unit of the last printed digit, a whole
    one where the source cut its digits off.
    """
    if entry.get("atol") is not None:
        given = read_printed(entry["atol"], default_unit=printed.unit)
        return convert(given.number, given.unit, printed.unit)
    if entry.get("rtol") is not None:
        return float(entry["rtol"]) * abs(printed.number)
    return printed.half_unit * (2.0 if entry.get("digits") == "truncated" else 1.0)


def uncertainty_of(entry: Mapping[str, Any], printed: PrintedValue) -> float:
    """Standard uncertainty of the value of a [[reference]], in its unit.

    That is `uncertainty`, in percent of the value or in the value's unit; else that of an error of
    which only the limits are known, the tolerance over sqrt 3 (JCGM 100:2008, 4.3.7).
    """
    given = entry.get("uncertainty")
    if given is None:
        return tolerance_of(entry, printed) / math.sqrt(3.0)
    if isinstance(given, str) and split_number(given)[1] == "%":
        return float(split_number(given)[0]) / 100.0 * abs(printed.number)
    stated = read_printed(given, default_unit=printed.unit)
    return convert(stated.number, stated.unit, printed.unit)
