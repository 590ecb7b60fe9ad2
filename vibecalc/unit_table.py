"""The units that cases use most, and the dimensions in words; held equal to pint by a test."""

import math

_TURN = 2.0 * math.pi
_DEGREE = math.pi / 180.0
_INCH = 0.0254
_POUND = 0.45359237
_POUND_FORCE = 4.4482216152605  # a pound under standard gravity, exactly
_POUND_FORCE_PER_INCH = 175.1268352464764  # their quotient, rounded once

#: unit -> (factor, SI unit)
TABLE: dict[str, tuple[float, str]] = {
    "": (1.0, ""),
    "%": (0.01, ""),
    "m": (1.0, "m"),
    "cm": (1e-2, "m"),
    "mm": (1e-3, "m"),
    "in": (0.0254, "m"),
    "kg": (1.0, "kg"),
    "g": (1e-3, "kg"),
    "s": (1.0, "s"),
    "rad": (1.0, "rad"),
    "deg": (_DEGREE, "rad"),
    "rad/s": (1.0, "rad/s"),
    "rpm": (_TURN / 60.0, "rad/s"),
    "Hz": (_TURN, "rad/s"),
    "m/s": (1.0, "m/s"),
    "m/s^2": (1.0, "m/s^2"),
    "N": (1.0, "N"),
    "kN": (1e3, "N"),
    "N*m": (1.0, "N*m"),
    "N/m": (1.0, "N/m"),
    "N/mm": (1e3, "N/m"),
    "kN/m": (1e3, "N/m"),
    "N*s/m": (1.0, "N*s/m"),
    "kg*m": (1.0, "kg*m"),
    "kg*m^2": (1.0, "kg*m^2"),
    "N*m/rad": (1.0, "N*m/rad"),
    "N*m*s/rad": (1.0, "N*m*s/rad"),
    "lb": (_POUND, "kg"),
    "lbf": (_POUND_FORCE, "N"),
    "lbf/in": (_POUND_FORCE_PER_INCH, "N/m"),
    "lbf*s/in": (_POUND_FORCE_PER_INCH, "N*s/m"),
    "in*lbf": (_POUND_FORCE * _INCH, "N*m"),
    "lbf*in": (_POUND_FORCE * _INCH, "N*m"),
    "lbf*s^2/in": (_POUND_FORCE_PER_INCH, "kg"),
    "lbf*s^2": (_POUND_FORCE, "kg*m"),
    "lbf*in*s^2": (_POUND_FORCE * _INCH, "kg*m^2"),
    "psi": (_POUND_FORCE / _INCH**2, "Pa"),
    "Pa": (1.0, "Pa"),
    "bar": (1e5, "Pa"),
    "J": (1.0, "J"),
    "ms": (1e-3, "s"),
    "in/s^2": (_INCH, "m/s^2"),
    "rad/s^2": (1.0, "rad/s^2"),
    "N*m*s": (1.0, "N*m*s"),
    "V": (1.0, "V"),
    "kV": (1e3, "V"),
    "ohm": (1.0, "ohm"),
    "mohm": (1e-3, "ohm"),
    "H": (1.0, "H"),
    "mH": (1e-3, "H"),
    "dB": (1.0, "dB"),
}

#: SI unit -> (its dimension in words, an example of what may be written)
WORDS: dict[str, tuple[str, str]] = {
    "": ("a number without unit", "'0.5' or '50 %'"),
    "m": ("a length", "'0.2 m' or '200 mm'"),
    "kg": ("a mass", "'0.4 kg' or '400 g'"),
    "s": ("a time", "'0.5 s'"),
    "K": ("a temperature", "'20 degC' or '293.15 K'"),
    "rad": ("an angle", "'1.5 rad' or '120 deg'"),
    "rad/s": ("an angular speed", "'513 rad/s' or '4900 rpm'"),
    "m/s": ("a speed", "'2 m/s'"),
    "m/s^2": ("an acceleration", "'9.81 m/s^2'"),
    "N": ("a force", "'100 N' or '0.1 kN'"),
    "N*m": ("a moment", "'250 N*m'"),
    "N/m": ("a stiffness", "'10000 N/m' or '10 N/mm'"),
    "N*s/m": ("a damping", "'50 N*s/m'"),
    "kg*m": ("an unbalance", "'0.02 kg*m' or '20000 g*mm'"),
    "kg*m^2": ("a moment of inertia", "'6.4 kg*m^2'"),
    "N*m/rad": ("an angular stiffness", "'6400 N*m/rad'"),
    "N*m*s/rad": ("an angular damping", "'32 N*m*s/rad'"),
    "Pa": ("a pressure", "'2 bar' or '200000 Pa'"),
    "J": ("an energy", "'0.1 J'"),
    "rad/s^2": ("an angular acceleration", "'20 rad/s^2'"),
    "N*m*s": ("an angular momentum", "'0.5 N*m*s'"),
    "V": ("a voltage", "'440 V'"),
    "ohm": ("a resistance", "'0.05 ohm'"),
    "H": ("an inductance", "'1.5 mH'"),
    "dB": ("a level", "'104 dB'"),
}
