"""Claim: whatever key a case may have, what `check` takes is run, reported and drawn.

Each optional key, and each value of choices and switches, stands in one case at least: in a shipped
one, which golden files and snapshots hold, or in one that `key_walk.py` makes; CI takes a few.
"""

import re
from itertools import islice
from pathlib import Path

import pytest
import tomli_w
from drawn import coarse
from fuzzing import command
from key_walk import (
    VALUES,
    Aim,
    Data,
    aims,
    every_aim,
    files_beside,
    plans,
    refused_always,
    without_number,
)

from vibecalc.errors import EXIT_NUMERICAL
from vibecalc.kinds import KINDS

#: the aims are shared out to so many long tests
PARTS = 40
#: those of CI, of quick cases
QUICK = (Aim("absorber", ("tuning", "kind"), "lanchester"),)
#: how a command may end where not with 0 or 1: points of a sweep may be no case
ENDS = {"sweep": (0, 1, 4)}
#: seconds for one command
LONGEST = 600
#: cases that are tried with a key until there are numbers
MOST_CASES = 4


@pytest.fixture(autouse=True)
def _files_of_cases(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder with the tables that cases name."""
    files_beside(tmp_path)
    monkeypatch.chdir(tmp_path)
    coarse(monkeypatch)


def what_is_wrong(aim: Aim) -> str:
    """What a case with this key ends in that it must not; nothing where all goes through."""
    said = ""
    for base, data in islice(plans(aim), MOST_CASES):
        code, said = how_it_ends(base, data)
        if code != EXIT_NUMERICAL:  # no number exists for this value, which check cannot know
            return said
    if without_number(aim, said):
        return ""
    return said or ("" if refused_always(aim) else "no run reaches it")


def how_it_ends(base: str, data: Data) -> tuple[int, str]:
    """The exit code that a case must not have, and its words; 0 where all goes through."""
    Path("case.toml").write_text(tomli_w.dumps(data), encoding="utf-8")
    steps = [("check", "case.toml")]
    varied = data.get("sweep", {}).get("axes")  # else --grid has to say what to vary
    for command_of in ("run", "sweep") if varied else ("run",):
        fresh = ("--fresh", "-j", "1") if command_of == "sweep" else ()
        steps += [(command_of, "case.toml", "-q", "-o", "case.h5", *fresh)]
        steps += [("report", "case.h5"), ("report", "case.h5", "--full")]
    steps.append(("report", "case.h5", "--full", "--html"))
    steps.append(("plot", "case.h5", "-o", "pictures"))
    for step in steps:
        code, _, said = command(*step, cap=LONGEST)
        if code not in ENDS.get(step[0], (0, 1)):
            lines = said.strip().splitlines()
            return code, f"in {base}, {step[0]} ends with {code}: {' '.join(lines[-2:])}"
    return 0, ""


def wrong_of(mine: list[Aim]) -> dict[str, str]:
    """What is wrong with some aims."""
    assert mine
    return {str(aim): words for aim in mine if (words := what_is_wrong(aim))}


def test_what_check_takes_is_run_and_shown() -> None:
    assert wrong_of([*QUICK]) == {}


@pytest.mark.long
@pytest.mark.timeout(14000)
@pytest.mark.parametrize("part", range(PARTS))
def test_all_that_check_takes_is_run_and_shown(part: int) -> None:
    assert wrong_of([*every_aim()[part::PARTS]]) == {}


@pytest.mark.parametrize("name", ["together", "unreached", "without_number"])
def test_each_row_by_hand_is_of_a_key(name: str) -> None:
    every = [str(aim) for kind in KINDS for aim in aims(kind)]
    for row in VALUES[name]:
        assert any(re.search(row["keys"], aim) for aim in every), row["keys"]
