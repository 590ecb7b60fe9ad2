"""A case with some of its keys set to numbers, as a function that a search can call."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from vibecalc.core.case.load import validate
from vibecalc.core.case.raw import NOT_COMPUTED, case_at, field_unit, number_at
from vibecalc.core.case.tables import Limit, Objective
from vibecalc.core.results.select import Where, uncertainty, worst
from vibecalc.core.run.run import StageCache, check_again, run_case
from vibecalc.core.study.variables import period_of, shown_as
from vibecalc.errors import CaseError, NumericalFailure
from vibecalc.units import parse_quantity

if TYPE_CHECKING:
    from vibecalc.core.case.load import LoadedCase
    from vibecalc.core.results.record import Quantity, Record
    from vibecalc.schema import Case

Side = Literal["max", "min"]


class Binding:
    """Variables, objective and limits of one `[optimisation]` on its case; of a `[fit]` the first.

    `lower`, `upper` and `first` (n,) are in SI, `first` the case as written (of a key that it
    leaves out the middle of the bounds); `period` (n,) is that
    of angles, 0 of others. `accuracy` is the largest relative error estimate met in objective and
    limits.
    """

    def __init__(self, loaded: "LoadedCase"):
        study = loaded.case.optimisation or loaded.case.fit
        if study is None:
            raise ValueError("the case has neither [optimisation] nor [fit]")
        # what a point of the search is computed from; its own tables hold the rest
        self._resolved = {k: v for k, v in loaded.resolved.items() if k not in NOT_COMPUTED}
        # most points of a search change some parts only, and a front comes back to old points
        self._cache = StageCache()
        self.keys = tuple(variable.key for variable in study.variables)
        self.units = tuple(field_unit(key) for key in self.keys)
        self.written = tuple(variable.upper for variable in study.variables)
        self.lower = self._bounds([variable.lower for variable in study.variables])
        self.upper = self._bounds([variable.upper for variable in study.variables])
        middle = (0.5 * (self.lower + self.upper)).tolist()
        self.first = np.array(
            [
                number_at(loaded.resolved, key, where)
                for key, where in zip(self.keys, middle, strict=True)
            ]
        )
        self.period = np.array([period_of(key, loaded.case.machine) for key in self.keys])
        self.ties = tuple(
            tuple(
                (
                    tie.key,
                    tie.factor,
                    0.0 if tie.offset is None else parse_quantity(tie.offset, unit),
                )
                for tie in variable.follow
            )
            for variable, unit in zip(study.variables, self.units, strict=True)
        )
        if loaded.case.optimisation is None:
            return
        study = loaded.case.optimisation
        self.goal = study.objective
        self.sign = sign_of(study.objective)
        self.limits = tuple(limit for limit in loaded.case.limit if _counts(limit))
        self._wanted = frozenset({self.goal.quantity, *(limit.quantity for limit in self.limits)})
        self.accuracy = 0.0

    def _bounds(self, given: list[Any]) -> np.ndarray:
        return np.array(
            [parse_quantity(str(v), unit) for v, unit in zip(given, self.units, strict=True)]
        )

    def case_at(self, variables: np.ndarray) -> "Case":
        """The case with its variables set, checked again; NumericalFailure if it is not a case."""
        settings: dict[str, float] = {}
        for key, value, ties in zip(self.keys, map(float, variables), self.ties, strict=True):
            settings[key] = value
            settings |= {tied: factor * value + offset for tied, factor, offset in ties}
        return checked_case(self._resolved, settings, self._cache)

    def apart(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        """The difference of two points, (n,) in SI, along angles the shorter one around."""
        difference = np.asarray(other - one)
        period = np.where(self.period > 0.0, self.period, 1.0)
        return np.where(
            self.period > 0.0, difference - period * np.round(difference / period), difference
        )

    def evaluate(self, variables: np.ndarray) -> tuple[float, np.ndarray]:
        """Objective (to be made small) and dimensionless margins, kept where >= 0.

        They are those of the whole interval of a value and its error, as verdicts are.
        """
        record = self.results(variables, self._wanted)
        return self._objective(record, self.goal), self._all_margins(record)

    def evaluate_both(
        self, variables: np.ndarray, second: Objective
    ) -> tuple[float, float, np.ndarray]:
        """Objective and a second one (both to be made small) and the margins."""
        record = self.results(variables, self._wanted | {second.quantity})
        one, two = (self._objective(record, goal) for goal in (self.goal, second))
        return one, two, self._all_margins(record)

    def results(self, variables: np.ndarray, wanted: frozenset[str]) -> "Record":
        """Some results of the case with its variables set; NumericalFailure as in a run."""
        return run_case(self.case_at(variables), wanted=wanted, cache=self._cache)

    def _objective(self, record: "Record", goal: Objective) -> float:
        side: Side = "max" if goal.sense == "min" else "min"
        value, _ = worst(record[goal.quantity], goal.where, side)
        self._note_accuracy(record, goal.quantity, value)
        return sign_of(goal) * value

    def _all_margins(self, record: "Record") -> np.ndarray:
        margins = [margin for limit in self.limits for margin in self._margins(record, limit)]
        return np.array(margins, dtype=float)

    def _margins(self, record: "Record", limit: Limit) -> list[float]:
        quantity = record[limit.quantity]
        margins = []
        bounds: tuple[tuple[Any, Side, float], ...] = (
            (limit.max, "max", 1.0),
            (limit.min, "min", -1.0),
        )
        for bound, side, sign in bounds:
            if bound is None:
                continue
            allowed = parse_quantity(str(bound), quantity.unit)
            value, _ = worst(quantity, limit.where, side)
            self._note_accuracy(record, limit.quantity, value)
            reach = self._reach(quantity, limit.where, value)
            margins.append((sign * (allowed - value) - reach) / (abs(allowed) or 1.0))
        return margins

    def _reach(self, quantity: "Quantity", where: Where, value: float) -> float:
        """How far the truth may lie beyond a value that a limit holds."""
        zero = quantity.estimate.is_zero(value)
        return 0.0 if zero or not np.isfinite(value) else uncertainty(quantity, where)

    def words(self, variables: np.ndarray) -> str:
        """The variables by name, in the units that the case gives their bounds in."""
        return ", ".join(
            f"{key} = {shown_as(float(value), unit, written)}"
            for key, value, unit, written in zip(
                self.keys, variables, self.units, self.written, strict=True
            )
        )

    def broken(self, variables: np.ndarray) -> tuple[str, np.ndarray]:
        """Which limits a point breaks and by how much, in the units of the case; and all margins.

        Raises NumericalFailure as a run does.
        """
        record = self.results(variables, self._wanted)
        said = []
        for limit in self.limits:
            quantity = record[limit.quantity]
            for bound, side, most in (
                (limit.max, "max", "at most"),
                (limit.min, "min", "at least"),
            ):
                if bound is None:
                    continue
                value, label = worst(quantity, limit.where, "max" if side == "max" else "min")
                allowed = parse_quantity(str(bound), quantity.unit)
                left = allowed - value if side == "max" else value - allowed
                if left < self._reach(quantity, limit.where, value):
                    said.append(
                        f"{limit.quantity}{f' at {label}' if label else ''} is "
                        f"{shown_as(value, quantity.unit, bound)}, {most} "
                        f"{shown_as(allowed, quantity.unit, bound)} is allowed"
                    )
        return "; ".join(said), self._all_margins(record)

    def margin_names(self) -> tuple[str, ...]:
        """One name per margin, in the order of `evaluate`."""
        return tuple(
            f"{limit.quantity} {side} {bound}"
            for limit in self.limits
            for side, bound in (("max", limit.max), ("min", limit.min))
            if bound is not None
        )

    def _note_accuracy(self, record: "Record", path: str, value: float) -> None:
        if value != 0.0 and np.isfinite(value):
            self.accuracy = max(self.accuracy, record[path].error_estimate / abs(value))


def checked_case(
    resolved: Mapping[str, Any], settings: Mapping[str, float], cache: StageCache
) -> "Case":
    """A case in SI with some keys set, checked again; NumericalFailure if it is not a case."""
    try:
        case = validate(case_at(resolved, settings))
    except CaseError as error:
        raise NumericalFailure(str(error.problems[0].message)) from error
    problems = check_again(case, cache)
    if problems:
        raise NumericalFailure(problems[0].message)
    return case


def sign_of(goal: Objective) -> float:
    """1 where an objective is to be made small, -1 where large."""
    return 1.0 if goal.sense == "min" else -1.0


def _counts(limit: Limit) -> bool:
    return limit.at == "optimum" and limit.expect == "kept"
