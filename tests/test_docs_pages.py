"""Claim: every page of the documentation that the program or another page names is there."""

import re

import pytest
from shipped_cases import ROOT

NAMED = re.compile(r"docs/(\w+\.md)")


def named() -> dict[str, set[str]]:
    """Pages by name, with the files that name them."""
    found: dict[str, set[str]] = {}
    for path in (*(ROOT / "vibecalc").rglob("*.py"), *(ROOT / "cases").glob("*.toml")):
        for page in NAMED.findall(path.read_text(encoding="utf-8")):
            found.setdefault(page, set()).add(path.relative_to(ROOT).as_posix())
    return found


@pytest.mark.parametrize("page", sorted(named()))
def test_a_page_that_is_named_is_there(page: str) -> None:
    assert (ROOT / "docs" / page).is_file(), f"{page} is named in {sorted(named()[page])}"


def test_links_between_pages_lead_somewhere() -> None:
    link = re.compile(r"\]\(([\w./]+\.md)\)")
    for page in (ROOT / "docs").glob("*.md"):
        for target in link.findall(page.read_text(encoding="utf-8")):
            assert (page.parent / target).is_file(), f"{page.name} leads to {target}"
