"""Claim: sweeps of the roll are shown so that orders, lines and keys can be distinguished."""

import numpy as np
import pytest
from report_samples import quantity
from shipped_cases import result_of
from sweep_views import axis_of, key, view

from vibecalc.core.report.goals import key_words
from vibecalc.core.report.headline import headline_rows
from vibecalc.core.report.sweep.statistics import extreme_lines
from vibecalc.core.report.sweep.view import SweepView
from vibecalc.core.results.record import Axis, Record

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
