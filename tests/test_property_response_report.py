"""Claim: the report shows energies, operations, switching and impacts as the result has them.

Tables keep to the page, what cancels is 0, the faint orders are counted and their underflow
reported, and of many references the first page shows those that matter.
"""

import re
from typing import Any

import numpy as np
import pytest
from report_samples import quantity
from response_samples import (
    by_order,
    compressor,
    impact,
    modes,
    motion,
    operations,
    response,
    switching,
)

from vibecalc.core.report.terminal import plain_summary
from vibecalc.core.report.text import render_report
from vibecalc.core.results.record import Axis, Quantity, Result
from vibecalc.impact.report import ranges
from vibecalc.response.report import SMALLEST, last_normal, main_coordinates

PARTS = {
    "Running gear": motion,
    "Response": lambda: [*modes(), *response()],
    "Operations and balances": operations,
    "Switching": switching,
    "Impacts": impact,
}


def section(result: Result, title: str) -> list[str]:
    """Lines of one section of the report."""
    lines = render_report(result, full=True).splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith(title))
    length = next(
        (i for i, line in enumerate(lines[start + 2 :]) if re.match(r"-{4,}$", line)), len(lines)
    )
    return lines[start : start + 1 + length]


def row(lines: list[str], start: str) -> list[str]:
    """Cells of the first line that begins with some words, without them."""
    found = next(line for line in lines if line.strip().startswith(start))
    return found.strip().removeprefix(start).split()


def replaced(result: Result, path: str, values: Any) -> Result:
    old = result.record.quantities[path]
    result.record.quantities[path] = quantity(path, values, old.unit, *old.axes)
    return result


def test_the_whole_page_is_narrow_clean_and_stable() -> None:
    text = render_report(compressor(), full=True)
    assert max(len(line) for line in text.splitlines()) <= 100
    assert all(line == line.rstrip() for line in text.splitlines())
    assert not re.search(r"\b(nan|inf|None|array|np\.)\b", text)
    assert text == render_report(compressor(), full=True)
    assert "Further results" not in text


@pytest.mark.parametrize("title", PARTS)
def test_a_section_appears_for_its_own_results_only(title: str) -> None:
    text = render_report(compressor(PARTS[title]()), full=True)
    assert {name for name in PARTS if f"\n{name}" in text} == {title}


@pytest.mark.parametrize("title", PARTS)
def test_each_result_alone_is_no_reason_to_fail(title: str) -> None:
    for item in PARTS[title]():
        text = render_report(compressor([item]), full=True)
        name = item.path.rsplit("/", 1)[-1]
        assert name in text or f"\n{title}" in text or "Piston motion" in text


def test_modes_say_what_moves_and_which_order_is_near() -> None:
    result = compressor()
    lines = section(result, "Response")
    natural = result.record["response/modes/natural_frequency"].values
    cells = row(lines, "1  ")
    assert float(cells[0]) == pytest.approx(natural[0] / (2.0 * np.pi), rel=5e-4)
    assert cells[2:6] == ["y", "51", "%,", "rx"]
    assert float(cells[-2]) == pytest.approx(100.0 * (361.0 / natural[0] - 1.0), abs=0.05)


def test_coordinates_are_named_until_most_of_the_energy_is() -> None:
    names = Axis(name="coordinate", values=np.array(["x", "y", "z", "rx"], object))
    mode = Axis(name="mode", values=np.array([1, 2]))
    share = quantity("share", [[0.1, 0.85, 0.05, 0.0], [0.25, 0.25, 0.25, 0.25]], "", mode, names)
    assert main_coordinates(share, 0) == "y 85 %, x 10 %"
    assert main_coordinates(share, 1) == "x 25 %, y 25 %, z 25 %"


def test_what_lies_within_its_error_is_zero_in_the_motion() -> None:
    lines = section(compressor(), "Response")
    assert row(lines, "translation peak")[:3] == ["0", "0.01460", "6.500e-05"]
    assert row(lines, "rotation peak")[:3] == ["0.7400", "0", "0.0009300"]


