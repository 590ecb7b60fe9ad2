"""Claim: tables of tangential effort that do not say enough are refused at their place."""

import tomllib
from typing import Any

import pytest
from effort_tables import ROWS, table
from engine_cases import CARD, ENGINE
from engine_mounted import SEPARATE
from refused import changed, problems_of, refusals, said_of

SMALL = {"mean_indicated_pressure": "[1e5, 1e5, 10e5, 10e5]", "order": "ORDER",
         "cosine": "[4, 3, 2, 1]", "sine": "SINE"}  # fmt: skip
VALUES = {"ORDER": "[1, 2, 1, 2]", "SINE": "[1, 2, 3, 4]"}
OVER = 'over_speed = { speed = [60.0, 230.0], mean_indicated_pressure = ["6 bar", "18 bar"] }'
LOAD = 'mean_indicated_pressure = "9 bar"'


def written(columns: dict[str, Any], load: str) -> str:
    """The three-cylinder engine with such a table."""
    inside = ", ".join(f"{name} = {value}" for name, value in columns.items())
    effort = f"tangential_effort = {{ {load}, harmonics = {{ {inside} }} }}"
    return ENGINE.replace(CARD, effort)


CASES = {
    "load": written(table(ROWS), LOAD),
    "speed": written(table(ROWS), OVER),
    "whole": written(table([row for row in ROWS if row[1] % 1 == 0.0]), LOAD),
    "one": written(table([(9e5, *row[1:]) for row in ROWS if row[0] == 4e5]), LOAD),
    "small": written(SMALL, LOAD).replace("highest = 6", "highest = 2, step = 1"),
}


@pytest.mark.parametrize(("case", "change", "place", "words"), refusals("tangential_effort"))
def test_words_and_place(case: str, change: str, place: str, words: list[str]) -> None:
    text = changed(CASES[case], change)
    for name, value in VALUES.items():
        text = text.replace(name, value)
    found = problems_of(tomllib.loads(text))
    assert found, "nothing found wrong"
    for expected in words:
        assert expected in said_of(found[0])
    whole = f"machine.crank_train.tangential_effort{place}" if place[0] == "." else place
    assert ".".join(map(str, found[0].path)) == whole


@pytest.mark.parametrize("case", CASES)
def test_without_a_change_nothing_is_refused(case: str) -> None:
    text = CASES[case]
    for name, value in VALUES.items():
        text = text.replace(name, value)
    if case == "whole":
        text = text.replace("highest = 6", "highest = 6, step = 1")
    assert not problems_of(tomllib.loads(text))


def test_the_gas_is_not_left_out_where_it_reaches_the_mounts() -> None:
    data = tomllib.loads(SEPARATE)
    train = data["machine"]["crank_train"]
    train.pop("gas_cycle")
    train["tangential_effort"] = {
        "harmonics": table(ROWS), "mean_indicated_pressure": "9 bar"
    }  # fmt: skip
    (one,) = problems_of(data)
    assert one.path == ("machine", "crank_train", "tangential_effort")
    assert "as many orders again" in one.message and "gas_pressure" in one.allowed
    data["excitation"]["driven_machine"] = "cancels_torque"
    assert not problems_of(data)
