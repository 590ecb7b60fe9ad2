"""What a run to an optimum or to a wanted value adds to those of the stages: its result paths."""

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from vibecalc.core.case.load import resolve
from vibecalc.core.case.raw import field_unit, number_at
from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.results.record import Entry
from vibecalc.core.run.plan import needed_stages, planned_quantities
from vibecalc.core.study.balancing import balances
from vibecalc.core.study.choices import (
    MOST_RUNS,
    SEARCH_RUNS,
    Choice,
    choices_of,
    combinations,
    examines_all,
    runs_of_one,
)

if TYPE_CHECKING:
    from vibecalc.core.case.study_tables import Find, Objective, Optimisation
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Result paths that [[find]] adds to those of the stages, and its row of the plan.
# ----------------------------------------------------------------------------

FIND = "find"
#: below it the results of the machine that a search found
MACHINE = "machine"


def find_entries(case: "Case") -> dict[str, Entry]:
    """Catalogue entries of everything under `find/` for a case that searches."""
    if not case.find:
        return {}
    planned, resolved = planned_quantities(case), resolve(case)
    found: dict[str, Entry] = {}
    for search in case.find:
        goal = planned.get(search.quantity)
        unit, kind = (goal.unit, goal.amplitude) if goal else ("", None)
        written = number_at(resolved, search.key, math.nan)
        found |= {entry.path: entry for entry in _find_entries(search, written, unit, kind)}
        for path in machine_paths(case, search):
            entry = planned[path]._replace(path=f"{FIND}/{search.name}/{MACHINE}/{path}")
            found[entry.path] = entry
    return found


def machine_paths(case: "Case", search: "Find") -> tuple[str, ...]:
    """Results without axes of the stages that a search runs: of the machine found, too."""
    stages = needed_stages(case, frozenset({search.quantity}))
    paths = (path for stage in stages for path in stage.quantities)
    return tuple(path for path in paths if not CATALOGUE[path].axes)


def _find_entries(search: "Find", written: float, unit: str, kind: str | None) -> Iterator[Entry]:
    root, key, key_unit = f"{FIND}/{search.name}", search.key, field_unit(search.key)
    yield Entry(f"{root}/value", (), key_unit, f"{key} that brings what is wanted")
    is_written = math.isfinite(written)
    if is_written and written != 0.0:
        yield Entry(f"{root}/ratio", (), "", "that value over the one written")
    yield Entry(f"{root}/reached", (), unit, f"{search.quantity} there", kind)
    if search.seek is None:
        yield Entry(f"{root}/wanted", (), unit, f"{search.quantity} that is wanted", kind)
    if is_written:
        yield Entry(f"{root}/written", (), key_unit, f"{key} as written")
    yield Entry(
        f"{root}/others", ("solution",), key_unit, f"further values of {key} between the bounds"
    )
    yield Entry(
        f"{root}/others_reached", ("solution",), unit, f"{search.quantity} with these", kind
    )
    for other in search.also:
        yield Entry(f"{root}/also/{other}", (), field_unit(other), f"{other} with that value")
    yield Entry(f"{root}/evaluations", (), "", "points evaluated")
    yield Entry(f"{root}/failures", (), "", "points that could not be evaluated")


def describe_find(case: "Case") -> dict[str, str]:
    """The row of the plan that the searches add."""
    keys = (key for search in case.find for key in (search.key, *search.also))
    runs = " + ".join(str(search.points) for search in case.find)
    return {
        "stage": "find",
        "why": "[[find]] is in the case",
        "parts": ", ".join(dict.fromkeys(keys)),
        "orders": "",
        "cost": f"{runs} runs, and some 15 for each solution, of the stages that make "
        + ", ".join(dict.fromkeys(search.quantity for search in case.find)),
        "quantities": ", ".join(find_entries(case)),
    }


# ----------------------------------------------------------------------------
# Result paths of what an optimisation adds only if it is asked to: methods, front, slopes.
# ----------------------------------------------------------------------------

#: most runs of the stages that one compared method may spend
COMPARE_BUDGET = 5000
#: runs of one point of a front, of weights solved for next to one for each variable
FRONT_RUNS, _SOLVED = 100, 5
_FRONT_POINTS = 15


def front_points(study: "Optimisation") -> int:
    """Points of the front that are asked for."""
    return _FRONT_POINTS if study.front_points is None else study.front_points


#: objectives of a front, in their order
FRONT_NAMES = (
    "objective",
    "second_objective",
    "third_objective",
    "fourth_objective",
    "fifth_objective",
)


def goals_of(study: "Optimisation") -> tuple["Objective", ...]:
    """All objectives, in the order of `FRONT_NAMES`."""
    second = () if study.second_objective is None else (study.second_objective,)
    return (study.objective, *second, *study.further_objectives)


