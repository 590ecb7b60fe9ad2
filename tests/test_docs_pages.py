"""Claim: blocks of README, tutorials and guides work as printed, and show what comes out."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from drawn import coarse
from fuzzing import command
from long_but import long_but
from page_run import blocks_of, pictures_of, run_page
from pages import missing_names, table
from shipped_cases import ROOT

from vibecalc.core.results.layout import STATUS_WORDS, TARGETS
from vibecalc.core.results.record import Record
from vibecalc.core.results.store import read_result
from vibecalc.core.results.sweep_file import open_sweep
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import load_checked
from vibecalc.core.study.planned import find_entries
from vibecalc.units import convert

DOCS = ROOT / "docs"
#: pages that are scripts
GUIDES = [DOCS / "guide_absorber.md"]
LONG = [DOCS / "guide_propulsion.md"]
PAGES = [*sorted(DOCS.glob("tutorials/*.md")), *sorted(DOCS.glob("how_to/*.md")), *GUIDES]
README, CONTRIBUTING = ROOT / "README.md", DOCS / "contributing.md"
ACCURACY, SEARCHES, SWEEPS = (DOCS / f"{name}.md" for name in ("accuracy", "searches", "sweeps"))
TEXT = {page: page.read_text(encoding="utf-8") for page in (README, ACCURACY, SEARCHES, SWEEPS)}


def without_make(text: str) -> str:
    """What makes numbers golden, draws all, or runs tests is for a person; so is code to copy."""
    return re.sub(r"(?m)^(make .*|vibecalc .*--accept.*)\n", "", text).replace(
        "```python", "```text"
    )


@pytest.fixture
def ran(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Path]:
    """A page that was run in a folder of its own, which is the one of the test from then on."""
    coarse(monkeypatch)
    monkeypatch.setattr("vibecalc.core.accuracy.topic._ENOUGH", 0.0)

    def page_ran(page: Path, change: Callable[[str], str] = str) -> Path:
        text = page.read_text(encoding="utf-8")
        if "plot" in text or "--html" in text:
            pytest.importorskip("matplotlib")
        run_page(page, tmp_path, change)
        monkeypatch.chdir(tmp_path)
        return tmp_path

    return page_ran


@pytest.mark.parametrize("page", long_but([*PAGES, *LONG], *PAGES), ids=lambda path: path.stem)
def test_a_page_runs_and_prints_what_it_shows(page: Path, ran: Callable[..., Path]) -> None:
    folder = ran(page)
    for picture in pictures_of(page, DOCS / "pictures" / "drawn"):
        assert [*folder.rglob(picture.name)], picture


@pytest.mark.parametrize("page", [*PAGES, *LONG, SEARCHES], ids=lambda path: path.stem)
def test_a_page_has_nothing_that_is_not_run_and_names_what_is_there(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    blocks = blocks_of(text)
    assert text.count("```") == 2 * len(blocks)
    assert {one.language for one in blocks} <= {"sh", "toml", "python", "text", "yaml", ""}
    left = [one.text for one in blocks if one.language == "text"]
    assert not [one for one in left if re.search(r"^(vibecalc|import|from) ", one, re.M)]
    assert any(one.language in ("sh", "python", "toml") for one in blocks)
    assert missing_names(text, str(page.parent.relative_to(ROOT))) == []


def test_the_start_page_links_each_page_and_works_in_a_clone() -> None:
    links = re.findall(r"\]\(([\w/.]+)\)", (DOCS / "index.md").read_text(encoding="utf-8"))
    assert [link for link in links if not (DOCS / link).is_file()] == []
    for path in (*DOCS.glob("*.md"), *PAGES):
        name = str(path.relative_to(DOCS))
        assert name == "index.md" or name in links, name


# ----------------------------------------------------------------------------
# README.md and docs/contributing.md.
# ----------------------------------------------------------------------------


@pytest.mark.parametrize("page", [README, CONTRIBUTING], ids=lambda path: path.stem)
def test_commands_for_users_and_developers_work(page: Path, ran: Callable[..., Path]) -> None:
    folder = ran(page, without_make)
    assert [*folder.glob("outputs/*.h5")]
    assert bool([*folder.glob("outputs/generator*.png")]) == (page is README)


def test_make_targets_exist_and_bare_make_prints_them() -> None:
    targets = re.findall(r"(?m)^make (\w+)", TEXT[README])
    assert targets[:2] == ["run", "test"]
    shown = subprocess.run(["make"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    wanted = {"run", "test", "check", "golden", "plots", "clean"}
    assert wanted | set(targets) <= {line.split()[0] for line in shown.splitlines() if line}


def test_pictures_and_documents_that_are_linked_exist() -> None:
    links = re.findall(r"\]\(([^)#]+)\)", TEXT[README])
    assert links
    missing = [link for link in links if "://" not in link and not (ROOT / link).exists()]
    assert not missing


def test_every_command_and_option_of_the_table_is_in_the_help() -> None:
    rows = re.findall(r"^\| `vibecalc (\w+)([^|`]*)`", TEXT[README], re.M)
    assert {name for name, _ in rows} >= {"run", "check", "verify", "report", "diff", "plot", "new"}
    for name, usage in rows:
        text = command(name, "--help").out
        for option in re.findall(r"--[a-z]+", usage):
            assert option in text, (name, option)


# ----------------------------------------------------------------------------
# docs/accuracy.md.
# ----------------------------------------------------------------------------


def test_the_table_of_a_measurement_is_shown_and_the_file_has_what_is_named(
    ran: Callable[..., Path],
) -> None:
    """Method, setting and work; seconds are those of a machine, errors have its rounding."""
    folder = ran(ACCURACY, lambda text: text.replace("```\nkinematics", "```text\nkinematics"))
    text = (folder / "outputs" / "generator.accuracy.txt").read_text(encoding="utf-8")
    (excerpt,) = re.findall(r"<!-- excerpt -->\n```\n(.*?)```", TEXT[ACCURACY], re.S)
    printed = [line[:40].rstrip() for line in text.splitlines()]
    shown = [line[:40].rstrip() for line in excerpt.splitlines()]
    assert [line for line in shown if line not in printed] == []
    record = read_result(folder / "outputs" / "generator.accuracy.h5").record
    names = {path.rsplit("/", 1)[1] for path in record}
    paragraph = " ".join(TEXT[ACCURACY].split("### The file")[1].split("### ")[0].split())
    named = set(re.findall(r"`(?:accuracy/<stage>/<question>/)?(\w+)`", paragraph))
    axes = {"trial", "method", "diff"}
    assert names | {"position_error"} == (named - axes) | {"order_kind", "position_error"}


def test_options_and_targets_are_those_of_the_command() -> None:
    text = command("accuracy", "--help").out
    section = TEXT[ACCURACY].split("## Compare methods on your case")[1]
    for option in re.findall(r"--[a-z]+", section.split("### How to read")[0]):
        assert option in text, option
    assert "1e-3, 1e-6 and 1e-9" in TEXT[ACCURACY] and TARGETS == (1e-3, 1e-6, 1e-9)


# ----------------------------------------------------------------------------
# docs/searches.md.
# ----------------------------------------------------------------------------


def test_searches_find_what_the_page_asks_for_and_its_table_has_every_path(
    ran: Callable[..., Path],
) -> None:
    folder = ran(SEARCHES)
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
    rows = re.findall(r"^\| (`.*?) \|", TEXT[SEARCHES].split("\n## ")[1], re.M)
    reported = {name for row in rows for name in re.findall(r"`(\w+)`", row)}
    own = [path.split("/", 2)[2] for path in find_entries(load_checked(["finds.toml"])[0].case)]
    assert reported == {name for name in own if "/" not in name}
    assert "`scaled_with/<key>`" in rows[3] and "`machine/<path>`" in rows[4]
    assert {name.split("/")[0] for name in own if "/" in name} == {"scaled_with", "machine"}


# ----------------------------------------------------------------------------
# docs/sweeps.md, as far as one machine allows.
# ----------------------------------------------------------------------------


@pytest.mark.parametrize("points", ["3log", pytest.param("21log", marks=pytest.mark.long)])
def test_sweeps_work_in_the_order_printed(points: str, ran: Callable[..., Path]) -> None:
    """As printed, and with fewer points."""
    assert "21log" in TEXT[SWEEPS]
    folder = ran(SWEEPS, lambda text: text.replace("21log", points))
    assert (folder / "outputs" / "generator.sweep.txt").is_file()
    assert list((folder / "outputs").glob("*.png"))


def test_every_status_is_explained_with_its_words() -> None:
    rows = dict(re.findall(r"^\| (-?\d) \| ([a-z ]+?) \|", TEXT[SWEEPS], re.M))
    assert rows == {str(status): words for status, words in STATUS_WORDS.items()}


@pytest.mark.long
def test_the_lines_for_dask_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    dask = Path(sys.executable).with_name("dask")
    if not dask.is_file():
        pytest.skip("the command dask is not next to this Python")
    (tmp_path / "cases").symlink_to(ROOT / "cases")
    (tmp_path / "bin").mkdir()
    shutil.copy(dask, tmp_path / "bin" / "dask")
    program = tmp_path / "bin" / "vibecalc"
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m vibecalc "$@"\n', encoding="ascii")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{program.parent}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.chdir(tmp_path)
    (script,) = [one.text for one in blocks_of(TEXT[SWEEPS]) if "dask scheduler" in one.text]
    script = script.replace("scheduler.json &", "scheduler.json --port 0 "
        "--no-dashboard > scheduler.log 2>&1 &\nscheduler=$!", 1)  # fmt: skip
    script = script.replace("--nthreads 1 &", "--nthreads 1 --no-dashboard > worker.log 2>&1 &\n"
        "worker=$!\ntrap 'kill $worker; sleep 0.5; kill $scheduler; wait' EXIT\n"
        "while [ ! -s scheduler.json ]; do sleep 0.1; done", 1)  # fmt: skip
    done = subprocess.run(
        ["bash", "-e", "-c", script], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    with open_sweep("outputs/on_cluster.h5") as found:
        assert found.count == 16 and not found.status().any()


# ----------------------------------------------------------------------------
# What the guides try gives what is printed.
# ----------------------------------------------------------------------------

TRIED = {path: path.read_text(encoding="utf-8") for path in (*GUIDES, *LONG)}
ROWS = [(path, row) for path, text in TRIED.items() for row in table(text, "change")]


def propulsion(record: Record) -> list[str]:
    """The highest utilisation of a limit, and the barred ranges."""
    ends = [record[f"response/torsion/barred/{name}"].values for name in ("from", "to")]
    shown = [[f"{convert(one, 'rad/s', 'rpm'):.4g}" for one in end] for end in ends]
    ranges = ", ".join(f"{low} to {high}" for low, high in zip(*shown, strict=True)) or "none"
    use = float(record["response/torsion/limit/largest_utilisation"].values[0])
    return [f"{100.0 * use:.4g} %", ranges]


def absorber(record: Record) -> list[str]:
    """Stiffness in N/mm, damping, and acceleration in mm/s^2."""
    motion = "response/absorber/motion/largest/acceleration"
    paths = {"tuning/linear_stiffness": 1e-3, "tuning/linear_damping": 1.0, motion: 1e3}
    return [f"{float(record[path].values) * scale:.4g}" for path, scale in paths.items()]


@pytest.mark.long
@pytest.mark.parametrize(("page", "row"), ROWS, ids=lambda one: getattr(one, "stem", ""))
def test_what_is_tried_gives_what_is_printed(page: Path, row: list[str], tmp_path: Path) -> None:
    case = "\n".join(re.findall(r"```toml\n(.*?)```", TRIED[page], re.S))
    (tmp_path / "case.toml").write_text(case, encoding="utf-8")
    for card in (ROOT / "cases").glob("marine_gas_pressure_*.csv"):
        shutil.copy(card, tmp_path)
    settings = [word for word in shlex.split(row[1].strip("`")) if word != "--set"]
    (loaded,) = load_checked([tmp_path / "case.toml"], settings)
    found = (absorber if page in GUIDES else propulsion)(run_case(loaded.case))
    assert [one.replace(".0 ", " ") for one in found] == row[2:]
