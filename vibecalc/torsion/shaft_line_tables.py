"""The shaft line in a case: tables of its parts, and how its stations hang together."""

import math
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple

from pydantic import Field

from vibecalc.core.case.fields import (
    AngularDamping,
    AngularStiffness,
    Density,
    Inertia,
    Length,
    Mass,
    Modulus,
    Moment,
    Name,
    Number,
    Stress,
    Table,
    Unit,
    key,
    later,
)
from vibecalc.core.case.raw import tables_at
from vibecalc.core.case.rules import (
    Row,
    at_most_one,
    below,
    by_kind,
    needs,
    one_of,
    refers,
    refuse,
    unique,
)
from vibecalc.errors import Problem

_PARTS = "vibecalc.torsion.line_part_tables"
if TYPE_CHECKING:
    from vibecalc.torsion.line_part_tables import (
        Coupling,
        EngineDamping,
        FatigueLine,
        LoadCurve,
        OverSpeed,
        PropellerDamping,
        StationExcitation,
    )
else:
    _named = "Coupling EngineDamping FatigueLine LoadCurve OverSpeed PropellerDamping"
    globals().update(later({_PARTS: f"{_named} StationExcitation"}))

# ----------------------------------------------------------------------------
# A damper on a shaft line: a ring behind oil, springs or dry friction, or pendulums.
# ----------------------------------------------------------------------------

DamperKind = Literal["viscous", "spring", "friction", "pendulum"]


class LineDamper(Table):
    """Damper or pendulums on a station, whose inertia includes hub and casing."""

    name: Name = key("label in tables and `where`")
    on: Name = key("name of its station")
    kind: DamperKind = key("ring in oil, on springs or on dry friction, or pendulums")
    inertia: Inertia | None = key("of the ring, about the axis of its station", None, gt=0)
    stiffness: AngularStiffness | None = key(
        "of the springs, or friction linings, between station and ring", None, ge=0
    )
    damping: AngularDamping = key(
        "viscous, between station and ring, or pendulums about the axis",
        0.0,
        ge=0,
    )
    friction_torque: Moment | None = key(
        "slip torque of the linings, on the shaft of its station", None, gt=0
    )
    loss_factor: Number = key("of the springs, k (1 + i loss_factor)", 0.0, ge=0, le=10)
    order: Number | None = key(
        "tuned order of pendulums, per turn of the station; of friction dampers, of machine.speed",
        None,
        gt=0,
        le=400,
    )
    mass: Mass | None = key("of one pendulum", None, gt=0)
    count: int = key("equal pendulums", 1, strict=True, ge=1, le=1000)
    arm_radius: Length | None = key("from the axis to the pivot of a pendulum", None, gt=0)
    RULES = (
        by_kind(
            "damper",
            viscous="inertia damping",
            spring="inertia stiffness | damping loss_factor",
            friction="inertia stiffness friction_torque order | damping",
            pendulum="order mass arm_radius | damping count",
        ),
    )


# ----------------------------------------------------------------------------
# The shaft line of an engine: stations that turn, and what holds them together.
# ----------------------------------------------------------------------------

SectionModulus = Annotated[float, Field(gt=0), Unit("m^3", "a section modulus")]
LinearStiffness = Annotated[float, Field(gt=0), Unit("N/m")]
Teeth = Annotated[int, Field(strict=True, ge=3, le=100_000)]
TwoNames = tuple[Name, Name]
_NARROWER = "a bore must be smaller than the outer diameter"
_TWO_ENDS = "a rectangular web has two ends"


class CrankDimensions(Table):
    """Journal, pin and web of a throw, solid forged or cast."""

    journal_diameter: Length = key("outer, of the main journal", gt=0)
    journal_bore: Length = key("of a hollow journal", 0.0, ge=0)
    pin_diameter: Length = key("outer, of the crank pin", gt=0)
    pin_bore: Length = key("of a hollow pin", 0.0, ge=0)
    web_thickness: Length = key("of one web, axial", gt=0)
    web_width: Length = key("of a web, across the throw", gt=0)
    pin_recess: Length = key("of the pin's fillet into the web", 0.0, ge=0)
    journal_recess: Length = key("of the journal's fillet into the web", 0.0, ge=0)
    oil_bore: Length | None = key("diameter, radial, in the pin", None, gt=0)
    RULES: ClassVar[tuple[Any, ...]] = (
        below("journal_bore", "journal_diameter", _NARROWER),
        below("pin_bore", "pin_diameter", _NARROWER),
    )


