"""Claim: the text report has stable digits, says what it has and nothing more.

No line is wider than 100 columns, equal results give equal text, values within their error print
as 0, infinite ones in words, and results that no section knows appear without a change here.
"""

import io
import math
import re
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from long_but import long_but
from report_samples import generator, generator_case, golden, quantity, result_of, rigid_body
from rich.console import Console

from vibecalc.core.report.brief import lines_of
from vibecalc.core.report.sections import largest_of
from vibecalc.core.report.terminal import plain_summary, summary
from vibecalc.core.report.text import render_report, render_verdicts, report_lines, sections_of
from vibecalc.core.report.writing import Column, Table, fold, show, show_percent, show_phase, table
from vibecalc.core.results.catalogue import CATALOGUE, HEADLINES
from vibecalc.core.results.named import named
from vibecalc.core.results.record import Axis, Record
from vibecalc.units import TABLE, convert


def test_what_changes_from_run_to_run_stands_at_the_end() -> None:
    first = replace(generator(), provenance={"host": "here"}, timings={"excitation": 1.0})
    second = replace(first, provenance={"host": "elsewhere"}, timings={"excitation": 9.0})
    parts = [render_report(one, full=True).split("Provenance") for one in (first, second)]
    assert parts[0][0] == parts[1][0]
    assert parts[0][1] != parts[1][1]
    assert render_report(first) == render_report(second)


@pytest.mark.parametrize("name", ["absorber_mass", "generator", "engine_geared", "genset_on_deck"])
def test_a_brief_report_is_as_long_as_its_case_and_names_what_it_leaves_out(name: str) -> None:
    result = golden(name)
    brief = render_report(result)
    assert brief.count("\n") <= lines_of(result.case) <= 90
    last = " ".join(brief.rpartition("`vibecalc report --full` adds: ")[2].split())
    made = (named(where)(result) for where in sections_of(result.record))
    for one in (section for section in made if section is not None):
        assert not one.lines or f"\n{one.title}\n--" in brief or one.title in last
        assert not one.detail or one.detail_name in last


def test_unknown_results_show_up_without_changes() -> None:
    record = Record()
    record.add(quantity("torsion/largest_stress", 41.25e6, "Pa"))
    masses = Axis(name="station", values=np.array(["damper", "flywheel"], dtype=object))
    record.add(quantity("torsion/twist", [1e-3, 2e-3], "rad", masses))
    record.add(quantity("torsion/map", np.ones((2, 2)), "rad", masses, masses))
    text = render_report(result_of(record, generator_case()), full=True)
    assert re.search(r"largest stress, torsion +41\.25 +N/mm\^2", text)
    assert re.search(r"flywheel +0\.1146", text)
    assert "in the result file only: torsion/map" in text


@given(st.floats(-1e307, 1e307), st.integers(3, 9))
def test_shown_numbers_hold_their_digits(value: float, digits: int) -> None:
    text = show(value, digits=digits)
    if abs(value) > 1e-300:
        assert abs(float(text) - value) <= 0.5001 * 10.0 ** (1 - digits) * abs(value)
    mantissa = text.split("e")[0].lstrip("-").replace(".", "").lstrip("0")
    assert value == 0.0 or len(mantissa) == max(digits, len(text.split(".")[0].lstrip("-")))


@given(st.floats(1e-12, 1e12), st.floats(0.0, 1.0))
def test_what_is_within_its_error_is_zero(error: float, share: float) -> None:
    assert show(share * error, error) == "0"
    assert show(-share * error, error) == "0"
    assert show(complex(0.0, share * error), error) == "0"
    assert show_phase(complex(0.0, share * error), error) == "-"
    assert show(2.0 * error, error) != "0"


def test_special_values_have_words() -> None:
    assert show(math.inf) == "unbounded"
    assert show(-math.inf) == "-unbounded"
    assert show(math.nan) == "undefined"
    assert show(np.int64(12345678)) == "12345678"
    assert show(3.5, error=math.inf) == "3.500"
    assert show_percent(None) == "-"
    shares = {-1e-9: "0.0000", 0.012345: "+1.23", -0.99999: "-100.0", 22.229: "+2223"}
    assert {one: show_percent(one) for one in shares} == {k: f"{v} %" for k, v in shares.items()}
    assert (show_percent(380.0), show_percent(1.0e9)) == ("factor 381", "factor 1.0e+09")
    assert show_phase(-1.0 + 1e-17j) == show_phase(-1.0 - 1e-17j) == "180.00"
    assert show_phase(1.0 - 1e-17j) == "0.00"


