"""Checks of physics on a validated case, all problems and warnings at once."""

from vibecalc.case.schema import Case
from vibecalc.errors import Problem
from vibecalc.machine.body_checks import body_problems
from vibecalc.machine.cautions import machine_warnings
from vibecalc.machine.crank_train_checks import crank_train_problems
from vibecalc.machine.isolation_checks import isolation_problems
from vibecalc.machine.range_checks import range_problems

__all__ = ["check_machine", "machine_warnings"]


def check_machine(case: Case) -> list[Problem]:
    """What makes a machine impossible or its model meaningless, with key paths into the case.

    Numbers that are out of range come alone, since nothing can be computed with them; the model of
    isolation is judged once its body and crank train are possible.
    """
    problems = range_problems(case)
    if problems:
        return problems
    return [*crank_train_problems(case), *body_problems(case)] or isolation_problems(case)
