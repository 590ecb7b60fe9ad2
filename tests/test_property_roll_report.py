"""Claim: the report of the shell's roll says what the result has, and advises in the right sense.

Tables keep to the page, a level of nothing is `zero` and has no lag, an unstable motion is called
so, and for each harmonic the three parameters that lower it most are named, with what else rises.
"""

import math
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from report_samples import quantity
from roll_samples import (
    LAGS,
    LEVELS,
    ORDERS,
    PARAMETERS,
    SLOPES,
    forces,
    roll,
    running,
    sensitivities,
    spectra,
    spreads,
    symmetrical,
    with_changes,
)

from vibecalc.core.report.text import render_report
from vibecalc.core.report.writing import decibels, text_of
from vibecalc.core.results.catalogue import HEADLINES
from vibecalc.core.results.record import Axis, Result
from vibecalc.roll.report import advice as advised
from vibecalc.roll.report.advice import joined, parameter_words
from vibecalc.roll.report.running import lag_degrees

TITLE = "Roll of the shell"
PARTS = (running, spectra, forces, spreads, sensitivities)


def section(result: Result) -> list[str]:
    """Lines of the section."""
    lines = render_report(result, full=True).splitlines()
    start = lines.index(TITLE)
    rest = lines[start + 2 :]
    length = next((i for i, line in enumerate(rest) if re.match(r"-{4,}$", line)), len(lines))
    return rest[: length - 2]


def advice(result: Result) -> list[str]:
    blocks = advised.advice(result)
    return text_of(blocks).splitlines() if blocks else []


def table(lines: list[str], *heads: str) -> list[list[str]]:
    """Cells of the rows under the titles that contain all of `heads`."""
    start = next(
        i
        for i, line in enumerate(lines)
        if set(line.strip()) == {"-", " "}
        and all(head in lines[i - 2] + lines[i - 1] for head in heads)
    )
    rows = []
    for line in lines[start + 1 :]:
        if not re.match(r"\s+\d", line):
            break
        rows.append(line.split())
    return rows


def changed(result: Result, path: str, values: Any, error: float | None = None) -> Result:
    old = result.record.quantities[path]
    found = quantity(path, values, old.unit, *old.axes, error=error)
    result.record.quantities[path] = found
    return result


@pytest.mark.parametrize("part", PARTS)
def test_each_result_alone_is_no_reason_to_fail(part: Any) -> None:
    for item in part():
        text = render_report(roll([item]), full=True)
        assert f"\n{TITLE}\n" in text or item.path in {*HEADLINES, *text.split()}


def test_levels_and_lags_stand_as_the_result_has_them() -> None:
    rows = table(section(roll()), "shell", "rotor", "motor torque")
    assert [int(row[0]) for row in rows] == list(range(1, 11))
    for row, level, lag in zip(rows, LEVELS, LAGS, strict=True):
        assert float(row[1]) == pytest.approx(10.0 ** (level / 20.0), rel=5e-4)
        assert row[2] == f"{level:.2f}"
        assert float(row[3]) == pytest.approx(math.degrees(lag), abs=0.0051)
        assert float(row[5]) == pytest.approx(level + 20.0 * math.log10(72.0), abs=0.0051)


@pytest.mark.parametrize("floor", [0.0, 1e-15])
def test_a_harmonic_that_vanishes_is_zero_without_lag_and_without_advice(floor: float) -> None:
    lines = section(symmetrical(floor))
    rows = table(lines, "shell", "rotor")
    for row in rows[::2]:
        assert row[1:] == ["0", "zero", "-"] * 3
    assert all("zero" not in row for row in rows[1::2])
    assert sum("nothing to lower" in line for line in lines) == 5
    for row in table(lines, "linear", "cubic")[::2]:
        assert row[1:] == ["zero"] * 4
    assert all(row[1:] == ["-", "-"] for row in table(lines, "fourier", "euler")[::2])
    # what is raised is reported of the harmonics that are there, and so is what lowers all of them
    assert not any(re.search(r"\d-?\.\d\d  *[13579]( |,|$)", line) for line in lines)
    assert any("shell inertia lowers every harmonic, by 0.86 dB" in line for line in lines)


@pytest.mark.parametrize(
    ("largest", "words"),
    [
        (0.05, "stable: of a disturbance 5.00 % is left after a turn;"),
        (0.9, "stable: of a disturbance 90.0 % is left after a turn, 1 % after 44 turns;"),
        (1.0, "neither stable nor unstable: a disturbance stays as large as it is;"),
        (1.0 + 1e-9, "UNSTABLE: a disturbance grows to 1.000 of itself in a turn;"),
        (7.5, "UNSTABLE: a disturbance grows to 7.500 of itself in a turn;"),
    ],
)
def test_stability_is_said_in_words(largest: float, words: str) -> None:
    result = changed(roll(), "response/roll/largest_multiplier", largest)
    assert words in " ".join(" ".join(section(result)).split())