@given(st.lists(st.floats(), min_size=1, max_size=25), st.booleans())
def test_no_number_is_broken_and_no_table_wider_than_its_numbers_ask(
    values: list[float], right: bool
) -> None:
    shown = [show(value, digits=6) for value in values]
    columns = [Column("a long name")]
    columns += [Column("of", right)] * len(shown)
    rows = [["name " * 8, *shown], ["x" * 70, *shown[::-1]]]
    (block,) = table(columns, rows, [["all", *shown]])
    words = block.split()
    numbers = [one for one in shown if one[-1].isdigit()] + (shown if right else [])
    assert all(words.count(one) >= 3 for one in numbers)
    assert all(len(line) <= 100 for line in block.split("\n"))


@pytest.mark.parametrize(
    "name",
    long_but(
        ["marine_propulsion", "engine_v8", "genset_coupling", "generator_mount_design",
         "roll_startup", "roll_control", "absorber_damped", "compressor_impact", "balance_v8",
         "genset_points"],
        "genset_coupling", "roll_control", "compressor_impact",
    ),
)  # fmt: skip
def test_every_table_has_room_for_numbers_with_long_exponents(name: str) -> None:
    """Real ones and errors of a golden result, as small as they go: no number is broken."""
    result = golden(name)
    for path, one in result.record.quantities.items():
        if np.asarray(one.values).dtype.kind in "fc":
            small = {"values": one.values * 1.234567e-123, "error_estimate": 0.0}
            result.record.quantities[path] = replace(one, **small)
    text = plain_summary(result) + render_report(result, full=True)
    assert len(re.findall(r"\de-1[0-9]{2}\b", text)) > 3
    text = re.sub(r"(?m)^ +sha256 .*$", "", text)
    # where a number was broken, a line of a cell ends or begins within it
    assert not re.search(r"(?m)\de-?(\s|$)|(^|\s)e-\d", text)


@given(st.text(st.characters(codec="ascii", exclude_categories=["C"])), st.integers(3, 40))
def test_folding_keeps_every_letter(text: str, width: int) -> None:
    lines = fold(text, width)
    assert all(len(line) <= width for line in lines)
    assert "".join(lines).replace(" ", "") == text.replace(" ", "")


def test_the_terminal_shows_what_differs_and_the_report_everything() -> None:
    row = {"quantity": "isolation/couple_over_lever/blocked_peak", "source": "Graph 1"}
    rows = [{**row, "value": "9329 N"}] * 30 + [{**row, "value": "9000 N"}]
    result = generator(reference=rows)
    brief, some = plain_summary(result), render_report(result)
    all_of_it = render_report(result, full=True)
    assert (some.count(" within"), "match: Graph 1 (30)" in some) == (0, True)
    assert (some.count("OUTSIDE"), some.count("MISSED")) == (1, 0)
    assert (brief.count(" within"), brief.count("OUTSIDE")) == (0, 1)
    # what is missed stands on top as well
    assert (all_of_it.count(" within"), all_of_it.count("OUTSIDE")) == (30, 2)


def test_verdicts_name_every_miss() -> None:
    path = "isolation/couple_over_lever/steady_peak"
    limit = [{"quantity": path, "max": "97 N"}, {"quantity": path, "max": "99 N"}]
    text = render_verdicts(generator(limit=limit))
    assert max(len(line) for line in text.splitlines()) <= 100
    assert text.count("MISSED") == 1
    assert f"MISSED limit on {path} is broken: 97.9987 N, margin -0.999" in text
    assert "1 of 2 limits is kept" in text


