"""What an optimum over tolerances adds to its record: mean and deviation, and how well known."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.results.record import Method
from vibecalc.core.results.select import worst
from vibecalc.core.study.record import Numbers, add_numbers
from vibecalc.core.study.scatter import Scatter, scatter_of
from vibecalc.errors import NumericalFailure

if TYPE_CHECKING:
    from vibecalc.core.results.record import Record
    from vibecalc.core.study.binding import Binding
    from vibecalc.schema import Case

#: draws of the machines by which the error of mean and deviation is known
SCRAMBLINGS = 8
#: what is given of the objective at each point
OF_POINTS = (
    "nominal", "mean", "deviation", "value", "mean_error", "deviation_error", "value_error",
)  # fmt: skip

# ----------------------------------------------------------------------------
# Mean and deviation at the start and at the optimum, and how well the machines drawn tell them.
# ----------------------------------------------------------------------------


def add_robust(
    record: "Record",
    case: "Case",
    points: Mapping[str, tuple["Binding", np.ndarray]],
) -> None:
    """Add `optimisation/robust/...` for some points by name, the optimum last.

    The standard error of mean and deviation is how much they differ between independent
    scramblings of the points (A. B. Owen, SIAM J. Numer. Anal. 34 (1997), 1884-1910).
    """
    study = case.optimisation
    assert study is not None and study.robust is not None
    draws = [scatter_of(study.robust, draw) for draw in range(SCRAMBLINGS)]
    goal, side = study.objective, "max" if study.objective.sense == "min" else "min"
    rows: dict[str, list[float]] = {name: [] for name in OF_POINTS}
    names, off = [], 0.0
    for name, (binding, variables) in points.items():
        try:
            nominal = binding.results(variables, frozenset({goal.quantity}))
            value, _ = worst(nominal[goal.quantity], goal.where, "max" if side == "max" else "min")
            moments = [
                binding.machines_at(variables, draw, frozenset({goal.quantity}))
                .spread(goal.quantity, goal.where, side)
                .moments()
                for draw in draws
            ]
        except NumericalFailure as failure:
            record.warnings.append(f"no mean over tolerances at the {name}: {failure}")
            continue
        middles, aparts, errors = map(np.array, zip(*moments, strict=True))
        off = max(off, float(errors[0]))
        more = study.robust.sigmas * aparts * (1.0 if side == "max" else -1.0)
        for key, one in zip(
            OF_POINTS,
            (
                value, middles[0], aparts[0], middles[0] + more[0],
                np.std(middles, ddof=1), np.std(aparts, ddof=1), np.std(middles + more, ddof=1),
            ),
            strict=True,
        ):  # fmt: skip
            rows[key].append(float(one))
        names.append(name)
    if not names:
        return
    exact = ("mean_error", "deviation_error", "value_error")
    numbers: Numbers = {
        f"robust/{key}": (row, 0.0 if key in exact else off) for key, row in rows.items()
    }
    numbers["robust/samples"] = (study.robust.samples, 0.0)
    axes = {"point": np.array(names, dtype=object)}
    binding, variables = list(points.values())[-1]
    if binding.limits:
        add_limits(binding, variables, draws[0], numbers)
        axes["limit"] = np.array(binding.margin_names(), dtype=object)
    add_numbers(record, case, numbers, axes)
    record.methods.append(
        Method(
            name=f"the same {study.robust.samples} scrambled Sobol points for all candidates",
            purpose="mean and deviation over tolerances",
            citation="Owen 1997, SIAM J. Numer. Anal. 34, 1884-1910",
        )
    )


def add_limits(
    binding: "Binding", variables: np.ndarray, scatter: Scatter, numbers: Numbers
) -> None:
    """Margins without tolerances, their mean and their deviation over the machines."""
    wanted = frozenset(limit.quantity for limit in binding.limits)
    nominal = binding.results(variables, wanted)
    found = binding.machines_at(variables, scatter, wanted)
    rows, off = [], 0.0
    for limit, bound in binding.held():
        value, _ = worst(nominal[limit.quantity], limit.where, bound.side)
        middle, apart, error = found.spread(limit.quantity, limit.where, bound.side).moments()
        margins = (bound.left(value), bound.left(middle), apart)
        rows.append([bound.scaled(one) for one in margins])
        off = max(off, bound.scaled(error))
    for name, row in zip(("nominal", "mean", "deviation"), zip(*rows, strict=True), strict=True):
        numbers[f"robust/margin_{name}"] = (list(row), off)
