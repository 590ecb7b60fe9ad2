"""Claim: references and limits are judged as the conventions say, whatever way they are written.

The default tolerance is half a unit of the last printed digit; units convert; complex quantities
count by magnitude; measured numbers and known differences are shown and never counted; of an
array the worst entry is held against a limit and named.
"""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from report_samples import MOUNTS, ORDERS, generator_case, quantity, result_of

from vibecalc.core.report.pages import difference, references
from vibecalc.core.report.verdicts import judge_references, misses
from vibecalc.core.results.printed import read_printed
from vibecalc.core.results.record import Record, Result, Verdict
from vibecalc.core.results.verdicts import verdicts_of
from vibecalc.errors import ResultError

PATH = "isolation/couple_over_lever/steady_peak"


def with_value(value: Any, unit: str = "N", error: float | None = None, **tables: Any) -> Result:
    record = Record()
    axes = (MOUNTS,) if np.size(value) == 4 else (ORDERS,) if np.size(value) == 2 else ()
    record.add(quantity(PATH, value, unit, *axes, error=error))
    return result_of(record, generator_case(**tables))


def judged(value: Any, row: dict[str, Any], unit: str = "N") -> Any:
    entry = {"quantity": PATH, "source": "a table", **row}
    return judge_references(with_value(value, unit, reference=[entry]))[0]


def limited(value: Any, row: dict[str, Any], unit: str = "N", error: float = 0.0) -> Any:
    return verdicts_of(with_value(value, unit, error, limit=[{"quantity": PATH, **row}]))[0]


@pytest.mark.parametrize(
    ("value", "half_unit"),
    [
        ("93 N", 0.5),
        ("0.079", 0.0005),
        ("31.74 rad/s", 0.005),
        (".0021 m", 0.00005),
        (8209, 0.5),
        (8209.0, 0.5),
        (0.079, 0.0005),
        ("8209.0", 0.05),
        ("1e-3", 0.0005),
        ("1.20e-3 m", 5e-6),
        ("12e2 N", 50.0),
        ("1_000.50", 0.005),
        ("-0.30", 0.005),
    ],
)
def test_half_a_unit_of_the_last_digit(value: float | str, half_unit: float) -> None:
    assert read_printed(value).half_unit == pytest.approx(half_unit, rel=1e-15)


@given(
    st.integers(-(10**6), 10**6), st.integers(0, 8), st.floats(-0.499, 0.499), st.floats(0.501, 50)
)
def test_what_rounds_to_the_printed_value_is_within(
    digits: int, decimals: int, inside: float, outside: float
) -> None:
    printed = f"{digits / 10**decimals:.{decimals}f} N"
    step = 10.0**-decimals
    assert judged(digits * step + inside * step, {"value": printed}).within is True
    assert judged(digits * step + outside * step, {"value": printed}).within is False


def test_units_convert_before_comparison() -> None:
    row = judged(0.00211739, {"value": "2.1 mm"}, "m")
    assert (row.unit, row.within) == ("mm", True)
    assert row.computed == pytest.approx(2.11739, rel=1e-14)
    assert row.tolerance == pytest.approx(0.05, rel=1e-14)
    speed = judged(32.03, {"value": 305.9, "unit": "rpm", "atol": "0.1 rpm"}, "rad/s")
    assert speed.unit == "rpm"
    assert speed.computed == pytest.approx(305.86, abs=0.01)
    assert speed.within is True


def test_tolerances_given_win_over_digits() -> None:
    assert judged(97.9, {"value": "93 N", "rtol": 0.06}).within is True
    assert judged(97.9, {"value": "93 N", "rtol": 0.05}).within is False
    assert judged(97.9, {"value": "93 N", "atol": 4.0}).within is False
    assert judged(97.9, {"value": "93 N", "atol": "0.005 kN"}).within is True


def test_complex_counts_by_magnitude() -> None:
    row = judged(3.0 + 4.0j, {"value": "5 N"})
    assert (row.computed, row.within) == (5.0, True)
    assert judged([3.0j, -4.0 + 0j], {"value": "4.0", "where": {"order": 2}}).within is True


def test_measured_and_known_rows_are_shown_and_never_counted() -> None:
    measured = judged(98.0, {"value": "50 N", "kind": "measured"})
    known = judged(98.0, {"value": "93 N", "known_difference": "a slip"})
    assert (measured.verdict, measured.within, measured.agrees) == ("measured", None, False)
    assert (known.verdict, known.within, known.agrees) == ("known difference", None, False)
    assert judged(98.0, {"value": "98 N", "known_difference": "a slip"}).agrees is True
    assert misses([measured, known], []) == []


