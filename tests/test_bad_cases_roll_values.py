"""Claim: whatever stands in the place of a value of a roll or control case is refused in words.

Every leaf of the starter cases is replaced by what a typing error, a spreadsheet or a script
leaves there; the case is then refused at that key, or is a case, and never ends in an exception.
"""

import copy
import tomllib
from pathlib import Path
from typing import Any

import pytest
from fuzzing import command
from long_but import long_but
from test_property_fuzz import check_broken_starters

from vibecalc.cli.starters import starter
from vibecalc.core.case.load import load_case, resolve, validate
from vibecalc.core.case.raw import get_key, key_text, set_key
from vibecalc.core.case.walk import shape_at
from vibecalc.core.run.machine_checks import check_machine, machine_warnings
from vibecalc.errors import CaseError, KeyPath

PLATE = tomllib.loads(starter("plate"))
ROLL = tomllib.loads(starter("roll"))
ROLL_CONTROL = tomllib.loads(starter("roll_control"))

START_UP = {
    "duration": 2.0,
    "crank_angle": "30 deg",
    "load": {"time": [0.0, 1.0], "factor": [0.0, 1.0]},
    "angles": 12,
}
TUNE = {
    "orders": [1, 3],
    "gain": {"lower": 1.0, "upper": 9.0},
    "acceleration_feedback": {"lower": "-1 s", "upper": "0 s"},
    "gain_margin": "6 dB",
    "phase_margin": "30 deg",
    "delay_margin": "1 ms",
}
WHOLE: dict[str, Any] = {
    **ROLL,
    "response": {
        "roll": {"orders": 6, "method": "euler", "step": "0.1 ms", "compare": ["rk4"]},
        "start_up": START_UP,
        "control": {**ROLL_CONTROL["response"]["control"], "tune": TUNE, "motor_gains": [20.0]},
    },
}
DYNAMIC: dict[str, Any] = copy.deepcopy(WHOLE)
DYNAMIC["machine"]["motor"] |= {
    "kind": "dynamic",
    "poles": 6,
    "voltage": "400 V",
    "stator_resistance": "50 mohm",
    "cages": "double",
}
#: what of it can be followed: the other methods and the start-up have no fluxes as states
FOLLOWED: dict[str, Any] = copy.deepcopy(DYNAMIC)
FOLLOWED["response"] = {"roll": {"orders": 6}, "control": WHOLE["response"]["control"]}
BAD = (float("nan"), float("inf"), "nan", "1e400 m", "3 bananas", [], {}, True, "", 10**400)


QUICK = ("nan", "3 bananas", {}, 10**400)


def leaves(value: Any, path: KeyPath = ()) -> list[KeyPath]:
    if isinstance(value, dict):
        return [leaf for key, entry in value.items() for leaf in leaves(entry, (*path, key))]
    if isinstance(value, list):
        return [leaf for n, entry in enumerate(value) for leaf in leaves(entry, (*path, n))]
    return [path]


PLACES = sorted(
    {path for path in leaves(DYNAMIC) if path[0] in ("machine", "response")},
    key=lambda path: [str(part) for part in path],
)


def test_the_whole_case_is_fine() -> None:
    for data in (WHOLE, FOLLOWED, ROLL, ROLL_CONTROL, PLATE):
        assert check_machine(validate(data)) == []
        assert machine_warnings(validate(data)) == []


@pytest.mark.parametrize("bad", long_but(BAD, *QUICK), ids=lambda bad: str(bad)[:12])
def test_no_value_but_a_good_one_is_taken(bad: Any) -> None:
    for path in PLACES:
        shape = shape_at(path)
        assert shape is not None, path
        data = copy.deepcopy(DYNAMIC)
        set_key(data, path, bad)
        if shape.kind == "text" and isinstance(bad, str) and bad:
            continue  # a name may be anything
        with pytest.raises(CaseError) as caught:
            validate(data)
        reported = [problem.path for problem in caught.value.problems]
        assert any(path[: len(one)] == one for one in reported), (key_text(path), reported)


def test_a_key_with_a_letter_too_few_is_reported_with_the_right_one() -> None:
    seen = set()
    for path in PLACES:
        key = next(part for part in reversed(path) if isinstance(part, str))
        above = path[: len(path) - 1 - path[::-1].index(key)]
        if (key, above) in seen or len(key) < 5:
            continue
        seen.add((key, above))
        data = copy.deepcopy(DYNAMIC)
        table = get_key(data, above)
        table[key[:-2] + key[-1]] = table.pop(key)
        with pytest.raises(CaseError) as caught:
            validate(data)
        hints = [problem.hint for problem in caught.value.problems]
        assert f"did you mean {key!r}?" in hints, (above, key, hints)
        assert len(hints) == 1, (above, key, caught.value.problems)
    assert len(seen) > 30


@pytest.mark.parametrize(
    ("scale", "least"),
    [
        (-1.0, 30),
        (1e30, 80),
        *(pytest.param(scale, 20, marks=pytest.mark.long) for scale in (0.0, 1e-30, 1e3)),
    ],
)
def test_scaled_numbers_are_refused_or_stand(scale: float, least: int) -> None:
    refused = 0
    cases = [resolve(validate(data)) for data in (WHOLE, FOLLOWED)]
    for tables, path in [(one, path) for one in cases for path in leaves(one)]:
        value = get_key(tables, path)
        if isinstance(value, bool | str) or not value or path[0] not in ("machine", "response"):
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
        if not problems:
            assert all("nan" not in text for text in machine_warnings(case))
    assert refused > least


@pytest.mark.parametrize("scene", ["roll", "roll_control", "plate"])
def test_broken_starters_end_in_words(scene: str, tmp_path: Path) -> None:
    codes = check_broken_starters(scene, 15, tmp_path / "mutated.toml")
    assert set(codes) <= {0, 2}
    assert codes[2] > 4


@pytest.mark.parametrize("key", ["gas_force", "slip_table", "load"])
def test_a_csv_may_stand_for_each_table(key: str, tmp_path: Path) -> None:
    """Also inside the list of cylinders."""
    place = {
        "gas_force": "machine.crank_train.cylinders[1].gas_force",
        "slip_table": "machine.motor.slip_table",
        "load": "response.start_up.load",
    }[key]
    data = copy.deepcopy(DYNAMIC)
    table = get_key(data, place)
    head = ", ".join(table)
    rows = [", ".join(map(str, row)) for row in zip(*table.values(), strict=True)]
    (tmp_path / "table.csv").write_text("# by hand\n" + "\n".join([head, *rows]) + "\n")
    set_key(data, place, "table.csv")
    import tomli_w

    path = tmp_path / "case.toml"
    path.write_text(tomli_w.dumps(data))
    assert load_case(path).case == validate(DYNAMIC)
    (tmp_path / "table.csv").write_text("\n".join([head, *rows[:-1], "x, 1"]) + "\n")
    outcome = command("check", str(path))
    assert outcome.code == 2
    assert f"{key}: line {len(rows) + 1}, column {next(iter(table))}: not a number: 'x'" in (
        outcome.err
    )
