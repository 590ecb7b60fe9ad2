"""Claim: what an editor is told of cases by the JSON schemas is what `vibecalc check` holds to.

The judges are jsonschema, and the two programs behind most editors of TOML, taplo and tombi.
"""

import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from long_but import long_but
from schema_places import keys, places
from shipped_cases import CASES, table_of

from vibecalc.cli.editors import schema_name, schema_text, with_directive, write_schema
from vibecalc.cli.starters import scenes, starter
from vibecalc.core.case.load import validate
from vibecalc.core.case.raw import EACH, Data, get_key
from vibecalc.core.case.rules import cross_check
from vibecalc.errors import CaseError, KeyPath
from vibecalc.json_schema import json_schema
from vibecalc.kinds import KINDS, MACHINE, TRAIN

STARTERS = {scene: tomllib.loads(starter(scene)) for scene in scenes()}


@cache
def schema_of(kind: str) -> dict[str, Any]:
    return json_schema(kind)


@cache
def judge_of(kind: str) -> jsonschema.Draft202012Validator:
    return jsonschema.Draft202012Validator(schema_of(kind))


def kind_of(data: Data) -> str:
    kind: str = data["machine"]["kind"]
    return kind


@cache
def every_case() -> dict[str, Data]:
    """Shipped cases and starters."""
    return {name: table_of(name) for name in CASES} | {f"{s}-": STARTERS[s] for s in STARTERS}


@cache
def some_cases() -> tuple[str, ...]:
    """One of each kind of machine."""
    return tuple({kind_of(data): name for name, data in every_case().items()}.values())


#: the starters alone, or all cases: taplo holds all of them to the same in either way
MANY = [pytest.param(False, id="some"), pytest.param(True, id="all", marks=pytest.mark.long)]


@pytest.mark.parametrize("all_of_them", MANY)
def test_cases_fit_the_schema_of_all_kinds_and_that_of_their_kind_alone(all_of_them: bool) -> None:
    assert {kind_of(data) for data in every_case().values()} == set(KINDS)
    for name in every_case() if all_of_them else some_cases():
        data = every_case()[name]
        for kind in KINDS if all_of_them else ("machine", kind_of(data)):
            assert judge_of(kind).is_valid(data) == (kind == kind_of(data)), (name, kind)
        assert judge_of("").is_valid(data), name


# ----------------------------------------------------------------------------
# A place is offered to a kind of machine just where no check says that the kind has it not.
# ----------------------------------------------------------------------------


def table_in(schema: dict[str, Any], path: KeyPath) -> dict[str, Any]:
    """The table of a schema at a path, or one without keys."""
    at = schema
    for part in (*path, ""):
        while "$ref" in at or ("properties" not in at and "anyOf" in at):
            at = schema["$defs"][at["$ref"].split("/")[-1]] if "$ref" in at else at["anyOf"][0]
        if part:
            at = at.get("items", {}) if part == EACH else at.get("properties", {}).get(part, {})
    return at


TABLES: tuple[KeyPath, ...] = ((), MACHINE, ("response",), TRAIN, (*TRAIN, "cylinders", EACH))
TABLES += ((*MACHINE, "shaft_line"),)


def with_key(data: Data, path: KeyPath) -> tuple[Data, KeyPath]:
    """A case with something at a place, which a list has in its first entry; and that place."""
    data = json.loads(json.dumps(data))
    at, whole = data, list[str | int]()
    for part, below in zip(path, (*path[1:], ""), strict=True):
        whole.append(0 if part == EACH else part)
        if below:
            empty: Any = [{}] if below == EACH else {}
            at = at[0] if part == EACH else at.setdefault(part, empty)
        else:
            at.setdefault(part, {})
    return data, tuple(whole)


def machine_of(kind: str) -> Data:
    """A case of this kind that has all that a table may ask for and that the kind may have."""
    data = next(one for one in STARTERS.values() if kind_of(one) == kind)
    data = {"schema": 1, "title": kind, "machine": dict(data["machine"])}
    if kind == "plate":
        data["machine"] |= {**STARTERS["generator"]["machine"], "kind": kind}
    return data


