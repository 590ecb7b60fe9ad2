"""Claim: a slip of the hand on the command line costs neither a file nor a true exit code.

Arguments the wrong way round overwrite nothing, one file name for several results is refused, and
a terminal that cannot show a letter is no bug.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from fuzzing import command
from small_case import SMALL

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(autouse=True)
def _with_a_case(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("one.toml").write_text(SMALL, encoding="utf-8")
    Path("two.toml").write_text(SMALL, encoding="utf-8")


def test_accept_overwrites_no_case_file() -> None:
    assert command("run", "one.toml", "-q").code == 0
    outcome = command("diff", "one.toml", "outputs/one.h5", "--accept")
    assert outcome.code == 2
    assert "one.toml is not a result file" in outcome.err and "comes first" in outcome.err
    assert Path("one.toml").read_text(encoding="utf-8") == SMALL
    assert command("diff", "golden/one.h5", "outputs/one.h5", "--accept").code == 0
    assert command("diff", "golden/one.h5", "outputs/one.h5", "--accept").code == 0


def test_accept_compares_nothing_and_says_so() -> None:
    for option in ("--rules", "--junit"):
        outcome = command("diff", "golden.h5", "one.h5", "--accept", option, "given")
        assert outcome.code == 2
        assert f"--accept compares nothing, leave {option} out" in outcome.err


def test_one_file_for_two_cases_is_refused() -> None:
    outcome = command("run", "one.toml", "two.toml", "-q", "-o", "both.h5")
    assert outcome.code == 2
    assert "-o both.h5 is one result file" in outcome.err and "-o both.h5/" in outcome.err
    assert not Path("both.h5").exists()
    assert command("run", "one.toml", "two.toml", "-q", "-o", "both.h5/").code == 0
    assert sorted(path.name for path in Path("both.h5").glob("*.h5")) == ["one.h5", "two.h5"]
    assert command("run", "one.toml", "-q", "-o", "").code == 2


def test_letters_that_the_terminal_lacks_are_escaped() -> None:
    ended = subprocess.run(
        [sys.executable, "-m", "vibecalc", "run", "one.toml"],
        capture_output=True, check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "ascii"},
    )  # fmt: skip
    assert (ended.returncode, ended.stderr) == (0, b"")
    assert b"Gr\\xf6\\xdfe \\xb5 \\u4e09" in ended.stdout


def test_rerun_can_be_pasted_into_a_shell() -> None:
    Path("my case.toml").write_text(SMALL, encoding="utf-8")
    done = command("run", "my case.toml", "-q", "--set", 'title="it\'s"')
    assert (done.code, done.out, done.err) == (0, "", "")
    report = command("report", "outputs/my case.h5", "--full").out
    (line,) = [line for line in report.splitlines() if line.startswith("  rerun ")]
    words = subprocess.run(
        ["sh", "-c", f"printf '%s\\n' {line.split('rerun', 1)[1]}"],
        capture_output=True,
        text=True,
        check=True,
    ).stdout.splitlines()
    assert words == ["vibecalc", "run", "my case.toml", "-q", "--set", 'title="it\'s"']


def test_a_search_without_a_way_names_limit_and_variable() -> None:
    text = SMALL.replace("[excitation]", "[excitation]\norders = 2\n")
    text += """
[optimisation]
variables = [{ key = "machine.crank_train.reciprocating_mass", min = "400 g", max = "600 g" }]
objective = { quantity = "excitation/couple_peak" }
starts = 1

[[limit]]
quantity = "excitation/force_peak"
max = "1 N"
"""
    Path("narrow.toml").write_text(text, encoding="utf-8")
    outcome = command("run", "narrow.toml")
    assert outcome.code == 3
    assert "no values of the variables between their bounds keep all limits" in outcome.err
    words = " ".join(outcome.out.split())
    assert "these come nearest, all results are for them: machine.crank_train." in words
    assert "reciprocating_mass = 400 g" in words
    assert re.search(r"excitation/ ?force_peak at direction=\w is [\d.]+ N, at most 1 N is", words)
    assert Path("outputs/narrow.h5").is_file()
    report = Path("outputs/narrow.txt").read_text(encoding="utf-8")
    assert "nearest" in report and "optimum" not in report.partition("Limits")[0]


def test_a_case_that_fails_is_named_and_the_others_are_verified() -> None:
    undamped = """
[machine.body]
mass = 100
inertia = [6, 6, 6]
[machine.mounts]
each = { stiffness = 25000 }
positions = [[-1, -1, 0], [-1, 1, 0], [1, -1, 0], [1, 1, 0]]
[isolation]
model = "rigid_body"
"""
    text = SMALL.replace('"3000 rpm"', repr(1000.0**0.5)) + undamped  # heave: 4 k / m = 1000
    Path("on.toml").write_text(text, encoding="utf-8")
    limit = '[[limit]]\nquantity = "excitation/force_peak"\nmax = "1 N"\n'
    Path("over.toml").write_text(SMALL + limit, encoding="utf-8")
    assert command("verify", "on.toml").code == 3
    outcome = command("verify", "on.toml", "over.toml")
    assert outcome.code == 3
    assert "error: on.toml: order 1" in outcome.err
    assert "MISSED limit on excitation/force_peak" in outcome.out
