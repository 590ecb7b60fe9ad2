"""What the cylinders of a pump do over a turn: two pressures and a liquid that yields a little."""

from typing import Annotated

from pydantic import Field

from vibecalc.case.fields import Pressure, Table, Unit

Volume = Annotated[float, Unit("m^3")]


class PumpCycle(Table):
    """Suction, compression, discharge and re-expansion; the pressures open and close the valves."""

    suction_pressure: Pressure = Field(gt=0, description="absolute, in the cylinder as it fills")
    discharge_pressure: Pressure = Field(
        gt=0, description="absolute, in the cylinder as it delivers"
    )
    bulk_modulus: Pressure = Field(
        gt=0, description="of the liquid with the walls around it: -V dp/dV"
    )
    dead_volume: Volume = Field(
        gt=0, description="liquid left in one cylinder at its top dead centre"
    )
    outside_pressure: Pressure = Field(
        101325.0, gt=0, description="absolute, on the other side of the plunger"
    )
