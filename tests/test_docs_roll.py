"""Claim: docs/validation_roll.md shows what the source prints and what is right, to each digit."""

import re
import runpy
from collections import Counter
from typing import Any

import numpy as np
import pytest
from exact_roll import exact_harmonics, exact_levels, exact_turn
from herold_simulation import open_tables, simulate
from pages import assert_named_exist
from roll_control_loops import SOURCE, source_load
from roll_machines import (
    FIRST_MASS,
    GRAVITY,
    ROTOR,
    RPM,
    SHELL,
    SYNCHRONOUS,
    source_drive,
    source_machine,
)
from roll_page import (
    ORDERS,
    PAGE,
    PRINTED_LOAD,
    RIGHT_LOAD,
    SECOND,
    SIX_POUNDS,
    WORDS,
    best_estimate,
    changed,
    control_numbers,
    least_numbers,
    needed_numbers,
    pistons,
    running_numbers,
    shown,
    spectrum,
    study_numbers,
    table,
)
from shipped_cases import ROOT
from test_docs import rows

from vibecalc.roll.control.gains import motor_gain_study
from vibecalc.roll.turn import level

VERDICTS = ("reproduced", "with the slip", "misprint", "compatible", "not reproducible")
EQUAL = {"equal": True, "reciprocating_mass": [FIRST_MASS, FIRST_MASS]}


def published(name: str = "roll") -> dict[str, Any]:
    return runpy.run_path(str(ROOT / "tests" / "published" / f"test_published_{name}.py"))


PART = published()


def section(number: int) -> str:
    """Heading of a section."""
    found = re.search(rf"^## {number}\. .*$", PAGE, re.MULTILINE)
    assert found is not None
    return found[0]


def labelled(cells: list[list[str]], label: int, number: int) -> dict[str, str]:
    """Numbers of a table by the name of their quantity."""
    return {row[label]: row[number] for row in cells if row[label]}


def test_summary_counts_the_verdicts() -> None:
    summary = rows(PAGE)[2:9]
    assert len(summary) == 7
    for title, printed, *counts in summary:
        start = PAGE.index(f"\n## {title}")
        body = PAGE[start + 1 :].split("\n## ")[0]
        found: Counter[str] = Counter()
        for block in body.split("\n\n"):
            lines = rows(block)
            if not lines:
                continue
            places = [i for i, name in enumerate(lines[0]) if name == "verdict"]
            found += Counter(row[i] for row in lines[2:] for i in places if row[i])
        assert set(found) <= set(VERDICTS)
        assert int(printed) == found.total(), title
        assert [int(cell or 0) for cell in counts] == [found[verdict] for verdict in VERDICTS]


def test_the_tests_that_are_named_exist() -> None:
    assert_named_exist(PAGE)


def test_table_6() -> None:
    cells = table(section(1), "speed, rpm")
    assert len(cells) == len(PART["TABLE_6"])
    for row, (speed, torque, slip, power) in zip(cells, PART["TABLE_6"], strict=True):
        assert row[:4] == [str(speed), str(torque), str(slip), "" if power is None else str(power)]
        if power is not None:
            shown(row[4], 100.0 * torque * speed * RPM / 44.7e3)


def test_units() -> None:
    values = {
        "3600 lbf": 3600.0 * 0.45359237 * GRAVITY,
        "60.0 hp": 60.0 * 0.7457,
        "11.5 in": 11.5 * 25.4,
        "2.5 in": 2.5 * 25.4,
        "3600 lbm ft^2": SHELL,
        "50 lbm ft^2": ROTOR,
    }
    cells = labelled(table(section(1), "place"), 2, 3)
    assert set(cells) == set(values)
    for name, cell in cells.items():
        shown(cell, values[name])


def test_section_2() -> None:
    values, cells = running_numbers(), table(section(2), "place")
    found = labelled(cells, 2, 3)
    assert set(found) <= set(values) and len(found) == 5
    for name, cell in found.items():
        shown(cell, values[name])
    printed = {row[0].split(",")[0]: row[1] for row in cells if row[1]}
    assert {"6.3", "6.4", "6.5", ["7.1", " the speed varies by"][0]} == set(printed)
    assert [row[1] for row in cells if row[0].startswith("6.3")] == ["136", "100", "0.5 dB"]


