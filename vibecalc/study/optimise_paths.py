"""Result paths that an optimisation adds to those of its stages."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.case.overrides import field_unit
from vibecalc.pipeline.entries.entry import Entry
from vibecalc.pipeline.plan import planned_quantities
from vibecalc.study.balancing import balances
from vibecalc.study.optimise_further_paths import COMPARE_BUDGET, front_points, further_entries

if TYPE_CHECKING:
    from vibecalc.case.schema import Case
    from vibecalc.case.tables import Optimisation

ROOT = "optimisation"


def optimisation_entries(case: "Case") -> dict[str, Entry]:
    """Catalogue entries of everything under `optimisation/` for a case that optimises."""
    return {entry.path: entry for entry in _entries(case)}


def _entries(case: "Case") -> Iterator[Entry]:
    study = case.optimisation
    if study is None:
        return
    planned = planned_quantities(case)
    goal = planned.get(study.objective.quantity)
    unit, kind = (goal.unit, goal.amplitude) if goal else ("", None)
    for variable in study.variables:
        key = variable.key
        own = field_unit(key)
        yield Entry(f"{ROOT}/variable/{key}", (), own, f"{key} at the optimum")
        yield Entry(
            f"{ROOT}/active_bound/{key}", (), "", "-1 at lower bound, 1 at upper, 0 between"
        )
        yield Entry(f"{ROOT}/history/start/{key}", ("search",), own, f"{key} where searches began")
        yield Entry(f"{ROOT}/history/end/{key}", ("search",), own, f"{key} where searches ended")
    yield Entry(f"{ROOT}/objective", (), unit, "objective at the optimum", kind)
    if balances(case):
        yield Entry(f"{ROOT}/lower_bound", (), unit, "no values within the bounds give less", kind)
    yield Entry(f"{ROOT}/margin", ("limit",), "", "distance to a limit over the limit")
    yield Entry(f"{ROOT}/multiplier", ("limit",), unit, "rise of the objective per unit of margin")
    yield Entry(f"{ROOT}/kkt_residual", (), "", "what is left of the gradients that should balance")
    yield Entry(f"{ROOT}/evaluations", (), "", "points evaluated")
    yield Entry(f"{ROOT}/failures", (), "", "points that could not be evaluated")
    yield Entry(
        f"{ROOT}/history/objective", ("search",), unit, "objective where searches ended", kind
    )
    yield Entry(f"{ROOT}/history/feasible", ("search",), "", "1 where a search kept all limits")
    yield Entry(f"{ROOT}/history/evaluations", ("search",), "", "points a search evaluated")
    yield Entry(f"{ROOT}/optima/objective", ("optimum",), unit, "distinct optima, best first", kind)
    yield Entry(f"{ROOT}/optima/found_by", ("optimum",), "", "searches that ended there")
    yield from further_entries(study, planned)
    for path, entry in planned.items():
        yield entry._replace(path=f"{ROOT}/start/{path}")


def describe_study(case: "Case") -> dict[str, str]:
    """The row of the plan that an optimisation adds."""
    study = case.optimisation
    if study is None:
        raise ValueError("the case has no [optimisation]")
    return {
        "stage": "optimisation",
        "why": "[optimisation] is in the case",
        "parts": ", ".join(variable.key for variable in study.variables),
        "orders": "",
        "modules": ", ".join(_modules(study)),
        "cost": (
            "solved as linear least squares within bounds"
            if balances(case)
            else f"{study.starts + 1} searches of some 50 runs each of the stages above"
        )
        + _further_cost(study),
        "quantities": ", ".join(
            path for path in optimisation_entries(case) if not path.startswith(f"{ROOT}/start/")
        ),
    }


def _modules(study: "Optimisation") -> Iterator[str]:
    yield "optimisation.constrained"
    if study.compare or study.method:
        yield "optimisation.methods"
    if study.sensitivity:
        yield "optimisation.sensitivity"
    if study.second_objective:
        yield "optimisation.pareto"


def _further_cost(study: "Optimisation") -> str:
    words = ""
    if study.compare:
        words += f", {len(study.compare)} methods beside it with up to {COMPARE_BUDGET} runs each"
    if study.second_objective:
        words += f", some 100 runs for each of {front_points(study)} points of the front"
    return words
