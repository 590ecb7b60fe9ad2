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
    key,
)
from vibecalc.core.case.rules import by_kind, one_of, ordered, same_length

# ----------------------------------------------------------------------------
# What the gas does to a piston over one turn, as a table. Each may stand in a CSV.
# ----------------------------------------------------------------------------

#: not below that of an empty cylinder
GasPressureValue = Annotated[float, Field(ge=-1e5), Unit("Pa", "a pressure")]


class GasPressure(Table):
    """Pressure on the piston over one turn, of an engine over one cycle."""

    crank_angle: tuple[Angle, ...] = key(
        "ascending, the last one turn (of an engine: one cycle) after the first",
        min_length=3,
        max_length=2000,
    )
    pressure: tuple[GasPressureValue, ...] = key(
        "above crankcase pressure, one per angle", min_length=3, max_length=2000
    )
    RULES = (same_length("crank_angle", "pressure"),)


class GasForce(Table):
    """Force on the piston over one turn of its own cylinder; positive pushes towards the crank."""

    crank_angle: tuple[Angle, ...] = key(
        "of this cylinder, from its own top dead centre; the last one turn after the first",
        min_length=1,
        max_length=2000,
    )
    force: tuple[Force, ...] = key(
        "of the gas on the piston, one per angle", min_length=1, max_length=2000
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
    """Pressure over a cycle at one speed."""

    speed: AngularSpeed = key("crank speed of the card", gt=0)
    gas_pressure: GasPressure = key("over one cycle: a table or a CSV")


class GasCycle(Table):
    """Computed cycle instead of a measured card; keys left out have usual values."""

    kind: Literal["spark", "diesel"] = key(
        "combustion at constant volume first, or limited by the peak pressure"
    )
    compression_ratio: Number | None = key("largest volume over the smallest", None, gt=1, le=60)
    intake_pressure: Pressure | None = key(
        "absolute, in the cylinder before the compression", None, gt=0
    )
    exhaust_pressure: Pressure | None = key("absolute, in the cylinder during exhaust", None, gt=0)
    crankcase_pressure: Pressure | None = key(
        "absolute, under the piston; default: 101325 Pa", None, gt=0
    )
    peak_pressure: Pressure | None = key("absolute; it or mean_indicated_pressure", None, gt=0)
    mean_indicated_pressure: Pressure | None = key(
        "work per cycle over swept volume; negative: motored", None
    )
    compression_exponent: Exponent | None = key("polytropic", None)
    expansion_exponent: Exponent | None = key("polytropic", None)
    combustion_starts: CycleAngle | None = key("crank angle of the cylinder", None)
    combustion_ends: CycleAngle | None = key("crank angle of the cylinder", None)
    injection_ends: CycleAngle | None = key("end of constant pressure of a diesel", None)
    inlet_closes: CycleAngle | None = key("start of compression", None)
    exhaust_opens: CycleAngle | None = key("end of expansion", None)
    overlap: Angle | None = key("half width of the gas exchange, four-stroke", None, gt=0, le=1.5)
    RULES = (
        one_of("peak_pressure", "mean_indicated_pressure"),
        by_kind("cycle", spark="", diesel="| injection_ends"),
    )


# ----------------------------------------------------------------------------
# What the cylinders of a pump do over a turn: two pressures and a liquid that yields a little.
# ----------------------------------------------------------------------------

Volume = Annotated[float, Unit("m^3")]


class PumpCycle(Table):
    """Suction, compression, discharge and re-expansion; valves open and close by pressure."""

    suction_pressure: Pressure = key("absolute, in the cylinder during suction", gt=0)
    discharge_pressure: Pressure = key("absolute, in the cylinder during discharge", gt=0)
    bulk_modulus: Modulus = key("of the liquid with the cylinder walls: -V dp/dV", gt=0)
    dead_volume: Volume = key("of one cylinder at top dead centre", gt=0)
    outside_pressure: Pressure = key("absolute, on the other side of the plunger", 101325.0, gt=0)
    RULES = (
        ordered(
            "suction_pressure",
            "discharge_pressure",
            "a pump delivers at a higher pressure than it draws at",
        ),
    )
