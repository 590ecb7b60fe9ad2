"""Claim: the page of a shaft line is a calculation to hand in, and its conclusion only reads."""

import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from long_but import long_but
from shipped_cases import ROOT
from test_consistency_html import Page

from vibecalc.core.report.page import html_page
from vibecalc.core.report.text import sections_of
from vibecalc.core.results.record import (
    BARRED,
    BROKEN,
    KEPT,
    UNDECIDED,
    Quantity,
    Result,
)
from vibecalc.core.results.store import read_result
from vibecalc.core.results.verdicts import verdicts_of
from vibecalc.torsion.report.first_page import CALCULATION, conclusion_table, in_one_sentence
from vibecalc.torsion.report.limits import flags

GOLDEN = ROOT / "tests" / "golden"
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
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


def result_of(name: str) -> Result:
    return read_result(GOLDEN / f"{name}.h5")


def changed(result: Result, path: str, values: object, error: float = 0.0) -> Result:
    """The result with other numbers of a quantity."""
    quantities = dict(result.record.quantities)
    one = quantities[path]
    quantities[path] = replace(one, values=np.asarray(values, dtype=float), error_estimate=error)
    return with_quantities(result, quantities)


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
    assert flags(found) == ["BROKEN", "barred range"]


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
    named = np.array(["all fire", "4 misfires"], dtype=object)
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
    assert CHROMIUM is not None
    page, sheet = tmp_path / "page.html", tmp_path / "page.pdf"
    page.write_text(html_page(GOLDEN / "marine_propulsion.h5"), encoding="utf-8")
    options = ["--headless=new", "--no-sandbox", "--disable-gpu", "--no-pdf-header-footer"]
    command = [CHROMIUM, *options, f"--print-to-pdf={sheet}", page.as_uri()]
    subprocess.run(command, capture_output=True, timeout=120, check=True)
    assert 9 <= len(re.findall(rb"/Type\s*/Page\b", sheet.read_bytes())) <= 18
