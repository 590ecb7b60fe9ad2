"""Questions of no subject: what a tolerance costs, searches of [[find]] and [optimisation]."""

import time
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.accuracy.kinds import (
    Ask,
    Limited,
    optimum,
    ours,
    wanted_value,
)
from vibecalc.core.accuracy.run import LONGEST, WHOLE_CASE
from vibecalc.core.accuracy.topic import Answer, Reference, Topic
from vibecalc.core.run.plan import planned_quantities
from vibecalc.core.run.run import StageCache, run_case
from vibecalc.core.study.binding import Binding
from vibecalc.core.study.find import Along
from vibecalc.core.study.search.minimise import minimise
from vibecalc.errors import NumericalFailure
from vibecalc.units import parse_quantity

if TYPE_CHECKING:
    from vibecalc.core.case.load import LoadedCase
    from vibecalc.core.case.study_tables import Find
    from vibecalc.core.results.record import Quantity, Record
    from vibecalc.schema import Case

#: [accuracy] rtol of the series, and what these are held against
TOLERANCES = (1e-3, 1e-6, 1e-9)
FINEST = 1e-12
#: evaluations of a search from one start, about
_EVALUATIONS = 50
#: what a run leaves out at its tolerance: no error, but another question at each
_OF_THE_TOLERANCE = frozenset({"kinematics/dropped_acceleration"})


def whole_case_topics(case: "Case") -> list[Topic]:
    """What a run gives, and what it says of itself, at each tolerance.

    All scalar results are one vector, each over its value in the finest run. Left out are counts,
    statistics, what is unbounded, zero within its own estimate or left out at the tolerance.
    """

    def run(rtol: float) -> "Record":
        accuracy = case.accuracy.model_copy(update={"rtol": rtol})
        return run_case(case.model_copy(update={"accuracy": accuracy}))

    finest, own = run(FINEST), case.accuracy.rtol
    truth = {path: float(np.abs(one.values)) for path, one in finest.items() if _is_reported(one)}
    if not truth:
        return []

    def worst(record: "Record") -> float:
        shares = (record[path].error_estimate / truth[path] for path in truth if path in record)
        return max(shares, default=np.inf)

    def shares(rtol: float) -> Answer:
        record = run(rtol)
        each = [float(np.abs(record[path].values)) / size if path in record else np.inf
                for path, size in truth.items()]  # fmt: skip
        return Answer(np.array(each), 1.0)

    def estimated(rtol: float) -> Answer:
        return Answer(np.full(len(truth), 1.0 + worst(run(rtol))), 1.0)

    words = f"{len(truth)} scalar results"
    reference = Reference(
        np.ones(len(truth)), worst(finest), f"the run at rtol = {FINEST:g}, agreement as it says"
    )

    def topic(name: str, said: str, solve: Callable[[float], Answer], more: tuple[float, ...],
              reference: Reference) -> Topic:  # fmt: skip
        default = own if own > FINEST or more else None
        solver = ours("run", "the whole run of the case", solve, "[accuracy] rtol",
                      (*TOLERANCES, *more), default, falling=True)  # fmt: skip
        return Topic(
            WHOLE_CASE, name, f"{words}, {said}", "", "", "runs", lambda: reference, (solver,)
        )

    return [
        topic("true error of a run", "each over that of the finest run", shares, (), reference),
        topic("error that a run estimates", "the largest estimate, as relative error", estimated,
              (FINEST,), reference._replace(agreement=0.0, words="no error at all")),
    ]  # fmt: skip


def _is_reported(quantity: "Quantity") -> bool:
    values = quantity.values
    if quantity.path in _OF_THE_TOLERANCE:
        return False
    if quantity.axes or values.dtype.kind not in "fc" or quantity.standard_error is not None:
        return False
    size = float(np.abs(values))
    return np.isfinite(size) and size > quantity.error_estimate


