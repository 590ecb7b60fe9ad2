"""Tables of a machine with absorbers: primary system, absorbers, hardware, pendulums."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from vibecalc.core.case.fields import (
    Angle,
    AngularDamping,
    AngularSpeed,
    AngularStiffness,
    Density,
    Force,
    Frequency,
    Inertia,
    Length,
    Mass,
    Modulus,
    Moment,
    Name,
    Stress,
    Table,
    Unit,
)
from vibecalc.core.case.raw import table_at
from vibecalc.core.case.rules import (
    Row,
    at_most_one,
    below,
    needs,
    one_of,
    refuse,
    same_length,
)
from vibecalc.errors import Problem

# ----------------------------------------------------------------------------
# Kinds of field that only an absorber has: temperatures, viscosities, moduli, ratios.
# ----------------------------------------------------------------------------

#: K, of 0 degrees Celsius
ICE = 273.15
#: K and m^2/s, ends of the chart of viscosities, ASTM D341: -70 and 370 C, 2 and 20e6 cSt
COLDEST, HOTTEST = 203.15, 643.15
THINNEST, THICKEST = 2e-6, 20.0
Temperature = Annotated[float, Field(ge=COLDEST, le=HOTTEST), Unit("K")]
LinearStiffness = Annotated[float, Unit("N/m")]
LinearDamping = Annotated[float, Unit("N*s/m")]
KinematicViscosity = Annotated[float, Field(ge=THINNEST, le=THICKEST), Unit("m^2/s")]
#: zero is a limit: no spring, no damper
Share = Annotated[float, Field(ge=0), Unit("")]
Positive = Annotated[float, Field(gt=0), Unit("")]
Ordinate = Annotated[float, Field(ge=-1e6, le=1e6), Unit("")]
PartNumber = Annotated[int, Field(strict=True, ge=0, le=10**9)]
Count = Annotated[int, Field(strict=True, ge=1, le=1000)]
Several = Annotated[int, Field(strict=True, ge=1, le=100)]

# ----------------------------------------------------------------------------
# A primary system and the absorbers on it, in ratios or in units of their own.
# ----------------------------------------------------------------------------


#: keys of an absorber that say one number each, in the three ways
WAYS = {
    "mass": ("mass_ratio", "inertia", "mass"),
    "stiffness": ("stiffness_ratio", "stiffness", "linear_stiffness"),
    "damping": ("damping_ratio", "own_damping_ratio", "damping", "linear_damping"),
}
#: keys of a primary and of absorbers that say how they move
MOTIONS = {
    "torsion": ("inertia", "stiffness", "damping"),
    "translation": ("mass", "linear_stiffness", "linear_damping"),
}
_ONE_MOTION = at_most_one(*map(" ".join, MOTIONS.values()))


class Mode(Table):
    """A mode of a floor, a bridge or a frame on which the absorber is put."""

    natural_frequency: Frequency = Field(gt=0, description="without the absorber, '6 Hz'")
    modal_mass: Mass = Field(gt=0, description="in the scale of its shape")
    damping_ratio: Share = Field(0.0, lt=1, description="of critical")
    shape_at_absorber: Ordinate = Field(1.0, description="ordinate where the absorber is")
    shape_at_response: Ordinate = Field(1.0, description="ordinate where the motion is read")
    shape_at_force: Ordinate | None = Field(
        None, description="ordinate where the force acts; default: where the motion is read"
    )
    participation: Ordinate | None = Field(
        None, description="sum of mass times shape over modal_mass; a moving ground needs it"
    )


class Primary(Table):
    """What is to be kept still: ratios alone, or a system in torsion, or one in translation.

    Every ratio is relative to it; without inertia or mass all results are ratios.
    """

    damping_ratio: Share | None = Field(
        None, description="c1 / (2 sqrt(K1 J1)); default: 0, undamped"
    )
    inertia: Inertia | None = Field(None, gt=0, description="J1, in torsion")
    stiffness: AngularStiffness | None = Field(
        None, gt=0, description="K1 to the ground, in torsion; or [machine.rod] gives it"
    )
    damping: AngularDamping | None = Field(
        None, ge=0, description="c1 to the ground, in torsion, instead of damping_ratio"
    )
    mass: Mass | None = Field(None, gt=0, description="in translation, instead of inertia")
    linear_stiffness: LinearStiffness | None = Field(
        None, gt=0, description="to the ground, in translation, instead of stiffness"
    )
    linear_damping: LinearDamping | None = Field(
        None, ge=0, description="to the ground, in translation, instead of damping"
    )
    natural_frequency: Frequency | None = Field(
        None, gt=0, description="of inertia or mass on its spring, '8 Hz', instead of stiffness"
    )
    modes: Annotated[tuple[Mode, ...], Field(max_length=20)] = Field(
        (), description="several modes by modal masses, instead of all other keys"
    )
    RULES = (
        at_most_one(
            "modes",
            "damping_ratio inertia stiffness damping mass linear_stiffness linear_damping "
            "natural_frequency",
        ),
        at_most_one("natural_frequency", "stiffness"),
        at_most_one("natural_frequency", "linear_stiffness"),
        refuse(
            "",
            "[machine.primary] is empty",
            lambda t: not t.data,
            "damping_ratio = 0.0 for ratios alone, or inertia and stiffness, or mass and "
            "linear_stiffness",
        ),
        at_most_one("damping_ratio", "damping", "linear_damping"),
        _ONE_MOTION,
    )


class Secondary(Table):
    """The absorber: its mass, and spring and damper unless [tuning] finds them."""

    mass_ratio: Positive | None = Field(
        None, description="J2 / J1, or the ratio of masses, instead of inertia or mass"
    )
    inertia: Inertia | None = Field(None, gt=0, description="J2, in torsion")
    mass: Mass | None = Field(None, gt=0, description="in translation")
    stiffness_ratio: Share | None = Field(
        None, description="K2 / K1, instead of stiffness; 0: no spring, a pure viscous damper"
    )
    stiffness: AngularStiffness | None = Field(
        None, ge=0, description="K2 to what carries it, in torsion"
    )
    linear_stiffness: LinearStiffness | None = Field(
        None, ge=0, description="to what carries it, in translation"
    )
    damping_ratio: Share | None = Field(
        None, description="c2 / (2 sqrt(K1 J1)): referred to the primary, not to its own frequency"
    )
    own_damping_ratio: Share | None = Field(
        None,
        description="c2 / (2 J2 w2) instead, on its own frequency; it needs a spring",
    )
    damping: AngularDamping | None = Field(
        None, ge=0, description="c2, in torsion; a negative one would feed energy in"
    )
    linear_damping: LinearDamping | None = Field(None, ge=0, description="in translation")
    RULES: ClassVar[tuple[Any, ...]] = (
        *(at_most_one(*keys) for keys in WAYS.values()),
        _ONE_MOTION,
        refuse(
            "own_damping_ratio",
            "without a spring the absorber has no frequency of its own for this ratio",
            lambda t: "own_damping_ratio" in t and 0.0 in map(t.number, WAYS["stiffness"]),
            "damping_ratio, which is referred to the primary, or a stiffness > 0",
        ),
    )


class NamedSecondary(Secondary):
    """One of several absorbers, next to each other or one on another."""

    name: Name = Field(description="label used in `on`, in tables and in `where`")
    on: Name = Field("primary", description="what carries it: the primary, or another one by name")
    mode_shapes: Annotated[tuple[Ordinate, ...], Field(max_length=20)] = Field(
        (),
        description="ordinate of each of primary.modes where it is; default: shape_at_absorber",
    )
    RULES = (
        *Secondary.RULES,
        refuse(
            "mode_shapes",
            "there are not as many ordinates as the primary has modes",
            lambda t: (
                "mode_shapes" in t
                and len(t.entries("mode_shapes"))
                != len(table_at(t.machine, "primary").get("modes", ()))
            ),
            "one for each of [[machine.primary.modes]]",
            also=("machine", "primary"),
        ),
        refuse(
            "mode_shapes",
            "an absorber on another moves with that one, whatever the modes",
            lambda t: "mode_shapes" in t and t["on"] not in (None, "primary"),
            "no mode_shapes, or on = 'primary'",
            also="on",
        ),
    )


Secondaries = Annotated[tuple[NamedSecondary, ...], Field(max_length=8)]

# ----------------------------------------------------------------------------
# What an absorber is built of: rod, springs, ring, gap, oil; and what the stock has of them.
# ----------------------------------------------------------------------------

LiquidDensity = Annotated[float, Field(ge=100, le=20_000), Unit("kg/m^3")]
Expansion = Annotated[float, Field(ge=0, lt=0.01), Unit("1/K", "an expansion")]
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
    RULES = (
        needs("length", "shear_modulus", "they give its stiffness together"),
        needs("shear_modulus", "length", "they give its stiffness together"),
        at_most_one("mass", "density"),
        below("bore", "diameter", "the bore is as wide as the rod"),
        below(
            "span",
            "total_length",
            "the supports stand further apart than the rod is long",
            equal=True,
        ),
    )


def _is_no_body(row: Row) -> bool:
    polar, across = row.number("polar_inertia"), row.number("diametral_inertia")
    return polar is not None and across is not None and polar > 2.0 * across * (1.0 + 1e-6)


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
    RULES = (
        refuse(
            "polar_inertia",
            "no body has this polar inertia: it is at most twice the diametral one",
            _is_no_body,
            "at most twice diametral_inertia",
            found="{polar_inertia}",
            also="diametral_inertia",
        ),
    )


WIRE = ("wire_diameter", "coil_diameter", "turns", "shear_modulus")
_NOT_BELOW = "the inner radius is not below the outer one"


class Springs(Table):
    """Equal helical springs between primary and seismic mass.

    With a rate, given or from the wire, they are the secondary's stiffness as built; without one
    they are the places of springs whose rate [tuning] finds.
    """

    count: Count = Field(description="springs that act together")
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
    allowed_stress: Stress | None = Field(
        None, gt=0, description="in shear: it bounds the extension of the wire's spring"
    )
    RULES = (
        at_most_one("rate", " ".join(WIRE)),
        *(
            needs(
                key, other, "a spring from its wire needs all of it", f"{' '.join(WIRE)}, or rate"
            )
            for key, other in pairwise((*WIRE, WIRE[0]))
        ),
        needs("allowed_stress", "wire_diameter", "the stress of a spring follows from its wire"),
        below(
            "wire_diameter",
            "coil_diameter",
            "the wire does not go round: the coil is no wider than its wire",
        ),
    )


class Ring(Table):
    """The seismic mass as a ring of rectangular section: it gives the secondary's inertia."""

    outer_radius: Length = Field(gt=0, description="of the ring")
    inner_radius: Length = Field(0.0, ge=0, description="0: a disc")
    width: Length = Field(gt=0, description="along the axis")
    density: Density = Field(description="of its material")
    RULES = (below("inner_radius", "outer_radius", _NOT_BELOW),)


