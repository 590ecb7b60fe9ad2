"""Fronts between several objectives; which points are dominated, and where the knee is."""

from contextlib import suppress
from dataclasses import replace
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.core.study.search.minimise import minimise
from vibecalc.core.study.search.problem import Optimum, Problem
from vibecalc.errors import NumericalFailure

# ----------------------------------------------------------------------------
# Points of a front: which of them count, and which gives most for least.
# ----------------------------------------------------------------------------

#: objectives closer than this share of the front are the same
SAME = 1e-9
#: depth below the plane through the ends, as a share of the front, that makes a knee
_KNEE = 1e-3


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
    notes: list[str]


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
# Optima with some objectives bounded, each searched from its neighbours.
# ----------------------------------------------------------------------------

#: slack of an objective, as a share of the front, where its optimum is not unique
_SLACKS = (1e-6, 1e-5, 1e-4, 1e-3)
#: volume between the ends below which they do not span a simplex
_FLAT = 1e-3
#: step of the slopes that carry an error of the variables over, as a share of their bounds
_STEP = 1e-6


class _Point(NamedTuple):
    """Variables (n,) and objectives (m,) with their errors."""

    variables: np.ndarray
    variables_error: np.ndarray
    values: np.ndarray
    errors: np.ndarray


class _Tracer:
    """Searches on shares of the front: of each objective from its best, 0, to its worst, 1."""

    def __init__(self, problem: Problem, objectives: int, rtol: float):
        self.problem, self.rtol = problem, rtol
        self.best, self.span = np.zeros(objectives), np.ones(objectives)
        self.known: dict[bytes, tuple[list[np.ndarray], list[Any], np.ndarray]] = {}
        self.notes: list[str] = []

    def at(self, variables: np.ndarray) -> tuple[list[np.ndarray], list[Any], np.ndarray]:
        """Parts of all objectives, the margins, and the errors of both, 0 where not known."""
        key = (variables + 0.0).tobytes()
        if key not in self.known:
            goals, margins, *errors = self.problem.evaluate(variables)
            off = errors[0] if errors else np.zeros(len(goals) + len(margins))
            self.known[key] = [np.ravel(one) for one in goals], list(margins), np.array(off)
        return self.known[key]

    def values(self, variables: np.ndarray) -> np.ndarray:
        """All objectives (m,)."""
        return np.array([np.max(parts) for parts in self.at(variables)[0]])

    def least(
        self,
        goals: list[int],
        bound: tuple[int, float] | None = None,
        first: ArrayLike | None = None,
        starts: int = 0,
        foot: np.ndarray | None = None,
    ) -> Optimum:
        """The optimum of the sum of some objectives, one of which may be bounded by a share; or how
        far all can come below a `foot` (m,)."""
        count = self.span.size

        def evaluate(variables: np.ndarray) -> tuple[Any, list[Any], np.ndarray]:
            parts, margins, errors = self.at(variables)
            shares = [one / span for one, span in zip(parts, self.span, strict=True)]
            off, more = errors[:count] / self.span, errors[count:]
            if bound is not None:
                goal, share = bound
                most, of = self.best[goal] / self.span[goal] + share, shares[goal]
                # smooth where a norm vanishes just below its bound
                left = most * abs(most) - of * np.abs(of)
                margins = [*margins, left / max(abs(most), share)]
                more = np.append(more, 2.0 * off[goal])
            if foot is not None:
                below = [one - at for one, at in zip(shares, foot, strict=True)]
                return np.concatenate(below), margins, np.append(np.max(off), more)
            whole = shares[goals[0]] if len(goals) == 1 else sum(np.max(shares[g]) for g in goals)
            return whole, margins, np.append(np.sum(off[goals]), more)

        asked = replace(self.problem, evaluate=evaluate, first=first)
        return minimise(asked, starts, rtol=self.rtol)

    def described(self, optimum: Optimum, goal: int | None = None) -> _Point:
        """A point of the front; of its objectives one may be that of the optimum.

        Errors of the others are their own, and those of the variables by their slopes.
        """
        place, away, box = optimum.variables, optimum.variables_error, self.problem.box
        here, errors = self.values(place), self.at(place)[2][: self.span.size].copy()
        axes = np.flatnonzero(away)
        steps = np.maximum(_STEP * (box.upper - box.lower), away)
        sides = np.diag(steps)[axes]
        near = np.clip(place + np.stack([-sides, sides]), box.lower, box.upper)
        if self.problem.ahead is not None and axes.size:
            self.problem.ahead(near.reshape(-1, place.size))
        for which, axis in enumerate(axes):
            slopes = [np.zeros_like(here)]
            for moved in near[:, which]:
                with suppress(NumericalFailure):
                    far = max(float(np.abs(moved - place)[axis]), 1e-300)
                    slopes.append(np.abs(self.values(moved) - here) / far)
            errors += float(away[axis]) * np.max(slopes, axis=0)
        if goal is not None:
            errors[goal] = optimum.objective_error * self.span[goal]
        return _Point(place, away, here, errors)

    def unique(self, goal: int, end: Optimum) -> _Point:
        """Of all points with the best of one objective nearly the best in the sum of the others."""
        others = [one for one in range(self.span.size) if one != goal]
        one, starts = (others[0], 0) if len(others) == 1 else (None, 2)
        for slack in _SLACKS:
            with suppress(NumericalFailure):
                found = self.least(others, (goal, slack), end.variables, starts)
                return self.described(found, one)
        self.notes.append(
            f"objective {goal + 1} is at its best at many points, one of them is taken"
        )
        return self.described(end, goal)

    def first_of(
        self, near: list[_Point], goal: int | None, words: str, **asked: Any
    ) -> _Point | None:
        """The point that a search ends in, from the first of two from which it ends."""
        why = ""
        for count, start in enumerate(near):
            try:
                found = self.least([0], first=start.variables, starts=2 * count, **asked)
                return self.described(found, goal)
            except NumericalFailure as failure:
                why = str(failure)
        self.notes.append(f"{words}: {why}")
        return None

    def halved(self, ends: list[_Point], points: int) -> list[_Point]:
        """Points between the two ends: the next bound halves the gap that may hide most."""

        def share(point: _Point) -> float:
            return float((point.values[1] - self.best[1]) / self.span[1])

        def size(gap: tuple[_Point, _Point, float, float]) -> float:
            left, right, high, low = gap
            return max(0.0, float(right.values[0] - left.values[0])) * max(0.0, high - low)

        found = list(ends)
        (begin, end), (high, low) = ends, map(share, ends)
        gaps = [(begin, end, high, low)]
        for _ in range(points - 2):
            left, right, high, low = gaps.pop(int(np.argmax([size(gap) for gap in gaps])))
            middle = 0.5 * (high + low)
            level = self.best[1] + middle * self.span[1]
            words = f"no optimum with the second objective at {level:.6g}"
            point = self.first_of([left, right], 0, words, bound=(1, middle))
            if point is not None:
                found.append(point)
                reached = min(middle, share(point))
                gaps += [(left, point, high, middle), (point, right, reached, low)]
        return found

    def spread_out(self, ends: list[_Point], points: int) -> list[_Point]:
        """Points from evenly spread ones of the simplex between the ends, as far as they can go."""
        found = list(ends)
        corners = np.array([(end.values - self.best) / self.span for end in ends])
        whole = abs(float(np.linalg.det(corners))) > _FLAT
        for weights in lattice(self.span.size, points):
            if whole and np.max(weights) == 1.0:
                continue  # that is an end
            foot = (weights @ corners if whole else weights) + self.best / self.span
            away = [float(np.linalg.norm(one.values / self.span - foot)) for one in found]
            nearest = [found[near] for near in np.argsort(away, kind="stable")[:2].tolist()]
            shown = ", ".join(f"{weight:g}" for weight in weights)
            words = f"no point of the front with the weights {shown}"
            point = self.first_of(nearest, None, words, foot=foot)
            found += [] if point is None else [point]
        return found


