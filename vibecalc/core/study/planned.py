"""What studies add to a run of the stages: their result paths, and their rows of the plan."""

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from types import MappingProxyType
from typing import TYPE_CHECKING

from vibecalc.core.case.load import resolve
from vibecalc.core.case.raw import field_unit, number_at
from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.results.record import FRONT_NAMES, Entry
from vibecalc.core.run.plan import needed_stages, planned_quantities
from vibecalc.core.run.stage import Stage
from vibecalc.core.study.balancing import balances
from vibecalc.core.study.choices import (
    MOST_RUNS,
    SEARCH_RUNS,
    choices_of,
    combinations,
    examines_all,
    runs_of_one,
)
from vibecalc.core.study.measured_points import chosen_references

if TYPE_CHECKING:
    from vibecalc.core.case.study_tables import Find, Optimisation
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Result paths as tables: name, axes, unit, words.
# ----------------------------------------------------------------------------

#: unit as a table names it -> the unit, and the kind of amplitude
Units = Mapping[str, tuple[str, str | None]]


def tabled(
    root: str,
    table: str,
    units: Units,
    each: Mapping[str, Sequence[Mapping[str, str]]],
    asked: Mapping[str, object] = MappingProxyType({}),
) -> dict[str, Entry]:
    """Catalogue entries below a root, by path.

    Rows with a name in braces are repeated for `each` of that name, with what belongs to it, as a
    unit may. What is not `asked` for, by the first part of the path, is left out.
    """
    found = {}
    lines = (line.split("|") for line in table.strip().splitlines())
    for mark, rows in groupby(lines, key=lambda row: row[0].partition("{")[2].partition("}")[0]):
        block = list(rows)
        for names in each[mark] if mark else [{}]:
            for row in block:
                name, axes, unit, words = (one.strip().format(**names) for one in row)
                if asked.get(name.partition("/")[0], True):
                    known, path = names.get(unit, unit), f"{root}/{name}"
                    of, kind = units.get(known, (known, None))
                    found[path] = Entry(path, tuple(axes.split()), of, words, kind)
    return found


def _unit_of(planned: Mapping[str, Entry], quantity: str) -> tuple[str, str | None]:
    """Unit and kind of amplitude of a result; none of one that no stage brings."""
    goal = planned.get(quantity)
    return (goal.unit, goal.amplitude) if goal else ("", None)


# ----------------------------------------------------------------------------
# Result paths that [[find]] adds to those of the stages, and its row of the plan.
# ----------------------------------------------------------------------------

FIND = "find"
#: below it the results of the machine that a search found
MACHINE = "machine"
_FOUND = """
value          |          | key  | KEY that brings what is wanted
ratio          |          |      | that value over the one written
reached        |          | goal | GOAL there
wanted         |          | goal | GOAL that is wanted
written        |          | key  | KEY as written
others         | solution | key  | further values of KEY between the bounds
others_reached | solution | goal | GOAL with these
scaled_with/{key} |       | unit | {key} with that value
evaluations    |          |      | points evaluated
failures       |          |      | points that could not be evaluated
"""


def find_entries(case: "Case") -> dict[str, Entry]:
    """Catalogue entries of everything under `find/` for a case that searches."""
    if not case.find:
        return {}
    planned, resolved = planned_quantities(case), resolve(case)
    found: dict[str, Entry] = {}
    for search in case.find:
        root, written = f"{FIND}/{search.name}", number_at(resolved, search.key, math.nan)
        is_written = math.isfinite(written)
        found |= tabled(
            root,
            _FOUND.replace("KEY", search.key).replace("GOAL", search.quantity),
            {"key": (field_unit(search.key), None), "goal": _unit_of(planned, search.quantity)},
            {"key": [{"key": key, "unit": field_unit(key)} for key in search.also]},
            {
                "ratio": is_written and written != 0.0,
                "wanted": search.sense is None,
                "written": is_written,
            },
        )
        for path in machine_paths(case, search):
            below = f"{root}/{MACHINE}/{path}"
            found[below] = planned[path]._replace(path=below)
    return found