_NO_FILM = "a gap as wide as the mass is no film: its damping cannot be determined"
OILS = frozenset({"oil", "stock_oils", "oil_catalogue"})


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
    RULES = (
        below("inner_radius", "outer_radius", _NOT_BELOW),
        *(
            below(key, "width", _NO_FILM)
            for key in ("clearance", "side_clearance", "bore_clearance")
        ),
        refuse(
            "bore_clearance",
            "the gap in the bore is as wide as the bore itself",
            lambda t: (
                0.0 < (t.number("inner_radius") or 0.0) <= (t.number("bore_clearance") or 0.0)
            ),
            "less than inner_radius",
            found="{bore_clearance}",
            also="inner_radius",
        ),
        needs("bore_clearance", "inner_radius", "a disc without a bore has no film in it"),
        refuse(
            "",
            "oils need the temperature at which they run",
            lambda t: not OILS.isdisjoint(t.machine) and t.lacks("temperature"),
            "temperature = '60 degC', for example",
        ),
    )


_NO_OIL = "no oil has these two points: it is thinner at the higher temperature"


_THINNER = "two temperatures, and less viscosity at the higher one"


def _thickens(row: Row) -> bool:
    warm, thick = row.listed("temperatures") or [*STATED], row.listed("viscosities")
    if len(warm) != 2 or len(thick) != 2 or None in (*warm, *thick):
        return False
    return bool((warm[1] - warm[0]) * (thick[0] - thick[1]) <= 0.0)


