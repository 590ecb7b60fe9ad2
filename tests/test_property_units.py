"""Claim: a text with a unit is read as its number times its unit, and nonsense is a UnitError.

Nothing that is not finite comes out, whatever goes in, and conversion there and back is the
identity to round-off.
"""

import json
import math
import re
import sys
from functools import cache
from itertools import product

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from refused import refusals

from vibecalc.errors import EXIT_USAGE, UnitError, UsageError
from vibecalc.unit_patterns import (
    NUMBERS,
    SHIFTED,
    WRITTEN,
    number_pattern,
    shifted_pattern,
    unit_pattern,
)
from vibecalc.unit_table import DIMENSIONS, TABLE
from vibecalc.units import convert, describe, parse_quantity, si_value

EPS = sys.float_info.epsilon
ordinary = st.floats(min_value=1e-100, max_value=1e100)
units = st.sampled_from(sorted(TABLE))


@given(ordinary, st.sampled_from([1, -1]), units)
def test_number_times_factor(size: float, sign: int, unit: str) -> None:
    value = sign * size
    factor, si = TABLE[unit]
    assert parse_quantity(f"{value!r} {unit}", si) == value * factor
    assert parse_quantity(f"{value!r}{unit}", si) == value * factor
    assert si_value(f"{value!r} {unit}") == value * factor


@given(ordinary, units)
def test_there_and_back(value: float, unit: str) -> None:
    _, si = TABLE[unit]
    back = convert(convert(value, unit, si), si, unit)
    assert abs(back - value) <= 4 * EPS * value


@given(ordinary, units)
def test_without_unit_it_is_si(value: float, unit: str) -> None:
    assert parse_quantity(repr(value), TABLE[unit][1]) == value
    assert parse_quantity(value, TABLE[unit][1]) == value


@settings(max_examples=100, deadline=None)
@given(
    st.text(max_size=30)
    | st.from_regex(r"[+-]?[0-9.e]{1,8} ?[a-zA-Z*/^()0-9 ]{0,12}", fullmatch=True),
    st.sampled_from(["", "m", "rad/s", "N*m/rad"]),
)
@example("1 9**9**9**9", "m")
@example("1 m^99999999999", "m")
@example("1 " + "(" * 50, "m")
@example("1 yottaparsec^9", "m")
@example("1 yottaparsec^-9", "m")
@example("1 ℵ", "m")
@example("٣ m", "m")
@example("1e309", "m")
@example("1e-9999 m", "m")
def test_any_text_gives_a_finite_number_or_a_unit_error(text: str, unit: str) -> None:
    try:
        value = parse_quantity(text, unit)
    except UnitError as error:
        refused, message = error, str(error)
    else:
        refused, message = None, "read"
        assert math.isfinite(value)
    assert refused is None or refused.allowed
    assert len(message) < 400


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("2.375 in", "m", 2.375 * 0.0254),
        ("-300 mm", "m", -0.3),
        ("120 deg", "rad", 2 * math.pi / 3),
        ("120°", "rad", 2 * math.pi / 3),
        ("4900 rpm", "rad/s", 4900 * math.pi / 30),
        ("1 Hz", "rad/s", 2 * math.pi),
        ("2 kHz", "rad/s", 4000 * math.pi),
        ("3 1/s", "1/s", 3.0),
        ("3 m s⁻²", "m/s^2", 3.0),
        ("1e4 N/m", "N/m", 1e4),
        ("5 N*mm", "N*m", 5e-3),
        ("5 N mm/rad", "N*m/rad", 5e-3),
        ("1 N*m", "N*m/rad", 1.0),
        ("1 lb", "kg", 0.45359237),
        ("1 lbf*s^2/in", "kg", 0.45359237 * 9.80665 / 0.0254),
        ("1 N/(m/s)", "N*s/m", 1.0),
        ("2 kg*m²", "kg*m^2", 2.0),
        ("50 %", "", 0.5),
        ("61 MNm/rad", "N*m/rad", 61e6),
        ("3 Nms/rad", "N*m*s/rad", 3.0),
        ("3 kNm s/rad", "N*m*s/rad", 3e3),
        ("7 Ns/m", "N*s/m", 7.0),
        ("5 kgm2", "kg*m^2", 5.0),
        ("5 kgm²", "kg*m^2", 5.0),
        ("2 kgcm^2", "kg*m^2", 2e-4),
        ("2 gmm", "kg*m", 2e-6),
        ("5 Nmm", "N*m", 5e-3),
    ],
)
def test_units_of_engineers(text: str, unit: str, value: float) -> None:
    assert abs(parse_quantity(text, unit) - value) <= 4 * EPS * abs(value)


@pytest.mark.parametrize(("case", "text", "unit", "words"), refusals("units"))
def test_words_of_refusals(case: str, text: str, unit: str, words: list[str]) -> None:
    with pytest.raises(UnitError) as caught:
        parse_quantity(json.loads(text), unit.removeprefix("-"))
    for expected in words:
        assert expected in str(caught.value)
    assert isinstance(caught.value, UsageError)
    assert caught.value.exit_code == EXIT_USAGE


def test_a_number_that_is_not_finite_is_refused() -> None:
    for value in (math.nan, math.inf, -math.inf):
        with pytest.raises(UnitError, match="not finite"):
            parse_quantity(value, "m")


def test_every_si_unit_has_words() -> None:
    for _, si in TABLE.values():
        assert not describe(si).startswith("a value in")


# ----------------------------------------------------------------------------
# The patterns of the JSON schema take a text with a unit where the program reads it.
# ----------------------------------------------------------------------------

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
