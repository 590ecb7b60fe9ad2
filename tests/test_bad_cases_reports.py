"""Claim: a finished result is never lost, whatever becomes of the words and pictures made of it."""

import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from drawn import coarse
from fuzzing import command
from report_samples import generator
from shipped_cases import CASES

from vibecalc import api
from vibecalc.core.report import plots
from vibecalc.core.report.plots import draw_file, draw_files
from vibecalc.core.report.writing import Column, number, table
from vibecalc.core.results.record import Record, Result
from vibecalc.core.results.store import write_result
from vibecalc.errors import Defect, UsageError
from vibecalc.excitation import report as excitation

GENERATOR = str(CASES["generator"])
ABSORBER = str(CASES["absorber_mass"])


@pytest.fixture(autouse=True)
def _in_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    coarse(monkeypatch)


def _broken(*_: Any, **__: Any) -> Any:
    raise IndexError("nothing there")


def _mended(monkeypatch: pytest.MonkeyPatch) -> None:
    """Take back what was broken, and stay in the folder."""
    here = Path.cwd()
    monkeypatch.undo()
    monkeypatch.chdir(here)


def _run(*more: str) -> Any:
    return command("run", GENERATOR, "-o", "one.h5", *more)


def _stands() -> None:
    """The result is there, and can be read by all commands that read results."""
    assert command("get", "one.h5", "excitation/force").code == 0
    assert command("info", "one.h5").code == 0


# ----------------------------------------------------------------------------
# The text report.
# ----------------------------------------------------------------------------


