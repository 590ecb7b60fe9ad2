"""Claim: Ctrl-C and an output that takes no more are one sentence each and never called a bug."""

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from long_but import long_but

from vibecalc.core.results.store import read_result

CASES = Path(__file__).parents[1] / "cases"
GENERATOR = str(CASES / "generator.toml")
PROGRAM = [sys.executable, "-m", "vibecalc"]

RESULT = str(CASES.parent / "tests" / "golden" / "generator.h5")
PRINTING = (
    ["verify", GENERATOR, "--json"],
    ["report", RESULT],
    ["run", GENERATOR],
    ["plot", RESULT, "--only", "shaking", "-o", "pictures"],
    ["accuracy", GENERATOR, "--longest", "0.5"],
    ["--help"],
    ["check", GENERATOR],
    ["schema"],
    ["run", "--help"],
)

# Ctrl-C arrives in the middle of the command, in one of the ways that libraries have with it
INTERRUPTED = """
import os, signal, sys

class Struck:
    def find_spec(self, name, path=None, target=None):
        if name == "{module}":
            try:
                exec("os.kill(os.getpid(), signal.SIG{came}); [None for _ in range(99)]")
            except KeyboardInterrupt as error:
                {then}

sys.meta_path.insert(0, Struck())
"""
THEN = {"passed on": "raise", "swallowed": "pass", "another error": "raise ValueError from error"}


def _name(arguments: list[str]) -> str:
    return " ".join(Path(one).name for one in arguments)


def ended(words: Sequence[str], folder: Path, **streams: Any) -> "subprocess.CompletedProcess[str]":
    """A command that has come to its end in a folder, with what it said on all other streams."""
    kept = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | streams
    return subprocess.run(words, text=True, check=False, cwd=folder, **kept)


@contextlib.contextmanager
def sink(kind: str) -> Iterator[int]:
    """An output that takes nothing: a full device, or a pipe without a reader."""
    if kind == "full":
        writing = os.open("/dev/full", os.O_WRONLY)
    else:
        reading, writing = os.pipe()
        os.close(reading)
    yield writing
    os.close(writing)


SINKS = {"full": (2, "no space left on device"), "closed": (130, "it was closed by its reader")}
INTO = [(kind, arguments) for kind in SINKS for arguments in PRINTING]


@pytest.mark.parametrize(
    "into", long_but(INTO, ("full", ["report", RESULT]), ("closed", ["run", GENERATOR])),
    ids=lambda into: f"{into[0]} {_name(into[1])}",
)  # fmt: skip
def test_an_output_that_takes_no_more(into: tuple[str, list[str]], tmp_path: Path) -> None:
    kind, arguments = into
    with sink(kind) as writing:
        done = ended([*PROGRAM, *arguments], tmp_path, stdout=writing)
    code, why = SINKS[kind]
    assert done.returncode == code
    assert done.stderr == f"error: cannot write to standard output: {why}\n"
    written = (tmp_path / "outputs" / "generator.txt").is_file()
    assert written == (arguments == ["run", GENERATOR])


@pytest.mark.parametrize(
    "arguments",
    long_but(
        [["check", "no.toml"], ["check"], ["check", "--json"], ["check", "no.toml", "-v"]],
        ["check", "no.toml", "-v"],
    ),
    ids=" ".join,
)
def test_a_full_stderr_changes_no_exit_code(arguments: list[str], tmp_path: Path) -> None:
    with sink("full") as full:
        assert ended([*PROGRAM, *arguments], tmp_path, stderr=full).returncode == 2


@pytest.mark.parametrize(
    ("module", "arguments"),
    [
        ("vibecalc.schema", ["run", GENERATOR]),
        *(
            pytest.param(*one, marks=pytest.mark.long)
            for one in (
                ("vibecalc.core.report.plots", ["plot", "a.h5"]),
                ("vibecalc.schema", ["sweep", GENERATOR, "--dry-run"]),
                ("vibecalc.schema", ["check", GENERATOR]),
                ("vibecalc.schema", ["verify", GENERATOR]),
                ("vibecalc.schema", ["accuracy", GENERATOR]),
                ("vibecalc.core.study.sweep.assemble", ["merge", "a.h5", "b.h5", "-o", "c.h5"]),
                ("vibecalc.cli.starters", ["new", "generator"]),
                ("vibecalc.json_schema", ["schema"]),
                ("vibecalc.core.results.compare", ["diff", "a.h5", "b.h5"]),
                ("vibecalc.core.report.sweep.text", ["report", "a.h5"]),
            )
        ),
    ],
    ids=lambda value: value[0] if isinstance(value, list) else "",
)
def test_ctrl_c_says_so_in_every_command(module: str, arguments: list[str], tmp_path: Path) -> None:
    _struck(tmp_path, module, arguments, "INT", "passed on")


@pytest.mark.parametrize(
    ("came", "then"), [("INT", "swallowed"), ("INT", "another error"), ("TERM", "passed on")]
)
def test_an_interrupt_is_one_whatever_a_library_makes_of_it(
    came: str, then: str, tmp_path: Path
) -> None:
    _struck(tmp_path, "vibecalc.core.case.load", ["check", GENERATOR], came, then)


