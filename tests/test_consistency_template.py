"""Claim: starter cases, resolved cases, the JSON schema and the schema itself say the same."""

import copy
import re
import tomllib
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from long_but import long_but

from vibecalc.core.case.load import case_hash, load_case, resolve, validate
from vibecalc.core.case.raw import get_key, set_key
from vibecalc.core.case.walk import keys_of, shape_at, shape_of
from vibecalc.errors import CaseError, UsageError
from vibecalc.schema import Case
from vibecalc.starters import SCENES, json_schema, starter

CASES = sorted((Path(__file__).parent.parent / "cases").glob("*.toml"))
SCHEMA = json_schema()
JUDGE = jsonschema.Draft202012Validator(SCHEMA)


@pytest.fixture(params=sorted(SCENES))
def text(request: pytest.FixtureRequest) -> str:
    """Each starter case."""
    return starter(request.param)


def test_starters_load_as_they_are(text: str, tmp_path: Path) -> None:
    path = tmp_path / "starter.toml"
    path.write_text(text)
    loaded = load_case(path)
    assert loaded.name == "starter"
    assert loaded.text == text
    data = tomllib.loads(text)
    assert data in [scene.data for scene in SCENES.values()]


def test_starters_fit_the_screen(text: str) -> None:
    written = [line for line in text.splitlines() if "#" in line]
    assert max(map(len, written)) <= 100
    assert text.endswith("\n")


def test_every_key_of_every_table_that_appears_is_shown(text: str) -> None:
    data = tomllib.loads(text)

    def held(value: Any, path: tuple[str | int, ...]) -> None:
        shape = shape_at(path)
        assert shape is not None
        if shape.table is not None:
            for key, field in keys_of(shape.table).items():
                assert re.search(rf"\b{key}\b", text), f"{key} of {path} is not shown"
                words = (field.description or "").split()[0]
                assert words in text
                if key in value:
                    held(value[key], (*path, key))
        elif shape.item is not None and shape.item.table is not None:
            for position, entry in enumerate(value):
                held(entry, (*path, position))

    held(data, ())


def test_units_stand_in_the_comments() -> None:
    lines = starter("generator").splitlines()
    radius = next(line for line in lines if line.startswith("crank_radius"))
    assert radius.split("# ")[1] == "half the stroke [m], > 0"
    assert any(line.startswith("# gravity = 9.80665") and "[m/s^2]" in line for line in lines)


def test_a_bound_stands_once_and_is_the_stricter() -> None:
    (line,) = [one for one in starter("impact").splitlines() if one.startswith("stiffness = ")]
    assert line.endswith("[N/m], > 0") and ">=" not in line
    for scene in SCENES:
        assert not re.search(r">=? \S+, >|<=? \S+, <", starter(scene))


def test_no_weights_at_all_is_an_empty_list_but_someone_has_to_work() -> None:
    data = copy.deepcopy(SCENES["compressor"].data)
    set_key(data, "excitation.balanced_for", [])
    set_key(data, "response.balances[1].balanced_for", [])
    case = validate(data)
    assert case.excitation is not None and case.excitation.balanced_for == ()
    assert case.response is not None and case.response.balances[1].balanced_for == ()
    assert JUDGE.is_valid(data)
    again = resolve(case)
    assert validate(again) == case
    for key in ("excitation.working", "response.operations[0].working"):
        broken = copy.deepcopy(data)
        set_key(broken, key, [])
        with pytest.raises(CaseError, match="working is empty"):
            validate(broken)
        assert not JUDGE.is_valid(broken)


def test_an_unknown_scene_gets_the_list() -> None:
    with pytest.raises(UsageError, match=r"generator, rigid_body.*did you mean 'generator'"):
        starter("genrator")


@pytest.mark.long
def test_json_schema_is_a_schema() -> None:
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    assert SCHEMA["$schema"].endswith("2020-12/schema")


def test_json_schema_takes_the_starters(text: str) -> None:
    JUDGE.validate(tomllib.loads(text))


KEPT = (path for path in CASES if "_" not in path.stem or path.stem.endswith("_sweep"))


@pytest.mark.parametrize("path", long_but(CASES, *KEPT), ids=lambda path: path.stem)
def test_shipped_cases_survive_being_resolved(path: Path) -> None:
    loaded = load_case(path)
    JUDGE.validate(tomllib.loads(loaded.text))
    JUDGE.validate(tomllib.loads(loaded.resolved_toml))
    again = tomllib.loads(loaded.resolved_toml)
    assert again == loaded.resolved
    assert resolve(validate(again)) == loaded.resolved
    assert validate(again) == loaded.case
    assert case_hash(again) == loaded.sha256


def test_hash_follows_values_and_not_comments(tmp_path: Path) -> None:
    text = starter("generator")
    hashes = []
    for number, written in enumerate(
        (
            text,
            "# more\n" + text,
            text.replace('"55 mm"', "0.055"),
            text.replace('"55 mm"', "0.056"),
        )
    ):
        path = tmp_path / f"{number}.toml"
        path.write_text(written)
        hashes.append(load_case(path).sha256)
    assert hashes[0] == hashes[1] == hashes[2] != hashes[3]
    assert re.fullmatch("[0-9a-f]{64}", hashes[0])


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("schema", 2),
        ("title", ""),
        ("title", 3),
        ("surplus", 1),
        ("machine.speed", 0),
        ("machine.speed", True),
        ("machine.surplus", 1),
        ("machine.kind", "aeroplane"),
        ("machine.crank_train.rod_length", -1.0),
        ("machine.crank_train.cylinders", []),
        ("machine.crank_train.cylinders[0].position", [1]),
        ("machine.crank_train.origin", [1, 2]),
        ("machine.body.box.length", {}),
        ("machine.mounts.each.stiffness", [1, 2]),
        ("machine.mounts.each.stiffness", -1),
        ("machine.mounts.each.loss_factor", 11),
        ("isolation.model", "pich"),
        ("accuracy", {"rtol": 0.2}),
        ("excitation", {"orders": 1.5}),
        ("limit[0].max", True),
        ("limit[0].where", {"order": []}),
    ],
)
def test_json_schema_and_schema_refuse_the_same(key: str, value: Any) -> None:
    data = copy.deepcopy(SCENES["generator"].data)
    assert JUDGE.is_valid(data)
    set_key(data, key, value)
    assert get_key(data, key) == value
    with pytest.raises(CaseError):
        validate(data)
    assert not JUDGE.is_valid(data)


def test_every_field_is_described() -> None:
    seen: set[type] = set()

    def visit(table: type) -> None:
        if table in seen:
            return
        seen.add(table)
        assert table.__doc__
        for key, field in keys_of(table).items():
            assert field.description, f"{table.__name__}.{key} has no description"
            shape = shape_of(field)
            below = shape.table or (shape.item.table if shape.item else None)
            if below is not None:
                visit(below)

    visit(Case)
    assert len(seen) > 20
