"""Claim: a CSV file that cannot stand for a table is refused in one message at its key.

The message names the file, and the line and column of it where there is one.
"""

import os
from pathlib import Path

import pytest

from vibecalc.core.case.data_files import LARGEST_FILE, MOST_ROWS
from vibecalc.core.case.load import load_case
from vibecalc.errors import EXIT_USAGE, CaseError

TABLES = """\
schema = 1
title = "one cylinder"

[machine]
kind = "compressor"
speed = "361 rad/s"

[machine.crank_train]
crank_radius = "12.7 mm"
rod_length = "60 mm"
reciprocating_mass = "0.35 kg"
cylinders = [{ name = "A" }]
bore = "41 mm"
"""
PRESSURE = TABLES + 'gas_pressure = "FILE"\n'
TORQUE = """
[machine.motor]
rotor_diameter = "150 mm"
skew_angle = "2 deg"
torque = "FILE"
"""
REFERENCE = """
[kinematics]

[[reference_table]]
quantity = "kinematics/acceleration_harmonics"
axis = "order"
file = "FILE"
source = "a table"
"""
GOOD = "crank_angle [deg], pressure [bar]\n0, 9\n90, 0\n270, 0\n360, 9\n"
ORDERS = "order, exact [in/s^2], cut [in/s^2]\n1, 65160.5, 65160\n2, 13873.2,\n"


def refused(folder: Path, case: str, name: str = "table.csv") -> str:
    """The message about a case whose table is the file of that name."""
    path = folder / "case.toml"
    path.write_text(case.replace("FILE", name), encoding="utf-8")
    with pytest.raises(CaseError) as caught:
        load_case(path)
    assert caught.value.exit_code == EXIT_USAGE
    text = str(caught.value)
    assert text.count("error: ") == 1, text
    assert "Traceback" not in text and "pydantic" not in text
    return text


def reported(folder: Path, content: str | bytes, case: str = PRESSURE) -> str:
    data = content if isinstance(content, bytes) else content.encode()
    (folder / "table.csv").write_bytes(data)
    return refused(folder, case)


