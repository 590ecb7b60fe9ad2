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
from vibecalc.core.case.rules import Row, at_most_one, below, needs, one_of, refuse, same_length
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
    """A mode of a floor, a bridge or a frame that carries the absorber."""

    natural_frequency: Frequency = key("without the absorber, '6 Hz'", gt=0)
    modal_mass: Mass = key("in the scaling of the mode shape values", gt=0)
    damping_ratio: Share = key("fraction of critical damping", 0.0, lt=1)
    shape_at_absorber: Ordinate = key("mode shape at the absorber", 1.0)
    shape_at_response: Ordinate = key("mode shape where the response is read", 1.0)
    shape_at_force: Ordinate | None = key(
        "mode shape where the force acts; default: as shape_at_response", None
    )
    participation: Ordinate | None = key(
        "sum of mass times shape over modal_mass, for base excitation", None
    )


class Primary(Table):
    """Primary system: ratios alone, or with inertia (torsion) or mass (translation).

    Every ratio is relative to it; without inertia or mass all results are ratios.
    """

    damping_ratio: Share | None = key("c1 / (2 sqrt(K1 J1)); default: 0, undamped", None)
    inertia: Inertia | None = key("J1, in torsion", None, gt=0)
    stiffness: AngularStiffness | None = key(
        "K1 to ground, in torsion; or from [machine.rod]", None, gt=0
    )
    damping: AngularDamping | None = key(
        "c1 to ground, in torsion, instead of damping_ratio", None, ge=0
    )
    mass: Mass | None = key("in translation, instead of inertia", None, gt=0)
    linear_stiffness: LinearStiffness | None = key(
        "to ground, in translation, instead of stiffness", None, gt=0
    )
    linear_damping: LinearDamping | None = key(
        "to ground, in translation, instead of damping", None, ge=0
    )
    natural_frequency: Frequency | None = key("instead of stiffness, '8 Hz'", None, gt=0)
    modes: tuple[Mode, ...] = key(
        "several modes with modal masses, instead of all other keys", (), max_length=20
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
    """The absorber: mass, with spring and damper unless [tuning] finds them."""

    mass_ratio: Positive | None = key("J2 / J1 or m2 / m1, instead of inertia or mass", None)
    inertia: Inertia | None = key("J2, in torsion", None, gt=0)
    mass: Mass | None = key("in translation", None, gt=0)
    stiffness_ratio: Share | None = key(
        "K2 / K1, instead of stiffness; 0: viscous damper without a spring", None
    )
    stiffness: AngularStiffness | None = key("K2 to its carrier, in torsion", None, ge=0)
    linear_stiffness: LinearStiffness | None = key("to its carrier, in translation", None, ge=0)
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
            "without a spring the absorber has no natural frequency for this ratio",
            lambda t: "absorber_damping_ratio" in t and 0.0 in map(t.number, WAYS["stiffness"]),
            "damping_over_primary_critical, which is referred to the primary, or a stiffness > 0",
        ),
    )


