"""Claim: starter cases, resolved cases, the JSON schema and the schema itself say the same."""

import copy
import re
import tomllib
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from long_but import long_but
from shipped_cases import judge

from vibecalc.cli.starters import scenes, starter
from vibecalc.core.case.load import load_case, resolve, validate
from vibecalc.core.case.raw import EACH, Data, set_key
from vibecalc.core.case.walk import keys_of, shape_at, shape_of
from vibecalc.core.results.case_hash import case_hash
from vibecalc.errors import CaseError, KeyPath
from vibecalc.kinds import FINDING_MOTORS, KINDS, MACHINE, OF_THE_BODY, absent_places, motor_kind
from vibecalc.parts.motor_tables import Motor

CASES = sorted((Path(__file__).parent.parent / "cases").glob("*.toml"))


@pytest.fixture(params=sorted(scenes()))
def text(request: pytest.FixtureRequest) -> str:
    """Each starter case."""
    return starter(request.param)


def test_starters_load_as_they_are_and_fit_the_screen(text: str, tmp_path: Path) -> None:
    path = tmp_path / "starter.toml"
    path.write_text(text)
    loaded = load_case(path)
    assert (loaded.name, loaded.text) == ("starter", text)
    assert text.startswith("#:schema ./vibecalc.schema.json\n# ") and text.endswith("\n")
    assert max(map(len, text.splitlines())) <= 100


# ----------------------------------------------------------------------------
# What stands in a starter as a comment: `# key = value` of the table above it, `#   key = value` of
# an entry of the list below it (`#   key: ...` where entries have it), `# [table]` at the end.
# ----------------------------------------------------------------------------

LINE = re.compile(r"(?P<entry>#   |# |)(?P<key>\w+)(?P<sign> = |:)(?P<rest>.*)")
HEADER = re.compile(r"(?P<left># |)\[{1,2}(?P<path>[\w.]+)\]{1,2}")
CLASHES = re.compile(
    "are mutually exclusive|is given twice|is given, but|has units, and no|belongs to|others do"
    "|needs| has no"
)


class Commented(NamedTuple):
    """A key that stands as a comment: where it would be, its value, what is said about it."""

    path: KeyPath
    value: Any
    about: str


def headed(path: str, data: Any) -> KeyPath:
    """A header as a path into the case, at the first entry of each list."""
    whole: list[str | int] = []
    for part in path.split("."):
        whole.append(part)
        data = data.get(part, {}) if isinstance(data, dict) else {}
        if isinstance(data, list):
            whole.append(0)
            data = data[0]
    return tuple(whole)


def shown(text: str) -> tuple[set[KeyPath], list[Commented]]:
    """Places that a starter names, and its commented keys."""
    data, table, entries = tomllib.loads(text), (), []
    named: set[KeyPath] = set()
    commented: list[Commented] = []
    before = ""
    for line in text.split("\n\n", 1)[1].splitlines():
        header, found = HEADER.match(line), LINE.match(line)
        if header:
            path = headed(header["path"], data)
            named.add(path[:-1] if path[-1] == 0 else path)
            table = table if header["left"] else path
        elif found and found["entry"] == "#   ":
            entries.append((found, before))
        elif found and found["sign"] == " = ":
            path = (*table, found["key"])
            named.add(path)
            for one, above in entries:
                place = (*path, 0, one["key"])
                named.add(place)
                if one["sign"] == " = ":
                    commented.append(Commented(place, value_of(one), one["rest"] + above))
            entries = []
            if found["entry"]:
                commented.append(Commented(path, value_of(found), found["rest"] + before))
        before = line
    return named, commented


def value_of(line: re.Match[str]) -> Any:
    return tomllib.loads(f"{line['key']} = {line['rest']}")[line["key"]]


#: what checks refuse of a line without cylinders, in words of their own
SHAFT_LINE = (*MACHINE, "shaft_line")
OF_CYLINDERS = (
    *((*SHAFT_LINE, "stations", EACH, key) for key in ("throw", "cylinder", "cylinders")),
    (*SHAFT_LINE, "shafts", EACH, "throw"),
    (*SHAFT_LINE, "engine_damping"),
    *(
        ("response", "torsion", key)
        for key in ("misfire", "misfire_kind", "orders", "conditions", "as_published")
    ),
    ("response", "torsion", "variable_inertia"),
)


