"""Claim: each command imports what it needs and nothing heavier."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from long_but import long_but

from vibecalc.subjects import SUBJECTS

ROOT = Path(__file__).resolve().parents[1]
CASES, PACKAGE = ROOT / "cases", ROOT / "vibecalc"

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


@pytest.mark.parametrize(
    "command", long_but([["--help"], ["run", "--help"], ["diff", "--help"]], ["run", "--help"])
)
def test_help_needs_no_numbers_no_models_and_nothing_that_no_page_shows(
    command: list[str], tmp_path: Path
) -> None:
    modules = modules_after(*command, cwd=tmp_path)
    assert not roots(modules) & {"numpy", "scipy", "h5py", "pint", "matplotlib"}
    assert "vibecalc.schema" not in modules
    assert "rich.panel" in modules
    assert not modules & {"typer.rich_utils", "rich.markdown", "rich.traceback", "rich.syntax"}
    assert not roots(modules) & {"markdown_it", "pygments"}


def test_the_first_help_loads_no_pydantic(tmp_path: Path) -> None:
    # typer itself loads it as soon as it parses the parameter of a command
    assert "pydantic.main" not in modules_after("--help", cwd=tmp_path)


#: what a subject has to say of any case: its tables and rules, its stages, its results
SAYING = (
    "tables", "shaft_line_tables", "rules", "form", "stage", "results",
    "checks", "motor_checks", "line_checks", "engine_rules", "question_tables",
    "question_checks", "line_part_tables", "study_results",
    "asked", "asked_tables", "motion_results", "readings",
)  # fmt: skip
#: what checks count with
COUNTING = (
    "isolation.model",
    "kinematics.harmonics",
    "kinematics.slider_crank",
    "excitation.balance",
    "response.resonances",
)


def computing(modules: set[str]) -> set[str]:
    """Modules of the subjects, without `vibecalc.`, that compute or report."""
    own = {name.removeprefix("vibecalc.") for name in modules if name.startswith("vibecalc.")}
    inside = {name for name in own if name.split(".")[0] in SUBJECTS and "." in name}
    return {name for name in inside if name.split(".")[-1] not in SAYING} - set(COUNTING)


@pytest.fixture(scope="module")
def generator_run(tmp_path_factory: pytest.TempPathFactory) -> set[str]:
    folder = tmp_path_factory.mktemp("generator")
    return modules_after("run", str(CASES / "generator.toml"), "-q", cwd=folder)


def test_run_on_the_generator_needs_no_scipy_pint_or_pictures(generator_run: set[str]) -> None:
    modules = generator_run
    assert {"vibecalc.isolation.rows", "vibecalc.core.results.store"} <= modules
    assert not roots(modules) & {"scipy", "pint", "matplotlib", "rich"}
    assert not modules & {"numpy.ma", "numpy.random", "numpy.fft", "numpy.polynomial"}


def test_run_on_the_generator_needs_no_torque_and_no_search(generator_run: set[str]) -> None:
    found = computing(generator_run)
    assert {name.split(".")[0] for name in found} <= {
        "kinematics",
        "excitation",
        "isolation",
        "response",
    }
    modes = {"modes", "modal_damping", "resonances", "spectral", "system"}
    loads = {"adapters", "adapters.loads", "torque_reaction"}
    used = {name.removeprefix("response.") for name in found if name.startswith("response.")}
    assert used <= modes | loads
    assert not found & {"excitation.cylinder_torque", "excitation.rod_inertia", "torsion"}
    frame = {name.removeprefix("vibecalc.") for name in generator_run}
    for path in NOT_FOR_THE_GENERATOR:
        assert (PACKAGE / path).exists(), f"{path} has moved: this list has to follow"
        name = path.removesuffix(".py").replace("/", ".")
        assert not {one for one in frame if one == name or one.startswith(f"{name}.")}


#: what only an optimisation, a comparison, a mistake, a picture or another machine has work for
NOT_FOR_THE_GENERATOR = (
    "core/study/binding.py",
    "core/study/optimise.py",
    "core/study/search",
    "core/study/sweep",
    "core/results/compare.py",
    "core/case/diagnose.py",
    "core/report/plots.py",
    "core/accuracy",
    "json_schema.py",
    *("absorber/tables.py", "absorber/asked_tables.py", "measurement/tables.py"),
    *("response/tables.py", "roll/tables.py"),
    *("torsion/shaft_line_tables.py", "torsion/tables.py"),
)


def test_a_shaft_line_needs_no_masked_arrays(tmp_path: Path) -> None:
    """Which numpy imports late, in a tenth of the time that it takes itself."""
    keys = ("response.torsion.speeds.points=5", "reference=[]", "limit=[]")
    few = [word for key in keys for word in ("--set", key)]
    modules = modules_after("run", str(CASES / "engine_damped.toml"), "-q", *few, cwd=tmp_path)
    assert "numpy.ma" not in modules
