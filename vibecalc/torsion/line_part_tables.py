"""Tables of a shaft line that few have: couplings, dampings over speed, given torques, fatigue."""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from vibecalc.core.case.fields import (
    Angle,
    AngularDamping,
    AngularSpeed,
    AngularStiffness,
    Frequency,
    Moment,
    Name,
    Number,
    Stress,
    Table,
    Unit,
    key,
)
from vibecalc.core.case.rules import (
    Row,
    ascending,
    at_most_one,
    needs,
    no,
    one_of,
    ordered,
    refuse,
    same_length,
)
from vibecalc.errors import Problem

# ----------------------------------------------------------------------------
# What stiffness and damping of a coupling depend on: rows over one quantity.
#
# A column is either the value itself or a factor on the value that the coupling has otherwise, as
# makers print both. Between the rows values are linear; beyond the first and the last they stay.
# ----------------------------------------------------------------------------

Temperature = Annotated[float, Field(gt=0), Unit("K")]
Rise = Annotated[
    float,
    Field(gt=0, le=1000),
    Unit("K", "a rise of temperature", "'40 K'", difference=True),
]
Power = Annotated[float, Field(gt=0), Unit("W")]
ThermalResistance = Annotated[float, Field(gt=0), Unit("K/W")]
#: 4 pi: a coupling that loses more than it stores twice over is none
Psi = Annotated[float, Field(gt=0, le=60), Unit("")]
Factor = Annotated[float, Field(gt=0, le=100), Unit("")]
_Rows = Field(min_length=2, max_length=200)
Torques = Annotated[tuple[Annotated[Moment, Field(ge=0)], ...], _Rows]
Frequencies = Annotated[tuple[Annotated[Frequency, Field(ge=0)], ...], _Rows]
Temperatures = Annotated[tuple[Temperature, ...], _Rows]
Powers = Annotated[tuple[Power, ...], _Rows]
Stiffnesses = Annotated[tuple[Annotated[float, Field(gt=0), Unit("N*m/rad")], ...], _Rows]
Dampings = Annotated[tuple[Psi, ...], _Rows]
Factors = Annotated[tuple[Factor, ...], _Rows]
_VALUES = ("stiffness", "stiffness_factor", "relative_damping", "relative_damping_factor")


def _of_rows(axis: str, *others: str) -> tuple[object, ...]:
    """Rules of rows over `axis`, that may have `others` for a column."""
    return (
        ascending(axis),
        same_length(axis, *_VALUES, *others),
        at_most_one("stiffness", "stiffness_factor"),
        at_most_one("relative_damping", "relative_damping_factor"),
        needs("", " ".join((*_VALUES, *others))),
    )


class Dependence(Table):
    """Columns of values at the rows of some quantity."""

    stiffness: Stiffnesses | None = key("dynamic torsional stiffness, one per row", None)
    stiffness_factor: Factors | None = key("factor on the stiffness, instead", None)
    relative_damping: Dampings | None = key("psi, one per row", None)
    relative_damping_factor: Factors | None = key("factor on psi, instead", None)


class OverMeanTorque(Dependence):
    """Stiffness and damping of a coupling over its mean torque."""

    torque: Torques = key("mean torque, ascending, on its own shaft")
    RULES = _of_rows("torque")


class OverAmplitude(Dependence):
    """Stiffness and damping of a coupling over its vibratory torque."""

    torque: Torques = key("half range of all orders, ascending")
    RULES = _of_rows("torque")


class OverFrequency(Dependence):
    """Stiffness and damping of a coupling over the vibration frequency."""

    frequency: Frequencies = key("ascending, e.g. '10 Hz'")
    RULES = _of_rows("frequency")


class OverTemperature(Dependence):
    """Stiffness and damping of a coupling over the temperature of its element."""

    temperature: Temperatures = key("ascending, e.g. '60 degC'")
    service_factor: Factors | None = key(
        "S_theta of DIN 740-2, factor on the torques: 1 where it is cold", None
    )
    RULES = _of_rows("temperature", "service_factor")


class PowerOverTemperature(Table):
    """Permissible power loss of a coupling over the ambient temperature."""

    temperature: Temperatures = key("ambient, ascending")
    power_loss: Powers = key("permissible, one per row")
    RULES = (ascending("temperature"), same_length("temperature", "power_loss"))


