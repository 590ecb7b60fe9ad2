"""Claim: bodies of parts and mounts that cannot be are refused in words, at their place."""

import pytest
from mounted_sets import tables
from refused import problems_of, refusals, said_of, with_keys


@pytest.mark.parametrize(("case", "change", "place", "words"), refusals("mounts"))
def test_words_and_place(case: str, change: str, place: str, words: list[str]) -> None:
    found = problems_of(with_keys(tables(), change))
    assert found, "nothing found wrong"
    for expected in words:
        assert expected in said_of(found[0])
    assert place == ".".join(map(str, found[0].path))


def test_the_plain_case_is_fine() -> None:
    assert not problems_of(tables())
