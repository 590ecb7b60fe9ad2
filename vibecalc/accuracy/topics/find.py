"""Topic of [[find]]: the value of one key that brings a wanted result, by every plain search."""

import math
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.accuracy.topic import Answer, Ladder, Reference, Topic
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.pipeline.stage_cache import StageCache
from vibecalc.study.find_along import Along
from vibecalc.study.find_choice import choose
from vibecalc.study.sweep.place import NOT_COMPUTED
from vibecalc.units import parse_quantity

if TYPE_CHECKING:
    from vibecalc.case.find_tables import Find
    from vibecalc.case.load import LoadedCase

_WHY = (
    "looks over the whole of the bounds first, so that no other solution is missed, and closes in "
    "from both sides for the error"
)
#: what that takes over Brent's method alone, where the bounds happen to hold one solution
_EXTRA = 4.0

#: how far a result is above what is wanted, at a value of the key
_Off = Callable[[float], float]


def study_topics(loaded: "LoadedCase") -> list[Topic]:
    """The first search of the case for a wanted value; none where all seek extremes."""
    searches = [search for search in loaded.case.find if search.seek is None]
    return [_topic(loaded, searches[0])] if searches else []


def _topic(loaded: "LoadedCase", search: "Find") -> Topic:
    along = _along(loaded, search)
    unit = along.unit

    @cache
    def wanted() -> float:
        return _wanted(loaded, search)

    def counted() -> tuple[_Off, list[float]]:
        """A fresh function of the key, and what it was asked; the result as written counts."""
        fresh, asked = _along(loaded, search), [along.written]

        def off(key: float) -> float:
            asked.append(key)
            return fresh.evaluate(key)[0] - wanted()

        return off, asked

    def plain(way: Callable[[_Off, float, float, float], float]) -> Callable[[float], Answer]:
        def solve(setting: float) -> Answer:
            off, asked = counted()
            key = way(off, along.lower, along.upper, setting)
            return Answer(np.array([key]), float(len(asked)))

        return solve

    def own(points: float) -> Answer:
        key, work = _own(loaded, search, int(points))
        return Answer(np.array([key]), float(work))

    @cache
    def reference() -> Reference:
        key, _ = _own(loaded, search, search.points)
        off, _ = counted()
        beside = 1e-3 * key
        low, high = max(key - beside, along.lower), min(key + beside, along.upper)
        again = _brent(off, low, high, 1e-14)
        apart = abs(again / key - 1.0)
        words = "the search of the case; held against Brent's method of scipy around it, which "
        words += "confirms this solution and not that there is no other"
        return Reference(np.array([key]), max(apart, UNIT_ROUNDOFF), words)

    looks = sorted({5.0, 9.0, float(search.points)})
    return Topic(
        stage="find",
        name=search.name,
        words=f"{search.key} that brings {search.quantity} to what is wanted",
        quantity=f"find/{search.name}/value",
        unit=unit,
        work="evaluations of the case",
        reference=reference,
        ladders=(
            Ladder("look, then Brent's method", "evenly spread points first", "points",
                   tuple(one for one in looks if one <= search.points), own, float(search.points),
                   citation="Brent (1973), chapter 4"),
            Ladder("Brent's method of scipy", "between the bounds", "tolerance",
                   (1e-2, 1e-4, 1e-8, 1e-12), plain(_brent)),
            Ladder("bisection", "between the bounds", "halvings", (4.0, 8.0, 16.0),
                   plain(_bisection), None, "geometric"),
            Ladder("runs and a straight line", "the pair of runs around what is wanted", "runs",
                   (4.0, 6.0, 9.0, 13.0), plain(_line), None, "order 2",
                   "as read off runs by Herold (1977), section 6.6"),
        ),
        default_extra=_EXTRA,
        default_why=_WHY,
    )  # fmt: skip


def _along(loaded: "LoadedCase", search: "Find") -> Along:
    """The case along the key, with nothing remembered."""
    resolved = {key: part for key, part in loaded.resolved.items() if key not in NOT_COMPUTED}
    return Along(search, resolved, StageCache(), lambda: None)


def _own(loaded: "LoadedCase", search: "Find", points: int) -> tuple[float, int]:
    """The solution that the case names, with another first look, and evaluations."""
    along = _along(loaded, search.model_copy(update={"points": points}))
    as_written = along.evaluate(along.written)
    choice = choose(along, as_written, _goal_unit(loaded, search))
    return choice.solution.sample.key, choice.course.evaluations + 1


def _wanted(loaded: "LoadedCase", search: "Find") -> float:
    """The result wanted, in the unit of the results."""
    along, unit = _along(loaded, search), _goal_unit(loaded, search)
    value, _ = along.evaluate(along.written)
    if search.target is not None:
        return parse_quantity(search.target, unit)
    if search.change is None:
        raise ValueError("the search does not say what is wanted")
    return value + parse_quantity(search.change, unit)


def _goal_unit(loaded: "LoadedCase", search: "Find") -> str:
    from vibecalc.pipeline.plan import planned_quantities

    return planned_quantities(loaded.case)[search.quantity].unit


def _brent(off: _Off, low: float, high: float, tolerance: float) -> float:
    from scipy.optimize import brentq

    at_low, at_high = off(low), off(high)
    if at_low * at_high > 0.0:
        raise NumericalFailure("both bounds are on the same side of what is wanted")
    known = {low: at_low, high: at_high}
    return float(
        brentq(
            lambda key: known[key] if key in known else off(key), low, high,
            xtol=tolerance * abs(high), rtol=max(tolerance, 4.0 * np.finfo(float).eps),
        )
    )  # fmt: skip


def _bisection(off: _Off, low: float, high: float, halvings: float) -> float:
    at_low = off(low)
    if at_low * off(high) > 0.0:
        raise NumericalFailure("both bounds are on the same side of what is wanted")
    for _ in range(int(halvings)):
        middle = 0.5 * (low + high)
        if off(middle) * at_low > 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def _line(off: _Off, low: float, high: float, runs: float) -> float:
    """Runs at equal ratios (equal steps where a bound is not positive), a line between two."""
    count = int(runs)
    if low > 0.0:
        keys = np.exp(np.linspace(math.log(low), math.log(high), count))
    else:
        keys = np.linspace(low, high, count)
    values = np.array([off(float(key)) for key in keys])
    turns = np.flatnonzero(values[1:] * values[:-1] <= 0.0)
    if not len(turns):
        raise NumericalFailure(f"none of {count} runs is on the other side of what is wanted")
    at = int(turns[0])
    share = values[at] / (values[at] - values[at + 1])
    return float(keys[at] + share * (keys[at + 1] - keys[at]))