def test_a_miss_is_counted_with_its_numbers() -> None:
    found = misses([judged(98.0, {"value": "93 N"})], [])
    assert len(found) == 1
    for word in (PATH, "93 N", "98", "0.5", "a table"):
        assert word in found[0]


def test_an_infinite_result_is_outside() -> None:
    row = judged(np.inf, {"value": "93 N"})
    assert (row.within, row.relative_difference) == (False, None)


def test_what_does_not_exist_is_said() -> None:
    with pytest.raises(ResultError, match=r"couple_over_lever/steady_pek.*nearest.*steady_peak"):
        judge_references(
            with_value(1.0, reference=[{"quantity": PATH[:-2] + "k", "value": 1, "source": "x"}])
        )
    with pytest.raises(ResultError, match="order"):
        judged([1.0, 2.0], {"value": "1 N", "where": {"order": 7}})
    with pytest.raises(ResultError, match=r"\[\[limit\]\].*no_such"):
        verdicts_of(with_value(1.0, limit=[{"quantity": "no_such/path", "max": 1.0}]))
    with pytest.raises(ResultError, match=r"2 entries.*order"):
        judged([1.0, 2.0], {"value": "1 N"})


def test_start_is_looked_up_below_the_start() -> None:
    record = Record()
    record.add(quantity(PATH, 10.0, "N"))
    record.add(quantity("optimisation/start/" + PATH, 93.2, "N"))
    rows = [
        {"quantity": PATH, "value": "93 N", "source": "s", "at": "start"},
        {"quantity": PATH, "value": "10 N", "source": "s"},
    ]
    limits = [{"quantity": PATH, "max": "50 N", "at": "start"}, {"quantity": PATH, "max": "50 N"}]
    result = result_of(record, generator_case(reference=rows, limit=limits))
    assert [row.within for row in judge_references(result)] == [True, True]
    assert [row.kept for row in verdicts_of(result)] == [False, True]


@given(st.lists(st.floats(-1e6, 1e6), min_size=4, max_size=4), st.floats(-1e6, 1e6))
def test_the_worst_entry_of_an_array_counts_and_is_named(values: list[float], bound: float) -> None:
    top = limited(values, {"max": bound})
    bottom = limited(values, {"min": bound})
    assert top.computed == max(values)
    assert bottom.computed == min(values)
    assert top.label == f"mount={1 + values.index(max(values))}"
    last_bits = 1e-15 * abs(bound)
    assert top.kept == all(value <= bound + last_bits for value in values)
    assert bottom.kept == all(value >= bound - last_bits for value in values)
    assert top.margin == pytest.approx(bound - max(values), abs=1e-9)


def test_where_narrows_what_a_limit_sees() -> None:
    row = limited([1.0, 9.0, 2.0, 3.0], {"max": 5.0, "where": {"mount": "3"}})
    assert (row.computed, row.kept) == (2.0, True)


@pytest.mark.parametrize(
    ("value", "error", "state"),
    [
        (461.6, 145.0, "undecided"),
        (361.6, 145.0, "undecided"),
        (361.6, 38.3, "kept"),
        (461.6, 61.5, "broken"),
        (523.7, 1e-9, "broken"),
        (400.0, 0.0, "kept"),
        (400.0, 3e-8, "kept"),  # on the bound to ten digits, which it is not written with
        (400.0, 3e-7, "undecided"),
        (400.0 + 1e-9, 2e-9, "kept"),
        (400.0 + 1e-7, 2e-7, "undecided"),
        (400.0 + 1e-9, 0.5e-9, "broken"),
        (120.0, math.inf, "undecided"),
    ],
)
@pytest.mark.parametrize("expect", ["kept", "broken"])
def test_the_whole_interval_decides(value: float, error: float, state: str, expect: str) -> None:
    rows = (
        limited(value, {"max": "400 N", "expect": expect}, error=error),
        limited(-value, {"min": "-0.4 kN", "expect": expect}, error=error),
    )
    for row in rows:
        assert row.state == state
        assert row.satisfied == (state == expect)
        assert bool(misses([], [row])) == (state != expect)
        assert bool(row.decided_by) == (state == "undecided")


def test_what_is_zero_to_rounding_of_its_terms_is_held_as_zero() -> None:
    def held(terms: float, error: float) -> Verdict:
        result = with_value(3e-12, "N", error, limit=[{"quantity": PATH, "max": 0.0}])
        one = replace(result.record[PATH], terms=terms)
        result.record.quantities[PATH] = one
        return verdicts_of(result)[0]

    assert (held(1e3, 9e-11).state, held(1e3, 9e-11).computed) == ("kept", 0.0)
    assert held(0.0, 9e-11).state == "undecided"
    assert held(1e3, 1e-5).state == "undecided"