@pytest.mark.parametrize("kind", KINDS)
def test_what_a_kind_is_not_offered_is_what_it_is_refused(kind: str) -> None:
    schema, base, refused = schema_of(kind), machine_of(kind), 0
    for table in TABLES:
        offered = table_in(schema, table).get("properties", {})
        for key in table_in(schema_of(""), table)["properties"]:
            data, path = with_key(base, (*table, key))
            about = [one for one in cross_check(data) if one.path == path[: len(one.path)]]
            words = [one.message for one in about if one.also == (*MACHINE, "kind")]
            foreign = any("is for a machine" in one or " has no " in one for one in words)
            assert foreign == (key not in offered), ((*table, key), words)
            refused += foreign
            if foreign:
                assert not judge_of("").is_valid(data) and not judge_of(kind).is_valid(data)
    assert refused > 10


# ----------------------------------------------------------------------------
# What an editor shows.
# ----------------------------------------------------------------------------


def told(key: dict[str, Any]) -> str:
    """The description of a key, that many tables may have."""
    said = schema_of("")["$defs"][key["$ref"].split("/")[-1]] if "$ref" in key else key
    text: str = said["description"]
    return text


def test_hovers_end_with_the_unit_beside_bounds_and_default() -> None:
    train = table_in(schema_of(""), TRAIN)["properties"]
    assert train["crank_radius"]["description"] == "half the stroke [m]"
    assert train["wrist_pin_offset"]["default"] == 0.0
    assert train["axis"]["enum"] == ["x", "y", "z"] and train["axis"]["default"] == "x"
    assert schema_of("")["$defs"]["unit_m"]["examples"] == ["0.2 m", "200 mm"]
    numbers = 0
    for (_, key), pattern in keys().items():
        (shape, _, field), number = places()[pattern], places()[pattern].innermost
        if number.table is None:
            text = told(table_in(schema_of(""), pattern[:-1])["properties"][key])
            about = f"{field.description} [{number.unit}]" if number.unit else field.description
            assert text == about or text.startswith(f"{about}\n"), key
            numbers += shape.kind == "number"
    assert numbers > 150


@pytest.mark.parametrize("kind", KINDS)
def test_a_schema_of_one_kind_has_at_most_150_kilobytes(kind: str) -> None:
    assert len(schema_text(kind).encode()) <= 150_000


def test_each_kind_of_machine_has_its_line() -> None:
    kind = table_in(schema_of(""), MACHINE)["properties"]["kind"]
    assert kind["enum"] == [*KINDS]
    assert kind["x-taplo"]["docs"]["enumValues"] == [row.about for row in KINDS.values()]
    assert kind["description"].count("\n- `") == len(KINDS)
    ids = {schema_of(one)["$id"] for one in ("", *KINDS)}
    assert len(ids) == len(KINDS) + 1 and "urn:vibecalc:case:1:pump" in ids


# ----------------------------------------------------------------------------
# taplo and tombi.
# ----------------------------------------------------------------------------


def linted(folder: Path, tool: str, *arguments: str) -> dict[str, str]:
    """What a tool finds wrong, for each file of a folder."""
    program = Path(sys.executable).with_name(tool)
    names = sorted(path.name for path in folder.glob("*.toml"))
    done = subprocess.run(
        [str(program), "lint", *arguments, *names], cwd=folder, capture_output=True, text=True
    )
    said = re.sub(r"\x1b\[[0-9;]*m", "", done.stdout + done.stderr)
    found: dict[str, str] = {}
    # tombi: "Error: words" and "at name:line:column"; taplo: "error: words" and "┌─ /../name:line"
    pattern = r"^ *[Ee]rror: (.*)\n\s+(?:at |┌─ )(?:.*[/\\])?([^/\\]+?\.toml):\d+"
    for words, name in re.findall(pattern, said, re.MULTILINE):
        found[name] = found.get(name, "") + words + "\n"
    assert bool(found) == bool(done.returncode), said[-2000:]
    return found


TOOLS = [("taplo",), ("tombi", "--offline")]


def folder_of(names: Iterable[str], folder: Path) -> Path:
    """Cases under the schema of their kind, as `vibecalc new --schema` writes them."""
    for kind in ("", *KINDS):
        write_schema(folder, kind)
    for name in names:
        shipped = CASES.get(name)
        text = shipped.read_text(encoding="utf-8") if shipped else starter(name.removesuffix("-"))
        text = with_directive(text, kind_of(every_case()[name]))
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")
    return folder


def test_taplo_takes_shipped_cases(tmp_path: Path) -> None:
    folder, few = folder_of(every_case(), tmp_path), tmp_path / "few"
    assert not linted(folder, "taplo")
    few.mkdir()
    schema = (folder_of(some_cases(), few) / schema_name("")).as_uri()
    assert not linted(few, "taplo", "--schema", schema)


