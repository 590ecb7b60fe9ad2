"""What an absorber is built of: rod, springs, ring, gap, oil; and what the stock has of them."""

from typing import Annotated

from pydantic import Field

from vibecalc.case.absorber_fields import (
    ICE,
    Density,
    KinematicViscosity,
    LinearDamping,
    LinearStiffness,
    Modulus,
    PartNumber,
    Positive,
    Temperature,
)
from vibecalc.case.fields import (
    Angle,
    AngularSpeed,
    Force,
    Inertia,
    Length,
    Mass,
    Name,
    Table,
    Unit,
)

Expansion = Annotated[float, Field(ge=0, lt=0.01), Unit("1/K")]
Temperatures = tuple[Temperature, Temperature]
Viscosities = tuple[KinematicViscosity, KinematicViscosity]
#: of the two viscosities that suppliers state
STATED = (ICE + 40.0, ICE + 100.0)


class Rod(Table):
    """The round rod that is the primary's spring; with its supports, how it bends."""

    diameter: Length = Field(gt=0, description="outer one")
    bore: Length = Field(0.0, ge=0, description="inner diameter of a tube")
    length: Length | None = Field(None, gt=0, description="that is twisted")
    shear_modulus: Modulus | None = Field(
        None, description="with length it gives the primary's stiffness"
    )
    total_length: Length | None = Field(
        None, gt=0, description="from the first support to the free end, for bending"
    )
    span: Length | None = Field(None, gt=0, description="between the two supports, for bending")
    elastic_modulus: Modulus | None = Field(None, description="for bending")
    mass: Mass | None = Field(None, gt=0, description="of the total length, for bending")
    density: Density | None = Field(None, description="instead of mass")


class Flywheel(Table):
    """The body on the free end of the rod, for its bending."""

    mass: Mass = Field(gt=0, description="of all that is fixed there")
    diametral_inertia: Inertia = Field(
        0.0, ge=0, description="about a line across the rod, through the mass centre"
    )
    polar_inertia: Inertia = Field(0.0, ge=0, description="about the rod, for spin")
    offset: Length = Field(
        0.0, description="of the mass centre beyond the end of the rod; negative: back over it"
    )
    spin: AngularSpeed = Field(
        0.0, ge=0, description="of a shaft that turns; 0 for a rod that only oscillates"
    )
    modes: Annotated[int, Field(strict=True, ge=1, le=6)] = Field(
        2, description="bending modes to compute"
    )


class Springs(Table):
    """Equal helical springs between primary and seismic mass.

    With a rate, given or from the wire, they are the secondary's stiffness as built; without one
    they are the places of springs whose rate [tuning] finds.
    """

    count: Annotated[int, Field(strict=True, ge=1, le=1000)] = Field(
        description="springs that act together"
    )
    radius: Length | None = Field(
        None, gt=0, description="from the axis to the hook on the mass, in torsion"
    )
    angle: Angle = Field(
        0.0, gt=-1.5, lt=1.5, description="of each line against the tangent, or the motion"
    )
    rate: LinearStiffness | None = Field(None, gt=0, description="of each, or from the wire")
    wire_diameter: Length | None = Field(None, gt=0, description="instead of rate")
    coil_diameter: Length | None = Field(
        None, gt=0, description="mean one, from centre to centre of the wire"
    )
    turns: Positive | None = Field(None, description="active ones")
    shear_modulus: Modulus | None = Field(None, description="of the wire")
    initial_tension: Force = Field(0.0, ge=0, description="with which the coils are wound")
    allowed_stress: Modulus | None = Field(
        None, description="in shear: it bounds the extension of the wire's spring"
    )


class Ring(Table):
    """The seismic mass as a ring of rectangular section: it gives the secondary's inertia."""

    outer_radius: Length = Field(gt=0, description="of the ring")
    inner_radius: Length = Field(0.0, ge=0, description="0: a disc")
    width: Length = Field(gt=0, description="along the axis")
    density: Density = Field(description="of its material")


class Gap(Table):
    """The gaps full of oil around the seismic mass: its damping for a viscosity."""

    outer_radius: Length = Field(gt=0, description="of the mass")
    inner_radius: Length = Field(0.0, ge=0, description="0: a disc without a bore")
    width: Length = Field(gt=0, description="of the mass at its rim, along the axis")
    clearance: Length | None = Field(
        None,
        gt=0,
        description="at rim and sides; default: 0.010 in (1 + sqrt(2 outer_radius / 10 in))",
    )
    side_clearance: Length | None = Field(None, gt=0, description="where the sides have their own")
    bore_clearance: Length | None = Field(
        None, gt=0, description="of a film in the bore; default: there is none"
    )
    temperature: Temperature | None = Field(
        None, description="of the oil while it runs, '60 degC' or in K; oils need it"
    )


class Oil(Table):
    """A liquid by two points of its viscosity line (ASTM D341) and its density."""

    viscosities: Viscosities = Field(description="kinematic, at the two temperatures")
    temperatures: Temperatures = Field(
        STATED, description="'40 degC' and '100 degC' if not said, otherwise so or in K"
    )
    density: Density = Field(description="at 15 degC")
    expansion: Expansion | None = Field(
        None, description="change of volume; default: that of mineral oils, from the density"
    )


class StockSpring(Table):
    """A spring that can be bought."""

    name: Name = Field(description="label used in tables and in `where`")
    rate: LinearStiffness = Field(gt=0, description="of one spring")


class StockOil(Oil):
    """An oil that can be bought."""

    name: Name = Field(description="label used in tables and in `where`")


class StockDamper(Table):
    """A damper that can be bought, for an absorber that moves in a line."""

    name: Name = Field(description="label used in tables and in `where`")
    linear_damping: LinearDamping = Field(gt=0, description="of one damper")
    count: Annotated[int, Field(strict=True, ge=1, le=1000)] = Field(
        1, description="dampers that act together"
    )


class SpringCatalogue(Table):
    """Springs that can be bought, one in each row."""

    part: tuple[PartNumber, ...] = Field(min_length=1, max_length=2000, description="its number")
    rate: tuple[LinearStiffness, ...] = Field(
        min_length=1, max_length=2000, description="of one spring"
    )


class OilCatalogue(Table):
    """Oils that can be bought, one in each row."""

    part: tuple[PartNumber, ...] = Field(
        min_length=1, max_length=2000, description="its number or grade"
    )
    viscosity_40: tuple[KinematicViscosity, ...] = Field(
        min_length=1, max_length=2000, description="at 40 degC"
    )
    viscosity_100: tuple[KinematicViscosity, ...] = Field(
        min_length=1, max_length=2000, description="at 100 degC"
    )
    density: tuple[Density, ...] = Field(min_length=1, max_length=2000, description="at 15 degC")


StockSprings = Annotated[tuple[StockSpring, ...], Field(max_length=200)]
StockDampers = Annotated[tuple[StockDamper, ...], Field(max_length=200)]
StockOils = Annotated[tuple[StockOil, ...], Field(max_length=200)]
