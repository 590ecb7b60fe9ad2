"""Claim: docs/validation_compressor.md shows what the cases give and what the source prints.

Every computed number is held against the case named at the head of its section, to each digit
shown, and every printed one against the reference rows of that case.
"""

import re

import numpy as np
import ong_tables as ong
import pytest
from compressor_page import (
    BLOCKS,
    MAIN_PAGE,
    PAGE,
    Stated,
    computed,
    is_printed,
    record,
    rows,
    shown,
    stated,
    table,
)
from shipped_cases import CASES, ROOT

from vibecalc.core.results.select import scalar
from vibecalc.units import convert


@pytest.mark.parametrize("row", stated(), ids=lambda row: f"{row.path}-{row.number}")
def test_computed_number_is_what_the_case_gives(row: Stated) -> None:
    value = computed(row.case, row.path, row.where, row.unit, *row.settings)
    tolerance = 4.0 * (record(row.case, *row.settings)[row.path].standard_error or 0.0)
    if tolerance:
        quantity = record(row.case)[row.path]
        tolerance = convert(tolerance, quantity.unit, row.unit) if row.unit else tolerance
        assert float(row.number) == pytest.approx(value, abs=tolerance)
    else:
        shown(row.number, value if row.number.startswith("-") else abs(value))


@pytest.mark.parametrize(
    "row",
    [row for row in stated() if row.printed and not row.settings],
    ids=lambda row: f"{row.path}-{row.printed}",
)
def test_printed_number_is_a_reference_of_the_case(row: Stated) -> None:
    assert is_printed(row.printed, row.case, row.path, row.where), row


def test_the_page_states_enough_numbers() -> None:
    found = stated()
    assert len(found) >= 20
    assert {"compressor", "compressor_motor"} <= {row.case for row in found}


def test_appendix_1() -> None:
    cells = table("order", "**Appendix I**")
    orders = [int(row[0]) for row in cells]
    assert orders == [*ong.ORDERS]
    path, settings = "kinematics/acceleration_harmonics", ("series=truncated", "terms=40")
    settings = tuple(f"kinematics.{setting}" for setting in settings)
    for order, (_, printed, exact, cut, lacking) in zip(orders, cells, strict=True):
        assert printed == ong.APPENDIX_I[orders.index(order)]
        assert is_printed(printed, "compressor", path, {"order": order})
        values = [
            computed("compressor", path, {"order": order}, "in/s^2", *some)
            for some in ((), settings)
        ]
        shown(exact, values[0])
        shown(cut, values[1])
        rest = 1.0 - values[1] / values[0]
        if lacking == "-":
            assert rest < 1e-12
        else:
            shown(lacking, rest)


def test_plain_arithmetic() -> None:
    share = 0.131 * 0.625 / 2.375
    values = {
        "361.28 rad/s": convert(3450.0, "rpm", "rad/s"),
        "4600 Hz": 80.0 * 361.0 / (2.0 * np.pi),
        "8.929e-5 lbf*s^2/in": share / 386.088,
        "8.9218e-5 lbf*s^2/in": share / 386.4,
        "1.875 in": 5.71 - 3.835,
        "2.07394 in^2": np.pi * 1.625**2 / 4.0,
        "0.017405 s": 2.0 * np.pi / 361.0,
        "1.699702E-5 s": 2.0 * np.pi / 361.0 / 1024.0,
        "8825": 0.15 / (2.0 * np.pi / 361.0 / 1024.0),
        "9848": 8825.0 + 1023.0,
        "0.28269 in lbf": (0.63686 - 0.07148) / 2.0,
        "0.56538 in lbf": 0.63686 - 0.07148,
        "0.747": 1.0 - 2.0 * 0.07148 / (0.63686 - 0.07148),
        "1.253": 1.0 + 2.0 * 0.07148 / (0.63686 - 0.07148),
    }
    cells = [row for block in BLOCKS for row in rows(block) if len(row) == 4 and row[1] in values]
    assert {row[1] for row in cells} == set(values)
    for row in cells:
        shown(row[2].split()[0], values[row[1]])


def test_equations_2_10_to_2_12() -> None:
    """Coefficients of the source's expansion to order 8, acceleration over w^2."""
    radius, length = 0.5, 2.375
    r, ell = radius, length
    printed = {
        1: r,
        2: r**2 * (512 * ell**6 + 128 * ell**4 * r**2 + 60 * ell**2 * r**4 + 35 * r**6) / 512,
        4: -(r**4) * (64 * ell**4 + 48 * ell**2 * r**2 + 35 * r**4) / 256,
        6: 9 * r**6 * (4 * ell**2 + 5 * r**2) / 512,
        8: -5 * r**8 / 256,
    }
    settings = ("kinematics.series=truncated", "kinematics.terms=4")
    acceleration = record("compressor", *settings)["kinematics/acceleration_harmonics"]
    position = record("compressor", *settings)["kinematics/position_harmonics"]
    for order, value in printed.items():
        expected = value if order == 1 else value / ell**7
        ours = -convert(complex(scalar(acceleration, {"order": order})).real, "m", "in")
        assert ours / 361.0**2 == pytest.approx(expected, rel=1e-13)
        # way from top dead centre towards the crank
        way = -convert(complex(scalar(position, {"order": order})).real, "m", "in")
        assert way == pytest.approx(-expected / order**2, rel=1e-13)


def test_summary_adds_up() -> None:
    """Each row: printed numbers, and how many have each verdict."""
    for _, total, *verdicts in table("section"):
        assert int(total) == sum(int(one) for one in verdicts if one)
    shared = [block for block in BLOCKS if block.startswith("| section")]
    assert len(shared) == 1 and shared[0] in MAIN_PAGE


def test_every_test_that_the_page_names_is_there() -> None:
    published = "".join(
        path.read_text(encoding="utf-8") for path in (ROOT / "tests/published").glob("*.py")
    )
    named = re.findall(r"`(test_\w+)`", PAGE)
    assert len(named) >= 12
    for name in named:
        assert f"def {name}(" in published, name
    for name in re.findall(r"`cases/(\w+)\.toml`", PAGE):
        assert name in CASES