def test_orders_end_where_they_no_longer_count_and_their_underflow_is_reported() -> None:
    result = compressor()
    lines = section(result, "Response")
    assert [line.split()[1] for line in lines if line.strip().startswith("order ")] == ["1", "2"]
    values = result.record["response/kinetic_energy/mean_by_order"].values
    last = int(np.flatnonzero(values >= SMALLEST)[-1]) + 1
    text = " ".join(line.strip() for line in lines)
    count = int(np.count_nonzero(values >= SMALLEST)) - 2
    assert f"{count} further orders up to {last}," in text
    assert "beyond it they are below the smallest double" in text
    assert row(lines, "kinetic ")[0] == "0.006560"
    short = compressor(response())
    for path in [path for path in short.record if path.endswith("by_order")]:
        old = short.record.quantities.pop(path)
        orders = Axis(name="order", values=np.arange(1, 41))
        short.record.add(quantity(path, old.values[:40], "J", orders))
    assert "still above the smallest double" in render_report(short, full=True)


def test_an_end_by_symmetry_is_not_an_underflow() -> None:
    assert last_normal(np.array([1.0, 1e-3, 0.0])) == (1, False)
    assert last_normal(by_order(1.0))[1]
    assert last_normal(np.zeros(3)) == (-1, False)
    assert last_normal(np.array([1.0, 1e-300, 5e-324])) == (1, True)


def test_operations_show_range_difference_and_zero() -> None:
    result = compressor()
    lines = section(result, "Operations")
    text = "\n".join(lines)
    kinetic = text[text.index("kinetic energy,") :].splitlines()
    assert row(kinetic, "A ") == ["0.05364", "0.03943", "0.06804"]
    assert "(0.03218 .. 0.05900)" in text
    assert row(kinetic, "difference") == ["0.06922", "0.08459", "0.06277", "J"]
    assert row(kinetic, "weighted") == ["0.04511", "0.04914", "0.04512", "J"]
    turning = text[text.index("kinetic energy of throws") :].splitlines()
    assert row(turning, "A+B  ")[0] == "0"
    assert "0.06277 J with balance B" in " ".join(text.split())


def test_a_range_within_its_error_is_one_number() -> None:
    result = compressor(operations())
    for end in ("low", "high"):
        path = f"response/operations/kinetic_energy/mean_{end}"
        mean = result.record["response/operations/kinetic_energy/mean"].values
        replaced(result, path, mean * (1.0 + 1e-14))
    text = "\n".join(section(result, "Operations"))
    first = text[text.index("mean over a turn") : text.index("difference")]
    assert ".." not in first


def test_many_balances_are_set_below_each_other() -> None:
    names = np.array([f"weights number {i}" for i in range(16)], object)
    balances = Axis(name="balance", values=names)
    one = Axis(name="operation", values=np.array(["A"], object))
    energies = [
        quantity(f"response/operations/kinetic_energy/{what}", np.ones((1, 16)), "J", one, balances)
        for what in ("mean", "peak", "mean_low", "mean_high")
    ]
    text = render_report(compressor(energies), full=True)
    assert text.count("weights") >= 2 * len(names)
    assert max(len(line) for line in text.splitlines()) <= 100


def test_switching_is_held_against_the_steady_state() -> None:
    result = compressor()
    lines = section(result, "Switching")
    peaks = result.record["response/switching/reversal/kinetic_energy_peak"].values
    ratios = row(lines, "kinetic energy over the larger steady one")
    assert float(ratios[0]) == pytest.approx(float(peaks[0]) / 0.1074, rel=5e-3)
    assert row(lines, "crank speed then, with its sense")[1] == "-601.6"
    assert [f"{float(one):.1f}" for one in row(lines, "worst crank angle")[:2]] == ["68.8", "252.1"]
    assert row(lines, "translation peak")[1] == "y"
    assert row(lines, "time to settle, from the end of the change")[:2] == ["0.9100", "1.020"]
    passages = [line.split() for line in lines if line.startswith("  A+B to A    ")]
    orders = [int(cells[4]) for cells in passages]
    assert max(orders) == 3
    assert "14 further passages of higher order" in " ".join(" ".join(lines).split())


def test_impacts_stand_in_one_line_for_each_clearance() -> None:
    lines = section(compressor(), "Impacts")
    cells = row(lines, "0.0381")
    assert cells == ["93.90", "3.7e+01", "46.95", "169.0", "41.08", "2817", "5634"]
    text = "\n".join(lines)
    assert re.search(r"0\.00254 +210\.0 +62\.00 .* nowhere", text)
    # 10 turns to forget the start and 30 that count, and no word on what a longer run would do
    assert re.search(r"0\.254 .* > 40 +order 2 +0\n", text)
    assert "never" not in text
    assert re.search(r"0\.254 .* none seen +order 2", "\n".join(
        section(compressor(impact(), response={"impact": {"members": 64}}), "Impacts")
    ))  # fmt: skip
    assert re.search(r"crank pin +0\.0381 +103\.3", text)
    assert re.search(r"cylinder wall +0\.254 +183\.0 +2\.000", text)
    assert "64 runs of 30 turns that count" in " ".join(text.split())


