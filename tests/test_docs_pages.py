"""Claim: every block of tutorials and how-to guides works as printed, and shows what comes out."""

import re
from fnmatch import fnmatch
from pathlib import Path

import pytest
from drawn import coarse
from long_but import long_but
from page_run import PageError, blocks_of, pictures_of, run_page
from pages import missing_names
from shipped_cases import ROOT

DOCS = ROOT / "docs"
#: pages that are scripts; other guides have tests of their own names
GUIDES = [DOCS / f"{name}.md" for name in ("guide_absorber", "optimisation")]
LONG = [DOCS / f"{name}.md" for name in ("guide_propulsion", "fits")]
PAGES = [*sorted(DOCS.glob("tutorials/*.md")), *sorted(DOCS.glob("how_to/*.md")), *GUIDES]


@pytest.mark.parametrize("page", long_but([*PAGES, *LONG], *PAGES), ids=lambda path: path.stem)
def test_a_page_runs_and_prints_what_it_shows(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    coarse(monkeypatch)
    text = page.read_text(encoding="utf-8")
    if "plot" in text or "--html" in text:
        pytest.importorskip("matplotlib")
    if "import dask" in text:
        pytest.importorskip("dask")
    run_page(page, tmp_path)
    for picture in pictures_of(page, DOCS / "generated" / "drawn"):
        assert [*tmp_path.rglob(picture.name)], picture


@pytest.mark.parametrize("page", [*PAGES, *LONG], ids=lambda path: path.stem)
def test_a_page_has_nothing_that_is_not_run_and_names_what_is_there(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    blocks = blocks_of(text)
    assert text.count("```") == 2 * len(blocks)
    assert {one.language for one in blocks} <= {"sh", "toml", "python", "text", "yaml", ""}
    left = [one.text for one in blocks if one.language == "text"]
    assert not [one for one in left if re.search(r"^(vibecalc|import|from) ", one, re.M)]
    assert any(one.language in ("sh", "python", "toml") for one in blocks)
    assert missing_names(text, str(page.parent.relative_to(ROOT))) == []


def test_each_page_is_on_the_start_page() -> None:
    text = (DOCS / "index.md").read_text(encoding="utf-8")
    listed = re.findall(r"^(?:.* <)?([\w/]+\*?)>?$", text, re.M)
    for path in (*DOCS.glob("*.md"), *PAGES):
        name = str(path.relative_to(DOCS).with_suffix(""))
        assert name == "index" or any(fnmatch(name, one) for one in listed), name


@pytest.mark.parametrize(
    ("page", "said"),
    [
        ("```sh\necho 1.5 N\n```\n\n```\n1.6 N\n```\n", "shown and not printed: 1.6 N"),
        ("```sh\necho one\necho two\n```\n\n```\ntwo\none\n```\n", "shown and not printed: one"),
        ("```sh\nfalse\n```\n", "exit code 1, not 0"),
        ("```sh\nvibecalc run there.toml # exit code 1\n```\n", "exit code 2, not 1"),
        ("```python\nprint(2.0)\n```\n\n```\n2.00001\n```\n", "shown and not printed"),
        ("```toml\nspeed = 1\n```\n", "no file is named"),
    ],
)
def test_a_page_that_is_wrong_is_found(page: str, said: str, tmp_path: Path) -> None:
    path, folder = tmp_path / "page.md", tmp_path / "run"
    path.write_text(page)
    folder.mkdir()
    with pytest.raises(PageError, match=said):
        run_page(path, folder)


def test_what_is_left_out_and_rounded_is_allowed(tmp_path: Path) -> None:
    path, folder = tmp_path / "page.md", tmp_path / "run"
    path.write_text(
        "```toml\n# a.toml\nx = 1\n```\n\n```sh\ncat a.toml\n```\n\n```\n...\nx   = 1\n```\n\n"
        "```toml\ny = 2\n```\n\n```python\nprint(0.1 + 0.2, 'and more')\n"
        "from pathlib import Path\nprint(Path('a.toml').read_text())\n```\n\n"
        "```\n0.3 and ...\ny = 2\n```\n"
    )
    folder.mkdir()
    run_page(path, folder)