# ----------------------------------------------------------------------------
# The coupling: stiffness, damping, what they depend on, its heat and what it may bear.
# ----------------------------------------------------------------------------

#: rows that stiffness and damping may follow, and what over
FOLLOWS = {
    "over_mean_torque": "the mean torque",
    "over_temperature": "its own temperature",
    "over_frequency": "the frequency",
    "over_amplitude": "its vibratory torque",
}


def _said_once(key: str, words: str, wanted: bool) -> object:
    """A value stands once: by itself, or as a column of one table of rows."""

    def rule(row: Row) -> Iterator[Problem]:
        if "catalogue" in row:  # not read, which is a problem of its own
            return
        places: list[tuple[str, ...]] = [(key,)] if key in row else []
        for name in FOLLOWS:
            below = row.below(name)
            if below is not None and key in below:
                places.append((name, key))
        if len(places) > 1:
            yield row.problem(
                ".".join(places[1]),
                f"the {words} of the coupling is given twice",
                allowed=f"{key} in one place, {key}_factor in the others",
                also=".".join(places[0]),
            )
        elif not places and wanted and row.lacks(key):
            yield row.problem(
                "",
                f"the coupling has no {words}",
                allowed=f"{key}, or a column of it in one of {', '.join(FOLLOWS)}",
            )

    return rule


def _covers(rows: str, key: str, words: str) -> object:
    """The temperature at `key` lies within those of the rows."""

    def rule(row: Row) -> Iterator[Problem]:
        below, asked = row.below(rows), row.number(key)
        known = (rows, key) == ("over_temperature", "ambient_temperature") and "temperature" in row
        if below is None or asked is None or known:
            return
        every = [one for one in below.listed("temperature") if one is not None]
        if len(every) > 1 and not every[0] - 1e-9 <= asked <= every[-1] + 1e-9:
            yield row.problem(
                key,
                f"the coupling has no row of {rows} for {words}",
                found=f"{asked - 273.15:.6g} degC",
                allowed=f"{every[0] - 273.15:.6g} to {every[-1] - 273.15:.6g} degC",
                hint="a row of the maker's table that reaches so far",
                also=f"{rows}.temperature",
            )

    return rule


