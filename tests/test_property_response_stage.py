"""Claim: a compressor that is described in another way has the same results.

Other units, other names and another sequence of the cylinders, another reference point with the
matrices moved along, another crank angle zero, all masses and forces scaled, tables in a file or in
the case: results change as they have to and not otherwise.
"""

from pathlib import Path

import numpy as np
import tomli_w
from random_machines import Table
from response_machines import shipped

from vibecalc.core.case.load import load_case
from vibecalc.core.results.store import read_result, write_result
from vibecalc.core.study.execute import execute

CASES = Path(__file__).resolve().parents[1] / "cases"


def folder_with(table: Table, tmp_path: Path, *files: str) -> Path:
    tmp_path.mkdir(exist_ok=True)
    case = tmp_path / "case.toml"
    case.write_text(tomli_w.dumps(table), encoding="utf-8")
    for name in files:
        (tmp_path / name).write_bytes((CASES / name).read_bytes())
    return case


MOTOR = "compressor_motor_torque.csv"


def with_motor() -> Table:
    """The motor's case, its torque in a file next to it."""
    table = shipped("compressor_motor")
    del table["response"]
    return table


def test_another_number_in_the_file_is_another_case(tmp_path: Path) -> None:
    table = with_motor()
    table["machine"]["motor"]["torque"] = MOTOR
    case = folder_with(table, tmp_path, MOTOR)
    first = load_case(case).sha256
    csv = tmp_path / MOTOR
    text = csv.read_text(encoding="utf-8")
    csv.write_text("# a comment\n" + text, encoding="utf-8")
    assert load_case(case).sha256 == first
    head, last = text.rstrip("\n").rsplit("\n", 1)
    cells = last.split(",")
    cells[-1] = repr(float(cells[-1]) * 1.5 + 1.0)
    csv.write_text(f"{head}\n{','.join(cells)}\n", encoding="utf-8")
    assert load_case(case).sha256 != first


def test_a_result_runs_again_without_the_file(tmp_path: Path) -> None:
    table = with_motor()
    table["machine"]["motor"]["torque"] = MOTOR
    loaded = load_case(folder_with(table, tmp_path / "with", MOTOR))
    stored = tmp_path / "result.h5"
    write_result(execute(loaded), stored)
    result = read_result(stored)
    alone = tmp_path / "alone.toml"
    alone.write_text(result.case_toml_resolved, encoding="utf-8")
    again = load_case(alone)
    assert again.sha256 == result.case_sha256
    for path, quantity in execute(again).record.items():
        assert np.array_equal(quantity.values, result.record[path].values), path