def further_entries(study: "Optimisation", planned: Mapping[str, Entry]) -> Iterator[Entry]:
    """Catalogue entries of the parts that `study` asks for."""
    goal = planned.get(study.objective.quantity)
    unit, kind = (goal.unit, goal.amplitude) if goal else ("", None)
    keys = [variable.key for variable in study.moving]
    if study.sensitivity:
        yield Entry(f"{ROOT}/gain", (), unit, "how much better the optimum is than the start", kind)
        for key in keys:
            yield from _sensitivity(key, unit)
    if study.robust:
        yield from _robust(unit, kind)
    if study.compare:
        yield from _methods(unit, kind)
    if study.second_objective:
        axes, root = ("front_point",), f"{ROOT}/front"
        for name, one in zip(FRONT_NAMES, goals_of(study), strict=False):
            of = planned.get(one.quantity)
            of_unit, of_kind = (of.unit, of.amplitude) if of else ("", None)
            words = name.replace("_", " ")
            where = "along the front" if name == "objective" else "there"
            yield Entry(f"{root}/{name}", axes, of_unit, f"{words} {where}", of_kind)
        yield Entry(f"{root}/knee", (), "", "number of the point at the knee of the front")
        for choice in choices_of(study):
            unit_of = field_unit(choice.name) if choice.is_number else ""
            yield Entry(f"{root}/{choice.path}", axes, unit_of, f"{choice.name} there")
        for key in keys:
            yield Entry(f"{ROOT}/front/variable/{key}", axes, field_unit(key), f"{key} there")
        yield Entry(f"{ROOT}/front/evaluations", (), "", "points evaluated for the front")


def _robust(unit: str, kind: str | None) -> Iterator[Entry]:
    axes, root = ("point",), f"{ROOT}/robust"
    for name, words, amplitude in (
        ("nominal", "objective without tolerances", kind),
        ("mean", "mean over the machines within tolerances", kind),
        ("deviation", "deviation over these machines", None),
        ("value", "mean and deviations together, which is improved", kind),
        ("mean_error", "standard error of the mean, by other machines drawn", None),
        ("deviation_error", "standard error of the deviation", None),
        ("value_error", "standard error of mean and deviations together", None),
    ):
        yield Entry(f"{root}/{name}", axes, unit, words, amplitude)
    yield Entry(f"{root}/samples", (), "", "machines drawn for each candidate")
    for name, words in (
        ("nominal", "distance to a limit over the limit, without tolerances"),
        ("mean", "mean of that over the machines"),
        ("deviation", "deviation of that over the machines"),
    ):
        yield Entry(f"{root}/margin_{name}", ("limit",), "", words)


def _sensitivity(key: str, unit: str) -> Iterator[Entry]:
    key_unit = field_unit(key)
    yield Entry(
        f"{ROOT}/sensitivity/{key}",
        ("point",),
        _over(unit, key_unit),
        f"objective per unit of {key}",
    )
    cost = f"{ROOT}/deviation"
    yield Entry(f"{cost}/size/{key}", (), key_unit, f"1 % of the bounds of {key}, the worse way")
    yield Entry(f"{cost}/loss/{key}", (), unit, "objective lost by it at the optimum")
    yield Entry(f"{cost}/margin/{key}", (), "", "least margin of all limits there")


def _methods(unit: str, kind: str | None) -> Iterator[Entry]:
    axes = ("method",)
    for name, value_unit, words, amplitude in (
        ("objective", unit, "objective where the method ended", kind),
        ("shortfall", unit, "how much worse it is than the optimum", None),
        ("distance", "", "largest distance of a variable from the optimum, over its bounds", None),
        ("violation", "", "most negative margin, as a positive number", None),
        ("kkt_residual", "", "what is left of the gradients; infinite on a kink", None),
        ("converged", "", "1 where the method says that it has converged", None),
        ("evaluations", "", "points evaluated", None),
        ("failures", "", "points that could not be evaluated", None),
    ):
        yield Entry(f"{ROOT}/methods/{name}", axes, value_unit, words, amplitude)


def _over(unit: str, key_unit: str) -> str:
    """Unit of a slope."""
    if not key_unit:
        return unit
    bottom = f"({key_unit})" if any(mark in key_unit for mark in "*/") else key_unit
    return f"{unit or '1'}/{bottom}"


