"""The gas, or a pumped liquid, in the cylinders of a crank train, as a case writes it."""

from typing import Annotated, Literal

from pydantic import Field

from vibecalc.core.case.fields import (
    Angle,
    AngularSpeed,
    Force,
    Modulus,
    Number,
    Pressure,
    Table,
    Unit,
)
from vibecalc.core.case.rules import by_kind, one_of, ordered, same_length

# ----------------------------------------------------------------------------
# What the gas does to a piston over one turn, as a table. Each may stand in a CSV.
# ----------------------------------------------------------------------------

#: not below that of an empty cylinder
GasPressureValue = Annotated[float, Field(ge=-1e5), Unit("Pa", "a pressure")]


class GasPressure(Table):
    """Pressure on the piston over one turn, or over one cycle of an engine."""

    crank_angle: tuple[Angle, ...] = Field(
        min_length=3,
        max_length=2000,
        description="ascending, the last one turn (of an engine: one cycle) after the first",
    )
    pressure: tuple[GasPressureValue, ...] = Field(
        min_length=3, max_length=2000, description="above that of the crankcase, one per angle"
    )
    RULES = (same_length("crank_angle", "pressure"),)


class GasForce(Table):
    """Force on the piston over one turn of its own cylinder; positive pushes towards the crank."""

    crank_angle: tuple[Angle, ...] = Field(
        min_length=1,
        max_length=2000,
        description="of this cylinder, from its own top dead centre; the last one turn after the "
        "first",
    )
    force: tuple[Force, ...] = Field(
        min_length=1, max_length=2000, description="of the gas on the piston, one per angle"
    )
    RULES = (same_length("crank_angle", "force"),)


# ----------------------------------------------------------------------------
# What the cylinders of an engine do over a cycle: cards at several speeds, computed cycles.
# ----------------------------------------------------------------------------

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
    RULES = (
        one_of("peak_pressure", "mean_indicated_pressure"),
        by_kind("cycle", spark="", diesel="| injection_ends"),
    )


# ----------------------------------------------------------------------------
# What the cylinders of a pump do over a turn: two pressures and a liquid that yields a little.
# ----------------------------------------------------------------------------

Volume = Annotated[float, Unit("m^3")]


class PumpCycle(Table):
    """Suction, compression, discharge and re-expansion; the pressures open and close the valves."""

    suction_pressure: Pressure = Field(gt=0, description="absolute, in the cylinder as it fills")
    discharge_pressure: Pressure = Field(
        gt=0, description="absolute, in the cylinder as it delivers"
    )
    bulk_modulus: Modulus = Field(
        gt=0, description="of the liquid with the walls around it: -V dp/dV"
    )
    dead_volume: Volume = Field(
        gt=0, description="liquid left in one cylinder at its top dead centre"
    )
    outside_pressure: Pressure = Field(
        101325.0, gt=0, description="absolute, on the other side of the plunger"
    )
    RULES = (
        ordered(
            "suction_pressure",
            "discharge_pressure",
            "a pump delivers at a higher pressure than it draws at",
        ),
    )
