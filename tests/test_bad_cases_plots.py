"""Claim: what stands in the way of a picture is said in words, never in a traceback."""

import sys
from pathlib import Path

import pytest
from report_samples import generator

from vibecalc.errors import UsageError
from vibecalc.report.plots import draw


def test_matplotlib_missing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(UsageError) as raised:
        draw(generator(), tmp_path)
    assert "matplotlib" in str(raised.value)
    assert "pip install 'vibecalc[plot]'" in str(raised.value)
    assert raised.value.exit_code == 2
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_a_file(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    blocked = tmp_path / "pictures"
    blocked.write_text("not a folder")
    with pytest.raises(UsageError, match="cannot write the picture"):
        draw(generator(), blocked)
    assert blocked.read_text() == "not a folder"