def test_leaders_are_reported_as_ranges_of_orders() -> None:
    orders = np.arange(1, 11)
    assert ranges(orders, orders <= 2) == "1 to 2"
    assert ranges(orders, np.isin(orders, (1, 4, 5, 9))) == "1, 4 to 5, 9"
    assert ranges(orders, orders > 10) == "-"
    assert ranges(orders, orders % 2 == 1) == "1, 3, 5, 7 and 1 more"
    result = compressor(impact())
    spectrum = result.record["response/impact/spectrum"]
    dominant = np.where(spectrum.axes[1].values < 3, 0, 1) * np.ones((3, 1), int)
    result.record.add(quantity("response/impact/dominant", dominant, "", *spectrum.axes))
    assert re.search(r"0\.0381 +0 to 2 +3 to 100 +-", "\n".join(section(result, "Impacts")))


def test_one_clearance_and_no_extras_still_make_a_table() -> None:
    parts = [item for item in impact(1) if item.path.endswith(("/mean_force", "/impacts"))]
    result = compressor([item for item in parts if "crank_pin" not in item.path])
    assert row(section(result, "Impacts"), "0.00254")[:2] == ["14.30", "2.9e-01"]


def test_the_rod_has_its_couple_or_its_bound() -> None:
    lines = section(compressor(), "Running gear")
    assert row(lines, "A, B  ") == ["0.3486", "0.04380"]
    assert [line.split()[1] for line in lines if line.strip().startswith("order ")] == [
        "1", "3", "5", "7", "9"
    ]  # fmt: skip
    bound = quantity("excitation/rod/couple_bound", 1.18, "N*m")
    assert "cannot add more than the bound" in " ".join(
        " ".join(section(compressor([bound]), "Running gear")).split()
    )


def test_the_terminal_names_energies_and_no_more_than_a_page() -> None:
    text = plain_summary(compressor())
    assert len(text.splitlines()) <= 50
    assert "kinetic energy, peak" in text and "mean force in the joint" in text


def energies_of(values: np.ndarray, error: float) -> list[Quantity]:
    orders = Axis(name="order", values=np.arange(1, len(values) + 1))
    path = "response/kinetic_energy/mean_by_order"
    return [quantity(path, values, "J", orders, error=error)]


def test_many_references_leave_the_first_page_to_those_that_matter() -> None:
    values = 10.0 ** -np.arange(0.0, 60.0)
    path = "response/kinetic_energy/mean_by_order"
    reasons = ("a slip of the source", "a misprint")
    rows = [
        {
            "quantity": path,
            "where": {"order": i + 1},
            "value": f"{value if i % 2 else 1.1 * value:.6e} J",
            "source": "Table 1",
            **({} if i % 2 else {"known_difference": reasons[i % 4 // 2]}),
        }
        for i, value in enumerate(values)
    ]
    result = compressor(energies_of(values, 1e-16), reference=rows)
    short = render_report(result)
    assert "match: Table 1 (30)" in short and short.count("the same for 14 more numbers") == 2
    text = render_report(result, full=True)
    top = text[: text.index("\nResponse")]
    assert (top.count(" within"), top.count("known [")) == (0, 0)
    below = text[text.index("\nReference numbers\n") :]
    assert (below.count(" within"), below.count("known [")) == (30, 30)
    # no number is folded in two, and ours has its digits next to a published one of its size
    assert re.search(r"mean_by_order +1\.00000e-59 +1\.00000e-59 +J +0\.0000 % +within", below)


def test_round_off_nearby_a_published_number_is_zero() -> None:
    row_of = {"quantity": "response/rotation_peak", "where": {"direction": "y"}, "source": "T. 1"}
    rows = [{**row_of, "value": value, "kind": "measured"} for value in ("1e-3 rad", "0 rad")]
    lines = section(compressor(response(), reference=rows), "Reference numbers")
    found = [line.split() for line in lines if line.startswith("  response/rotation_peak")]
    assert [cells[2] for cells in found] == ["0", "0"]


def test_an_empty_record_has_none_of_the_sections() -> None:
    text = render_report(compressor([]))
    assert not any(f"\n{title}" in text for title in PARTS)