def test_verdicts_have_speeds_in_rpm_and_frequencies_in_hertz() -> None:
    """As reports do, also where the result is largest; the case may give them in rad/s."""
    peak = "isolation/couple_over_lever/run_up_peak_speed"
    mode, force = "isolation/pitch/natural_frequency", "isolation/couple_over_lever/run_up"
    rows = {peak: {"max": "30 rad/s"}, mode: {"min": 40.0}, force: {"max": "0.01 kN"}}
    limits = [{"quantity": path, **bound} for path, bound in rows.items()]
    result = generator(limit=limits, reference=[])
    text = render_verdicts(result)
    assert "rad/s" not in text
    speed, frequency = (float(result.record[path].values) for path in (peak, mode))
    shown = f"{speed * 30.0 / np.pi:.6g} rpm, margin {(30.0 - speed) * 30.0 / np.pi:.3g}"
    assert f"MISSED limit on {peak} is broken: {shown}" in text
    shown = f"{frequency / (2.0 * np.pi):.6g} Hz, margin {(frequency - 40.0) / (2.0 * np.pi):.3g}"
    assert f"MISSED limit on {mode} is broken: {shown}" in text
    assert "worst speed=" in text


@pytest.mark.parametrize("width", long_but([60, 80, 100], 60))
def test_a_narrow_terminal_cuts_no_number_and_no_name(width: int) -> None:
    output = io.StringIO()
    summary(generator(), Console(file=output, width=width, highlight=False))
    text = output.getvalue()
    assert "\N{HORIZONTAL ELLIPSIS}" not in text
    assert max(len(line) for line in text.splitlines()) <= width
    for words in ("98.00", "5.051", "lever"):
        assert words in text


def test_the_terminal_summary_is_plain_where_there_is_no_terminal() -> None:
    output = io.StringIO()
    summary(generator(), Console(file=output, width=100))
    text = output.getvalue()
    assert "\x1b" not in text
    for words in ("98.00", "for a known reason", "34 of 34"):
        assert words in text and words in plain_summary(generator())
    assert "warning: mode 3" in plain_summary(rigid_body())
    coloured = io.StringIO()
    summary(rigid_body(), Console(file=coloured, width=100, force_terminal=True))
    assert "\x1b[" in coloured.getvalue()
    assert "warning" in coloured.getvalue()


_NUMBERS = re.compile(r"\d[\d.,]*(?:e[+-]?\d+)?")


@pytest.mark.parametrize("name", ["engine_damped", "genset_on_deck"])
def test_a_narrow_screen_breaks_no_number(name: str) -> None:
    for block in report_lines(golden(name), full=True):
        if isinstance(block, Table):
            shown = block.at(60)
            assert max(map(len, shown.split("\n"))) <= 60
            cells = (cell for row in (*block.rows, *block.totals) for cell in row)
            said = Counter(one for cell in cells for one in _NUMBERS.findall(cell))
            assert not said - Counter(_NUMBERS.findall(shown))


def test_headlines_are_results_in_units_that_fit() -> None:
    for path, one in HEADLINES.items():
        held = CATALOGUE[path]
        # without pint, whose registry takes longer than all of a report
        assert one.unit in TABLE and (not one.unit or held.unit in TABLE), path
        assert math.isfinite(convert(1.0, held.unit, one.unit or held.unit)), path
        assert {one.at, one.unless} - {""} <= set(CATALOGUE), path
        assert one.pick in ("largest", "least", "each", "first", "ends", "elastic", "present"), path


@pytest.mark.parametrize(
    ("values", "largest"),
    [
        ([-3.0, 2.0], -3.0), ([2.0, -1.0], 2.0), ([-5.0, -4.0], -5.0), ([0.0, -0.0], 0.0),
        ([1.0, -1.0 - 1e-12], 1.0), ([-np.inf, 1.0], -np.inf),
    ],
)  # fmt: skip
def test_the_largest_of_an_array_keeps_its_sign(values: list[float], largest: float) -> None:
    """Both signs of one size, as rounding leaves them, are the positive one on every processor."""
    assert largest_of(np.array(values)) == largest


def test_on_a_foundation_modes_and_displacements_say_what_they_are_of() -> None:
    """Modes of body and foundation together, and the body itself or relative to the foundation."""
    text = " ".join(render_report(golden("genset_on_deck"), full=True).split())
    assert "coupled mode: counted in the table of machine and foundation" in text
    assert "static, total: deflection, of the body relative to the foundation" in text
    assert "relative to the foundation" not in render_report(generator(), full=True)
