"""What [fit] fits to, and what it adds to the results of the stages: paths, plan, problems."""

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from vibecalc.core.case.raw import field_unit
from vibecalc.core.results.printed import read_printed, uncertainty_of
from vibecalc.core.results.record import TURN, Entry
from vibecalc.core.run.plan import planned_quantities
from vibecalc.core.study.planned import row_of, tabled
from vibecalc.core.study.variables import start_problems
from vibecalc.errors import KeyPath, Problem, UnitError
from vibecalc.units import convert

if TYPE_CHECKING:
    from vibecalc.core.case.tables import Reference
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Measured points: the references that a case is fitted to, in SI.
# ----------------------------------------------------------------------------

ROOT = "fit"


class MeasuredPoint(NamedTuple):
    """A number that the fit is to meet, and its standard uncertainty, both in the quantity's unit.

    A `cyclic` one says the same after a whole turn.
    """

    quantity: str
    where: Mapping[str, Any]
    value: float
    uncertainty: float
    cyclic: bool

    @property
    def place(self) -> str:
        """The entry as results name it: `order=2, mount=1`."""
        return ", ".join(f"{axis}={entry}" for axis, entry in self.where.items())

    @property
    def name(self) -> str:
        """Quantity and entry."""
        return f"{self.quantity} [{self.place}]" if self.where else self.quantity


def chosen_references(case: "Case") -> Iterator[tuple[int, "Reference"]]:
    """References that [fit] takes, with their place among all."""
    assert case.fit is not None
    for place, one in enumerate(case.reference):
        kept = case.fit.references == "all" or one.kind == case.fit.references
        if kept and not one.known_difference and one.at != "start":
            yield place, one


def measured_points(case: "Case") -> list[MeasuredPoint]:
    """The points of a case that `fit_problems` has found none with."""
    planned = planned_quantities(case)
    return [_point(one, planned) for _, one in chosen_references(case)]


def _point(one: "Reference", planned: Mapping[str, Entry]) -> MeasuredPoint:
    """Raises UnitError where a unit does not fit."""
    unit = planned[one.quantity].unit
    entry = one.model_dump(exclude_none=True)
    printed = read_printed(one.value, one.unit, unit)
    value = convert(printed.number, printed.unit, unit)
    off = convert(uncertainty_of(entry, printed), printed.unit, unit)
    cyclic = planned[one.quantity].circle == TURN
    return MeasuredPoint(one.quantity, dict(one.where), value, abs(off), cyclic)


def fit_problems(case: "Case") -> Iterator[Problem]:
    """Problems of [fit] as a whole: its starts, uncertainties, and whether the points suffice."""
    assert case.fit is not None
    yield from start_problems(case, "fit")
    planned, chosen = planned_quantities(case), list(chosen_references(case))
    for place, one in chosen:
        if one.quantity in planned:  # else it is said as of any reference
            yield from _uncertainty_problems(one, ("reference", place), planned)
    keys, count = len(case.fit.variables), len(chosen)
    if 0 < count < keys:
        yield Problem(
            path=("fit", "variables"),
            message=f"{count} measured point{'' if count == 1 else 's'} cannot tell {keys} keys",
            allowed="at least as many points as keys",
            hint="measure more, or write some of the keys into the case",
        )
    if not count:
        yield Problem(
            path=("fit",),
            message="there is nothing to fit to: the references are all of another kind, of the "
            "start, or have a known_difference",
            allowed="references that [fit] takes",
        )


def _uncertainty_problems(
    one: "Reference", path: KeyPath, planned: Mapping[str, Entry]
) -> Iterator[Problem]:
    """Problems of the uncertainty of a reference, stated or by its digits."""
    stated = one.uncertainty is not None
    found = f", uncertainty = {one.uncertainty!r}"[:60] if stated else ""
    try:
        point = _point(one, planned)
    except UnitError as error:
        if stated:  # else it is said of the value
            unit = planned[one.quantity].unit or "plain numbers"
            yield Problem(
                path=(*path, "uncertainty"),
                message=f"an uncertainty that does not fit {one.quantity}",
                found=str(one.uncertainty)[:60],
                allowed=error.allowed or f"a value in {unit}, or in %",
                hint=error.hint,
            )
        return
    if not (point.uncertainty > 0.0 and math.isfinite(point.value / point.uncertainty)):
        yield Problem(
            path=(*path, "uncertainty") if stated else path,
            message=f"a measured {one.quantity} without uncertainty weighs without end",
            found=f"value = {one.value!r}"[:60] + found,
            allowed='uncertainty > 0, as in uncertainty = "2 %" (of a value that is not 0)',
        )


# ----------------------------------------------------------------------------
# Result paths of a fit, and its row of the plan.
# ----------------------------------------------------------------------------


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
    """Catalogue entries of everything under `fit/`."""
    if case.fit is None:
        return {}
    planned = planned_quantities(case)
    known = [planned[path] for path in _measured(case) if path in planned]
    keys = [variable.key for variable in case.fit.variables]
    each = {
        "key": [{"key": key, "unit": field_unit(key)} for key in keys],
        "path": [{"path": one.path, "words": one.long_name} for one in known],
    }
    units = {one.path: (one.unit, one.amplitude) for one in known}
    return tabled(ROOT, _FITTED, units, each, {})


def _measured(case: "Case") -> tuple[str, ...]:
    """The quantities that were measured."""
    return tuple(dict.fromkeys(one.quantity for _, one in chosen_references(case)))


def describe_fit(case: "Case") -> dict[str, str]:
    """The row of the plan that a fit adds."""
    assert case.fit is not None
    keys = [variable.key for variable in case.fit.variables]
    cost = f"{len(list(chosen_references(case)))} measured points, {case.fit.starts + 1} searches "
    cost += f"of some {_RUNS * len(keys)} runs each of the stages that make "
    cost += ", ".join(_measured(case))
    return row_of("fit", "[fit] is in the case", keys, cost, fit_entries(case))


#: runs of one search for each key
_RUNS = 20


def fit_runs(case: "Case") -> int:
    """Runs of the stages that a fit is likely to take."""
    assert case.fit is not None
    return (case.fit.starts + 2) * _RUNS * len(case.fit.variables)
