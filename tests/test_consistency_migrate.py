"""Claim: a case of before is rewritten to the names of now, and nothing else of it changes.

The oracle is `current_case`, which renames the tables that tomllib reads: a rewritten text, read by
tomllib, is the renamed tables of the text as it was.
"""

import json
import tomllib
from pathlib import Path

import h5py
import pytest
from fuzzing import command
from schema_places import places
from shipped_cases import CASES

from vibecalc.core.case.load import load_case
from vibecalc.core.case.migrate import migrate
from vibecalc.core.case.raw import EACH
from vibecalc.core.results.compare import compare
from vibecalc.core.results.renamed import (
    AXES,
    KEYS,
    PATHS,
    VALUES,
    current_axis,
    current_case,
    current_choice,
    current_key,
    current_name,
    current_path,
    current_where,
)
from vibecalc.core.results.store import read_result
from vibecalc.core.results.verdicts import as_objects, from_objects, verdicts_of
from vibecalc.errors import CaseError, dotted
from vibecalc.torsion.question_tables import Conditions, condition_names

GOLDEN = Path(__file__).resolve().parent / "golden"
OLD = """# a machine of before
[machine] # its tables
kind = "generator"
"crank_train".stroke = "z"   # upwards
crank_train . crank_radius = "50 mm"
speed = "1500 rpm"

[sweep]
keep = ["isolation/torque_reaction/mean_support_force", "excitation/force_peak"]
axes = [{ key = "machine.crank_train.stroke", values = ["x", 'z'] }]

[[limit]]
quantity = 'foundation/coupled/mount_force'
where = { half_order = 2.0, mount = "left" }
max = "100 N"
source = "half_order of the stroke, machine.crank_train.stroke to the left"
"""


#: what may stand at each key of the schema, positions in lists left out
PLACES = {
    tuple(part for part in pattern if part != EACH): place.shape
    for pattern, place in places().items()
}


@pytest.mark.parametrize("old", KEYS)
def test_no_key_of_the_schema_has_a_name_of_before(old: str) -> None:
    """Each row of the table is the place of a key that is there under its new name only."""
    *above, last = old.split(".")
    new = (*above, KEYS[old])
    assert any(place[-len(new) :] == new for place in PLACES), f"no key is named {new}"
    assert not [place for place in PLACES if current_name(place) == KEYS[old]]
    assert last != KEYS[old]


@pytest.mark.parametrize("place", VALUES)
def test_no_choice_of_the_schema_has_a_name_of_before(place: str) -> None:
    """What is chosen now is a choice at its place, and what was is none."""
    ends = [one for one in PLACES if f".{dotted(one)}".endswith(f".{place}")]
    assert ends
    for path in ends:
        choices = set(PLACES[path].choices)
        assert set(VALUES[place].values()) <= choices
        assert not VALUES[place].keys() & choices
        for old, new in VALUES[place].items():
            assert (current_choice(path, old), current_choice(path, new)) == (new, None)


def test_no_result_has_a_name_of_before() -> None:
    for path in sorted(GOLDEN.glob("*.h5")):
        with h5py.File(path) as file:
            quantities = json.loads(file.attrs["quantities"])
            axes = {scale.label for one in quantities for scale in file[one].dims}
        assert [current_path(one) for one in quantities] == quantities, path.name
        assert {current_axis(one) for one in axes} == axes, path.name


def test_paths_of_before_are_called_differently_now() -> None:
    for old, new in PATHS.items():
        assert current_path(old) == current_path(new) == new
        assert current_path(f"optimisation/start/{old}/x") == f"optimisation/start/{new}/x"
        assert current_path(f"{old}s") == f"{old}s"


