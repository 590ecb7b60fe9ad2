"""Claim: words and pictures of the shell's roll say what the result has, and advise in its sense.

What is said of the shipped cases stands in snapshots; here are motions that none of them has, and
the numbers behind the words: an unstable motion is called so, for each harmonic the three
parameters that lower it most are named, with what else rises, and lines are drawn where they are.
"""

import copy
import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from report_samples import quantity
from shipped_cases import result_of
from sweep_views import axis_of, key, view

from vibecalc.core.report.goals import key_words
from vibecalc.core.report.headline import headline_rows
from vibecalc.core.report.sweep.statistics import extreme_lines
from vibecalc.core.report.sweep.view import SweepView
from vibecalc.core.report.text import render_report
from vibecalc.core.report.writing import decibels, text_of
from vibecalc.core.results.record import Axis, Record, Result
from vibecalc.roll.report import advice as advised
from vibecalc.roll.report.advice import joined, parameter_words
from vibecalc.roll.report.running import lag_degrees

ROOT = "response/roll/"
MORE, LESS = (f"{ROOT}sensitivity/ten_percent_{sense}" for sense in ("more", "less"))


def altered(path: str, values: Any, error: float = 1e-7, *axes: Axis) -> Result:
    """The shipped result with one quantity replaced."""
    found = result_of("roll")
    record = copy.copy(found.record)
    old = record[path]
    record.quantities = record.quantities | {
        path: quantity(path, values, old.unit, *(axes or old.axes), error=error)
    }
    return replace(found, record=record)


def words_of(result: Result) -> str:
    return " ".join(render_report(result, full=True).split())


def advice(result: Result) -> list[str]:
    blocks = advised.advice(result)
    return text_of(blocks).splitlines() if blocks else []


@pytest.mark.parametrize(
    ("largest", "words"),
    [
        (0.05, "stable: disturbances decay to 5.00 % in a turn;"),
        (0.9, "stable: disturbances decay to 90.0 % in a turn, to 1 % in 44 turns;"),
        (1.0, "marginally stable: disturbances neither grow nor decay;"),
        (1.0 + 1e-9, "UNSTABLE: disturbances grow by a factor of 1.000 per turn;"),
        (7.5, "UNSTABLE: disturbances grow by a factor of 7.500 per turn;"),
    ],
)
def test_stability_is_said_in_words(largest: float, words: str) -> None:
    assert words in words_of(altered(f"{ROOT}largest_multiplier", largest, 1e-14))


def test_the_three_strongest_changes_lower_each_harmonic() -> None:
    result = result_of("roll")
    changes = {
        sense: result.record[path].values for sense, path in (("more", MORE), ("less", LESS))
    }
    names, orders = (axis.values for axis in result.record[MORE].axes)
    known = [parameter_words(name) for name in names]
    order, seen = 0, 0
    for line in advice(result):
        match = re.match(
            r" +(?:(\d+) +-?[\d.]+ )? *10 % (more|less) (.*?)(?: \(curved\))?  +(-[\d.]+) +(.*)$",
            line,
        )
        if match is None:
            continue
        place = seen % 3
        order, seen = int(match[1] or order), seen + 1
        change = changes[match[2]][known.index(match[3])]
        strongest = np.sort(np.minimum(*(one[:, order - 1] for one in changes.values())))
        assert float(match[4]) == pytest.approx(change[order - 1], abs=0.0051)
        assert float(match[4]) == pytest.approx(strongest[place], abs=0.0051)
        rises = orders[change >= 0.005]
        assert match[5] == (joined(rises) if len(rises) else "none")
    assert seen == 30


def test_changes_within_their_error_are_no_advice() -> None:
    values = result_of("roll").record[MORE].values
    record = altered(MORE, values, 100.0).record
    whole = replace(result_of("roll"), record=record)
    record.quantities[LESS] = replace(record[LESS], error_estimate=100.0)
    lines = advice(whole)
    assert sum("no noticeable effect" in line for line in lines) == 10
    assert not any("lowers every" in line for line in lines)


def test_a_change_that_does_what_its_slope_does_not_is_said_to_be_curved() -> None:
    text = " ".join(" ".join(advice(result_of("roll"))).split())
    assert "(curved)" in text
    record = result_of("roll").record
    slopes = record[f"{ROOT}sensitivity/level"].values
    straight = altered(MORE, 10.0 * slopes)
    straight.record.quantities[LESS] = replace(record[LESS], values=-10.0 * slopes)
    assert "(curved)" not in " ".join(advice(straight))


def test_a_change_without_a_running_state_is_named_and_not_advised() -> None:
    names, orders = result_of("roll").record[LESS].axes
    values = result_of("roll").record[LESS].values
    left = Axis(name="parameter", values=np.delete(names.values, 2))
    lines = advice(altered(LESS, np.delete(values, 2, axis=0), 1e-7, left, orders))
    words = f"10 % less {parameter_words(names.values[2])}"
    assert [line for line in lines if words in line] == [f"  - no running state with {words}"]


