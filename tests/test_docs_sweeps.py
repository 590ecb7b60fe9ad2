"""Claim: what docs/sweeps.md shows works as printed, as far as one machine allows."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from drawn import coarse
from fuzzing import command

from vibecalc.core.results.layout import STATUS_WORDS
from vibecalc.core.results.sweep_file import open_sweep

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "docs" / "sweeps.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(\w+)\n(.*?)```", PAGE, re.S)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder with the cases, and `vibecalc` of this checkout on the path."""
    (tmp_path / "cases").symlink_to(ROOT / "cases")
    (tmp_path / "bin").mkdir()
    program = tmp_path / "bin" / "vibecalc"
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m vibecalc "$@"\n', encoding="ascii")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{program.parent}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def block(kind: str, with_words: str) -> str:
    (found,) = [text for name, text in BLOCKS if name == kind and with_words in text]
    return found


def shell(script: str, **environment: str) -> None:
    done = subprocess.run(
        ["bash", "-e", "-c", script], env={**os.environ, **environment},
        capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("points", ["3log", pytest.param("21log", marks=pytest.mark.long)])
def test_commands_work_in_the_order_printed(
    folder: Path, monkeypatch: pytest.MonkeyPatch, points: str
) -> None:
    """As printed, and with fewer points."""
    coarse(monkeypatch)
    pytest.importorskip("matplotlib")
    assert "21log" in block("sh", "--dry-run")
    for line in block("sh", "--dry-run").replace("21log", points).splitlines():
        outcome = command(*shlex.split(line)[1:], cap=60)
        assert outcome.code == 0, (line, outcome.err)
    assert (folder / "outputs" / "generator.sweep.txt").is_file()
    assert list((folder / "outputs").glob("*.png"))


def test_every_status_is_explained_with_its_words() -> None:
    rows = dict(re.findall(r"^\| (-?\d) \| ([a-z ]+?) \|", PAGE, re.M))
    assert rows == {str(status): words for status, words in STATUS_WORDS.items()}


@pytest.mark.long
def test_the_lines_for_dask_work(folder: Path) -> None:
    pytest.importorskip("distributed")
    dask = Path(sys.executable).with_name("dask")
    if not dask.is_file():
        pytest.skip("the command dask is not next to this Python")
    shutil.copy(dask, folder / "bin" / "dask")
    script = block("bash", "dask scheduler").replace("scheduler.json &", "scheduler.json --port 0 "
        "--no-dashboard > scheduler.log 2>&1 &\nscheduler=$!", 1)  # fmt: skip
    script = script.replace("--nthreads 1 &", "--nthreads 1 --no-dashboard > worker.log 2>&1 &\n"
        "worker=$!\ntrap 'kill $worker; sleep 0.5; kill $scheduler; wait' EXIT\n"
        "while [ ! -s scheduler.json ]; do sleep 0.1; done", 1)  # fmt: skip
    shell(script)
    with open_sweep("outputs/on_cluster.h5") as found:
        assert found.count == 16 and not found.status().any()
