"""Claim: docs/validation_absorber.md shows what the source prints and what is right, each digit."""

import functools
from collections import Counter

import pytest
from absorber_page import SECTIONS, VERDICTS, says_what_it_is
from pages import Row
from shipped_cases import ROOT
from test_docs import rows, shows

PAGE = (ROOT / "docs" / "validation_absorber.md").read_text(encoding="utf-8")


@functools.cache
def computed(title: str) -> list[Row]:
    return list(SECTIONS[title]())


def cells_of(title: str) -> list[list[str]]:
    body = PAGE.split(f"\n## {title}\n")[1].split("\n## ")[0]
    return rows(body)[2:]


def shown(cell: str, value: float | None) -> None:
    """The number of a cell is the value to each digit; an empty cell is no value."""
    assert bool(cell) == (value is not None)
    if value is not None:
        assert shows(cell, value), f"{cell} is shown, {value!r} computed"


@pytest.mark.parametrize("title", SECTIONS)
def test_every_row(title: str) -> None:
    cells, found = cells_of(title), computed(title)
    assert [row[:2] for row in cells] == [[one.place, one.printed] for one in found]
    for (_, _, source, right, verdict, reason), one in zip(cells, found, strict=True):
        shown(source, one.source)
        shown(right, one.right)
        assert (verdict, reason) == (one.verdict, one.reason)


@pytest.mark.parametrize("title", SECTIONS)
def test_the_verdict_is_what_the_numbers_say(title: str) -> None:
    """Reproduced where the right number has the printed digits, else with the slip."""
    for row in computed(title):
        assert says_what_it_is(row), row.place


def test_summary_counts_the_verdicts() -> None:
    summary = rows(PAGE)[2 : 2 + len(SECTIONS)]
    assert [row[0] for row in summary] == list(SECTIONS)
    for title, printed, *counts in summary:
        found = Counter(row.verdict for row in computed(title))
        assert int(printed) == found.total()
        assert [int(cell or 0) for cell in counts] == [found[verdict] for verdict in VERDICTS]
