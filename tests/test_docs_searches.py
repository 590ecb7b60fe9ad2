"""Claim: the case and the commands of docs/searches.md work as printed."""

import re
from pathlib import Path

import pytest
from page_run import run_page

from vibecalc.core.results.store import read_result
from vibecalc.core.study.execute import load_checked
from vibecalc.core.study.planned import find_entries

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "docs" / "searches.md").read_text(encoding="utf-8")
FIND = PAGE.split("\n## ")[1]
BLOCKS = dict(re.findall(r"```(\w+)\n(.*?)```", FIND, re.S))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the case of the page."""
    text = (ROOT / "cases" / "generator.toml").read_text(encoding="utf-8")
    (tmp_path / "finds.toml").write_text(f"{text}\n{BLOCKS['toml']}", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_page_runs_and_finds_what_it_asks_for(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    folder.mkdir()
    run_page(ROOT / "docs" / "searches.md", folder)
    record = read_result(folder / "outputs" / "finds.h5").record
    assert float(record["find/ten_hertz/reached"].values) == pytest.approx(62.8318530718)
    peak = float(record["isolation/couple_over_lever/blocked_peak"].values)
    assert float(record["find/smaller_crank/reached"].values) == pytest.approx(peak - 1000.0)
    assert float(record["find/smaller_crank/ratio"].values) == pytest.approx(1.0 - 1000.0 / peak)
    best = record["find/best_damping/reached"].values
    assert best < record["isolation/couple_over_lever/run_up_peak"].values
    said = (folder / "outputs" / "finds.txt").read_text(encoding="utf-8")
    found = said[said.index("Found values") :]
    assert re.search(r"ten_hertz .* 10\.00 Hz +10\.00 Hz\n", found), "not as the case writes it"


def test_every_path_is_in_the_table(folder: Path) -> None:
    rows = re.findall(r"^\| (`.*?) \|", FIND, re.M)
    reported = {name for row in rows for name in re.findall(r"`(\w+)`", row)}
    entries = find_entries(load_checked([folder / "finds.toml"])[0].case)
    own = [path.split("/", 2)[2] for path in entries]
    assert reported == {name for name in own if "/" not in name}
    assert "`scaled_with/<key>`" in rows[3] and "`machine/<path>`" in rows[4]
    assert {name.split("/")[0] for name in own if "/" in name} == {"scaled_with", "machine"}