def test_appendix_a() -> None:
    single, levels = PART["best_estimate"](True), level(best_estimate())
    lags = -np.angle(best_estimate()) % (2.0 * np.pi)
    cells = table(section(3), "order")
    for row, (order, texts) in zip(cells, PART["APPENDIX_A"].items(), strict=True):
        place = order - 1
        assert (row[0], row[1], row[6]) == (str(order), *texts)
        shown(row[2], single.level[place])
        shown(row[3], levels[place])
        shown(row[4].lstrip("+"), float(texts[0]) - levels[place])
        shown(row[7], single.lag[place])
        shown(row[8], lags[place])
        right = PART["prints"](texts[0], levels[place])
        assert row[5] == ("reproduced" if right else "with the slip")
        digits = PART["prints"](texts[1], single.lag[place])
        assert row[9] == ("with the slip" if digits else "compatible")


def test_frequency_and_drift() -> None:
    single, double = (PART["best_estimate"](x) for x in (True, False))
    frequency, drift = table(section(3), "place")
    numbers = single.frequency, double.frequency, running_numbers()["frequency"]
    for cell, value in zip(frequency[2:5], numbers, strict=True):
        shown(cell, value)
    for cell, value in zip(drift[2:5], (single.drift, double.drift, 0.0), strict=True):
        shown(cell, value)


def test_words_on_appendix_a() -> None:
    apart = PART["LEVELS"] - level(best_estimate())
    assert re.search(r"off by up to 0\.61 dB \(order 7\)", WORDS)
    assert np.argmax(np.abs(apart)) == 6
    shown("0.61", abs(apart[6]))
    single = PART["best_estimate"](True).level[7]
    assert "order 8, is -20.052 and lacks 0.002 dB" in WORDS
    shown("-20.052", single)
    shown("0.002", -20.05 - single)
    assert "turns the lag of order n by up to 0.046 n rad" in WORDS
    shown("0.046", 2.0 * np.pi * 0.0005 * running_numbers()["frequency"])


@pytest.mark.long
def test_shorter_steps_lead_to_the_computed_levels() -> None:
    """Two thousandths of his step: what remains is mostly the first interval of the gas tables."""
    fine = simulate(source_machine(), open_tables(source_drive()), step=1e-5)
    assert "comes within 0.08 dB" in WORDS
    assert np.max(np.abs(fine.level - level(best_estimate()))) < 0.08


def test_table_7() -> None:
    levels, cells = level(best_estimate()), table(section(4), "order")
    double, single = PART["equal_pressure"](), PART["equal_pressure"](True)
    linear, parabola = (spectrum(gas, **EQUAL) for gas in ("linear", "parabola"))
    for row, (order, texts) in zip(cells, PART["TABLE_7"].items(), strict=True):
        place = order - 1
        assert (row[0], row[1], row[4]) == (str(order), *texts)
        shown(row[2], levels[place])
        shown(row[5], (single if order % 2 else double)[place])
        if order % 2:
            assert row[6] == row[7] == "no motion"
            for found in (linear, parabola):
                assert abs(found[place]) < 1e-13 * np.max(np.abs(found))
        else:
            shown(row[6], level(linear)[place])
            shown(row[7], level(parabola)[place])


def test_section_6_6() -> None:
    cells, values, needed = table(section(5), "change"), study_numbers(), needed_numbers()
    assert [row[2] for row in cells] == list(values)
    for row in cells:
        shown(row[3], values[row[2]])
        assert bool(row[4]) == (row[2] in needed)
        if row[4]:
            shown(row[4], needed[row[2]])
        # a change is reproduced where it rounds to what is printed
        rounds = PART["prints"](row[1].split(" ")[0], values[row[2]])
        assert rounds == (row[5] == "reproduced"), row
    assert "with 0.3 kg m^2 it is -10.6 and order 2 is -8.7 dB" in PAGE
    for number, order in (("-10.6", 1), ("-8.7", 2)):
        shown(number, changed(order, rotor_inertia=[0.3]))


