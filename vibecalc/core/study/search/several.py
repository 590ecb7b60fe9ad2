"""Fronts between three and more objectives; which points are dominated, and where the knee is."""

from collections.abc import Callable, Iterator
from functools import partial
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.core.study.search.minimise import minimise
from vibecalc.core.study.search.problem import Ahead, ErrorsAt, Optimum
from vibecalc.errors import NumericalFailure

# ----------------------------------------------------------------------------
# Points of a front: which of them count, and which gives most for least.
# ----------------------------------------------------------------------------

#: objectives closer than this share of the front are the same
SAME = 1e-9
#: depth below the plane through the ends, as a share of the front, that makes a knee
_KNEE = 1e-3

Values = Callable[[np.ndarray], tuple[np.ndarray, ArrayLike]]


class FrontPoints(NamedTuple):
    """k points that no other beats in all of m objectives, all to be made small.

    `values` and `errors` (k, m), `variables` and `variables_error` (k, n). `evaluations` counts
    points evaluated, all searches together; `notes` says what was left out.
    """

    values: np.ndarray
    errors: np.ndarray
    variables: np.ndarray
    variables_error: np.ndarray
    evaluations: int
    notes: tuple[str, ...]


def undominated(values: np.ndarray) -> np.ndarray:
    """Places of points (k, m) that no other equals or beats in all objectives; of equals one.

    They come in the order of the first objective, then of the next.
    """
    near = SAME * np.maximum(np.ptp(values, axis=0), 1e-300)
    kept: list[int] = []
    for place in np.lexsort(values.T[::-1]):
        here = values[place]
        as_good = np.all(values <= here + near, axis=1)
        better = as_good & np.any(values < here - near, axis=1)
        same = any(np.all(np.abs(values[one] - here) <= near) for one in kept)
        if not np.any(better) and not same:
            kept.append(int(place))
    return np.array(kept, dtype=int)


def knee(values: np.ndarray) -> int | None:
    """The point (of k, m) deepest below the plane through the best of each objective, if any.

    In shares of the front from the best to the worst of each objective. There a little more of one
    objective costs most of the others on either side. I. Das, On characterizing the knee of the
    Pareto curve based on normal-boundary intersection, Struct. Optim. 18 (1999), 107-115.
    """
    span = np.ptp(values, axis=0)
    ends = np.argmin(values, axis=0)
    if len(values) < 3 or np.any(span <= 0.0) or len(set(ends.tolist())) < values.shape[1]:
        return None
    shares = (values - np.min(values, axis=0)) / span
    try:
        normal = np.linalg.solve(shares[ends], np.ones(values.shape[1]))
    except np.linalg.LinAlgError:
        return None
    if np.any(normal <= 0.0):
        return None
    depth = (1.0 - shares @ normal) / float(np.linalg.norm(normal))
    deepest = int(np.argmax(depth))
    return deepest if depth[deepest] > _KNEE else None


# ----------------------------------------------------------------------------
# Normal boundary intersection: evenly spread points of a front of several objectives.
# ----------------------------------------------------------------------------

#: slack of an objective, as a share of the front, where its optimum is not unique
_SLACKS = (1e-6, 1e-4)
#: how far a point of the front may lie from the plane through the ends, in shares of the front
_REACH = 3.0
#: volume between the ends below which they do not span a simplex
_FLAT = 1e-3
#: step of the slopes that carry an error of the variables over, as a share of their bounds
_STEP = 1e-6


def lattice(objectives: int, points: int) -> np.ndarray:
    """Weights (k, objectives) spread evenly over the simplex, at most `points`, at least the ends.

    All that are whole multiples of 1 / h and add up to 1 (I. Das and J. E. Dennis 1998).
    """
    found = np.eye(objectives)
    for parts in range(2, points + 1):
        finer = np.array(list(_parted(parts, objectives)), dtype=float) / parts
        if len(finer) > points:
            break
        found = finer
    return found


