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
    compressor,
    impact,
    modes,
    motion,
    operations,
    response,
    switching,
)

from vibecalc.core.report.text import render_report
from vibecalc.core.results.record import Axis, Quantity, Result
from vibecalc.response.report import SMALLEST

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


@pytest.mark.parametrize("title", PARTS)
def test_a_section_appears_for_its_own_results_only_and_for_each_alone(title: str) -> None:
    text = render_report(compressor(PARTS[title]()), full=True)
    assert {name for name in PARTS if f"\n{name}" in text} == {title}
    assert max(len(line) for line in text.splitlines()) <= 100
    assert not re.search(r"\b(nan|inf|None|array|np\.)\b| \n", text)
    for item in PARTS[title]():
        text = render_report(compressor([item]), full=True)
        name = item.path.rsplit("/", 1)[-1]
        assert name in text or f"\n{title}" in text or "Piston motion" in text


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


def test_a_range_within_its_error_is_one_number() -> None:
    result = compressor(operations())
    for end in ("low", "high"):
        path = f"response/operations/kinetic_energy/mean_{end}"
        mean = result.record["response/operations/kinetic_energy/mean"].values
        replaced(result, path, mean * (1.0 + 1e-14))
    text = "\n".join(section(result, "Operations"))
    first = text[text.index("mean over a turn") : text.index("difference")]
    assert ".." not in first


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
