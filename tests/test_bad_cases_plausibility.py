"""Numbers that are possible and most unlikely: the slip is named, by `check` and once by `run`."""

import tomllib
from copy import deepcopy
from typing import Any

import pytest
from engine_cases import replaced
from engine_mounted import SEPARATE
from shipped_cases import CASES

from vibecalc.core.case.load import load_case, validate
from vibecalc.core.case.raw import set_key
from vibecalc.parts.cautions import implausible
from vibecalc.schema import Case

TRAIN = "machine.crank_train"
WEIGHT = {"name": "web", "unbalance": 26.0, "phase": 3.0}
SLIPS: list[tuple[str, str, str, Any, str]] = [
    ("bore in mm", "generator", f"{TRAIN}.bore", 108.0, "the bore is 108 m: is it in m ('108 mm'"),
    ("radius in mm", "generator", f"{TRAIN}.crank_radius", 60.0, "'60 mm'"),
    ("place in mm", "generator", f"{TRAIN}.cylinders[1].position", -300.0, "the position of '"),
    ("mount in mm", "generator", "machine.mounts.positions[0][0]", -550.0, "'-550 mm'"),
    ("weight in kg mm", "generator", f"{TRAIN}.counterweights", [WEIGHT], "'web', 26 kg*m, is "),
    ("degrees", "generator", f"{TRAIN}.cylinders[1].crank_phase", 180.0, "be '180 deg'?"),
    ("few", "generator", f"{TRAIN}.cylinders[1].bank_angle", 7.5, "bank_angle of cylinder '"),
    ("rpm", "generator", "machine.speed", 4900.0, "the mean piston speed is 187 m/s"),
    ("fast", "generator", "machine.speed", 800.0, "the mean piston speed is 30.6 m/s"),
    ("quick", "generator", "machine.speed", 3e3, "piston acceleration is up to"),
    ("heavy", "roll", f"{TRAIN}.cylinders[0].reciprocating_mass", 9e3, "' carries about"),
    ("gas in mN", "roll", f"{TRAIN}.cylinders[0].gas_force.force[3]", -1.6e6, "bar on a piston of"),
    ("soft", "generator", "machine.mounts.each.stiffness", 60.0, "is about 4.09 m, over"),
    ("wide", "compressor", f"{TRAIN}.bore", 0.5, "0.5 m at a stroke of 0.0254 m"),
    ("percent", "absorber", "machine.secondary.mass_ratio", 5.0, "should it be '5 %'?"),
    ("field", "roll", "machine.motor.synchronous_speed", 900.0, "should it be '900 rpm'?"),
]


def changed(name: str, key: str, value: Any) -> Case:
    """A shipped case with another value, not held against the checks."""
    data = deepcopy(load_case(CASES[name]).resolved)
    set_key(data, key, value)
    return validate(data)


@pytest.mark.parametrize(
    ("name", "key", "value", "words"), [row[1:] for row in SLIPS], ids=[row[0] for row in SLIPS]
)
def test_slip_is_named(name: str, key: str, value: Any, words: str) -> None:
    assert any(words in text for text in implausible(changed(name, key, value)))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('bore = "100 mm"', 'bore = "0.9 m"', "0.9 m at a stroke of 0.12 m"),
        ('piston_mass = "1.7 kg"', "piston_mass = 1700", "a piston weighs 1.7e+03 kg"),
    ],
)
def test_parts_of_an_engine(old: str, new: str, words: str) -> None:
    case = validate(tomllib.loads(replaced(SEPARATE, (old, new))))
    assert any(words in text for text in implausible(case))


@pytest.mark.parametrize("angle", [8.377580409572781, 6.283185307179586, -6.283185307179586])
def test_a_phase_of_many_degrees_with_its_unit_is_none(angle: float) -> None:
    assert implausible(changed("generator", f"{TRAIN}.cylinders[1].crank_phase", angle)) == []


@pytest.mark.parametrize("name", sorted(CASES))
def test_shipped_cases_have_no_slip(name: str) -> None:
    assert implausible(load_case(CASES[name]).case) == []
