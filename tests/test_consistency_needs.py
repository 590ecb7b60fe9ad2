"""Claim: a run takes what `vibecalc check` says, and a table that is left out takes its cost along.

`make golden` holds the modules, stages and harmonics of every shipped case; here are a few.
"""

import ast
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest
from needs.check_needs import differences, stage_differences
from needs_cases import FOLDER, NAMES, case_of, lighter_cases, table_of
from shipped_cases import ROOT
from test_start_up import modules_after, roots

from vibecalc.case.schema import Case
from vibecalc.pipeline.needs import FRAME, OUTSIDE, Needs, needs_of, work_seconds
from vibecalc.pipeline.needs_imports import PACKAGE, brought_in, imports_of, source_of
from vibecalc.pipeline.needs_lazy import LAZY
from vibecalc.pipeline.needs_units import UNITS
from vibecalc.pipeline.plan import plan_case
from vibecalc.results.store import read_result
from vibecalc.study.check_rows import check_rows
from vibecalc.study.load import load_checked

GOLDEN = ROOT / "tests" / "golden"
STAGES = ROOT / "vibecalc" / "pipeline" / "stages"
ADAPTERS = [
    ".".join((PACKAGE, "pipeline", "stages", *path.relative_to(STAGES).with_suffix("").parts))
    for path in sorted(STAGES.rglob("[a-z]*.py"))
]
#: cases that run in a moment
QUICK = ("generator", "engine_undamped")


def reachable() -> set[str]:
    """Modules that some case may bring in, by imports at once and by those of functions."""
    found: set[str] = set()
    waiting = [*ADAPTERS, *FRAME]
    while waiting:
        fresh = {name for name in brought_in(waiting.pop()) - found if source_of(name)}
        found |= fresh
        waiting += [later for name in fresh for later in imports_of(name).later]
    return {name for name in found if name.split(".")[1] not in OUTSIDE}


def test_every_late_import_has_a_rule() -> None:
    writing = ("h5py", "rich", "pint", "numpy")
    wanted = {
        (name.removeprefix(f"{PACKAGE}."), later.removeprefix(f"{PACKAGE}."))
        for name in reachable()
        for later in imports_of(name).later
        if later.split(".")[0] not in writing and ".".join(later.split(".")[1:2]) not in OUTSIDE
    }
    wanted = {row for row in wanted if not row[0].startswith("study.sweep")}
    assert not sorted(wanted - set(LAZY))
    assert not sorted(set(LAZY) - wanted)


def test_sources_are_read_as_python_reads_them() -> None:
    for name in sorted(reachable())[::5]:
        path = source_of(name)
        assert path is not None
        said = {other for other in imports_of(name).at_once if other.startswith(f"{PACKAGE}.")}
        assert said == _by_syntax(path), name


def _by_syntax(path: Path) -> set[str]:
    found: set[str] = set()
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(f"{PACKAGE}."):
            origin = str(node.module)
            inside = [f"{origin}.{alias.name}" for alias in node.names]
            found |= {origin} if source_of(origin) else {one for one in inside if source_of(one)}
    return found


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("needs")
    for name in QUICK:
        program = [sys.executable, "-m", "vibecalc", "run", str(FOLDER / f"{name}.toml"), "-q"]
        subprocess.run([*program, "-o", f"{folder}/"], check=True)
    return folder


@pytest.mark.parametrize("name", QUICK)
def test_a_run_takes_the_modules_stages_and_harmonics_that_were_said(name: str, runs: Path) -> None:
    (loaded,) = load_checked([FOLDER / f"{name}.toml"])
    result = read_result(runs / f"{name}.h5")
    assert len(str(result.provenance["modules"]).split()) > 100
    assert differences(loaded.case, result) == []