def _parted(parts: int, objectives: int) -> Iterator[tuple[int, ...]]:
    """All ways to part a number into as many whole ones."""
    for bars in combinations(range(parts + objectives - 1), objectives - 1):
        ends = (-1, *bars, parts + objectives - 1)
        yield tuple(ends[i + 1] - ends[i] - 1 for i in range(objectives))


def front_of_several(
    evaluate: Values,
    lower: ArrayLike,
    upper: ArrayLike,
    objectives: int,
    *,
    first: ArrayLike | None = None,
    points: int = 15,
    starts: int = 8,
    rtol: float = 1e-9,
    errors: ErrorsAt | None = None,
    period: ArrayLike = 0.0,
    ahead: Ahead | None = None,
) -> FrontPoints:
    """Points where no objective can become smaller without another growing, evenly spread.

    Parameters
    ----------
    evaluate : callable
        `evaluate(variables (n,)) -> (values (m,), margins)`, all values to be made small; points
        that cannot be evaluated as in `minimise`.
    lower, upper, first, starts, rtol, errors, period, ahead
        As of `minimise`, with errors of all objectives, then of the margins; the ends of the front
        are searched from all starts.
    objectives, points : int
        How many objectives, and how many points at most.

    Raises
    ------
    NumericalFailure
        If one of the objectives has no optimum (see `minimise`).

    Notes
    -----
    Normal boundary intersection (I. Das and J. E. Dennis, SIAM J. Optim. 8 (1998), 631-657) with
    inequalities: from points spread evenly over the simplex between the best of each objective, in
    shares of the front, a search goes as far as it can towards smaller values of all. Where two of
    these ends are one the simplex between the worst of each objective takes their place. Parts of a
    front that bulge inwards are found, too; with three and more objectives parts of its rim may lie
    beyond what these points see. Dominated points are removed.
    """
    low, high = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
    known: dict[bytes, tuple[np.ndarray, np.ndarray]] = {}
    notes: list[str] = []
    search = partial(minimise, rtol=rtol, ahead=ahead)

    def at(variables: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        key = (variables + 0.0).tobytes()
        if key not in known:
            values, margins = evaluate(variables)
            known[key] = (values, np.atleast_1d(np.asarray(margins, dtype=float)))
        return known[key]

    def off(variables: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Errors of all objectives, and of the margins."""
        if errors is None:
            return np.zeros(objectives), np.zeros(len(at(variables)[1]))
        every = errors(variables)
        return every[:objectives], every[objectives:]

    def end_of(goal: int) -> Optimum:
        def alone_off(variables: np.ndarray) -> np.ndarray:
            own, margins = off(variables)
            return np.append(own[goal], margins)

        def alone(variables: np.ndarray) -> tuple[float, np.ndarray]:
            values, margins = at(variables)
            return float(values[goal]), margins

        return search(alone, low, high, first=first, starts=starts, period=period, errors=alone_off)

    def unique(goal: int, end: Optimum, best: np.ndarray, span: np.ndarray) -> Optimum:
        """Of all points with the best of one objective nearly the best in the sum of the others."""
        others = np.arange(objectives) != goal

        def sum_of_others(variables: np.ndarray, slack: float) -> tuple[float, np.ndarray]:
            values, margins = at(variables)
            shares = (values - best) / span
            return float(np.sum(shares[others])), np.append(margins, slack - shares[goal])

        def sum_off(variables: np.ndarray) -> np.ndarray:
            own, margins = off(variables)
            shares = own / span
            return np.concatenate([[np.sum(shares[others])], margins, [shares[goal]]])

        for slack in _SLACKS:
            try:
                return search(
                    partial(sum_of_others, slack=slack),
                    low,
                    high,
                    first=end.variables,
                    starts=2,
                    period=period,
                    errors=sum_off,
                )
            except NumericalFailure:
                continue
        notes.append(f"objective {goal + 1} is at its best at many points, one of them is taken")
        return end

    ends = [end_of(goal) for goal in range(objectives)]
    table = np.array([at(end.variables)[0] for end in ends])
    best, span = np.diag(table).copy(), np.ptp(table, axis=0)
    unsure = np.max([off(end.variables)[0] for end in ends], axis=0)
    if np.all(span <= unsure + SAME * np.max(np.abs(table), axis=0)):
        notes.append("one point is the best for all objectives")
        return _as_front(at, off, ends[:1], low, high, len(known), notes)
    span = np.where(span > 0.0, span, 1.0)

    def shares_at(variables: np.ndarray) -> np.ndarray:
        return (at(variables)[0] - best) / span

    ends = [
        unique(goal, end, best, span) if end.free_directions else end
        for goal, end in enumerate(ends)
    ]
    found = list(ends)
    corners = np.array([shares_at(end.variables) for end in ends])
    whole = abs(float(np.linalg.det(corners))) > _FLAT
    turn = np.append(np.broadcast_to(np.asarray(period, dtype=float), low.shape), 0.0)
    for weights in lattice(objectives, points):
        if whole and np.max(weights) == 1.0:
            continue  # that is an end
        foot = weights @ corners if whole else weights

        def towards(moved: np.ndarray, foot: np.ndarray = foot) -> tuple[float, np.ndarray]:
            _, margins = at(moved[:-1])
            return -float(moved[-1]), np.append(margins, foot - moved[-1] - shares_at(moved[:-1]))

        def towards_off(moved: np.ndarray) -> np.ndarray:
            own, margins = off(moved[:-1])
            return np.concatenate([[0.0], margins, own / span])

        places = [one.variables[: low.size] for one in found]
        away = [float(np.linalg.norm(shares_at(one) - foot)) for one in places]
        why = ""
        for count, near in enumerate(np.argsort(away, kind="stable")[:2].tolist()):
            start = places[near]
            reached = float(np.min(foot - shares_at(start)))
            begin = np.append(start, np.clip(reached, -_REACH, _REACH))
            try:
                optimum = search(
                    towards,
                    np.append(low, -_REACH),
                    np.append(high, _REACH),
                    first=begin,
                    starts=2 * count,
                    period=turn,
                    ahead=ahead and (lambda moved: ahead(moved[:, :-1])),
                    errors=towards_off,
                )
            except NumericalFailure as failure:
                why = str(failure)
                continue
            found.append(optimum)
            break
        else:
            shown = ", ".join(f"{weight:g}" for weight in weights)
            notes.append(f"no point of the front with the weights {shown}: {why}")
    return _as_front(at, off, found, low, high, len(known), notes)


def _as_front(
    at: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]],
    off: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]],
    optima: list[Optimum],
    low: np.ndarray,
    high: np.ndarray,
    evaluations: int,
    notes: list[str],
) -> FrontPoints:
    size = low.size
    variables = np.array([one.variables[:size] for one in optima])
    away = np.array([one.variables_error[:size] for one in optima])
    values = np.array([at(one)[0] for one in variables])
    errors = np.array([off(one)[0] for one in variables]) + np.array(
        [_carried(at, one, error, low, high) for one, error in zip(variables, away, strict=True)]
    )
    kept = undominated(values)
    if len(kept) < len(values):
        notes.append(f"{len(values) - len(kept)} points were as good as others or dominated")
    return FrontPoints(
        values[kept], errors[kept], variables[kept], away[kept], evaluations, tuple(notes)
    )


def _carried(
    at: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]],
    place: np.ndarray,
    error: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
) -> np.ndarray:
    """Errors of the objectives that come from the errors of the variables."""
    here = at(place)[0]
    total = np.zeros_like(here)
    for axis in np.flatnonzero(error):
        step = max(_STEP * (high[axis] - low[axis]), float(error[axis]))
        slopes = [np.zeros_like(here)]
        for side in (-1.0, 1.0):
            nearby = place.copy()
            nearby[axis] = np.clip(nearby[axis] + side * step, low[axis], high[axis])
            if nearby[axis] != place[axis]:
                try:
                    change = np.abs(at(nearby)[0] - here)
                except NumericalFailure:
                    continue
                slopes.append(change / abs(nearby[axis] - place[axis]))
        total += float(error[axis]) * np.max(slopes, axis=0)
    return total
