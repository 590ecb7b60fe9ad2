"""Claim: files of a shaft line that cannot be read are refused in one message with their line."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from refused import changed, refusal, refusals
from test_consistency_shaft_line_files import HEAD

from vibecalc.core.case.load import load_case
from vibecalc.errors import UsageError
from vibecalc.torsion.adapters.exchange import case_of_assembly, export_shaft_line
from vibecalc.torsion.tors import LARGEST_FILE

FILES = {
    "stations": (
        "name; inertia [kg m^2]; cylinder\ncrank; 1,5; 1\n# a remark\nwheel; 2,5;\n"
        "pinion; 0,5; 2\nend; 3;\n"
    ),
    "shafts": (
        "from,to,stiffness (MN*m/rad),outer diameter [mm],inner diameter [mm],length [mm]\n"
        "crank,wheel,1.5,,,\nwheel,pinion,,100,20,500\n"
    ),
    "gears": "from,to,teeth from,teeth to,reverses\npinion,end,20,61,no\n",
}
LISTS = "".join(f'{name} = "{name}.csv"\n' for name in FILES)
ASSEMBLY = """\
{
 "components": [
  {"name": "a", "elements": [
   {"name": "d", "type": "Disk",
    "inertia": 3, "damping": 0},
   {"name": "k", "type": "ShaftDiscrete", "stiffness": 9e5, "damping": 1},
   {"name": "g1", "type": "GearElement", "inertia": 0.1, "teeth": 20},
   {"name": "g2", "type": "GearElement", "inertia": 0.4, "teeth": 60, "parent": "g1"}]},
  {"name": "b", "elements": [
   {"name": "k", "type": "ShaftContinuous", "length": 900, "outerDiameter": 90, "innerDiameter": 0},
   {"name": "d", "type": "Disk", "inertia": 5, "damping": 0}]}
 ],
 "structure": [["a.g2", "b.k"]]
}
"""


def said(file: str, change: str, folder: Path) -> str:
    if file == "assembly":
        return of_assembly(changed(ASSEMBLY, change).encode(), folder)
    files = FILES | ({file: changed(FILES[file], change)} if file else {})
    text = refusal(folder, "case", HEAD + LISTS, **files)
    assert text.count("error: ") <= 1, text
    return text


def of_assembly(content: bytes, folder: Path) -> str:
    path = folder / "line.json"
    path.write_bytes(content)
    try:
        case_of_assembly(path)
    except UsageError as error:
        return str(error)
    return ""


def test_the_good_files_are_read(tmp_path: Path) -> None:
    assert said("", "-", tmp_path) == ""
    assert said("assembly", "-", tmp_path) == ""


@pytest.mark.parametrize(("file", "change", "line", "words"), refusals("shaft_line_files"))
def test_refused(file: str, change: str, line: str, words: list[str], tmp_path: Path) -> None:
    text = said(file, change, tmp_path)
    for part in words:
        assert part.strip() in text, text
    if line != "0":
        assert f"line {line}" in text, text
    assert "Traceback" not in text
    assert "pydantic" not in text


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "not JSON"),
        (b"\xff\xfe{}", "is encoded in UTF-16\n  help: save it in UTF-8"),
        (b"[1, 2]", "it has a list; wanted: 'components'"),
        (b"[" * 100_000, "not readable JSON"),
        (b'{"components": []}', "the file has no components"),
        (b'{"components": [' + b"9" * 5000 + b"]}", "not readable JSON"),
        (b'{"components": [{"name": "\\ud800", "elements": []}]}', "components[0] has no name"),
        (b'{"components": [7, {"name": 3}]}', "components[0] has no name"),
        (b" " * (LARGEST_FILE + 1), "is larger than"),
        (b'{"shafts": [{"nl": -1, "nr": 0, "k": 5.0}]}', "it has the keys 'shafts'; wanted"),
    ],
)
def test_other_files_are_no_assembly(content: bytes, words: str, tmp_path: Path) -> None:
    assert words in of_assembly(content, tmp_path)


def test_no_file_and_a_folder(tmp_path: Path) -> None:
    for path, words in (
        (tmp_path / "none.json", "the assembly"),
        (tmp_path, "is a folder"),
        (tmp_path / "a\0b.json", "has a null character in its name"),
    ):
        with pytest.raises(UsageError, match=words):
            case_of_assembly(path)


def test_ten_problems_are_eight_and_a_count(tmp_path: Path) -> None:
    file = json.loads(ASSEMBLY)
    file["components"][0]["elements"] = [{"name": f"d{n}", "type": "Disk"} for n in range(10)]
    text = of_assembly(json.dumps(file).encode(), tmp_path)
    assert text.count("has no 'inertia'") == 8
    assert text.endswith("and 2 more")


@pytest.mark.parametrize("change", ["# a name", " wheel"])
def test_a_name_that_no_file_gives_back(change: str, tmp_path: Path) -> None:
    text = (
        f'stations = [{{ name = "{change}", inertia = 1.0, cylinders = ["1", "2"] }}, '
        '{ name = "b", inertia = 2.0 }]\nshafts = [{ stiffness = 1e5 }]\n'
    )
    (tmp_path / "case.toml").write_text(HEAD + text)
    with pytest.raises(UsageError, match="begin"):
        export_shaft_line(load_case(tmp_path / "case.toml"), tmp_path)
    assert not re.findall(r"\.csv", str(list(tmp_path.iterdir())))


def test_what_an_assembly_cannot_say(tmp_path: Path) -> None:
    ends = 'stations = [{ name = "a", inertia = 1.0, cylinders = ["1", "2"]HELD }, '
    ends += '{ name = "b", inertia = 2.0 }]\n'
    shaft = '{ name = "NAME", between = ["a", "b"], stiffness = 1e5 }'
    for held, shafts, words in (
        ("", [shaft, shaft.replace("NAME", "x")], "'x' between 'a' and 'b' closes a loop"),
        (", ground_stiffness = 5.0", [shaft], "no word for a stiffness to the ground, as of 'a'"),
    ):
        lists = ends.replace("HELD", held) + f"shafts = [{', '.join(shafts)}]\n"
        (tmp_path / "case.toml").write_text(HEAD + lists)
        with pytest.raises(UsageError, match=words):
            export_shaft_line(load_case(tmp_path / "case.toml"), tmp_path / "line.json")
    (tmp_path / "case.toml").write_text(HEAD[: HEAD.index("[response")] + "[excitation]\n")
    with pytest.raises(UsageError, match=r"no \[machine.shaft_line\] to write"):
        export_shaft_line(load_case(tmp_path / "case.toml"), tmp_path / "line.json")


NONSENSE = (None, True, -1, 0, 1e300, 5e-324, "", "x", "k", "g1", "a.g2", [], {}, [["a.g2", "b.k"]])


def places(data: object) -> list[tuple[object, object]]:
    """What holds each value of a file, and its key."""
    entries = (
        data.items()
        if isinstance(data, dict)
        else enumerate(data)
        if isinstance(data, list)
        else ()
    )
    return [place for key, one in entries for place in ((data, key), *places(one))]


def test_nonsense_is_read_or_refused(tmp_path: Path) -> None:
    """In one place or two; nothing else is raised."""
    draw = np.random.default_rng(7)
    refused = 0
    for _ in range(100):
        file = json.loads(ASSEMBLY)
        for _ in range(int(draw.integers(1, 3))):
            there = places(file)
            holder, key = there[int(draw.integers(len(there)))]
            if draw.random() < 0.2 and isinstance(holder, dict):
                holder.pop(key)
            else:
                holder[key] = NONSENSE[int(draw.integers(len(NONSENSE)))]
        refused += bool(of_assembly(json.dumps(file).encode(), tmp_path))
    assert 50 < refused < 100
