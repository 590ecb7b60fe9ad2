"""Claim: an engine or a shaft line that contradicts itself is refused in words, at its line."""

from functools import partial
from pathlib import Path

import pytest
from engine_cases import CARD, DESIGN, ENGINE, GEARED, cards, refusal, replaced
from refused import changed, hold, rows_with_messages

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
