"""Questions of no subject: what a tolerance costs, searches of [[find]] and [optimisation]."""

import time
from functools import cache

import numpy as np

from vibecalc.core.accuracy.kinds import Counted, Limited, Optimal, of_kind, optimum, plain_way
from vibecalc.core.accuracy.run import LONGEST
from vibecalc.core.accuracy.topic import Answer, Ask, Reference, Solver, Topic
from vibecalc.core.case.load import LoadedCase
from vibecalc.core.results.record import Quantity, Record
from vibecalc.core.run.run import StageCache, run_case
from vibecalc.core.study.binding import Binding
from vibecalc.core.study.find import Along
from vibecalc.core.study.search.minimise import minimise
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF

#: [accuracy] rtol of the series, and what these are held against
TOLERANCES = (1e-3, 1e-6, 1e-9)
FINEST = 1e-12
#: evaluations of a search from one start, about
_EVALUATIONS = 50
#: what a run leaves out at its tolerance: no error, but another question at each
_OF_THE_TOLERANCE = frozenset({"kinematics/dropped_acceleration"})


def whole_case_topics(loaded: LoadedCase) -> list[Topic]:
    """What a run gives, and what it says of itself, at each tolerance.

    All scalar results are one vector, each over its value in the finest run. Left out are counts,
    statistics, what is unbounded, zero within its own estimate or left out at the tolerance.
    """
    case, own = loaded.case, loaded.case.accuracy.rtol

    def run(rtol: float) -> Record:
        accuracy = case.accuracy.model_copy(update={"rtol": rtol})
        return run_case(case.model_copy(update={"accuracy": accuracy}))

    finest = run(FINEST)
    truth = {path: float(np.abs(one.values)) for path, one in finest.items() if _is_reported(one)}
    if not truth:
        return []

    def worst(record: Record) -> float:
        shares = (record[path].error_estimate / truth[path] for path in truth if path in record)
        return max(shares, default=np.inf)

    def shares(rtol: float) -> Answer:
        record = run(rtol)
        each = [float(np.abs(record[path].values)) / size if path in record else np.inf
                for path, size in truth.items()]  # fmt: skip
        return Answer(np.array(each), 1.0)

    def estimated(rtol: float) -> Answer:
        return Answer(np.full(len(truth), 1.0 + worst(run(rtol))), 1.0)

    words = f"the run at rtol = {FINEST:g}, with its own error estimate"
    exact, ones = Reference(np.ones(len(truth)), 0.0, "zero error"), np.ones(len(truth))
    solver = Solver("run", shares, "[accuracy] rtol", TOLERANCES, own if own > FINEST else None)
    claims = solver._replace(solve=estimated, settings=(*TOLERANCES, FINEST), default=own)
    said = f"{len(truth)} scalar results, "
    of_finest = Ask("true error of a run", said + "each relative to that of the finest run", "")
    of_estimate = Ask("error that a run estimates", said + "largest relative error estimate", "")
    return [
        Topic(of_finest, "runs", lambda: Reference(ones, worst(finest), words), [solver]),
        Topic(of_estimate, "runs", lambda: exact, [claims]),
    ]


def _is_reported(quantity: Quantity) -> bool:
    values = quantity.values
    if quantity.path in _OF_THE_TOLERANCE or quantity.standard_error is not None:
        return False
    if quantity.axes or values.dtype.kind not in "fc":
        return False
    return bool(quantity.error_estimate < np.abs(values) < np.inf)


def find_topics(loaded: LoadedCase) -> list[Topic]:
    """The first search of the case for a wanted value; none where all seek extremes."""
    searches = [search for search in loaded.case.find if search.sense is None]
    if not searches:
        return []
    search = searches[0]

    def along(points: int = search.points) -> Along:
        """The case along the key, with nothing remembered."""
        asked = search.model_copy(update={"points": points})
        return Along(asked, loaded, StageCache(), lambda _: None)

    def chosen(points: float) -> Along:
        curve = along(int(points))
        curve.choose(curve.evaluate(curve.written))
        return curve

    def own(points: float) -> Answer:
        found = chosen(points)
        return Answer(found.solutions[0].sample.key, float(found.curve.evaluations + 1))

    ours = cache(lambda: chosen(search.points))
    low, high = along().lower, along().upper

    def brent(tolerance: float, low: float = low, high: float = high) -> Answer:
        from scipy.optimize import brentq

        curve, level = along(), ours().level
        assert level is not None
        off = Counted(lambda key: curve.evaluate(key)[0] - level.wanted)
        try:
            key = brentq(off, low, high, xtol=tolerance * abs(high), rtol=max(tolerance, 1e-15))
        except ValueError as error:
            raise NumericalFailure(f"no root is known between the bounds: {error}") from error
        return Answer(float(key), float(off.asked + 1))

    def reference() -> Reference:
        key = ours().solutions[0].sample.key
        again = brent(1e-14, max(key * (1.0 - 1e-3), low), min(key * (1.0 + 1e-3), high)).values
        words = "ours; Brent's method of scipy around it confirms it, not that there is no other"
        return Reference(key, max(abs(again / key - 1.0), UNIT_ROUNDOFF), words)

    ask = Ask(search.name, f"{search.key} that brings {search.quantity} to what is wanted",
              f"find/{search.name}/value", 4.0,
              "samples all of the bounds first, for other solutions")  # fmt: skip
    counts = [points for points in (5, 9) if points <= search.points]
    solvers = (
        Solver("samples, then Brent's method", own, "points", counts, search.points),
        plain_way("scipy brentq", brent, "tolerance", (1e-2, 1e-4, 1e-8, 1e-12)),
    )
    return [Topic(of_kind("optimum", ask), "evaluations of the case", reference, solvers)]


def optimisation_topics(loaded: LoadedCase) -> list[Topic]:
    """The optimum of a case with [optimisation], within some evaluations."""
    study = loaded.case.optimisation
    if study is None:
        return []
    first = Binding(loaded)
    # what is picked is no problem of a method, nor are bounds that leave a variable no room
    if first.choices or study.robust or not np.all(first.upper > first.lower):
        return []
    box, goal = first.problem().box, study.objective.quantity
    begin, began = box.unit(first.first), time.process_time()
    Binding(loaded).evaluate(0.999 * first.first + 0.001 * first.upper)
    took = (time.process_time() - began) * _EVALUATIONS * (1.0 + study.starts)
    if took > LONGEST:
        raise NumericalFailure(f"the search would take about {took:.0f} s")

    def search(starts: float) -> Optimal:
        problem, rtol = Binding(loaded).problem(), loaded.case.accuracy.rtol
        found = minimise(problem, int(starts), rtol=rtol)
        error, work = float(found.objective_error), float(found.evaluations)
        return Optimal(box.unit(found.variables), found.objective, error, work)

    def problem() -> Limited:
        binding = Binding(loaded)
        return lambda unit: binding.worst(box.values(unit))

    budgets = (20, 40, 80)
    ask = Ask("optimum", f"{goal} at the best point that keeps the limits",
              "optimisation/objective", 1.5 * (1.0 + study.starts),
              "the global optimum rests on all its starts, whose best ends are proven")  # fmt: skip
    starts = [one for one in (1, 2, 4) if one <= study.starts]
    words = "sequential quadratic programming, refined"
    ours = Solver(words, search, "starts", starts, study.starts)
    return [optimum(
        ask, ours, problem, [(0.0, 1.0)] * len(begin), begin, budgets,
        ("SLSQP", "COBYLA", "differential evolution"), "evaluations of the case",
        sign=first.sign,
    )]  # fmt: skip