@pytest.mark.parametrize("all_of_them", MANY)
def test_tombi_takes_shipped_cases(all_of_them: bool, tmp_path: Path) -> None:
    names = every_case() if all_of_them else some_cases()
    assert not linted(folder_of(names, tmp_path), "tombi", "--offline")


#: what is wrong -> key, value, and a word that both tools say
WRONG: dict[str, tuple[str, Any, str]] = {
    "misspelt_key": ("machine.crank_train.rod_lenght", 0.2, "rod_lenght"),
    "misspelt_table": ("machine.crank_trian", {"rod_length": 0.2}, "crank_trian"),
    "wrong_unit": ("machine.crank_train.rod_length", "190 kg", "190 kg"),
    "wrong_speed": ("machine.speed", "1500 mm", "1500 mm"),
    "no_unit": ("machine.speed", "1500 rmp", "1500 rmp"),
    "negative": ("machine.crank_train.rod_length", "-190 mm", "-190 mm"),
    "zero": ("machine.crank_train.rod_length", "0.0 mm", "0.0 mm"),
    "wrong_kind": ("machine.kind", "aeroplane", "aeroplane"),
    "other_kind": ("machine.kind", "engine", "cycle"),
    "other_table": ("tuning", {"kind": "free"}, ""),
    "other_part": ("machine.crank_train.pump_cycle", {}, ""),
    "wrong_choice": ("isolation.model", "pich", "pich"),
    "wrong_length": ("machine.crank_train.origin", [1.0], ""),
    "wrong_type": ("title", 3, ""),
    "switch_for_a_number": ("machine.speed", True, ""),
    "empty_list": ("machine.crank_train.cylinders", [], ""),
    "half_an_order": ("excitation", {"orders": 1.5}, ""),
}


@pytest.mark.parametrize("kind", long_but(["", "machine"], ""))
@pytest.mark.parametrize("tool", TOOLS, ids=lambda tool: tool[0])
def test_tools_flag_wrong_cases(tool: tuple[str, ...], kind: str, tmp_path: Path) -> None:
    import tomli_w

    write_schema(tmp_path, kind)
    for name, (key, value, _) in WRONG.items():
        data = tomllib.loads(starter("generator"))
        table, _, last = key.rpartition(".")
        (get_key(data, table) if table else data)[last] = value
        with pytest.raises(CaseError):
            validate(data)
        assert not judge_of(kind).is_valid(data), name
        text = f"#:schema ./{schema_name(kind)}\n" + tomli_w.dumps(data)
        (tmp_path / f"{name}.toml").write_text(text, encoding="utf-8")
    right = f"#:schema ./{schema_name(kind)}\n" + tomli_w.dumps(STARTERS["generator"])
    (tmp_path / "right.toml").write_text(right, encoding="utf-8")
    found = linted(tmp_path, *tool)
    assert found.keys() == {f"{name}.toml" for name in WRONG}
    if not kind:
        for name, (_, _, word) in WRONG.items():
            said = found[f"{name}.toml"]  # tombi says of a sign that it is one of what is not taken
            assert word in said or (tool[0] == "tombi" and '"not" schema is matched' in said), name


@pytest.mark.parametrize(("tool", "name"), [(TOOLS[0], ".taplo.toml"), (TOOLS[1], "tombi.toml")])
def test_the_files_of_the_document_find_the_schema(
    tool: tuple[str, ...], name: str, tmp_path: Path
) -> None:
    page = (Path(__file__).parents[1] / "docs" / "ci.md").read_text(encoding="utf-8")
    block = page.split(f"`{name}`", 1)[1].split("```toml\n", 1)[1].split("```")[0]
    (tmp_path / name).write_text(block, encoding="utf-8")
    write_schema(tmp_path / "cases", "")
    text = starter("generator").split("\n", 1)[1]
    for case, written in (("right", text), ("wrong", text.replace("55 mm", "55 kg"))):
        (tmp_path / "cases" / f"{case}.toml").write_text(written, encoding="utf-8")
    program = str(Path(sys.executable).with_name(tool[0]))
    for case, code in (("right", 0), ("wrong", 1)):
        run = [program, "lint", *tool[1:], f"cases/{case}.toml"]
        done = subprocess.run(run, cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == code and "arning" not in done.stderr, done.stderr