class Oil(Table):
    """A liquid by two points of its viscosity line (ASTM D341) and its density."""

    viscosities: Viscosities = Field(
        description="kinematic, at the two temperatures, '86 cSt' or in m^2/s"
    )
    temperatures: Temperatures = Field(
        STATED, description="'40 degC' and '100 degC' if not said, otherwise so or in K"
    )
    density: LiquidDensity = Field(description="at 15 degC")
    expansion: Expansion | None = Field(
        None, description="change of volume; default: that of mineral oils, from the density"
    )
    RULES = (refuse("viscosities", _NO_OIL, _thickens, _THINNER, found="{viscosities}"),)


class StockSpring(Table):
    """A spring that can be bought."""

    name: Name = Field(description="label used in tables and in `where`")
    rate: LinearStiffness = Field(gt=0, description="of one spring")
    parallel: Several | None = Field(
        None, description="every number up to it is tried; default: springs.count of them"
    )
    series: Annotated[int, Field(strict=True, ge=1, le=10)] | None = Field(
        None, description="up to so many behind each other in each line; default: 1"
    )
    RULES = (needs("series", "parallel", "springs.count says how many act together, each alone"),)


class StockOil(Oil):
    """An oil that can be bought."""

    name: Name = Field(description="label used in tables and in `where`")


class StockDamper(Table):
    """A damper that can be bought, for an absorber that moves in a line."""

    name: Name = Field(description="label used in tables and in `where`")
    linear_damping: LinearDamping = Field(gt=0, description="of one damper")
    count: Count = Field(1, description="dampers that act together")
    parallel: Several = Field(1, description="every number of such sets up to it is tried")


PartNumbers = Annotated[tuple[PartNumber, ...], Field(min_length=1, max_length=2000)]
Rates = Annotated[tuple[LinearStiffness, ...], Field(min_length=1, max_length=2000)]
ManyViscosities = Annotated[tuple[KinematicViscosity, ...], Field(min_length=1, max_length=2000)]
Densities = Annotated[tuple[LiquidDensity, ...], Field(min_length=1, max_length=2000)]