class NamedSecondary(Secondary):
    """One of several absorbers, side by side or one on another."""

    name: Name = key("label used in `on`, in tables and in `where`")
    on: Name = key("its carrier: the primary, or another absorber by name", "primary")
    mode_shapes: tuple[Ordinate, ...] = key(
        "each of primary.modes at this absorber; default: shape_at_absorber",
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
    """Lanchester damper: a mass coupled by dry friction, instead of an absorber."""

    mass_ratio: Positive | None = key("J2 / J1 or m2 / m1; or inertia or mass", None)
    inertia: Inertia | None = key("J2, in torsion", None, gt=0)
    mass: Mass | None = key("in translation", None, gt=0)
    friction_ratio: Positive | None = key(
        "friction over the force amplitude on the primary; default: optimum", None
    )
    friction_torque: Moment | None = key("slip torque instead, in torsion", None, gt=0)
    friction_force: Force | None = key("slip force instead, in translation", None, gt=0)
    torque: Moment | None = key("torque amplitude on the primary, in torsion", None, gt=0)
    force: Force | None = key("force amplitude on the primary, in translation", None, gt=0)
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
    """Round rod that is the primary's spring; with its supports, its bending."""

    diameter: Length = key("outer diameter", gt=0)
    bore: Length = key("inner diameter of a tube", 0.0, ge=0)
    length: Length | None = key("twisted length", None, gt=0)
    shear_modulus: Modulus | None = key("gives the primary's stiffness, with length", None)
    total_length: Length | None = key(
        "from the first support to the free end, for bending", None, gt=0
    )
    span: Length | None = key("distance of the two supports, for bending", None, gt=0)
    elastic_modulus: Modulus | None = key("for bending", None)
    mass: Mass | None = key("of total_length, for bending", None, gt=0)
    density: Density | None = key("instead of mass", None)
    RULES = (
        needs("length", "shear_modulus", "they give its stiffness together"),
        needs("shear_modulus", "length", "they give its stiffness together"),
        at_most_one("mass", "density"),
        below("bore", "diameter", "the bore is as wide as the rod"),
        below(
            "span",
            "total_length",
            "the distance of the supports exceeds the length of the rod",
            equal=True,
        ),
    )


def _is_no_body(row: Row) -> bool:
    polar, across = row.number("polar_inertia"), row.number("diametral_inertia")
    return polar is not None and across is not None and polar > 2.0 * across * (1.0 + 1e-6)


class Flywheel(Table):
    """Body on the free end of the rod, for bending."""

    mass: Mass = key("total mass at the rod's end", gt=0)
    diametral_inertia: Inertia = key(
        "about an axis across the rod, through the mass centre", 0.0, ge=0
    )
    polar_inertia: Inertia = key("about the rod, for gyroscopic effects", 0.0, ge=0)
    offset: Length = key("mass centre beyond the rod's end; negative: before it", 0.0)
    spin: AngularSpeed = key(
        "speed of a rotating shaft; 0 for a rod that only oscillates", 0.0, ge=0
    )
    modes: int = key("number of bending modes", 2, strict=True, ge=1, le=6)
    RULES = (
        refuse(
            "polar_inertia",
            "impossible polar inertia: it is at most twice the diametral one",
            _is_no_body,
            "at most twice diametral_inertia",
            found="{polar_inertia}",
            also="diametral_inertia",
        ),
    )


WIRE = ("wire_diameter", "coil_diameter", "turns", "shear_modulus")
_NOT_BELOW = "the inner radius must be smaller than the outer one"


class Springs(Table):
    """Equal helical springs between primary and seismic mass.

    With a rate, given or from the wire, they are the secondary's stiffness as built; without one
    they are the places of springs whose rate [tuning] finds.
    """

    count: Count = key("number of springs in parallel")
    radius: Length | None = key(
        "from the axis to the attachment on the mass, in torsion", None, gt=0
    )
    angle: Angle = key(
        "between spring axis and tangent, or direction of motion", 0.0, gt=-1.5, lt=1.5
    )
    rate: LinearStiffness | None = key("of each spring; or from the wire", None, gt=0)
    wire_diameter: Length | None = key("instead of rate", None, gt=0)
    coil_diameter: Length | None = key("mean coil diameter", None, gt=0)
    turns: Positive | None = key("number of active coils", None)
    shear_modulus: Modulus | None = key("of the wire", None)
    initial_tension: Force = key("built-in tension of close-wound coils", 0.0, ge=0)
    allowed_stress: Stress | None = key("allowable shear stress; limits the extension", None, gt=0)
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
            "the mean coil diameter must exceed the wire diameter",
        ),
    )


class Ring(Table):
    """Seismic mass as a ring of rectangular section, which gives the absorber's inertia."""

    outer_radius: Length = key("outer radius", gt=0)
    inner_radius: Length = key("0: a disc", 0.0, ge=0)
    width: Length = key("axial width", gt=0)
    density: Density = key("of its material")
    RULES = (below("inner_radius", "outer_radius", _NOT_BELOW),)


_NO_FILM = "a gap as wide as the mass is not an oil film: its damping cannot be computed"
OILS = frozenset({"oil", "stock_oils", "oil_catalogue"})


