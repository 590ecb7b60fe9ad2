"""[response.torsion] and [damper_design] in a case: what is asked of a shaft line."""

from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import ConfigDict, Field

from vibecalc.core.case.fields import (
    Angle,
    AngularDamping,
    AngularSpeed,
    AngularStiffness,
    Inertia,
    Name,
    Number,
    Table,
    Unit,
    key,
    later,
)
from vibecalc.core.case.raw import table_at
from vibecalc.core.case.rules import (
    Row,
    at_most_one,
    by_kind,
    needs,
    ordered,
    pair_ordered,
    refuse,
    unique,
    wants,
)
from vibecalc.parts.tables import cylinders_in

if TYPE_CHECKING:
    from vibecalc.torsion.question_tables import (
        Conditions,
        Irregularity,
        LineCurve,
        TorsionLimit,
        Transient,
    )
else:
    _named = "Conditions Irregularity LineCurve TorsionLimit Transient"
    globals().update(later({"vibecalc.torsion.question_tables": _named}))

# ----------------------------------------------------------------------------
# What is asked of the torsion of a shaft line.
# ----------------------------------------------------------------------------

TorsionNames = Annotated[tuple[Name, ...], Field(max_length=64)]
ModeNumber = Annotated[int, Field(strict=True, ge=1, le=2000)]
DampingRatio = Annotated[float, Field(ge=0, lt=1), Unit("")]


class LineSpeeds(Table):
    """Range of crank speeds."""

    model_config = ConfigDict(validate_by_alias=True, validate_by_name=False)

    start: AngularSpeed = key("lowest", alias="from", gt=0)
    stop: AngularSpeed = key("highest", alias="to", gt=0)
    points: int = key(
        "number of points, ends included; maxima between them are found",
        801,
        strict=True,
        ge=2,
        le=1_000_000,
    )
    spacing: Literal["linear", "logarithmic"] = key("spacing of the points", "linear")
    RULES = (ordered("from", "to", "speeds must go from a lower to a higher one"),)


class LineOrders(Table):
    """Orders of the excitation: step, 2 step, 3 step and so on."""

    step: Number | None = key(
        "0.5 or 1; default: 0.5 of a four-stroke, 1 of a two-stroke engine", None, gt=0, le=1
    )
    count: Annotated[int, Field(strict=True, ge=1, le=800)] | None = key("number of orders", None)
    highest: Number | None = key("highest order, instead of count", None, gt=0, le=400)
    RULES = (
        at_most_one("count", "highest"),
        refuse(
            "step",
            "an engine excites half and whole orders only",
            lambda t: (t.number("step") or 0.0) > 0.0 and t.number("step") not in (0.5, 1.0),
            "0.5 or 1",
            found="step = {step}",
        ),
    )


def _through(row: Row) -> bool:
    """Whether the modes of Rayleigh damping are two, with a ratio for each or one for both."""
    two = len({*map(str, row.entries("modes"))}) == len(row.entries("modes")) == 2
    return two and ("ratios" not in row or len(row.entries("ratios")) in (1, 2))


class ProportionalDamping(Table):
    """Damping by mode, instead of that of shafts, stations and dampers."""

    kind: Literal["rayleigh", "modal"] = key(
        "J and K proportional (rayleigh), or a ratio for every mode"
    )
    modes: tuple[ModeNumber, ...] = key(
        "the two modes of the ratios, for rayleigh; the rigid mode is 1", (), max_length=2
    )
    ratios: tuple[DampingRatio, ...] = key(
        "of the two modes, or of all; a single number is for all",
        min_length=1,
        max_length=2000,
    )
    RULES = (
        refuse(
            "",
            "Rayleigh damping is defined by the ratios of two modes",
            lambda t: t["kind"] == "rayleigh" and not _through(t),
            "modes = [2, 3] and ratios = [0.01, 0.01], for example",
        ),
        refuse(
            "modes",
            "mode 1 is the rigid one, and has no damping ratio",
            lambda t: t["kind"] == "rayleigh" and _through(t) and 1 in t.entries("modes"),
            "two elastic modes, from 2",
        ),
        by_kind("damping model", rayleigh="| modes", modal=""),
    )


class AsPublished(Table):
    """The source's modal method: one mode at a time, with its dynamic magnifier."""

    damping_ratio: DampingRatio = key("of every mode", 0.01)
    magnifier: Literal["undamped", "empirical", "damped"] = key(
        "of each order; empirical: 3.8 over the fourth root, on a critical", "damped"
    )
    modes: ModeNumber = key("number of elastic modes, from the lowest", 3)


class VariableInertia(Table):
    """The variable inertia of the crank train over a revolution."""

    orders: Annotated[int, Field(strict=True, ge=1, le=400)] | None = key(
        "highest harmonic of the motion; default: from the tolerance", None
    )