def find_topics(loaded: "LoadedCase") -> list[Topic]:
    """The first search of the case for a wanted value; none where all seek extremes."""
    searches = [search for search in loaded.case.find if search.seek is None]
    if not searches:
        return []
    search = searches[0]
    goal = planned_quantities(loaded.case)[search.quantity].unit

    def along(one: "Find") -> Along:
        """The case along the key, with nothing remembered."""
        return Along(one, loaded, StageCache(), lambda _: None)

    @cache
    def wanted() -> float:
        if search.target is not None:
            return parse_quantity(search.target, goal)
        curve = along(search)
        return curve.evaluate(curve.written)[0] + parse_quantity(str(search.change), goal)

    def own(points: float) -> Answer:
        curve = along(search.model_copy(update={"points": int(points)}))
        curve.choose(curve.evaluate(curve.written))
        key = curve.solutions[0].sample.key
        return Answer(np.array([key]), float(curve.curve.evaluations + 1))

    def fresh() -> Callable[[float], float]:
        curve = along(search)
        return lambda key: curve.evaluate(key)[0] - wanted()

    one = along(search)
    ask = Ask("find", search.name, f"{search.key} that brings {search.quantity} to what is wanted",
              f"find/{search.name}/value", one.unit, 4.0,
              "samples all of the bounds first, for other solutions")  # fmt: skip
    counts = [points for points in (5, 9) if points <= search.points]
    solver = ours("samples, then Brent's method", "evenly spread points first", own, "points",
                  counts, search.points, citation="Brent (1973), chapter 4")  # fmt: skip
    return [wanted_value(ask, [solver], fresh, one.lower, one.upper,
                         lambda: float(own(search.points).values[0]), 1)]  # fmt: skip


def optimisation_topics(loaded: "LoadedCase") -> list[Topic]:
    """The optimum of a case with [optimisation], within some evaluations."""
    study = loaded.case.optimisation
    if study is None:
        return []
    first = Binding(loaded)
    # what is picked is no problem of a method, nor are bounds that leave a variable no room
    if first.choices or study.robust or not np.all(first.upper > first.lower):
        return []
    box, goal = first.problem().box, study.objective.quantity

    asked, began = Binding(loaded), time.process_time()
    asked.evaluate(0.999 * first.first + 0.001 * first.upper)
    took = (time.process_time() - began) * _EVALUATIONS * (1.0 + study.starts)
    if took > LONGEST:
        raise NumericalFailure(f"the search would take about {took:.0f} s")

    @cache
    def run(starts: int) -> tuple[np.ndarray, float, float, int, float]:
        binding, began = Binding(loaded), time.process_time()
        found = minimise(binding.problem(), starts, rtol=loaded.case.accuracy.rtol)
        place, error = box.unit(found.variables), float(found.objective_error)
        seconds = time.process_time() - began
        return place, found.objective, error, found.evaluations, seconds

    def own(starts: float) -> Answer:
        _, objective, _, work, seconds = run(int(starts))
        return Answer(np.array([first.sign * objective]), float(work), None, seconds)

    def problem() -> Limited:
        binding = Binding(loaded)
        return lambda unit: binding.worst(box.values(unit))

    budgets = (20, 40, 80)
    ask = Ask("optimisation", "optimum", f"{goal} at the best point that keeps the limits",
              "optimisation/objective", planned_quantities(loaded.case)[goal].unit,
              1.5 * (1.0 + study.starts),
              "the global optimum rests on all its starts, whose best ends are proven")  # fmt: skip
    starts = [one for one in (1, 2, 4) if one <= study.starts]
    solver = ours("sequential quadratic programming, refined", "as the case is run", own, "starts",
                  starts, study.starts, citation="Kraft 1988, DFVLR-FB 88-28; Nocedal and Wright, "
                  "Numerical Optimization, 2nd ed. 2006, ch. 12 and 18")  # fmt: skip
    begin = box.unit(first.first)
    return [optimum(
        ask, [solver], problem, [(0.0, 1.0)] * len(begin), begin, lambda value: first.sign * value,
        lambda: run(study.starts)[:3], budgets, ("SLSQP", "COBYLA", "differential evolution"),
        "evaluations of the case",
    )]  # fmt: skip