@pytest.mark.parametrize("name", CASES)
def test_a_shipped_case_is_up_to_date(name: str) -> None:
    found = migrate(CASES[name])
    assert not found.renamings
    assert not found.files
    assert found.text == CASES[name].read_text(encoding="utf-8")


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_names_change_and_nothing_else(tmp_path: Path, end: str) -> None:
    case = tmp_path / "case.toml"
    case.write_bytes(OLD.replace("\n", end).encode())
    found = migrate(case)
    assert found.text.count(end) == OLD.count("\n")
    text = found.text.replace(end, "\n")
    assert tomllib.loads(text) == current_case(tomllib.loads(OLD))
    for old, new in (
        ('kind = "generator"', 'kind = "machine"'),
        ('"crank_train".stroke = "z"   # up', '"crank_train".stroke_axis = "z"   # up'),
        ('"machine.crank_train.stroke"', '"machine.crank_train.stroke_axis"'),
        ("torque_reaction/mean_support_force", "support_force/mean"),
        ("foundation/coupled/mount_force", "isolation/support_force/steady_harmonics"),
        *((f"{old} =", f"{new} =") for old, new in AXES.items()),
    ):
        assert old not in text
        assert new in text or old not in OLD
    assert text.endswith(OLD[OLD.index("max = ") :])
    assert [row.old for row in found.renamings if row.line == 4] == ["stroke"]
    case.write_text(found.text, encoding="utf-8")
    assert not migrate(case).renamings