# ----------------------------------------------------------------------------
# Result paths that an optimisation adds to those of its stages.
# ----------------------------------------------------------------------------

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
    choices = choices_of(study)
    if choices:
        yield from _combinations(choices, unit, kind)
    for variable in study.moving:
        key = variable.key
        key_unit = field_unit(key)
        yield Entry(f"{ROOT}/variable/{key}", (), key_unit, f"{key} at the optimum")
        yield Entry(
            f"{ROOT}/active_bound/{key}", (), "", "-1 at lower bound, 1 at upper, 0 between"
        )
        yield Entry(
            f"{ROOT}/history/start/{key}", ("search",), key_unit, f"{key} where searches began"
        )
        yield Entry(
            f"{ROOT}/history/end/{key}", ("search",), key_unit, f"{key} where searches ended"
        )
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


def _combinations(choices: tuple[Choice, ...], unit: str, kind: str | None) -> Iterator[Entry]:
    axes, root = ("combination",), f"{ROOT}/combinations"
    for choice in choices:
        words = f"{choice.name}, picked"
        if not choice.is_number:
            words += ": number in its list, from 1"
        unit_of = field_unit(choice.name) if choice.is_number else ""
        yield Entry(f"{ROOT}/{choice.path}", (), unit_of, words)
        yield Entry(f"{root}/{choice.path}", axes, unit_of, f"{choice.name} there")
    yield Entry(f"{root}/possible", (), "", "combinations of all that can be picked")
    yield Entry(f"{root}/examined", (), "", "combinations examined")
    yield Entry(f"{root}/kept", (), "", "combinations that can keep all limits")
    yield Entry(f"{root}/objective", axes, unit, "best objective of each, best first", kind)
    yield Entry(f"{root}/feasible", axes, "", "1 where it can keep all limits")
    yield Entry(f"{root}/evaluations", axes, "", "points evaluated for it")


def search_runs(case: "Case") -> int:
    """Points that the search of an optimisation is likely to evaluate, without what follows it."""
    study = case.optimisation
    if study is None:
        return 0
    if balances(case) and not case.limit:
        return len(study.variables) + _SOLVED
    choices = choices_of(study)
    if not choices:
        return (study.starts + 1) * SEARCH_RUNS
    return combinations(choices) * runs_of_one(study) if examines_all(study, choices) else MOST_RUNS


def runs_expected(case: "Case") -> int:
    """Points that an optimisation is likely to evaluate in all; compared methods end half way."""
    study = case.optimisation
    if study is None:
        return 0
    if balances(case) and not case.limit:
        return search_runs(case)
    return search_runs(case) + len(study.compare) * COMPARE_BUDGET // 2 + front_runs(study)


def front_runs(study: "Optimisation") -> int:
    """Points that the front is likely to take: of all combinations, where these are not many."""
    if study.second_objective is None:
        return 0
    each = front_points(study) * FRONT_RUNS if study.moving else 1
    every = combinations(choices_of(study)) * each
    return every if every <= MOST_RUNS else each


def describe_study(case: "Case") -> dict[str, str]:
    """The row of the plan that an optimisation adds."""
    study = case.optimisation
    if study is None:
        raise ValueError("the case has no [optimisation]")
    keys = [variable.key for variable in study.variables]
    keys += [table for stock in study.stock for table in (stock.table, *stock.also)]
    return {
        "stage": "optimisation",
        "why": "[optimisation] is in the case",
        "parts": ", ".join(keys),
        "orders": "",
        "cost": (
            "solved as linear least squares within bounds"
            if balances(case)
            else _of_choices(study)
            or f"{study.starts + 1} searches of some 50 runs each of the stages above"
        )
        + _further_cost(study),
        "quantities": ", ".join(
            path for path in optimisation_entries(case) if not path.startswith(f"{ROOT}/start/")
        ),
    }


def _of_choices(study: "Optimisation") -> str:
    """How what is picked is searched, nothing where there is nothing to pick."""
    choices = choices_of(study)
    if not choices:
        return ""
    possible = combinations(choices)
    each = f"of some {runs_of_one(study)} runs each" if study.moving else "of one run each"
    if examines_all(study, choices):
        return f"all {possible} combinations {each} of the stages above"
    return (
        f"differential evolution over {possible} combinations {each}, then all next to the best, "
        f"within some {MOST_RUNS} runs of the stages above"
    )


def _further_cost(study: "Optimisation") -> str:
    words = ""
    if study.robust:
        words += f", each run {study.robust.samples} machines within the tolerances"
    if study.compare:
        words += f", {len(study.compare)} further methods with up to {COMPARE_BUDGET} runs each"
    if study.second_objective and study.moving:
        words += f", some 100 runs for each of {front_points(study)} points of the front"
        count = front_runs(study) // (front_points(study) * FRONT_RUNS)
        words += f" of each of {count} combinations" if count > 1 else ""
    return words
