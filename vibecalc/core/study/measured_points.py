"""What [fit] fits to, and what is wrong with it."""

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from vibecalc.core.results.printed import read_printed, uncertainty_of
from vibecalc.core.results.record import TURN, Entry
from vibecalc.core.run.plan import planned_quantities
from vibecalc.core.study.variables import start_problems
from vibecalc.errors import KeyPath, Problem, UnitError
from vibecalc.units import convert

if TYPE_CHECKING:
    from vibecalc.core.case.tables import Reference
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Measured points: the references that a case is fitted to, in SI.
# ----------------------------------------------------------------------------


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
    if case.fit is None:
        return
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
            message=f"a measured {one.quantity} without uncertainty would weigh infinitely",
            found=f"value = {one.value!r}"[:60] + found,
            allowed='uncertainty > 0, as in uncertainty = "2 %" (of a value that is not 0)',
        )
