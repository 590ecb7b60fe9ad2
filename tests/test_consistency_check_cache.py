"""Claim: checks left out because nothing that they read has changed would have found nothing."""

import random
import re
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from shipped_cases import CASES
from test_consistency_stage_cache import leaves

from vibecalc.core.case.load import load_case, validate
from vibecalc.core.case.raw import NOT_COMPUTED, case_at
from vibecalc.core.run import machine_checks
from vibecalc.core.run.machine_checks import OF_PARTS, check_machine
from vibecalc.core.run.run import StageCache, check_again
from vibecalc.core.run.stage import subjects
from vibecalc.errors import CaseError, dotted


@cache
def resolved(name: str) -> dict[str, Any]:
    tables = load_case(CASES[name]).resolved
    return {k: v for k, v in tables.items() if k not in NOT_COMPUTED}


#: these are called by others of them
WITHIN = {
    *("matrix_problems", "planar_problems", "study_problems"),
    *("mount_problems", "articulated_problems", "fit_problems"),
}


def test_all_checks_take_part() -> None:
    """Every function of a case that gives problems is a check of the parts or of a subject."""
    named = {check.__name__ for check in OF_PARTS} - {"matrices", "mounts", "slave_rods"}
    for subject in subjects().values():
        named |= {one.partition(":")[2] for one in (*subject.checks, *subject.last_checks)}
    pattern = r"^def (\w+_problems)\(case: \"?Case\"?\) -> (?:list|Iterator)\["
    package = Path(machine_checks.__file__).parents[2]
    offers = {
        name
        for path in package.rglob("*.py")
        for name in re.findall(pattern, path.read_text(encoding="utf-8"), re.M)
    }
    assert offers - WITHIN == named
    assert offers >= WITHIN


@pytest.mark.parametrize(
    "name",
    [
        "generator",
        pytest.param("compressor", marks=pytest.mark.long),
        pytest.param("compressor_impact", marks=pytest.mark.long),
        "four_cylinder",
    ],
)
def test_changed_numbers_have_the_same_problems(name: str) -> None:
    tables, cache, draw = resolved(name), StageCache(), random.Random(name)
    paths = leaves(tables)
    chosen = draw.sample(paths, min(len(paths), 150))
    refused = 0
    for path in chosen:
        value: Any = tables
        for part in path:
            value = value[part]
        for factor in (1.1, 0.0, -1.0, 1e-30, 1e30, 1e3):
            try:
                case = validate(case_at(tables, {dotted(path): factor * value}))
            except CaseError:
                continue
            problems = check_machine(case)
            refused += bool(problems)
            assert check_again(case, cache) == problems, (path, factor)
    assert refused > 10
