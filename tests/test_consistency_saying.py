"""Claim: `--quiet`, `--verbose` and `--json` are the same for all commands, colours add no word,
help has examples that work, a shell is offered what there is, a long run says what it is at.
"""

import io
import json
import re
import shlex
import shutil
import sys
import time
from pathlib import Path

import h5py
import pytest
from fuzzing import command
from shipped_cases import CASES, ROOT
from typer._completion_classes import BashComplete

from vibecalc.cli.colours import coloured
from vibecalc.cli.commands import app
from vibecalc.cli.examples import EXAMPLES
from vibecalc.core.study import variables as progress
from vibecalc.errors import EXIT_CODES

NAMES = [str(one.name or one.callback.__name__) for one in app.registered_commands if one.callback]
GOLDEN = ROOT / "tests" / "golden"
RESULT, CASE = str(GOLDEN / "absorber_mass.h5"), str(CASES["generator"])
SWEEP = ("--grid", "machine.speed=300,400", "--keep", "excitation/force_peak", "-j", "1")
#: a call of each command, and what its object has
CALLS: dict[str, tuple[tuple[str, ...], str]] = {
    "run": ((CASE,), "written"),
    "check": ((CASE,), "warnings"),
    "verify": ((CASE,), "limits"),
    "report": ((RESULT,), "headlines"),
    "diff": ((RESULT, RESULT), "same"),
    "plot": ((RESULT, "-o", "p", "--only", "absorber_curves", "--dpi", "50"), "written"),
    "new": (("roll", "-o", "roll.toml"), "written"),
    "schema": ((), "properties"),
    "sweep": ((CASE, *SWEEP), "written"),
    "merge": (("part.h5", "-o", "whole.h5"), "written"),
    "accuracy": ((CASE, "--stage", "kinematics", "--longest", "0.1"), "written"),
    "info": ((RESULT,), "quantities"),
    "get": ((RESULT, "response/absorber/peak/magnitude"), "value"),
    "export": ((RESULT, "-o", "e"), "written"),
    "migrate": ((CASE, "-o", "new.toml"), "renamed"),
}
#: what they print is a script for a shell, and a page for a person
WORDS_ONLY = {"completion": ("bash",), "help": ("run",)}


@pytest.fixture(scope="module")
def part(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("once") / "part.h5"
    assert command("sweep", CASE, *SWEEP, "-q", "-o", str(path)) == (0, "", "")
    return path.read_bytes()


@pytest.fixture(autouse=True)
def _in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, part: bytes) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("vibecalc.core.accuracy.topic._ENOUGH", 0.0)
    (tmp_path / "part.h5").write_bytes(part)


def test_every_command_is_tried() -> None:
    assert sorted(NAMES) == sorted([*CALLS, *WORDS_ONLY])


@pytest.mark.parametrize("name", NAMES)
def test_the_options_are_on_every_page(name: str) -> None:
    page = command(name, "--help").out
    assert "Print problems only, and JSON if requested." in page
    assert "Log each step with its time on stderr." in page
    assert ("--json" in page) == (name in CALLS)


@pytest.mark.parametrize("name", CALLS)
def test_json_is_all_that_stdout_has_and_steps_go_to_stderr(name: str) -> None:
    words, key = CALLS[name]
    outcome = command(name, *words, "--json", "-q", "-v")
    assert outcome.code == 0, outcome.err
    found = json.loads(outcome.out)
    assert key in (found[0] if isinstance(found, list) else found)
    one = found[0] if isinstance(found, list) else found
    for path in one["written"] if key == "written" else ():
        assert Path(path).is_file() and f"{Path(path).name}" in outcome.err
    steps = re.findall(r"^ *(\d+\.\d{3}) s  (\S.*)$", outcome.err, re.M)
    assert steps[0][1] == f"vibecalc {name}" and steps[-1][1] == "end"
    assert [float(time) for time, _ in steps] == sorted(float(time) for time, _ in steps)
    for word in words:
        if word in (CASE, RESULT, "part.h5"):
            assert any(re.match(f"(read|opened) .*{re.escape(word)}", step) for _, step in steps)


