"""Claim: limits of a shaft line that cannot be held are refused in words, at their place."""

import tomllib
from pathlib import Path

import pytest
from engine_cases import ENGINE, GEARED
from limited_lines import CRANK, ran
from refused import changed, problems_of, refusals, said_of

from vibecalc.errors import NumericalFailure

CASES = {"engine": ENGINE, "geared": GEARED}


@pytest.mark.parametrize(("case", "change", "place", "words"), refusals("limits"))
def test_words_and_place(case: str, change: str, place: str, words: list[str]) -> None:
    text = changed(CASES[case], change.replace("CRANK", CRANK))
    found = problems_of(tomllib.loads(text))
    assert found, "nothing found wrong"
    for expected in words:
        assert expected in said_of(found[0])
    assert ".".join(map(str, found[0].path)) == place


def test_a_gear_without_a_mean_torque_has_no_share_of_it(tmp_path: Path) -> None:
    with pytest.raises(NumericalFailure, match="'wheel - take-off' carries no mean torque"):
        ran(GEARED + "limits = [{ alternating_share = 0.3 }]\n", tmp_path)