class SpringCatalogue(Table):
    """Springs that can be bought, one in each row."""

    part: PartNumbers = Field(description="its number")
    rate: Rates = Field(description="of one spring")
    RULES = (same_length("part", "rate"),)


def _thins(row: Row) -> Iterator[Problem]:
    both = zip(row.listed("viscosity_40"), row.listed("viscosity_100"), strict=False)
    for place, (thick, thin) in enumerate(both):
        if thick is not None and thin is not None and thick <= thin:
            found = f"{1e6 * thin:.6g} cSt at 100 degC"
            at = (*row.path, "viscosity_100", place)
            yield row.problem(at, _NO_OIL, found=found, allowed=f"< {1e6 * thick:.6g} cSt")


class OilCatalogue(Table):
    """Oils that can be bought, one in each row."""

    part: PartNumbers = Field(description="its number or grade")
    viscosity_40: ManyViscosities = Field(description="at 40 degC")
    viscosity_100: ManyViscosities = Field(description="at 100 degC")
    density: Densities = Field(description="at 15 degC")
    RULES = (same_length("part", "viscosity_40", "viscosity_100", "density"), _thins)


StockSprings = Annotated[tuple[StockSpring, ...], Field(max_length=200)]
StockDampers = Annotated[tuple[StockDamper, ...], Field(max_length=200)]
StockOils = Annotated[tuple[StockOil, ...], Field(max_length=200)]

# ----------------------------------------------------------------------------
# A pendulum in the centrifugal field of a rotor, as a case gives it.
# ----------------------------------------------------------------------------


class Swings(Table):
    """Angles of swing up to which the order is followed."""

    to: Angle = Field(gt=0, description="largest angle by which the tangent turns")
    points: Annotated[int, Field(strict=True, ge=2, le=2000)] = Field(
        41, description="from zero on"
    )


class Rollers(Table):
    """Two equal rollers in equal cutouts that carry the mass: a bifilar mount."""

    mass: Mass = Field(gt=0, description="of all rollers of one pendulum")
    distance: Length = Field(
        gt=0, description="mean, from the axis to their centres across the vertex"
    )
    diameter: Length = Field(gt=0, description="of a roller")
    inertia: Inertia | None = Field(
        None, ge=0, description="of all about their own axes; default: solid ones"
    )


class Pendulum(Table):
    """Equal pendulums on a rotor that follow one order of its speed."""

    order: Positive = Field(description="of the excitation that they have to follow")
    mass: Mass = Field(gt=0, description="of one pendulum, without its rollers")
    count: Count = Field(1, description="pendulums that swing together")
    vertex_distance: Length | None = Field(
        None, gt=0, description="from the axis to the mass centre at rest"
    )
    arm_radius: Length | None = Field(
        None, gt=0, description="from the axis to the centre of the path, instead"
    )
    path: Literal["circular", "cycloidal", "epicycloidal"] = Field(
        "circular", description="of the mass centre; an epicycloid keeps its order"
    )
    path_radius: Length | None = Field(
        None, gt=0, description="of curvature at the vertex; default: as the order wants it"
    )
    swing_inertia: Inertia = Field(
        0.0, ge=0, description="of one mass about its centre, where it turns with an arm"
    )
    rollers: Rollers | None = Field(None, description="of one pendulum; default: a point on an arm")
    damping_ratio: Share = Field(
        0.0, lt=1, description="of small swings, on their own frequency; at 1 it creeps"
    )
    rotor_inertia: Inertia = Field(gt=0, description="of all that turns, without pendulums")
    rotor_stiffness: AngularStiffness = Field(
        0.0, ge=0, description="that holds the rotor against its mean turning; 0: none"
    )
    speed: AngularSpeed = Field(gt=0, description="mean speed of the rotor")
    torque: Moment | None = Field(
        None, gt=0, description="amplitude of the exciting torque: how far it swings"
    )
    swings: Swings | None = Field(None, description="detuning with the angle of swing")
    RULES = (
        one_of("vertex_distance", "arm_radius"),
        refuse(
            "arm_radius",
            "with rollers or a swing_inertia the path cannot be tuned from the arm's radius",
            lambda t: (
                "arm_radius" in t
                and "path_radius" not in t
                and ("rollers" in t or t.number("swing_inertia"))
            ),
            "vertex_distance instead, or path_radius with it",
        ),
        refuse(
            "swing_inertia",
            "a mass that turns with an arm runs on a circle, without rollers",
            lambda t: t.number("swing_inertia") and ("rollers" in t or t["path"] != "circular"),
            "no swing_inertia, or path = 'circular' without rollers",
        ),
    )
