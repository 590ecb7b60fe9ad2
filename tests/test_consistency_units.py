"""Claim: the small table of units equals pint in every entry, and reading never needs pint for it.

pint is asked for each unit as a whole, with its own parser; its Hz is replaced by turns per second,
which is what an engineer means by it.
"""

import subprocess
import sys
from functools import cache
from typing import Any

import pytest
from schema_places import keys, places

from vibecalc.core.case.walk import words
from vibecalc.errors import UnitError
from vibecalc.units import DIMENSIONS, TABLE, convert, parse_quantity

EPS = sys.float_info.epsilon


@cache
def registry() -> Any:
    """Of pint, which takes a while to be loaded."""
    import pint

    return pint.UnitRegistry()


def pint_factor(unit: str, si: str) -> float:
    """Factor between two units by pint alone."""
    asked = {"": "dimensionless", "Hz": "turn/s", "%": "percent"}
    return float(registry().Quantity(1.0, asked.get(unit, unit)).to(asked.get(si, si)).magnitude)


@pytest.mark.parametrize("unit", sorted(TABLE))
def test_table_equals_pint(unit: str) -> None:
    factor, si = TABLE[unit]
    assert abs(factor - pint_factor(unit, si)) <= 2 * EPS * factor
    assert TABLE[si] == (1.0, si)
    assert si in DIMENSIONS


@pytest.mark.parametrize(
    ("unit", "si"),
    [("ft", "m"), ("N*mm", "N*m"), ("oz*in", "kg*m"), ("slug", "kg"), ("turn/min", "rad/s"),
     ("deg/ms", "rad/s"), ("gravity", "m/s^2")],
)  # fmt: skip
def test_the_rest_equals_pint(unit: str, si: str) -> None:
    factor = pint_factor(unit, si)
    assert abs(convert(1.0, unit, si) - factor) <= 8 * EPS * factor
    assert abs(parse_quantity(f"2.5 {unit}", si) - 2.5 * factor) <= 20 * EPS * factor


@pytest.mark.parametrize(
    ("unit", "si"),
    [("N*m/rad^2", "N*m/rad^2"), ("1/rad^2", "1/rad^2"), ("kg*cm^2", "kg*m^2"), ("%/ms", "1/s"),
     ("kN/mm*deg", "N/m*rad"), ("lb*in^2", "kg*m^2"), ("psi/in", "Pa/m"), ("kW/rpm", "N*m/rad"),
     ("lbf*in/deg", "N*m/rad"), ("bar*cm^2", "N"), ("kJ/m^3", "Pa"), ("1/cSt", "s/m^2")],
)  # fmt: skip
def test_products_of_the_table_equal_pint_without_it(
    unit: str, si: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    from vibecalc import units

    monkeypatch.setattr(units, "registry", None)  # is not asked
    units.read_unit.cache_clear()
    units._factor.cache_clear()
    factor = pint_factor(unit, si)
    assert abs(convert(1.0, unit, si) - factor) <= 8 * EPS * factor


def test_the_table_is_read_without_pint() -> None:
    code = (
        "import sys; from vibecalc.units import TABLE, convert, parse_quantity\n"
        "for unit, (_, si) in TABLE.items():\n"
        "    convert(1.0, unit, si); parse_quantity('1 ' + unit, si)\n"
        "try: parse_quantity('3 kg', 'm')\n"
        "except ValueError: pass\n"
        "sys.exit(any(name in sys.modules for name in ('pint', 'numpy', 'pydantic')))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_degrees_celsius_have_a_zero_of_their_own() -> None:
    assert parse_quantity("20 degC", "K") == 293.15
    assert parse_quantity("-40 °C", "K") == pytest.approx(233.15, rel=1e-15)
    assert parse_quantity("293.15 K", "K") == 293.15
    for read in (lambda: convert(20.0, "degC", "K"), lambda: parse_quantity("20 degC", "m")):
        with pytest.raises(UnitError, match="zero of its own"):
            read()
    with pytest.raises(UnitError, match="zero of its own"):
        parse_quantity("20 degC", "K", difference=True)
    assert parse_quantity("20 K", "K", difference=True) == 20.0


#: a part of keys -> what the messages call their number
CALLED = {
    "volume": "a volume",
    "section_modulus": "a section modulus",
    "shear_modulus": "an elastic modulus",
    "bulk_modulus": "an elastic modulus",
    "pressure": "a pressure",
    "stress": "a stress",
    "strength": "a stress",
    "torque": "a torque",
    "frequency": "a frequency",
    "speed": "an angular speed",
    "sample_rate": "a sampling rate",
    "temperature_rise": "a rise of temperature",
}


@pytest.mark.parametrize("part", CALLED)
def test_a_number_is_called_what_its_key_says(part: str) -> None:
    units = {"bulk_modulus": "Pa", "shear_modulus": "Pa", "pressure": "Pa", "torque": "N*m"}
    units |= dict.fromkeys(("frequency", "speed"), "rad/s")
    shapes = (places()[pattern].innermost for (_, key), pattern in keys().items() if part in key)
    found = [
        shape for shape in shapes
        if shape.kind == "number" and shape.unit and shape.unit == units.get(part, shape.unit)
    ]  # fmt: skip
    assert found and {words(one).startswith(CALLED[part]) for one in found} == {True}
