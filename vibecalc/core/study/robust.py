"""What an optimum over tolerances adds to its record: mean and deviation, and how well known."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.results.record import Method
from vibecalc.core.results.select import worst
from vibecalc.core.study.binding import worse_side
from vibecalc.core.study.record import Numbers, Studied
from vibecalc.core.study.scatter import Scatter, scatter_of
from vibecalc.errors import NumericalFailure

if TYPE_CHECKING:
    from vibecalc.core.study.binding import Binding

#: draws of the machines by which the error of mean and deviation is known
SCRAMBLINGS = 8
#: what is given of the objective at each point
OF_POINTS = (
    "nominal", "mean", "deviation", "value", "mean_error", "deviation_error", "value_error",
)  # fmt: skip

# ----------------------------------------------------------------------------
# Mean and deviation at the start and at the optimum, and how well the machines drawn tell them.
# ----------------------------------------------------------------------------


def add_robust(out: Studied, optimum: np.ndarray) -> None:
    """Add `optimisation/robust/...` for the case as written and the optimum (n,).

    The standard error of mean and deviation is how much they differ between independent
    scramblings of the points (A. B. Owen, SIAM J. Numer. Anal. 34 (1997), 1884-1910).
    """
    robust, goal = out.study.robust, out.study.objective
    assert robust is not None
    draws = [scatter_of(robust, draw) for draw in range(SCRAMBLINGS)]
    wanted = frozenset({goal.quantity})
    side = worse_side(goal)
    rows, names, off = [], [], 0.0
    start = out.as_written.first
    for name, at, variables in (
        ("start", out.as_written, start), ("optimum", out.binding, optimum)
    ):  # fmt: skip
        try:
            nominal = at.results(variables, wanted)[goal.quantity]
            found = [at.machines_at(variables, draw, wanted) for draw in draws]
        except NumericalFailure as failure:
            out.warn(f"no mean over tolerances at the {name}: {failure}")
            continue
        moments = [one.moments(goal.quantity, goal.where, side) for one in found]
        middles, aparts, errors = map(np.array, zip(*moments, strict=True))
        off = max(off, float(errors[0]))
        both = middles + robust.sigmas * aparts * (1.0 if side == "max" else -1.0)
        value, _ = worst(nominal, goal.where, side)
        scatter = [np.std(one, ddof=1) for one in (middles, aparts, both)]
        rows.append([value, middles[0], aparts[0], both[0], *scatter])
        names.append(name)
    if not names:
        return
    numbers: Numbers = {
        f"robust/{key}": (list(column), 0.0 if key.endswith("_error") else off)
        for key, column in zip(OF_POINTS, zip(*rows, strict=True), strict=True)
    }
    numbers["robust/samples"] = (robust.samples, 0.0)
    if out.binding.limits:
        numbers |= _of_limits(out.binding, optimum, draws[0])
    out.add(numbers, point=np.array(names, dtype=object))
    out.record.methods.append(
        Method(
            name=f"the same {robust.samples} scrambled Sobol points for all candidates",
            purpose="mean and deviation over tolerances",
            citation="Owen 1997, SIAM J. Numer. Anal. 34, 1884-1910",
        )
    )


def _of_limits(binding: "Binding", variables: np.ndarray, scatter: Scatter) -> Numbers:
    """Margins without tolerances, their mean and their deviation over the machines."""
    wanted = frozenset(limit.quantity for limit in binding.limits)
    nominal = binding.results(variables, wanted)
    found = binding.machines_at(variables, scatter, wanted)
    rows, off = [], 0.0
    for limit, bound in binding.held():
        value, _ = worst(nominal[limit.quantity], limit.where, bound.side)
        middle, apart, error = found.moments(limit.quantity, limit.where, bound.side)
        margins = (bound.left(value), bound.left(middle), apart)
        rows.append([bound.scaled(one) for one in margins])
        off = max(off, bound.scaled(error))
    return {
        f"robust/margin_{name}": (list(column), off)
        for name, column in zip(
            ("nominal", "mean", "deviation"), zip(*rows, strict=True), strict=True
        )
    }
