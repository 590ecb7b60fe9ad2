"""Claim: `report --html` says what the text says, in one file that needs no other, and fits."""

import re
import shutil
import subprocess
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from long_but import long_but
from shipped_cases import ROOT, result_of, table_of

import vibecalc
from vibecalc.core.report.html import html_table
from vibecalc.core.report.inputs import inputs
from vibecalc.core.report.page import html_page
from vibecalc.core.report.plots import vector_pictures
from vibecalc.core.report.sweep.text import file_lines
from vibecalc.core.report.text import report_lines, sections_of
from vibecalc.core.report.writing import Column, Table, read, table, text_of
from vibecalc.core.results.record import BARRED, BROKEN, KEPT, UNDECIDED, Quantity, Result
from vibecalc.core.results.verdicts import verdicts_of
from vibecalc.torsion.report.first_page import CALCULATION, conclusion_table, in_one_sentence
from vibecalc.torsion.report.limits import flags

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


def browsed(page: Path, *options: str) -> "subprocess.CompletedProcess[str]":
    """What a browser makes of a page."""
    words = [str(CHROMIUM), "--headless=new", "--no-sandbox", "--disable-gpu", *options]
    return subprocess.run(
        [*words, page.as_uri()], capture_output=True, text=True, timeout=120, check=True
    )


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
    page = tmp_path / "page.html"
    page.write_text(html_page(GOLDEN / f"{name}.h5", full=True) + LOOK, encoding="utf-8")
    run = browsed(page, "--window-size=1000,900", "--dump-dom", "--virtual-time-budget=9000")
    found = re.search(r'data-seen="([^"]+)"', run.stdout)
    assert found, run.stdout[-500:]
    wide, cut, lost, pictures = map(int, found[1].split())
    assert wide <= 0 and not cut and not lost and pictures > 3


# ----------------------------------------------------------------------------
# The page of a shaft line is a calculation to hand in, and its conclusion only reads.
# ----------------------------------------------------------------------------

ROOT_PATH = "response/torsion/"
COMMON = ["System data", "Natural frequencies and mode shapes", "Holzer tables", "Excitation"]
LAST = ["Barred ranges and critical speeds", "Conclusion"]
CHAPTERS = {
    "marine_propulsion": [
        *COMMON,
        "Damping",
        "Forced vibration",
        "Misfire and worst condition",
        *LAST,
    ],
    "engine_geared": [*COMMON, "Forced vibration", *LAST],
    "genset_coupling": [*COMMON, "Forced vibration", "Misfire and worst condition", *LAST],
    "pump_drive": [*COMMON, "Forced vibration", *LAST],
}


def changed(result: Result, path: str, values: object, error: float = 0.0) -> Result:
    """The result with other numbers of a quantity."""
    one = result.record[path]
    one = replace(one, values=np.asarray(values, dtype=float), error_estimate=error)
    return with_quantities(result, {**result.record.quantities, path: one})


def with_quantities(result: Result, quantities: dict[str, Quantity]) -> Result:
    """The result with other quantities, its limits not judged yet."""
    return replace(result, record=replace(result.record, quantities=quantities), verdicts=None)


# ----------------------------------------------------------------------------
# The page: chapters in their order, numbers without gaps, nothing twice.
# ----------------------------------------------------------------------------