def machine_paths(case: "Case", search: "Find") -> tuple[str, ...]:
    """Results without axes of the stages that a search runs: of the machine found, too."""
    stages = needed_stages(case, frozenset({search.quantity}))
    paths = (path for stage in stages for path in stage.quantities)
    return tuple(path for path in paths if not CATALOGUE[path].axes)


def describe_find(case: "Case") -> dict[str, str]:
    """The row of the plan that the searches add."""
    keys = (key for search in case.find for key in (search.key, *search.also))
    runs = " + ".join(str(search.points) for search in case.find)
    quantities = ", ".join(dict.fromkeys(search.quantity for search in case.find))
    cost = f"{runs} runs and about 15 per solution of the stages for {quantities}"
    return _row("find", "[[find]]", keys, cost, find_entries(case))


def _row(
    name: str, table: str, parts: Iterable[str], cost: str, quantities: Iterable[str]
) -> dict[str, str]:
    """A row of the plan, as a stage has one."""
    why, known = f"{table} is in the case", tuple(dict.fromkeys(parts))
    return Stage(name, "", why, known, "", cost, tuple(quantities)).as_texts()


# ----------------------------------------------------------------------------
# Result paths of a fit, and its row of the plan.
# ----------------------------------------------------------------------------

FIT = "fit"
#: runs of one search for each key
_FIT_RUNS = 20
_FITTED = """
value/{key}             |                         | unit | {key}, fitted
standard_error/{key}    |                         | unit | standard uncertainty of {key}
start/{key}             |                         | unit | {key} as written
active_bound/{key}      |                         |      | -1 at lower bound, 1 at upper, 0 between
correlation             | variable other_variable |      | correlation of the fitted keys
chi_square |  |  | sum of the squared residuals over uncertainties
start_chi_square        |                         |      | the same for the case as written
degrees_of_freedom      |                         |      | points less keys that they tell
probability             | | | of a chi square as large, were the uncertainties right
growth                  | | | factor of all uncertainties that the scatter of the points asks
residual | measured_point |  | computed less measured over the uncertainty
start_residual          | measured_point          |      | the same for the case as written
combination             | combination variable    |      | orthogonal combinations of keys
combination_uncertainty|combination||standard uncertainty along each, over the way between bounds
combination_told        | combination             |      | 1 where the points tell it
search_chi_square       | search                  |      | chi square where searches ended
evaluations             |                         |      | points evaluated
failures                |                         |      | points that could not be evaluated
measured/{path}         | point                   | path | {words}, measured
uncertainty/{path} | point | path | {words}, standard uncertainty of what was measured
at_start/{path}         | point                   | path | {words}, computed for the case as written
computed/{path}         | point                   | path | {words}, computed with the fitted keys
"""


def fit_entries(case: "Case") -> dict[str, Entry]:
    """Catalogue entries of everything under `fit/` for a case that is fitted."""
    if case.fit is None:
        return {}
    planned = planned_quantities(case)
    known = [planned[path] for path in _measured(case) if path in planned]
    each = {
        "key": [{"key": one.key, "unit": field_unit(one.key)} for one in case.fit.variables],
        "path": [{"path": one.path, "words": one.long_name} for one in known],
    }
    return tabled(FIT, _FITTED, {one.path: (one.unit, one.amplitude) for one in known}, each)


def _measured(case: "Case") -> dict[str, None]:
    """The quantities that were measured."""
    return dict.fromkeys(one.quantity for _, one in chosen_references(case))


def describe_fit(case: "Case") -> dict[str, str]:
    """The row of the plan that a fit adds."""
    assert case.fit is not None
    keys = [variable.key for variable in case.fit.variables]
    cost = f"{len(list(chosen_references(case)))} measured points, {case.fit.starts + 1} searches "
    cost += f"of about {_FIT_RUNS * len(keys)} runs each of the stages for "
    cost += ", ".join(_measured(case))
    return _row("fit", "[fit]", keys, cost, fit_entries(case))


