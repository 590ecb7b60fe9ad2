"""Claim: help pages have examples that work and exit codes; a shell is offered what there is."""

import re
import shlex
from pathlib import Path

import pytest
from fuzzing import command
from shipped_cases import ROOT
from typer._completion_classes import BashComplete

from vibecalc.cli.commands import app
from vibecalc.cli.examples import EXAMPLES
from vibecalc.errors import EXIT_CODES

NAMES = {str(one.name or one.callback.__name__) for one in app.registered_commands if one.callback}
#: what the examples stand for
GENERATOR = ROOT / "cases" / "generator.toml"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "case.toml").write_text(GENERATOR.read_text(encoding="utf-8"), encoding="utf-8")
    starter = command("new", "drive_train").out
    (tmp_path / "line.toml").write_text(starter, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_every_command_has_examples() -> None:
    assert set(EXAMPLES) == NAMES
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
