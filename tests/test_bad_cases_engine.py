"""Claim: an engine or a shaft line that contradicts itself is refused in words, at its line."""

import copy
import random
import tomllib
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from engine_cases import CARD, DESIGN, ENGINE, GEARED, cards, refusal, replaced
from engine_refusals import REFUSED as OF_MACHINES
from engine_refusals_asked import REFUSED as OF_QUESTIONS
from refused import hold

from vibecalc.cli.starters import starter
from vibecalc.core.case.load import validate
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.core.run.plan import plan_case
from vibecalc.errors import CaseError
from vibecalc.torsion.model import build_shaft_line

E, G, P, D = ENGINE, GEARED, CARD, DESIGN
MESSAGES = {
    name: partial(refusal, text=text) for name, text in (OF_MACHINES | OF_QUESTIONS).items()
}
NONSENSE: tuple[Any, ...] = (
    *(float("nan"), float("inf"), -1, 0, 1e15, 1e-15, 10**400, True),
    *("nan", "1e400 m", "3 bananas", "", "1", "nix", [], {}, [1, 2], [{}]),
)

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


def test_whatever_stands_in_the_place_of_a_value_is_no_exception() -> None:
    random_places = random.Random(7)
    ring = ("viscous", 'spring", stiffness = "9 kN*m/rad')
    for text in (replaced(E, ring) + D, G, tomllib.loads(starter("engine"))):
        data = tomllib.loads(text) if isinstance(text, str) else text
        for path in random_places.sample([*_places(data["machine"])], 40):
            changed = copy.deepcopy(data)
            holder = changed["machine"]
            for key in path[:-1]:
                holder = holder[key]
            holder[path[-1]] = random_places.choice(NONSENSE)
            try:
                case = validate(changed)
            except CaseError:
                continue
            plan_case(case)
            if not check_machine(case) and case.machine.shaft_line is not None:
                assert all(np.all(np.isfinite(one)) for one in build_shaft_line(case).line), path


def _places(value: Any, above: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    if above:
        yield above
    if isinstance(value, dict | list):
        entries = value.items() if isinstance(value, dict) else enumerate(value)
        for key, entry in entries:
            yield from _places(entry, (*above, key))
