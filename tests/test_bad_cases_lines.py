"""Claim: a shaft line with torques that nobody can place is refused in words, at its key."""

import pytest
from refused import problems_of, refusals, said_of, with_keys
from shipped_cases import CASES

from vibecalc.core.case.load import load_case, resolve

NAMES = {"pump": "pump_drive", "geared": "engine_geared", "v8": "engine_v8"}


@pytest.mark.parametrize(("case", "change", "place", "words"), refusals("line"))
def test_refused_at_its_key(case: str, change: str, place: str, words: list[str]) -> None:
    base = resolve(load_case(CASES[NAMES[case]]).case)
    base = {key: one for key, one in base.items() if not key.startswith(("reference", "limit"))}
    assert problems_of(base) == []
    found = problems_of(with_keys(base, change))
    assert found, "nothing found wrong"
    text = " ".join(said_of(problem) for problem in found)
    assert ".".join(map(str, found[0].path)) == place, text
    for expected in words:
        assert expected in text
    assert len({(p.path, p.message) for p in found}) == len(found)
