"""Claim: whatever key a case may have, what `check` takes is run, reported and drawn.

Each optional key of each kind of machine, and each value of choices and switches, stands in one
case at least (`key_walk.py`); CI takes a fixed share of them.
"""

from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import pytest
import tomli_w
from drawn import coarse
from fuzzing import command
from key_walk import Aim, aims, files_beside, places, plans, refused_always, without_number
from long_but import long_but

from vibecalc.errors import EXIT_NUMERICAL
from vibecalc.kinds import KINDS

#: the aims are shared out to so many tests, of which CI runs two
SHARES = 480
#: seconds for one command
LONGEST = 120
#: cases that are tried with a key until there are numbers
MOST_CASES = 4


@pytest.fixture(autouse=True)
def _files_of_cases(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder with the tables that cases name."""
    files_beside(tmp_path)
    monkeypatch.chdir(tmp_path)
    coarse(monkeypatch)


def every_aim() -> Iterator[Aim]:
    for kind in KINDS:
        yield from aims(kind)


def is_first(aim: Aim) -> bool:
    """Whether this kind of machine is the first one that has the key: its pictures are drawn."""
    return next(kind for kind in KINDS if aim.pattern in places(kind)) == aim.kind


def what_is_wrong(aim: Aim) -> str:
    """What a case with this key ends in that it must not; nothing where all goes through."""
    said = ""
    for base, data in islice(plans(aim), MOST_CASES):
        code, said = how_it_ends(aim, base, data)
        if code != EXIT_NUMERICAL:  # no number exists for this value, which check cannot know
            return said
    if without_number(aim, said):
        return ""
    return said or ("" if refused_always(aim) else "no run reaches it")


def how_it_ends(aim: Aim, base: str, data: dict[str, Any]) -> tuple[int, str]:
    """The exit code that a case must not have, and its words; 0 where all goes through."""
    Path("case.toml").write_text(tomli_w.dumps(data), encoding="utf-8")
    run = ("run", "case.toml", "-q", "-o", "case.h5")
    if aim.pattern[0] == "sweep":
        run = ("sweep", "case.toml", "-q", "-o", "case.h5", "--fresh", "-j", "1")
    steps = [("check", "case.toml"), run, ("report", "case.h5"), ("report", "case.h5", "--full")]
    if is_first(aim):
        steps.append(("report", "case.h5", "--full", "--html"))
        steps.append(("plot", "case.h5", "-o", "pictures"))
    for step in steps:
        code, _, said = command(*step, cap=LONGEST)
        if code not in (0, 1):
            lines = said.strip().splitlines()
            return code, f"in {base}, {step[0]} ends with {code}: {' '.join(lines[-2:])}"
    return 0, ""


@pytest.mark.parametrize("share", long_but(range(SHARES), 0, 1))
def test_what_check_takes_is_run_and_shown(share: int) -> None:
    mine = [aim for aim in every_aim() if aim.number % SHARES == share]
    assert mine
    wrong = {str(aim): words for aim in mine if (words := what_is_wrong(aim))}
    assert wrong == {}