@given(st.sets(st.integers(1, 60), max_size=40))
def test_joined_orders_can_be_read_back(orders: set[int]) -> None:
    back: list[int] = []
    for word in filter(None, joined(sorted(orders)).split(", ")):
        ends = [int(end) for end in word.split(" to ")]
        back += range(ends[0], ends[-1] + 1)
    assert back == sorted(orders)


@given(st.floats(0.0, 2.0 * math.pi), st.floats(-400.0, 400.0))
def test_a_lag_is_never_a_whole_turn_and_a_level_no_negative_zero(lag: float, level: float) -> None:
    shown = float(lag_degrees(lag))
    assert 0.0 <= shown < 360.0
    off = (shown - math.degrees(lag) + 180.0) % 360.0 - 180.0
    assert abs(off) <= 0.0051
    words = decibels(level)
    assert abs(float(words) - level) <= 0.0051
    assert re.fullmatch(r"-?\d+\.\d\d", words) and words != "-0.00"


def test_a_level_of_nothing_stands_at_the_foot() -> None:
    pytest.importorskip("matplotlib")
    from drawn import figure, lines, words

    (axes,) = figure(result_of("roll_equal_pressure"), "roll_levels").axes
    orders, levels = (np.asarray(one) for one in lines(axes)["computed"].get_data())
    np.testing.assert_array_equal(orders[np.isfinite(levels)], [2, 4, 6, 8, 10])
    assert words(axes).count("zero") == 5


# ----------------------------------------------------------------------------
# Sweeps: orders, lines and keys can be distinguished.
# ----------------------------------------------------------------------------


LEVEL = "response/roll/level/shell_acceleration"
CASE = {"machine": {"crank_train": {"cylinders": [{"name": "first stage"}, {"name": "No. 2"}]}}}


def levels(values: np.ndarray) -> SweepView:
    """Levels (points, orders) over the inertia of the rotor, 1, 2, ... kg m^2."""
    inertia = key("machine.rotor.inertia", "kg*m^2", "kg*m^2")
    points = 1.0 + np.arange(len(values))
    orders = Axis(name="order", values=np.arange(1, values.shape[1] + 1))
    return view([axis_of([inertia], points[:, None])], [inertia], {LEVEL: values},
                own={LEVEL: (orders,)}, units={LEVEL: "dB"}, errors=0.0)  # fmt: skip


def test_each_order_of_a_level_has_its_own_extremes() -> None:
    lines = extreme_lines(levels(np.array([[5.0, -30.0], [4.0, -10.0], [6.0, -20.0]])))
    text = " ".join(" ".join(lines).split())
    for order, low, at_low, high, at_high in ((1, 4, 2, 6, 3), (2, -30, 1, -10, 2)):
        assert f"order {order}" in text
        assert f"smallest {low:#.4g} dB inertia = {at_low} kg*m^2" in text
        assert f"largest {high:#.4g} dB inertia = {at_high} kg*m^2" in text
    assert text.count("(order") == 0


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        (["machine.rotor.inertia"], ["rotor inertia"]),
        (["machine.shell.inertia", "machine.rotor.inertia"], ["shell inertia", "rotor inertia"]),
        (["machine.crank_train.rod_length"], ["rod length"]),
        (["machine.mounts.each.stiffness"], ["stiffness"]),
        (
            [f"machine.crank_train.cylinders[{i}].reciprocating_mass" for i in (0, 1)],
            ["reciprocating mass of first stage", "reciprocating mass of No. 2"],
        ),
        (["machine.mounts[0].stiffness", "machine.mounts[1].stiffness"],
         ["mounts[0].stiffness", "mounts[1].stiffness"]),
        (["machine.mounts.positions[2][0]", "machine.mounts.positions[3][1]"],
         ["position of mount 3 along x", "position of mount 4 along y"]),
    ],
)  # fmt: skip
def test_a_key_says_whose_it_is(keys: list[str], words: list[str]) -> None:
    assert key_words(keys, CASE) == words


def test_the_terminal_names_the_strongest_order() -> None:
    def rows(record: Record) -> list[list[str]]:
        return [row for row in headline_rows(record) if row[2] == "dB"]

    for name in ("roll", "roll_equal_pressure"):
        own = result_of(name).record[LEVEL].values
        row = rows(result_of(name).record)[0]
        assert [*row[1:4]] == [f"{max(own):.2f}", "dB", f"order {np.argmax(own) + 1}"]
    record, orders = Record(), Axis(name="order", values=np.array([1, 2]))
    for name, values in (("roll", [16.6, 7.4]), ("pitch", [-0.6, -np.inf])):
        record.add(quantity(f"measurement/{name}_level", values, "dB", orders))
    assert [[*row[1:4]] for row in rows(record)] == [
        ["16.60", "dB", "order 1"],
        ["7.40", "dB", "order 2"],
        ["-0.60", "dB", "order 1"],
        ["zero", "dB", "order 2"],
    ]
