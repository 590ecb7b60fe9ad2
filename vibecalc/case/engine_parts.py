"""What the cylinders of an engine do over a cycle: cards at several speeds, computed cycles."""

from typing import Annotated, Literal

from pydantic import Field

from vibecalc.case.fields import Angle, AngularSpeed, Number, Pressure, Table, Unit
from vibecalc.case.gas_parts import GasPressure

Cycle = Literal["four_stroke", "two_stroke"]
#: of the crank of a cylinder, from its own firing top dead centre
CycleAngle = Annotated[float, Field(ge=-3.1416, le=3.1416), Unit("rad")]
#: of a polytropic change of state
Exponent = Annotated[float, Field(gt=1, lt=2), Unit("")]


class GasCard(Table):
    """The pressure over a cycle at one speed."""

    speed: AngularSpeed = Field(gt=0, description="of the crankshaft, at which it was taken")
    gas_pressure: GasPressure = Field(description="over one cycle: a table or a CSV")


class GasCycle(Table):
    """A cycle to be computed instead of a measured card; what is not said has usual values."""

    kind: Literal["spark", "diesel"] = Field(
        description="heat at constant volume at first, or limited by the peak pressure"
    )
    compression_ratio: Number | None = Field(
        None, gt=1, le=60, description="largest volume over the smallest"
    )
    intake_pressure: Pressure | None = Field(
        None, gt=0, description="absolute, in the cylinder before the compression"
    )
    exhaust_pressure: Pressure | None = Field(
        None, gt=0, description="absolute, in the cylinder as the gas goes out"
    )
    crankcase_pressure: Pressure | None = Field(
        None, gt=0, description="absolute, under the piston; default: 101325 Pa"
    )
    peak_pressure: Pressure | None = Field(
        None, gt=0, description="absolute; it or mean_indicated_pressure"
    )
    mean_indicated_pressure: Pressure | None = Field(
        None, description="work of a cycle over the swept volume; negative: it is driven"
    )
    compression_exponent: Exponent | None = Field(None, description="polytropic")
    expansion_exponent: Exponent | None = Field(None, description="polytropic")
    combustion_starts: CycleAngle | None = Field(None, description="of the own crank angle")
    combustion_ends: CycleAngle | None = Field(None, description="of the own crank angle")
    injection_ends: CycleAngle | None = Field(
        None, description="of a diesel, which holds its pressure up to there"
    )
    inlet_closes: CycleAngle | None = Field(None, description="where the compression begins")
    exhaust_opens: CycleAngle | None = Field(None, description="where the expansion ends")
    overlap: Angle | None = Field(
        None, gt=0, le=1.5, description="half width of the charge exchange, of four strokes"
    )
