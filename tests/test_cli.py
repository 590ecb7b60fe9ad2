"""Claim: the command line does what README and docs say, with the exit codes they give."""

import json
import shutil
from pathlib import Path
from xml.etree import ElementTree

import h5py
import pytest
from drawn import coarse
from fuzzing import command

ROOT = Path(__file__).resolve().parents[1]
CASES = ROOT / "cases"
GENERATOR = str(CASES / "generator.toml")


@pytest.fixture(autouse=True)
def _in_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("once") / "generator.h5"
    assert command("run", GENERATOR, "-q", "-o", str(path)).code == 0
    return path


@pytest.fixture(scope="module")
def repeated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same case run once more."""
    path = tmp_path_factory.mktemp("twice") / "generator.h5"
    assert command("run", GENERATOR, "-q", "-o", str(path)).code == 0
    return path


def changed_case(tmp_path: Path, old: str, new: str, name: str = "changed.toml") -> Path:
    text = Path(GENERATOR).read_text(encoding="utf-8")
    assert old in text
    path = tmp_path / name
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    return path


def test_run_writes_result_and_report_and_says_where() -> None:
    outcome = command("run", GENERATOR)
    assert outcome.code == 0
    assert Path("outputs/generator.h5").is_file()
    report = Path("outputs/generator.txt").read_text(encoding="utf-8")
    assert "202.1 N" in report and "outputs/generator.h5" in outcome.out
    assert "98.00  N" in outcome.out and "8 differ" in outcome.out


@pytest.mark.parametrize(
    ("given", "key"),
    [
        (("check", GENERATOR, "--set", "machine.speed=-3"), "machine.speed"),
        (("run", GENERATOR, "--set", "machine.sped=3"), "machine.sped"),
        (("verify", "none.toml"), ""),
        (("sweep", GENERATOR, "--grid", "nothing=1,2"), "sweep.axes[0].key"),
        (("diff", "a.h5", "b.h5"), ""),
        (("merge", "a.h5", "-o", "b.h5"), ""),
        (("accuracy", "none.toml"), ""),
        (("run", "--bogus"), ""),
    ],
)
def test_an_error_is_an_object_with_its_problems(given: tuple[str, ...], key: str) -> None:
    outcome = command(*given, "--json")
    error = json.loads(outcome.out)["error"]
    assert outcome.code == error["exit_code"] == 2
    assert error["message"] and outcome.err
    assert [problem["key"] for problem in error["problems"]] == [key]
    for problem in error["problems"]:
        assert problem["message"] and bool(problem["place"]) == bool(problem["file"])
        assert (problem["file"] is None) == (given[0] in ("diff", "merge") or "--bogus" in given)


def test_two_cases_of_one_name_are_refused(tmp_path: Path) -> None:
    other = tmp_path / "sub"
    other.mkdir()
    shutil.copy(GENERATOR, other)
    outcome = command("run", GENERATOR, str(other / "generator.toml"))
    assert outcome.code == 2
    assert "two cases are named 'generator'" in outcome.err
    assert not Path("outputs").exists()
    outcome = command("run", GENERATOR, "-q", "-o", "result.json")
    assert outcome.code == 2 and "ends in .h5" in outcome.err


def test_set_changes_a_key() -> None:
    outcome = command("run", GENERATOR, "--json", "--set", 'machine.speed="3000 rpm"')
    assert outcome.code == 0
    faster = json.loads(outcome.out)[0]["quantities"]["isolation/couple_over_lever/blocked_peak"][
        "value"
    ]
    assert faster == pytest.approx(9329.33 * (3000 / 4900) ** 2, rel=1e-5)


def test_check_computes_nothing_and_shows_the_plan() -> None:
    outcome = command("check", GENERATOR)
    assert outcome.code == 0
    assert not list(Path().iterdir())
    for word in ("kinematics", "run_up", "isolation/pitch: inertia", "42 reference numbers"):
        assert word in outcome.out
    plan = json.loads(command("check", GENERATOR, "--json").out)[0]["plan"]
    assert [row["stage"] for row in plan] == ["kinematics", "excitation", "isolation", "run_up"]


def test_verify_exits_1_for_a_missed_reference_and_a_broken_limit(tmp_path: Path) -> None:
    missed = changed_case(tmp_path, '"9329 N"', '"9339 N"')
    outcome = command("verify", str(missed))
    assert outcome.code == 1
    assert "OUTSIDE" in outcome.out
    broken = changed_case(tmp_path, 'max = "100 N"', 'max = "20 N"')
    outcome = command("verify", str(broken), "--json")
    assert outcome.code == 1
    assert [row["kept"] for row in json.loads(outcome.out)[0]["limits"]].count(False) == 1
    assert not Path("outputs").exists()


def test_report_writes_where_it_is_told(result: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    coarse(monkeypatch)
    assert command("report", str(result), "-o", "hand/").out == "hand/generator.txt\n"
    assert (
        Path("hand/generator.txt").read_text(encoding="utf-8") == command("report", str(result)).out
    )
    assert command("report", str(result), "-o", "one.html").code == 0
    assert Path("one.html").read_text(encoding="utf-8").startswith("<!doctype html>")
    for wrong in (["one.pdf"], ["one.txt", "--html"], ["one.txt", str(result)]):
        outcome = command("report", str(result), "-o", *wrong)
        assert outcome.code == 2 and "-o one" in outcome.err and not Path(wrong[0]).exists()


def test_diff_of_two_runs_is_0_and_1_with_one_number_changed(
    result: Path, repeated: Path, tmp_path: Path
) -> None:
    assert command("diff", str(result), str(repeated)).code == 0
    again = Path(shutil.copy(repeated, tmp_path / "again.h5"))
    with h5py.File(again, "r+") as file:
        dataset = file["isolation/couple_over_lever/steady_peak"]
        dataset[()] = dataset[()] * (1 + 1e-5)
    outcome = command("diff", str(result), str(again), "--junit", "junit.xml")
    assert outcome.code == 1
    assert "isolation/couple_over_lever/steady_peak" in outcome.out and "1 differs" in outcome.out
    assert "isolation/couple_over_lever/steady_peak" in Path("junit.xml").read_text(
        encoding="utf-8"
    )
    found = json.loads(command("diff", str(result), str(again), "--json").out)
    assert found["same"] is False
    assert command("diff", str(result), "nowhere.h5").code == 2


def test_diff_of_several_results_takes_the_golden_files_of_their_names(
    result: Path, tmp_path: Path
) -> None:
    golden, new = tmp_path / "golden", tmp_path / "new"
    for folder in (golden, new):
        folder.mkdir()
        for name in ("one.h5", "two.h5"):
            shutil.copyfile(result, folder / name)
    with h5py.File(new / "two.h5", "r+") as file:
        file["isolation/couple_over_lever/steady_peak"][()] *= 1 + 1e-5
    both = [str(new / "one.h5"), str(new / "two.h5")]
    outcome = command("diff", str(golden), *both, "--junit", "junit.xml")
    assert outcome.code == 1
    same, other = outcome.out.split("\n", 1)
    assert outcome.out.endswith("1 of 2 files the same, 1 differs.\n")
    assert same.startswith("one.h5: ") and same.endswith("all the same.")
    assert other.startswith("two.h5: Differences") and "1 differs" in other
    assert Path("junit.xml").read_text(encoding="utf-8").count("<testsuite ") == 2
    found = json.loads(command("diff", str(golden), *both, "--json").out)
    assert {one["result"]: one["same"] for one in found["results"]} == {
        "one.h5": True,
        "two.h5": False,
    }
    single = json.loads(command("diff", both[0], both[0], "--json").out)
    assert single.keys() == found.keys() and single["same"] and not found["same"]
    assert single["results"][0].keys() == found["results"][0].keys()
    assert command("diff", str(golden), *both, "--accept").code == 0
    assert command("diff", str(golden), *both).code == 0
    (golden / "one.h5").unlink()
    assert "one.h5" in command("diff", str(golden), *both).err
    assert command("diff", both[0], *both).code == 2
    assert command("diff", str(golden), both[0], str(tmp_path / "one.h5")).code == 2


def test_each_bad_missing_or_surplus_file_is_one_failed_test_case(
    result: Path, tmp_path: Path
) -> None:
    golden, new = tmp_path / "golden", tmp_path / "new"
    for folder, names in ((golden, "abcd"), (new, "abce")):
        folder.mkdir()
        for name in names:
            shutil.copyfile(result, folder / f"{name}.h5")
    (new / "b.h5").write_bytes(result.read_bytes()[:5000])
    (golden / "c.h5").write_bytes(b"")
    Path("r.toml").write_text('[[rule]]\nquantity = "nothing/*"\nrtol = 1.0\n', encoding="utf-8")
    options = ("--junit", "junit.xml", "--rules", "r.toml")
    outcome = command("diff", str(golden), str(new), *options)
    assert outcome.code == 2 and outcome.err.count("error: ") == 4
    assert "warning: the rule for 'nothing/*' in r.toml fits no quantity" in outcome.err
    assert outcome.out.startswith("a.h5: ") and outcome.out.endswith(
        "1 of 5 files the same, 4 not compared.\n"
    )
    suites = {one.get("name"): one for one in ElementTree.parse("junit.xml").iter("testsuite")}
    assert {name: one.get("failures") for name, one in suites.items()} == {
        "a.h5": "0", "b.h5": "1", "c.h5": "1", "d.h5": "1", "e.h5": "1",
    }  # fmt: skip
    assert [one.get("name") for one in suites["d.h5"].iter("testcase")] == ["file"]
    found = json.loads(command("diff", str(golden), str(new), "--json").out)
    assert [bool(one["problem"]) for one in found["results"]] == [False, True, True, True, True]
    # of some results alone the golden files of others, and their rules, are not missed
    some = command("diff", str(golden), str(new / "a.h5"), "--partial", *options)
    assert (some.code, some.err) == (0, "")
    assert command("diff", str(golden), str(new / "a.h5")).code == 2
    # a rule that cannot be read fails every file, and the JUnit file says so
    Path("r.toml").write_text("[[rule]]\nrtol = 1.0\n", encoding="utf-8")
    assert command("diff", str(golden), str(new), *options).code == 2
    assert ElementTree.parse("junit.xml").getroot().get("failures") == "5"


def test_a_sweep_with_a_failed_point_is_the_same_as_itself(tmp_path: Path) -> None:
    for name, ratio in (("a", 50), ("b", 80)):
        grid = f"machine.crank_train.rod_length={ratio} mm:200 mm:3"
        command("sweep", GENERATOR, "--grid", grid, "-q", "-j", "1", "-o", f"{name}.h5")
    assert command("diff", "a.h5", "a.h5").code == 0
    assert command("diff", "a.h5", "b.h5").code == 1


def test_a_schema_is_written_next_to_cases_and_in_the_place_of_an_earlier_one(
    tmp_path: Path,
) -> None:
    case, schema = tmp_path / "mine.toml", tmp_path / "vibecalc.engine.schema.json"
    outcome = command("new", "engine", "-o", str(case), "--schema")
    assert outcome.out.splitlines() == [f"wrote {case}", f"wrote {schema}"]
    assert case.read_text().startswith("#:schema ./vibecalc.engine.schema.json\n# ")
    assert "`vibecalc schema --kind engine -o ./` writes" in case.read_text()
    assert command("check", str(case)).code == 0
    schema.write_text('"$id": "urn:vibecalc:case:0"')
    assert command("schema", "--kind", "engine", "-o", str(tmp_path)).out == f"wrote {schema}\n"
    assert schema.read_text() == command("schema", "--kind", "engine").out
    every = tmp_path / "new" / "vibecalc.schema.json"
    assert command("schema", "-o", f"{every.parent}/").out == f"wrote {every}\n"
    assert command("schema", "-o", str(every)).code == 2  # a file is not replaced
    every.write_text("mine")
    outcome = command("schema", "-o", str(every.parent))
    assert outcome.code == 2 and "is no schema of vibecalc" in outcome.err
    every.unlink()
    every.mkdir()
    outcome = command("schema", "-o", str(every.parent))
    assert outcome.code == 2 and "vibecalc.schema.json is a folder" in outcome.err
    outcome = command("schema", "--kind", "aeroplane")
    assert outcome.code == 2 and "drive_train" in outcome.err
    outcome = command("new", "engine", "--schema")
    assert outcome.code == 2 and "needs -o" in outcome.err


QUICK_STARTERS = ("rigid_body", "balance", "plate")


@pytest.mark.parametrize(
    "running", [QUICK_STARTERS, pytest.param((), marks=pytest.mark.long)], ids=["quick", "all"]
)
def test_starter_cases_pass_check_and_run(running: tuple[str, ...], tmp_path: Path) -> None:
    listed = command("new", "list").out.split("\n")
    scenes = [line.split()[0] for line in listed if line.strip()]
    assert {"generator", "rigid_body"} <= set(scenes)
    for scene in scenes:
        path = tmp_path / f"{scene}.toml"
        if running and scene not in running:
            continue
        assert command("new", scene, "-o", str(path)).code == 0
        assert command("check", str(path)).code == 0
        outcome = command("run", str(path), "-q", cap=120)
        assert outcome.code == 0, (scene, outcome.err)
    assert command("new", "rigid_body", "-o", str(tmp_path / "rigid_body.toml")).code == 2
    outcome = command("new", "generatr")
    assert outcome.code == 2
    assert "generator" in outcome.err


@pytest.mark.parametrize("verb", ["report", "plot", "diff"])
def test_a_damaged_or_foreign_result_is_said(verb: str, result: Path, tmp_path: Path) -> None:
    short = tmp_path / "short.h5"
    short.write_bytes(result.read_bytes()[:5000])
    foreign = tmp_path / "foreign.h5"
    with h5py.File(foreign, "w") as file:
        file["numbers"] = [1.0, 2.0]
    for path in (short, foreign, Path(GENERATOR), tmp_path / "nowhere.h5", tmp_path):
        extra = [str(result)] if verb == "diff" else []
        outcome = command(verb, *extra, str(path))
        assert outcome.code == 2, (verb, path, outcome.err)
        assert outcome.err.startswith("error: ")


@pytest.mark.parametrize(
    ("asked", "written"),
    [
        (["--only", "run_up"], {"generator_run_up.png"}),
        (
            ["--only", "run_up,piston_motion", "--only", "run_up", "--dpi", "50", "--no-title"],
            {"generator_run_up.png", "generator_piston_motion.png"},
        ),
        (
            ["--only", "piston_motion", "--format", "svg,pdf"],
            {"generator_piston_motion.svg", "generator_piston_motion.pdf"},
        ),
        (["--only", "run_upp"], "did you mean 'run_up'"),
        (["--format", "svg,jpg"], "found 'jpg'"),
        (["--dpi", "20"], "from 50 to 1200"),
        (["--dpi", "many"], "valid integer"),
    ],
)
def test_plot_draws_what_is_asked_for(
    asked: list[str], written: set[str] | str, result: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("matplotlib")
    coarse(monkeypatch)
    outcome = command("plot", str(result), "-o", "pictures", *asked)
    made = {path.name for path in Path("pictures").glob("*")}
    if isinstance(written, str):
        assert outcome.code == 2 and written in outcome.err and made == set()
        return
    assert outcome.code == 0
    assert made == written == {Path(line).name for line in outcome.out.splitlines()}