class Throw(CrankDimensions):
    """One throw of a crankshaft: half a journal, a web, the pin, a web, half a journal."""

    journal_length: Length = key("of one journal between two webs", gt=0)
    pin_length: Length = key("of the pin between the webs", gt=0)
    beyond_journal: Length | None = key(
        "of a rectangular web, beyond the axis of the journal", None, gt=0
    )
    beyond_pin: Length | None = key(
        "and beyond that of the pin; without both a web ends in half discs", None, gt=0
    )
    formula: Literal["source", "timoshenko", "carter", "ker_wilson"] = key(
        "formula of the stiffness", "carter"
    )
    density: Density = key("of the steel", 7850.0)
    shear_modulus: Modulus = key("of the steel", 80e9)
    balance_weight_inertia: Inertia = key(
        "about the crank axis, of the weights on both webs", 0.0, ge=0
    )
    pin_fillet: Length | None = key(
        "radius between pin and web, for the rule for crankshafts", None, gt=0
    )
    journal_fillet: Length | None = key("radius between journal and web, for that rule", None, gt=0)
    RULES = (
        needs("pin_fillet", "journal_fillet", "a throw has both"),
        needs("journal_fillet", "pin_fillet", "a throw has both"),
        needs("beyond_journal", "beyond_pin", _TWO_ENDS),
        needs("beyond_pin", "beyond_journal", _TWO_ENDS),
        *CrankDimensions.RULES,
    )


class Station(Table):
    """One inertia of the line, on its own shaft."""

    name: Name = key("label used in tables, in `between` and in `where`")
    inertia: Inertia | None = key("on its own shaft; 0: a point without mass", None, ge=0)
    throw: Throw | None = key(
        "dimensions that give the inertia, with rod and piston of its cylinders", None
    )
    cylinder: Name | None = key("name of the cylinder at this station", None)
    cylinders: tuple[Name, ...] = key(
        "instead, names of several cylinders on one throw, as in a V engine", (), max_length=8
    )
    absolute_damping: AngularDamping = key(
        "against the steady rotation, on its own shaft", 0.0, ge=0
    )
    over_speed: OverSpeed | None = key("factor on absolute_damping against the speed", None)
    ground_stiffness: AngularStiffness = key(
        "to the steady rotation, as of an infinite grid", 0.0, ge=0
    )
    RULES = (
        refuse(
            "name",
            "the name of the station is blank",
            lambda t: isinstance(t["name"], str) and t["name"].isspace(),
            "a name with visible characters",
        ),
        one_of("inertia", "throw"),
        at_most_one("cylinder", "cylinders"),
        needs("over_speed", "absolute_damping", "it is a factor on it"),
    )

    @property
    def turned_by(self) -> tuple[str, ...]:
        """Names of the cylinders that turn it."""
        return self.cylinders if self.cylinder is None else (self.cylinder,)


def _cone(row: Row) -> Iterator[Problem]:
    """The bore at the other end of a cone is narrower, too."""
    inner, outer = (
        f"end_{side}" if f"end_{side}" in row else side
        for side in ("inner_diameter", "outer_diameter")
    )
    if (inner, outer) != ("inner_diameter", "outer_diameter"):
        yield from below(inner, outer, _NARROWER)(row)


class Section(Table):
    """A round shaft from its dimensions, plain or a cone from one end to the other."""

    outer_diameter: Length = key("of the shaft", gt=0)
    inner_diameter: Length = key("of its bore; 0: solid", 0.0, ge=0)
    end_outer_diameter: Length | None = key(
        "at its other end, of a cone; default: the same", None, gt=0
    )
    end_inner_diameter: Length | None = key(
        "of the bore at the other end; default: the same", None, ge=0
    )
    length: Length = key("twisted length", gt=0)
    shear_modulus: Modulus = key("of the material", 80e9)
    RULES = (below("inner_diameter", "outer_diameter", _NARROWER), _cone)


#: of what leads from one station to another
_TO_ITSELF = refuse(
    "between",
    "this {list} connects a station to itself",
    lambda t: len({*map(str, t.entries("between"))}) == 1,
    "two different stations",
    found="{between}",
)