@pytest.mark.parametrize("name", long_but(CHAPTERS, "pump_drive"))
def test_chapters_stand_in_their_order_and_their_numbers_close_up(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vibecalc.core.report.plots._image", lambda *_: b"<svg/>")
    page = html_page(GOLDEN / f"{name}.h5")
    Page(page)  # every tag is closed
    heads = re.findall(r'<h2 id="([^"]+)">([^<]+)</h2>', page)
    numbered = [f"{number} {title}" for number, title in enumerate(CHAPTERS[name], 1)]
    assert [title for _, title in heads] == [*numbered, "Appendix"]
    contents = re.findall(r'<li><a href="#([^"]+)">([^<]+)</a></li>', page)
    assert contents == heads
    ids = re.findall(r' id="([^"]+)"', page)
    assert len(ids) == len(set(ids))
    tables = re.findall(r"<table>.*?</table>", page, re.DOTALL)
    assert len(tables) == len(set(tables)) > 6
    figures = [int(one) for one in re.findall(r"<figcaption>Figure (\d+): ", page)]
    assert figures == list(range(1, len(figures) + 1)) and len(figures) > 3
    assert page.count("Holzer table of mode") == 2
    assert {"Input", "Assumptions"} <= set(re.findall(r"<h3[^>]*>A\.\d+ ([^<]+)</h3>", page))
    rows = verdicts_of(result_of(name))
    assert f"{sum(row.state == KEPT for row in rows)} of {len(rows)} limits are kept" in page
    # heading, line and a row for each in the table of the conclusion, which may go on below
    table = "\n".join(conclusion_table(result_of(name)))
    assert len(re.findall(r"informative|maker|case", table)) >= len(rows)


def test_every_part_of_the_calculation_exists() -> None:
    from vibecalc.core.report.plots import every_picture
    from vibecalc.core.results.named import named

    pictures = every_picture()
    for chapter in CALCULATION.chapters:
        for part in (*chapter.parts, *chapter.details):
            assert callable(named(part)) if ":" in part else part in pictures, part
    sections = set(sections_of(result_of("marine_propulsion").record))
    assert set(CALCULATION.elsewhere) <= sections


# ----------------------------------------------------------------------------
# The conclusion: each limit of the result is a line, and no other, with its verdict.
# ----------------------------------------------------------------------------


def test_allowed_computed_and_use_belong_together() -> None:
    for name in CHAPTERS:
        for row in verdicts_of(result_of(name)):
            if np.isfinite(row.utilisation) and row.max is not None:
                assert (row.margin >= 0.0) == (row.utilisation <= 1.0)
                if row.status != "maker":
                    assert row.computed / row.max == pytest.approx(row.utilisation, rel=1e-6)


def test_what_is_broken_or_undecided_is_said() -> None:
    result, path = result_of("marine_propulsion"), f"{ROOT_PATH}limit/each/passage_utilisation"
    broken = changed(result, path, [[1.2, 0.0], [0.0, 0.3]])
    row = next(one for one in verdicts_of(broken) if one.quantity == path)
    assert (row.element, row.state, row.utilisation) == ("intermediate shaft", BROKEN, 1.2)
    assert (row.max, row.unit, np.isnan(row.speed)) == (1.0, "", True)  # not those of this use
    said = "intermediate shaft, stress, passing through: 120.0 % of what is allowed"
    assert said in in_one_sentence(broken)
    near = changed(result, path, [[0.99, 0.0], [0.0, 0.3]], error=0.02)
    assert next(one for one in verdicts_of(near) if one.quantity == path).state == UNDECIDED
    assert "intermediate shaft, stress, passing through is undecided: " in in_one_sentence(near)


def test_a_range_that_may_not_be_barred_breaks_the_limit() -> None:
    result, path = result_of("marine_propulsion"), f"{ROOT_PATH}limit/each/utilisation"
    found = changed(result, f"{ROOT_PATH}exceeded/permitted", [0.0, 1.0])
    assert next(one for one in verdicts_of(found) if one.quantity == path).state == BROKEN
    assert flags(found) == ["BROKEN", "barred"]


@pytest.mark.parametrize(
    ("permitted", "unbarred", "operating", "states"),
    [
        ([1, 0], 0.9, 1.5, [BROKEN, BROKEN]),  # the operating speed is in the range
        ([1, 1], 0.9, 0.5, [BARRED, KEPT]),  # ranges that may be barred
        ([0, 1], 0.9, 0.5, [BROKEN, KEPT]),  # one of another condition may not
        (None, 1.2, 0.5, [BROKEN, KEPT]),  # an older file has no ranges
        (None, 0.9, 0.5, [BARRED, KEPT]),
    ],
)
def test_a_condition_is_broken_where_no_range_may_be_barred(
    permitted: list[int] | None, unbarred: float, operating: float, states: list[str]
) -> None:
    result = result_of("marine_propulsion")
    use = result.record[f"{ROOT_PATH}limit/each/utilisation"]
    stem, quantities = f"{ROOT_PATH}conditions/limit/", dict(result.record.quantities)
    named = np.array(["all fire", "misfire of cylinder 4"], dtype=object)
    condition = replace(use.axes[1], name="condition", values=named)
    axes = (condition, replace(use.axes[0], values=np.array([1])))
    for name, values in (
        ("largest_utilisation", [1.1, 2.2]), ("operating_utilisation", [0.2, operating]),
        ("speed", [5.0, 4.0]),
        ("unbarred_utilisation", [0.3, unbarred]),
    ):  # fmt: skip
        made = replace(use, path=stem + name, values=np.array(values)[:, None], axes=axes)
        quantities[stem + name] = made
    folder, known = f"{ROOT_PATH}conditions/exceeded/", result.record[f"{ROOT_PATH}exceeded/limit"]
    quantities = {path: one for path, one in quantities.items() if not path.startswith(folder)}
    for name, values in (("limit", [1, 1]), ("permitted", permitted)) if permitted else ():
        axis = replace(known.axes[0], values=np.array([1, 2]))
        made = replace(known, path=folder + name, values=np.array(values), axes=(axis,))
        quantities[made.path] = made
    found = with_quantities(result, quantities)
    rows = [one for one in verdicts_of(found) if one.element and one.quantity.startswith(stem)]
    assert [(one.utilisation, one.state) for one in rows] == [
        (2.2, states[0]),
        (operating, states[1]),
    ]
    assert all(one.condition == "misfire of cylinder 4 (worst of 2 conditions)" for one in rows)


def test_nothing_is_concluded_without_limits() -> None:
    result = result_of("engine_run_up")
    case = {**result.case, "limit": ()}
    kept = {
        path: one
        for path, one in result.record.quantities.items()
        if "/limit/" not in path and "hammers" not in path
    }
    bare = replace(with_quantities(result, kept), case=case)
    assert verdicts_of(bare) == ()
    assert in_one_sentence(bare) == "The case sets no limits."


# ----------------------------------------------------------------------------
# On paper.
# ----------------------------------------------------------------------------


@pytest.mark.long
@pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")
def test_a_marine_line_takes_no_more_than_18_pages(tmp_path: Path) -> None:
    page, sheet = tmp_path / "page.html", tmp_path / "page.pdf"
    page.write_text(html_page(GOLDEN / "marine_propulsion.h5"), encoding="utf-8")
    browsed(page, "--no-pdf-header-footer", f"--print-to-pdf={sheet}")
    assert 9 <= len(re.findall(rb"/Type\s*/Page\b", sheet.read_bytes())) <= 18
