"""Kinds of field that only an absorber has: temperatures, viscosities, moduli, ratios."""

from typing import Annotated

from pydantic import Field

from vibecalc.case.fields import Unit

#: K, of 0 degrees Celsius
ICE = 273.15
Temperature = Annotated[float, Field(gt=0), Unit("K")]
LinearStiffness = Annotated[float, Unit("N/m")]
LinearDamping = Annotated[float, Unit("N*s/m")]
Modulus = Annotated[float, Field(gt=0), Unit("Pa")]
KinematicViscosity = Annotated[float, Field(gt=0), Unit("m^2/s")]
Density = Annotated[float, Field(gt=0), Unit("kg/m^3")]
#: zero is a limit: no spring, no damper
Share = Annotated[float, Field(ge=0), Unit("")]
Positive = Annotated[float, Field(gt=0), Unit("")]
PartNumber = Annotated[int, Field(strict=True, ge=0, le=10**9)]
