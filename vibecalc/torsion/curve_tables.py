"""Curves by order, cyclic irregularity and conditions of the cylinders, asked of a shaft line."""

from collections.abc import Iterable
from typing import Annotated, Literal

from pydantic import Field

from vibecalc.core.case.fields import (
    Angle,
    AngularSpeed,
    Moment,
    Name,
    Number,
    Stress,
    Table,
    Unit,
)
from vibecalc.core.case.rules import Row, at_most_one, needs, once, refers, refuse, same_length
from vibecalc.torsion.shaft_line_tables import Layout, ShaftLine, stressed

# ----------------------------------------------------------------------------
# Every order of what a named shaft or station does, against the speed, with what was measured.
# ----------------------------------------------------------------------------

Size, Points = Field(ge=0), Field(max_length=2000)
LineOrder = Annotated[float, Field(ge=0, le=400), Unit("")]
Torques = Annotated[tuple[Annotated[Moment, Size], ...], Points]
Stresses = Annotated[tuple[Annotated[Stress, Size], ...], Points]
Angles = Annotated[tuple[Annotated[Angle, Size], ...], Points]
Speeds = Annotated[tuple[Annotated[AngularSpeed, Size], ...], Points]
Accelerations = Annotated[tuple[Annotated[float, Size, Unit("rad/s^2")], ...], Points]
#: what is read of sections, and of stations
OF_SECTIONS, OF_STATIONS = (
    ("torque", "stress", "twist"),
    ("angle", "angular_speed", "angular_acceleration"),
)
READINGS = (*OF_SECTIONS, *OF_STATIONS)


class MeasuredPoints(Table):
    """Measured half ranges, one per speed: a column for each quantity, or a CSV with such ones."""

    speed: Annotated[tuple[AngularSpeed, ...], Field(min_length=1, max_length=2000)] = Field(
        description="of the crankshaft"
    )
    order: Annotated[tuple[LineOrder, ...], Points] = Field(
        (), description="amplitude of this order; 0 or no column: half range of all orders"
    )
    torque: Torques = Field((), description="in the section")
    stress: Stresses = Field((), description="in the section")
    twist: Angles = Field((), description="of the section")
    angle: Angles = Field((), description="of the station")
    angular_speed: Speeds = Field((), description="of the station, vibration alone")
    angular_acceleration: Accelerations = Field((), description="of the station")
    RULES = (
        needs("", " ".join(READINGS), "what was measured at these speeds"),
        *(same_length("speed", name) for name in ("order", *READINGS)),
    )


class LineCurve(Table):
    """Orders over the range of speeds, with their sums, of one shaft or station."""

    on: Name = Field(description="name of a shaft, elastic gear, damper or station")
    of: Annotated[
        tuple[
            Literal["torque", "stress", "twist", "angle", "angular_speed", "angular_acceleration"],
            ...,
        ],
        Field(max_length=6),
    ] = Field(
        (), description="default: torque, and stress where it is known; of a station the angle"
    )
    orders: Annotated[tuple[LineOrder, ...], Field(max_length=400)] = Field(
        (), description="that are kept; default: those of some share"
    )
    share: Number = Field(
        0.05,
        gt=0,
        le=1,
        description="of the largest order over the speeds, from which on an order is kept",
    )
    measured: MeasuredPoints | None = Field(None, description="points next to the curves")
    RULES = (
        at_most_one("orders", "share"),
        once("of", "quantity"),
        once("orders", "order"),
    )


def curves_of(line: ShaftLine, curves: Iterable[LineCurve]) -> dict[str, tuple[str, ...]]:
    """Quantity -> names of the shafts or stations whose curves of it are asked for."""
    layout = Layout(line)
    found: dict[str, list[str]] = {name: [] for name in READINGS}
    for curve in curves:
        alone = curve.on in layout.at and curve.on not in layout.sections
        usual: tuple[str, ...] = ("angle",) if alone else ("torque",)
        if curve.on in stressed(line, layout):
            usual = ("torque", "stress")
        for name in curve.of or usual:
            found[name].append(curve.on)
    return {name: tuple(names) for name, names in found.items() if names}


# ----------------------------------------------------------------------------
# How evenly a station turns.
# ----------------------------------------------------------------------------


class Irregularity(Table):
    """Degree of unevenness of the turning of one station."""

    on: Name = Field(description="name of the station")
    pole_pairs: Annotated[int, Field(strict=True, ge=1, le=1000)] | None = Field(
        None, description="of the generator there, for its vibration in electrical degrees"
    )
    RULES = (refers("on", "machine.shaft_line.stations", "station"),)


# ----------------------------------------------------------------------------
# Cylinders that misfire or are out of balance: the worst of many conditions.
# ----------------------------------------------------------------------------


def _asks(row: Row) -> bool:
    return row["misfire"] == "each" or bool(row.said("imbalance", "pressure_scale"))


Share = Annotated[float, Field(ge=0, le=10), Unit("")]


ALL_FIRE, GIVEN = "all fire", "given pressures"


def condition_names(options: "Conditions", cylinders: Iterable[str]) -> tuple[str, ...]:
    """What the conditions are called, all firing first."""
    names = tuple(cylinders)
    found = [ALL_FIRE]
    if options.misfire == "each":
        found += [f"{name} misfires" for name in names]
    if options.imbalance is not None:
        found += [f"{name} out of balance" for name in names]
    return (*found, GIVEN) if options.pressure_scale else tuple(found)


class Conditions(Table):
    """What the cylinders may do: all fire, each misfires, pressures differ; the worst counts."""

    misfire: Literal["each", "none"] = Field(
        "each", description="every cylinder in turn, the others firing, or none"
    )
    misfire_kind: Literal["no_gas", "motored"] = Field(
        "no_gas", description="its gas: none, or compressed and expanded without combustion"
    )
    imbalance: Number | None = Field(
        None,
        ge=-1,
        le=1,
        description="share of gas pressure that every cylinder in turn has less; below 0: more",
    )
    pressure_scale: Annotated[tuple[Share, ...], Field(max_length=200)] = Field(
        (), description="factors on the gas pressure of all cylinders at once, in their order"
    )
    RULES = (
        refuse(
            "",
            "there is no condition but that all cylinders fire",
            lambda t: not _asks(t),
            "misfire = 'each', imbalance = 0.1 or pressure_scale = [1, 0.9, ...]",
        ),
        refuse(
            "imbalance",
            "an imbalance of nothing is that all cylinders fire",
            lambda t: t.number("imbalance") == 0.0,
            "0.1 for a tenth less, for example",
        ),
        refuse(
            "misfire_kind",
            "misfire_kind says how cylinders misfire, and none does",
            lambda t: t["misfire_kind"] == "motored" and t["misfire"] == "none",
            "misfire = 'each' with it",
        ),
    )
