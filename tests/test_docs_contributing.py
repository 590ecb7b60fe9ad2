"""Claim: the commands of docs/contributing.md work as printed."""

import re
import shlex
from pathlib import Path

import pytest
from fuzzing import command
from shipped_cases import ROOT

PAGE = (ROOT / "docs" / "contributing.md").read_text(encoding="utf-8")
LINES = [
    line for block in re.findall(r"```sh\n(.*?)```", PAGE, re.S) for line in block.splitlines()
]
#: what makes numbers golden, draws, or runs tests is for a person
BY_HAND = ("--accept", "vibecalc plot", "make ")


def test_commands_work_in_the_order_printed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("cases", "tests"):
        (tmp_path / name).symlink_to(ROOT / name)
    monkeypatch.chdir(tmp_path)
    tried = [line for line in LINES if not any(words in line for words in BY_HAND)]
    assert len(tried) == 6
    for line in tried:
        outcome = command(*shlex.split(line)[1:], cap=60)
        assert outcome.code == 0, (line, outcome.err)
    for name in ("pump", "generator_on_floor"):
        assert (tmp_path / "outputs" / f"{name}.h5").is_file()
        compared = command("diff", f"tests/golden/{name}.h5", f"outputs/{name}.h5", cap=60)
        assert compared.code == 0, compared.out
    assert "pump" in command("new", "list").out