class Shaft(Table):
    """Elastic element between two stations: a shaft, a throw or a coupling."""

    name: Name | None = key("label; default: 'first - second'", None)
    between: TwoNames | None = key(
        "names of two stations; default: from each station to the next", None
    )
    stiffness: AngularStiffness | None = key(
        "on its own shaft; or section, throw, coupling", None, gt=0
    )
    section: Section | None = key("dimensions that give the stiffness", None)
    throw: Throw | None = key("of a crank, that give the stiffness", None)
    coupling: Coupling | None = key(
        "elastic coupling by catalogue values, with damping and limits", None
    )
    damping: AngularDamping | None = key("viscous, of the twist; default: none", None, ge=0)
    damping_ratio: Number | None = key(
        "instead: fraction of critical, of the two neighbouring inertias alone",
        None,
        ge=0,
        le=10,
    )
    loss_factor: Number = key("of a complex stiffness k (1 + i loss_factor)", 0.0, ge=0, le=10)
    magnifier: Number | None = key(
        "dynamic magnifier M, instead: loss_factor = 1 / M", None, ge=0.1
    )
    lehr_ratio: Number | None = key(
        "Lehr's damping ratio D, instead: loss_factor = 2 D", None, ge=0, le=5
    )
    over_speed: OverSpeed | None = key(
        "factor on its damping and loss factor against the speed", None
    )
    diameter: Length | None = key("of the solid shaft where stress is evaluated", None, gt=0)
    section_modulus: SectionModulus | None = key(
        "polar, instead of diameter: stress is torque over this", None
    )
    tensile_strength: Stress | None = key("of the material, for a class rule", None, gt=0)
    fatigue: FatigueLine | None = key("S-N line, for cycle counts of transients", None)
    RULES = (
        one_of("stiffness", "section", "throw", "coupling"),
        at_most_one("coupling", "loss_factor"),
        at_most_one("damping", "damping_ratio"),
        at_most_one("magnifier", "lehr_ratio"),
        refuse(
            "loss_factor",
            "loss_factor and another word for it are mutually exclusive",
            lambda t: t.number("loss_factor") and ("magnifier" in t or "lehr_ratio" in t),
            "loss_factor, magnifier, or lehr_ratio",
        ),
        needs(
            "over_speed",
            "damping damping_ratio loss_factor magnifier lehr_ratio",
            "it is a factor on one of them",
        ),
        at_most_one("diameter", "section_modulus"),
        _TO_ITSELF,
    )

    @property
    def has_stress(self) -> bool:
        """Whether the case says enough for torque over section modulus."""
        given = (self.diameter, self.section_modulus, self.section, self.throw)
        return any(one is not None for one in given)

    @property
    def eta(self) -> float:
        """Of the complex stiffness k (1 + i eta): as given, 1 / M of a magnifier, or 2 D of Lehr's.

        Of a coupling it is psi / (2 pi) with its nominal relative damping.
        """
        if self.coupling is not None:
            from vibecalc.torsion.couplings import nominal

            return nominal(self.coupling).relative_damping / (2.0 * math.pi)
        if self.magnifier is not None:
            return 1.0 / self.magnifier
        return self.loss_factor if self.lehr_ratio is None else 2.0 * self.lehr_ratio


class Gear(Table):
    """A gear between two stations."""

    name: Name | None = key("label; default: 'first - second'", None)
    between: TwoNames = key("names of two stations")
    ratio: Number | None = key(
        "speed of the second over that of the first; or teeth", None, ge=1e-6, le=1e6
    )
    teeth: tuple[Teeth, Teeth] | None = key("of the first and of the second wheel", None)
    reverses: bool = key("the second wheel turns the other way", True, strict=True)
    mesh_stiffness: LinearStiffness | None = key("along the line of action; default: rigid", None)
    pitch_radius: Length | None = key(
        "of the first wheel, with mesh_stiffness; it gives tooth forces", None, gt=0
    )
    RULES = (
        one_of("ratio", "teeth"),
        needs("mesh_stiffness", "pitch_radius", "it is along the line of action"),
        _TO_ITSELF,
    )

    @property
    def label(self) -> str:
        """Its name, or those of its stations."""
        return self.name or " - ".join(self.between)

    @property
    def signed_ratio(self) -> float:
        """Speed of the second station over that of the first, with its sign."""
        size = self.ratio
        if size is None:
            assert self.teeth is not None  # one of the two, says the form
            size = self.teeth[0] / self.teeth[1]
        return -size if self.reverses else size


