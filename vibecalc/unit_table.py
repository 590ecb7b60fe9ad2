"""Dimensions in words, with the units that cases use most; held equal to pint by a test."""

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

_TURN = 2.0 * math.pi
_INCH = 0.0254
_POUND = 0.45359237
_POUND_FORCE = 4.4482216152605  # a pound under standard gravity, exactly
#: standard acceleration of free fall, m/s^2
FREE_FALL = 9.80665
_POUND_FORCE_PER_INCH = 175.1268352464764  # their quotient, rounded once


class Dimension(NamedTuple):
    """An SI unit in words, examples of what may be written, and other units with their factors."""

    words: str
    examples: str
    units: Mapping[str, float] = MappingProxyType({})


#: SI unit -> its dimension
DIMENSIONS: dict[str, Dimension] = {
    "": Dimension("a number without unit", "'0.5' or '50 %'", {"%": 0.01}),
    "m": Dimension(
        "a length", "'0.2 m' or '200 mm'", {"cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": _INCH}
    ),
    "kg": Dimension(
        "a mass",
        "'0.4 kg' or '400 g'",
        {"g": 1e-3, "lb": _POUND, "lbf*s^2/in": _POUND_FORCE_PER_INCH},
    ),
    "s": Dimension("a time", "'0.5 s'", {"ms": 1e-3}),
    "K": Dimension("a temperature", "'20 degC' or '293.15 K'"),
    "K/W": Dimension("a thermal resistance", "'0.05 K/W'"),
    "rad": Dimension("an angle", "'1.5 rad' or '120 deg'", {"mrad": 1e-3, "deg": math.pi / 180.0}),
    "rad/s": Dimension(
        "an angular speed or frequency",
        "'513 rad/s', '4900 rpm' or '50 Hz'",
        {"rpm": _TURN / 60.0, "Hz": _TURN},
    ),
    "m/s": Dimension("a speed", "'2 m/s'", {"mm/s": 1e-3}),
    "m/s^2": Dimension("an acceleration", "'9.81 m/s^2'", {"in/s^2": _INCH}),
    "N": Dimension("a force", "'100 N' or '0.1 kN'", {"kN": 1e3, "lbf": _POUND_FORCE}),
    "N*m": Dimension(
        "a torque or moment",
        "'250 N*m'",
        {"kN*m": 1e3, "in*lbf": _POUND_FORCE * _INCH, "lbf*in": _POUND_FORCE * _INCH},
    ),
    "N/m": Dimension(
        "a stiffness",
        "'10000 N/m' or '10 N/mm'",
        {"N/mm": 1e3, "kN/m": 1e3, "kN/mm": 1e6, "GN/m": 1e9, "lbf/in": _POUND_FORCE_PER_INCH},
    ),
    "N*s/m": Dimension("a damping", "'50 N*s/m'", {"lbf*s/in": _POUND_FORCE_PER_INCH}),
    "kg*m": Dimension(
        "an unbalance", "'0.02 kg*m' or '20000 g*mm'", {"g*mm": 1e-6, "lbf*s^2": _POUND_FORCE}
    ),
    "kg*m^2": Dimension(
        "a moment of inertia",
        "'6.4 kg*m^2'",
        {"t*m^2": 1e3, "lbf*in*s^2": _POUND_FORCE * _INCH},
    ),
    "N*m/rad": Dimension(
        "an angular stiffness", "'6400 N*m/rad'", {"kN*m/rad": 1e3, "MN*m/rad": 1e6}
    ),
    "N*m*s/rad": Dimension("an angular damping", "'32 N*m*s/rad'", {"kN*m*s/rad": 1e3}),
    "Pa": Dimension(
        "a pressure or stress",
        "'2 bar' or '200000 Pa'",
        {"kPa": 1e3, "bar": 1e5, "MPa": 1e6, "N/mm^2": 1e6, "GPa": 1e9}
        | {"psi": _POUND_FORCE / _INCH**2},
    ),
    "kg/m^3": Dimension("a density", "'850 kg/m^3'"),
    "m^2/s": Dimension("a kinematic viscosity", "'86 cSt'", {"cSt": 1e-6}),
    "J": Dimension("an energy", "'0.1 J'", {"kJ": 1e3}),
    "W": Dimension("a power", "'500 W' or '2 kW'", {"kW": 1e3}),
    "m^3": Dimension("a volume", "'40 cm^3'", {"cm^3": 1e-6}),
    "m^3/s": Dimension("a volume flow", "'50 l/min'", {"l/min": 1e-3 / 60.0}),
    "rad/s^2": Dimension("an angular acceleration", "'20 rad/s^2'"),
    "N*m*s": Dimension("an angular momentum", "'0.5 N*m*s'"),
    "V": Dimension("a voltage", "'440 V'", {"kV": 1e3}),
    "ohm": Dimension("a resistance", "'0.05 ohm'", {"mohm": 1e-3}),
    "H": Dimension("an inductance", "'1.5 mH'", {"mH": 1e-3}),
    "dB": Dimension("a level", "'104 dB'"),
}
#: unit -> (factor, SI unit)
TABLE: dict[str, tuple[float, str]] = {
    unit: (factor, si)
    for si, dimension in DIMENSIONS.items()
    for unit, factor in {si: 1.0, **dimension.units}.items()
}

#: what is written for a unit, and would be refused without help or be read as another one (U is an
#: enzyme unit, PS a petasiemens, ton the short ton) -> what is meant by it
MEANT: dict[str, str] = {
    **dict.fromkeys(("U/min", "u/min", "Upm", "upm", "UPM", "r/min", "tr/min"), "'rpm'"),
    **dict.fromkeys(("giri/min", "ob/min"), "'rpm'"),
    **dict.fromkeys(("/min", "per_minute", "cpm", "c/min"), "'rpm' (turns) or 'rad/min'"),
    **dict.fromkeys(("U/s", "u/s", "r/s", "tr/s"), "'rev/s'"),
    **dict.fromkeys(("/s", "per_second", "cps", "c/s", "Bq"), "'Hz' (turns) or 'rad/s'"),
    "ton": "'t' (1000 kg) or 'short_ton' (907 kg)",
    "PS": "'metric_horsepower'",
    "kp": "'kgf'",
    **dict.fromkeys(("mkp", "kpm"), "'kgf*m'"),
    "ccm": "'cm^3'",
    "C": "'degC'",
}

#: SI unit of a unit with a name of one word -> powers of the base units, as pint names them
POWERS: dict[str, dict[str, float]] = {
    "": {},
    "m": {"meter": 1.0},
    "kg": {"kilogram": 1.0},
    "s": {"second": 1.0},
    "rad": {"radian": 1.0},
    "rad/s": {"radian": 1.0, "second": -1.0},
    "m^2/s": {"meter": 2.0, "second": -1.0},
    "N": {"kilogram": 1.0, "meter": 1.0, "second": -2.0},
    "Pa": {"kilogram": 1.0, "meter": -1.0, "second": -2.0},
    "J": {"kilogram": 1.0, "meter": 2.0, "second": -2.0},
    "W": {"kilogram": 1.0, "meter": 2.0, "second": -3.0},
    "dB": {"level": 1.0},  # a level has a reference of its own, and is no power of ten here
}
