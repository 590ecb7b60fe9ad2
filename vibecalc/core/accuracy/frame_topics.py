"""Topics of no subject: what a tolerance costs, and the searches of [[find]] and [optimisation]."""

import math
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.core.accuracy.other_searches import NEARLY_KEPT, within_budget
from vibecalc.core.accuracy.run import WHOLE_CASE
from vibecalc.core.accuracy.topic import Answer, Reference, Solver, Topic
from vibecalc.core.case.raw import NOT_COMPUTED
from vibecalc.core.run.run import StageCache, run_case
from vibecalc.core.study.binding import Binding
from vibecalc.core.study.find import Along, choose
from vibecalc.core.study.optimise import STANDARD
from vibecalc.core.study.search.methods import METHODS, find
from vibecalc.core.study.search.minimise import minimise
from vibecalc.core.study.search.problem import Box
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.units import parse_quantity

if TYPE_CHECKING:
    from vibecalc.core.case.load import LoadedCase
    from vibecalc.core.case.tables import Find
    from vibecalc.core.results.record import Quantity, Record
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# What the tolerance of a case costs: a run at each, with its true and its estimated error.
# ----------------------------------------------------------------------------

#: [accuracy] rtol of the series, and what these are held against
TOLERANCES = (1e-3, 1e-6, 1e-9)
FINEST = 1e-12

#: what a run leaves out at its tolerance: no error, but another question at each
_OF_THE_TOLERANCE = frozenset({"kinematics/dropped_acceleration"})


def whole_case_topics(case: "Case") -> list[Topic]:
    """Two topics: what a run gives, and what it says of itself, at each tolerance.

    All scalar results of a run are one vector, each over its value in the finest run. Left out are
    counts, statistics, what is unbounded, what is zero within its own estimate and what a run
    leaves out at its tolerance.
    """
    finest = run_case(_at(case, FINEST))
    truth = {
        path: float(np.abs(quantity.values))
        for path, quantity in finest.items()
        if _is_reported(quantity)
    }
    if not truth:
        return []
    own = case.accuracy.rtol
    coarser = sorted({*TOLERANCES, *([own] if own > FINEST else [])}, reverse=True)
    reference = Reference(
        np.ones(len(truth)),
        _largest_estimate(finest, truth),
        f"the run at rtol = {FINEST:g}, agreement as it estimates itself",
    )
    solver = Solver(
        name="run",
        words="the whole run of the case",
        setting="[accuracy] rtol",
        settings=tuple(coarser),
        solve=lambda rtol: Answer(_shares(run_case(_at(case, rtol)), truth), 1.0),
        default=own if own > FINEST else None,
    )
    words = f"{len(truth)} scalar results of a run, each over its value in the finest run"
    topic = Topic(
        stage=WHOLE_CASE,
        name="true error of a run",
        words=words,
        quantity="",
        unit="",
        work="runs",
        reference=lambda: reference,
        solvers=(solver,),
    )

    def estimated(rtol: float) -> Answer:
        worst = _largest_estimate(run_case(_at(case, rtol)), truth)
        return Answer(np.full(len(truth), 1.0 + worst), 1.0)

    of_itself = solver._replace(
        settings=tuple(sorted({*coarser, FINEST, own}, reverse=True)), solve=estimated, default=own
    )
    return [
        topic,
        topic._replace(
            name="error that a run estimates",
            words=f"the largest error estimate of these {len(truth)} results, as relative error",
            reference=lambda: reference._replace(agreement=0.0, words="no error at all"),
            solvers=(of_itself,),
        ),
    ]


def _at(case: "Case", rtol: float) -> "Case":
    accuracy = case.accuracy.model_copy(update={"rtol": rtol})
    return case.model_copy(update={"accuracy": accuracy})


def _is_reported(quantity: "Quantity") -> bool:
    values = quantity.values
    if quantity.path in _OF_THE_TOLERANCE:
        return False
    if quantity.axes or values.dtype.kind not in "fc" or quantity.standard_error is not None:
        return False
    size = float(np.abs(values))
    return np.isfinite(size) and size > quantity.error_estimate