class Load(Table):
    """A mean torque absorbed at a station, other than `balanced_by`."""

    on: Name = key("name of a station")
    torque: Moment | None = key(
        "mean, at the operating speed, on its own shaft; positive brakes", None
    )
    exponent: Number = key("of the speed: 0 constant, 2 propeller", 0.0, ge=0, le=4)
    curve: LoadCurve | None = key(
        "instead of torque and exponent: over speed, a table or a CSV", None
    )
    propeller_damping: PropellerDamping | None = key(
        "absolute damping of its station from this torque", None
    )
    RULES = (one_of("torque", "curve"), at_most_one("curve", "exponent"))


def _some_between(row: Row) -> Iterator[Problem]:
    """All shafts say between which stations they are, or none does."""
    shafts = tables_at(row.data, "shafts")
    said = [place for place, shaft in shafts if "between" in shaft]
    silent = [place for place, shaft in shafts if "between" not in shaft]
    if said and silent:
        yield row.problem(
            (*row.path, "shafts", silent[0]),
            "this shaft has no `between`, but others have one",
            allowed="between = ['first', 'second'] for every shaft, or for none",
            also=(*row.path, "shafts", said[0], "between"),
        )


_STATIONS, _CYLINDERS = "machine.shaft_line.stations", "machine.crank_train.cylinders"


class ShaftLine(Table):
    """Inertias, shafts, gears and dampers of the whole installation."""

    stations: tuple[Station, ...] = key(
        "inertias in order, also as a CSV", min_length=1, max_length=2000
    )
    shafts: tuple[Shaft, ...] = key("between stations, also as a CSV", (), max_length=4000)
    gears: tuple[Gear, ...] = key("between two shafts, also as a CSV", (), max_length=64)
    dampers: tuple[LineDamper, ...] = key("dampers and pendulums on stations", (), max_length=16)
    balanced_by: Name | None = key("station that balances the mean torque; default: the last", None)
    speed_of: Name | None = key(
        "without cylinders: name of the station that turns with machine.speed; default: the first",
        None,
    )
    absorbed_torques: tuple[Load, ...] = key("mean torques of other stations", (), max_length=64)
    excitations: tuple[StationExcitation, ...] = key(
        "alternating torques, besides those of cylinders", (), max_length=64
    )
    engine_damping: EngineDamping | None = key(
        "absolute damping at every station with a cylinder", None
    )
    RULES = (
        *(unique(key) for key in ("stations", "shafts", "gears", "dampers")),
        _some_between,
        *(
            refers(key, _STATIONS, "station")
            for key in (
                "shafts.between",
                "gears.between",
                "dampers.on",
                "absorbed_torques.on",
                "balanced_by",
            )
        ),
        refers("excitations.on", _STATIONS, "station"),
        refers("speed_of", _STATIONS, "station"),
        refers("stations.cylinder", _CYLINDERS, "cylinder"),
        refers("stations.cylinders", _CYLINDERS, "cylinder"),
    )


# ----------------------------------------------------------------------------
# How the stations of a shaft line hang together: parts, speed ratios, rigid gears.
#
# Stations are numbers 0 .. n - 1 here. A ratio is a station's own speed over that of the
# crankshaft, negative where it turns the other way.
# ----------------------------------------------------------------------------


class StationJoint(NamedTuple):
    """Two stations that something joins, and the speed of the second over that of the first."""

    first: int
    second: int
    ratio: float = 1.0


class Ratios(NamedTuple):
    """Speed ratio of each station, and the first joint that contradicts the others, or None.

    A station that nothing joins to the crankshaft counts from the first one of its own part.
    """

    ratio: list[float]
    part: list[int]
    contradiction: tuple[int, float, float] | None


#: relative difference of two ways to a ratio that counts as one: ratios are often typed rounded
SAME_RATIO = 1e-6


