"""Claim: every command in README.md works as printed, and what it shows is what comes out."""

import re
import shlex
import subprocess
from pathlib import Path

import pytest
from drawn import coarse
from fuzzing import command

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```sh\n(.*?)```", README, re.S)
LINES = [line.split("#")[0].strip() for block in BLOCKS for line in block.splitlines()]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "cases").symlink_to(ROOT / "cases")
    monkeypatch.chdir(tmp_path)
    coarse(monkeypatch)
    return tmp_path


def test_commands_work_in_the_order_printed(folder: Path) -> None:
    done = [shlex.split(line) for line in LINES if line.startswith("vibecalc ")]
    assert len(done) >= 7
    for words in done:
        outcome = command(*words[1:])
        assert outcome.code == 0, (words, outcome.err)
    assert (folder / "mine.toml").is_file()
    assert (folder / "outputs" / "generator.txt").is_file()
    assert list((folder / "outputs").glob("generator*.png"))


def test_make_targets_exist_and_bare_make_prints_them() -> None:
    targets = [line.split()[1] for line in LINES if line.startswith("make ")]
    assert targets[:2] == ["run", "test"]
    shown = subprocess.run(["make"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    wanted = {"run", "test", "check", "golden", "plots", "clean"}
    assert wanted | set(targets) <= {line.split()[0] for line in shown.splitlines() if line}


def test_the_summary_shown_is_the_summary_printed(folder: Path) -> None:
    shown = re.search(r"<!-- summary -->\n```\n(.*?)```", README, re.S)
    assert shown is not None
    printed = command("run", "cases/generator.toml").out
    for line in shown[1].splitlines():
        assert line.strip() in printed, line


def test_pictures_and_documents_that_are_linked_exist() -> None:
    links = re.findall(r"\]\(([^)#]+)\)", README)
    assert links
    missing = [link for link in links if "://" not in link and not (ROOT / link).exists()]
    assert not missing


def test_every_command_and_option_of_the_table_is_in_the_help() -> None:
    rows = re.findall(r"^\| `vibecalc (\w+)([^|`]*)`", README, re.M)
    assert {name for name, _ in rows} >= {"run", "check", "verify", "report", "diff", "plot", "new"}
    for name, usage in rows:
        text = command(name, "--help").out
        for option in re.findall(r"--[a-z]+", usage):
            assert option in text, (name, option)
