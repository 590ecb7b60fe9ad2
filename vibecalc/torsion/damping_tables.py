"""Tables of a case for dampings and loads that follow the speed of a shaft line."""

from typing import Annotated, Literal

from pydantic import Field

from vibecalc.core.case.fields import AngularDamping, AngularSpeed, Moment, Number, Table
from vibecalc.core.case.rules import ascending, at_most_one, needs, one_of, refuse, same_length

# ----------------------------------------------------------------------------
# How a damping follows the speed: entries of a table, or a power.
# ----------------------------------------------------------------------------

Speeds = Annotated[
    tuple[Annotated[AngularSpeed, Field(gt=0)], ...], Field(min_length=2, max_length=2000)
]
Factors = Annotated[
    tuple[Annotated[Number, Field(gt=0)], ...], Field(min_length=2, max_length=2000)
]
Torques = Annotated[tuple[Moment, ...], Field(min_length=2, max_length=2000)]


class FactorCurve(Table):
    """A factor against the speed, straight lines between the entries."""

    speed: Speeds = Field(description="ascending")
    factor: Factors = Field(description="on the damping that is given, one per speed")
    RULES = (same_length("speed", "factor"), ascending("speed"))


class OverSpeed(Table):
    """A factor on a damping against the speed, as a table or as a power of the speed."""

    of: Literal["crank", "own"] = Field(
        "crank", description="whose speed: of the crankshaft, or that of its own shaft"
    )
    table: FactorCurve | None = Field(None, description="a table or a CSV")
    exponent: Number | None = Field(
        None, ge=-4, le=4, description="instead: factor (speed / reference) ^ exponent"
    )
    reference: AngularSpeed | None = Field(
        None, gt=0, description="speed at which the damping is as given, with exponent"
    )
    RULES = (
        one_of("table", "exponent reference"),
        needs("exponent", "reference", "at this speed the damping is as given"),
        needs("reference", "exponent", "the power of the speed"),
    )


class LoadCurve(Table):
    """A torque against the speed, straight lines between the entries."""

    speed: Speeds = Field(description="ascending, of the crankshaft")
    torque: Torques = Field(description="mean, on its own shaft; positive brakes; one per speed")
    RULES = (same_length("speed", "torque"), ascending("speed"))


# ----------------------------------------------------------------------------
# Damping of a propeller from its torque, and of the cylinders of an engine.
# ----------------------------------------------------------------------------


class PropellerDamping(Table):
    """Absolute damping from the mean torque T that the load takes at each speed."""

    method: Literal["archer", "slope", "factor"] = Field(
        description="a T / n with n in rpm; dT/dw of the law of the load; or x T / w"
    )
    coefficient: Number | None = Field(
        None, gt=0, le=1000, description="a of archer, default 30; or x of factor"
    )
    RULES = (
        refuse(
            "coefficient",
            "the slope of the law of a load has no coefficient",
            lambda t: t["method"] == "slope" and "coefficient" in t,
            "none, or method = 'factor'",
        ),
        refuse(
            "",
            "method 'factor' needs a coefficient: x in x T / w",
            lambda t: t["method"] == "factor" and "coefficient" not in t,
            "coefficient = 4, for example",
        ),
    )


class EngineDamping(Table):
    """Absolute damping at every station with a cylinder."""

    magnifier: Number | None = Field(
        None, ge=1, le=1e6, description="dynamic magnifier M of its inertia J: J w / M"
    )
    damping_ratio: Number | None = Field(
        None, ge=0, lt=1, description="Lehr's damping ratio D of its inertia: 2 D J w"
    )
    loss_factor: Number | None = Field(
        None, ge=0, le=2, description="of its inertia: loss_factor J w"
    )
    damping: AngularDamping | None = Field(
        None, ge=0, description="viscous, of each station; instead"
    )
    mode: Annotated[int, Field(strict=True, ge=2, le=2000)] | None = Field(
        None,
        description="whose undamped frequency w is, the rigid one is 1; default: lowest elastic",
    )
    over_speed: OverSpeed | None = Field(None, description="factor on it against the speed")
    RULES = (
        one_of("magnifier", "damping_ratio", "loss_factor", "damping"),
        at_most_one("damping", "mode"),
    )
