"""Claim: `run --if-needed` skips what a run would make as it is, and nothing else."""

import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import h5py
import pytest
import xarray
from fuzzing import command
from shipped_cases import CASES

import vibecalc
from vibecalc.core.case import inputs
from vibecalc.core.case.load import load_case
from vibecalc.core.results.store import file_image
from vibecalc.measurement import records

CASE = """\
schema = 1
title = "one cylinder"

[machine]
kind = "generator"
speed = "3000 rpm"

[machine.crank_train]
crank_radius = "45 mm"
rod_length = "160 mm"
reciprocating_mass = "0.5 kg"
cylinders = [{ name = "1" }]

[excitation]

[[reference_table]]
quantity = "excitation/force"
axis = "order"
where = { direction = "z" }
file = "forces.csv"
rtol = 0.9
source = "a guess"
"""
FORCES = "order,force [N]\n1,2220\n2,620\n"
RESULT, REPORT = Path("outputs/one.h5"), Path("outputs/one.txt")


@pytest.fixture(autouse=True)
def _with_a_result(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("one.toml").write_text(CASE, encoding="utf-8")
    Path("forces.csv").write_text(FORCES, encoding="utf-8")
    done = command("run", "one.toml", "--if-needed")
    assert done.code == 0 and "up to date" not in done.out, done.err


def again(*options: str) -> str:
    done = command("run", "one.toml", "--if-needed", *options)
    assert done.code == 0, done.err
    return done.out


def test_nothing_has_changed() -> None:
    before = RESULT.stat().st_mtime_ns, REPORT.read_bytes()
    assert again() == f"{RESULT} is up to date\n"
    assert again("-q") == ""
    assert (RESULT.stat().st_mtime_ns, REPORT.read_bytes()) == before
    Path("one.toml").write_bytes(b"\xef\xbb\xbf" + CASE.encode())  # the same text, marked as UTF-8
    assert again() == f"{RESULT} is up to date\n"
    assert "up to date" not in command("run", "one.toml").out  # who does not ask, runs


def _lacks_its_report() -> None:
    REPORT.unlink()


def _has_an_empty_report() -> None:
    REPORT.write_bytes(b"")


def _has_the_report_of_another_case() -> None:
    Path("two.toml").write_text(CASE.replace("0.5 kg", "0.6 kg"), encoding="utf-8")
    assert command("run", "two.toml", "-q", "-o", str(RESULT.with_suffix(".hdf5"))).code == 0


def _was_edited() -> None:
    with h5py.File(RESULT, "r+") as file:
        file["excitation/force"][...] = 0.0


def _was_written_by_others() -> None:
    vibecalc.write(vibecalc.read(RESULT), RESULT)


def _is_cut_short() -> None:
    os.truncate(RESULT, RESULT.stat().st_size - 1)


def _is_empty() -> None:
    RESULT.write_bytes(b"")


def _is_something_else() -> None:
    RESULT.write_text("not a result", encoding="utf-8")


def _is_of_another_case() -> None:
    Path("two.toml").write_text(CASE, encoding="utf-8")
    assert command("run", "two.toml", "-q", "-o", str(RESULT)).code == 0


def _case() -> None:
    Path("one.toml").write_text(CASE.replace("0.5 kg", "0.6 kg"), encoding="utf-8")


def _file() -> None:
    Path("forces.csv").write_text(FORCES.replace("2220", "2221"), encoding="utf-8")


@pytest.mark.parametrize(
    "change",
    [_lacks_its_report, _has_an_empty_report, _has_the_report_of_another_case, _was_edited,
     _was_written_by_others, _is_cut_short, _is_empty, _is_something_else, _is_of_another_case,
     _case, _file],
)  # fmt: skip
def test_runs_again_where_something_has_changed(change: Callable[[], None]) -> None:
    change()
    assert "up to date" not in again()
    assert again() == f"{RESULT} is up to date\n"


def test_settings_count_and_so_does_the_version(monkeypatch: pytest.MonkeyPatch) -> None:
    setting = ("--set", "machine.speed=2000 rpm")
    assert "up to date" not in again(*setting)
    assert again(*setting) == f"{RESULT} is up to date\n"
    assert "up to date" not in again()
    assert "up to date" not in again("--unset", "reference_table")
    assert "up to date" not in again()
    monkeypatch.setattr(inputs, "__version__", "9.9.9")
    assert "up to date" not in again()
    assert again() == f"{RESULT} is up to date\n"


def test_a_file_that_is_gone_is_missed() -> None:
    Path("forces.csv").unlink()
    refused = command("run", "one.toml", "--if-needed")
    assert refused.code == 2 and "forces.csv" in refused.err


def test_of_several_cases_those_run_that_have_to() -> None:
    Path("two.toml").write_text(CASE, encoding="utf-8")
    done = command("run", "one.toml", "two.toml", "--if-needed", "-q", "--json")
    assert [one["case"] for one in json.loads(done.out)] == ["one", "two"]
    printed = command("run", "one.toml", "two.toml", "--if-needed").out
    assert printed == f"{RESULT} is up to date\noutputs/two.h5 is up to date\n"
    once = json.loads(command("run", "one.toml", "--json", "--full").out)
    kept = json.loads(command("run", "one.toml", "--json", "--full", "--if-needed").out)
    assert kept[0].pop("timings") and once[0].pop("timings")
    assert kept[0].pop("written") == [] and len(once[0].pop("written")) == 2
    assert kept == once


def test_what_has_failed_is_tried_again(monkeypatch: pytest.MonkeyPatch) -> None:
    from vibecalc.core.run import run

    computed = run.run_case

    def failing(*given: object, **options: object) -> object:
        record = computed(*given, **options)  # type: ignore[arg-type]
        record.failure = "no such mass exists"
        return record

    with monkeypatch.context() as patched:
        patched.setattr(run, "run_case", failing)
        Path("one.toml").write_text(CASE + "\n", encoding="utf-8")
        assert command("run", "one.toml", "-q").code == 3
    assert "up to date" not in again()


def test_to_ask_needs_no_library() -> None:
    probe = (
        "import sys; sys.argv[1:] = ['run', 'one.toml', '--if-needed']\n"
        "from vibecalc.__main__ import main\n"
        "try:\n    main()\n"
        "finally:\n    print(sorted(sys.modules))"
    )
    ran = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
    assert "up to date" in ran.stdout
    for heavy in ("numpy", "h5py", "tomllib", "vibecalc.schema", "vibecalc.subjects"):
        assert f"'{heavy}'" not in ran.stdout


def test_readers_of_hdf5_do_not_see_the_lines() -> None:
    assert RESULT.read_bytes().startswith(file_image(vibecalc.read(RESULT)))
    with xarray.open_dataset(RESULT, group="excitation") as stage:
        assert "force" in stage
    assert command("diff", str(RESULT), str(RESULT)).code == 0


def test_records_over_time_count(tmp_path: Path) -> None:
    (tmp_path / "run.wav").write_bytes(b"RIFF")
    with inputs.files_seen() as seen:
        records._path(tmp_path, "run.wav")
    assert seen == {"run.wav": hashlib.sha256(b"RIFF").hexdigest()}
    assert '"roll_records.csv"' in load_case(CASES["roll_records"]).inputs


def test_a_report_printed_into_its_place_is_as_good() -> None:
    REPORT.write_bytes(b"")
    REPORT.write_text(command("report", str(RESULT)).out, encoding="utf-8")
    assert again() == f"{RESULT} is up to date\n"
