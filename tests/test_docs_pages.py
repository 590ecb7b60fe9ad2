"""Claim: every block of tutorials and how-to guides works as printed, and shows what comes out."""

import re
from pathlib import Path

import pytest
from drawn import coarse
from long_but import long_but
from page_run import blocks_of, pictures_of, run_page
from pages import missing_names
from shipped_cases import ROOT

DOCS = ROOT / "docs"
#: pages that are scripts; other guides have tests of their own names
GUIDES = [DOCS / "guide_absorber.md"]
LONG = [DOCS / "guide_propulsion.md"]
#: run by test_docs_searches.py
SEARCHES = DOCS / "searches.md"
PAGES = [*sorted(DOCS.glob("tutorials/*.md")), *sorted(DOCS.glob("how_to/*.md")), *GUIDES]


@pytest.mark.parametrize("page", long_but([*PAGES, *LONG], *PAGES), ids=lambda path: path.stem)
def test_a_page_runs_and_prints_what_it_shows(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    coarse(monkeypatch)
    text = page.read_text(encoding="utf-8")
    if "plot" in text or "--html" in text:
        pytest.importorskip("matplotlib")
    run_page(page, tmp_path)
    for picture in pictures_of(page, DOCS / "pictures" / "drawn"):
        assert [*tmp_path.rglob(picture.name)], picture


@pytest.mark.parametrize("page", [*PAGES, *LONG, SEARCHES], ids=lambda path: path.stem)
def test_a_page_has_nothing_that_is_not_run_and_names_what_is_there(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    blocks = blocks_of(text)
    assert text.count("```") == 2 * len(blocks)
    assert {one.language for one in blocks} <= {"sh", "toml", "python", "text", "yaml", ""}
    left = [one.text for one in blocks if one.language == "text"]
    assert not [one for one in left if re.search(r"^(vibecalc|import|from) ", one, re.M)]
    assert any(one.language in ("sh", "python", "toml") for one in blocks)
    assert missing_names(text, str(page.parent.relative_to(ROOT))) == []


def test_the_start_page_links_each_page_and_works_in_a_clone() -> None:
    links = re.findall(r"\]\(([\w/.]+)\)", (DOCS / "index.md").read_text(encoding="utf-8"))
    assert [link for link in links if not (DOCS / link).is_file()] == []
    for path in (*DOCS.glob("*.md"), *PAGES):
        name = str(path.relative_to(DOCS))
        assert name == "index.md" or name in links, name
