"""Claim: docs/validation_roll_control.md states what a run of its case gives and what is printed.

Every computed number is held to each digit shown, every printed one against the references of the
case, verdicts against what these say.
"""

from collections import Counter
from typing import Any, NamedTuple

import numpy as np
import pytest
from compressor_page import NUMBER, QUANTITY, shown
from roll_control_cases import shipped, value_of
from shipped_cases import ROOT
from test_docs import rows

from vibecalc.core.report.verdicts import judge_references
from vibecalc.core.results.select import scalar
from vibecalc.units import convert

PAGE = (ROOT / "docs" / "validation_roll_control.md").read_text(encoding="utf-8")
BLOCKS = PAGE.split("\n\n")


class Stated(NamedTuple):
    """A quantity of the case as the page shows it; `printed` and `verdict` are empty for ours."""

    path: str
    where: dict[str, Any]
    number: str
    unit: str
    printed: str
    verdict: str


def picked(text: str) -> dict[str, Any]:
    """`gain=10.0 feedback=-10s order=1` as a selection."""
    found: dict[str, Any] = {}
    for pair in text.split():
        key, value = pair.split("=")
        found[key] = (
            int(value) if value.isdigit() else float(value) if "." in value else value
        )  # fmt: skip
    return found


def stated() -> list[Stated]:
    """All rows of the page with a quantity."""
    every = []
    for block in BLOCKS:
        lines = rows(block)
        if not lines or "quantity" not in lines[0]:
            continue
        column = {name: place for place, name in enumerate(lines[0])}
        for cells in lines[2:]:
            quantity = QUANTITY.match(cells[column["quantity"]])
            number = NUMBER.match(cells[column["computed"]])
            assert quantity and number, cells
            more = [cells[column[n]] if n in column else "" for n in ("printed", "verdict")]
            where = picked(quantity[2])
            every.append(Stated(quantity[1], where, number[1], number[2] or "", *more))
    return every


def bare(where: dict[str, Any]) -> dict[str, Any]:
    return {k: v.replace(" ", "") if isinstance(v, str) else v for k, v in where.items()}


@pytest.mark.parametrize("row", stated(), ids=lambda row: f"{row.path}-{row.where}")
def test_computed_number_is_what_the_case_gives(row: Stated) -> None:
    quantity = shipped().record[row.path]
    value = scalar(quantity, row.where)
    size = abs(value) if isinstance(value, complex) else float(value)
    shown(row.number, convert(size, quantity.unit, row.unit) if row.unit else size)


def test_every_printed_number_is_a_reference_of_the_case_and_the_other_way_round() -> None:
    ours = Counter(
        (row.path, tuple(sorted(row.where.items())), row.printed.split(" ")[0])
        for row in stated() if row.printed
    )  # fmt: skip
    theirs = Counter(
        (row.quantity, tuple(sorted(bare(dict(row.where)).items())), row.printed.split(" ")[0])
        for row in judge_references(shipped())
    )
    assert ours == theirs and sum(ours.values()) == 39


def test_verdicts_are_those_of_the_references() -> None:
    judged = {
        (row.quantity, tuple(sorted(bare(dict(row.where)).items())), row.printed.split(" ")[0]): row
        for row in judge_references(shipped())
    }
    for row in stated():
        if not row.printed:
            continue
        like = judged[row.path, tuple(sorted(row.where.items())), row.printed.split(" ")[0]]
        if row.verdict in ("reproduced", "compatible"):
            assert like.within, row
        else:
            assert not like.agrees and like.known_difference, row
            tried = like.shown_by.startswith("not reproducible")
            assert tried == (row.verdict == "not reproducible"), row


def test_what_is_said_of_calm_and_torque() -> None:
    """No pair of the grid that the motor can follow takes more than 7 dB off the first orders."""
    record = shipped().record
    can = value_of(record, "grid/torque_peak") <= value_of(record, "breakdown_torque")
    taken = value_of(record, "grid/attenuation")[can][:, :2]
    assert np.sum(can) > 8 and 6.5 < np.max(taken) < 7.0
    assert "more than 7 dB off order 1 or 2" in " ".join(PAGE.split())
