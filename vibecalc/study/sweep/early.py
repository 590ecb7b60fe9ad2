"""What `check` says of a case with [sweep], before anything is computed."""

from collections.abc import Iterator

from vibecalc.case.load import LoadedCase
from vibecalc.case.schema import Case
from vibecalc.errors import CaseError, Problem
from vibecalc.study.sweep.checks import check_design
from vibecalc.study.sweep.design import Design, make_design
from vibecalc.study.sweep.keep import keep_problems


def sweep_problems(loaded: LoadedCase) -> list[Problem]:
    """Problems of axes, sampling, values and kept results; none without a sweep."""
    case, resolved = loaded.case, loaded.resolved
    if case.sweep is None or not case.sweep.axes:
        return []
    try:
        design = make_design(case.sweep, resolved)
    except CaseError as error:
        return list(error.problems)
    problems = [*_optimised_too(case, design), *check_design(design, resolved)]
    return problems or keep_problems(case.sweep.keep, case, design, resolved)


def _optimised_too(case: Case, design: Design) -> Iterator[Problem]:
    searched = () if case.optimisation is None else case.optimisation.variables
    for index, variable in enumerate(searched):
        if variable.key in design.keys:
            yield Problem(
                path=("optimisation", "variables", index, "key"),
                message="a key that the sweep sets cannot be searched for as well",
                found=variable.key,
                allowed="one or the other",
                also=("sweep", "axes"),
            )
