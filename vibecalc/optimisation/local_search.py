"""One local search by sequential quadratic programming."""

from typing import NamedTuple

import numpy as np

from vibecalc.optimisation.sampler import Values

#: forward step on the unit cube: square root of the relative noise expected of a pipeline
STEP = 1e-6
ACCURACY = 1e-7
FINE_ACCURACY = 1e-13
MOST_STEPS = 60
#: a norm below this, in scaled units, is left to the method for zeros
VANISHING = 1e-3


class End(NamedTuple):
    """Where a local search stopped, on the unit cube, and in words why."""

    unit: np.ndarray
    reason: str


class _NearZero(Exception):
    """A norm is about to vanish; its square is better for what is left."""


class _Stranded(Exception):
    """The search stands where no derivative can be formed."""


def local_search(sampler: Values, start: np.ndarray, *, to_the_end: bool = False) -> End:
    """Search downhill from a start with SLSQP until it stops, whatever the reason.

    Parameters
    ----------
    sampler : Values
    start : (n,) array
        Point of the unit cube at which the sampler gives values.
    to_the_end : bool
        Without it the search ends where it gains little, or where a norm is about to vanish.

    Notes
    -----
    Several entries of an objective become the smallest t with t >= entry, so that the corner of
    their maximum is smooth to the method. D. Kraft, A software package for sequential quadratic
    programming, DFVLR-FB 88-28 (1988), as in scipy. Points that cannot be evaluated look worse
    than all others, and the line search turns back from them.
    """
    from scipy.optimize import minimize

    accuracy = FINE_ACCURACY if to_the_end else ACCURACY
    minimax = sampler.entries > 1
    size = start.size
    best: list[np.ndarray] = [start]
    first = sampler(start)
    assert first is not None
    worst = float(np.max(first[: sampler.entries])) + 1e3

    def values(unit: np.ndarray) -> np.ndarray:
        vector = sampler(np.clip(unit, 0, 1))
        if vector is not None:
            return vector
        bad = np.full_like(first, -1.0)
        bad[: sampler.entries] = worst
        return bad

    def jacobian(unit: np.ndarray) -> np.ndarray:
        unit = np.clip(unit, 0, 1)
        centre = sampler(unit)
        if centre is None:
            raise _Stranded
        best[0] = unit
        if not to_the_end and _vanishing(sampler, centre):
            raise _NearZero
        columns = [_forward(sampler, unit, centre, axis) for axis in range(size)]
        return np.stack(columns, axis=1)

    entries = sampler.entries
    if minimax:
        point = np.append(start, np.max(first[:entries]))
        slack = np.concatenate([np.ones(entries), np.zeros(first.size - entries)])[:, None]
        sign = np.concatenate([-np.ones(entries), np.ones(first.size - entries)])
        gradient = np.append(np.zeros(size), 1.0)
        arguments = {
            "fun": lambda z: float(z[-1]),
            "jac": lambda z: gradient,
            "constraints": {
                "type": "ineq",
                "fun": lambda z: sign * values(z[:-1]) + slack[:, 0] * z[-1],
                "jac": lambda z: np.hstack([sign[:, None] * jacobian(z[:-1]), slack]),
            },
            "bounds": [(0.0, 1.0)] * size + [(None, None)],
        }
    else:
        point = start
        limits = {
            "type": "ineq",
            "fun": lambda z: values(z)[1:],
            "jac": lambda z: jacobian(z)[1:],
        }
        arguments = {
            "fun": lambda z: float(values(z)[0]),
            "jac": lambda z: jacobian(z)[0],
            "constraints": limits if first.size > 1 else (),
            "bounds": [(0.0, 1.0)] * size,
        }
    try:
        found = minimize(
            x0=point, method="SLSQP", options={"ftol": accuracy, "maxiter": MOST_STEPS}, **arguments
        )
    except _NearZero:
        return End(best[0], "near zero")
    except _Stranded:
        return End(best[0], "stopped beside points that cannot be evaluated")
    end = np.clip(found.x[:size], 0, 1)
    if not np.all(np.isfinite(end)) or sampler(end) is None:
        return End(best[0], "stopped beside points that cannot be evaluated")
    return End(end, REASONS.get(int(found.status), str(found.message).lower()))


def _vanishing(sampler: Values, vector: np.ndarray) -> bool:
    """Whether a single entry that was never negative is almost zero, with all margins kept."""
    never_negative = getattr(sampler, "smallest", -1.0) >= 0
    small = sampler.entries == 1 and 0 <= vector[0] < VANISHING
    return never_negative and small and bool(np.all(vector[1:] >= 0))


#: scipy's status of SLSQP in our words
REASONS = {
    0: "converged",
    2: "more equations than variables",
    3: "the inner problem took too long",
    4: "the limits contradict each other here",
    5: "the inner problem is singular",
    6: "the inner problem is singular",
    7: "the inner problem is rank deficient",
    8: "no descent along the last direction",
    9: f"stopped after {MOST_STEPS} steps",
}


def _forward(sampler: Values, unit: np.ndarray, centre: np.ndarray, axis: int) -> np.ndarray:
    """One column of the Jacobian, from the side that stays inside and can be evaluated."""
    for side in (1.0, -1.0) if unit[axis] < 0.5 else (-1.0, 1.0):
        step = side * STEP
        beside = unit.copy()
        beside[axis] += step
        if 0 <= beside[axis] <= 1:
            value = sampler(beside)
            if value is not None:
                return np.asarray((value - centre) / (beside[axis] - unit[axis]))
    raise _Stranded
