"""Cases from disk with everything checked that can be without computing: form, physics, targets."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from vibecalc.case.load import LoadedCase, load_case, raise_with_location
from vibecalc.errors import CaseError, Problem
from vibecalc.study.early_checks import early_problems

if TYPE_CHECKING:
    from vibecalc.pipeline.entries.entry import Entry


def load_checked(
    paths: Sequence[Path], settings: Sequence[str] = (), unset: Sequence[str] = ()
) -> list[LoadedCase]:
    """Read every case, or raise one CaseError whose text shows all problems of all files."""
    loaded: list[LoadedCase] = []
    problems: list[Problem] = []
    texts: list[str] = []
    for path in paths:
        try:
            case = load_case(path, settings, early_problems, unset)
            raise_with_location(case, physics_problems(case))
            loaded.append(case)
        except CaseError as error:
            problems += error.problems
            texts.append(str(error))
    if texts:
        raise CaseError(problems, "\n\n".join(texts))
    return loaded


def physics_problems(loaded: LoadedCase) -> list[Problem]:
    """What the machine, the plan and a study find wrong with a case of good form."""
    from vibecalc.core.run.machine_checks import check_machine
    from vibecalc.pipeline.targets import check_targets

    case = loaded.case
    extra: dict[str, Entry] = {}
    problems: list[Problem] = []
    if case.optimisation is not None:
        from vibecalc.study.optimise_checks import study_problems
        from vibecalc.study.optimise_paths import optimisation_entries

        extra = optimisation_entries(case)
        problems = study_problems(case)
    if case.find:
        from vibecalc.study.find_paths import find_entries

        extra = {**extra, **find_entries(case)}
    if case.sweep is not None and case.sweep.axes:
        from vibecalc.study.sweep.early import sweep_problems

        problems = [*problems, *sweep_problems(loaded)]
    return check_machine(case) + check_targets(case, extra) + problems