class Gap(Table):
    """Oil-filled gaps around the seismic mass: damping for a viscosity."""

    outer_radius: Length = key("of the mass", gt=0)
    inner_radius: Length = key("0: a disc without a bore", 0.0, ge=0)
    width: Length = key("axial width of the mass at its rim", gt=0)
    clearance: Length | None = key(
        "at rim and sides; default: 0.010 in (1 + sqrt(2 outer_radius / 10 in))", None, gt=0
    )
    side_clearance: Length | None = key("at the sides, if different", None, gt=0)
    bore_clearance: Length | None = key("of an oil film in the bore; default: no film", None, gt=0)
    temperature: Temperature | None = key(
        "operating temperature of the oil, '60 degC' or in K; needed with oils", None
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


_NO_OIL = "impossible viscosities: oil is thinner at the higher temperature"


_THINNER = "two temperatures, with the lower viscosity at the higher one"


def _thickens(row: Row) -> bool:
    warm, thick = row.listed("temperatures") or [*STATED], row.listed("viscosities")
    if len(warm) != 2 or len(thick) != 2 or None in (*warm, *thick):
        return False
    return bool((warm[1] - warm[0]) * (thick[0] - thick[1]) <= 0.0)


class Oil(Table):
    """Oil by two kinematic viscosities (ASTM D341) and its density."""

    viscosities: Viscosities = key("kinematic, at the two temperatures, '86 cSt' or in m^2/s")
    temperatures: Temperatures = key(
        "of the viscosities; default: '40 degC' and '100 degC'", STATED
    )
    density: LiquidDensity = key("at 15 degC")
    expansion: Expansion | None = key(
        "coefficient of volumetric expansion; default: mineral oil of this density", None
    )
    RULES = (refuse("viscosities", _NO_OIL, _thickens, _THINNER, found="{viscosities}"),)


class StockSpring(Table):
    """A stock spring."""

    name: Name = key("label in tables and `where`")
    rate: LinearStiffness = key("of one spring", gt=0)
    parallel: Several | None = key(
        "maximum number in parallel, every number is tried; default: springs.count", None
    )
    series: Annotated[int, Field(strict=True, ge=1, le=10)] | None = key(
        "maximum number in series in each line; default: 1", None
    )
    RULES = (needs("series", "parallel", "springs.count says how many act together, each alone"),)


class StockOil(Oil):
    """A stock oil."""

    name: Name = key("label in tables and `where`")


class StockDamper(Table):
    """A stock damper, for an absorber in translation."""

    name: Name = key("label in tables and `where`")
    linear_damping: LinearDamping = key("of one damper", gt=0)
    count: Count = key("dampers that act together, as a set", 1)
    parallel: Several = key("maximum number of sets, every number is tried", 1)


PartNumbers = Annotated[tuple[PartNumber, ...], Field(min_length=1, max_length=2000)]
Rates = Annotated[tuple[LinearStiffness, ...], Field(min_length=1, max_length=2000)]
ManyViscosities = Annotated[tuple[KinematicViscosity, ...], Field(min_length=1, max_length=2000)]
Densities = Annotated[tuple[LiquidDensity, ...], Field(min_length=1, max_length=2000)]


class SpringCatalogue(Table):
    """Stock springs, one per row."""

    part: PartNumbers = key("part number")
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
    """Stock oils, one per row."""

    part: PartNumbers = key("part number or grade")
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
    """Swing angles over which the order is computed."""

    to: Angle = key("largest angle by which the tangent turns", gt=0)
    points: int = key("number of points, from zero", 41, strict=True, ge=2, le=2000)


class Rollers(Table):
    """Two equal rollers in equal cut-outs that carry the mass: a bifilar pendulum."""

    mass: Mass = key("of all rollers of one pendulum", gt=0)
    distance: Length = key("mean distance of the roller centres from the axis, at the vertex", gt=0)
    diameter: Length = key("of a roller", gt=0)
    inertia: Inertia | None = key(
        "of all rollers about their own axes; default: solid rollers", None, ge=0
    )


class Pendulum(Table):
    """Equal centrifugal pendulums on a rotor, tuned to one order of its speed."""

    order: Positive = key("excitation order to absorb")
    mass: Mass = key("of one pendulum, without its rollers", gt=0)
    count: Count = key("number of equal pendulums", 1)
    vertex_distance: Length | None = key("from the axis to the mass centre at rest", None, gt=0)
    arm_radius: Length | None = key(
        "from the axis to the centre of the path, instead of vertex_distance", None, gt=0
    )
    path: Literal["circular", "cycloidal", "epicycloidal"] = key(
        "path of the mass centre; an epicycloid keeps its order at any amplitude", "circular"
    )
    path_radius: Length | None = key(
        "radius of curvature at the vertex; default: from the order", None, gt=0
    )
    swing_inertia: Inertia = key(
        "of one pendulum about its mass centre, if it rotates with an arm", 0.0, ge=0
    )
    rollers: Rollers | None = key("of one pendulum; default: mass on an arm", None)
    damping_ratio: Share = key(
        "of small swings, fraction of critical; 1: no oscillation", 0.0, lt=1
    )
    rotor_inertia: Inertia = key("of the rotor, without pendulums", gt=0)
    rotor_stiffness: AngularStiffness = key(
        "of the rotor against its steady rotation; 0: free", 0.0, ge=0
    )
    speed: AngularSpeed = key("mean speed of the rotor", gt=0)
    torque: Moment | None = key(
        "amplitude of the exciting torque, for the swing amplitude", None, gt=0
    )
    swings: Swings | None = key("detuning over the swing angle", None)
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