def _struck(folder: Path, module: str, arguments: list[str], came: str, then: str) -> None:
    """Run a command with a signal at the import of a module."""
    before, work = folder / "before", folder / "work"
    before.mkdir()
    work.mkdir()
    code = INTERRUPTED.format(module=module, came=came, then=THEN[then])
    (before / "sitecustomize.py").write_text(code)
    # Python ends a module that it runs by the signal where it thinks that nobody met it
    around = os.environ | {"PYTHONPATH": str(before)}
    done = ended([*PROGRAM, *arguments], work, env=around)
    assert done.returncode == 130, done.stderr
    assert done.stderr == "interrupted: no half-written file is left behind\n"
    assert not list(work.iterdir())


CLOSED = ("<&-", ">&-", "2>&-", "<&- >&- 2>&-")


@pytest.mark.parametrize("closed", long_but(CLOSED, CLOSED[-1]))
def test_a_closed_stream_changes_neither_files_nor_exit_code(closed: str, tmp_path: Path) -> None:
    program = f"{sys.executable} -m vibecalc"
    done = ended(["sh", "-c", f"exec {program} run {GENERATOR} {closed}"], tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    written = tmp_path / "outputs"
    assert sorted(one.name for one in written.iterdir()) == ["generator.h5", "generator.txt"]
    assert read_result(written / "generator.h5").name == "generator"
    assert ended(["sh", "-c", f"exec {program} check none.toml {closed}"], tmp_path).returncode == 2


def test_a_closed_stdin_is_an_empty_case(tmp_path: Path) -> None:
    done = ended(["sh", "-c", f"exec {sys.executable} -m vibecalc check - <&-"], tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("error: <stdin> is empty")


def test_a_case_from_a_pipe(tmp_path: Path) -> None:
    """As `vibecalc run <(command)` hands one over; no such result is up to date."""
    command = f"{sys.executable} -m vibecalc run --if-needed <(cat {GENERATOR})"
    for _ in range(2):
        done = ended(["bash", "-c", command], tmp_path)
        assert done.returncode == 0 and "Three-cylinder generator" in done.stdout


def spoken(folder: Path, *arguments: str | bytes, code: int = 0) -> str:
    """What a command says in a folder, in UTF-8."""
    ended = subprocess.run([*PROGRAM, *arguments], cwd=folder, capture_output=True, check=False)
    assert ended.returncode == code, ended.stderr
    return (ended.stdout + ended.stderr).decode("utf-8")


def test_a_name_in_another_encoding(tmp_path: Path) -> None:
    """Files get its bytes; texts, and the result itself, spell it out."""
    case = os.fsencode(tmp_path) + b"/F\xe4ll.toml"
    shutil.copy(GENERATOR, case)
    result = b"outputs/F\xe4ll.h5"
    assert r"outputs/F\xe4ll.h5" in spoken(tmp_path, "run", case)
    folder = os.fsencode(tmp_path) + b"/outputs"
    assert sorted(os.listdir(folder)) == [b"F\xe4ll.h5", b"F\xe4ll.txt"]
    assert r"F\xe4ll" in spoken(tmp_path, "info", result)
    words = spoken(tmp_path, "check", b"n\xe4.toml", code=2)
    assert words.startswith(r"error: n\xe4.toml does not exist")


def _of_folder(folder: Path) -> list[str]:
    """Numbers of the processes that work in a folder."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if (process / "cwd").readlink() == folder:
                found.append(process.name)
    return found


#: commands that would work for minutes
LONG_WORK = (
    ["sweep", GENERATOR, "--grid", "machine.speed=400 rpm:5000 rpm:200000", "-j", "2"],
    ["run", str(CASES / "generator_mount_design.toml"), "--set", "optimisation.starts=900"],
    ["accuracy", GENERATOR],
)


@pytest.mark.parametrize("arguments", long_but(LONG_WORK, *LONG_WORK[:2]), ids=lambda one: one[0])
def test_a_signal_in_the_middle(arguments: list[str], tmp_path: Path) -> None:
    """One line, the code of an interruption, and no process, lock or unfinished file after it."""
    if arguments[0] == "run":
        (tmp_path / "old.h5").write_bytes(b"the old result")
        arguments = [*arguments, "-o", "old.h5"]
    started = subprocess.Popen(
        [*PROGRAM, *arguments, "-v"], cwd=tmp_path, stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert started.stderr is not None
    for line in started.stderr:
        if "checked" in line or "read " in line:
            break
    time.sleep(0.2)
    started.send_signal(signal.SIGINT)
    _, words = started.communicate(timeout=60)
    assert started.returncode == 130, words
    assert "Traceback" not in words and "interrupted" in words
    assert not _of_folder(tmp_path)
    left = [one for one in tmp_path.rglob("*") if one.suffix in (".tmp", ".lock", ".h5")]
    assert [one.read_bytes() for one in left] == [b"the old result"] * (arguments[0] == "run")
