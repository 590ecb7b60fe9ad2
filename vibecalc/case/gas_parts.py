"""What the gas does to a piston over one turn, as a table. Each may stand in a CSV."""

from typing import Literal

from pydantic import Field

from vibecalc.case.fields import Angle, Force, Pressure, Table

GasInterpolation = Literal["linear", "parabola", "cubic", "trigonometric"]


class GasPressure(Table):
    """Pressure on the piston over one turn, or over one cycle of an engine."""

    crank_angle: tuple[Angle, ...] = Field(
        min_length=3,
        max_length=2000,
        description="ascending, the last one turn (of an engine: one cycle) after the first",
    )
    pressure: tuple[Pressure, ...] = Field(
        min_length=3, max_length=2000, description="above that of the crankcase, one per angle"
    )


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
