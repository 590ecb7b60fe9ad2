"""Claim: whatever stands in the place of a value of an absorber's case is refused in words.

Every leaf is replaced by what a typing error, a spreadsheet or a script leaves there; the case is
then refused at that key, or is a case, and never ends in an exception.
"""

import copy
import tomllib
from pathlib import Path
from typing import Any

import pytest
from absorber_cases import PENDULUM, RATIOS, RIG, SEVERAL, TUNED
from long_but import long_but
from test_property_fuzz import check_broken_starters

from vibecalc.core.case.load import resolve, validate
from vibecalc.core.case.raw import get_key, key_text, set_key
from vibecalc.core.case.walk import shape_at
from vibecalc.core.run.machine_checks import check_machine, machine_warnings
from vibecalc.core.run.run import StageCache, check_again
from vibecalc.errors import CaseError, KeyPath

ROLLERS = {"mass": "80 g", "distance": "92 mm", "diameter": "15 mm"}
WHOLE = {
    "ratios": tomllib.loads(RATIOS + "vary = { secondary_damping = [0.1, 0.2] }\nlimits = true\n"),
    "tuned": tomllib.loads(
        TUNED
        + "mistuning = [0.01, 0.05]\n"
        + "bounds = { stiffness_ratio = [0.01, 1.0], damping_ratio = [0.01, 1.0], travel = 20 }\n"
        + "chart = { primary_damping = [0.1], mass_ratio = { from = 0.1, to = 1 } }\n"
    ),
    "rig": tomllib.loads(
        RIG
        + '[tuning]\ntemperatures = { from = "20 degC", to = "90 degC" }\n'
        + '[response.absorber]\nfrequencies = { from = "1 Hz", to = "20 Hz" }\n'
    ),
    "several": tomllib.loads(SEVERAL),
    "pendulum": tomllib.loads(PENDULUM),
}
WHOLE["pendulum"]["machine"]["pendulum"]["rollers"] = ROLLERS
BAD: tuple[Any, ...] = (
    float("nan"),
    float("inf"),
    "nan",
    "1e400 m",
    "3 bananas",
    [],
    {},
    True,
    "",
    10**400,
)
TABLES = ("machine", "response", "tuning")


def leaves(value: Any, path: KeyPath = ()) -> list[KeyPath]:
    if isinstance(value, dict):
        return [leaf for key, entry in value.items() for leaf in leaves(entry, (*path, key))]
    if isinstance(value, list):
        return [leaf for n, entry in enumerate(value) for leaf in leaves(entry, (*path, n))]
    return [path]


def places(name: str) -> list[KeyPath]:
    return [path for path in leaves(WHOLE[name]) if path[0] in TABLES]


@pytest.mark.parametrize("name", sorted(WHOLE))
def test_the_whole_case_is_fine(name: str) -> None:
    case = validate(WHOLE[name])
    assert check_machine(case) == []
    assert machine_warnings(case) == []
    assert validate(resolve(case)) == case


@pytest.mark.parametrize("name", sorted(WHOLE))
@pytest.mark.parametrize("bad", BAD, ids=lambda bad: str(bad)[:12])
def test_no_value_but_a_good_one_is_taken(name: str, bad: Any) -> None:
    for path in places(name):
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
        assert any(path[: len(one)] == one for one in reported), (key_text(path), reported)


@pytest.mark.parametrize("name", sorted(WHOLE))
def test_a_key_with_a_letter_too_few_is_reported_with_the_right_one(name: str) -> None:
    seen = set()
    for path in places(name):
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


@pytest.mark.parametrize("name", sorted(WHOLE))
def test_scaled_numbers_are_refused_or_stand(name: str) -> None:
    """And the checks that a study leaves out would have found the same."""
    refused, cache = 0, StageCache()
    tables = resolve(validate(WHOLE[name]))
    for path in leaves(tables):
        value = get_key(tables, path)
        if isinstance(value, bool | str) or not value or path[0] not in TABLES:
            continue
        for scale in (0.0, -1.0, 1e-30, 1e30, 1e3, 1.1):
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
            assert all("nan" not in text for text in machine_warnings(case))
    assert refused > 10


@pytest.mark.parametrize(
    "scene", long_but(["absorber", "absorber_rig", "pendulum"], "absorber_rig")
)
def test_broken_starters_end_in_words(scene: str, tmp_path: Path) -> None:
    codes = check_broken_starters(scene, 33, tmp_path / "mutated.toml")
    assert set(codes) <= {0, 2}
    assert codes[2] > 10
