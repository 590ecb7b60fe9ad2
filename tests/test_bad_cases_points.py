"""Claim: points that cannot be read, and severities that contradict themselves, are refused."""

import json
import math

import pytest
from refused import problems_of, refusals, said_of, with_keys
from shipped_cases import CASES

from vibecalc.core.case.load import load_case, validate
from vibecalc.core.run.targets import check_targets

GENSET = dict(load_case(CASES["genset_points"]).resolved)


@pytest.mark.parametrize(("case", "change", "place", "words"), refusals("points"))
def test_words_and_place(case: str, change: str, place: str, words: list[str]) -> None:
    """The first problem, at its key."""
    assert case == "genset"
    problems = problems_of(with_keys(GENSET, change, NAN=math.nan))
    assert [".".join(map(str, one.path)) for one in problems[:1]] == [place]
    for expected in words:
        assert expected in said_of(problems[0])


def test_the_plain_case_is_fine() -> None:
    assert problems_of(GENSET) == []


def test_a_reading_and_an_order_that_are_not_there_are_refused() -> None:
    wrong = {"sensor": "governer x"}
    data = with_keys(GENSET, '{"limit[0].where": ' + json.dumps(wrong) + "}")
    data["reference"] = [
        {"quantity": "points/velocity", "where": {"sensor": "base", "order": 0.25}, "value": 1.0,
         "source": "none"}
    ]  # fmt: skip
    order, reading = check_targets(validate(data))
    assert "there is no sensor named 'governer x'" in reading.message
    assert "governor x" in reading.hint and reading.path == ("limit", 0, "where")
    assert "asks for an order that points/velocity lacks" in order.message
    assert order.allowed == "0.5 to 16"
    data["sweep"] = {"axes": [{"key": "machine.speed", "values": [150.0, 160.0]}]}
    assert len(check_targets(validate(data))) == 2, "`run` holds the case against its references"
