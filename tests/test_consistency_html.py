"""Claim: `report --html` says what the text says, in one file that needs no other, and fits."""

import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path

import pytest
from shipped_cases import ROOT, result_of, table_of

import vibecalc
from vibecalc.core.report.html import html_table
from vibecalc.core.report.inputs import inputs
from vibecalc.core.report.page import html_page
from vibecalc.core.report.plots import vector_pictures
from vibecalc.core.report.sweep.text import file_lines
from vibecalc.core.report.text import report_lines
from vibecalc.core.report.writing import Column, Table, read, table, text_of

GOLDEN = ROOT / "tests" / "golden"
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")

#: what a browser sees: how much too wide, parts cut off, pictures that it cannot draw, and all
LOOK = """<script>addEventListener("load", () => {
  const root = document.documentElement, pictures = [...document.images];
  const wide = root.scrollWidth - root.clientWidth;
  const cut = [...document.querySelectorAll(".wide, pre")]
    .filter(one => one.scrollWidth > one.clientWidth + 1).length;
  const lost = pictures.filter(one => !one.complete || one.naturalWidth < 100).length;
  document.body.setAttribute("data-seen", [wide, cut, lost, pictures.length].join(" "));
});</script>"""


class Page(HTMLParser):
    """Texts of cells and titles, and everything that a page would load; all tags are closed."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.cells: list[str] = []
        self.loads: list[str] = []
        self.open: list[str] = []
        self.feed(page)
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.loads += [value or "" for name, value in attrs if name in ("src", "href")]
        if tag not in ("meta", "img"):
            self.open.append(tag)
        if tag in ("td", "th", "h1", "h2"):
            self.cells.append("")

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if {"td", "th", "h1", "h2"} & set(self.open):
            self.cells[-1] += data


def test_a_page_has_every_cell_and_picture_and_loads_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("vibecalc.core.report.plots._image", lambda *_: b"<svg/>")
    path = GOLDEN / "generator.h5"
    page = html_page(path)
    seen = Page(page)
    tables = [line for line in file_lines(path) if isinstance(line, Table)]
    assert len(tables) > 3
    cells = [cell for one in tables for row in (*one.rows, *one.totals) for cell in row]
    for text in (*cells, *(column.title for one in tables for column in one.columns)):
        assert read(" ".join(text.split())) in seen.cells
    pictures = [one for one in seen.loads if one.startswith("data:image/svg+xml;base64,")]
    assert len(pictures) == len(list(vector_pictures(path))) > 3
    assert all(one.startswith(("#", "data:")) for one in seen.loads)
    assert page.count('class="kept"') == 4 + 4 and 'class="missed"' not in page  # also at the end


def test_a_report_to_hand_in_has_its_title_block_input_and_assumptions(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("vibecalc.core.report.plots._image", lambda *_: b"<svg/>")
    table = table_of("generator")
    table["document"] = {"number": "R 7 <&>", "approved": "N. N.", "remarks": "First.\n\nSecond."}
    table["document"]["history"] = [{"revision": "A", "text": "first issue"}]
    result = vibecalc.run(table, set={"machine.speed": "4800 rpm"})
    page = html_page(result)
    heads = re.findall(r"<h2[^>]*>([^<]+)</h2>", page)
    assert heads[:2] == ["1 Input", "2 Assumptions"]
    assert heads[-2].endswith("Conclusion") and heads[-1] == "Appendix"
    assert page.index("R 7 &lt;&amp;&gt;") < page.index("<p>Second.</p>") < page.index("Contents")
    cells = Page(page).cells
    assert {"4800 rpm", "60 mm", "100 kg", "first issue"} <= set(cells)  # as it was computed with
    assert cells.count("4900 rpm") == 1  # where the run-up ends
    assert "small motions about its rest position" in page
    assert "--full" not in page and "[machine" not in page and "Table 3" not in page
    figures = [int(one) for one in re.findall(r"<figcaption>Figure (\d+): ", page)]
    assert figures == list(range(1, len(figures) + 1)) and len(figures) > 3
    text = text_of(report_lines(result))
    assert "R 7 <&>" in text and "First." not in text.split("Results")[0]


@pytest.mark.parametrize("name", ["absorber_rig_a", "roll", "pump", "compressor", "roll_measured"])
def test_the_input_has_every_number_of_the_case(name: str) -> None:
    """Numbers that the case writes with a unit stand in the tables as they are written."""
    result, told = result_of(name), re.sub(r"\s+", " ", text_of(inputs(result_of(name)), 10_000))
    asked = re.split(r"\n\[\[(?:reference|limit)", result.case_toml)[0]
    written = set(re.findall(r'= "(-?[\d.e]+ [A-Za-z][^"]*)"', asked))
    assert len(written) > 3
    assert [one for one in written if read(one) not in told] == []


@pytest.mark.parametrize("name", ["engine_v8", "generator_mount_stock"])
def test_the_input_has_no_digits_that_nobody_wrote(name: str) -> None:
    result = result_of(name)
    told = re.findall(r"\d+\.\d{10,}", text_of(inputs(result), 10_000))
    assert [one for one in told if one not in result.case_toml and len(one.strip("0.")) > 10] == []


@pytest.mark.parametrize(
    ("cell", "colour"),
    [
        ("max 400 kept", "kept"),
        ("max 400 BROKEN", "missed"),
        ("min 3 broken", "kept"),  # as the case expects
        ("max 10 UNDECIDED", "missed"),
        ("known [2]", "open"),
        ("within", "kept"),
        ("OUTSIDE", "missed"),
        ("measured", ""),
    ],
)
def test_verdicts_have_the_colour_of_what_they_say(cell: str, colour: str) -> None:
    (block,) = table([Column("result"), Column("verdict")], [["kept", cell]])
    assert isinstance(block, Table)
    assert re.findall(r'class="(\w+)">', html_table(block)) == ["wide", *[colour] * bool(colour)]


@pytest.mark.long
@pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")
@pytest.mark.parametrize("name", ["generator", "engine_v8"])
def test_a_browser_shows_all_of_it(name: str, tmp_path: Path) -> None:
    assert CHROMIUM is not None
    page = tmp_path / "page.html"
    page.write_text(html_page(GOLDEN / f"{name}.h5", full=True) + LOOK, encoding="utf-8")
    options = ["--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=1000,900"]
    command = [CHROMIUM, *options, "--dump-dom", "--virtual-time-budget=9000", page.as_uri()]
    run = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    found = re.search(r'data-seen="([^"]+)"', run.stdout)
    assert found, run.stdout[-500:]
    wide, cut, lost, pictures = map(int, found[1].split())
    assert wide <= 0 and not cut and not lost and pictures > 3
