"""Claim: a motion of the base or a foundation that cannot be is refused in words, at its key."""

import math
from pathlib import Path

import pytest
from refused import problems_of, refusals, said_of, with_keys

from vibecalc.core.case.load import load_case, validate
from vibecalc.core.run.machine_checks import machine_warnings

CASES = Path(__file__).parents[1] / "cases"
DECK = dict(load_case(CASES / "genset_on_deck.toml").resolved)


@pytest.mark.parametrize(("case", "change", "place", "words"), refusals("base"))
def test_words_and_place(case: str, change: str, place: str, words: list[str]) -> None:
    """The first problem, at its key."""
    assert case == "deck"
    problem = problems_of(with_keys(DECK, change, NAN=math.nan))[0]
    assert ".".join(map(str, problem.path)) == place, said_of(problem)
    for expected in words:
        assert expected in said_of(problem)


def test_the_plain_case_is_fine() -> None:
    assert problems_of(DECK) == []


def test_damping_by_modes_that_does_not_count_is_said() -> None:
    case = validate(with_keys(DECK, '{"machine.mounts.modal_damping": 0.05}'))
    (said,) = (one for one in machine_warnings(case) if "modal_damping" in one)
    assert said.endswith("not in [isolation], [foundation], [base_motion]")