class Coupling(Table):
    """An elastic coupling by catalogue values; torques on its own shaft."""

    catalogue: Name | None = key(
        "TOML file of couplings next to the case; its keys may be replaced here", None
    )
    type: Name | None = key("name of the coupling in its catalogue", None)
    source: Name | None = key("origin of the values", None)
    stiffness: AngularStiffness | None = key("C_Tdyn, dynamic torsional stiffness", None, gt=0)
    relative_damping: Psi | None = key(
        "psi, energy loss per cycle over elastic energy: 2 pi times the loss factor", None
    )
    over_mean_torque: OverMeanTorque | None = key(
        "rows over the mean torque: a table or a CSV", None
    )
    over_temperature: OverTemperature | None = key(
        "rows over the temperature of the element: a table or a CSV", None
    )
    over_frequency: OverFrequency | None = key("rows over the frequency: a table or a CSV", None)
    over_amplitude: OverAmplitude | None = key(
        "rows over the vibratory torque: a table or a CSV", None
    )
    temperature: Temperature | None = key("of the element, if known", None)
    ambient_temperature: Temperature | None = key("of the surrounding air", None)
    thermal_resistance: ThermalResistance | None = key("temperature rise per power loss", None)
    temperature_rise: Rise | None = key(
        "instead: temperature rise at the permissible power loss", None
    )
    nominal_torque: Moment | None = key("T_KN, mean torque", None, gt=0)
    maximum_torque: Moment | None = key("T_Kmax, peak torque", None, gt=0)
    vibratory_torque: Moment | None = key(
        "T_KW, continuous vibratory torque, half range", None, gt=0
    )
    vibratory_frequency: Frequency = key(
        "reference frequency of T_KW; above it T_KW falls with the root of the ratio; "
        "default: 10 Hz",
        62.83185307179586,
        gt=0,
    )
    power_loss: Power | None = key("P_KV, permissible power loss", None)
    power_loss_over_temperature: PowerOverTemperature | None = key(
        "instead: over the ambient temperature, a table or a CSV", None
    )
    maximum_speed: AngularSpeed | None = key("n_max, of its own shaft", None, gt=0)
    maximum_temperature: Temperature | None = key("of the element", None)
    RULES = (
        _said_once("stiffness", "stiffness", True),
        _said_once("relative_damping", "relative damping", True),
        at_most_one("temperature", "thermal_resistance", "temperature_rise"),
        at_most_one("power_loss", "power_loss_over_temperature"),
        needs(
            "over_temperature",
            "temperature thermal_resistance temperature_rise",
            "its rows want the temperature of the element",
        ),
        needs("thermal_resistance", "ambient_temperature", "the rise is above it"),
        needs("temperature_rise", "ambient_temperature", "the rise is above it"),
        needs(
            "temperature_rise", "power_loss power_loss_over_temperature", "the rise belongs to it"
        ),
        needs("power_loss_over_temperature", "ambient_temperature"),
        needs("maximum_temperature", "thermal_resistance temperature_rise", "nothing heats it"),
        needs("catalogue", "type", "which of its couplings"),
        _covers("over_temperature", "temperature", "its temperature"),
        _covers("over_temperature", "ambient_temperature", "its ambient temperature"),
        _covers("power_loss_over_temperature", "ambient_temperature", "its ambient temperature"),
        refuse(
            "maximum_torque",
            "the maximum torque of the coupling is below its nominal torque",
            lambda t: (
                (t.number("maximum_torque") or 0.0) < (t.number("nominal_torque") or 0.0)
                and "maximum_torque" in t
            ),
            "T_Kmax >= T_KN",
            found="T_Kmax = {maximum_torque}, T_KN = {nominal_torque}",
        ),
        ordered(
            "ambient_temperature",
            "maximum_temperature",
            "the air about the coupling is as hot as its element may be",
        ),
    )

    @property
    def follows(self) -> list[str]:
        """Keys of the rows that stiffness and damping follow; a given temperature is one number."""
        found = [key for key in FOLLOWS if getattr(self, key) is not None]
        return [key for key in found if key != "over_temperature" or self.temperature is None]


# ----------------------------------------------------------------------------
# What a section bears of the cycles that a change in time counts.
# ----------------------------------------------------------------------------


class FatigueLine(Table):
    """An S-N line: N = cycles (strength / amplitude)^slope down to its knee."""

    stress: Stress | None = key("amplitude of the shear stress at the knee", None, gt=0)
    torque: Moment | None = key(
        "amplitude of the torque at the knee instead, on its own shaft", None, gt=0
    )
    cycles: Number = key("at the knee", 1e6, ge=1e3, le=1e12)
    slope: Number = key("k of the line above the knee", 5.0, ge=1, le=50)
    below: Literal["elementary", "haibach", "original"] = key(
        "the knee: the same slope, 2 k - 1, or no damage at all", "elementary", alias="below_knee"
    )
    RULES = (one_of("stress", "torque"),)


# ----------------------------------------------------------------------------
# How a damping follows the speed: entries of a table, or a power.
# ----------------------------------------------------------------------------

Speeds = Annotated[
    tuple[Annotated[AngularSpeed, Field(gt=0)], ...], Field(min_length=2, max_length=2000)
]
SpeedFactors = Annotated[
    tuple[Annotated[Number, Field(gt=0)], ...], Field(min_length=2, max_length=2000)
]
MeanTorques = Annotated[tuple[Moment, ...], Field(min_length=2, max_length=2000)]


class FactorCurve(Table):
    """A factor against the speed, straight lines between the entries."""

    speed: Speeds = key("ascending")
    factor: SpeedFactors = key("on the given damping, one per speed")
    RULES = (same_length("speed", "factor"), ascending("speed"))


class OverSpeed(Table):
    """A factor on a damping over speed, as a table or as a power of the speed."""

    of: Literal["crank", "own"] = key(
        "whose speed: of the crankshaft, or that of its own shaft", "crank"
    )
    table: FactorCurve | None = key("a table or a CSV", None)
    exponent: Number | None = key(
        "instead: factor (speed / reference) ^ exponent", None, ge=-4, le=4
    )
    reference: AngularSpeed | None = key("speed of the given damping, with exponent", None, gt=0)
    RULES = (
        one_of("table", "exponent reference"),
        needs("exponent", "reference", "at this speed the damping is as given"),
        needs("reference", "exponent", "the power of the speed"),
    )