@pytest.mark.parametrize("name", ["get", "new", "export", *WORDS_ONLY])
def test_quiet_says_nothing(name: str) -> None:
    words = CALLS[name][0] if name in CALLS else WORDS_ONLY[name]
    said = command(name, *words)
    assert said.code == 0 and said.out and not said.err
    Path("roll.toml").unlink(missing_ok=True)
    assert command(name, *words, "-q") == (0, "", "")


def test_stages_are_told_as_they_run_and_no_longer_than_asked_for() -> None:
    told = command("run", CASE, "-v").err
    stages = re.findall(r"stage (\w+): \d+\.\d{3} s$", told, re.M)
    with h5py.File("outputs/generator.h5") as file:
        plan = [row["stage"] for row in json.loads(file.attrs["plan"])]
    assert stages == [name.replace(" ", "_") for name in plan]
    assert command("run", CASE, "-q").err == ""


def test_what_a_run_says_in_json_is_its_first_table() -> None:
    (one,) = json.loads(command("run", CASE, "--json").out)
    assert one["exit_code"] == 0 and one["written"] == [
        "outputs/generator.h5",
        "outputs/generator.txt",
    ]
    (again,) = json.loads(command("report", "outputs/generator.h5", "--json").out)
    assert again["headlines"] == one["headlines"] and again["quantities"] == one["quantities"]
    row = next(row for row in one["headlines"] if row["quantity"].endswith("/steady_peak"))
    assert row["unit"] == "N" and row["value"] == one["quantities"][row["quantity"]]["value"]
    (sweep,) = json.loads(command("report", "part.h5", "--json").out)
    assert sweep["statuses"] == {"done": sweep["points"]}
    accepted = json.loads(command("diff", "new.h5", RESULT, "--accept", "--json").out)
    assert accepted == {"written": ["new.h5"]}


PROBLEM = """error: unknown key 'spd' in [machine]
  --> case.toml:12:1
     |
  12 | spd = 3
     | ^^^ allowed: speed
  help: did you mean 'speed'?
1 error in case.toml, nothing was run"""


