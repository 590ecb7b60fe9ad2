"""Checks of physics on a validated case, all problems and warnings at once."""

from collections.abc import Callable
from typing import Any

from vibecalc.core.case.number_range import range_problems
from vibecalc.core.results.named import named
from vibecalc.core.run.stage import subjects
from vibecalc.errors import Problem
from vibecalc.kinds import has_crank_train
from vibecalc.numerics.rounding import BoolArray
from vibecalc.parts.body import body_problems, body_suspects
from vibecalc.parts.cautions import part_warnings
from vibecalc.parts.crank_train import crank_train_problems, crank_train_suspects
from vibecalc.parts.drive_checks import gas_problems
from vibecalc.parts.mount_needs import frequency_counts, loads_count
from vibecalc.schema import Case

Check = Callable[[Case], list[Problem]]
Suspects = Callable[[Case], BoolArray | None]


def matrices(case: Case) -> list[Problem]:
    """Problems of matrices, if there are any matrices."""
    body, mounts = case.machine.body, case.machine.mounts
    matrix = None if body is None else body.mass_matrix
    stiffness = None if mounts is None else mounts.stiffness_matrix
    if matrix is None and stiffness is None:
        return []
    from vibecalc.parts.matrices import matrix_problems  # loads what solves the motion

    return matrix_problems(case)


def mounts(case: Case) -> list[Problem]:
    """Problems of mounts that depend on load or frequency, if there are any."""
    given = case.machine.mounts
    if given is None or not (loads_count(given) or frequency_counts(given)):
        return []
    from vibecalc.parts.mount_checks import mount_problems

    return mount_problems(case)


def slave_rods(case: Case) -> list[Problem]:
    """Problems of rods hinged on others, if there are any."""
    if not has_crank_train(case.machine) or not case.machine.crank_train.has_slave_rods:
        return []
    from vibecalc.parts.articulated import articulated_problems

    return articulated_problems(case)


#: of the parts of a machine
OF_PARTS: tuple[Check, ...] = (
    crank_train_problems, slave_rods, body_problems, matrices, mounts, gas_problems,
)  # fmt: skip


def _of_subjects(case: Case, what: str) -> list[Any]:
    """What the subjects that a case has to do with name as their checks or cautions."""
    concerned = [subject for subject in subjects().values() if subject.concerns(case)]
    return [named(where) for subject in concerned for where in getattr(subject, what)]


def checks_of(case: Case) -> tuple[list[Check], list[Check]]:
    """Checks of the parts and of the subjects that a case has to do with; those that come last."""
    return [*OF_PARTS, *_of_subjects(case, "checks")], _of_subjects(case, "last_checks")


#: of some checks: which points of a case with arrays they may refuse
SUSPECTS: dict[Check, Suspects] = {
    crank_train_problems: crank_train_suspects,
    body_problems: body_suspects,
}


def suspects_of(case: Case) -> dict[Check, Suspects]:
    """What tells, for some of the checks of a case, the points of a sweep that they may refuse."""
    return SUSPECTS | {
        named(check): named(where)
        for subject in subjects().values()
        if subject.concerns(case)
        for check, where in subject.suspects.items()
    }


def check_machine(case: Case) -> list[Problem]:
    """What makes a machine impossible or its model meaningless, with key paths into the case.

    Numbers that are out of range come alone, since nothing can be computed with them; what wants a
    possible machine is judged where the other checks find nothing.
    """
    problems = range_problems(case)
    if problems:
        return problems
    first, last = checks_of(case)
    problems = [problem for check in first for problem in check(case)]
    return problems or [problem for check in last for problem in check(case)]


def machine_warnings(case: Case) -> list[str]:
    """Sentences for the report, on a case without problems."""
    cautions = _of_subjects(case, "cautions")
    return [*part_warnings(case), *(words for caution in cautions for words in caution(case))]
