"""Claim: what docs/accuracy.md shows works as printed, and its tables name what there is."""

import re
import shlex
from pathlib import Path

import pytest
from drawn import coarse
from fuzzing import command
from shipped_cases import ROOT

from vibecalc.core.results.layout import TARGETS
from vibecalc.core.results.store import read_result

PAGE = (ROOT / "docs" / "accuracy.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which the commands of the page have run."""
    pytest.importorskip("matplotlib")
    made = tmp_path_factory.mktemp("page")
    (made / "cases").symlink_to(ROOT / "cases")
    (block,) = re.findall(r"```sh\n(.*?)```", PAGE, re.S)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(made)
        patch.setattr("vibecalc.core.accuracy.topic._ENOUGH", 0.0)
        coarse(patch)
        for line in block.splitlines():
            outcome = command(*shlex.split(line.split("#")[0])[1:], cap=60)
            assert outcome.code == 0, (line, outcome.err)
    return made


def test_the_excerpt_is_of_the_table(folder: Path) -> None:
    text = (folder / "outputs" / "generator.accuracy.txt").read_text(encoding="utf-8")
    (excerpt,) = re.findall(r"<!-- excerpt -->\n```\n(.*?)```", PAGE, re.S)
    # method, setting and work; seconds are those of a machine, errors have its rounding
    left = [line[:40].rstrip() for line in excerpt.splitlines()]
    printed = [line[:40].rstrip() for line in text.splitlines()]
    assert [line for line in left if line not in printed] == []


def test_the_file_holds_the_datasets_named(folder: Path) -> None:
    record = read_result(folder / "outputs" / "generator.accuracy.h5").record
    names = {path.rsplit("/", 1)[1] for path in record}
    paragraph = " ".join(PAGE.split("### The file")[1].split("### ")[0].split())
    named = set(re.findall(r"`(?:accuracy/<stage>/<question>/)?(\w+)`", paragraph))
    axes = {"trial", "method", "diff"}
    assert names | {"position_error"} == (named - axes) | {"order_kind", "position_error"}


def test_options_and_targets_are_those_of_the_command() -> None:
    text = command("accuracy", "--help").out
    section = PAGE.split("## Compare methods on your case")[1]
    for option in re.findall(r"--[a-z]+", section.split("### How to read")[0]):
        assert option in text, option
    assert "1e-3, 1e-6 and 1e-9" in PAGE and TARGETS == (1e-3, 1e-6, 1e-9)
