"""Claim: a CSV file that cannot stand for a table is refused in one message at its key.

The message names the file, and the line and column of it where there is one.
"""

import os
from pathlib import Path

import pytest
from refused import hold

from vibecalc.core.case.csv_files import LARGEST_FILE, MOST_ROWS
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
    assert f"error: {key}: the file does not exist" in text
    assert f"case.toml:{place}\n" in text
    assert "found 'table.csv'; allowed: the name of a CSV file next to the case" in text
    (tmp_path / "tables.csv").write_text(GOOD)
    assert "help: did you mean 'tables.csv'?" in refused(tmp_path, case)


COLUMN = REFERENCE + 'column = "COLUMN"\n'
#: name -> case, content of its table
REFUSED: dict[str, tuple[str, str | bytes]] = {
    "empty": (PRESSURE, ""),
    "comments only": (PRESSURE, "# angle\n\n# pressure\n"),
    "header only": (PRESSURE, "crank_angle [deg], pressure [bar]\n"),
    "UTF-16": (PRESSURE, GOOD.encode("utf-16")),
    "null character": (PRESSURE, GOOD.replace("270", "\0")),
    "not UTF-8": (PRESSURE, b"crank_angle, pressure\n\xff\xfe, 1\n"),
    "short row": (PRESSURE, GOOD + "# more\n\n370\n"),
    "long row": (PRESSURE, GOOD.replace("90, 0", "90, 0, 5")),
    "semicolons in the rows": (PRESSURE, "crank_angle, pressure\n0; 1\n"),
    "doubled column": (PRESSURE, "pressure [bar], pressure [Pa]\n1, 2\n"),
    "nameless column": (PRESSURE, GOOD.replace("\n", ",\n").replace("90, 0,", "90, 0, 5")),
    "open bracket": (PRESSURE, GOOD.replace("bar]", "bar")),
    "two brackets": (PRESSURE, GOOD.replace("bar]", "bar] [x]")),
    "unknown column": (PRESSURE, GOOD.replace("pressure", "presure")),
    "missing column": (PRESSURE, "crank_angle [deg]\n0\n90\n360\n"),
    "word": (PRESSURE, GOOD.replace("270, 0", "270, none")),
    "NaN": (PRESSURE, GOOD.replace("270, 0", "270, nan")),
    "infinite": (PRESSURE, GOOD.replace("270, 0", "270, -inf")),
    "too large": (PRESSURE, GOOD.replace("270, 0", "270, 1e999")),
    "blank cell": (PRESSURE, GOOD.replace("270, 0", "270,")),
    "decimal comma": (PRESSURE, GOOD.replace("270, 0", '270, "0,5"')),
    "thousands": (PRESSURE, "crank_angle; pressure\n0; 0,5\n90; 1.234,5\n"),
    "a point among decimal commas": (PRESSURE, "crank_angle; pressure\n0; 0,5\n90; 1.5\n"),
    "unit twice": (PRESSURE, GOOD.replace("270, 0", "270, 0 bar")),
    "wrong unit": (PRESSURE, GOOD.replace("bar", "mm")),
    "unknown unit": (PRESSURE, GOOD.replace("bar", "baar")),
    "unit too large": (PRESSURE, GOOD.replace("bar", "Ym^99")),
    "many rows": (PRESSURE, "a\n" + "1\n" * (MOST_ROWS + 1)),
    "many columns": (PRESSURE, ",".join(map(str, range(500))) + "\n1\n"),
    "huge": (PRESSURE, b"#" * (LARGEST_FILE + 1)),
    "a cell without end": (PRESSURE, 'a, b\n1, "' + "x" * 200_000 + "\n"),
    "torque: a unit of orders": (TABLES + TORQUE, "order [deg], cosine, sine\n1, 2, 3\n"),
    "torque: half an order": (TABLES + TORQUE, "order, cosine, sine\n1.5, 2, 3\n"),
    "torque: an order below zero": (TABLES + TORQUE, "order, cosine, sine\n-1, 2, 3\n"),
    "torque: wrong dimension of a column": (
        TABLES + TORQUE,
        "order, cosine [N*m], sine [N]\n1, 2, 3\n",
    ),
    "torque: wrong dimension of a cell": (TABLES + TORQUE, "order, cosine, sine\n1, 2, 3 N\n"),
    "torque: a column too many": (TABLES + TORQUE, "order, cosine, sine, phase\n1, 2, 3, 4\n"),
    "reference: which column": (TABLES + REFERENCE, ORDERS),
    "reference: no such column": (TABLES + COLUMN.replace("COLUMN", "exakt"), ORDERS),
    "reference: one column": (TABLES + REFERENCE, "order\n1\n2\n"),
    "reference: no values": (TABLES + REFERENCE, "order, exact\n1,\n2,\n"),
    "reference: a word": (TABLES + REFERENCE, "order, exact\n1, big\n"),
    "reference: NaN": (TABLES + REFERENCE, "order, exact\n1, 2\n# x\n2, NaN\n"),
    "reference: units that differ": (
        TABLES + REFERENCE + 'unit = "m/s^2"\n',
        "order, exact [in/s^2]\n1, 2\n",
    ),
    "reference: both ways": (TABLES + REFERENCE + "value = [1]\n", ORDERS),
}