def fit_runs(case: "Case") -> int:
    """Runs of the stages that a fit is likely to take."""
    assert case.fit is not None
    return (case.fit.starts + 2) * _FIT_RUNS * len(case.fit.variables)


# ----------------------------------------------------------------------------
# Result paths that an optimisation adds to those of its stages.
# ----------------------------------------------------------------------------

ROOT = "optimisation"
#: runs of one point of a front, of weights solved for next to one for each variable
FRONT_RUNS, _SOLVED = 100, 5
#: points of a front that says nothing else
FRONT_POINTS = 15

#: `goal` has the unit and the kind of amplitude of the objective, `loss` the unit alone
_OPTIMUM = """
{choice}                 |             | unit  | {name}, picked{number}
combinations/{choice}    | combination | unit  | {name} there
combinations/possible    |             |       | combinations of all that can be picked
combinations/examined    |             |       | combinations examined
combinations/kept        |             |       | combinations that can keep all limits
combinations/objective   | combination | goal  | best objective of each, best first
combinations/feasible    | combination |       | 1 where it can keep all limits
combinations/evaluations | combination |       | points evaluated for it
variable/{key}           |             | unit  | {key} at the optimum
active_bound/{key}       |             |       | -1 at lower bound, 1 at upper, 0 between
history/start/{key}      | search      | unit  | {key} where searches began
history/end/{key}        | search      | unit  | {key} where searches ended
objective                |             | goal  | objective at the optimum
lower_bound              |             | goal  | no values within the bounds give less
margin                   | limit       |       | distance to a limit over the limit
multiplier               | limit       | loss  | rise of the objective per unit of margin
kkt_residual             |             |       | what is left of the gradients that should balance
evaluations              |             |       | points evaluated
failures                 |             |       | points that could not be evaluated
history/objective        | search      | goal  | objective where searches ended
history/feasible         | search      |       | 1 where a search kept all limits
history/evaluations      | search      |       | points a search evaluated
optima/objective         | optimum     | goal  | distinct optima, best first
optima/found_by          | optimum     |       | searches that ended there
gain                     |             | goal  | how much better the optimum is than the start
sensitivity/{key}        | point       | slope | objective per unit of {key}
deviation/size/{key}     |             | unit  | 1 % of the bounds of {key}, the worse way
deviation/loss/{key}     |             | loss  | objective lost by it at the optimum
deviation/margin/{key}   |             |       | least margin of all limits there
robust/nominal           | point       | goal  | objective without tolerances
robust/mean              | point       | goal  | mean over the machines within tolerances
robust/deviation         | point       | loss  | deviation over these machines
robust/value             | point       | goal  | mean and deviations together, which is improved
robust/mean_error        | point       | loss  | standard error of the mean, by other machines drawn
robust/deviation_error   | point       | loss  | standard error of the deviation
robust/value_error       | point       | loss  | standard error of mean and deviations together
robust/samples           |             |       | machines drawn for each candidate
robust/margin_nominal | limit |  | distance to a limit over the limit, without tolerances
robust/margin_mean       | limit       |       | mean of that over the machines
robust/margin_deviation  | limit       |       | deviation of that over the machines
front/{goal}             | front_point | goal  | {words}
front/knee               |             |       | number of the point at the knee of the front
front/{choice}           | front_point | unit  | {name} there
front/variable/{key}     | front_point | unit  | {key} there
front/evaluations        |             |       | points evaluated for the front
"""


