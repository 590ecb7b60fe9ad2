"""Claim: pages of published numbers show each digit that the source prints and that is right."""

import functools
from collections import Counter

import absorber_page
import engine_page
import pytest
import roll_page
from long_but import long_but
from pages import (
    VERDICTS,
    Row,
    merged,
    place_of,
    reproduced,
    rows,
    says_what_it_is,
    shows,
    table,
    text_of,
)

PAGES = {
    "validation_absorber": absorber_page.SECTIONS,
    "validation_engine": engine_page.SECTIONS,
    "validation_roll": roll_page.SECTIONS,
}
SECTIONS = [(page, title) for page, sections in PAGES.items() for title in sections]
QUICK = [one for one in SECTIONS if one[1] != "5. Section 6.6: design changes"]


@functools.cache
def found(page: str, title: str) -> list[Row]:
    return list(PAGES[page][title]())


def body_of(page: str, title: str) -> str:
    return text_of(page).split(f"\n## {title}\n")[1].split("\n#")[0]


def shown(cell: str, values: list[float | None]) -> None:
    """The numbers of a cell are the values to each digit; an empty cell is no value."""
    numbers = cell.split(", ") if cell else [None] * len(values)
    for number, value in zip(numbers, values, strict=True):
        assert (number is None) == (value is None)
        assert number is None or value is None or shows(number, value), (number, value)


@pytest.mark.parametrize("section", long_but(SECTIONS, *QUICK), ids="-".join)
def test_every_number_is_on_the_page(section: tuple[str, str]) -> None:
    """Those reproduced as a list, all others as a table with the reason."""
    page, title = section
    body = body_of(page, title)
    assert reproduced(found(page, title)) in " ".join(body.split())
    groups = merged(row for row in found(page, title) if row.verdict != "reproduced")
    for cells, group in zip(rows(body)[2:], groups, strict=True):
        place, printed, source, right, verdict, reason = cells
        assert (place, verdict, reason) == (place_of(group), group[0].verdict, group[0].reason)
        assert printed.split(", ") == [row.printed for row in group]
        shown(source, [row.source for row in group])
        shown(right, [row.right for row in group])


@pytest.mark.parametrize("section", long_but(SECTIONS, *QUICK), ids="-".join)
def test_the_verdict_is_what_the_numbers_say(section: tuple[str, str]) -> None:
    """Reproduced where the right number has the printed digits, else with the slip."""
    for row in found(*section):
        assert says_what_it_is(row), row.place


@pytest.mark.parametrize("page", long_but(PAGES, "validation_absorber", "validation_engine"))
def test_summary_counts_the_verdicts(page: str) -> None:
    (_, _, *verdicts), *_ = rows(text_of(page))
    assert set(verdicts) <= set(VERDICTS)
    lines = {title: cells for title, *cells in table(text_of(page), "section")}
    assert set(PAGES[page]) <= set(lines)
    for title in PAGES[page]:
        printed, *counts = lines[title]
        counted = Counter(row.verdict for row in found(page, title))
        assert int(printed) == counted.total()
        assert [int(cell or 0) for cell in counts] == [counted[verdict] for verdict in verdicts]
