"""Claim: curves, irregularity and conditions of what a line does not have are refused in words."""

import tomllib
from pathlib import Path

import pytest
from dense_curve_line import text
from engine_cases import ENGINE, replaced
from refused import problems_of, refusal, refusals, said_of

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
    assert refusal(tmp_path, "good", text(ASKED), tail=columns) == ""
    assert "MPa" in refusal(tmp_path, "bad", text(ASKED), tail=columns.replace("kN*m", "MPa"))
    late = refusal(tmp_path, "late", text(ASKED), tail=columns.replace("731", "1731"))
    assert "measured outside of the range of speeds" in late
