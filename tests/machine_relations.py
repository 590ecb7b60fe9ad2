"""One machine told in other units."""

from collections.abc import Mapping
from typing import Any

import numpy as np

#: exponents of length, mass and time
DIMENSIONS: Mapping[str, tuple[int, int, int]] = {
    "": (0, 0, 0),
    "rad": (0, 0, 0),
    "dB": (0, 0, 0),
    "m": (1, 0, 0),
    "m/s": (1, 0, -1),
    "m/s^2": (1, 0, -2),
    "m^2/s^3": (2, 0, -3),
    "m^2/s": (2, 0, -1),
    "rad^2/s^3": (0, 0, -3),
    "m^3": (3, 0, 0),
    "m^3/s": (3, 0, -1),
    "kg": (0, 1, 0),
    "kg*m": (1, 1, 0),
    "kg*m^2": (2, 1, 0),
    "rad/s": (0, 0, -1),
    "rad/s^2": (0, 0, -2),
    "N": (1, 1, -2),
    "Pa": (-1, 1, -2),
    "N*m": (2, 1, -2),
    "J": (2, 1, -2),
    "W": (2, 1, -3),
    "N/m": (0, 1, -2),
    "N/m^3": (-2, 1, -2),
    "N*s/m": (0, 1, -1),
    "N*m/rad": (2, 1, -2),
    "N*m*s/rad": (2, 1, -1),
}
KEYS: Mapping[str, str] = {
    **dict.fromkeys(("crank_radius", "rod_length", "wrist_pin_offset", "position", "origin"), "m"),
    **dict.fromkeys(("length", "width", "height", "positions", "lever", "reference_length"), "m"),
    **dict.fromkeys(("crank_pin_to_mass_centre", "centre", "datum", "bore", "point"), "m"),
    **dict.fromkeys(("down", "up", "deflection", "displacement"), "m"),
    **dict.fromkeys(("mass", "reciprocating_mass", "rotating_mass", "piston_mass"), "kg"),
    **dict.fromkeys(("pin_mass",), "kg"),
    **dict.fromkeys(("inertia", "inertia_products"), "kg*m^2"),
    **dict.fromkeys(("speed", "from", "to", "frequency", "band", "angular_velocity"), "rad/s"),
    **dict.fromkeys(("suction_pressure", "discharge_pressure", "outside_pressure"), "Pa"),
    **dict.fromkeys(("bulk_modulus", "pressure"), "Pa"),
    **dict.fromkeys(("load", "force"), "N"),
    "dead_volume": "m^3",
    "velocity": "m/s",
    "acceleration": "m/s^2",
    "angular_acceleration": "rad/s^2",
    "unbalance": "kg*m",
    "gravity": "m/s^2",
    "stiffness": "N/m",
    "cubic_stiffness": "N/m^3",
    "damping": "N*s/m",
}
#: of columns in tables over frequency, by the key of the table
COLUMNS: Mapping[str, tuple[str, str]] = {
    "dynamic_stiffness": ("real imaginary", "N/m"),
    "impedance": ("real imaginary", "N*s/m"),
    "angular_dynamic_stiffness": ("real imaginary", "N*m/rad"),
    "angular_impedance": ("real imaginary", "N*m*s/rad"),
    "acceleration": ("density", "m^2/s^3"),
    "velocity": ("density", "m^2/s"),
    "angular_acceleration": ("density", "rad^2/s^3"),
}


def in_units(
    value: Any, factors: tuple[float, float, float], key: str = "", table: str = ""
) -> Any:
    """A case in other units; the factors are those of length, mass and time."""
    if isinstance(value, dict):
        return {name: in_units(item, factors, name, key) for name, item in value.items()}
    if isinstance(value, list):
        return [in_units(item, factors, key, table) for item in value]
    columns, unit = COLUMNS.get(table, ("", ""))
    unit = unit if key in columns.split() else KEYS.get(key, "")
    if isinstance(value, str | bool) or not unit:
        return value
    return value * factor_of(unit, factors)


def factor_of(unit: str, factors: tuple[float, float, float]) -> float:
    """What a number in this unit is multiplied by."""
    return float(np.prod([f**e for f, e in zip(factors, DIMENSIONS[unit], strict=True)]))