class Layout:
    """Names and places of a line, and what joins them.

    `at` has the number of each of the `names`; `ends` are the names of the two stations of each
    shaft, where none says them each leads to the next; `sections` are the names of the shafts,
    those without one after their ends; `joints` all shafts, then all gears. `crank` is the station
    whose speed is that of the crankshaft: the first with a cylinder, or else the one that the case
    names, or the first; `load` takes up the mean torque that is left.
    """

    def __init__(self, line: ShaftLine) -> None:
        self.names = [station.name for station in line.stations]
        self.at = {name: place for place, name in enumerate(self.names)}
        following = [*zip(self.names, self.names[1:], strict=False)]
        following += [("", "")] * len(line.shafts)
        self.ends = [
            shaft.between or after for shaft, after in zip(line.shafts, following, strict=False)
        ]
        self.sections = [
            shaft.name or " - ".join(ends)
            for shaft, ends in zip(line.shafts, self.ends, strict=True)
        ]
        joined = [(ends, 1.0) for ends in self.ends]
        joined += [(gear.between, gear.signed_ratio) for gear in line.gears]
        self.joints = [
            StationJoint(self.at[first], self.at[second], ratio)
            for (first, second), ratio in joined
            if first in self.at and second in self.at
        ]
        self.rigid = [
            StationJoint(self.at[first], self.at[second])
            for first, second in (g.between for g in line.gears if g.mesh_stiffness is None)
        ]
        self.fires = [bool(station.turned_by) for station in line.stations]
        self.crank = (
            self.fires.index(True) if any(self.fires) else self.at.get(line.speed_of or "", 0)
        )
        self.load = len(self.names) - 1 if line.balanced_by is None else self.at[line.balanced_by]

    @cached_property
    def ratios(self) -> Ratios:
        """Of all stations."""
        return self.joined(self.joints)

    @property
    def ratio(self) -> list[float]:
        """Own speed of each station over that of the crankshaft."""
        return self.ratios.ratio

    @cached_property
    def freedom(self) -> list[int]:
        """Number of each station among those that can twist: rigid gears hold some together."""
        numbers: dict[int, int] = {}
        return [numbers.setdefault(one, len(numbers)) for one in self.joined(self.rigid).part]

    def parts_without(self, place: int) -> list[int]:
        """The part of each station that hangs together were there not one of the `joints`."""
        return self.joined([one for n, one in enumerate(self.joints) if n != place]).part

    def joined(self, joints: Sequence[StationJoint]) -> Ratios:
        """Stations joined one joint after the other; one within a part has to agree with it."""
        count = len(self.names)
        ratio, members = [1.0] * count, [[station] for station in range(count)]
        part = list(range(count))
        contradiction = None
        for place, one in enumerate(joints):
            present, wanted = ratio[one.second], ratio[one.first] * one.ratio
            if part[one.first] != part[one.second]:
                small, large = part[one.second], part[one.first]
                factor = wanted / present
                if len(members[small]) > len(members[large]):
                    small, large, factor = large, small, 1.0 / factor
                for station in members[small]:
                    ratio[station], part[station] = ratio[station] * factor, large
                members[large] += members[small]
            elif contradiction is None and abs(present - wanted) > SAME_RATIO * abs(wanted):
                contradiction = (place, present / ratio[one.first], one.ratio)
        for number in set(part):
            base = ratio[self.crank if part[self.crank] == number else min(members[number])]
            for station in members[number]:
                ratio[station] /= base
        return Ratios(ratio, part, contradiction)


def stressed(line: ShaftLine, layout: Layout) -> list[str]:
    """Names of the shafts whose section modulus is known."""
    named = zip(layout.sections, line.shafts, strict=True)
    return [name for name, shaft in named if shaft.has_stress]


# ----------------------------------------------------------------------------
# Dampings that are more than one number of their station or shaft.
# ----------------------------------------------------------------------------


def has_laws(line: ShaftLine) -> bool:
    """Whether dampings follow the speed, a load or a mode."""
    return (
        line.engine_damping is not None
        or any(one.over_speed is not None for one in line.stations)
        or any(one.over_speed is not None for one in line.shafts)
        or any(one.propeller_damping is not None for one in line.absorbed_torques)
    )


def what_follows(line: ShaftLine) -> dict[str, bool]:
    """Whether absolute dampings, dashpots and loss factors are other ones at other speeds."""

    def moves(given: OverSpeed | None) -> bool:
        return given is not None and given.exponent != 0.0

    engine = line.engine_damping
    stations = any(moves(one.over_speed) and one.absolute_damping for one in line.stations)
    if engine is not None and moves(engine.over_speed):
        given = engine.magnifier, engine.damping_ratio, engine.loss_factor, engine.damping
        stations = stations or any(given)
    stations = stations or any(
        one.propeller_damping is not None and (one.curve is not None or one.exponent != 1.0)
        for one in line.absorbed_torques
    )
    turning = [one for one in line.shafts if moves(one.over_speed)]
    return {
        "station_damping": stations,
        "section_damping": any(one.damping or one.damping_ratio for one in turning),
        "section_loss_factor": any(one.eta for one in turning),
    }