def test_the_good_file_is_read(tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text(GOOD)
    (tmp_path / "case.toml").write_text(PRESSURE.replace("FILE", "table.csv"))
    train = load_case(tmp_path / "case.toml").case.machine.crank_train
    assert train.gas_pressure is not None
    assert train.gas_pressure.pressure == (9e5, 0.0, 0.0, 9e5)


@pytest.mark.parametrize(
    ("case", "key", "place"),
    [
        (PRESSURE, "gas_pressure", "14:1"),
        (TABLES + TORQUE, "torque", "18:1"),
        (TABLES + REFERENCE, "file", "20:1"),
    ],
)
def test_a_file_that_is_not_there(tmp_path: Path, case: str, key: str, place: str) -> None:
    text = refused(tmp_path, case)
    assert f"error: {key}: there is no such file" in text
    assert f"case.toml:{place}\n" in text
    assert "found 'table.csv'; allowed: the name of a CSV file next to the case" in text
    (tmp_path / "tables.csv").write_text(GOOD)
    assert "help: did you mean 'tables.csv'?" in refused(tmp_path, case)


PRESSURES: list[tuple[str, str | bytes, list[str]]] = [
    ("empty", "", ["the file is empty", "a line of column names"]),
    ("comments only", "# angle\n\n# pressure\n", ["the file is empty"]),
    ("header only", "crank_angle [deg], pressure [bar]\n", ["a line of names and no values"]),
    ("not UTF-8", b"crank_angle, pressure\n\xff\xfe, 1\n", ["not a text in UTF-8"]),
    ("short row", GOOD + "# more\n\n370\n", ["line 8 of the file has 1 cell", "allowed: 2"]),
    ("long row", GOOD.replace("90, 0", "90, 0, 5"), ["line 3 of the file has 3 cells"]),
    (
        "semicolons in the rows",
        "crank_angle; pressure, x\n0; 1\n",
        ["line 2 of the file has 1 cell", "parted by commas, not by semicolons"],
    ),
    ("doubled column", "pressure [bar], pressure [Pa]\n1, 2\n", ["two columns are named 'press"]),
    ("nameless column", GOOD.replace("\n", ",\n"), ["column 3 has no name"]),
    (
        "open bracket",
        GOOD.replace("bar]", "bar"),
        ["cannot be read: 'pressure [bar'"],
    ),
    ("two brackets", GOOD.replace("bar]", "bar] [x]"), ["name of column 2 cannot be read"]),
    (
        "unknown column",
        GOOD.replace("pressure", "presure"),
        ["unknown key 'presure' in [machine.crank_train.gas_pressure]", "did you mean 'pressure'?"],
    ),
    (
        "missing column",
        "crank_angle [deg]\n0\n90\n360\n",
        ["missing key 'pressure' in [machine.crank_train.gas_pressure]"],
    ),
    (
        "word",
        GOOD.replace("270, 0", "270, none"),
        ["column pressure: not a number: 'none'"],
    ),
    ("NaN", GOOD.replace("270, 0", "270, nan"), ["line 4, column pressure: not finite: 'nan'"]),
    ("infinite", GOOD.replace("270, 0", "270, -inf"), ["line 4, column pressure: not finite"]),
    ("too large", GOOD.replace("270, 0", "270, 1e999"), ["too large for a double: '1e999'"]),
    ("blank cell", GOOD.replace("270, 0", "270,"), ["line 4, column pressure: no number"]),
    (
        "decimal comma",
        GOOD.replace("270, 0", '270, "0,5"'),
        ["line 4, column pressure: not a number: '0,5'", "write a point: '0.5'"],
    ),
    (
        "unit twice",
        GOOD.replace("270, 0", "270, 0 bar"),
        ["line 4, column pressure: the unit stands twice: '0 bar'", "numbers alone"],
    ),
    (
        "wrong unit",
        GOOD.replace("bar", "mm"),
        ["column pressure, unit 'mm': wrong dimension, a length", "allowed: a pressure"],
    ),
    (
        "unknown unit",
        GOOD.replace("bar", "baar"),
        ["column pressure, unit 'baar': unknown unit", "did you mean 'bar'?"],
    ),
    ("unit too large", GOOD.replace("bar", "Ym^99"), ["column pressure, unit 'Ym^99'"]),
    ("many rows", "a\n" + "1\n" * (MOST_ROWS + 1), ["has 20001 lines of values", "up to 20000"]),
    ("many columns", ",".join(map(str, range(500))) + "\n1\n", ["has 500 columns", "up to 200"]),
    ("huge", b"#" * (LARGEST_FILE + 1), ["the file is larger than 2 MB"]),
    ("a cell without end", 'a, b\n1, "' + "x" * 200_000 + "\n", ["the file is no CSV"]),
]


@pytest.mark.parametrize(
    ("content", "expected"), [row[1:] for row in PRESSURES], ids=[row[0] for row in PRESSURES]
)
def test_pressures(tmp_path: Path, content: str | bytes, expected: list[str]) -> None:
    text = reported(tmp_path, content)
    assert f"{tmp_path / 'case.toml'}:14:1\n" in text
    for words in expected:
        assert words in text


ORDER_COLUMN: list[tuple[str, list[str]]] = [
    ("order [deg], cosine, sine\n1, 2, 3\n", ["column order is of whole numbers and has no unit"]),
    ("order, cosine, sine\n1.5, 2, 3\n", ["line 2, column order: not a whole number: '1.5'"]),
    ("order, cosine, sine\n-1, 2, 3\n", ["order[0] is out of range", "found -1; allowed: >= 0"]),
    ("order, cosine [N*m], sine [N]\n1, 2, 3\n", ["column sine, unit 'N': wrong dimension"]),
    ("order, cosine, sine\n1, 2, 3 N\n", ["sine[0]: wrong dimension", "found '3 N', a force"]),
    ("order, cosine, sine, phase\n1, 2, 3, 4\n", ["unknown key 'phase'", "order, cosine, sine"]),
]


@pytest.mark.parametrize(("content", "expected"), ORDER_COLUMN)
def test_torques(tmp_path: Path, content: str, expected: list[str]) -> None:
    text = reported(tmp_path, content, TABLES + TORQUE)
    for words in expected:
        assert words in text


COLUMN = REFERENCE + 'column = "COLUMN"\n'
REFERENCES: list[tuple[str, str, str, list[str]]] = [
    ("which column", REFERENCE, ORDERS, ["which column of the file?", "one of 'exact', 'cut'"]),
    (
        "no such column",
        COLUMN.replace("COLUMN", "exakt"),
        ORDERS,
        ["column: the file has no such column", "'exact', 'cut'", "did you mean 'exact'?", ":22:1"],
    ),
    ("one column", REFERENCE, "order\n1\n2\n", ["there is one column only"]),
    ("no values", REFERENCE, "order, exact\n1,\n2,\n", ["column exact has no values"]),
    ("a word", REFERENCE, "order, exact\n1, big\n", ["line 2, column exact: not a number: 'big'"]),
    ("NaN", REFERENCE, "order, exact\n1, 2\n# x\n2, NaN\n", ["line 4, column exact: not finite"]),
    (
        "units that differ",
        REFERENCE + 'unit = "m/s^2"\n',
        "order, exact [in/s^2]\n1, 2\n",
        ["column exact is in in/s^2, and unit = 'm/s^2'", "in one of the two places"],
    ),
    ("both ways", REFERENCE + "value = [1]\n", ORDERS, ["value and file exclude each other"]),
]


@pytest.mark.parametrize(
    ("table", "content", "expected"),
    [row[1:] for row in REFERENCES],
    ids=[row[0] for row in REFERENCES],
)
def test_references(tmp_path: Path, table: str, content: str, expected: list[str]) -> None:
    text = reported(tmp_path, content, TABLES + table)
    for words in expected:
        assert words in text


def test_a_column_without_a_file(tmp_path: Path) -> None:
    table = COLUMN.replace('file = "FILE"\n', "")
    assert "column needs file" in refused(tmp_path, TABLES + table)


OUTSIDE = ("/etc/passwd.csv", "../table.csv", "below/../../table.csv", "/proc/self/mem.csv")


@pytest.mark.parametrize("name", OUTSIDE)
def test_files_outside_the_folder_are_not_touched(tmp_path: Path, name: str) -> None:
    (tmp_path / "table.csv").write_text(GOOD)
    folder = tmp_path / "cases"
    folder.mkdir()
    assert "a table has to lie in the folder of its case" in refused(folder, PRESSURE, name)


def test_links(tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text(GOOD)
    folder = tmp_path / "cases"
    folder.mkdir()
    (folder / "link.csv").symlink_to(tmp_path / "table.csv")
    assert "has to lie in the folder" in refused(folder, PRESSURE, "link.csv")
    (folder / "round.csv").symlink_to(folder / "round.csv")
    refused(folder, PRESSURE, "round.csv")
    (folder / "dead.csv").symlink_to(folder / "nothing.csv")
    assert "there is no such file" in refused(folder, PRESSURE, "dead.csv")


def test_what_is_no_file(tmp_path: Path) -> None:
    (tmp_path / "folder.csv").mkdir()
    assert "this is a folder" in refused(tmp_path, PRESSURE, "folder.csv")
    os.mkfifo(tmp_path / "pipe.csv")  # to read it would wait for ever
    assert "this is no ordinary file" in refused(tmp_path, PRESSURE, "pipe.csv")
    assert "no name of a file" in refused(tmp_path, PRESSURE, "a\\u0000b.csv")
    assert "cannot be read: file name too long" in refused(tmp_path, PRESSURE, "a" * 300 + ".csv")
    (tmp_path / "plain").write_text("x")
    assert "cannot be read: not a directory" in refused(tmp_path, PRESSURE, "plain/table.csv")


def test_an_unreadable_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "table.csv").write_text(GOOD)
    whole = Path.open

    def refuse(path: Path, *arguments: object, **others: object) -> object:
        if path.suffix == ".csv":
            raise PermissionError(13, "Permission denied")
        return whole(path, *arguments, **others)  # type: ignore[call-overload]

    monkeypatch.setattr(Path, "open", refuse)
    assert "cannot be read: permission denied" in refused(tmp_path, PRESSURE)


def test_two_bad_files_and_a_slip_come_at_once(tmp_path: Path) -> None:
    case = (PRESSURE + TORQUE).replace("FILE", "none.csv").replace("rod_length", "rod_lenght")
    (tmp_path / "case.toml").write_text(case)
    with pytest.raises(CaseError) as caught:
        load_case(tmp_path / "case.toml")
    assert [problem.path[-1] for problem in caught.value.problems] == [
        "gas_pressure", "torque", "rod_lenght",
    ]  # fmt: skip


def test_only_tables_of_columns_are_read_from_files(tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text("name\nA\n")
    for key in ("rod", "cylinders"):
        case = TABLES.replace("cylinders =", f'{key} = "FILE"\ncylinders_ =')
        (tmp_path / "case.toml").write_text(case.replace("FILE", "table.csv"))
        with pytest.raises(CaseError, match=f"{key} cannot be a text"):
            load_case(tmp_path / "case.toml")


def test_the_file_may_come_from_the_command_line(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text(TABLES)
    key = 'machine.crank_train.gas_pressure="none.csv"'
    with pytest.raises(CaseError) as caught:
        load_case(path, [key])
    assert "--> --set machine.crank_train.gas_pressure" in str(caught.value)
    assert "there is no such file" in str(caught.value)
