"""What an optimum over tolerances adds to its record: mean and deviation, and how well known."""

import numpy as np

from vibecalc.core.results.record import Method
from vibecalc.core.results.select import worst
from vibecalc.core.study.binding import worse_side
from vibecalc.core.study.record import Numbers, Studied
from vibecalc.core.study.scatter import scatter_of
from vibecalc.errors import NumericalFailure

#: draws of the machines by which the error of mean and deviation is known
SCRAMBLINGS = 8
#: what is given of the objective at each point, and of each limit at the optimum
OF_POINTS = (
    "nominal", "mean", "deviation", "value", "mean_error", "deviation_error", "value_error",
)  # fmt: skip
OF_LIMITS = ("margin_nominal", "margin_mean", "margin_deviation")


def add_robust(out: Studied, optimum: np.ndarray) -> None:
    """Add `optimisation/robust/...` for the case as written and the optimum (n,).

    The standard error of mean and deviation is how much they differ between independent
    scramblings of the points (A. B. Owen, SIAM J. Numer. Anal. 34 (1997), 1884-1910).
    """
    robust, goal = out.study.robust, out.study.objective
    assert robust is not None
    draws = [scatter_of(robust, draw) for draw in range(SCRAMBLINGS)]
    wanted = frozenset({goal.quantity, *(limit.quantity for limit, _ in out.binding.held)})
    side = worse_side(goal)
    more = robust.sigmas * (1.0 if side == "max" else -1.0)
    rows: dict[str, tuple[float, ...]] = {}
    margins: list[tuple[float, ...]] = []
    off, margin_off = 0.0, 0.0
    places = ("start", out.as_written, out.as_written.first), ("optimum", out.binding, optimum)
    for name, at, variables in places:
        try:
            nominal = at.results(variables, wanted)
            found = [at.machines_at(variables, draw, wanted) for draw in draws]
        except NumericalFailure as failure:
            out.warn(f"no mean over tolerances at the {name}: {failure}")
            continue
        table = np.array([one.moments(goal.quantity, goal.where, side) for one in found])
        both = np.column_stack([table[:, :2], table[:, 0] + more * table[:, 1]])
        value, _ = worst(nominal[goal.quantity], goal.where, side)
        rows[name] = (value, *both[0], *np.std(both, axis=0, ddof=1))
        off = max(off, float(table[0, 2]))
        for limit, bound in out.binding.held if name == "optimum" else ():
            value, _ = worst(nominal[limit.quantity], limit.where, bound.side)
            middle, apart, error = found[0].moments(limit.quantity, limit.where, bound.side)
            left = bound.left(value), bound.left(middle), apart
            margins.append(tuple(bound.scaled(one) for one in left))
            margin_off = max(margin_off, bound.scaled(error))
    if not rows:
        return
    numbers: Numbers = {"robust/samples": (robust.samples, 0.0)}
    for key, column in zip(OF_POINTS, np.array([*rows.values()]).T, strict=True):
        numbers[f"robust/{key}"] = (column, 0.0 if key.endswith("_error") else off)
    for key, column in zip(OF_LIMITS, np.array(margins).T, strict=bool(margins)):
        numbers[f"robust/{key}"] = (column, margin_off)
    out.add(numbers, point=np.array([*rows], dtype=object))
    out.record.methods.append(
        Method(
            name=f"the same {robust.samples} scrambled Sobol points for all candidates",
            purpose="mean and deviation over tolerances",
            citation="Owen 1997, SIAM J. Numer. Anal. 34, 1884-1910",
        )
    )