class LoadCurve(Table):
    """A torque against the speed, straight lines between the entries."""

    speed: Speeds = key("ascending, of the crankshaft")
    torque: MeanTorques = key("mean, on its own shaft; positive brakes; one per speed")
    RULES = (same_length("speed", "torque"), ascending("speed"))


# ----------------------------------------------------------------------------
# Damping of a propeller from its torque, and of the cylinders of an engine.
# ----------------------------------------------------------------------------


class PropellerDamping(Table):
    """Absolute damping from the mean torque T that the load takes at each speed."""

    method: Literal["archer", "slope", "factor"] = key(
        "a T / n with n in rpm; dT/dw of the law of the load; or x T / w"
    )
    coefficient: Number | None = key("a of archer, default 30; or x of factor", None, gt=0, le=1000)
    RULES = (
        refuse(
            "coefficient",
            "the slope of the law of a load has no coefficient",
            lambda t: t["method"] == "slope" and "coefficient" in t,
            "none, or method = 'factor'",
        ),
        refuse(
            "",
            "method 'factor' needs a coefficient: x in x T / w",
            lambda t: t["method"] == "factor" and "coefficient" not in t,
            "coefficient = 4, for example",
        ),
    )


class EngineDamping(Table):
    """Absolute damping at every station with a cylinder."""

    magnifier: Number | None = key(
        "dynamic magnifier M of its inertia J: J w / M", None, ge=1, le=1e6
    )
    damping_ratio: Number | None = key(
        "Lehr's damping ratio D of its inertia: 2 D J w", None, ge=0, lt=1
    )
    loss_factor: Number | None = key("of its inertia: loss_factor J w", None, ge=0, le=2)
    damping: AngularDamping | None = key("viscous, of each station; instead", None, ge=0)
    mode: Annotated[int, Field(strict=True, ge=2, le=2000)] | None = key(
        "elastic mode whose undamped frequency is w, counted with the rigid one as 1; "
        "default: lowest elastic",
        None,
    )
    over_speed: OverSpeed | None = key("factor on it against the speed", None)
    RULES = (
        one_of("magnifier", "damping_ratio", "loss_factor", "damping"),
        at_most_one("damping", "mode"),
    )


Order = Annotated[float, Field(gt=0, le=100_000)]
Share = Annotated[float, Field(ge=0, le=10)]
Amplitude = Annotated[Moment, Field(ge=0)]
Blades = Annotated[int, Field(strict=True, ge=1, le=10_000)]
#: harmonics of one torque
MOST = 400
#: of a turn: a record ends where it began
_CLOSED = 1e-6
_TURN = 6.283185307179586


class FactorOverSpeed(Table):
    """Factor on a given torque at other speeds, straight lines between the entries."""

    speed: tuple[AngularSpeed, ...] = key(
        "ascending, of the crankshaft", min_length=2, max_length=2000
    )
    factor: tuple[Number, ...] = key("one per speed", min_length=2, max_length=2000)
    RULES = (same_length("speed", "factor"), ascending("speed"))


def _span(row: Row) -> Iterator[Problem]:
    angle = [one for one in row.listed("angle") if isinstance(one, float)]
    if len(angle) < 4 or len(angle) != len(row.entries("angle")):
        return
    turns = (angle[-1] - angle[0]) / _TURN
    if min(abs(turns - 1.0), abs(turns - 2.0)) > _CLOSED:
        yield row.problem(
            "angle",
            "a record of a torque goes over one turn of its shaft, or over two",
            found=f"{angle[-1] - angle[0]:.6g} rad, {turns:.6g} turns",
            allowed="angles from 0 to 360 deg, or to 720 deg",
        )
        return
    torque = [one for one in row.listed("torque") if isinstance(one, float)]
    if len(torque) != len(angle):
        return
    size = max(map(abs, torque))
    if abs(torque[-1] - torque[0]) > 1e-6 * size:
        yield row.problem(
            "torque",
            "a record of a torque ends with the value that it begins with",
            found=f"{torque[0]:.6g} N*m, and {torque[-1]:.6g} N*m in the last row",
            allowed="a last row that repeats the first",
        )


