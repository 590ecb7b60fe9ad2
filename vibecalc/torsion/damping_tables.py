"""Tables of a case for dampings and loads that follow the speed of a shaft line."""

from typing import Annotated, Literal

from pydantic import Field

from vibecalc.core.case.fields import AngularDamping, AngularSpeed, Moment, Number, Table, key
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

    speed: Speeds = key("ascending")
    factor: Factors = key("on the damping that is given, one per speed")
    RULES = (same_length("speed", "factor"), ascending("speed"))


class OverSpeed(Table):
    """A factor on a damping against the speed, as a table or as a power of the speed."""

    of: Literal["crank", "own"] = key(
        "whose speed: of the crankshaft, or that of its own shaft", "crank"
    )
    table: FactorCurve | None = key("a table or a CSV", None)
    exponent: Number | None = key(
        "instead: factor (speed / reference) ^ exponent", None, ge=-4, le=4
    )
    reference: AngularSpeed | None = key(
        "speed at which the damping is as given, with exponent", None, gt=0
    )
    RULES = (
        one_of("table", "exponent reference"),
        needs("exponent", "reference", "at this speed the damping is as given"),
        needs("reference", "exponent", "the power of the speed"),
    )


class LoadCurve(Table):
    """A torque against the speed, straight lines between the entries."""

    speed: Speeds = key("ascending, of the crankshaft")
    torque: Torques = key("mean, on its own shaft; positive brakes; one per speed")
    RULES = (same_length("speed", "torque"), ascending("speed"))


# ----------------------------------------------------------------------------
# Damping of a propeller from its torque, and of the cylinders of an engine.
# ----------------------------------------------------------------------------


class PropellerDamping(Table):
    """Absolute damping from the mean torque T that the load takes at each speed."""

    method: Literal["archer", "slope", "factor"] = key(
        "a T / n with n in rpm; dT/dw of the law of the load; or x T / w"
    )
    coefficient: Number | None = key("a of archer, default 30; or x of factor", None, gt=0, le=1000)
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

    magnifier: Number | None = key(
        "dynamic magnifier M of its inertia J: J w / M", None, ge=1, le=1e6
    )
    damping_ratio: Number | None = key(
        "Lehr's damping ratio D of its inertia: 2 D J w", None, ge=0, lt=1
    )
    loss_factor: Number | None = key("of its inertia: loss_factor J w", None, ge=0, le=2)
    damping: AngularDamping | None = key("viscous, of each station; instead", None, ge=0)
    mode: Annotated[int, Field(strict=True, ge=2, le=2000)] | None = key(
        "whose undamped frequency w is, the rigid one is 1; default: lowest elastic", None
    )
    over_speed: OverSpeed | None = key("factor on it against the speed", None)
    RULES = (
        one_of("magnifier", "damping_ratio", "loss_factor", "damping"),
        at_most_one("damping", "mode"),
    )
