"""What is asked of a shaft line beyond its steady response: curves, conditions, limits, changes."""

from collections.abc import Iterable, Iterator
from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from vibecalc.core.case.fields import (
    Angle,
    AngularSpeed,
    Frequency,
    Length,
    Moment,
    Name,
    Number,
    Stress,
    Table,
    Time,
    Unit,
    key,
)
from vibecalc.core.case.rules import (
    Row,
    Rule,
    ascending,
    at_most_one,
    by_kind,
    needs,
    no,
    once,
    one_of,
    ordered,
    refers,
    refuse,
    same_length,
)
from vibecalc.errors import Problem
from vibecalc.torsion.shaft_line_tables import CrankDimensions, Layout, ShaftLine, stressed
from vibecalc.torsion.study_results import PASSAGES

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
    """Orders and their sum over the speed range, of one shaft or station."""

    on: Name = key("name of a shaft, elastic gear, damper or station")
    of: tuple[
        Literal["torque", "stress", "twist", "angle", "angular_speed", "angular_acceleration"],
        ...,
    ] = key(
        "default: torque, and stress where it is known; of a station the angle",
        (),
        alias="quantities",
        max_length=6,
    )
    orders: tuple[LineOrder, ...] = key("orders to show; default: by share", (), max_length=400)
    share: Number = key("orders are shown from this share of the largest on", 0.05, gt=0, le=1)
    measured: MeasuredPoints | None = key("measured points, drawn with the curves", None)
    RULES = (
        at_most_one("orders", "share"),
        once("quantities", "quantity"),
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
    """Cyclic irregularity of one station."""

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
        found += [f"misfire of cylinder {name}" for name in names]
    if options.imbalance is not None:
        found += [f"imbalance of cylinder {name}" for name in names]
    return (*found, GIVEN) if options.pressure_scale else tuple(found)


class Conditions(Table):
    """Firing conditions: all fire, each misfires, pressures differ; the worst counts."""

    misfire: Literal["each", "none"] = key("each cylinder in turn misfires, or none", "each")
    misfire_kind: Literal["no_gas", "motored"] = key(
        "without gas, or compression and expansion without combustion", "no_gas"
    )
    imbalance: Number | None = key(
        "reduction of the gas pressure of each cylinder in turn, as a share; negative: increase",
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


# ----------------------------------------------------------------------------
# Limits against the speed, as tables.
# ----------------------------------------------------------------------------

_Speeds = Annotated[tuple[AngularSpeed, ...], Field(min_length=2, max_length=2000)]
_Stresses = Annotated[tuple[Stress, ...], Field(min_length=2, max_length=2000)]
_Torques = Annotated[tuple[Moment, ...], Field(min_length=2, max_length=2000)]
_PASSING = "amplitude that is allowed for passing through, one per speed; default: none is said"


def _no_less(transient: str, continuous: str) -> Rule:
    """Each number of one list is at least that of the other."""

    def rule(row: Row) -> Iterator[Problem]:
        pairs = zip(row.listed(continuous), row.listed(transient), strict=False)
        for place, (lasting, passing) in enumerate(pairs):
            if lasting is not None and passing is not None and passing < lasting:
                yield row.problem(
                    (*row.path, transient, place),
                    "less is allowed for passage than for continuous operation",
                    found=f"{passing:.6g}{row.unit(transient)} in row {place + 1}",
                    allowed=f">= {lasting:.6g}{row.unit(continuous)}, that of {continuous}",
                    also=(*row.path, continuous, place),
                )
                return

    return rule


class StressCurve(Table):
    """Allowable stress over speed, straight lines between the entries."""

    speed: _Speeds = key("ascending, of the crankshaft")
    stress: _Stresses = key("allowable amplitude, one per speed")
    transient: tuple[Stress, ...] | None = key(_PASSING, None, max_length=2000)
    RULES = (
        same_length("speed", "stress", "transient"),
        ascending("speed"),
        _no_less("transient", "stress"),
    )


class TorqueCurve(Table):
    """Allowable vibratory torque over speed, straight lines between the entries."""

    speed: _Speeds = key("ascending, of the crankshaft")
    torque: _Torques = key("allowable amplitude, one per speed, on its own shaft")
    transient: tuple[Moment, ...] | None = key(_PASSING, None, max_length=2000)
    RULES = (
        same_length("speed", "torque", "transient"),
        ascending("speed"),
        _no_less("transient", "torque"),
        refuse(
            "torque",
            "a limit of nothing leaves no use of it to be told",
            lambda t: any(one is not None and one <= 0.0 for one in t.listed("torque")),
            "amplitudes > 0",
        ),
    )


# ----------------------------------------------------------------------------
# What the rule for crankshafts counts with.
# ----------------------------------------------------------------------------


class Crank(CrankDimensions):
    """A throw for the class rule for crankshafts, solid forged or cast."""

    pin_fillet: Length = key("radius between pin and web", gt=0)
    journal_fillet: Length = key("radius between journal and web", gt=0)


class CrankBending(Table):
    """Nominal alternating stresses of a throw that are not of torsion."""

    web: Stress = key("sigma_BFN: bending, of the web's cross-section", ge=0)
    compressive: Stress = key("sigma_QFN: by the radial force, of the web's cross-section", ge=0)
    oil_bore: Stress | None = key(
        "sigma_BON: bending at the oil bore, of the pin's cross-section", None, ge=0
    )
    additional: Stress = key(
        "sigma_add: 10 N/mm^2 of trunk piston, 30 of crosshead engines", 10e6, ge=0
    )


# ----------------------------------------------------------------------------
# A limit.
# ----------------------------------------------------------------------------

#: what stands for c_K of IACS UR M68
ShaftKind = Literal[
    "flange",
    "shrink_fit",
    "keyway_taper",
    "keyway_cylinder",
    "radial_hole",
    "longitudinal_slot",
    "thrust_collar",
    "thrust_roller_bearing",
    "propeller_flange",
    "propeller_keyless",
    "propeller_keyed",
    "propeller_forward",
]
_CURVES = ("curve", "torque", "alternating_share")
_OF_RULES = (
    *("tensile_strength", "design_factor", "shaft_kind"),
    *("crank", "crankshaft_kind", "bending"),
)


_Names = Annotated[tuple[Name, ...], Field(max_length=64)]


class TorsionLimit(Table):
    """A limit on stress or torque: a class rule, a curve, or a share of the mean torque."""

    rule: Literal["iacs_m68", "iacs_m53"] | None = key(
        "class rule for propulsion shafts (m68) or crankshafts (m53); informative", None
    )
    curve: StressCurve | None = key("instead of a rule: stress over speed, a table or a CSV", None)
    torque: TorqueCurve | None = key(
        "instead: torque over speed of sections or gears, a table or a CSV", None
    )
    alternating_share: Number | None = key(
        "instead, of gears: alternating torque over the mean at the operating speed; in a "
        "condition of the cylinders over the mean that it leaves",
        None,
        gt=0,
        le=10,
    )
    sections: _Names = key("names of shafts; default: all with the necessary data", ())
    gears: _Names = key("names of gears; default of alternating_share: all", ())
    tensile_strength: Stress | None = key(
        "of the material, for the rule, if the shaft has none", None, gt=0
    )
    design_factor: Number = key("c_K of m68: 1 for a plain intermediate shaft", 1.0, gt=0, le=1)
    shaft_kind: ShaftKind | None = key(
        "instead of design_factor: kind of shaft, for c_K of m68", None
    )
    crank: Crank | None = key("throw for m53, where the shafts have no `throw` with fillets", None)
    crankshaft_kind: Literal["continuous_grain_flow", "free_form", "cast_cold_rolled"] | None = key(
        "manufacture of the crankshaft, for K of m53; default: free_form", None
    )
    bending: CrankBending | None = key("for m53: stresses not of torsion", None)
    RULES = (
        one_of("rule", *_CURVES),
        *(at_most_one(one, other) for one in _CURVES for other in _OF_RULES),
        at_most_one("design_factor", "shaft_kind"),
        at_most_one("alternating_share", "sections"),
        *(at_most_one(one, "gears") for one in ("rule", "curve")),
        needs("torque", "sections gears", "a limit of the torque is for some of them"),
        needs(
            "rule",
            "bending",
            "the rule for crankshafts judges bending and torsion together",
            "bending = { web = '30 MPa', compressive = '3 MPa' } with it",
            when=lambda t: t["rule"] == "iacs_m53",
        ),
        no(
            "design_factor shaft_kind",
            lambda t: t["rule"] == "iacs_m53",
            "{key} is of the rule for propulsion shafts, and this one is for crankshafts",
            "rule = 'iacs_m68', or no {key}",
        ),
        no(
            "crank crankshaft_kind bending",
            lambda t: t["rule"] == "iacs_m68",
            "{key} is of the rule for crankshafts, and this one is for propulsion shafts",
            "rule = 'iacs_m53', or no {key}",
        ),
    )


AngularAcceleration = Annotated[float, Field(gt=0), Unit("rad/s^2")]

#: changes of which the crank keeps its speed
AT_CONSTANT_SPEED = ("load_step", "misfire_onset", "short_circuit", "torque_history")

# ----------------------------------------------------------------------------
# What a section bears, and how its cycles are counted.
# ----------------------------------------------------------------------------


class CycleCounting(Table):
    """Rainflow count (ASTM E1049) of the section torques during the transient."""

    sections: tuple[Name, ...] = key(
        "names of shafts; default: all sections of the line", (), max_length=64
    )
    bins: int = key(
        "number of equal bins up to the largest range of each section",
        16,
        strict=True,
        ge=2,
        le=256,
    )
    ignore: Number = key(
        "cycles below this share of the largest range are ignored", 0.01, ge=0, lt=1
    )
    slope: Number = key(
        "of a section without an S-N line, for the equivalent torque", 5.0, ge=1, le=50
    )
    changes: Number = key("number of such transients in service life", 1.0, gt=0, le=1e9)


# ----------------------------------------------------------------------------
# Torques in time.
# ----------------------------------------------------------------------------


class DecayingTorque(Table):
    """amplitude exp(-t / time_constant) sin(2 pi frequency t + phase) from the change on."""

    amplitude: Moment = key("at the start, on its own shaft; positive brakes")
    frequency: Frequency = key("of the grid or twice that; 0: decay alone", 0.0, ge=0)
    time_constant: Time = key("time to fall to 1 / e", gt=0)
    phase: Angle = key("of the sine; 90 deg for one of frequency 0", 0.0)


Times = Annotated[tuple[Time, ...], Field(min_length=2, max_length=2000)]
TorquesInTime = Annotated[tuple[Moment, ...], Field(min_length=2, max_length=2000)]


class TorqueTable(Table):
    """A torque over time, straight lines between the entries."""

    time: Times = key("from the start of the transient, ascending")
    torque: TorquesInTime = key("on its own shaft, one per time; positive brakes more than before")
    RULES = (same_length("time", "torque"), ascending("time", 0.0))


_PASS = "from to | acceleration duration"


class Transient(Table):
    """A transient: passage of criticals, load step, misfire, short circuit, clutch."""

    model_config = ConfigDict(validate_by_alias=True, validate_by_name=False)

    kind: Literal[
        "run_up", "run_down", "start", "stop", "load_step", "misfire_onset", "short_circuit",
        "torque_history", "clutch_in",
    ] = key("kind of transient")  # fmt: skip
    start: AngularSpeed | None = key(
        "initial speed of run_up, run_down and stop", None, alias="from", ge=0
    )
    stop: AngularSpeed | None = key(
        "final speed of run_up, run_down and start", None, alias="to", ge=0
    )
    acceleration: AngularAcceleration | None = key("maximum; it rises and falls smoothly", None)
    duration: Time | None = key("instead of acceleration", None, gt=0)
    on: Name | None = key("station of the torque", None)
    torque: Moment | None = key(
        "of a load step, on its own shaft; positive brakes more than before", None
    )
    cylinder: Name | None = key("name of the cylinder that stops firing", None)
    terms: tuple[DecayingTorque, ...] = key(
        "air-gap torque of a short circuit as a sum of decaying sines",
        (),
        min_length=1,
        max_length=16,
    )
    history: TorqueTable | None = key("torque over time: a table or a CSV", None)
    clutch: Name | None = key("name of the shaft that represents the clutch", None)
    driven_speed: AngularSpeed | None = key(
        "initial speed of the driven side, on the clutch's own shaft", None, ge=0
    )
    friction_torque: Moment | None = key("slip torque of the clutch, on its own shaft", None, gt=0)
    engaging_time: Time | None = key("time of its linear rise from 0; default: at once", None, gt=0)
    time_before: Time = key("time in the initial state that is also computed", 0.0, ge=0)
    time_after: Time = key("time computed afterwards", 1.0, gt=0)
    counting: CycleCounting | None = key("also count cycles of torque and stress", None)
    RULES = (
        refers("on", "machine.shaft_line.stations", "station"),
        refers("cylinder", "machine.crank_train.cylinders", "cylinder"),
        by_kind(
            "transient",
            run_up=_PASS,
            run_down=_PASS,
            start="to | acceleration duration",
            stop="from | acceleration duration",
            load_step="on torque",
            misfire_onset="cylinder",
            short_circuit="on terms",
            torque_history="on history",
            clutch_in="clutch driven_speed friction_torque | engaging_time",
        ),
        one_of("acceleration", "duration", when=lambda t: t["kind"] in PASSAGES),
        ordered(
            "from",
            "to",
            "a run-up must go from a lower to a higher speed",
            when=lambda t: t["kind"] == "run_up",
        ),
        ordered(
            "to",
            "from",
            "a run-down goes from a higher speed to a lower one",
            when=lambda t: t["kind"] == "run_down",
        ),
    )