class _Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(
    ("terminal", "given", "wanted"),
    [
        (True, {}, True),
        (False, {}, False),
        (True, {"NO_COLOR": "1"}, False),
        (False, {"FORCE_COLOR": "1"}, True),
        (False, {"FORCE_COLOR": "1", "NO_COLOR": "1"}, False),
        (True, {"NO_COLOR": ""}, True),
        (True, {"TERM": "dumb"}, False),
        (True, {"TERM": "dumb", "FORCE_COLOR": "3"}, True),
    ],
)
def test_colours_are_where_they_are_wanted_and_change_no_word(
    terminal: bool, given: dict[str, str], wanted: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("NO_COLOR", "FORCE_COLOR"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("TERM", "xterm")
    for name, value in given.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(sys, "stderr", _Terminal() if terminal else io.StringIO())
    for text in (PROBLEM, "error: " + "long " * 60 + "words\twith [bold]marks[/bold] :smile:"):
        shown = coloured(text)
        assert (shown != text) == wanted
        assert re.sub(r"\x1b\[[\d;]*m", "", shown) == text


# ----------------------------------------------------------------------------
# What a long run is at.
# ----------------------------------------------------------------------------


class _Screen(io.StringIO):
    def __init__(self, is_terminal: bool) -> None:
        super().__init__()
        self.is_terminal = is_terminal

    def isatty(self) -> bool:
        return self.is_terminal


def _shown(monkeypatch: pytest.MonkeyPatch, screen: _Screen, seconds: float, wanted: bool) -> str:
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setattr(progress, "_QUIET", 0.02)
    monkeypatch.setattr(progress, "_STEP", 0.01)
    with progress.telling(wanted) as tell:
        tell("start-up")
        time.sleep(seconds)
    return screen.getvalue()


def test_a_long_run_names_its_stage_and_wipes_the_line(monkeypatch: pytest.MonkeyPatch) -> None:
    shown = _shown(monkeypatch, _Screen(True), 0.2, wanted=True)
    assert "\rcomputing: start-up, 0 s" in shown
    assert shown.endswith("\r")
    assert shown.split("\r")[-2].strip() == ""


@pytest.mark.parametrize(
    ("is_terminal", "seconds", "wanted"),
    [(True, 0.0, True), (False, 0.1, True), (True, 0.1, False)],
)
def test_nothing_is_said_elsewhere(
    monkeypatch: pytest.MonkeyPatch, is_terminal: bool, seconds: float, wanted: bool
) -> None:
    assert _shown(monkeypatch, _Screen(is_terminal), seconds, wanted) == ""


# ----------------------------------------------------------------------------
# Help pages have examples that work and exit codes; a shell is offered what there is.
# ----------------------------------------------------------------------------


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    shutil.copy(CASE, tmp_path / "case.toml")  # what the examples stand for
    starter = command("new", "drive_train").out
    (tmp_path / "line.toml").write_text(starter, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_every_command_has_examples() -> None:
    assert set(EXAMPLES) == set(NAMES)
    assert all(line.startswith(f"vibecalc {name}") for name in NAMES for line, _ in EXAMPLES[name])


@pytest.mark.long
def test_examples_work_in_the_order_of_their_commands(folder: Path) -> None:
    pytest.importorskip("matplotlib")
    shards = ["sweep case.toml --grid machine.speed=300,400 --keep excitation/force_peak -q -o"]
    for part in (1, 2):
        words = shlex.split(f"{shards[0]} part{part}.h5 --shard {part}/2")
        assert command(*words).code == 0
    assert command("run", "case.toml", "-q", "-o", "golden.h5").code == 0
    for name, lines in EXAMPLES.items():
        if name == "diff":
            assert command("run", "case.toml", "--set", "machine.speed=300", "-q").code == 0
        for line, _ in lines:
            words = shlex.split(line.partition(" >>")[0])[1:]
            outcome = command(*words, cap=120)
            differs = name == "diff"
            assert outcome.code == differs, (name, line, outcome.err)


def test_a_page_is_that_of_the_option_and_has_examples_and_exit_codes() -> None:
    page = command("help", "get").out
    assert page.strip() == command("get", "--help").out.strip()
    assert "vibecalc get outputs/case.h5" in page
    shown = dict(re.findall(r"^│ (\d+) +(\S.*?) +│$", page, re.M))
    assert shown == {str(code): words for code, words in EXIT_CODES.items()}
    refused = command("help", "rnu")
    assert refused.code == 2 and "no command 'rnu'; there are run" in refused.err


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        ("vibecalc ru", {"run"}),
        ("vibecalc run case.toml --set machine.crank_train.r",
         {"machine.crank_train.rod_length=", "machine.crank_train.reciprocating_mass="}),
        ("vibecalc sweep case.toml --grid machine.sp", {"machine.speed="}),
        ("vibecalc run case.toml --unset isolation.r",
         {"isolation.run_up.from", "isolation.run_up.to"}),
        ("vibecalc get case.h5 isolation/pitch/da",
         {"isolation/pitch/damping", "isolation/pitch/damping_ratio"}),
        ("vibecalc plot case.h5 --only run_", {"run_up"}),
        ("vibecalc new ro", {"roll", "roll_control"}),
        ("vibecalc new --example roll_re", {"roll_records"}),
        ("vibecalc run missing.toml --set mach", set()),
        ("vibecalc run case.toml --set isolation.model = p", {"pitch", "planar"}),
        ("vibecalc run case.toml --set isolation.model =", {"pitch", "rigid_body", "planar"}),
        ("vibecalc sweep case.toml --grid isolation.model=p",
         {"isolation.model=pitch", "isolation.model=planar"}),
        ("vibecalc run case.toml --set isolation.model = pitch --set machine.kind = ma",
         {"machine"}),
        ("vibecalc run case.toml --set accuracy.rtol =", {"1e-09"}),
    ],
)  # fmt: skip
def test_a_shell_is_offered(
    words: str, offered: set[str], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if "case.h5" in words:
        assert command("run", "case.toml", "-q", "-o", "case.h5").code == 0
    monkeypatch.setenv("_VIBECALC_COMPLETE", "complete_bash")
    format_before = BashComplete.format_completion
    monkeypatch.setattr(BashComplete, "format_completion", format_before)
    monkeypatch.setenv("COMP_WORDS", words)
    monkeypatch.setenv("COMP_CWORD", str(len(words.split()) - 1))
    assert offered <= set(command().out.split())
    assert offered or not command().out.split()
    monkeypatch.delenv("_VIBECALC_COMPLETE")
    assert "complete -o default -F" in command("completion", "bash").out
    assert command("completion", "csh").code == 2
