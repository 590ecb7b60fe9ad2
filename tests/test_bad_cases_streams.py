"""Claim: Ctrl-C and an output that takes no more are one sentence each and never called a bug."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from long_but import long_but

CASES = Path(__file__).parents[1] / "cases"
GENERATOR = str(CASES / "generator.toml")
PROGRAM = [sys.executable, "-m", "vibecalc"]

PRINTING = (
    ["verify", GENERATOR, "--json"],
    ["--help"],
    ["check", GENERATOR],
    ["schema"],
    ["run", "--help"],
)

# Ctrl-C arrives in the middle of the command: when it first asks for the tables of a case
INTERRUPTED = """
import sys
from vibecalc.__main__ import main

class Struck:
    def find_spec(self, name, path=None, target=None):
        if name == "{module}":
            raise KeyboardInterrupt

sys.meta_path.insert(0, Struck())
sys.argv = ["vibecalc", *{arguments!r}]
main()
"""


@pytest.mark.parametrize("arguments", long_but(PRINTING, ["check", GENERATOR]), ids=" ".join)
def test_a_full_device(arguments: list[str]) -> None:
    with open("/dev/full", "w") as full:
        ended = subprocess.run(
            [*PROGRAM, *arguments], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert ended.returncode == 2
    assert ended.stderr == "error: cannot write to standard output: no space left on device\n"


@pytest.mark.parametrize("arguments", long_but(PRINTING, ["--help"]), ids=" ".join)
def test_a_closed_pipe(arguments: list[str]) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    ended = subprocess.run(
        [*PROGRAM, *arguments], stdout=writing, stderr=subprocess.PIPE, text=True, check=False
    )
    os.close(writing)
    assert ended.returncode == 130
    assert ended.stderr == "error: cannot write to standard output: it was closed by its reader\n"


def test_a_full_stderr_changes_no_exit_code() -> None:
    with open("/dev/full", "w") as full:
        ended = subprocess.run([*PROGRAM, "check", "no.toml"], stderr=full, check=False)
    assert ended.returncode == 2


@pytest.mark.parametrize(
    ("module", "arguments"),
    [
        ("vibecalc.schema", ["run", GENERATOR]),
        ("vibecalc.core.report.plots", ["plot", "a.h5"]),
        *(
            pytest.param(*one, marks=pytest.mark.long)
            for one in (
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
    ended = subprocess.run(
        [sys.executable, "-c", INTERRUPTED.format(module=module, arguments=arguments)],
        capture_output=True, text=True, check=False, cwd=tmp_path,
    )  # fmt: skip
    assert ended.returncode == 130
    assert ended.stderr == "interrupted: no half-written file is left behind\n"
    assert not list(tmp_path.iterdir())
