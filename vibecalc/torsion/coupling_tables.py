"""An elastic coupling of a shaft line as its maker's table describes it."""

from collections.abc import Iterator
from typing import Annotated

from pydantic import Field

from vibecalc.core.case.fields import (
    AngularSpeed,
    AngularStiffness,
    Frequency,
    Moment,
    Name,
    Table,
    Unit,
    key,
)
from vibecalc.core.case.rules import (
    Row,
    ascending,
    at_most_one,
    needs,
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
    stiffness_factor: Factors | None = key("on the stiffness, instead of it", None)
    relative_damping: Dampings | None = key("psi, one per row", None)
    relative_damping_factor: Factors | None = key("on psi, instead of it", None)


class OverMeanTorque(Dependence):
    """Stiffness and damping of a coupling against the mean torque that it carries."""

    torque: Torques = key("mean torque, ascending, on its own shaft")
    RULES = _of_rows("torque")


class OverAmplitude(Dependence):
    """Stiffness and damping of a coupling against its vibratory torque."""

    torque: Torques = key("half range of all orders, ascending")
    RULES = _of_rows("torque")


class OverFrequency(Dependence):
    """Stiffness and damping of a coupling against the frequency of its vibration."""

    frequency: Frequencies = key("ascending, e.g. '10 Hz'")
    RULES = _of_rows("frequency")


class OverTemperature(Dependence):
    """Stiffness and damping of a coupling against the temperature of its element."""

    temperature: Temperatures = key("ascending, e.g. '60 degC'")
    service_factor: Factors | None = key(
        "S_theta of DIN 740-2, by which torques count more: 1 where it is cold", None
    )
    RULES = _of_rows("temperature", "service_factor")


class PowerOverTemperature(Table):
    """Permissible power loss of a coupling against the temperature of the air about it."""

    temperature: Temperatures = key("of the air, ascending")
    power_loss: Powers = key("permissible there, one per row")
    RULES = (ascending("temperature"), same_length("temperature", "power_loss"))


# ----------------------------------------------------------------------------
# The coupling: stiffness, damping, what they depend on, its heat and what it may bear.
# ----------------------------------------------------------------------------

_DEPENDENCES = ("over_mean_torque", "over_temperature", "over_frequency", "over_amplitude")


def _said_once(key: str, words: str, wanted: bool) -> object:
    """A value stands once: by itself, or as a column of one table of rows."""

    def rule(row: Row) -> Iterator[Problem]:
        if "catalogue" in row:  # not read, which is a problem of its own
            return
        places: list[tuple[str, ...]] = [(key,)] if key in row else []
        for name in _DEPENDENCES:
            below = row.below(name)
            if below is not None and key in below:
                places.append((name, key))
        if len(places) > 1:
            yield row.problem(
                ".".join(places[1]),
                f"the {words} of the coupling stands twice",
                allowed=f"{key} in one place, {key}_factor in the others",
                also=".".join(places[0]),
            )
        elif not places and wanted and row.lacks(key):
            yield row.problem(
                "",
                f"the coupling has no {words}",
                allowed=f"{key}, or a column of it in one of {', '.join(_DEPENDENCES)}",
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
    """An elastic coupling by the values of its maker; torques on its own shaft."""

    catalogue: Name | None = key(
        "TOML file of couplings next to the case; its keys may be replaced here", None
    )
    type: Name | None = key("name of the coupling in its catalogue", None)
    source: Name | None = key("where the values are from", None)
    stiffness: AngularStiffness | None = key("C_Tdyn, dynamic torsional stiffness", None, gt=0)
    relative_damping: Psi | None = key(
        "psi, loss of a cycle over elastic energy: loss factor 2 pi times", None
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
    temperature: Temperature | None = key("of the element, where it is known", None)
    ambient_temperature: Temperature | None = key("of the air about it", None)
    thermal_resistance: ThermalResistance | None = key(
        "rise of the temperature per power loss", None
    )
    temperature_rise: Rise | None = key("instead: rise at the permissible power loss", None)
    nominal_torque: Moment | None = key("T_KN, mean torque", None, gt=0)
    maximum_torque: Moment | None = key("T_Kmax, peak torque", None, gt=0)
    vibratory_torque: Moment | None = key(
        "T_KW, continuous vibratory torque, half range", None, gt=0
    )
    vibratory_frequency: Frequency = key(
        "of T_KW; above it less is permissible by the root of the ratio; 10 Hz",
        62.83185307179586,
        gt=0,
    )
    power_loss: Power | None = key("P_KV, permissible power loss", None)
    power_loss_over_temperature: PowerOverTemperature | None = key(
        "instead: rows over the temperature of the air, a table or a CSV", None
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
