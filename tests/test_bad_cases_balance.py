"""Claim: weights that cannot be sought are refused in words, at their key."""

import pytest
from refused import problems_of, refusals, said_of, with_keys
from shipped_cases import CASES

from vibecalc.core.case.load import load_case, resolve


@pytest.mark.parametrize(("case", "change", "place", "words"), refusals("balance"))
def test_refused_at_its_key(case: str, change: str, place: str, words: list[str]) -> None:
    base = resolve(load_case(CASES[f"balance_{case}"]).case)
    found = problems_of(with_keys(base, change))
    assert found, "nothing found wrong"
    text = " ".join(said_of(problem) for problem in found)
    assert ".".join(map(str, found[0].path)) == place, text
    for expected in words:
        assert expected in text
    assert len({(p.path, p.message) for p in found}) == len(found)
