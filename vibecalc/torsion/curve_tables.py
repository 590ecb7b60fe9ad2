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
    key,
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

    speed: tuple[AngularSpeed, ...] = key("of the crankshaft", min_length=1, max_length=2000)
    order: Annotated[tuple[LineOrder, ...], Points] = key(
        "amplitude of this order; 0 or no column: half range of all orders", ()
    )
    torque: Torques = key("in the section", ())
    stress: Stresses = key("in the section", ())
    twist: Angles = key("of the section", ())
    angle: Angles = key("of the station", ())
    angular_speed: Speeds = key("of the station, vibration alone", ())
    angular_acceleration: Accelerations = key("of the station", ())
    RULES = (
        needs("", " ".join(READINGS), "what was measured at these speeds"),
        *(same_length("speed", name) for name in ("order", *READINGS)),
    )


class LineCurve(Table):
    """Orders over the range of speeds, with their sums, of one shaft or station."""

    on: Name = key("name of a shaft, elastic gear, damper or station")
    of: tuple[
        Literal["torque", "stress", "twist", "angle", "angular_speed", "angular_acceleration"],
        ...,
    ] = key(
        "default: torque, and stress where it is known; of a station the angle", (), max_length=6
    )
    orders: tuple[LineOrder, ...] = key(
        "that are kept; default: those of some share", (), max_length=400
    )
    share: Number = key(
        "of the largest order over the speeds, from which on an order is kept", 0.05, gt=0, le=1
    )
    measured: MeasuredPoints | None = key("points next to the curves", None)
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

    on: Name = key("name of the station")
    pole_pairs: Annotated[int, Field(strict=True, ge=1, le=1000)] | None = key(
        "of the generator there, for its vibration in electrical degrees", None
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

    misfire: Literal["each", "none"] = key(
        "every cylinder in turn, the others firing, or none", "each"
    )
    misfire_kind: Literal["no_gas", "motored"] = key(
        "its gas: none, or compressed and expanded without combustion", "no_gas"
    )
    imbalance: Number | None = key(
        "share of gas pressure that every cylinder in turn has less; below 0: more",
        None,
        ge=-1,
        le=1,
    )
    pressure_scale: tuple[Share, ...] = key(
        "factors on the gas pressure of all cylinders at once, in their order", (), max_length=200
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