def test_multipliers_are_shown_with_both_parts() -> None:
    axis = Axis(name="multiplier", values=np.arange(1, 4))
    values = quantity("response/roll/multiplier", [0.01, 0.9 + 0.3j, 0.9 - 0.3j], "", axis)
    result = roll()
    result.record.quantities[values.path] = values
    words = " ".join(" ".join(section(result)).split())
    assert "multipliers 0.9000 + 0.3000i, 0.9000 - 0.3000i, 0.01000; 3 more are 1" in words


def test_a_bad_method_does_not_hide_how_good_another_is() -> None:
    result = roll()
    path = "response/roll/method/difference"
    changed(result, path, result.record[path].values, error=0.5)
    assert section(result) == section(roll())
    values = np.stack([np.full(10, -4e-10), np.linspace(-0.6, 0.1, 10)])
    rows = table(section(changed(result, path, values, error=0.5)), "fourier", "euler")
    assert rows[0][1:] == ["0", "-0.600"]


def test_the_three_strongest_changes_lower_each_harmonic() -> None:
    result = roll()
    lines = advice(result)
    head = next(i for i, line in enumerate(lines) if line.strip().startswith("-----"))
    order = 0
    found: dict[int, list[tuple[str, str, float, str]]] = {}
    for line in lines[head + 1 :]:
        match = re.match(r" +(?:(\d+) +-?[\d.]+ )? *10 % (more|less) (.*?)  +(-[\d.]+) (.*)$", line)
        if match is None:
            break
        order = int(match[1] or order)
        found.setdefault(order, []).append((match[2], match[3], float(match[4]), match[5]))
    assert sorted(found) == list(range(1, 11))
    names = [parameter_words(name) for name in PARAMETERS.values]
    for j, rows in found.items():
        strongest = sorted(np.abs(SLOPES[:, j - 1]))[-3:]
        assert [row[2] for row in rows] == pytest.approx(
            -10.0 * np.array(strongest[::-1]), abs=0.0051
        )
        for sense, name, effect, raised in rows:
            slope = SLOPES[names.index(name)]
            step = 10.0 if sense == "more" else -10.0
            assert step * slope[j - 1] == pytest.approx(effect, abs=0.0051)
            assert raised == joined(ORDERS.values[step * slope >= 0.005]) or raised == "none"
            assert (raised == "none") == (not np.any(step * slope >= 0.005))


def test_changes_within_their_error_are_no_advice() -> None:
    lines = advice(with_changes(roll(), SLOPES, error=10.0))
    assert sum("nothing that can be seen" in line for line in lines) == 10
    assert not any("lowers every" in line for line in lines)
    assert advice(roll(spectra())) == []


def test_a_change_that_does_what_its_slope_does_not_is_said_to_be_curved() -> None:
    assert not any("curved" in line for line in advice(roll()))
    bent = roll()
    path = "response/roll/sensitivity/ten_percent_more"
    values = 10.0 * SLOPES
    values[0, 0] = -9.0
    text = " ".join(" ".join(advice(changed(bent, path, values, error=1e-7))).split())
    assert f"10 % more {parameter_words(PARAMETERS.values[0])} (curved) -9.00" in text
    assert text.count("(curved)") == 1 and "does the opposite" in text


def test_a_change_without_a_running_state_is_named_and_not_advised() -> None:
    result = roll()
    path = "response/roll/sensitivity/ten_percent_less"
    left = Axis(name="parameter", values=np.delete(PARAMETERS.values, 2))
    result.record.quantities[path] = quantity(
        path, -10.0 * np.delete(SLOPES, 2, axis=0), "dB", left, ORDERS, error=1e-7
    )
    lines = advice(result)
    words = f"10 % less {parameter_words(PARAMETERS.values[2])}"
    assert [line for line in lines if words in line] == [
        f"  - no running state was found with {words}"
    ]


def test_changes_that_are_not_known_are_no_advice_and_hide_no_others() -> None:
    values = SLOPES.copy()
    values[:, 3] = np.nan
    lines = advice(with_changes(roll(), values, error=np.inf))
    assert sum("nothing that can be seen" in line for line in lines) == 1
    assert sum("more shell inertia " in line for line in lines) > 5


@given(st.sets(st.integers(1, 60), max_size=40))
def test_joined_orders_can_be_read_back(orders: set[int]) -> None:
    back: list[int] = []
    for word in filter(None, joined(sorted(orders)).split(", ")):
        ends = [int(end) for end in word.split(" to ")]
        back += range(ends[0], ends[-1] + 1)
    assert back == sorted(orders)


@given(st.floats(0.0, 2.0 * math.pi))
def test_a_lag_is_never_a_whole_turn(lag: float) -> None:
    shown = float(lag_degrees(lag))
    assert 0.0 <= shown < 360.0
    off = (shown - math.degrees(lag) + 180.0) % 360.0 - 180.0
    assert abs(off) <= 0.0051


@given(st.floats(-400.0, 400.0))
def test_a_level_has_two_decimals_and_no_negative_zero(level: float) -> None:
    shown = decibels(level)
    assert abs(float(shown) - level) <= 0.0051
    assert re.fullmatch(r"-?\d+\.\d\d", shown) and shown != "-0.00"
