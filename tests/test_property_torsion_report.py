"""Claim: the report on a shaft line says what the result has.

Verdicts follow the uses of the limits, tables add up where they have to, what is missing is left
out. What it says of golden results is held by `test_golden.py`.
"""

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from engine_cases import ENGINE, ran
from report_samples import golden, quantity

from vibecalc.core.report.headline import headline_rows
from vibecalc.core.report.text import render_report
from vibecalc.core.results.record import Axis, Record, Result
from vibecalc.core.run.stage import Harmonics
from vibecalc.numerics.rounding import first_of_largest, firsts_of_largest, ranked
from vibecalc.torsion.report.first_page import barred, conclusion
from vibecalc.torsion.report.limits import flags
from vibecalc.torsion.report.line import orders_words, within

ROOT = "response/torsion/"


LIMIT = """[[response.torsion.limits]]
curve = { speed = ["800 rpm", "1000 rpm", "1001 rpm", "2000 rpm"], stress = [9e6, 9e6, 99e6, 99e6] }
"""


def three() -> Result:
    """Three cylinders with a ring in front, over a range of speeds, with a limit."""
    return ran(ENGINE + LIMIT)


def changed(result: Result, **values: Any) -> Result:
    """A copy with other values; `__` stands for `/` in a path, None takes the quantity away."""
    record = Record(quantities=dict(result.record.quantities))
    for name, value in values.items():
        path = ROOT + name.replace("__", "/")
        old = record.quantities.pop(path)
        if value is not None:
            record.add(quantity(path, np.asarray(value), old.unit, *old.axes))
    return replace(result, record=record, verdicts=None)


def section(text: str, title: str) -> list[str]:
    """Lines below a title, up to the next one."""
    lines = text.splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith(title)) + 2
    rest = lines[start:]
    end = next((i for i, line in enumerate(rest) if re.fullmatch(r"-{3,}", line)), len(rest) + 1)
    return rest[: end - 1]


def row(lines: list[str], start: str, which: int = 0) -> list[str]:
    """Words of a line that starts with `start`."""
    found = [line for line in lines if " ".join(line.split()).startswith(start)]
    return found[which].split()


@pytest.mark.parametrize(
    ("largest", "operating", "transient", "verdict", "words"),
    [
        (0.9, 0.5, 0.5, "kept", "within the limit"),
        (1.2, 0.5, 0.7, "barred", "within the limit"),
        (1.2, 1.1, 0.7, "BROKEN", "exceeds limit 1 at the operating speed"),
        (2.2, 0.5, 1.3, "BROKEN", "exceeds limit 1 even for passage"),
        (2.2, 1.4, 1.3, "BROKEN", "at the operating speed and even for passage"),
    ],
)
def test_verdicts_follow_the_uses(
    largest: float, operating: float, transient: float, verdict: str, words: str
) -> None:
    uses = {
        "each/utilisation": largest,
        "operating/utilisation": operating,
        "each/passage_utilisation": transient,
    }
    shape = np.ones_like(three().record[f"{ROOT}limit/each/utilisation"].values)
    result = changed(three(), **{
        f"limit__{name.replace('/', '__')}": use * shape for name, use in uses.items()
    })  # fmt: skip
    assert flags(result) == [verdict]
    assert words in conclusion(result)


def test_a_limit_on_a_stress_is_told_where_no_rule_bars_speeds() -> None:
    """The page that shows a `[[limit]]` as broken does not say that there is none."""
    largest = f"{ROOT}largest/stress_half_range"
    case = {**three().case, "limit": [{"quantity": largest, "max": "1 MPa"}]}
    kept = Record(quantities={
        path: one for path, one in three().record.items() if "limit/" not in path
    })  # fmt: skip
    result = replace(three(), case=case, record=kept, verdicts=None)
    said = "The limit on the largest vibratory stress is BROKEN"
    assert conclusion(result).startswith(said)
    told = " ".join(barred(result))
    assert said in told and "no speed range is barred" in told
    without = replace(result, case={**case, "limit": []}, verdicts=None)
    assert "The case sets no stress limit" in conclusion(without)


def test_gears_that_hammer_inside_the_range_are_named_with_the_range() -> None:
    """Still in contact at the operating speed is no pass for the range."""
    geared = golden("engine_geared")
    hammers = np.zeros_like(geared.record[ROOT + "speeds/gear_hammers"].values)
    hammers[1, 20] = 1
    least = {"largest__gear_minimum_torque": [1.0, -1.0]}
    result = changed(geared, gear__hammers=[0, 0], speeds__gear_hammers=hammers, **least)
    for name in ("from", "to", "gear"):
        result.record.quantities.pop(f"{ROOT}hammering/{name}")
    axis = Axis(name="hammering", values=np.array([1]))
    for name, value in (("from", 50.0), ("to", 52.0), ("gear", 2)):
        result.record.add(quantity(f"{ROOT}hammering/{name}", [value], "rad/s", axis))
    assert "gear hammer in 'power take-off' from 477.5 to 496.6 rpm" in conclusion(result)
    assert "at the operating speed" not in conclusion(result).split("hammer")[1]