class Torsion(Table):
    """Natural frequencies, modes and forced vibration of the shaft line."""

    speeds: LineSpeeds | None = key(
        "also over a range of speeds, not at the operating speed only", None
    )
    orders: LineOrders | None = key("default: up to order 12", None)
    method: Literal["elimination", "modal", "dense"] = key(
        "along the line, by modes, or one full solve for each order", "elimination"
    )
    misfire: TorsionNames = key("names of cylinders that do not fire", ())
    misfire_kind: Literal["no_gas", "motored"] = key(
        "their gas: none, or compressed and expanded without combustion", "no_gas"
    )
    damping_model: ProportionalDamping | None = key(
        "default: what shafts, stations and dampers have", None
    )
    campbell: bool = key("natural frequencies against speed", False, strict=True)
    limits: tuple[TorsionLimit, ...] = key(
        "of stress or torque, with the barred ranges that follow", (), max_length=64
    )
    separation: Literal["api_618", "api_684", "api_671"] | None = key(
        "hold the margins of modes to orders against this rule; informative", None
    )
    as_published: AsPublished | None = key("also by the route of the source", None)
    variable_inertia: VariableInertia | None = key(
        "also with the inertia that changes over the revolution", None
    )
    transient: Transient | None = key("also a change in time", None)
    curves: tuple[LineCurve, ...] = key(
        "orders against speed of named shafts and stations", (), max_length=64
    )
    irregularity: tuple[Irregularity, ...] = key(
        "how evenly named stations turn", (), max_length=64
    )
    conditions: Conditions | None = key(
        "also the worst of cylinders that misfire or are out of balance", None
    )
    RULES = (
        wants("machine.shaft_line", "stations and shafts of the line", of="engine"),
        needs("curves", "speeds", "curves go over a range of speeds"),
        unique("curves", "curves", name="on"),
        unique("irregularity", "stations of the irregularity", name="on"),
        refuse(
            "misfire_kind",
            "misfire_kind says how cylinders misfire, and none does",
            lambda t: (
                t["misfire_kind"] == "motored"
                and not t["misfire"]
                and table_at(t.data, "transient").get("kind") != "misfire_onset"
            ),
            "misfire = ['1'], for example, with it",
        ),
        *cylinders_in("misfire"),
    )


# ----------------------------------------------------------------------------
# The search for the damper of a shaft line.
# ----------------------------------------------------------------------------

Power = Annotated[float, Field(gt=0), Unit("W")]


class DamperValues(Table):
    """A damper from a table, to be compared with the one that is found."""

    stiffness: AngularStiffness = key("of its springs; 0: none", 0.0, ge=0)
    damping: AngularDamping = key("viscous", ge=0)


class DamperLimits(Table):
    """What the damper has to keep at every speed."""

    heat: Power | None = key("in its dashpot, mean over the cycle", None)
    travel: Angle | None = key("of the ring against its station, peak over the cycle", None, gt=0)


SomeStiffness = Annotated[float, Field(ge=0), Unit("N*m/rad")]
SomeDamping = Annotated[float, Field(ge=0), Unit("N*m*s/rad")]
SomeInertia = Annotated[float, Field(ge=0), Unit("kg*m^2")]


class DamperBounds(Table):
    """From and to, of each number that is looked for."""

    stiffness: tuple[SomeStiffness, SomeStiffness] | None = key(
        "of the springs; from 0 to 0 is a ring in oil", None
    )
    damping: tuple[SomeDamping, SomeDamping] | None = key("viscous", None)
    inertia: tuple[SomeInertia, SomeInertia] | None = key(
        "of the ring; needed where it is looked for", None
    )
    RULES = (pair_ordered("stiffness"), pair_ordered("damping"), pair_ordered("inertia"))


class DamperDesign(Table):
    """Spring and damper of a ring on the line that make its worst section best."""

    on: Name = key("name of a station, or of a damper that is replaced")
    find: tuple[Literal["stiffness", "damping", "inertia"], ...] = key(
        "numbers to look for", ("stiffness", "damping"), min_length=1, max_length=3
    )
    inertia: Inertia | None = key(
        "of the ring; default: that of the damper that is replaced", None, gt=0
    )
    stiffness: AngularStiffness | None = key(
        "where it is not looked for; default: of the replaced damper", None, ge=0
    )
    damping: AngularDamping | None = key(
        "where it is not looked for; default: of the replaced damper", None, ge=0
    )
    objective: Literal["torque", "twist", "stress"] = key(
        "half range over the cycle in the worst section at the worst speed", "torque"
    )
    sections: tuple[Name, ...] = key("names of shafts that count; default: all", (), max_length=64)
    speeds: LineSpeeds | None = key("that count; default: those of [response.torsion]", None)
    limits: DamperLimits | None = key("that the damper has to keep", None)
    bounds: DamperBounds | None = key("of what is looked for", None)
    compare: DamperValues | None = key("a table value to compare with", None)
    rings: tuple[Inertia, ...] = key(
        "inertias of other rings, whose best dampers are reported as well", (), max_length=32
    )
    tolerance: Number = key("error of spring and damper whose cost is reported", 0.1, gt=0, lt=1)
    RULES = (
        wants("machine.shaft_line", "stations and shafts of the line", of="engine"),
        refuse(
            "",
            "the speed range of [damper_design] is missing",
            lambda t: "speeds" not in {*t.data, *table_at(t.case, "response", "torsion")},
            "speeds = { from = '300 rpm', to = '900 rpm' } here or in [response.torsion]",
        ),
    )
