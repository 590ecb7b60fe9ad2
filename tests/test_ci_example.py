"""Claim: docs/ci_example runs what has changed, and a number that has moved fails by its name."""

import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml
from junitparser import Failure, JUnitXml

from vibecalc.core.results import compare_rules

ROOT = Path(__file__).resolve().parents[1]
EXAMPLE, PAGE = ROOT / "docs" / "ci_example", ROOT / "docs" / "ci.md"
Run = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture
def run(tmp_path: Path) -> Run:
    """A command in a folder that begins with the three files, where `vibecalc` is on the path."""
    for name in ("Makefile", "rules.toml", "pipeline.yml"):
        shutil.copy(EXAMPLE / name, tmp_path)
    around = {name: value for name, value in os.environ.items() if not name.startswith("MAKE")}
    around["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{around['PATH']}"

    def ended(*words: str) -> "subprocess.CompletedProcess[str]":
        return subprocess.run(
            words, cwd=tmp_path, env=around, capture_output=True, text=True, check=False
        )

    return ended


def replace(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


def ran(ended: "subprocess.CompletedProcess[str]") -> list[str]:
    return sorted(re.findall(r"^wrote outputs/(\w+)\.h5", ended.stdout, re.M))


def failures(junit: Path) -> dict[tuple[str, str], str]:
    """Suite and quantity -> what is said of it, as a reader of JUnit files finds it."""
    return {
        (suite.name, f"{case.classname}.{case.name}"): said.message
        for suite in JUnitXml.fromfile(str(junit))
        for case in suite
        for said in case.result
        if isinstance(said, Failure)
    }


def begin(run: Run) -> None:
    """What the page says to begin with, up to the first golden files."""
    section = PAGE.read_text(encoding="utf-8").split("\n## Continuous integration\n")[1]
    (block,) = re.findall(r"```sh\n(.*?)```", section, re.S)
    for line in block.splitlines()[:3]:
        ended = run(*shlex.split(line))
        assert ended.returncode == 0, ended.stderr
    assert ran(ended) == ["compressor_motor", "i3"]


@pytest.mark.long
def test_a_case_that_breaks_is_red_and_holds_up_no_other(run: Run, tmp_path: Path) -> None:
    """Of two commits: at the second one case is broken, another's numbers move, a third is new."""
    begin(run)
    junit = tmp_path / "outputs" / "junit.xml"
    assert run("make", "-j2", "diff").returncode == 0 and failures(junit) == {}
    replace(tmp_path / "cases" / "i3.toml", "schema = 1", "schema = 1\ntitel = 1")
    replace(tmp_path / "cases" / "compressor_motor.toml", "\nspeed = ", "\nspeed = 10 # ")
    shutil.copy(ROOT / "cases" / "generator.toml", tmp_path / "cases")
    red = run("make", "-j2", "diff")
    assert red.returncode == 2 and "titel" in red.stderr
    assert ran(red) == ["compressor_motor", "generator"]
    failed = failures(junit)
    assert ("i3.h5", "vibecalc.file") in failed and ("generator.h5", "vibecalc.file") in failed
    assert len([1 for suite, _ in failed if suite == "compressor_motor.h5"]) > 1
    assert not (tmp_path / "outputs" / "i3.h5").exists()
    # nothing can be compared: no green report of an earlier time is left
    (tmp_path / "rules.toml").write_text("[[rule]]\n", encoding="utf-8")
    assert run("make", "diff").returncode == 2
    assert len(failures(junit)) == 3


@pytest.mark.long
def test_the_pipeline_does_what_the_page_says(run: Run, tmp_path: Path) -> None:
    """All its lines, in two clones without dates; data files count, pages come in any case."""
    begin(run)
    (job,) = yaml.safe_load((EXAMPLE / "pipeline.yml").read_text(encoding="utf-8")).values()
    (line,) = job["script"]
    green = run(*shlex.split(line))
    assert green.returncode == 0 and ran(green) == []
    page = tmp_path / "outputs" / "i3.html"
    assert page.read_text(encoding="utf-8").count("image/svg+xml") > 0
    assert (tmp_path / job["artifacts"]["reports"]["junit"]).is_file()
    for pattern in job["artifacts"]["paths"]:
        assert len(list(tmp_path.glob(pattern))) == 2

    (table,) = (tmp_path / "cases").glob("*.csv")
    rows = table.read_text(encoding="utf-8").splitlines()
    first, *rest = rows[-1].split(",")
    rows[-1] = ",".join([first, *(f"{1.01 * float(cell) + 1e-3}" for cell in rest)])
    table.write_text("\n".join(rows) + "\n", encoding="utf-8")
    page.unlink()
    red = run(*shlex.split(line))
    assert red.returncode == 2 and ran(red) == ["compressor_motor"] and page.is_file()
    assert {suite for suite, _ in failures(tmp_path / "outputs" / "junit.xml")} == {
        "compressor_motor.h5"
    }


def test_the_page_names_what_there_is() -> None:
    page = PAGE.read_text(encoding="utf-8")
    keys = set(re.findall(r"^\| `(\w+)` \|", page, re.M))
    assert keys == set(compare_rules.KEYS)
    for kind in compare_rules.KINDS:
        assert f"`{kind}`" in page
    rules = compare_rules.read_rules(EXAMPLE / "rules.toml")
    assert len(rules.rules) == len(tomllib.loads((EXAMPLE / "rules.toml").read_text())["rule"])
    assert "1e-7 of" in page and compare_rules.DEFAULT.rtol == 1e-7
    assert "1e-4." in page and compare_rules.CURVE_RTOL == 1e-4
