"""What a mount does under load, in its travel and over frequency, as a case writes it."""

from typing import Annotated, Literal

from pydantic import Field

from vibecalc.core.case.fields import Force, Frequency, Length, Number, Table, Unit, key
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

    stiffness: Stiffnesses | None = key("dynamic, in all directions, one per row", None)
    stiffness_factor: Factors | None = key("on the stiffness, instead of it", None)


class OverFrequency(DynamicStiffness):
    """Dynamic stiffness and loss factor of a mount against the frequency of its vibration."""

    frequency: Frequencies = key("ascending, e.g. '10 Hz'")
    loss_factor: Losses | None = key("one per row", None)
    RULES = (
        ascending("frequency"),
        same_length("frequency", "stiffness", "stiffness_factor", "loss_factor"),
        at_most_one("stiffness", "stiffness_factor"),
        needs("", "stiffness stiffness_factor loss_factor"),
    )


class OverLoad(DynamicStiffness):
    """Dynamic stiffness of a mount against its static load; over dynamic_to_static, its tangent."""

    load: Loads = key("compression along its axis, ascending")
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

    deflection: Deflections = key("ascending; 0 where the body is placed")
    load: Loads = key("ascending, one per row")
    RULES = (ascending("deflection"), ascending("load"), same_length("deflection", "load"))


class Stops(Table):
    """Bump stops of a mount, besides its own stiffness."""

    down: Length | None = key("compression at which it is reached, from zero load", None, ge=0)
    up: Length | None = key("extension at which it is reached, from zero load", None, ge=0)
    stiffness: Stiff = key("of the stop, added when reached")
    RULES = (needs("", "down up"),)


class Static(Table):
    """A mount at rest: data of its static deflection, tangent stiffness and clearance."""

    dynamic_to_static: Number = key(
        "dynamic over static stiffness, in all directions", 1.0, gt=0, le=20
    )
    axis: Literal["x", "y", "z"] | None = key(
        "the mount's own axis of load and stops; default: `up` of [isolation]", None
    )
    cubic_stiffness: Cubic | None = key("coefficient of the deflection cubed, along the axis", None)
    load_deflection: LoadDeflection | None = key(
        "along the axis, where stiffness may then be 0: a table or a CSV", None
    )
    stops: Stops | None = key("bump stops along the axis", None)
    RULES = (at_most_one("load_deflection", "cubic_stiffness"),)
