"""Claim: what docs/guide_absorber.md tries gives what is printed; its run: test_docs_pages.py."""

import re
import shlex
from pathlib import Path

import pytest
from pages import table
from shipped_cases import ROOT

from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import load_checked

PAGE = (ROOT / "docs" / "guide_absorber.md").read_text(encoding="utf-8")
MOTION = "response/absorber/motion/largest/acceleration"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The case of the page."""
    case = "\n".join(re.findall(r"```toml\n(.*?)```", PAGE, re.S))
    (tmp_path / "floor.toml").write_text(case, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


ROWS = {row[0]: row for row in table(PAGE, "change")}


@pytest.mark.long
@pytest.mark.parametrize("change", ROWS)
def test_what_is_tried_gives_what_is_printed(folder: Path, change: str) -> None:
    _, setting, *printed = ROWS[change]
    settings = [word for word in shlex.split(setting.strip("`")) if word != "--set"]
    (loaded,) = load_checked([folder / "floor.toml"], settings)
    record = run_case(loaded.case)
    found = (
        float(record["tuning/linear_stiffness"].values) / 1e3,
        float(record["tuning/linear_damping"].values),
        float(record[MOTION].values) * 1e3,
    )
    assert [f"{one:.4g}" for one in found] == printed
