"""Claim: an engine or a shaft line that contradicts itself, curves, irregularity and conditions of
what a line does not have, and tables of tangential effort that do not say enough are refused in
words, at their place.
"""

import tomllib
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from dense_curve_line import text
from effort_tables import ROWS, table
from engine_cases import CARD, DESIGN, ENGINE, GEARED, cards, refusal, replaced
from engine_mounted import SEPARATE
from refused import changed, hold, problems_of, refusals, rows_with_messages, said_of

E, G, P, D = ENGINE, GEARED, CARD, DESIGN
TEXTS = {"engine": ENGINE, "geared": GEARED}
MESSAGES = {
    name: partial(refusal, text=changed(TEXTS[case], change))
    for name, (case, change) in rows_with_messages("engine").items()
}

#: what is right, and no more than unusual
FINE: dict[str, str] = {
    "in line": E,
    "geared": G,
    "cards over the speed": replaced(E, (P, cards("700 rpm", "2100 rpm"))),
    "a damper to be found": E + D,
    "a damper to be replaced": E + '[damper_design]\non = "ring"\n',
    "misfire": E + 'misfire = ["2"]\nmisfire_kind = "motored"\nmethod = "dense"\n',
    "a rule": E
    + 'limits = [{ rule = "iacs_m68", tensile_strength = "600 MPa", sections = ["a - b"] }]\n',
    "spark": replaced(E, (P, 'gas_cycle = { kind = "spark", mean_indicated_pressure = "9 bar" }')),
    "phases that agree": replaced(
        E,
        ('{ name = "2" }', '{ name = "2", crank_phase = "240 deg" }'),
        ('{ name = "3" }', '{ name = "3", crank_phase = "120 deg" }'),
    ),
    "a point without mass": E.replace("0.1 kg*m^2", "0 kg*m^2"),
}


@pytest.mark.parametrize("name", MESSAGES)
def test_words_and_line(name: str, tmp_path: Path) -> None:
    hold("bad_cases_engine", name, MESSAGES[name], tmp_path)


@pytest.mark.parametrize("name", sorted(FINE))
def test_the_plain_cases_are_fine(name: str, tmp_path: Path) -> None:
    assert refusal(tmp_path, FINE[name]) == ""


ALONE = (
    (', { name = "2" }, { name = "3" }', ""),
    ('["1", "3", "2"]', '["1"]'),
    (', cylinder = "2"', ""),
    (', cylinder = "3"', ""),
)
ASKED = 'curves = [{ on = "tail", measured = "tail.csv" }]'


def case(kind: str, asked: str) -> str:
    """The three cylinders, without a range of speeds, or a cylinder alone."""
    if kind == "alone":
        return replaced(ENGINE, *ALONE) + asked
    whole = text(asked)
    return whole if kind == "line" else "\n".join(
        one for one in whole.splitlines() if not one.startswith("speeds = ")
    )  # fmt: skip


@pytest.mark.parametrize(("kind", "asked", "place", "words"), refusals("curves"))
def test_refused(kind: str, asked: str, place: str, words: list[str]) -> None:
    problems = problems_of(tomllib.loads(case(kind, asked)))
    found = {".".join(map(str, one.path)): said_of(one) for one in problems}
    assert place in found, found
    for word in words:
        assert word in found[place], found[place]


def test_given_pressures_of_a_single_cylinder_are_a_condition() -> None:
    asked = 'conditions = { misfire = "none", pressure_scale = [0.9] }'
    assert problems_of(tomllib.loads(case("alone", asked))) == []


def test_measured_points_come_from_a_csv(tmp_path: Path) -> None:
    columns = "speed [rpm],order,torque [kN*m]\n600,0,1.2\n731,1.5,0.4\n"
    assert refusal(tmp_path, text(ASKED), tail=columns) == ""
    assert "MPa" in refusal(tmp_path, text(ASKED), tail=columns.replace("kN*m", "MPa"))
    late = refusal(tmp_path, text(ASKED), tail=columns.replace("731", "1731"))
    assert "measured outside of the range of speeds" in late


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