def _written(folder: Path, case: str, content: str | bytes) -> str:
    (folder / "table.csv").write_bytes(content if isinstance(content, bytes) else content.encode())
    return refused(folder, case)


MESSAGES = {name: lambda folder, row=row: _written(folder, *row) for name, row in REFUSED.items()}


@pytest.mark.parametrize("name", MESSAGES)
def test_words_and_place(name: str, tmp_path: Path) -> None:
    hold("bad_cases_files", name, MESSAGES[name], tmp_path)


def test_a_column_without_a_file(tmp_path: Path) -> None:
    table = COLUMN.replace('file = "FILE"\n', "")
    assert "column needs file" in refused(tmp_path, TABLES + table)


OUTSIDE = ("/etc/passwd.csv", "../table.csv", "below/../../table.csv", "/proc/self/mem.csv")


@pytest.mark.parametrize("name", OUTSIDE)
def test_files_outside_the_folder_are_not_touched(tmp_path: Path, name: str) -> None:
    (tmp_path / "table.csv").write_text(GOOD)
    folder = tmp_path / "cases"
    folder.mkdir()
    assert "the file has to be in the folder of its case" in refused(folder, PRESSURE, name)


def test_links(tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text(GOOD)
    folder = tmp_path / "cases"
    folder.mkdir()
    (folder / "link.csv").symlink_to(tmp_path / "table.csv")
    assert "has to be in the folder" in refused(folder, PRESSURE, "link.csv")
    (folder / "round.csv").symlink_to(folder / "round.csv")
    refused(folder, PRESSURE, "round.csv")
    (folder / "dead.csv").symlink_to(folder / "nothing.csv")
    assert "the file does not exist" in refused(folder, PRESSURE, "dead.csv")


def test_what_is_no_file(tmp_path: Path) -> None:
    (tmp_path / "folder.csv").mkdir()
    assert "the file is a folder" in refused(tmp_path, PRESSURE, "folder.csv")
    os.mkfifo(tmp_path / "pipe.csv")  # to read it would wait for ever
    assert "the file is no ordinary file" in refused(tmp_path, PRESSURE, "pipe.csv")
    assert "the file has a null character in its name" in refused(
        tmp_path, PRESSURE, "a\\u0000b.csv"
    )
    assert "cannot be read: file name too long" in refused(tmp_path, PRESSURE, "a" * 300 + ".csv")
    (tmp_path / "plain").write_text("x")
    assert "cannot be read: not a directory" in refused(tmp_path, PRESSURE, "plain/table.csv")


def test_two_bad_files_and_a_slip_come_at_once(tmp_path: Path) -> None:
    case = (PRESSURE + TORQUE).replace("FILE", "none.csv").replace("rod_length", "rod_lenght")
    (tmp_path / "case.toml").write_text(case)
    with pytest.raises(CaseError) as caught:
        load_case(tmp_path / "case.toml")
    assert {one.path[-1] for one in caught.value.problems} == {
        "gas_pressure",
        "torque",
        "rod_lenght",
    }


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
    assert "the file does not exist" in str(caught.value)