def _shares(record: "Record", truth: dict[str, float]) -> np.ndarray:
    """Infinite where a run does not have the result at all."""
    return np.array(
        [
            float(np.abs(record[path].values)) / size if path in record else np.inf
            for path, size in truth.items()
        ]
    )


def _largest_estimate(record: "Record", truth: dict[str, float]) -> float:
    shares = (record[path].error_estimate / truth[path] for path in truth if path in record)
    return max(shares, default=np.inf)


# ----------------------------------------------------------------------------
# Topic of [[find]]: the value of one key that brings a wanted result, by every plain search.
# ----------------------------------------------------------------------------

_WHY = (
    "looks over the whole of the bounds first, so that no other solution is missed, and closes in "
    "from both sides for the error"
)
#: what that takes over Brent's method alone, where the bounds happen to hold one solution
_EXTRA = 4.0

#: how far a result is above what is wanted, at a value of the key
_Off = Callable[[float], float]


def find_topics(loaded: "LoadedCase") -> list[Topic]:
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
        nearby = 1e-3 * key
        low, high = max(key - nearby, along.lower), min(key + nearby, along.upper)
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
        solvers=(
            Solver("look, then Brent's method", "evenly spread points first", "points",
                   tuple(one for one in looks if one <= search.points), own, float(search.points),
                   citation="Brent (1973), chapter 4"),
            Solver("Brent's method of scipy", "between the bounds", "tolerance",
                   (1e-2, 1e-4, 1e-8, 1e-12), plain(_brent)),
            Solver("bisection", "between the bounds", "halvings", (4.0, 8.0, 16.0),
                   plain(_bisection), None, "geometric"),
            Solver("runs and a straight line", "the pair of runs around what is wanted", "runs",
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
    return choice.solution.sample.key, choice.curve.evaluations + 1


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
    from vibecalc.core.run.plan import planned_quantities

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


# ----------------------------------------------------------------------------
# Topic of [optimisation]: how near the proven optimum each search comes for its evaluations.
# ----------------------------------------------------------------------------

#: evaluations that a search may spend: a part of what the case itself would
_BUDGETS = (20.0, 40.0, 80.0)
_PLAIN = ("SLSQP", "COBYLA", "differential evolution")
#: evaluations of the search that confirms the optimum, and digits of the optimum it starts from
_CONFIRM, _DIGITS = 60, 4
#: to which a limit is kept while the optimum is confirmed
_KEPT = 1e-10
#: what the proof of the ends takes over the search of them
_REFINED = 1.5
_WHY_THE_SEARCH = (
    "searches from all the starts that the case asks for, since the global optimum rests on them, "
    "and refines their best ends until the optimum is proven"
)


class _Optimum(NamedTuple):
    """The proven optimum on the unit cube, its objective and how well another search agrees."""

    unit: np.ndarray
    objective: float
    agreement: float


def optimisation_topics(loaded: "LoadedCase") -> list[Topic]:
    """One topic for a case with [optimisation], of the shortfall and of the distance."""
    study = loaded.case.optimisation
    if study is None:
        return []
    binding = Binding(loaded)
    # bounds that leave a variable no room make it no variable
    if not np.all(binding.upper > binding.lower):
        return []
    box = Box(binding.lower, binding.upper, binding.period)
    goal, starts = study.objective.quantity, study.starts
    sign = binding.sign

    @cache
    def optimum() -> _Optimum:
        return _proven(loaded, box)

    def reference() -> Reference:
        found = optimum()
        words = f"the search of the case, refined and proven; held against SLSQP from {_DIGITS} "
        words += "digits of it, which confirms a local optimum and not that there is no better one"
        return Reference(np.array([sign * found.objective]), found.agreement, words, 0.0)

    def answer(objective: float, unit: np.ndarray, work: int) -> Answer:
        away = float(np.linalg.norm(box.apart(optimum().unit, unit)))
        return Answer(np.array([sign * objective]), float(work), away)

    solvers = [
        _default(loaded, box, answer),
        *(_bare(loaded, box, answer, name) for name in METHODS),
    ]
    solvers += [_scipy(loaded, box, answer, name) for name in _PLAIN]
    return [
        Topic(
            stage="optimisation",
            name="optimum",
            words=f"{goal} at the best point that keeps the limits, within some evaluations",
            quantity="optimisation/objective",
            unit=_unit(loaded, goal),
            work="evaluations of the case",
            reference=reference,
            solvers=tuple(solvers),
            position="distance from the optimum within bounds of 0 to 1 []",
            default_extra=_REFINED * (1.0 + starts),
            default_why=_WHY_THE_SEARCH,
        )
    ]


_Answer = Callable[[float, np.ndarray, int], Answer]


def _default(loaded: "LoadedCase", box: Box, answer: _Answer) -> Solver:
    study = loaded.case.optimisation
    assert study is not None
    method = study.method or STANDARD

    def solve(starts: float) -> Answer:
        binding = Binding(loaded)
        found = minimise(
            binding.evaluate, binding.lower, binding.upper, first=binding.first,
            starts=int(starts), rtol=loaded.case.accuracy.rtol, method=method,
            period=binding.period,
        )  # fmt: skip
        return answer(found.objective, box.unit(found.variables), found.evaluations)

    settings = sorted({1.0, 2.0, 4.0, float(study.starts)} - {0.0})
    return Solver(
        f"{METHODS[method].words}, refined", "as the case is run", "starts",
        tuple(one for one in settings if one <= study.starts), solve, float(study.starts),
        citation=METHODS[method].citation,
    )  # fmt: skip


def _bare(loaded: "LoadedCase", box: Box, answer: _Answer, name: str) -> Solver:
    method = METHODS[name]

    def solve(budget: float) -> Answer:
        binding = Binding(loaded)
        found = find(
            name, binding.evaluate, binding.lower, binding.upper,
            first=binding.first, budget=int(budget), period=binding.period,
        )  # fmt: skip
        if found.violation > NEARLY_KEPT:
            raise NumericalFailure(
                f"the point reached breaks a limit by {found.violation:.2g} of it: {found.reason}"
            )
        return answer(found.objective, box.unit(found.variables), found.evaluations)

    return Solver(
        method.words, "from the case as written, its end not refined", "evaluations",
        _BUDGETS, solve, citation=method.citation,
    )  # fmt: skip


def _scipy(loaded: "LoadedCase", box: Box, answer: _Answer, name: str) -> Solver:
    def solve(budget: float) -> Answer:
        binding = Binding(loaded)
        first = box.unit(binding.first)
        found = within_budget(
            name, lambda unit: binding.evaluate(box.values(unit)),
            [(0.0, 1.0)] * len(first), first, int(budget),
        )  # fmt: skip
        return answer(found.value, found.place, found.evaluations)

    words = f"on bounds of 0 to 1, best point met that keeps the limits to {NEARLY_KEPT:g}"
    return Solver(f"{name} of scipy", words, "evaluations", _BUDGETS, solve)


def _proven(loaded: "LoadedCase", box: Box) -> _Optimum:
    """The case's own search, and SLSQP of scipy from the optimum cut to a few digits."""
    study = loaded.case.optimisation
    assert study is not None
    binding = Binding(loaded)
    found = minimise(
        binding.evaluate, binding.lower, binding.upper, first=binding.first,
        starts=study.starts, rtol=loaded.case.accuracy.rtol, method=study.method or STANDARD,
        period=binding.period,
    )  # fmt: skip
    unit = box.unit(found.variables)
    cut = np.clip(np.round(unit, _DIGITS), 0.0, 1.0)
    again = within_budget(
        "SLSQP", lambda at: binding.evaluate(box.values(at)), [(0.0, 1.0)] * len(unit), cut,
        _CONFIRM, _KEPT,
    )  # fmt: skip
    size = abs(found.objective) or 1.0
    apart = abs(again.value - found.objective) / size
    return _Optimum(unit, found.objective, max(apart, float(found.objective_error) / size))


def _unit(loaded: "LoadedCase", goal: str) -> str:
    from vibecalc.core.run.plan import planned_quantities

    return planned_quantities(loaded.case)[goal].unit
