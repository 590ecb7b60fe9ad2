"""Claim: every check of a case belongs to the parts or to a subject, which a study runs or skips.

That what it skips would have found nothing is held by `test_bad_cases_values.py`.
"""

import re
from pathlib import Path

from vibecalc.core.run import machine_checks
from vibecalc.core.run.machine_checks import OF_PARTS
from vibecalc.core.run.stage import subjects

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
