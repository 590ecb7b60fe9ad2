"""Claim: `run --if-needed` skips what a run would make as it is, and nothing else."""

import hashlib
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import h5py
import pytest
from fuzzing import command
from shipped_cases import CASES
from small_case import SMALL

import vibecalc
from vibecalc.core.case import inputs
from vibecalc.core.case.load import load_case
from vibecalc.core.results.store import file_image
from vibecalc.measurement import records

CASE = f"""{SMALL}
[[reference_table]]
quantity = "excitation/force"
axis = "order"
where = {{ direction = "z" }}
file = "forces.csv"
rtol = 0.9
source = "a guess"
"""
FORCES = "order,force [N]\n1,2220\n2,620\n"
RESULT, REPORT = Path("outputs/one.h5"), Path("outputs/one.txt")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("made")
    (folder / "one.toml").write_text(CASE, encoding="utf-8")
    (folder / "forces.csv").write_text(FORCES, encoding="utf-8")
    done = command("run", f"{folder}/one.toml", "--if-needed", "-o", f"{folder}/outputs/")
    assert done.code == 0 and "up to date" not in done.out, done.err
    return folder


@pytest.fixture(autouse=True)
def _with_a_result(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(made, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)


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


def _has_the_report_of_another_case() -> None:
    Path("two.toml").write_text(CASE.replace("0.5 kg", "0.6 kg"), encoding="utf-8")
    assert command("run", "two.toml", "-q", "-o", str(RESULT.with_suffix(".hdf5"))).code == 0


def _was_edited() -> None:
    with h5py.File(RESULT, "r+") as file:
        file["excitation/force"][...] = 0.0


def _is_cut_short() -> None:
    os.truncate(RESULT, RESULT.stat().st_size - 1)


def _is_of_another_case() -> None:
    Path("two.toml").write_text(CASE, encoding="utf-8")
    assert command("run", "two.toml", "-q", "-o", str(RESULT)).code == 0


def _case() -> None:
    Path("one.toml").write_text(CASE.replace("0.5 kg", "0.6 kg"), encoding="utf-8")


def _file() -> None:
    Path("forces.csv").write_text(FORCES.replace("2220", "2221"), encoding="utf-8")


@pytest.mark.parametrize(
    "change",
    [_lacks_its_report, _has_the_report_of_another_case, _was_edited, _is_cut_short,
     _is_of_another_case, _case, _file],
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
    for name in ("vibecalc", "scipy"):
        other = inputs.versions() | {name: "99.9"}
        with monkeypatch.context() as patched:
            patched.setattr(inputs, "versions", lambda other=other: other)
            assert "up to date" not in again()
            assert again() == f"{RESULT} is up to date\n"


def test_a_sweep_that_is_up_to_date_is_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    grid = ("sweep", "one.toml", "--grid", "machine.speed=1000 rpm:3000 rpm:3", "-j", "1")
    once = command(*grid, "--if-needed")
    assert once.code == 0 and "up to date" not in once.out
    place = Path("outputs/one.sweep.h5")
    before = place.read_bytes()
    assert command(*grid, "--if-needed").out == f"{place} is up to date\n"
    assert json.loads(command(*grid, "--if-needed", "--json").out)["written"] == []
    assert place.read_bytes() == before and command("diff", str(place), str(place)).code == 0
    with monkeypatch.context() as patched:  # other libraries: computed again, not taken up
        other = inputs.versions() | {"scipy": "99.9"}
        patched.setattr(inputs, "versions", lambda: other)
        assert "up to date" not in command(*grid, "--if-needed", "--resume").out
        assert command(*grid, "--if-needed", "--resume").out == f"{place} is up to date\n"
    other_points = (*grid[:3], "machine.speed=1000 rpm:3000 rpm:5", "-j", "1", "--if-needed")
    assert "up to date" not in command(*other_points).out
    Path("forces.csv").write_text(FORCES.replace("2220", "2221"), encoding="utf-8")
    assert "up to date" not in command(*other_points).out
    assert "up to date" in command(*other_points).out
    assert command(*grid, "--if-needed", "--shard", "1/2").code == 2
    # what failed is said again
    failing = ("sweep", "one.toml", "--grid", "machine.crank_train.rod_length=30 mm:200 mm:3")
    first = command(*failing, "--if-needed", "-o", "f.h5", "-j", "1")
    again = command(*failing, "--if-needed", "-o", "f.h5", "-j", "1")
    assert first.code == again.code == 4 and again.out == "f.h5 is up to date\n"


@pytest.mark.parametrize("name", ["plain", "with a blank", "a#b", "a$b", "$(x)"])
def test_make_knows_the_files_of_a_case(name: str) -> None:
    folder = Path(name)
    folder.mkdir()
    table = f"{name} torque.csv"
    (folder / table).write_text(FORCES, encoding="utf-8")
    case = folder / f"{name}.toml"
    case.write_text(CASE.replace("forces.csv", table), encoding="utf-8")
    told = command("check", str(case), "--depfile", f"{name}.h5.d", "-q")
    assert told.code == 0 and told.out == "", told.err
    target = name.replace("$", "$$").replace("#", "\\#").replace(" ", "\\ ")
    shell = name.replace("$", "$$")
    rule = f"{target}.h5:\n\t@echo made; touch '{shell}.h5'\n-include {target}.h5.d\n"
    Path("Makefile").write_text(rule, encoding="utf-8")

    def made() -> bool:
        words = ["make", f"{name}.h5"]
        ran = subprocess.run(words, capture_output=True, text=True, check=False)
        assert ran.returncode == 0, ran.stderr
        return "made" in ran.stdout

    assert made() and not made()
    for file in (folder / table, case):
        later = Path(f"{name}.h5").stat().st_mtime + 5.0
        os.utime(file, (later, later))
        assert made()
        os.utime(file, (0.0, 0.0))
    assert not made()
    (folder / table).unlink()  # a file that is renamed is not asked for
    assert made()


def test_a_dep_file_is_of_one_case_that_is_a_file() -> None:
    for words in (("one.toml", "one.toml", "--depfile", "a.d"), ("one.toml", "--depfile", "a.mk")):
        refused = command("check", *words)
        assert refused.code == 2 and "--depfile needs one case" in refused.err
    Path("a%b.toml").write_text(CASE, encoding="utf-8")
    refused = command("check", "a%b.toml", "--depfile", "a.h5.d")
    assert refused.code == 2 and "make cannot take" in refused.err and not Path("a.h5.d").exists()


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
    with h5py.File(RESULT) as file:
        assert "force" in file["excitation"]
    assert command("diff", str(RESULT), str(RESULT)).code == 0


def test_records_over_time_count(tmp_path: Path) -> None:
    (tmp_path / "run.wav").write_bytes(b"RIFF")
    with inputs.files_seen() as seen:
        records._content(tmp_path, "run.wav")
    assert seen == {"run.wav": hashlib.sha256(b"RIFF").hexdigest()}
    assert '"roll_records.csv"' in load_case(CASES["roll_records"]).inputs


def test_a_report_printed_into_its_place_is_as_good() -> None:
    REPORT.write_bytes(b"")
    REPORT.write_text(command("report", str(RESULT)).out, encoding="utf-8")
    assert again() == f"{RESULT} is up to date\n"
