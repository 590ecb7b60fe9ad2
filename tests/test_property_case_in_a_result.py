"""Claim: a result runs again without the file that its case read, and with its numbers only."""

from pathlib import Path

import numpy as np
import tomli_w
from response_machines import shipped

from vibecalc.core.case.load import load_case
from vibecalc.core.results.store import read_result, write_result
from vibecalc.core.study.execute import execute

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