@pytest.mark.parametrize(
    ("value", "error", "words"),
    [(40.0, 19.6, "40 +- 20"), (49.82, 28.6, "50 +- 30"), (33.2312, 1e-9, "33.23"),
     (0.1234, 0.0021, "0.123 +- 0.003"), (-5.1, 0.2, "-5.1 +- 0.2"),
     (1234.0, 0.51, "1234.0 +- 0.6"), (3.0, 4.0, "0")],
)  # fmt: skip
def test_a_number_shows_no_digit_that_its_error_hides(
    value: float, error: float, words: str
) -> None:
    assert within(value, error) == words


def test_what_nothing_damps_is_unbounded_and_said() -> None:
    worst = np.array(three().record[ROOT + "largest/torque_half_range"].values)
    worst[2] = np.inf
    result = changed(three(), largest__torque_half_range=worst)
    axis = Axis(name="resonance_skipped", values=np.array([1]))
    for name, value in (("from", 50.0), ("to", 50.1), ("mode", 3), ("order", 3.0)):
        result.record.quantities.pop(f"{ROOT}resonances_skipped/{name}")
        result.record.add(quantity(f"{ROOT}resonances_skipped/{name}", [value], "rad/s", axis))
    text = render_report(result, full=True)
    assert "unbounded" in " ".join(row(section(text, "Vibration over the speed range"), "rear"))
    assert "No damping at 477.5 to 478.4 rpm (1-node, order 3)" in text
    assert "undamped" in conclusion(result)


def test_the_reduction_told_first_is_that_of_the_section_that_bears_most_without_dampers() -> None:
    """The least of all is often that of a section with hardly any torque."""
    axis, record = Axis(name="section", values=np.array(["nose", "rear"])), Record()
    record.add(quantity(f"{ROOT}reduction", [0.7, 3.0], "", axis))
    (least,) = headline_rows(record)
    assert least.where == "section nose"
    bare = f"{ROOT}without_dampers/largest/torque_half_range"
    record.add(quantity(bare, [10.0, 900.0], "N*m", axis))
    (governing,) = (one for one in headline_rows(record) if one.path == f"{ROOT}reduction")
    assert (governing.where, governing.value) == ("section rear", 3.0)


@pytest.mark.parametrize(("stiffness", "count"), [(0.0, 0), (2e5, 1)])
def test_a_damper_without_springs_has_no_row_of_them(stiffness: float, count: int) -> None:
    path, record = "damper_design/stiffness", Record()
    record.add(quantity(path, stiffness, "N*m/rad"))
    record.add(quantity("damper_design/damping_ratio", 0.3 if stiffness else np.inf, ""))
    record.add(quantity("damper_design/damping", 50.0, "N*m*s/rad"))
    assert sum(one.path == path for one in headline_rows(record)) == count
    told = section(
        render_report(replace(three(), record=record, verdicts=())), "Design of the damper"
    )
    assert sum("stiffness" in line for line in told) == count
    assert sum("damping ratio" in line for line in told) == count
    assert any("damping  " in line for line in told)


@pytest.mark.parametrize(
    ("orders", "words"),
    [
        ([0.5, 1.0, 1.5], "orders 0.5 to 1.5 every 0.5"), ([4.0], "order 4"),
        ([1.0, 2.0, 3.0, 4.04], "orders 1, 2, 3 and 1 of other shafts or constant frequencies"),
        ([0.561, 1.0, 1.122, 12.0], "orders 1, 12 and 2 of other shafts or constant frequencies"),
        (
            [1, 2, 3, 4, 5, 6, 7, 7.3],
            "orders up to 7 and 1 of other shafts or constant frequencies",
        ),
        ([1.5, 3.0, 6.0], "orders 1.5, 3 and 6"),
    ],
)  # fmt: skip
def test_orders_are_named_that_are_whole_or_half(orders: list[float], words: str) -> None:
    assert orders_words(np.array(orders)) == words
    number = Harmonics(len(orders), orders[0], orders[-1], "rule").words()
    assert ("up to" in number) == (len(orders) > 1 and "every" not in words)


def test_of_conditions_that_are_equal_but_for_rounding_the_first_is_named() -> None:
    """As of cylinders that are equal by symmetry: no word hangs on the last digits."""
    reports = []
    for last_digits in (1.0 - 1e-12, 1.0 + 1e-12):
        result = golden("marine_propulsion")
        for path, one in result.record.items():
            if one.axes and one.axes[0].name == "condition" and one.values.dtype.kind == "f":
                values = np.repeat(one.values[1:2], len(one.values), axis=0)
                values[3] *= last_digits
                result.record.quantities[path] = replace(one, values=values)
        reports.append(render_report(replace(result, verdicts=None), full=True))
    assert reports[0] == reports[1]
    assert "misfire of cylinder 3 (worst of" not in reports[0]


def test_equal_sections_swap_no_names() -> None:
    load = np.array([[1.0, 2.0, 2.0 + 1e-12], [3.0, 3.0 - 1e-12, 1.0], [np.inf, 1.0, np.inf]])
    assert firsts_of_largest(load, axis=1).tolist() == [1, 0, 0]
    assert [first_of_largest(one) for one in load] == [1, 0, 0]
    assert firsts_of_largest(-load, axis=0).tolist() == [0, 2, 1]
    assert first_of_largest([2.0, 2.0 + 1e-8]) == 1
    assert ranked([1.0, np.inf, 2.0, 2.0 + 1e-12, np.inf, 3.0]).tolist() == [1, 4, 5, 2, 3, 0]
    assert ranked([]).size == 0
