"""Claim: the patterns of the JSON schema take a text with a unit where the program reads it.

Every text that a pattern makes is read, as a number that the key may have; every unit of the table
is taken for its dimension and refused for all others, in every spelling that is listed here.
"""

import json
import math
import re
from functools import cache
from itertools import product

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from refused import refusals

from vibecalc.errors import UnitError
from vibecalc.unit_patterns import (
    NUMBERS,
    SHIFTED,
    WRITTEN,
    number_pattern,
    shifted_pattern,
    unit_pattern,
)
from vibecalc.unit_table import DIMENSIONS, TABLE
from vibecalc.units import parse_quantity

#: SI units of keys; the last ones have no words of their own
UNITS = (*DIMENSIONS, "m^2/s^3", "rad^2/s^3", "1/K", "N/m^3")


@cache
def patterns(unit: str, least: str = "") -> list[re.Pattern[str]]:
    """What a text has to match: the pattern of its number, and that of its unit."""
    if unit in SHIFTED:
        return [re.compile(shifted_pattern(unit, least))]
    return [re.compile(number_pattern(least)), re.compile(unit_pattern(unit))]


def takes(unit: str, least: str, text: str) -> bool:
    """Whether the schema takes a text."""
    return all(pattern.search(text) for pattern in patterns(unit, least))


@cache
def texts(unit: str, least: str) -> st.SearchStrategy[str]:
    """Texts of a number before the units that its pattern takes."""
    if unit in SHIFTED:
        return st.from_regex(shifted_pattern(unit, least))
    return st.from_regex(unit_pattern(unit).replace(WRITTEN, NUMBERS[least], 1))


def reads(text: str, unit: str, least: str = "") -> bool:
    """Whether the program takes this text for a key of this unit."""
    try:
        value = parse_quantity(text, unit)
    except UnitError:
        return False
    return {"": True, "from_0": value >= 0.0, "above_0": value > 0.0}[least]


PAIRS = [(unit, least) for unit in UNITS for least in NUMBERS]
TAKEN = st.sampled_from(PAIRS).flatmap(lambda pair: st.tuples(st.just(pair), texts(*pair)))


@settings(max_examples=4, deadline=None, suppress_health_check=list(HealthCheck))
@given(TAKEN)
def test_what_a_pattern_takes_is_read(taken: tuple[tuple[str, str], str]) -> None:
    pair, text = taken
    if len(text.strip()) <= 120:
        assert math.isfinite(parse_quantity(text, pair[0]))
        assert takes(*pair, text) and reads(text, *pair)


@pytest.mark.parametrize("unit", UNITS)
def test_units_of_the_table_are_taken_for_their_dimension_alone(unit: str) -> None:
    for name in (*TABLE, "degC", "°C", "K"):
        for text in (f"5 {name}", f"-2.5e3{name}"):
            assert takes(unit, "", text) == reads(text, unit), (text, unit)


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
        assert takes(unit, "", text), text


@pytest.mark.parametrize(("unit", "text", "least", "words"), refusals("unit_texts"))
def test_numbers_and_units_as_people_write_them(
    unit: str, text: str, least: str, words: list[str]
) -> None:
    unit, least, taken = unit.removeprefix("-"), least.removeprefix("-"), words == ["taken"]
    assert reads(json.loads(text), unit, least) == taken
    assert takes(unit, least, json.loads(text)) == taken