def optimisation_entries(case: "Case") -> dict[str, Entry]:
    """Catalogue entries of everything under `optimisation/` for a case that optimises."""
    study = case.optimisation
    if study is None:
        return {}
    planned, choices = planned_quantities(case), choices_of(study)
    goals = dict(zip(FRONT_NAMES, study.goals, strict=False))
    units = {name: _unit_of(planned, one.quantity) for name, one in goals.items()}
    of_goal, _ = units["goal"] = units["objective"]
    units["loss"] = (of_goal, None)
    each = {
        "choice": [
            {
                "choice": choice.path,
                "name": choice.name,
                "unit": field_unit(choice.name) if choice.is_number else "",
                "number": "" if choice.is_number else ": number in its list, from 1",
            }
            for choice in choices
        ],
        "key": [
            {"key": key, "unit": field_unit(key), "slope": _over(of_goal, field_unit(key))}
            for key in (variable.key for variable in study.moving)
        ],
        "goal": [
            {"goal": name, "words": f"{words} {'there' if place else 'along the front'}"}
            for place, (name, words) in enumerate((one, one.replace("_", " ")) for one in goals)
        ],
    }
    asked = {
        "combinations": choices,
        "lower_bound": balances(case),
        **dict.fromkeys(("gain", "sensitivity", "deviation"), study.sensitivity),
        "robust": study.robust,
        "front": study.second_objective,
    }
    found = tabled(ROOT, _OPTIMUM, units, each, asked)
    for path, entry in planned.items():
        found[f"{ROOT}/start/{path}"] = entry._replace(path=f"{ROOT}/start/{path}")
    return found


def _over(unit: str, key_unit: str) -> str:
    """Unit of a slope."""
    if not key_unit:
        return unit
    bottom = f"({key_unit})" if any(mark in key_unit for mark in "*/") else key_unit
    return f"{unit or '1'}/{bottom}"


def search_runs(case: "Case") -> int:
    """Points that the search of an optimisation is likely to evaluate, without what follows it."""
    study = case.optimisation
    assert study is not None
    choices = choices_of(study)
    if balances(case) and not case.limit:
        return len(study.variables) + _SOLVED
    if not choices:
        return (study.starts + 1) * SEARCH_RUNS
    return combinations(choices) * runs_of_one(study) if examines_all(study, choices) else MOST_RUNS


def front_runs(study: "Optimisation", every: bool = False) -> int:
    """Points that the front is likely to take: of `every` combination, or of those traced."""
    if study.second_objective is None:
        return 0
    each = (study.front_points or FRONT_POINTS) * FRONT_RUNS if study.moving else 1
    whole = combinations(choices_of(study)) * each
    return whole if every or whole <= MOST_RUNS else each


def describe_study(case: "Case") -> dict[str, str]:
    """The row of the plan that an optimisation adds."""
    study = case.optimisation
    assert study is not None
    keys = [variable.key for variable in study.variables]
    keys += [table for stock in study.stock for table in (stock.table, *stock.also)]
    choices = choices_of(study)
    possible, points = combinations(choices), study.front_points or FRONT_POINTS
    each = f"of about {runs_of_one(study)} runs each" if study.moving else "of one run each"
    if balances(case):
        cost = "solved as linear least squares within bounds"
    elif not choices:
        cost = f"{study.starts + 1} searches of about 50 runs each of the stages above"
    elif examines_all(study, choices):
        cost = f"all {possible} combinations {each} of the stages above"
    else:
        cost = (
            f"differential evolution over {possible} combinations {each}, then all neighbours "
            f"of the best, within about {MOST_RUNS} runs of the stages above"
        )
    if study.robust:
        cost += f", each with {study.robust.samples} samples of the tolerances"
    if study.second_objective and study.moving:
        cost += f", about 100 runs for each of {points} points of the front"
        count = front_runs(study) // (points * FRONT_RUNS)
        cost += f" of each of {count} combinations" if count > 1 else ""
    paths = (one for one in optimisation_entries(case) if not one.startswith(f"{ROOT}/start/"))
    return _row("optimisation", "[optimisation]", keys, cost, paths)


def study_entries(case: "Case") -> dict[str, Entry]:
    """Catalogue entries of all studies of a case."""
    return optimisation_entries(case) | find_entries(case) | fit_entries(case)


def study_rows(case: "Case") -> list[dict[str, str]]:
    """Rows of the plan of all studies of a case."""
    rows = [] if case.optimisation is None else [describe_study(case)]
    rows += [describe_find(case)] if case.find else []
    return rows if case.fit is None else [*rows, describe_fit(case)]
