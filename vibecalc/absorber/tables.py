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
    key,
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
    "damping": (
        "damping_over_primary_critical",
        "absorber_damping_ratio",
        "damping",
        "linear_damping",
    ),
}
#: keys of a primary and of absorbers that say how they move
MOTIONS = {
    "torsion": ("inertia", "stiffness", "damping"),
    "translation": ("mass", "linear_stiffness", "linear_damping"),
}
_ONE_MOTION = at_most_one(*map(" ".join, MOTIONS.values()))


class Mode(Table):
    """A mode of a floor, a bridge or a frame on which the absorber is put."""

    natural_frequency: Frequency = key("without the absorber, '6 Hz'", gt=0)
    modal_mass: Mass = key("in the scale of its shape", gt=0)
    damping_ratio: Share = key("of critical", 0.0, lt=1)
    shape_at_absorber: Ordinate = key("ordinate where the absorber is", 1.0)
    shape_at_response: Ordinate = key("ordinate where the motion is read", 1.0)
    shape_at_force: Ordinate | None = key(
        "ordinate where the force acts; default: where the motion is read", None
    )
    participation: Ordinate | None = key(
        "sum of mass times shape over modal_mass; a moving ground needs it", None
    )


class Primary(Table):
    """What is to be kept still: ratios alone, or a system in torsion, or one in translation.

    Every ratio is relative to it; without inertia or mass all results are ratios.
    """

    damping_ratio: Share | None = key("c1 / (2 sqrt(K1 J1)); default: 0, undamped", None)
    inertia: Inertia | None = key("J1, in torsion", None, gt=0)
    stiffness: AngularStiffness | None = key(
        "K1 to the ground, in torsion; or [machine.rod] gives it", None, gt=0
    )
    damping: AngularDamping | None = key(
        "c1 to the ground, in torsion, instead of damping_ratio", None, ge=0
    )
    mass: Mass | None = key("in translation, instead of inertia", None, gt=0)
    linear_stiffness: LinearStiffness | None = key(
        "to the ground, in translation, instead of stiffness", None, gt=0
    )
    linear_damping: LinearDamping | None = key(
        "to the ground, in translation, instead of damping", None, ge=0
    )
    natural_frequency: Frequency | None = key(
        "of inertia or mass on its spring, '8 Hz', instead of stiffness", None, gt=0
    )
    modes: tuple[Mode, ...] = key(
        "several modes by modal masses, instead of all other keys", (), max_length=20
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

    mass_ratio: Positive | None = key(
        "J2 / J1, or the ratio of masses, instead of inertia or mass", None
    )
    inertia: Inertia | None = key("J2, in torsion", None, gt=0)
    mass: Mass | None = key("in translation", None, gt=0)
    stiffness_ratio: Share | None = key(
        "K2 / K1, instead of stiffness; 0: no spring, a pure viscous damper", None
    )
    stiffness: AngularStiffness | None = key("K2 to what carries it, in torsion", None, ge=0)
    linear_stiffness: LinearStiffness | None = key("to what carries it, in translation", None, ge=0)
    damping_over_primary_critical: Share | None = key(
        "c2 / (2 sqrt(K1 J1)): over the critical damping of the primary, not of the absorber", None
    )
    absorber_damping_ratio: Share | None = key(
        "instead, c2 / (2 J2 w2): over the critical damping of the absorber, with its spring",
        None,
    )
    damping: AngularDamping | None = key(
        "c2, in torsion; a negative one would feed energy in", None, ge=0
    )
    linear_damping: LinearDamping | None = key("in translation", None, ge=0)
    RULES: ClassVar[tuple[Any, ...]] = (
        *(at_most_one(*keys) for keys in WAYS.values()),
        _ONE_MOTION,
        refuse(
            "absorber_damping_ratio",
            "without a spring the absorber has no frequency of its own for this ratio",
            lambda t: "absorber_damping_ratio" in t and 0.0 in map(t.number, WAYS["stiffness"]),
            "damping_over_primary_critical, which is referred to the primary, or a stiffness > 0",
        ),
    )


class NamedSecondary(Secondary):
    """One of several absorbers, next to each other or one on another."""

    name: Name = key("label used in `on`, in tables and in `where`")
    on: Name = key("what carries it: the primary, or another one by name", "primary")
    mode_shapes: tuple[Ordinate, ...] = key(
        "ordinate of each of primary.modes where it is; default: shape_at_absorber",
        (),
        max_length=20,
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


class FrictionDamper(Table):
    """A mass that dry friction drags along: Lanchester's damper, instead of an absorber."""

    mass_ratio: Positive | None = key("J2 / J1, or the ratio of masses, or inertia or mass", None)
    inertia: Inertia | None = key("J2, in torsion", None, gt=0)
    mass: Mass | None = key("in translation", None, gt=0)
    friction_ratio: Positive | None = key(
        "friction over the amplitude of the force on the primary; default: the best", None
    )
    friction_torque: Moment | None = key("at which it slips, instead, in torsion", None, gt=0)
    friction_force: Force | None = key("at which it slips, in translation", None, gt=0)
    torque: Moment | None = key("amplitude that acts on the primary, in torsion", None, gt=0)
    force: Force | None = key("amplitude that acts on the primary, in translation", None, gt=0)
    RULES = (
        one_of(*WAYS["mass"]),
        at_most_one("friction_ratio", "friction_torque", "friction_force"),
        needs("friction_torque", "torque", "friction counts against the torque on the primary"),
        needs("friction_force", "force", "friction counts against the force on the primary"),
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

    diameter: Length = key("outer one", gt=0)
    bore: Length = key("inner diameter of a tube", 0.0, ge=0)
    length: Length | None = key("that is twisted", None, gt=0)
    shear_modulus: Modulus | None = key("with length it gives the primary's stiffness", None)
    total_length: Length | None = key(
        "from the first support to the free end, for bending", None, gt=0
    )
    span: Length | None = key("between the two supports, for bending", None, gt=0)
    elastic_modulus: Modulus | None = key("for bending", None)
    mass: Mass | None = key("of the total length, for bending", None, gt=0)
    density: Density | None = key("instead of mass", None)
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

    mass: Mass = key("of all that is fixed there", gt=0)
    diametral_inertia: Inertia = key(
        "about a line across the rod, through the mass centre", 0.0, ge=0
    )
    polar_inertia: Inertia = key("about the rod, for spin", 0.0, ge=0)
    offset: Length = key(
        "of the mass centre beyond the end of the rod; negative: back over it", 0.0
    )
    spin: AngularSpeed = key("of a shaft that turns; 0 for a rod that only oscillates", 0.0, ge=0)
    modes: int = key("bending modes to compute", 2, strict=True, ge=1, le=6)
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

    count: Count = key("springs that act together")
    radius: Length | None = key("from the axis to the hook on the mass, in torsion", None, gt=0)
    angle: Angle = key("of each line against the tangent, or the motion", 0.0, gt=-1.5, lt=1.5)
    rate: LinearStiffness | None = key("of each, or from the wire", None, gt=0)
    wire_diameter: Length | None = key("instead of rate", None, gt=0)
    coil_diameter: Length | None = key("mean one, from centre to centre of the wire", None, gt=0)
    turns: Positive | None = key("active ones", None)
    shear_modulus: Modulus | None = key("of the wire", None)
    initial_tension: Force = key("with which the coils are wound", 0.0, ge=0)
    allowed_stress: Stress | None = key(
        "in shear: it bounds the extension of the wire's spring", None, gt=0
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

    outer_radius: Length = key("of the ring", gt=0)
    inner_radius: Length = key("0: a disc", 0.0, ge=0)
    width: Length = key("along the axis", gt=0)
    density: Density = key("of its material")
    RULES = (below("inner_radius", "outer_radius", _NOT_BELOW),)


_NO_FILM = "a gap as wide as the mass is no film: its damping cannot be determined"
OILS = frozenset({"oil", "stock_oils", "oil_catalogue"})


class Gap(Table):
    """The gaps full of oil around the seismic mass: its damping for a viscosity."""

    outer_radius: Length = key("of the mass", gt=0)
    inner_radius: Length = key("0: a disc without a bore", 0.0, ge=0)
    width: Length = key("of the mass at its rim, along the axis", gt=0)
    clearance: Length | None = key(
        "at rim and sides; default: 0.010 in (1 + sqrt(2 outer_radius / 10 in))", None, gt=0
    )
    side_clearance: Length | None = key("where the sides have their own", None, gt=0)
    bore_clearance: Length | None = key("of a film in the bore; default: there is none", None, gt=0)
    temperature: Temperature | None = key(
        "of the oil while it runs, '60 degC' or in K; oils need it", None
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

    viscosities: Viscosities = key("kinematic, at the two temperatures, '86 cSt' or in m^2/s")
    temperatures: Temperatures = key(
        "'40 degC' and '100 degC' if not said, otherwise so or in K", STATED
    )
    density: LiquidDensity = key("at 15 degC")
    expansion: Expansion | None = key(
        "change of volume; default: that of mineral oils, from the density", None
    )
    RULES = (refuse("viscosities", _NO_OIL, _thickens, _THINNER, found="{viscosities}"),)


class StockSpring(Table):
    """A spring that can be bought."""

    name: Name = key("label in tables and `where`")
    rate: LinearStiffness = key("of one spring", gt=0)
    parallel: Several | None = key(
        "every number up to it is tried; default: springs.count of them", None
    )
    series: Annotated[int, Field(strict=True, ge=1, le=10)] | None = key(
        "up to so many behind each other in each line; default: 1", None
    )
    RULES = (needs("series", "parallel", "springs.count says how many act together, each alone"),)


class StockOil(Oil):
    """An oil that can be bought."""

    name: Name = key("label in tables and `where`")


class StockDamper(Table):
    """A damper that can be bought, for an absorber that moves in a line."""

    name: Name = key("label in tables and `where`")
    linear_damping: LinearDamping = key("of one damper", gt=0)
    count: Count = key("dampers that act together", 1)
    parallel: Several = key("every number of such sets up to it is tried", 1)


PartNumbers = Annotated[tuple[PartNumber, ...], Field(min_length=1, max_length=2000)]
Rates = Annotated[tuple[LinearStiffness, ...], Field(min_length=1, max_length=2000)]
ManyViscosities = Annotated[tuple[KinematicViscosity, ...], Field(min_length=1, max_length=2000)]
Densities = Annotated[tuple[LiquidDensity, ...], Field(min_length=1, max_length=2000)]


class SpringCatalogue(Table):
    """Springs that can be bought, one in each row."""

    part: PartNumbers = key("its number")
    rate: Rates = key("of one spring")
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

    part: PartNumbers = key("its number or grade")
    viscosity_40: ManyViscosities = key("at 40 degC")
    viscosity_100: ManyViscosities = key("at 100 degC")
    density: Densities = key("at 15 degC")
    RULES = (same_length("part", "viscosity_40", "viscosity_100", "density"), _thins)


StockSprings = Annotated[tuple[StockSpring, ...], Field(max_length=200)]
StockDampers = Annotated[tuple[StockDamper, ...], Field(max_length=200)]
StockOils = Annotated[tuple[StockOil, ...], Field(max_length=200)]

# ----------------------------------------------------------------------------
# A pendulum in the centrifugal field of a rotor, as a case gives it.
# ----------------------------------------------------------------------------


class Swings(Table):
    """Angles of swing up to which the order is followed."""

    to: Angle = key("largest angle by which the tangent turns", gt=0)
    points: int = key("from zero on", 41, strict=True, ge=2, le=2000)


class Rollers(Table):
    """Two equal rollers in equal cutouts that carry the mass: a bifilar mount."""

    mass: Mass = key("of all rollers of one pendulum", gt=0)
    distance: Length = key("mean, from the axis to their centres across the vertex", gt=0)
    diameter: Length = key("of a roller", gt=0)
    inertia: Inertia | None = key("of all about their own axes; default: solid ones", None, ge=0)


class Pendulum(Table):
    """Equal pendulums on a rotor that follow one order of its speed."""

    order: Positive = key("of the excitation that they have to follow")
    mass: Mass = key("of one pendulum, without its rollers", gt=0)
    count: Count = key("pendulums that swing together", 1)
    vertex_distance: Length | None = key("from the axis to the mass centre at rest", None, gt=0)
    arm_radius: Length | None = key("from the axis to the centre of the path, instead", None, gt=0)
    path: Literal["circular", "cycloidal", "epicycloidal"] = key(
        "of the mass centre; an epicycloid keeps its order", "circular"
    )
    path_radius: Length | None = key(
        "of curvature at the vertex; default: as the order wants it", None, gt=0
    )
    swing_inertia: Inertia = key(
        "of one mass about its centre, where it turns with an arm", 0.0, ge=0
    )
    rollers: Rollers | None = key("of one pendulum; default: a point on an arm", None)
    damping_ratio: Share = key("of small swings, on their own frequency; at 1 it creeps", 0.0, lt=1)
    rotor_inertia: Inertia = key("of all that turns, without pendulums", gt=0)
    rotor_stiffness: AngularStiffness = key(
        "that holds the rotor against its mean turning; 0: none", 0.0, ge=0
    )
    speed: AngularSpeed = key("mean speed of the rotor", gt=0)
    torque: Moment | None = key("amplitude of the exciting torque: how far it swings", None, gt=0)
    swings: Swings | None = key("detuning with the angle of swing", None)
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
