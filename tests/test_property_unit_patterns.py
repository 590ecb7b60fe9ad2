"""Claim: the patterns of the JSON schema take a text with a unit where the program reads it.

Every text that a pattern makes is read, as a number that the key may have; every unit of the table
is taken for its dimension and refused for all others, in every spelling that is listed here.
"""

import math
import re
from functools import cache
from itertools import product

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from vibecalc.errors import UnitError
from vibecalc.unit_patterns import LESS, SHIFTED, text_pattern
from vibecalc.unit_table import DIMENSIONS, TABLE
from vibecalc.units import parse_quantity

#: SI units of keys; the last ones have no words of their own
UNITS = (*DIMENSIONS, "m^2/s^3", "rad^2/s^3", "1/K", "N/m^3")


@cache
def pattern(unit: str, least: str = "") -> re.Pattern[str]:
    return re.compile(text_pattern(unit, least if unit in SHIFTED else ""))


def takes(unit: str, least: str, text: str) -> bool:
    """Whether the schema takes a text: by its pattern, and not by that of less than it may be."""
    less = re.search(LESS[least], text) if least and unit not in SHIFTED else None
    return bool(pattern(unit, least).search(text)) and not less


def reads(text: str, unit: str, least: str = "") -> bool:
    """Whether the program takes this text for a key of this unit."""
    try:
        value = parse_quantity(text, unit)
    except UnitError:
        return False
    return {"": True, "from_0": value >= 0.0, "above_0": value > 0.0}[least]


PAIRS = [(unit, least) for unit in UNITS for least in ("", *LESS)]
TEXTS = {pair: st.from_regex(pattern(*pair)) for pair in PAIRS}
TAKEN = st.sampled_from(PAIRS).flatmap(lambda pair: st.tuples(st.just(pair), TEXTS[pair]))


@settings(max_examples=4, deadline=None, suppress_health_check=list(HealthCheck))
@given(TAKEN)
def test_what_a_pattern_takes_is_read(taken: tuple[tuple[str, str], str]) -> None:
    pair, text = taken
    if len(text.strip()) <= 120:
        assert math.isfinite(parse_quantity(text, pair[0]))
        assert reads(text, *pair) >= takes(*pair, text)


@pytest.mark.parametrize("unit", UNITS)
def test_units_of_the_table_are_taken_for_their_dimension_alone(unit: str) -> None:
    for name in (*TABLE, "degC", "°C", "K"):
        for text in (f"5 {name}", f"-2.5e3{name}"):
            assert bool(pattern(unit).search(text)) == reads(text, unit), (text, unit)


#: factors with their prefixes, in products and spellings that engineers use
FORCE, LENGTH, MASS = ("N", "kN", "MN", "lbf", "kgf"), ("m", "mm", "in", "ft"), ("kg", "g", "lb")
TIMES, SQUARED = ("*", " ", "·", " * "), ("^2", "2", "²", "**2")
SPELLINGS: dict[str, tuple[tuple[str, ...], ...]] = {
    "m": (("", "k", "c", "m", "u", "µ", "n"), ("m",)),
    "rad/s": (
        ("Hz", "kHz", "mHz", "rpm", "krpm", "rad/s", "mrad/s", "deg/s", "°/s", "turn/min", "rev/s"),
    ),
    "N": (FORCE,),
    "N*m": (FORCE, TIMES, LENGTH),
    "J": (("", "k", "M"), ("J", "N*m", "Nm")),
    "N/m": (FORCE, ("/", " / "), LENGTH),
    "N*s/m": (FORCE, TIMES, ("s", "ms"), ("/",), LENGTH),
    "kg*m": (MASS, TIMES, LENGTH),
    "kg*m^2": (MASS, TIMES, LENGTH, SQUARED),
    "N*m/rad": (FORCE, TIMES, LENGTH, ("", "/rad", "/deg")),
    "N*m*s/rad": (FORCE, TIMES, LENGTH, TIMES, ("s",), ("", "/rad")),
    "Pa": (("Pa", "kPa", "hPa", "bar", "mbar", "psi", "N/mm^2", "N/m²", "kN/cm2"),),
    "m/s^2": (LENGTH, ("/s",), SQUARED),
    "m^2/s": (("cSt", "St", "mm^2/s", "m²/s", "m2/s"),),
    "K": (("K", "mK", "degC", "°C", "kelvin"),),
}


@pytest.mark.parametrize("unit", SPELLINGS)
def test_products_with_prefixes_are_taken_and_read(unit: str) -> None:
    for parts in product(*SPELLINGS[unit]):
        text = f"3 {''.join(parts)}"
        assert reads(text, unit), text
        assert pattern(unit).search(text), text


@pytest.mark.parametrize(
    ("unit", "least", "text", "taken"),
    [
        *(("m", "", text, True) for text in ("5", "+5", "−5 mm", " 5mm ", "1_000 mm", "5.e-3 km")),
        *(("m", "", text, True) for text in (".5 m", "5e+03 mm", "3 millimetres", "1 inch")),
        *(("m", "", text, False) for text in ("", "mm", "5,5 mm", "5 m m", "1e m", "5 mm/s")),
        *(("m", "", text, False) for text in ("1__0 m", "1_ m", "0x5 m", "nan", "inf m", "5 mmm")),
        *(("m", "", text, False) for text in ("5 min", "5 m^2", "5 Mm^1.5", "- 5 mm", "5 MM")),
        *(("rad/s", "", text, True) for text in ("5 rev/s", "3e3 rpm", "10 °/s")),
        *(("rad/s", "", text, False) for text in ("51/s", "5 rmp", "5 rad", "5 1/min", "5 /s")),
        *(("rad/s", "", text, False) for text in ("5 1/s", "5 1 / s", "5 s^-1", "5 U/min")),
        *(("rad/s^2", "", text, False) for text in ("5 1/s^2", "5 rad", "5 s^-2")),
        *(("N*m", "", text, True) for text in ("5 Nm", "5 kNm", "5 Nmm", "5 m*N", "5 lbf*ft")),
        *(("N*m", "", text, False) for text in ("5 N", "5 Ncm2", "5 N/m", "5 Nin", "5 kNm/s")),
        *(("N*m*s/rad", "", text, True) for text in ("5 Nms/rad", "5 Nms", "5 kNm*s/rad")),
        *(("kg*m^2", "", text, True) for text in ("5 kgm2", "5 kgm²", "5 g*mm^2", "5 gmm2")),
        *(("", "", text, True) for text in ("50 %", "50%", "0.5")),
        *(("", "", text, False) for text in ("%", "0.5 m", "5 deg")),
        *(("dB", "", text, True) for text in ("104 dB", "-3dB")),
        *(("dB", "", text, False) for text in ("104 mdB", "104 db", "3 %")),
        *(("m", "from_0", text, True) for text in ("0 mm", "0", "+0.0 m", "5 mm")),
        *(("m", "from_0", text, False) for text in ("-5 mm", "−1")),
        *(("m", "above_0", text, True) for text in ("0.05 mm", "00.10", "10 mm", ".01e-5 m")),
        *(("m", "above_0", text, False) for text in ("0 mm", "0", "0.00e5 m", "-5 mm", ".0")),
        *(("K", "above_0", text, True) for text in ("-20 degC", "20 °C", "293 K", "-199.9 °C")),
        *(("K", "above_0", text, False) for text in ("-20 K", "-300 degC", "0 K", "−1")),
    ],
)
def test_numbers_and_units_as_people_write_them(
    unit: str, least: str, text: str, taken: bool
) -> None:
    assert reads(text, unit, least) == taken
    assert takes(unit, least, text) == taken
