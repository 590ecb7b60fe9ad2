"""Claim: each command imports what it needs and nothing heavier."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

CASES = Path(__file__).resolve().parents[1] / "cases"

PROBE = """
import json, sys
sys.argv = ["vibecalc", *sys.argv[1:]]
from vibecalc.__main__ import main
try:
    main()
except SystemExit as stop:
    code = stop.code
print("\\n@@" + json.dumps([code, sorted(sys.modules)]))
"""


def modules_after(*arguments: str, cwd: Path) -> set[str]:
    run = subprocess.run(
        [sys.executable, "-c", PROBE, *arguments], capture_output=True, text=True, cwd=cwd
    )
    assert "@@" in run.stdout, run.stderr
    code, modules = json.loads(run.stdout.rsplit("@@", 1)[1])
    assert not code, run.stderr
    return set(modules)


def roots(modules: set[str]) -> set[str]:
    return {name.split(".")[0] for name in modules}


@pytest.mark.parametrize("command", [["--help"], ["run", "--help"], ["diff", "--help"]])
def test_help_needs_no_numbers_and_no_models(command: list[str], tmp_path: Path) -> None:
    modules = modules_after(*command, cwd=tmp_path)
    assert not roots(modules) & {"numpy", "scipy", "h5py", "pint", "matplotlib"}
    assert not {name for name in modules if name.startswith("vibecalc.case")}


def test_the_first_help_loads_no_pydantic(tmp_path: Path) -> None:
    # typer itself loads it as soon as it parses the parameter of a command
    assert "pydantic.main" not in modules_after("--help", cwd=tmp_path)


def test_check_needs_no_arrays_file_or_solver(tmp_path: Path) -> None:
    modules = modules_after("check", str(CASES / "generator.toml"), cwd=tmp_path)
    assert not roots(modules) & {"scipy", "h5py", "pint", "matplotlib"}
    assert not {name for name in modules if name.startswith("vibecalc.isolation")}


def test_run_on_the_generator_needs_no_scipy_pint_or_pictures(tmp_path: Path) -> None:
    modules = modules_after("run", str(CASES / "generator.toml"), "-q", cwd=tmp_path)
    assert not roots(modules) & {"scipy", "pint", "matplotlib", "rich"}
    unused = {"vibecalc.isolation.modes", "vibecalc.optimisation", "vibecalc.study.optimise"}
    assert not modules & unused


@pytest.mark.parametrize(
    ("removed", "unwanted"),
    [
        ("[isolation]", "vibecalc.pipeline.stages.isolation_pitch"),
        ("[isolation]", "vibecalc.pipeline.stages.run_up"),
    ],
)
def test_a_table_that_is_absent_costs_no_import(
    removed: str, unwanted: str, tmp_path: Path
) -> None:
    text = (CASES / "generator.toml").read_text(encoding="utf-8")
    head, rest = text.split(removed, 1)
    assert unwanted.startswith("vibecalc.pipeline.stages.") and rest
    shorter = tmp_path / "shorter.toml"
    shorter.write_text(head, encoding="utf-8")
    whole = modules_after("run", str(CASES / "generator.toml"), "-q", cwd=tmp_path)
    modules = modules_after("run", str(shorter), "-q", cwd=tmp_path)
    assert unwanted in whole
    assert unwanted not in modules
