"""Values as a source prints them: number, unit, and half a unit of the last printed digit."""

from decimal import Decimal
from typing import NamedTuple

from vibecalc.units import split_number


class Printed(NamedTuple):
    """A printed value: `number` and `half_unit` are in `unit`, `text` has the digits as written."""

    number: float
    unit: str
    half_unit: float
    text: str


def read_printed(value: float | str, unit: str = "", default_unit: str = "") -> Printed:
    """Read a reference value.

    The unit is the one in the text, else `unit`, else `default_unit` (that of the quantity).
    Half a unit of the last digit counts the digits of the text: "93 N" gives .5, "0.079" .0005,
    "1e-3" .0005, "1.20e-3" 5e-6. A number that is not a text counts as Python prints it, without
    the ".0" of a whole one; whoever means a zero after the point writes a text.
    """
    if isinstance(value, str):
        digits, own_unit = split_number(value)
        digits = digits.replace("_", "")
        unit = own_unit or unit
    else:
        digits = repr(float(value)).removesuffix(".0")
    unit = unit or default_unit
    exponent = Decimal(digits).as_tuple().exponent
    if not isinstance(exponent, int):
        raise ValueError(f"not a finite number: {value!r}")
    half_unit = float(Decimal((0, (5,), exponent - 1)))
    return Printed(float(digits), unit, half_unit, digits)