def test_columns_of_files_are_keys(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(KEYS, "shafts.torsional_stiffness", "stiffness")
    monkeypatch.setitem(KEYS, "section.outside", "outer_diameter")
    text = '[machine.shaft_line]\nshafts = "shafts.csv"\n'
    (tmp_path / "case.toml").write_text(text, encoding="utf-8")
    columns = "# ours\r\nname, Torsional stiffness [MN*m/rad] , section.outside (mm)\r\na, 1, 2\r\n"
    now = "# ours\r\nname, stiffness [MN*m/rad] , section.outer_diameter (mm)\r\na, 1, 2\r\n"
    (tmp_path / "shafts.csv").write_bytes(columns.encode())
    found = migrate(tmp_path / "case.toml")
    assert found.text == text
    assert found.files == {"shafts.csv": now}
    assert [(row.file, row.line) for row in found.renamings] == [("shafts.csv", 2)] * 2


def test_an_item_of_a_stock_names_keys(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(KEYS, "each.spring_rate", "stiffness")
    case = tmp_path / "case.toml"
    case.write_text(
        '[[optimisation.stock]]\ntable = "machine.mounts.each"\n'
        'items = [{ name = "a", values = { spring_rate = 1.0 } }]\n',
        encoding="utf-8",
    )
    assert "values = { stiffness = 1.0 }" in migrate(case).text


def test_a_key_under_both_names_is_refused(tmp_path: Path) -> None:
    case = tmp_path / "case.toml"
    case.write_text('[machine.crank_train]\nstroke = "z"\nstroke_axis = "z"\n', encoding="utf-8")
    with pytest.raises(CaseError, match="stroke is now stroke_axis, and both stand here") as told:
        migrate(case)
    assert told.value.problems[0].line == 2


def test_an_unknown_key_of_before_says_its_name(tmp_path: Path) -> None:
    case = tmp_path / "case.toml"
    text = CASES["compressor"].read_text(encoding="utf-8").replace("stroke_axis =", "stroke =")
    case.write_text(text, encoding="utf-8")
    with pytest.raises(CaseError, match="unknown key 'stroke'") as told:
        load_case(case)
    hints = [one.hint for one in told.value.problems if one.path[-1] == "stroke"]
    assert hints == ["`stroke` is now `stroke_axis`; `vibecalc migrate CASE` rewrites the case"]
    with pytest.raises(CaseError, match="`stroke` is now `stroke_axis`"):
        load_case(CASES["compressor"], ["machine.crank_train.stroke=z"])


def test_a_choice_of_before_says_its_name() -> None:
    hint = '`kind = "generator"` is now `"machine"`; `vibecalc migrate CASE` rewrites the case'
    with pytest.raises(CaseError, match="unknown kind 'generator'") as told:
        load_case(CASES["generator"], ["machine.kind=generator"])
    assert [one.hint for one in told.value.problems] == [hint]


def test_keys_are_renamed_part_by_part() -> None:
    assert current_key("machine.crank_train.stroke") == "machine.crank_train.stroke_axis"
    assert current_key("machine.crank_train.cylinders[0].name") == (
        "machine.crank_train.cylinders[0].name"
    )


def test_entries_of_an_axis_have_the_names_of_now() -> None:
    where = {"curve": "own damping 0.05", "peak": 1}
    now = {"curve": "absorber damping ratio 0.05", "peak": 1}
    assert current_where(where) == now == current_where(now)
    assert current_case({"limit": [{"where": where}]}) == {"limit": [{"where": now}]}
    before = read_result(GOLDEN / "absorber_curves.h5").record["response/absorber/largest"]
    assert "absorber damping ratio 0.05" in before.axes[0].values


@pytest.mark.parametrize(
    ("before", "now"),
    [
        ("5 misfires", "misfire of cylinder 5"),
        ("A1 out of balance", "imbalance of cylinder A1"),
        ("misfire of cylinder a misfires", "misfire of cylinder a misfires"),
        ("all fire", "all fire"),
    ],
)
def test_conditions_of_the_cylinders_are_called_as_reports_call_them(before: str, now: str) -> None:
    where = {"condition": before, "section": "crank 3-4"}
    assert current_where(where) == {**where, "condition": now}
    assert current_case({"limit": [{"where": where}]}) == {
        "limit": [{"where": current_where(where)}]
    }
    names = condition_names(Conditions(imbalance=0.1), ["5", "A1"])
    assert now in {*names, "misfire of cylinder a misfires"}


def test_a_result_of_before_has_the_names_of_now(tmp_path: Path) -> None:
    """A golden file whose quantities and axes get their names of before reads as it did."""
    name = "pump"
    old = "isolation/torque_reaction/mean_support_force"
    new = "isolation/support_force/mean"
    now = read_result(GOLDEN / f"{name}.h5")
    before = tmp_path / "before.h5"
    before.write_bytes((GOLDEN / f"{name}.h5").read_bytes())
    with h5py.File(before, "r+") as file:
        file.require_group(old.rpartition("/")[0])
        file.move(new, old)
        file.attrs["quantities"] = file.attrs["quantities"].replace(f'"{new}"', f'"{old}"')
    read = read_result(before)
    assert list(read.record) == list(now.record)
    assert compare(read, now).same


def test_verdicts_of_before_have_the_names_of_now() -> None:
    rows = verdicts_of(read_result(GOLDEN / "genset_coupling.h5"))
    before = [
        {name.replace("utilisation", "use"): value for name, value in row.items()}
        | {"quantity": row["quantity"].replace("utilisation", "use")}
        for row in as_objects(rows)
    ]
    assert before[0]["quantity"] == "response/torsion/coupling/use"
    assert "utilisation" not in before[0]
    assert list(map(str, from_objects(before))) == list(map(str, rows))


@pytest.fixture
def old_case(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "old.toml").write_text(OLD, encoding="utf-8")
    return Path("old.toml")


def test_the_command_rewrites_in_place(old_case: Path) -> None:
    told = command("migrate", "old.toml")
    assert told.code == 0
    assert "old.toml:4: stroke -> stroke_axis\n" in told.out
    assert told.out.endswith("wrote old.toml\n")
    assert "stroke_axis" in old_case.read_text(encoding="utf-8")
    again = command("migrate", "old.toml")
    assert (again.code, again.out) == (0, "old.toml is up to date\n")


def test_the_command_writes_elsewhere(old_case: Path) -> None:
    said = json.loads(command("migrate", "old.toml", "-o", "new.toml", "--json").out)
    assert said["written"] == ["new.toml"]
    assert said["renamed"][-1]["file"] == "old.toml"
    assert old_case.read_text(encoding="utf-8") == OLD
    assert "stroke_axis" in Path("new.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("missing.toml",), "missing.toml does not exist"),
        (("broken.toml",), "not TOML"),
        (("old.toml", "old.toml", "-o", "new.toml"), "-o names the file for one case"),
        (("-",), "needs -o"),
    ],
)
def test_what_cannot_be_rewritten_stays(
    old_case: Path, arguments: tuple[str, ...], words: str
) -> None:
    Path("broken.toml").write_text("[machine\n", encoding="utf-8")
    told = command("migrate", *arguments)
    assert told.code == 2
    assert words in told.err
    assert old_case.read_text(encoding="utf-8") == OLD
