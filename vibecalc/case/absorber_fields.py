"""Kinds of field that only an absorber has: temperatures, viscosities, moduli, ratios."""

import math
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import Field
from pydantic_core import core_schema

from vibecalc.case.fields import Unit, as_double
from vibecalc.errors import UnitError
from vibecalc.units import split_number

#: K, of 0 degrees Celsius
ICE = 273.15
#: names of the unit -> kelvins at its zero
_SCALES = {"K": 0.0, "degC": ICE, "°C": ICE}
ALLOWED = "a temperature > 0 K, e.g. '20 degC' or '293.15 K'"


@dataclass(frozen=True)
class Thermometer:
    """Reads a temperature into kelvins: a number is in K, a text says its scale.

    Other units are factors and this one also moves the zero, so that it is no `Unit`.
    """

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        number = handler(source)
        number.update(strict=True, allow_inf_nan=False)
        return core_schema.no_info_before_validator_function(_kelvins, number)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        number = handler(schema["schema"])
        return {"anyOf": [number, {"type": "string", "maxLength": 120}], "unit": "K"}


def _kelvins(value: Any) -> Any:
    if isinstance(value, str):
        value = _read(value)
    elif isinstance(value, bool) or not isinstance(value, int | float):
        raise UnitError("not a temperature", found=type(value).__name__, allowed=ALLOWED)
    number = as_double(value)
    if not math.isfinite(number):
        raise UnitError("not finite", found=str(number), allowed=ALLOWED)
    if number <= 0.0:
        raise UnitError("below absolute zero", found=f"{number:.6g} K", allowed=ALLOWED)
    return number


def _read(value: str) -> float:
    """A text as a number in K."""
    try:
        digits, scale = split_number(value)
    except UnitError as error:
        raise UnitError(error.message, found=error.found, allowed=ALLOWED) from None
    shown = repr(value[:40])
    if scale and scale not in _SCALES:
        hint = "did you mean 'degC'?" if scale.lower() in ("c", "degc", "celsius", "grad") else ""
        raise UnitError("not a scale of temperature", found=shown, allowed=ALLOWED, hint=hint)
    return float(digits) + _SCALES.get(scale, 0.0)


Temperature = Annotated[float, Thermometer()]
LinearStiffness = Annotated[float, Unit("N/m")]
LinearDamping = Annotated[float, Unit("N*s/m")]
Modulus = Annotated[float, Field(gt=0), Unit("Pa")]
KinematicViscosity = Annotated[float, Field(gt=0), Unit("m^2/s")]
Density = Annotated[float, Field(gt=0), Unit("kg/m^3")]
#: zero is a limit: no spring, no damper
Share = Annotated[float, Field(ge=0), Unit("")]
Positive = Annotated[float, Field(gt=0), Unit("")]
PartNumber = Annotated[int, Field(strict=True, ge=0, le=10**9)]
