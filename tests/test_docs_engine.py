"""Claim: docs/validation_engine.md shows what chapter 4 prints and what is right, each digit."""

from collections import Counter

import engine_source as source
import numpy as np
import pytest
from engine_page import SECTIONS, SHAPES, shape_cells
from pages import Row, assert_named_exist
from shipped_cases import ROOT
from test_docs import rows, shows

PAGE = (ROOT / "docs" / "validation_engine.md").read_text(encoding="utf-8")
VERDICTS = ("reproduced", "with the slip", "misprint", "compatible", "not reproducible")


def body(title: str) -> str:
    return PAGE.split(f"\n## {title}\n")[1].split("\n## ")[0]


def shown(cell: str, value: float | None) -> None:
    """The number of a cell is the value to each digit; an empty cell is no value."""
    assert bool(cell) == (value is not None)
    if value is not None:
        assert shows(cell, value), f"{cell} is shown, {value!r} computed"


@pytest.mark.parametrize("title", SECTIONS)
def test_every_row_and_its_verdict(title: str) -> None:
    cells, found = rows(body(title))[2:], SECTIONS[title]()
    assert [row[:2] for row in cells] == [[one.place, one.printed] for one in found]
    for (_, _, slipped, right, verdict, reason), one in zip(cells, found, strict=True):
        shown(slipped, one.source)
        shown(right, one.right)
        assert (verdict, reason) == (one.verdict, one.reason)
        judged(one)


def judged(row: Row) -> None:
    """Reproduced where the right number has the printed digits, else with the slip."""
    assert row.right is not None
    right = shows(row.printed, row.right)
    slipped = row.source is not None and shows(row.printed, row.source)
    assert row.verdict in VERDICTS
    assert (row.verdict == "reproduced") == right, row
    assert (row.verdict == "with the slip") == slipped, row
    assert row.reason or row.verdict == "reproduced"


def test_shapes() -> None:
    cells = [row for row in rows(body(SHAPES)) if row[1] in ("printed", "computed")]
    modes = [one for freedoms in (7, 8) for one in shape_cells(freedoms)]
    assert len(cells) == 2 * len(modes)
    cut = Counter[str]()
    for (place, printed, value), above, below in zip(modes, cells[::2], cells[1::2], strict=True):
        assert above == [place, "printed", *printed]
        assert below[:2] == ["", "computed"]
        for text, number, exact in zip(printed, below[2:], value, strict=True):
            shown(number, float(exact))
            assert len(number.partition(".")[2]) > len(text.partition(".")[2]) or number == "1"
            digits = 10.0 ** len(text.partition(".")[2])
            towards_zero = np.trunc(exact * digits) / digits
            cut[place[0]] += not shows(text, float(exact))
            assert shows(text, float(exact)) or abs(towards_zero - float(text)) < 1e-9
    assert cut == {"7": 2, "8": 17}


def test_summary_counts_the_verdicts() -> None:
    summary = rows(PAGE)[2 : 2 + len(SECTIONS) + 1]
    assert sorted([*SECTIONS, SHAPES]) == [row[0] for row in summary]
    values = sum(len(printed) for n in (7, 8) for _, printed, _ in shape_cells(n))
    assert values == 6 * 7 + 7 * 8 == sum(map(len, source.SHAPE_7[1:] + source.SHAPE_8[1:]))
    for title, printed, *counts in summary:
        found = (
            Counter({"reproduced": values})
            if title == SHAPES
            else Counter(row.verdict for row in SECTIONS[title]())
        )
        assert int(printed) == found.total()
        assert [int(cell or 0) for cell in counts] == [found[verdict] for verdict in VERDICTS]


def test_the_tests_and_files_that_are_named_exist() -> None:
    assert_named_exist(PAGE, least=10)
