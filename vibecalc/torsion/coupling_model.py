"""The elastic couplings of a validated shaft line as arrays."""

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.numerics.rounding import FloatArray
from vibecalc.torsion.couplings import Coupling, Permissible, Rows

if TYPE_CHECKING:
    from vibecalc.torsion import line_part_tables as tables

# ----------------------------------------------------------------------------
# Nominal values of a coupling, and its rows as factors on them.
#
# What the case says by itself is nominal; of a value that stands in rows only, that of the first
# row is. Rows over a temperature that is given are read there, once and for all.
# ----------------------------------------------------------------------------

_AXES = {
    "over_mean_torque": "torque",
    "over_temperature": "temperature",
    "over_frequency": "frequency",
    "over_amplitude": "torque",
}


class Nominal(NamedTuple):
    """Stiffness in N m/rad and psi of a coupling, and its rows as factors on them by their key."""

    stiffness: float
    relative_damping: float
    rows: dict[str, Rows]


def nominal(given: "tables.Coupling") -> Nominal:
    """Of a coupling whose values stand once each, as the rules of its table hold."""
    value = {"stiffness": given.stiffness, "relative_damping": given.relative_damping}
    rows: dict[str, Rows] = {}
    for key, axis in _AXES.items():
        table = getattr(given, key)
        if table is None:
            continue
        at = np.array(getattr(table, axis), dtype=float)
        factors: list[FloatArray] = []
        for name in value:
            column, factor = getattr(table, name), getattr(table, f"{name}_factor")
            if column is not None:
                value[name] = column[0]
                factor = np.array(column) / column[0]
            factors.append(np.ones(len(at)) if factor is None else np.array(factor))
        rows[key] = Rows(at, *factors)
    stiffness, psi = value["stiffness"], value["relative_damping"]
    assert stiffness is not None and psi is not None  # each stands once, say the rules
    if given.temperature is not None and "over_temperature" in rows:
        warm = rows.pop("over_temperature").factors(np.asarray(given.temperature))
        stiffness, psi = stiffness * float(warm[0]), psi * float(warm[1])
    return Nominal(stiffness, psi, rows)


def permissible(given: "tables.Coupling") -> Permissible:
    """What the maker of a coupling permits, its power loss at the temperature of the air."""
    power, rows = given.power_loss, given.power_loss_over_temperature
    if rows is not None:
        assert given.ambient_temperature is not None  # its rows want one, says the form
        power = float(np.interp(given.ambient_temperature, rows.temperature, rows.power_loss))
    return Permissible(
        given.nominal_torque or math.inf,
        given.maximum_torque or math.inf,
        given.vibratory_torque or math.inf,
        given.vibratory_frequency,
        power or math.inf,
        given.maximum_speed or math.inf,
        given.maximum_temperature or math.inf,
    )


def coupling_of(given: "tables.Coupling", name: str, element: int, ratio: float) -> Coupling:
    """The coupling of the shaft number `element`, at so many times the crank speed."""
    own, may = nominal(given), permissible(given)
    resistance = given.thermal_resistance or 0.0
    if given.temperature_rise is not None:
        resistance = given.temperature_rise / may.power
    warm, service = given.over_temperature, np.zeros((0, 2))
    if warm is not None and warm.service_factor is not None:
        service = np.array([warm.temperature, warm.service_factor]).T
    known = given.ambient_temperature if resistance else given.temperature
    return Coupling(
        name=name,
        type=given.type or "",
        element=element,
        ratio=ratio,
        stiffness=own.stiffness,
        loss_factor=own.relative_damping / (2.0 * math.pi),
        mean_torque=own.rows.get("over_mean_torque"),
        over_temperature=own.rows.get("over_temperature"),
        frequency=own.rows.get("over_frequency"),
        amplitude=own.rows.get("over_amplitude"),
        temperature=known or 0.0,
        resistance=resistance,
        service=service,
        permissible=may,
    )
