"""What a mount does under load, in its travel and over frequency, as a case writes it."""

from typing import Annotated, Literal

from pydantic import Field

from vibecalc.core.case.fields import Force, Frequency, Length, Number, Table, Unit
from vibecalc.core.case.rules import ascending, at_most_one, needs, same_length

_Rows = Field(min_length=2, max_length=200)
Stiff = Annotated[float, Field(gt=0), Unit("N/m")]
Cubic = Annotated[float, Field(ge=0), Unit("N/m^3", "a cubic stiffness")]
Stiffnesses = Annotated[tuple[Stiff, ...], _Rows]
Factors = Annotated[tuple[Annotated[float, Field(gt=0, le=100), Unit("")], ...], _Rows]
Losses = Annotated[tuple[Annotated[float, Field(ge=0, le=10), Unit("")], ...], _Rows]
Frequencies = Annotated[tuple[Annotated[Frequency, Field(ge=0)], ...], _Rows]
Loads = Annotated[tuple[Force, ...], _Rows]
Deflections = Annotated[tuple[Length, ...], _Rows]

# ----------------------------------------------------------------------------
# Dynamic stiffness over frequency and over the load that the mount carries.
#
# A column is either the stiffness itself or a factor on the one that the mount has otherwise.
# ----------------------------------------------------------------------------


class DynamicStiffness(Table):
    """A column of stiffness or of a factor on it."""

    stiffness: Stiffnesses | None = Field(
        None, description="dynamic, in all directions, one per row"
    )
    stiffness_factor: Factors | None = Field(None, description="on the stiffness, instead of it")


class OverFrequency(DynamicStiffness):
    """Dynamic stiffness and loss factor of a mount against the frequency of its vibration."""

    frequency: Frequencies = Field(description="ascending, e.g. '10 Hz'")
    loss_factor: Losses | None = Field(None, description="one per row")
    RULES = (
        ascending("frequency"),
        same_length("frequency", "stiffness", "stiffness_factor", "loss_factor"),
        at_most_one("stiffness", "stiffness_factor"),
        needs("", "stiffness stiffness_factor loss_factor"),
    )


class OverLoad(DynamicStiffness):
    """Dynamic stiffness of a mount against its static load; over dynamic_to_static, its tangent."""

    load: Loads = Field(description="compression along its axis, ascending")
    RULES = (
        ascending("load"),
        same_length("load", "stiffness", "stiffness_factor"),
        at_most_one("stiffness", "stiffness_factor"),
        needs("", "stiffness stiffness_factor"),
    )


# ----------------------------------------------------------------------------
# At rest: static stiffness, load over deflection along one axis, stops.
# ----------------------------------------------------------------------------


class LoadDeflection(Table):
    """Static load of a mount over its deflection, both positive in compression."""

    deflection: Deflections = Field(description="ascending; 0 where the body is placed")
    load: Loads = Field(description="ascending, one per row")
    RULES = (ascending("deflection"), ascending("load"), same_length("deflection", "load"))


class Stops(Table):
    """What ends the travel of a mount, beside its own stiffness."""

    down: Length | None = Field(
        None, ge=0, description="compression of the mount from zero load at which it touches"
    )
    up: Length | None = Field(
        None, ge=0, description="extension of the mount from zero load at which it touches"
    )
    stiffness: Stiff = Field(description="of the stop, added once it touches")
    RULES = (needs("", "down up"),)


class Static(Table):
    """A mount at rest: what its sag, its tangent stiffness there and its clearance come from."""

    dynamic_to_static: Number = Field(
        1.0, gt=0, le=20, description="stiffness over that for the sag, in all directions"
    )
    axis: Literal["x", "y", "z"] | None = Field(
        None, description="the mount's own axis of load and stops; default: `up` of [isolation]"
    )
    cubic_stiffness: Cubic | None = Field(
        None, description="times the deflection cubed, along the axis"
    )
    load_deflection: LoadDeflection | None = Field(
        None, description="along the axis, where stiffness may then be 0: a table or a CSV"
    )
    stops: Stops | None = Field(None, description="bump stops along the axis")
    RULES = (at_most_one("load_deflection", "cubic_stiffness"),)
