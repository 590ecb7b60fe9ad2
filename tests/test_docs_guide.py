"""Claim: what docs/guide_propulsion.md tries gives what is printed; its run: test_docs_pages.py."""

import re
import shlex
import shutil
from pathlib import Path

import pytest
from pages import table
from shipped_cases import ROOT

from vibecalc.core.results.record import Record
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import load_checked
from vibecalc.units import convert

PAGE = (ROOT / "docs" / "guide_propulsion.md").read_text(encoding="utf-8")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The case of the page with its cards."""
    case = "\n".join(re.findall(r"```toml\n(.*?)```", PAGE, re.S))
    (tmp_path / "line.toml").write_text(case, encoding="utf-8")
    for card in (ROOT / "cases").glob("marine_gas_pressure_*.csv"):
        shutil.copy(card, tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def ranges(record: Record) -> str:
    """Barred ranges as the table prints them."""
    ends = [record[f"response/torsion/barred/{name}"].values for name in ("from", "to")]
    shown = [[f"{convert(one, 'rad/s', 'rpm'):.4g}" for one in end] for end in ends]
    return ", ".join(f"{low} to {high}" for low, high in zip(*shown, strict=True)) or "none"


@pytest.mark.long
@pytest.mark.parametrize("row", table(PAGE, "change"), ids=lambda row: row[0].split()[0])
def test_what_is_tried_gives_what_is_printed(folder: Path, row: list[str]) -> None:
    _, setting, use, barred = row
    (loaded,) = load_checked([folder / "line.toml"], shlex.split(setting.strip("`")))
    record = run_case(loaded.case, wanted=None)
    found = float(record["response/torsion/limit/largest_use"].values[0])
    assert f"{found:.4g}" == use
    assert ranges(record).replace(".0 ", " ") == barred