def starred(path: KeyPath) -> KeyPath:
    return tuple(EACH if isinstance(part, int) else part for part in path)


def of_others(data: Data, path: KeyPath) -> bool:
    """Whether only another kind of machine or motor has this place."""
    kind, motor, place = data["machine"]["kind"], motor_kind(data["machine"]), starred(path)
    if absent_places(kind).get(place):
        return True
    if kind == "drive_train" and place in OF_CYLINDERS:
        return True
    if place == (*MACHINE, "speed"):
        return motor in FINDING_MOTORS or "speed" not in KINDS[kind].needs
    if kind == "absorber" and place[:1] == ("response",) and len(place) == 2:
        return place[1] in ("method", *OF_THE_BODY)
    if place[:2] == (*MACHINE, "motor") and len(place) == 3:
        kinds = {name for name, keys in Motor.RULES[0].kinds.items() if place[2] in sum(keys, ())}
        return bool(kinds) and motor not in kinds
    return place in KINDS[kind].foreign


def test_every_key_of_every_table_is_named_and_none_of_another_kind(text: str) -> None:
    data = tomllib.loads(text)
    named, _ = shown(text)
    assert not {path for path in named if of_others(data, path)}

    def held(value: Any, path: KeyPath) -> None:
        shape = shape_at(path)
        if shape is not None and shape.table is not None and isinstance(value, dict):
            for key, field in keys_of(shape.table).items():
                below, place = shape_of(field), (*path, key)
                table = below.table or (below.item and below.item.table)
                if key in value:
                    held(value[key][0] if below.kind == "list" else value[key],
                         (*place, 0) if below.kind == "list" else place)  # fmt: skip
                elif not of_others(data, place) and not (table and len(path) < 2):
                    assert place in named, f"{place} is not named"

    held(data, ())


def test_commented_keys_have_their_defaults_or_say_that_they_are_examples(text: str) -> None:
    for path, value, about in shown(text)[1]:
        shape = shape_at(path[:-1])
        assert shape is not None and shape.table is not None, path
        field = keys_of(shape.table)[str(path[-1])]
        default = field.get_default(call_default_factory=True)
        if default in (None, (), {}):
            assert "# e.g., " in about, path
        else:
            assert value == (list(default) if isinstance(default, tuple) else default), path


def test_each_commented_key_may_be_taken_in_or_is_refused_for_what_it_clashes_with(
    text: str,
) -> None:
    data = tomllib.loads(text)
    for path, value, _ in shown(text)[1]:
        changed = copy.deepcopy(data)
        table = changed
        for part in path[:-1]:
            table = table[part]
        table[path[-1]] = value
        problems = refused(changed)
        assert CLASHES.search(problems) or not problems, f"{path}: {problems}"


def refused(data: Data) -> str:
    """Why a case is refused, or nothing."""
    try:
        validate(data)
    except CaseError as error:
        return str(error)
    return ""


def test_no_weights_at_all_is_an_empty_list_but_someone_has_to_work() -> None:
    data = tomllib.loads(starter("compressor"))
    set_key(data, "excitation.balanced_for", [])
    set_key(data, "response.balances[1].balanced_for", [])
    case = validate(data)
    assert case.excitation is not None and case.excitation.balanced_for == ()
    assert case.response is not None and case.response.balances[1].balanced_for == ()
    assert judge().is_valid(data)
    again = resolve(case)
    assert validate(again) == case
    for key in ("excitation.working", "response.operations[0].working"):
        broken = copy.deepcopy(data)
        set_key(broken, key, [])
        with pytest.raises(CaseError, match="working is empty"):
            validate(broken)
        assert not judge().is_valid(broken)


KEPT = (path for path in CASES if "_" not in path.stem or path.stem.endswith("_sweep"))


@pytest.mark.parametrize("path", long_but(CASES, *KEPT), ids=lambda path: path.stem)
def test_shipped_cases_survive_being_resolved(path: Path) -> None:
    loaded = load_case(path)
    judge().validate(tomllib.loads(loaded.text))
    judge().validate(tomllib.loads(loaded.resolved_toml))
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
