"""The checks of physics for studies that change a case thousands of times, a little each time.

A check that found nothing finds nothing again where all that it read is the same. As soon as one
finds something, all of them run, so that the problems are those of `machine.checks`, every time.
"""

from functools import partial
from typing import TYPE_CHECKING

from vibecalc.case.overrides import key_text
from vibecalc.core.case.number_range import present, range_problems
from vibecalc.core.run.machine_checks import CHECKS, check_machine
from vibecalc.errors import Problem
from vibecalc.pipeline.stage_cache import StageCache

if TYPE_CHECKING:
    from vibecalc.case.schema import Case


def check_again(case: "Case", cache: StageCache) -> list[Problem]:
    """`machine.checks.check_machine` with what `cache` knows of earlier cases."""
    now = cache.at(case, None)
    for place in present(case):
        if now.once(f"range of {key_text(place)}", partial(range_problems, places=(place,))):
            return check_machine(case)
    for check in CHECKS:
        if now.once(check.__name__, check):
            return check_machine(case)
    return []
