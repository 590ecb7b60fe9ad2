"""Claim: what stands in the way of a picture is said in words, never in a traceback."""

import sys
from dataclasses import replace
from pathlib import Path

import pytest
from drawn import coarse
from fuzzing import command
from report_samples import generator

from vibecalc.core.report.plots import draw_file, draw_files
from vibecalc.core.results.record import Record, Result
from vibecalc.core.results.store import write_result
from vibecalc.errors import UsageError


def test_matplotlib_missing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(UsageError) as raised:
        draw_file(generator(), tmp_path)
    assert "matplotlib" in str(raised.value)
    assert "pip install 'vibecalc[plot]'" in str(raised.value)
    assert raised.value.exit_code == 2
    assert list(tmp_path.iterdir()) == []


@pytest.fixture(autouse=True)
def _coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    coarse(monkeypatch)


def few() -> Result:
    """The generator with the numbers of one picture."""
    record = Record()
    for quantity in generator().record.values():
        if quantity.path.startswith("kinematics/"):
            record.add(quantity)
    return replace(generator(), record=record)


def test_a_folder_that_is_a_file(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    blocked = tmp_path / "pictures"
    blocked.write_text("not a folder")
    with pytest.raises(UsageError, match="cannot make the output folder"):
        draw_file(few(), blocked)
    assert blocked.read_text() == "not a folder"


def test_pictures_of_one_name_are_refused_before_any_is_drawn(tmp_path: Path) -> None:
    first, second = tmp_path / "one.h5", tmp_path / "other" / "one.h5"
    with pytest.raises(UsageError, match="same names") as raised:
        list(draw_files([first, second], tmp_path / "pictures"))
    assert "two folders" in str(raised.value)
    assert not (tmp_path / "pictures").exists()


def test_two_results_of_one_case_nearby_each_other(tmp_path: Path) -> None:
    """The file gives its pictures their names, not the case that both were made from."""
    pytest.importorskip("matplotlib")
    paths = [tmp_path / "before.h5", tmp_path / "after.h5"]
    for path in paths:
        write_result(few(), path)
    drawn = [picture for _, pictures in draw_files(paths, None) for picture in pictures]
    assert len(set(drawn)) == len(drawn) > 0
    assert {picture.name.partition("_")[0] for picture in drawn} == {"before", "after"}


def test_a_failed_picture_leaves_the_old_one(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    agg = pytest.importorskip("matplotlib.backends.backend_agg")
    path = tmp_path / "one.h5"
    write_result(few(), path)
    ((_, pictures),) = draw_files([path], None)
    before = {picture: picture.read_bytes() for picture in pictures}

    def half(self: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(agg.FigureCanvasAgg, "draw", half)
    with pytest.raises(KeyboardInterrupt):
        list(draw_files([path], None))
    assert {picture: picture.read_bytes() for picture in tmp_path.glob("*.png")} == before


def test_nothing_to_draw_is_said(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    path = tmp_path / "scalars.h5"
    write_result(replace(generator(), record=Record()), path)
    printed = command("plot", str(path))
    assert printed.out == ""
    assert printed.err == f"{path}: nothing to draw, it holds no curve or map\n"