def test_least_vibration() -> None:
    cells, values = table(section(5), "quantity"), least_numbers()
    assert [row[0] for row in cells] == list(values)
    for name, printed, factor, change, verdict in cells:
        shown(factor, values[name][0])
        shown(change, values[name][1])
        assert printed == ("2.0" if name.startswith("both") else "4.0")
        assert verdict == "with the slip"


def test_reduced_model() -> None:
    cells, values = table(section(6), "place"), running_numbers()
    found = labelled(cells, 2, 3)
    assert set(found) <= set(values) and len(found) == 5
    for name, cell in found.items():
        shown(cell, values[name])
    levels = PART["LEVELS"]
    shown(cells[0][3], np.max(np.abs(PART["reduced"](None) - levels)))
    low = levels - PART["reduced"](203.4)
    words = re.search(r"harmonics 3 and 7 are (\S+) and (\S+) dB low", WORDS)
    assert words is not None
    shown(words[1], low[2])
    shown(words[2], low[6])
    shown("-303.29", PART["disturbance"](92.76)[0].real)


def test_control() -> None:
    cells, values = labelled(table(section(7), "place"), 2, 3), control_numbers()
    assert set(cells) == set(values)
    for name, cell in cells.items():
        shown(cell, values[name])


def test_table_8() -> None:
    printed = published("roll_control")["TABLE_8"]
    cells = table(section(7), "gain")
    source, right = (
        motor_gain_study(SOURCE, printed[:, 0], source_load(*load))
        for load in (PRINTED_LOAD, RIGHT_LOAD)
    )
    for place, row in enumerate(cells):
        assert [float(row[i]) for i in (0, 1, 5, 9)] == printed[place].tolist()
        for harmonic, column in ((0, 2), (1, 6)):
            shown(row[column], source.level.value[place, harmonic])
            shown(row[column + 1], right.level.value[place, harmonic])
        shown(row[10], float(source.speed.value[place]))
        assert (row[11] == "reproduced") == PART["prints"](row[9], float(row[10]))
    shown("345.6", RIGHT_LOAD[0])
    shown("345.6", running_numbers()["d, harmonic 1"])
    shown("472.2", running_numbers()["d, harmonic 2"])


@pytest.mark.long
def test_the_independent_integration_gives_the_same_spectrum() -> None:
    exact = exact_turn(source_machine(), source_drive(), started_at=SYNCHRONOUS)
    truth = exact_harmonics(exact, exact.shell_acceleration, ORDERS)
    np.testing.assert_allclose(best_estimate(), truth, rtol=0, atol=1e-11)
    assert np.max(np.abs(level(best_estimate()) - exact_levels(exact, ORDERS))) < 1e-9
    assert running_numbers()["frequency"] == pytest.approx(1.0 / exact.period, rel=1e-12)
    kept = running_numbers()["what a turn keeps of a deviation"]
    assert kept == pytest.approx(exact.multiplier, rel=1e-6)
    ratio = exact.crank_speed * exact.period / (2.0 * np.pi)
    assert running_numbers()["speed, least to largest"] == pytest.approx(
        100.0 * np.ptp(ratio), abs=0.01
    )


@pytest.mark.long
@pytest.mark.parametrize(
    "fields",
    [{"rod_length": 3.302}, {"rotor_inertia": SIX_POUNDS}, pistons(4.574, SECOND)],
    ids=["long rod", "light rotor", "heavy piston"],
)
def test_the_independent_integration_gives_the_same_changes(fields: dict[str, Any]) -> None:
    exact = exact_turn(source_machine(**fields), source_drive(), started_at=SYNCHRONOUS)
    boxed = {k: v if np.ndim(v) else [v] for k, v in fields.items()}
    apart = level(spectrum(**boxed)) - exact_levels(exact, ORDERS)
    assert np.max(np.abs(apart)) < 1e-9
