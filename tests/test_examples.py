"""Claim: `new --example` copies a shipped case and the files that it names, and overwrites none."""

from pathlib import Path

import pytest
from fuzzing import command

from vibecalc.cli.starters import carried, examples, files_of_example, starter
from vibecalc.core.case.load import load_case

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_every_shipped_case_is_listed_with_its_title() -> None:
    listed = command("new", "--example").out.splitlines()
    names = [line.split()[0] for line in listed]
    shipped = [*(ROOT / "cases").glob("*.toml"), *(ROOT / "cases" / "gallery").glob("*.toml")]
    assert sorted(names) == sorted(
        path.relative_to(ROOT / "cases").with_suffix("").as_posix() for path in shipped
    )
    assert "generator  " in "\n".join(listed) and "Three-cylinder generator set" in "\n".join(
        listed
    )
    assert max(map(len, listed)) <= 110
    assert carried("cases") == ROOT / "cases"


def test_each_case_reads_in_a_folder_of_its_own(tmp_path: Path) -> None:
    """Of those that name the same files, one."""
    seen: set[frozenset[str]] = set()
    for name in examples():
        files = files_of_example(name)
        others = frozenset(files) - {f"{Path(name).name}.toml"}
        assert len(others) == len(files) - 1
        if not others or others in seen:
            continue
        seen.add(others)
        assert command("new", "--example", name, "-o", f"{len(seen)}").code == 0
        copied = tmp_path / f"{len(seen)}" / f"{name}.toml"
        assert copied.read_bytes() == (ROOT / "cases" / f"{name}.toml").read_bytes()
        assert load_case(copied).text, name
    assert len(seen) > 10


def test_an_output_that_is_a_case_is_the_file_of_the_case() -> None:
    assert command("new", "--example", "roll", "-o", "my/own.toml").code == 0
    names = {path.name for path in Path("my").iterdir()}
    assert names == {"own.toml", *files_of_example("roll")} - {"roll.toml"}
    whole = load_case(ROOT / "cases" / "roll.toml")
    assert load_case(Path("my/own.toml")).sha256 == whole.sha256


def test_nothing_is_overwritten_without_force() -> None:
    Path("roll_motor.csv").write_text("mine", encoding="utf-8")
    outcome = command("new", "--example", "roll")
    assert outcome.code == 2
    assert "roll_motor.csv exists already" in outcome.err and "--force" in outcome.err
    assert [path.name for path in Path().iterdir()] == ["roll_motor.csv"]
    assert Path("roll_motor.csv").read_text(encoding="utf-8") == "mine"
    assert command("new", "--example", "roll", "--force").code == 0
    assert Path("roll_motor.csv").read_bytes() == (ROOT / "cases" / "roll_motor.csv").read_bytes()
    assert command("new", "generator", "-o", "roll.toml").code == 2
    assert command("new", "generator", "-o", "roll.toml", "--force").code == 0
    assert Path("roll.toml").read_text(encoding="utf-8") == starter("generator")


@pytest.mark.parametrize("name", ["genertor", "../cases/generator", "catalogues/couplings", ""])
def test_a_name_that_no_case_has_lists_them(name: str) -> None:
    outcome = command("new", "--example", name)
    assert outcome.code == 2 and not list(Path().iterdir())
    assert "no example" in outcome.err and "Three-cylinder generator set on four" in outcome.err
    if name == "genertor":
        assert outcome.err.endswith("did you mean 'generator'?\n")


def test_it_goes_with_no_assembly() -> None:
    outcome = command("new", "--example", "--from", "line.json")
    assert outcome.code == 2 and "leave --example out" in outcome.err
