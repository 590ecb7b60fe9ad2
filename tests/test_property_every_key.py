"""Claim: whatever key a case may have, what `check` takes is run, reported and drawn.

Each optional key of each kind of machine, and each value of choices and switches, stands in one
case at least (`key_walk.py`); CI takes a fixed share of them.
"""

import re
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import pytest
import tomli_w
from drawn import coarse
from fuzzing import command
from key_walk import (
    REFUSED_BESIDE,
    VALUES,
    Aim,
    Data,
    aims,
    files_beside,
    joined,
    places,
    plans,
    refused_always,
    standing,
    without_number,
)

from vibecalc.errors import EXIT_NUMERICAL
from vibecalc.kinds import KINDS

#: the aims are shared out to so many parts, of which CI runs one; the long tests take some together
SHARES, TOGETHER = 2400, 40
#: the share of CI, of quick cases: absorbers with pictures, a fit to a pump
QUICK = 701
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


def every_aim() -> Iterator[Aim]:
    for kind in KINDS:
        yield from aims(kind)


def is_first(aim: Aim) -> bool:
    """Whether this kind of machine is the first one that has the key: its pictures are drawn."""
    return next(kind for kind in KINDS if aim.pattern in places(kind)) == aim.kind


#: what stood in a case that went through, by whether its pictures were drawn
THROUGH: dict[bool, set[Aim]] = {True: set(), False: set()}


def what_is_wrong(aim: Aim) -> str:
    """What a case with this key ends in that it must not; nothing where all goes through."""
    said, drawn = "", is_first(aim)
    if aim in THROUGH[drawn]:
        return ""
    for base, data in islice(plans(aim), MOST_CASES):
        others = (one for one in aims(aim.kind) if one not in THROUGH[drawn])
        more, came = joined(aim, data, (one for one in others if is_first(one) == drawn))
        code, said = how_it_ends(base, more, drawn)
        if came and code == EXIT_NUMERICAL:  # what of all these has no number?
            REFUSED_BESIDE.update(came)
            code, said = how_it_ends(base, data, drawn)
        elif code == 0:
            data = more
        if code == 0:
            for one in {drawn, False}:
                THROUGH[one].update(standing(aim.kind, data))
        if code != EXIT_NUMERICAL:  # no number exists for this value, which check cannot know
            return said
    if without_number(aim, said):
        return ""
    return said or ("" if refused_always(aim) else "no run reaches it")


def how_it_ends(base: str, data: Data, drawn: bool) -> tuple[int, str]:
    """The exit code that a case must not have, and its words; 0 where all goes through."""
    Path("case.toml").write_text(tomli_w.dumps(data), encoding="utf-8")
    steps = [("check", "case.toml")]
    varied = data.get("sweep", {}).get("axes")  # else --grid has to say what to vary
    for command_of in ("run", "sweep") if varied else ("run",):
        fresh = ("--fresh", "-j", "1") if command_of == "sweep" else ()
        steps += [(command_of, "case.toml", "-q", "-o", "case.h5", *fresh)]
        steps += [("report", "case.h5"), ("report", "case.h5", "--full")]
    if drawn:
        steps.append(("report", "case.h5", "--full", "--html"))
        steps.append(("plot", "case.h5", "-o", "pictures"))
    for step in steps:
        code, _, said = command(*step, cap=LONGEST)
        if code not in ENDS.get(step[0], (0, 1)):
            lines = said.strip().splitlines()
            return code, f"in {base}, {step[0]} ends with {code}: {' '.join(lines[-2:])}"
    return 0, ""


def wrong_of(first: int, count: int) -> dict[str, str]:
    """What is wrong with the aims of some shares."""
    mine = [aim for aim in every_aim() if 0 <= aim.number % SHARES - first < count]
    assert mine
    return {str(aim): words for aim in mine if (words := what_is_wrong(aim))}


def test_what_check_takes_is_run_and_shown() -> None:
    assert wrong_of(QUICK, 1) == {}


@pytest.mark.long
@pytest.mark.timeout(14000)
@pytest.mark.parametrize("first", range(0, SHARES, TOGETHER))
def test_all_that_check_takes_is_run_and_shown(first: int) -> None:
    assert wrong_of(first, TOGETHER) == {}


@pytest.mark.parametrize("name", ["together", "unreached", "without_number"])
def test_each_row_by_hand_is_of_a_key(name: str) -> None:
    every = [*map(str, every_aim())]
    for row in VALUES[name]:
        assert any(re.search(row["keys"], aim) for aim in every), row["keys"]