class TorqueOverAngle(Table):
    """A measured or computed torque over one or two turns of its shaft."""

    angle: tuple[Angle, ...] = key(
        "ascending, of the shaft, one turn or two", min_length=4, max_length=100_000
    )
    torque: tuple[Moment, ...] = key(
        "one per angle; the last equals the first", min_length=4, max_length=100_000
    )

    RULES = (same_length("angle", "torque"), ascending("angle"), _span)


def _amplitudes(row: Row) -> str:
    return "torques" if row.said("torques") else "shares"


def _harmonics(row: Row) -> Iterator[Problem]:
    """As many amplitudes as orders or frequencies, and as many phases."""
    key = _amplitudes(row)
    said = row.said(key, "orders", "frequencies", "phases")
    counts = {name: len(row.entries(name)) for name in said}
    if len(set(counts.values())) > 1:
        yield row.problem(
            key if row.said(key) else "",
            "each harmonic of a torque has one amplitude",
            found=", ".join(f"{count} of {name}" for name, count in counts.items()),
            allowed="the same number of entries in each",
        )


_BY_ORDER = ("orders", "blades", "teeth", "frequencies", "record")


class StationExcitation(Table):
    """A torque on a station: A cos(order x angle turned + phase), positive as the station turns."""

    name: Name | None = key("label; default: that of the station", None)
    on: Name = key("name of a station")
    orders: tuple[Order, ...] = key(
        "periods in a turn of its own shaft, or of the crankshaft, see `orders_of`",
        (),
        max_length=MOST,
    )
    blades: Blades | None = key(
        "instead: of a propeller or wheel; the orders are its multiples", None
    )
    teeth: Blades | None = key("instead: of a gear or sprocket; the orders are its multiples", None)
    frequencies: tuple[Annotated[Frequency, Field(gt=0)], ...] = key(
        "instead: that do not follow the speed, '50 Hz'", (), max_length=MOST
    )
    record: TorqueOverAngle | None = key(
        "instead: over its own angle, a table or a CSV; its mean does not count", None
    )
    harmonics: int = key("of a record: number of orders", 24, strict=True, ge=1, le=MOST)
    of: Literal["shaft", "crankshaft"] = key(
        "whose turns the orders count: its own shaft's or the crankshaft's",
        "shaft",
        alias="orders_of",
    )
    torques: tuple[Amplitude, ...] = key(
        "amplitudes, 0-to-peak, on its own shaft, at the operating speed", (), max_length=MOST
    )
    shares: tuple[Share, ...] = key(
        "instead: of the mean torque absorbed at the station, at every speed", (), max_length=MOST
    )
    phases: tuple[Angle, ...] = key("at crank angle zero; default: 0", (), max_length=MOST)
    exponent: Number = key("of the speed, for torques: 2 as a fan", 0.0, ge=0, le=4)
    over_speed: FactorOverSpeed | None = key("instead of exponent: a table or a CSV", None)
    RULES = (
        one_of(
            *_BY_ORDER,
            hint="blades = 4 with shares = [0.06, 0.01] for a propeller, for example",
        ),
        one_of("torques", "shares", when=lambda t: not t.said("record")),
        at_most_one("record", "torques"),
        at_most_one("record", "shares"),
        at_most_one("record", "phases"),
        at_most_one("exponent", "over_speed"),
        no(
            "exponent over_speed",
            lambda t: t.said("shares"),
            "{key} is of torques; shares follow the mean torque",
            "torques, or no {key}",
        ),
        no(
            "harmonics",
            lambda t: not t.said("record"),
            "harmonics are those of a record",
            "a record",
        ),
        no(
            "orders_of",
            lambda t: not t.said("orders", "record"),
            "`orders_of` says whose turns the orders count, and there are none",
            "orders with it",
        ),
        refuse(
            "orders",
            "an order is given twice",
            lambda t: len({*map(str, t.entries("orders"))}) < len(t.entries("orders")),
            "each order once",
        ),
        _harmonics,
    )
