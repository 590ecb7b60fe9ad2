"""Claim: whatever stands in the place of a value of a case is refused in words.

Every leaf of cases of absorbers and of rolling machines is replaced by what a typing error, a
spreadsheet or a script leaves there; the case is then refused at that key, or is a case, and never
ends in an exception.
"""

import copy
import tomllib
from typing import Any

import pytest
from absorber_cases import PENDULUM, RATIOS, RIG, SEVERAL, TUNED
from engine_cases import replaced
from engine_mounted import SEPARATE
from fuzzing import leaves
from long_but import long_but
from shipped_cases import CASES, table_of

from vibecalc.cli.starters import starter
from vibecalc.core.case.load import load_case, resolve, validate
from vibecalc.core.case.raw import NOT_COMPUTED, get_key, set_key
from vibecalc.core.case.walk import shape_at
from vibecalc.core.run.machine_checks import check_machine, machine_warnings
from vibecalc.core.run.run import StageCache, check_again
from vibecalc.errors import CaseError, KeyPath, dotted
from vibecalc.parts.cautions import implausible
from vibecalc.schema import Case

ROLLERS = {"mass": "80 g", "distance": "92 mm", "diameter": "15 mm"}
START_UP = {
    "duration": 2.0,
    "crank_angle": "30 deg",
    "load": {"time": [0.0, 1.0], "factor": [0.0, 1.0]},
    "angles": 12,
}
TUNE = {
    "orders": [1, 3],
    "gain": {"min": 1.0, "max": 9.0},
    "acceleration_feedback": {"min": "-1 s", "max": "0 s"},
    "gain_margin": "6 dB",
    "phase_margin": "30 deg",
    "delay_margin": "1 ms",
}
CONTROL = tomllib.loads(starter("roll_control"))["response"]["control"]
DYNAMIC = {
    "kind": "dynamic",
    "poles": 6,
    "voltage": "400 V",
    "stator_resistance": "50 mohm",
    "cages": "double",
}


def rolling(motor: dict[str, Any], *tables: str) -> dict[str, Any]:
    """The starter with a motor and the tables of its response that are named."""
    data = tomllib.loads(starter("roll"))
    data["machine"]["motor"] |= motor
    response = {
        "roll": {"orders": 6, "method": "euler", "step": "0.1 ms", "compare": ["rk4"]},
        "start_up": START_UP,
        "control": {**CONTROL, "tune": TUNE, "motor_gains": [20.0]},
    }
    data["response"] = {"roll": {"orders": 6}} | {name: response[name] for name in tables}
    return data


GOOD: dict[str, dict[str, Any]] = {
    "ratios": tomllib.loads(
        RATIOS + "vary = { damping_over_primary_critical = [0.1, 0.2] }\nlimits = true\n"
    ),
    "tuned": tomllib.loads(
        TUNED
        + "mistuning = [0.01, 0.05]\n"
        + "bounds = { stiffness_ratio = [0.01, 1.0], travel = 20, "
        + "damping_over_primary_critical = [0.01, 1.0] }\n"
        + "chart = { primary_damping = [0.1], mass_ratio = { from = 0.1, to = 1 } }\n"
    ),
    "rig": tomllib.loads(
        RIG
        + '[tuning]\ntemperatures = { from = "20 degC", to = "90 degC" }\n'
        + '[response.absorber]\nfrequencies = { from = "1 Hz", to = "20 Hz" }\n'
    ),
    "several": tomllib.loads(SEVERAL),
    "pendulum": tomllib.loads(PENDULUM),
    "roll": rolling({}, "roll", "start_up", "control"),
    # what of it can be followed: the other methods and the start-up have no fluxes as states
    "followed": rolling(DYNAMIC, "control"),
}
GOOD["pendulum"]["machine"]["pendulum"]["rollers"] = ROLLERS
GOOD["machine"] = {
    key: one for key, one in table_of("generator").items() if key not in NOT_COMPUTED
}
#: cases whose form is right, every key of the roll in one
WHOLE = {name: GOOD[name] for name in ("ratios", "tuned", "rig", "several", "pendulum")}
WHOLE["dynamic"] = rolling(DYNAMIC, "roll", "start_up", "control")
BAD = (float("nan"), float("inf"), "nan", "1e400 m", "3 bananas", [], {}, True, "", 10**400)
QUICK = ("nan", {}, 10**400)
TABLES = ("machine", "response", "tuning", "isolation")


def places(data: dict[str, Any]) -> list[KeyPath]:
    return [path for path in leaves(data, kind=object) if path[0] in TABLES]


@pytest.mark.parametrize("name", GOOD)
def test_the_whole_case_is_fine(name: str) -> None:
    case = validate(GOOD[name])
    assert check_machine(case) == []
    assert machine_warnings(case) == []
    assert validate(resolve(case)) == case


@pytest.mark.parametrize("name", WHOLE)
@pytest.mark.parametrize("bad", long_but(BAD, *QUICK), ids=lambda bad: str(bad)[:12])
def test_no_value_but_a_good_one_is_taken(name: str, bad: Any) -> None:
    for path in places(WHOLE[name]):
        shape = shape_at(path)
        assert shape is not None, path
        if shape.kind == "text" and isinstance(bad, str) and bad:
            continue  # a name may be anything
        if shape.kind == "flag" and bad is True:
            continue
        data = copy.deepcopy(WHOLE[name])
        set_key(data, path, bad)
        with pytest.raises(CaseError) as caught:
            validate(data)
        reported = [problem.path for problem in caught.value.problems]
        assert any(path[: len(one)] == one for one in reported), (dotted(path), reported)


@pytest.mark.parametrize("name", WHOLE)
def test_a_key_with_a_letter_too_few_is_reported_with_the_right_one(name: str) -> None:
    seen = set()
    for path in places(WHOLE[name]):
        key = next(part for part in reversed(path) if isinstance(part, str))
        above = path[: len(path) - 1 - path[::-1].index(key)]
        if (key, above) in seen or len(key) < 5:
            continue
        seen.add((key, above))
        data = copy.deepcopy(WHOLE[name])
        table = get_key(data, above)
        table[key[:-2] + key[-1]] = table.pop(key)
        with pytest.raises(CaseError) as caught:
            validate(data)
        hints = [problem.hint for problem in caught.value.problems]
        assert hints == [f"did you mean {key!r}?"], (above, key, caught.value.problems)
    assert seen


@pytest.mark.parametrize("name", GOOD)
@pytest.mark.parametrize("scale", long_but((0.0, -1.0, 1e-30, 1e30, 1e3, 1.1), -1.0, 1e30))
def test_scaled_numbers_are_refused_or_stand(name: str, scale: float) -> None:
    """And the checks that a study leaves out would have found the same."""
    refused, cache = 0, StageCache()
    tables = resolve(validate(GOOD[name]))
    for path in places(tables):
        value = get_key(tables, path)
        if isinstance(value, bool | str) or not value:
            continue
        data = copy.deepcopy(tables)
        set_key(data, path, scale * value)
        try:
            case = validate(data)
        except CaseError:
            refused += 1
            continue
        problems = check_machine(case)
        refused += bool(problems)
        assert check_again(case, cache) == problems, (path, scale)
        assert problems or all("nan" not in text for text in machine_warnings(case))
    assert refused or scale in (1e3, 1.1)


# ----------------------------------------------------------------------------
# Numbers that are possible and most unlikely: the slip is named, by `check` and once by `run`.
# ----------------------------------------------------------------------------

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
    data = copy.deepcopy(load_case(CASES[name]).resolved)
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