def lattice(objectives: int, points: int) -> np.ndarray:
    """Weights (k, objectives) spread evenly over the simplex, at most `points`, at least the ends.

    All that are whole multiples of 1 / h and add up to 1 (I. Das and J. E. Dennis 1998).
    """
    found = np.eye(objectives)
    for parts in range(2, points + 1):
        slots = parts + objectives - 1
        bars = np.array(list(combinations(range(slots), objectives - 1)))
        if len(bars) > points:
            break
        ends = np.pad(bars, ((0, 0), (1, 1)), constant_values=((0, 0), (-1, slots)))
        found = (np.diff(ends, axis=1) - 1.0) / parts
    return found


def front(
    problem: Problem,
    objectives: int = 2,
    *,
    points: int = 15,
    starts: int = 8,
    rtol: float = 1e-9,
    searched: bool = False,
) -> FrontPoints:
    """Trace the points where no objective can become smaller without another growing.

    Parameters
    ----------
    problem : Problem
        Of which `evaluate` gives all objectives, each with its parts, the margins, and the errors
        of all objectives, then of the margins.
    starts, rtol
        As of `minimise`; the ends of the front are searched from all starts.
    searched : bool
        Whether that was done for the first objective, and the first start is where it ended.
    objectives, points : int
        How many objectives, and how many points at most, ends included; at least 2. Fewer come back
        where the front jumps.

    Raises
    ------
    NumericalFailure
        If one of the objectives has no optimum (see `minimise`).

    Notes
    -----
    Of two objectives by the epsilon-constraint method (Y. Y. Haimes, L. S. Lasdon, D. A. Wismer,
    IEEE Trans. SMC-1 (1971), 296-297): the second one is bounded and the first one minimised, from
    the neighbour. Errors are those of the exact point with the same bound.

    Of more by normal boundary intersection (I. Das and J. E. Dennis, SIAM J. Optim. 8 (1998),
    631-657) with inequalities: from points spread evenly over the simplex between the best of each
    objective, in shares of the front, a search goes as far as it can towards smaller values of all.
    Where two of these ends are one the simplex between the worst of each objective takes their
    place. With three and more objectives parts of its rim may lie beyond what these points see.

    Both find parts of a front that bulge inwards, which weighted sums miss. Where the best of an
    objective is reached on a continuum, that end bounds it a millionth of the front above, or more
    where a kink is in the way, which makes it unique. Dominated points are removed.
    """
    tracer = _Tracer(problem, objectives, rtol)
    each = [0 if searched and goal == 0 else starts for goal in range(objectives)]
    ends = [tracer.least([goal], first=problem.first, starts=n) for goal, n in enumerate(each)]
    table = np.array([tracer.values(end.variables) for end in ends])
    span = np.ptp(table, axis=0)
    described = [tracer.described(end, goal) for goal, end in enumerate(ends)]
    unsure = np.max([one.errors for one in described], axis=0)
    if np.all(span <= unsure + SAME * np.max(np.abs(table), axis=0)):
        every = "both" if objectives == 2 else "all"
        tracer.notes.append(f"one point is the best for {every} objectives")
        found = described[:1]
    else:
        tracer.best, tracer.span = np.diag(table).copy(), np.where(span > 0.0, span, 1.0)
        for goal, end in enumerate(ends):
            if end.free_directions and (goal > 0 or objectives > 2):
                described[goal] = tracer.unique(goal, end)
        trace = tracer.halved if objectives == 2 else tracer.spread_out
        found = trace(described, points)
    variables, away, values, off = (np.array(one) for one in zip(*found, strict=True))
    kept, notes = undominated(values), tracer.notes
    if len(kept) < len(values):
        notes.append(f"{len(values) - len(kept)} points were as good as others or dominated")
    return FrontPoints(
        values[kept], off[kept], variables[kept], away[kept], len(tracer.known), notes
    )