def test_what_is_not_said_is_found(runs: Path) -> None:
    # the run of one case held against what is said of another
    (loaded,) = load_checked([FOLDER / "generator.toml"])
    found = dict(differences(loaded.case, read_result(runs / "engine_undamped.h5")))
    assert {"module", "stages"} <= set(found)
    other = read_result(GOLDEN / "compressor_a.h5")
    assert "harmonics of excitation" in dict(stage_differences(needs_of(loaded.case), other))


@pytest.mark.parametrize("name", [name for name in NAMES if (GOLDEN / f"{name}.h5").is_file()])
def test_harmonics_of_every_golden_result_are_those_said(name: str) -> None:
    case = case_of(table_of(name))
    assert case is not None
    golden = read_result(GOLDEN / f"{name}.h5")
    found = [row for row in stage_differences(needs_of(case), golden) if row[0] != "stages"]
    assert found == []


def test_check_of_every_kind_imports_no_stage_and_no_library(tmp_path: Path) -> None:
    names = ("engine_run_up", "absorber", "roll_dynamic_motor")
    modules = modules_after("check", *(str(FOLDER / f"{n}.toml") for n in names), cwd=tmp_path)
    assert not roots(modules) & {"scipy", "h5py", "pint", "matplotlib"}
    assert not {name for name in modules if name.startswith("vibecalc.pipeline.stages.")}


def test_no_scene_brings_in_what_belongs_to_another() -> None:
    foreign = {
        "generator": ("torsion", "roll", "absorber", "impact", "scipy"),
        "engine_undamped": ("roll", "absorber", "optimisation", "scipy.optimize"),
        "absorber_curves": ("torsion", "roll", "kinematics", "scipy"),
        "roll_measured": ("torsion", "roll.", "kinematics", "isolation.run_up"),
    }
    for name, words in foreign.items():
        case = case_of(table_of(name))
        assert case is not None
        brought = [
            module
            for stage in needs_of(case).stages
            for module in (*stage.modules, *stage.libraries)
            if not module.startswith("pipeline.entries")
        ]
        assert not [module for module in brought for word in words if word in module], name


class Cost(Counter[str]):
    """Counted terms of a plan: stages, quantities, modules, and the seconds of the work."""


def _cost(needs: Needs) -> Cost:
    found = Cost()
    for stage in needs.stages:
        found["stages"] += 1
        found["quantities"] += len(stage.plan.quantities)
    found["modules"] = len({name for stage in needs.stages for name in stage.modules})
    return found


def _seconds(case: Case) -> float:
    _, total = check_rows(case)
    return float(total["seconds"])


@pytest.mark.parametrize("name", NAMES)
def test_a_table_left_out_takes_its_cost_along(name: str) -> None:
    counted = 0
    for key, whole, part in lighter_cases(name):
        before, after = _cost(needs_of(whole)), _cost(needs_of(part))
        grown = [what for what in before | after if after[what] > before[what]]
        cheaper = _seconds(part) < _seconds(whole)
        assert not grown or key in KEYS_THAT_STAND_FOR_LESS, (key, grown)
        assert after != before or cheaper or key in WITHOUT_A_COST, key
        counted += 1
    assert counted or name in BARE, name


#: a table that also says how the machine is driven: what it drives then counts as on the body
KEYS_THAT_STAND_FOR_LESS = (("excitation",),)
#: forces that other tables need as well; natural frequencies that no pendulum moves with the speed
WITHOUT_A_COST = (("excitation",), ("response", "torsion", "campbell"))
#: cases with one table only, or none: there is no run without it
BARE = ("absorber_pendulum", "roll_measured")


def test_work_is_in_units_that_have_a_cost() -> None:
    assert all(unit.seconds > 0.0 and unit.words for unit in UNITS.values())
    used = set()
    for name in NAMES:
        case = case_of(table_of(name))
        assert case is not None
        for stage in needs_of(case).stages:
            assert work_seconds(stage.work) > 0.0
            used |= {unit for _, unit in stage.work}
        assert [stage.plan for stage in needs_of(case).stages] == list(plan_case(case))
    assert len(used) > 0.8 * len(UNITS)
