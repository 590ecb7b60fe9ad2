"""The shaft line of an engine: stations that turn, and what holds them together."""

from typing import Annotated, Literal

from pydantic import Field

from vibecalc.case.absorber_fields import Density, Modulus
from vibecalc.case.fields import (
    AngularDamping,
    AngularStiffness,
    Inertia,
    Length,
    Moment,
    Name,
    Number,
    Pressure,
    Table,
    Unit,
)
from vibecalc.case.shaft_dampers import LineDamper

SectionModulus = Annotated[float, Field(gt=0), Unit("m^3")]
LinearStiffness = Annotated[float, Field(gt=0), Unit("N/m")]
Teeth = Annotated[int, Field(strict=True, ge=3, le=100_000)]
TwoNames = tuple[Name, Name]


class Throw(Table):
    """One throw of a crankshaft: half a journal, a web, the pin, a web, half a journal."""

    journal_diameter: Length = Field(gt=0, description="outer, of the main journal")
    journal_bore: Length = Field(0.0, ge=0, description="of a hollow journal")
    journal_length: Length = Field(gt=0, description="of one journal between two webs")
    pin_diameter: Length = Field(gt=0, description="outer, of the crank pin")
    pin_bore: Length = Field(0.0, ge=0, description="of a hollow pin")
    pin_length: Length = Field(gt=0, description="of the pin between the webs")
    web_thickness: Length = Field(gt=0, description="of one web, along the shaft")
    web_width: Length = Field(gt=0, description="of a web, across the throw")
    beyond_journal: Length | None = Field(
        None, gt=0, description="reach of a rectangular web behind the axis of the journal"
    )
    beyond_pin: Length | None = Field(
        None, gt=0, description="and past that of the pin; without both a web ends in half discs"
    )
    formula: Literal["source", "timoshenko", "carter", "ker_wilson"] = Field(
        "carter", description="for the stiffness; they differ"
    )
    density: Density = Field(7850.0, description="of the steel")
    shear_modulus: Modulus = Field(80e9, description="of the steel")
    balance_weight_inertia: Inertia = Field(
        0.0, ge=0, description="about the crank axis, of the weights on both webs"
    )


class Station(Table):
    """One inertia of the line, on the shaft whose speed it has."""

    name: Name = Field(description="label used in tables, in `between` and in `where`")
    inertia: Inertia | None = Field(
        None, ge=0, description="about its own axis, at its own speed; 0: a point without mass"
    )
    throw: Throw | None = Field(
        None, description="dimensions that give the inertia, with rod and piston of its cylinders"
    )
    cylinder: Name | None = Field(None, description="name of the cylinder that turns it")
    cylinders: Annotated[tuple[Name, ...], Field(max_length=8)] = Field(
        (), description="instead, names of several on one throw, as in a V engine"
    )
    absolute_damping: AngularDamping = Field(
        0.0, ge=0, description="against the steady rotation, on its own shaft"
    )
    ground_stiffness: AngularStiffness = Field(
        0.0, ge=0, description="to the steady rotation; a line on an unlimited grid has some"
    )


class Section(Table):
    """A round shaft from its dimensions, plain or a cone from one end to the other."""

    outer_diameter: Length = Field(gt=0, description="of the shaft")
    inner_diameter: Length = Field(0.0, ge=0, description="of its bore; 0: solid")
    end_outer_diameter: Length | None = Field(
        None, gt=0, description="at its other end, of a cone; default: the same"
    )
    end_inner_diameter: Length | None = Field(
        None, ge=0, description="of the bore at the other end; default: the same"
    )
    length: Length = Field(gt=0, description="that twists")
    shear_modulus: Modulus = Field(80e9, description="of the material")


class Shaft(Table):
    """What twists between two stations: a shaft, a throw or an elastic coupling."""

    name: Name | None = Field(None, description="label; default: 'first - second'")
    between: TwoNames | None = Field(
        None, description="names of two stations; without any: from each to the next"
    )
    stiffness: AngularStiffness | None = Field(
        None, gt=0, description="on its own shaft; or section, or throw"
    )
    section: Section | None = Field(None, description="dimensions that give the stiffness")
    throw: Throw | None = Field(None, description="of a crank, that give the stiffness")
    damping: AngularDamping | None = Field(
        None, ge=0, description="viscous, of the twist; default: none"
    )
    damping_ratio: Number | None = Field(
        None,
        ge=0,
        le=10,
        description="instead: of the two neighbouring inertias against each other, were they alone",
    )
    loss_factor: Number = Field(
        0.0, ge=0, le=10, description="of a complex stiffness k (1 + i loss_factor)"
    )
    diameter: Length | None = Field(
        None, gt=0, description="of the solid shaft where the stress is read"
    )
    section_modulus: SectionModulus | None = Field(
        None, description="polar, instead of diameter: stress is torque over it"
    )
    tensile_strength: Pressure | None = Field(
        None, gt=0, description="of the material, for a class rule"
    )


class Gear(Table):
    """Two stations on two shafts that turn together."""

    name: Name | None = Field(None, description="label; default: 'first - second'")
    between: TwoNames = Field(description="names of two stations")
    ratio: Number | None = Field(
        None, gt=0, description="speed of the second over that of the first; or teeth"
    )
    teeth: tuple[Teeth, Teeth] | None = Field(
        None, description="of the first and of the second wheel"
    )
    reverses: bool = Field(True, strict=True, description="the second one turns the other way")
    mesh_stiffness: LinearStiffness | None = Field(
        None, description="along the line of action; default: rigid teeth"
    )
    pitch_radius: Length | None = Field(
        None, gt=0, description="of the first wheel, with mesh_stiffness; it gives tooth forces"
    )


class Load(Table):
    """A torque that something takes from the line, apart from what balances the mean torque."""

    on: Name = Field(description="name of a station")
    torque: Moment = Field(
        description="mean, at the operating speed, on its own shaft; positive brakes"
    )
    exponent: Number = Field(
        0.0, ge=0, le=4, description="of the speed: 0 constant, 2 as a propeller"
    )


class ShaftLine(Table):
    """Inertias, shafts, gears and dampers of the whole installation."""

    stations: tuple[Station, ...] = Field(
        min_length=1, max_length=2000, description="inertias in their order, also as a CSV"
    )
    shafts: tuple[Shaft, ...] = Field((), max_length=4000, description="between them, also a CSV")
    gears: tuple[Gear, ...] = Field((), max_length=64, description="between two shafts")
    dampers: tuple[LineDamper, ...] = Field((), max_length=16, description="hung on stations")
    load: Name | None = Field(
        None, description="name of the station that takes up the mean torque; default: the last"
    )
    loads: tuple[Load, ...] = Field((), max_length=64, description="other torques that are taken")
