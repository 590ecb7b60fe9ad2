"""Claim: bearing loads that no shaft on its bearings can have are refused in words."""

import tomllib

import pytest
from refused import changed, problems_of, refusals, said_of
from shipped_cases import CASES

from vibecalc.errors import dotted


@pytest.mark.parametrize(("case", "change", "place", "words"), refusals("bearing_loads"))
def test_refused(case: str, change: str, place: str, words: list[str]) -> None:
    name = {"engine": "engine_bearing_loads", "radial": "radial_articulated"}[case]
    text = changed(CASES[name].read_text(encoding="utf-8"), change)
    found = {dotted(one.path): said_of(one) for one in problems_of(tomllib.loads(text))}
    assert place in found, found
    for word in words:
        assert word in found[place], found[place]
