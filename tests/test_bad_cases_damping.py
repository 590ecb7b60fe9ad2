"""Claim: a damping or a load over the speed that contradicts itself is refused in words."""

import math
from pathlib import Path

import pytest
from refused import problems_of, refusals, said_of, with_keys

from vibecalc.core.case.load import load_case

MARINE = dict(load_case(Path(__file__).parents[1] / "cases" / "marine_propulsion.toml").resolved)
#: refuse what some of the rows ask for
MARINE["machine"]["shaft_line"].pop("excitations")


@pytest.mark.parametrize(("case", "change", "place", "words"), refusals("damping"))
def test_words_and_place(case: str, change: str, place: str, words: list[str]) -> None:
    """One problem, at its key."""
    assert case == "marine"
    data = with_keys(MARINE, change, NAN=math.nan)
    problems = problems_of(data)
    assert [".".join(map(str, one.path)) for one in problems] == [place]
    for expected in words:
        assert expected in said_of(problems[0])


def test_the_plain_case_is_fine() -> None:
    assert problems_of(MARINE) == []