def test_what_would_decide_follows_from_the_case_and_the_stage() -> None:
    def decided_by(path: str, value: float = 461.6, **tables: Any) -> str:
        record = Record()
        record.add(quantity(path, value, "N", error=145.0))
        row = {"quantity": path, "max": 400.0}
        return verdicts_of(result_of(record, generator_case(limit=[row], **tables)))[0].decided_by

    few = decided_by("excitation/couple_peak", excitation={"orders": 1})
    assert few == "more orders in [excitation] (now 1)"
    assert "a smaller [accuracy] rtol" in decided_by("excitation/couple_peak", excitation={})
    assert "rtol" in decided_by("response/torsion/torque_peak", excitation={"orders": 1})


def test_a_reference_that_its_error_exceeds_is_unresolved() -> None:
    row = {"quantity": PATH, "value": "196 N", "source": "s"}
    wide = judge_references(with_value(196.2, "N", 722.0, reference=[row]))[0]
    assert (wide.within, wide.verdict, wide.resolved) == (False, "unresolved", False)
    assert "196.2 +-722, unresolved" in misses([wide], [])[0]
    row = {"quantity": PATH, "value": "0 N", "atol": "1 N", "source": "s"}
    narrow = judge_references(with_value(0.3, "N", 0.5, reference=[row]))[0]
    assert (narrow.within, narrow.resolved) == (True, False)


def test_both_sides_of_a_limit_and_units() -> None:
    row = limited(250.0, {"max": "0.3 kN", "min": "100 N"})
    assert (row.unit, row.min, row.max) == ("kN", pytest.approx(0.1), pytest.approx(0.3))
    assert row.margin == pytest.approx(0.05)
    low = limited(90.0, {"max": "300 N", "min": "100 N"})
    assert low.kept is False
    assert low.margin == pytest.approx(-10.0)


def test_an_infinite_value_breaks_a_maximum() -> None:
    row = limited([1.0, np.inf, 2.0, 3.0], {"max": "400 N"})
    assert (row.kept, row.margin, row.label) == (False, -math.inf, "mount=2")
    assert limited([1.0, np.nan, 2.0, 3.0], {"max": "400 N"}).kept is False
    assert limited([1.0, np.nan, 2.0, 3.0], {"min": "0 N"}).kept is False


PHASE = "response/roll/phase_lag/shell_acceleration"


def judged_phase(value: float, row: dict[str, Any], path: str = PHASE) -> Any:
    record = Record()
    record.add(quantity(path, value, "rad"))
    entry = {"quantity": path, "source": "a table", **row}
    return judge_references(result_of(record, generator_case(reference=[entry])))[0]


@given(st.floats(0.0, 6.2), st.floats(-3.1, 3.1), st.integers(-2, 2))
def test_phases_are_compared_the_shortest_way_round(value: float, apart: float, turns: int) -> None:
    printed = f"{value - apart + turns * math.tau:.4f} rad"
    row = judged_phase(value, {"value": printed})
    assert row.cyclic and row.difference == pytest.approx(apart, abs=6e-5)
    assert row.agrees == (abs(row.difference) <= row.tolerance)
    assert float(difference(row).split()[0]) == pytest.approx(math.degrees(apart), abs=0.06)


def test_a_phase_on_the_other_side_of_zero_is_near() -> None:
    row = judged_phase(0.0603, {"value": "6.156 rad"})
    assert difference(row) == "+10.7 deg"
    assert judged_phase(0.0603, {"value": "352.7 deg"}).difference == pytest.approx(10.8, abs=0.1)
    assert judged_phase(0.0001, {"value": "360.0 deg"}).agrees
    # an angle that is no phase, and how uncertain one is, have no whole turns to spare
    for path in ("response/start_up/shell_angle_peak", "measurement/uncertainty/roll_phase"):
        row = judged_phase(0.0603, {"value": "6.156 rad"}, path)
        assert not row.cyclic and row.difference == pytest.approx(-6.0957)


def test_what_cannot_be_shown_is_not_said_to_be_shown_by_it() -> None:
    entry = {"value": 9.0, "known_difference": "why", "shown_by": "not reproducible: 3 ways tried"}
    assert references([judged(8.0, entry)])[-1] == "  [1] why (not reproducible: 3 ways tried)"
    entry["shown_by"] = "tests/test_this.py::that"
    assert references([judged(8.0, entry)])[-1] == "  [1] why (shown by tests/test_this.py::that)"
