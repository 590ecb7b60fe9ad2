"""A case along one of its keys, as a function that a search can call."""

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from vibecalc.case.overrides import field_unit, get_key, number_at
from vibecalc.errors import NumericalFailure, ResultError
from vibecalc.pipeline.run import run_case
from vibecalc.pipeline.stage_cache import StageCache
from vibecalc.results.select import worst
from vibecalc.study.binding import checked_case
from vibecalc.units import parse_quantity

if TYPE_CHECKING:
    from vibecalc.case.find_tables import Find
    from vibecalc.results.record import Record


class Along:
    """One [[find]] on its case: the result for a value of the key, in SI.

    Keys of `also` keep their ratio to it. `written` is the value of the key in the case. `turn` is
    the whole turn in rad that the bounds of an angle hold, whose ends are then one; else 0.
    """

    def __init__(
        self,
        search: "Find",
        resolved: Mapping[str, Any],
        cache: StageCache,
        count: Callable[[], None],
        period: float = 0.0,
    ):
        self.search = search
        self.unit = field_unit(search.key)
        self.lower = parse_quantity(search.lower, self.unit)
        self.upper = parse_quantity(search.upper, self.unit)
        # nan of a key that the case leaves out; solutions are then ordered from the middle
        self.written = number_at(resolved, search.key, math.nan)
        self.near = number_at(resolved, search.key, 0.5 * (self.lower + self.upper))
        whole = abs(self.upper - self.lower - period) <= 1e-9 * period and not search.also
        self.turn = period if whole else 0.0
        self._also = {key: float(get_key(resolved, key)) for key in search.also}
        self._resolved, self._cache, self._count = resolved, cache, count

    def evaluate(self, value: float) -> tuple[float, float]:
        """The result and its absolute error; NumericalFailure where there is none."""
        self._count()
        record = self.results(value, frozenset({self.search.quantity}))
        try:
            return self.read(record)
        except ResultError as error:  # an order that this point does not keep, say
            raise NumericalFailure(str(error)) from error

    def changed(self, value: float) -> dict[str, float]:
        """All keys that the search changes, with what it sets them to."""
        settings = {self.search.key: value}
        if self._also:
            ratio = value / self.written
            settings |= {key: ratio * written for key, written in self._also.items()}
        return settings

    def results(self, value: float, wanted: frozenset[str]) -> "Record":
        """Some results of the case with its keys changed; NumericalFailure as in a run."""
        case = checked_case(self._resolved, self.changed(value), self._cache)
        return run_case(case, wanted=wanted, cache=self._cache)

    def read(self, record: "Record") -> tuple[float, float]:
        """The result and its error from a run; of several entries the largest counts."""
        quantity = record[self.search.quantity]
        value, _ = worst(quantity, self.search.where, "max")
        return value, quantity.error_estimate