def test_a_section_that_fails_takes_nothing_along(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = _run("-q")
    assert whole.code == 0
    text = Path("one.txt").read_text(encoding="utf-8")
    monkeypatch.setattr(excitation, "excitation", _broken)
    found = _run("-q")
    assert found.code == 70
    assert "one.h5: the result is whole" in found.err and "IndexError: nothing there" in found.err
    assert "vibecalc.excitation.report:excitation" in found.err and "bug in vibecalc" in found.err
    short = Path("one.txt").read_text(encoding="utf-8")
    assert "Parts left out because of a bug" in short
    headings = [row for row in text.splitlines() if set(row) == {"-"}]
    assert len([row for row in short.splitlines() if set(row) == {"-"}]) >= len(headings) - 1
    _stands()
    assert command("report", "one.h5").code == 70
    _mended(monkeypatch)


@pytest.mark.parametrize(
    ("broken", "given", "words"),
    [
        ("text.identity", ["run", "-q"], "the text report: IndexError"),
        ("terminal.print_summary", ["run"], "the summary: IndexError"),
        (
            "sweep.text.sweep_lines",
            ["sweep", "--grid", "machine.speed=300:310:2", "--jobs", "1"],
            "",
        ),
        ("accuracy.accuracy_lines", ["accuracy", "--stage", "excitation", "--longest", "1"], ""),
    ],
)
def test_a_result_stands_whose_words_fail(
    broken: str, given: list[str], words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(f"vibecalc.core.report.{broken}", _broken)
    verb, *more = given
    found = command(verb, GENERATOR, *more, "-o", "one.h5", cap=60)
    assert found.code == 70 and "one.h5: the result is whole" in found.err and words in found.err
    assert Path("one.txt").exists() == (verb == "run" and "-q" not in more)
    _mended(monkeypatch)
    assert command("report", "one.h5").code == 0


def test_the_result_stands_before_words_are_made(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C while they are made loses no result either."""

    def stopped(*_: Any) -> Any:
        assert Path("one.h5").exists()
        raise KeyboardInterrupt

    monkeypatch.setattr("vibecalc.core.report.text.identity", stopped)
    assert _run("-q").code == 130
    _mended(monkeypatch)
    _stands()


def test_json_names_what_failed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(excitation, "excitation", _broken)
    found = _run("--json")
    assert found.code == 70
    (one,) = json.loads(found.out)
    assert "the result is whole" in one["error"]["message"]
    assert one["error"]["exit_code"] == one["exit_code"] == 70


def test_a_failed_report_is_not_up_to_date(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(excitation, "excitation", _broken)
    assert _run("-q", "--if-needed").code == 70
    _mended(monkeypatch)
    assert "up to date" not in _run("--if-needed").out
    assert "up to date" in _run("--if-needed").out


def test_one_case_that_fails_does_not_stop_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    """Be it in its report or while it is computed."""
    for broken in ("report.excitation", "adapter.run_excitation"):
        monkeypatch.setattr(f"vibecalc.excitation.{broken}", _broken)
        found = command("run", GENERATOR, ABSORBER, "-q", "-o", "out/")
        assert found.code == 70 and "nothing there" in found.err
        assert Path("out/absorber_mass.txt").exists()
        Path("out/absorber_mass.txt").unlink()
        _mended(monkeypatch)


# ----------------------------------------------------------------------------
# Pages, pictures, sweeps, measured methods, Python.
# ----------------------------------------------------------------------------


def test_a_picture_that_fails_takes_nothing_along(monkeypatch: pytest.MonkeyPatch) -> None:
    every = plots.pictures_of
    monkeypatch.setattr(plots, "_image", lambda *_: b"")
    monkeypatch.setattr(plots, "pictures_of", lambda one: dict(list(every(one).items())[:6]))
    assert _run("-q").code == 0
    assert command("plot", "one.h5", "-o", "all").code == 0
    names = sorted(path.name for path in Path("all").iterdir())
    assert len(names) > 1

    real, calls = plots.make, []

    def make(result: Any, name: str) -> Any:
        calls.append(name)
        return _broken() if len(calls) == 1 else real(result, name)

    monkeypatch.setattr(plots, "make", make)
    found = command("plot", "one.h5", "-o", "some")
    assert found.code == 70 and f"the picture {calls[0]}: IndexError" in found.err
    assert len(list(Path("some").iterdir())) >= len(names) - 1
    calls.clear()
    found = command("report", "--html", "one.h5")
    assert found.code == 70 and Path("one.html").exists()


def test_python_has_the_result_and_its_file(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plots, "_image", lambda *_: b"")
    monkeypatch.setattr(plots, "vector_picture", lambda _: None)
    monkeypatch.setattr(excitation, "excitation", _broken)
    result = api.run(GENERATOR)
    with pytest.raises(Defect, match=r"one\.h5: the result is whole"):
        api.write(result, "one.h5")
    assert api.read("one.h5").record.keys() == result.record.keys()
    for source, words in ((result, "generator"), ("one.h5", r"one\.h5")):
        failed = rf"^{words}: the result is whole.*\n  vibecalc\.excitation\.report:excitation: Ind"
        with pytest.raises(Defect, match=failed) as error:
            api.report(source)
        assert "Parts left out because of a bug" in error.value.made
        with pytest.raises(Defect, match=rf"^{words}: the result is whole"):
            api.report(source, html=True)
    monkeypatch.setattr("vibecalc.core.report.calculation.html_document", _broken)
    with pytest.raises(Defect, match=r"^one\.h5: (.|\n)*  the report: IndexError: nothing there"):
        api.report("one.h5", html=True)
    whole = plots.make

    def make(result: Any, name: str) -> Any:
        return _broken() if name == "shaking" else whole(result, name)

    monkeypatch.setattr(plots, "make", make)
    with pytest.raises(Defect, match=r"^generator: (.|\n)*the picture shaking: Ind") as error:
        api.plot(result, "pictures", only=("shaking", "run_up"))
    assert str(error.value).count("the picture shaking") == 1
    assert [one.name for one in error.value.made] == ["generator_run_up.png"]


# ----------------------------------------------------------------------------
# Tables that are wider than a page.
# ----------------------------------------------------------------------------


def test_a_table_that_is_too_wide_goes_on_below() -> None:
    """With the names of its rows, and no number is broken over lines."""
    columns = (Column("name"), *(number(f"column {n}") for n in range(12)))
    values = [f"-{n}.234567e-123" for n in range(12)]
    rows = [[name, *values] for name in ("first " + "x" * 40, "second")]
    (block,) = table(columns, rows)
    lines = block.split("\n")
    assert max(map(len, lines)) <= 100
    assert all(block.count(value) == 2 for value in values)
    assert sum(line.startswith("  second") for line in lines) == block.count("name ")
    (block,) = table((Column("size"), number("n")), [["300.125/180.25", "1"]])
    assert "300.125/180.25" in block


# ----------------------------------------------------------------------------
# What stands in the way of a picture is said.
# ----------------------------------------------------------------------------


def test_matplotlib_missing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(UsageError) as raised:
        draw_file(generator(), tmp_path)
    assert "matplotlib" in str(raised.value)
    assert "pip install 'vibecalc[plot]'" in str(raised.value)
    assert raised.value.exit_code == 2
    assert list(tmp_path.iterdir()) == []


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
