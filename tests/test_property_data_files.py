"""Claim: a table in a CSV file is the same table as one written into the case, however it looks.

Order of columns, comments, blank lines, quotes, line ends and units do not matter; a file of any
other content is reported in words and never ends in a traceback.
"""

import csv
import io
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
from hypothesis import given, settings
from hypothesis import strategies as st
from response_machines import shipped
from small_case import SMALL

from vibecalc.core.case.csv_files import columns_of
from vibecalc.core.case.data_files import attach_files
from vibecalc.core.case.load import load_case
from vibecalc.core.results.plain import comma_separated
from vibecalc.core.results.record import Axis, Quantity
from vibecalc.core.results.store import read_result, write_result
from vibecalc.core.results.visible import text_cell
from vibecalc.core.study.execute import execute
from vibecalc.errors import Problem
from vibecalc.units import parse_quantity

#: up to the table of its crank train, whose last keys may follow
TABLES = SMALL.partition("[excitation]")[0].replace('"machine"', '"compressor"')
PRESSURE = ["Pa", "bar", "psi", "kN/m^2"]
numbers = st.floats(-1e9, 1e9, allow_subnormal=False).filter(lambda x: x == 0 or abs(x) > 1e-9)


def attached(content: bytes, data: dict[str, Any]) -> list[Problem]:
    """Problems of the files named table.csv in a case, which is changed."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "table.csv").write_bytes(content)
        return attach_files(data, Path(folder))


def of_pressure(content: bytes) -> tuple[Any, list[Problem]]:
    data = {"machine": {"crank_train": {"gas_pressure": "table.csv"}}}
    problems = attached(content, data)
    return data["machine"]["crank_train"]["gas_pressure"], problems


def same_case(folder: Path, inline: str, file: str, content: str) -> None:
    (folder / "table.csv").write_text(content)
    (folder / "a.toml").write_text(TABLES + inline)
    (folder / "b.toml").write_text(TABLES + file)
    first, second = load_case(folder / "a.toml"), load_case(folder / "b.toml")
    assert first.resolved == second.resolved
    assert first.sha256 == second.sha256


def test_a_file_gives_the_case_and_the_hash_of_the_same_table_written_out(tmp_path: Path) -> None:
    same_case(
        tmp_path,
        'gas_pressure = { crank_angle = ["0 deg", "90 deg", "360 deg"], pressure = '
        '["2 bar", "0.5 bar", "2 bar"] }\n',
        'gas_pressure = "table.csv"\n',
        "# from a gauge\nCrank angle [deg], Pressure [bar]\n0, 2\n90, 0.5\n360, 2\n",
    )
    table = '[[reference_table]]\nquantity = "kinematics/acceleration_harmonics"\naxis = "order"\n'
    same_case(
        tmp_path,
        table + 'source = "x"\nentry = [1, 4]\nvalue = ["1.50", "2e-3"]\nunit = "in/s^2"\n',
        table + 'source = "x"\nfile = "table.csv"\ncolumn = "b"\n',
        "order, a, b [in/s^2]\n1, 7, 1.50\n2, 8,\n4, 9, 2e-3\n",
    )


@given(
    rows=st.lists(st.tuples(numbers, numbers), min_size=3, max_size=30),
    units=st.tuples(st.sampled_from(["rad", "deg"]), st.sampled_from(PRESSURE)),
    swapped=st.booleans(),
    quoted=st.booleans(),
    end=st.sampled_from(["\n", "\r\n"]),
    mark=st.sampled_from(["", "\ufeff"]),
    noise=st.lists(st.sampled_from(["", "  ", "# note, with, commas", '# "open']), max_size=4),
    places=st.lists(st.integers(0, 30), min_size=4, max_size=4),
)
@settings(max_examples=60, deadline=None, derandomize=True)
def test_looks_do_not_matter(
    rows: list[tuple[float, float]],
    units: tuple[str, str],
    swapped: bool,
    quoted: bool,
    end: str,
    mark: str,
    noise: list[str],
    places: list[int],
) -> None:
    cell = '"{}"'.format if quoted else " {} ".format
    table = [(f"crank_angle [{units[0]}]", f"pressure [{units[1]}]"), *rows]
    lines = [",".join(map(cell, map(str, row[::-1] if swapped else row))) for row in table]
    for text, place in zip(noise, places, strict=False):
        lines.insert(min(place, len(lines)), text)
    found, problems = of_pressure((mark + end.join(lines) + end).encode())
    assert problems == []
    for key, unit, si, values in (
        ("crank_angle", units[0], "rad", [row[0] for row in rows]),
        ("pressure", units[1], "Pa", [row[1] for row in rows]),
    ):
        read = [parse_quantity(text, si) for text in found[key]]
        assert read == [parse_quantity(f"{value} {unit}", si) for value in values]


labels = st.text("ABab+ 01.-", min_size=1, max_size=6).map(str.strip).filter(bool)


@given(rows=st.lists(st.tuples(labels, st.booleans(), numbers), min_size=1, max_size=12))
@settings(max_examples=60, deadline=None, derandomize=True)
def test_rows_of_references_keep_their_digits_and_blank_ones_go(
    rows: list[tuple[str, bool, float]],
) -> None:
    lines = [f'"{label}", {repr(value) if there else ""}' for label, there, value in rows]
    row: dict[str, Any] = {"file": "table.csv"}
    content = "\n".join(["operation, energy [J]", *lines]).encode()
    problems = attached(content, {"reference_table": [row]})
    kept = [(label, repr(value)) for label, there, value in rows if there]
    if not kept:
        assert len(problems) == 1 and "no values" in problems[0].message
        return
    assert problems == []
    assert row["value"] == [value for _, value in kept]
    assert row["unit"] == "J" and not row.keys() & {"file", "column"}
    for (label, _), entry in zip(kept, row["entry"], strict=True):
        assert entry == label or float(label) == entry


@pytest.mark.long
@given(
    st.one_of(
        st.binary(max_size=60),
        st.text('crank_angle,pressure[]deg"\n\r\t;# 0123.e-nanif\x00', max_size=80).map(str.encode),
        st.text("aB1,[] é\xa0\u2028\ufeff\U0001f600\x7f", max_size=60).map(str.encode),
    )
)
@settings(max_examples=100, deadline=None, derandomize=True)
def test_any_bytes_are_a_table_or_one_problem(content: bytes) -> None:
    found, problems = of_pressure(content)
    if problems:
        assert len(problems) == 1
        assert problems[0].path == ("machine", "crank_train", "gas_pressure")
        assert found == "table.csv"
    else:
        sizes = {len(column) for column in found.values()}
        assert len(sizes) == 1 and min(sizes) > 0
    row = {"file": "table.csv", "column": "pressure"}
    problems = attached(content, {"reference_table": [row]})
    assert bool(problems) is ("file" in row)


@given(name=st.text("aB1 =+-@'\"#,;.é\U0001f600"))
def test_a_text_that_could_be_a_formula_is_read_back(name: str) -> None:
    """`export` marks it, so that nobody computes it; our reader takes the mark off."""
    for text in (name.strip(), f"={name.strip()}", f"'@{name.strip()}", "-0.5", "+1e3", "'-"):
        cell = text_cell(text)
        assert cell in ("-0.5", "+1e3") or not cell.startswith(("=", "+", "-", "@"))
        stream = io.StringIO()
        csv.writer(stream).writerows([["name", "value"], [cell, "1"]])
        if text.strip(" '\"") and not text.startswith("#"):
            assert columns_of(stream.getvalue())["name"].cells == [text]


def test_numbers_below_zero_are_marked_nowhere() -> None:
    axis = Axis(name="point", values=np.array(["=1+1", "a"]), unit="", long_name="")
    quantity = Quantity(
        path="a/b", values=np.array([-1.5, 2.0]), unit="m", long_name="", axes=(axis,),
        error_estimate=0.0,
    )  # fmt: skip
    assert comma_separated(quantity) == "point,b [m]\n'=1+1,-1.5\na,2.0\n"


# ----------------------------------------------------------------------------
# A result runs again without the file that its case read.
# ----------------------------------------------------------------------------

MOTOR = Path(__file__).resolve().parents[1] / "cases" / "compressor_motor_torque.csv"


def test_a_result_runs_again_without_the_file(tmp_path: Path) -> None:
    table = shipped("compressor_motor")
    del table["response"]
    table["machine"]["motor"]["torque"] = MOTOR.name
    case, csv, stored = (tmp_path / name for name in ("case.toml", MOTOR.name, "result.h5"))
    case.write_text(tomli_w.dumps(table), encoding="utf-8")
    text = MOTOR.read_text(encoding="utf-8")
    csv.write_text(text, encoding="utf-8")
    write_result(execute(load_case(case)), stored)
    head, last = text.rstrip("\n").rsplit("\n", 1)
    csv.write_text(f"{head}\n{last}1\n", encoding="utf-8")
    result = read_result(stored)
    assert load_case(case).sha256 != result.case_sha256
    csv.unlink()
    case.write_text(result.case_toml_resolved, encoding="utf-8")
    again = load_case(case)
    assert again.sha256 == result.case_sha256
    for path, quantity in execute(again).record.items():
        assert np.array_equal(quantity.values, result.record[path].values), path
