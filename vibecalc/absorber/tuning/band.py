"""Minimax tuning within a band of frequencies, of one or several modes, over states of parts."""

import itertools
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.absorber.modal import (
    Fitted,
    Modes,
    fitted,
    highest,
    poles,
    response_at,
    tops_within,
)
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, BoolArray, FloatArray, IntArray

# ----------------------------------------------------------------------------
# What is tuned: an absorber on modes, the band, and the states in which it has to do well.
# ----------------------------------------------------------------------------


class BandProblem(NamedTuple):
    """Find k and z2 that make the largest |H| from `low` to `high` least over all `states`.

    `states` (s, 4): relative deviations of natural frequencies of the primary at constant mass,
    mass of the absorber, its stiffness, its damping; the first row zeros.
    `stiffness` and `damping` bound the nominal ratios.
    """

    modes: Modes
    mass: float
    excitation: str
    response: str
    low: float
    high: float
    states: FloatArray
    stiffness: tuple[float, float] = (0.0, np.inf)
    damping: tuple[float, float] = (0.0, np.inf)

    def systems(
        self,
        stiffness: float | FloatArray,
        damping: float | FloatArray,
        states: FloatArray | None = None,
    ) -> Fitted:
        """The absorber with nominal ratios, one or (s,), in every state (s, 4): one row each."""
        off = 1.0 + (self.states if states is None else states)
        modes = self.modes._replace(frequency=off[:, :1] * self.modes.frequency)
        return fitted(modes, self.mass * off[:, 1], stiffness * off[:, 2], damping * off[:, 3])


def states_of(tolerances: tuple[float, float, float, float]) -> FloatArray:
    """Lowest, nominal and highest of all four in every combination (s, 4), nominal ones first."""
    each = [(0.0, -share, share) if share else (0.0,) for share in tolerances]
    return np.array(list(itertools.product(*each)))


# ----------------------------------------------------------------------------
# Levels: all maxima within the band over all states, with slopes by k and z.
# ----------------------------------------------------------------------------


class Levels(NamedTuple):
    """Maxima (p,): state, place, ln |H|, error of it, and its gradient (p, 2) by (ln k, z)."""

    state: IntArray
    place: FloatArray
    level: FloatArray
    error: FloatArray
    slope: FloatArray

    def some(self, which: BoolArray | IntArray) -> "Levels":
        """The maxima that an index names."""
        state, place, level, error, slope = self
        return Levels(state[which], place[which], level[which], error[which], slope[which])


def levels_at(problem: BandProblem, point: FloatArray) -> Levels:
    """All maxima at (ln k, z); how their places move counts for nothing to first order."""
    stiffness, damping = float(np.exp(point[0])), float(max(point[1], 0.0))
    system = problem.systems(stiffness, damping)
    tops = tops_within(system, problem.excitation, problem.response, problem.low, problem.high)
    here = response_at(
        system.some(tops.row), tops.place.value, problem.excitation, problem.response
    )
    off = 1.0 + problem.states[tops.row]
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.stack([
            np.real(here.by_stiffness / here.value) * stiffness * off[:, 2],
            np.real(here.by_damping / here.value) * off[:, 3],
        ], axis=1)  # fmt: skip
        level = np.log(tops.height.value)
        error = tops.height.error / tops.height.value
    usable = tops.height.value > 0.0
    slope = np.where(np.isfinite(slope), slope, 0.0)
    whole = Levels(tops.row, tops.place.value, level, error + 2.0 * EPSILON, slope)
    return whole.some(usable)


def _bends(problem: BandProblem, point: FloatArray, here: Levels, step: FloatArray) -> FloatArray:
    """Second derivatives (p, 2, 2) of each level, by differences of its slope."""
    bend = np.zeros((len(here.level), 2, 2))
    # of states far below the highest one the slopes are enough
    near = np.unique(here.state[here.level > np.max(here.level) - _NEAR])
    some = problem._replace(states=problem.states[near])
    for i in range(2):
        there = point.copy()
        there[i] += step[i]
        found = levels_at(some, there)
        moved = _matched(here, found._replace(state=near[found.state]))
        bend[:, i] = (moved - here.slope) / (there[i] - point[i])
    return np.asarray(0.5 * (bend + np.swapaxes(bend, 1, 2)))


def _matched(here: Levels, there: Levels) -> FloatArray:
    """Slopes (p, 2) of the maxima of `there` that are those of `here`."""
    slope = here.slope.copy()
    for i, (state, place) in enumerate(zip(here.state, here.place, strict=True)):
        same = np.flatnonzero(there.state == state)
        if len(same):
            slope[i] = there.slope[same[np.argmin(np.abs(there.place[same] - place))]]
    return slope


# ----------------------------------------------------------------------------
# The search: a grid for the start, quadratic models of all levels, then Newton's method.
# ----------------------------------------------------------------------------

_ACTIVE, _NEAR, _WATCHED = 1e-7, 0.15, 1.0
_ROUNDS, _POLISHES = 60, 6
#: points of the first grid: stiffness, damping on the absorber's own frequency
_ALONG, _DAMPINGS = 22, np.geomspace(2e-3, 1.2, 12)
_STARTS = 3
#: height over the least of the grid from which on a start leads nowhere better
_HOPELESS = 1.3
#: what may be left of weighted slopes of ln |H| by ln k, and by z over its usual size
_SETTLED = 1e-6


class BandTuning(NamedTuple):
    """k, z2, the largest |H| within the band over all states, absolute errors of the three.

    Active maxima (a,): state, frequency ratio, height, weight with which their slopes cancel;
    `residual` what is left of these. `evaluations` counts sets of maxima. `edge`: "free" where a
    spring hardly helps, the softest that was examined.
    """

    stiffness_ratio: float
    secondary_damping: float
    largest: float
    stiffness_error: float
    damping_error: float
    largest_error: float
    state: IntArray
    frequency: FloatArray
    height: FloatArray
    weight: FloatArray
    residual: float
    evaluations: int
    edge: str = ""


def band_tuning(problem: BandProblem) -> BandTuning:
    """The tuning with the least largest response within the band.

    Raises NumericalFailure where the search does not settle, nothing keeps the response finite, or
    a mass fastened rigidly does more than any spring.
    """
    count = [0]

    def levels(point: FloatArray) -> Levels | None:
        count[0] += 1
        try:
            found = levels_at(problem, point)
        except NumericalFailure:
            return None
        return found if len(found.level) and np.all(np.isfinite(found.level)) else None

    found = None
    # where the best starts end in a corner that is no optimum, more of them
    for many, hopeless in ((_STARTS, _HOPELESS), (4 * _STARTS, np.inf)):
        starts = _starts(problem, many, hopeless)
        ended = [one for start in starts if (one := _descend(problem, levels, start)) is not None]
        if not ended:
            raise NumericalFailure("no spring and damper keep the response within the band finite")
        best = min(ended, key=lambda one: float(np.max(one[1].level)))
        found = _finish(problem, *best, levels, count)
        if found.edge == "locked":
            raise NumericalFailure(
                "within this band a mass fastened rigidly does more than any absorber"
            )
        if found.residual <= _SETTLED:
            return found
    raise NumericalFailure(
        "the search for a tuning within the band has not settled: slopes of its peaks leave "
        f"{'nothing' if found is None else format(found.residual, '.2g')}"
    )


def tuned_to(problem: BandProblem, frequency: float) -> BandTuning:
    """The absorber that swings at one frequency ratio, with the least damping within its bounds.

    Without damping its mass takes all of a force on the primary there, and the primary rests where
    the absorber is. Its largest response in the band tells what a spread of frequency costs.
    Raises NumericalFailure where a resonance without damping stands in the band.
    """
    stiffness, damping = problem.mass * frequency**2, problem.damping[0]
    here = levels_at(problem, np.array([np.log(stiffness), damping]))
    top = np.max(here.level)
    active = here.some(np.flatnonzero(here.level > top - _ACTIVE))
    largest = float(np.exp(top))
    off = 8.0 * EPSILON * stiffness
    slope = float(np.max(np.abs(active.slope[:, 0])))
    error = largest * (float(np.max(active.error)) + 16.0 * EPSILON * slope)
    return BandTuning(
        stiffness, damping, largest, off, 4.0 * EPSILON * damping, error, active.state,
        active.place, np.exp(active.level), np.zeros(len(active.level)), 0.0, 1,
    )  # fmt: skip


def _limits(problem: BandProblem) -> tuple[FloatArray, FloatArray]:
    """Bounds of (ln k, z): those given, and ones that no optimum reaches."""
    reach = np.array([problem.low, problem.high])
    wide = problem.mass * np.square(np.array([0.002, 8.0]) * np.array([
        max(reach[0], 0.05 * reach[1]), max(reach[1], float(np.max(problem.modes.frequency)))
    ]))  # fmt: skip
    low = np.array([np.log(max(wide[0], problem.stiffness[0])), problem.damping[0]])
    high = np.array([
        np.log(min(wide[1], problem.stiffness[1])),
        min(problem.damping[1], 40.0 * problem.mass * reach[1]),
    ])  # fmt: skip
    if np.any(low > high):
        raise NumericalFailure("no spring within the bounds acts within the band")
    return low, high


def _starts(problem: BandProblem, many: int, hopeless: float) -> list[FloatArray]:
    """The best few points of a coarse grid, no two of them next to each other."""
    low, high = _limits(problem)
    middle = problem.mass * np.square(np.array([0.5 * max(problem.low, 0.2 * problem.high),
                                                1.7 * problem.high]))  # fmt: skip
    ends = np.clip(np.log(middle), low[0], high[0])
    logs = np.linspace(float(ends[0]), float(ends[1]), _ALONG)
    k, own = (part.ravel() for part in np.meshgrid(np.exp(logs), _DAMPINGS, indexing="ij"))
    z = np.clip(own * np.sqrt(problem.mass * k), low[1], high[1])
    height = np.zeros(len(k))
    for state in problem.states[_few(len(problem.states))]:
        system = problem.systems(k, z, np.tile(state, (len(k), 1)))
        roots = np.abs(poles(system).imag)
        grid = np.broadcast_to(np.linspace(problem.low, problem.high, 25), (len(k), 25))
        x = np.concatenate([np.clip(roots, problem.low, problem.high), grid], axis=1)
        row = np.repeat(np.arange(len(k)), x.shape[1])
        found = response_at(system.some(row), x.ravel(), problem.excitation, problem.response)
        height = np.maximum(height, np.max(np.abs(found.value).reshape(x.shape), axis=1))
    starts: list[FloatArray] = []
    table = np.stack([np.log(k), z], axis=1)
    for place in np.argsort(height):
        near = [np.abs(np.log(k[place]) - one[0]) < 0.15 for one in starts]
        if not any(near):
            starts.append(table[place])
        if len(starts) == many or height[place] > hopeless * np.min(height):
            break
    return starts


def _few(count: int) -> IntArray:
    """The nominal state and some of the others."""
    return np.unique(np.linspace(0, count - 1, min(count, 9)).round().astype(int))


_Found = Callable[[FloatArray], Levels | None]


def _scale(problem: BandProblem, point: FloatArray) -> FloatArray:
    """Of steps: ln k as it is, z by what is usual on such a spring."""
    return np.array([1.0, 0.3 * np.sqrt(problem.mass * np.exp(point[0]))])


def _descend(
    problem: BandProblem, levels: _Found, start: FloatArray
) -> tuple[FloatArray, Levels, float] | None:
    """Steps to the least of quadratic models of all levels, in a region that adapts."""
    low, high = _limits(problem)
    point, radius = np.clip(start, low, high), 0.3
    here = levels(point)
    if here is None:
        point = np.clip(point + np.array([0.0, 0.1]) * _scale(problem, point), low, high)
        here = levels(point)
    if here is None:
        return None
    moved = np.inf
    for _ in range(_ROUNDS):
        scale = _scale(problem, point)
        try:
            bend = _bends(problem, point, here, 1e-5 * scale)
        except NumericalFailure:
            bend = np.zeros((len(here.level), 2, 2))
        step = _model_step(here, bend, scale, radius, low - point, high - point)
        there = None if step is None else levels(point + step)
        size = np.inf if step is None else float(np.max(np.abs(step / scale)))
        better = there is not None and np.max(there.level) < np.max(here.level)
        if better:
            assert step is not None and there is not None
            point, here, moved = point + step, there, size
            radius = min(2.0 * radius, 0.5) if size > 0.5 * radius else radius
        else:
            radius = 0.25 * min(radius, size)
        if (better and size < 1e-7) or radius < 1e-9:
            break
    return point, here, moved


def _model_step(
    here: Levels, bend: FloatArray, scale: FloatArray, radius: float, low: FloatArray,
    high: FloatArray,
) -> FloatArray | None:  # fmt: skip
    """The step within a region that makes the highest of the quadratic models least."""
    from scipy.optimize import minimize

    top = float(np.max(here.level))
    seen = here.level > top - _WATCHED
    level = (here.level[seen] - top) / radius
    slope = here.slope[seen] * scale
    curve = scale[:, None] * bend[seen] * scale * radius
    floor = np.maximum(low / (scale * radius), -1.0)
    ceiling = np.minimum(high / (scale * radius), 1.0)

    def models(u: FloatArray) -> FloatArray:
        bent = 0.5 * np.einsum("i,pij,j->p", u[:2], curve, u[:2])
        return np.asarray(u[2] - (level + slope @ u[:2] + bent))

    def rates(u: FloatArray) -> FloatArray:
        return np.column_stack([-(slope + curve @ u[:2]), np.ones(len(level))])

    found = minimize(
        lambda u: u[2], np.zeros(3), jac=lambda u: np.array([0.0, 0.0, 1.0]), method="SLSQP",
        bounds=[(floor[0], ceiling[0]), (floor[1], ceiling[1]), (None, None)],
        constraints={"type": "ineq", "fun": models, "jac": rates},
        options={"ftol": 1e-14, "maxiter": 100},
    )  # fmt: skip
    step = np.clip(found.x[:2], floor, ceiling) * scale * radius
    return np.clip(step, low, high) if np.all(np.isfinite(step)) else None


def _finish(
    problem: BandProblem, point: FloatArray, here: Levels, moved: float, levels: _Found,
    count: list[int],
) -> BandTuning:  # fmt: skip
    """Newton's method on equal levels whose weighted slopes cancel; errors from its last step."""
    low, high = _limits(problem)
    scale = _scale(problem, point)
    weight, active, residual = _weights(here, scale, point, low, high)
    last = np.full(2, min(moved, 1e-6)) * scale
    for _ in range(_POLISHES):
        step = _newton(problem, point, here, active, weight, scale, low, high)
        if step is None or np.max(np.abs(step / scale)) > 1e-3:
            break
        target = np.clip(point + step, low, high)
        there = levels(target)
        if there is None or np.max(there.level) > np.max(here.level) + 1e-9:
            break
        point, here, last = target, there, np.abs(step)
        weight, active, residual = _weights(here, scale, point, low, high)
        if np.max(np.abs(step / scale)) < 1e-13:
            break
    top = float(np.max(here.level))
    largest, noise = float(np.exp(top)), float(np.max(here.error[active], initial=EPSILON))
    # slopes and levels are rounded, what holds the place is of order one in these units
    off = 4.0 * last + 64.0 * noise * scale
    # what a bound holds is that bound
    at = np.where(point <= low + 1e-12 * scale, low, np.where(
        point >= high - 1e-12 * scale, high, np.nan))  # fmt: skip
    off = np.where(np.isnan(at), off, 4.0 * EPSILON * np.abs(at))
    point = np.where(np.isnan(at), point, at)
    stiffness = float(np.exp(point[0]))
    edge = "free" if point[0] < low[0] + 1e-9 and stiffness > 2.0 * problem.stiffness[0] else ""
    if point[0] > high[0] - 1e-9 and stiffness < problem.stiffness[1] * (1.0 - 1e-9):
        edge = "locked"
    return BandTuning(
        stiffness, float(point[1]), largest, float(stiffness * off[0]), float(off[1]),
        largest * (noise + float(np.sum((off / scale) ** 2)) + residual * float(
            np.max(off / scale))), here.state[active], here.place[active],
        np.exp(here.level[active]), weight, residual, count[0], edge,
    )  # fmt: skip


def _weights(
    here: Levels, scale: FloatArray, point: FloatArray, low: FloatArray, high: FloatArray
) -> tuple[FloatArray, IntArray, float]:
    """Weights of the active levels, no less than zero and one in sum, whose slopes cancel best."""
    from scipy.optimize import nnls

    top = float(np.max(here.level))
    active = np.flatnonzero(here.level > top - _ACTIVE)
    slope = here.slope[active] * scale
    # what pushes against a bound is held by it
    walls = [w for i in range(2) for w in (
        *([-np.eye(2)[i]] if point[i] <= low[i] + 1e-12 * scale[i] else []),
        *([np.eye(2)[i]] if point[i] >= high[i] - 1e-12 * scale[i] else []),
    )]  # fmt: skip
    size = max(float(np.max(np.abs(slope), initial=0.0)), 1e-300)
    rows = np.concatenate([slope / size, np.reshape(walls, (-1, 2))])
    heavy = np.concatenate([np.ones(len(active)), np.zeros(len(walls))])
    found, _ = nnls(np.vstack([rows.T, 1e3 * heavy]), np.array([0.0, 0.0, 1e3]))
    weight = found[: len(active)]
    weight = weight / np.sum(weight) if np.sum(weight) else weight
    keep = weight > 1e-6
    left = float(np.max(np.abs(found @ rows))) * size
    return weight[keep], active[keep], left


def _newton(
    problem: BandProblem, point: FloatArray, here: Levels, active: IntArray, weight: FloatArray,
    scale: FloatArray, low: FloatArray, high: FloatArray,
) -> FloatArray | None:  # fmt: skip
    """Step of (ln k, z) to equal levels with cancelling slopes; a variable at its bound stays."""
    free = (point > low + 1e-12 * scale) & (point < high - 1e-12 * scale)
    n, a = int(np.sum(free)), len(active)
    if not n or not a:
        return None
    some = here.some(active)
    bend = _bends(problem, point, some, 1e-5 * scale)
    slope = (some.slope * scale)[:, free]
    curve = np.einsum("p,pij->ij", weight, bend) * scale[:, None] * scale
    table = np.zeros((n + a + 1, n + a + 1))
    table[:n, :n] = curve[np.ix_(free, free)]
    table[:n, n : n + a], table[n : n + a, :n] = slope.T, slope
    table[n : n + a, -1], table[-1, n : n + a] = -1.0, 1.0
    right = np.zeros(n + a + 1)
    right[:n] = -slope.T @ weight
    right[n : n + a] = np.max(some.level) - some.level
    if np.linalg.cond(table) > 1e12:
        return None
    solved = np.linalg.solve(table, right)
    step = np.zeros(2)
    step[free] = solved[:n] * scale[free]
    return step


# ----------------------------------------------------------------------------
# Next to a tuning: without an absorber, in other states, with a part off.
# ----------------------------------------------------------------------------


def largest_in(
    problem: BandProblem, stiffness: float, damping: float, states: FloatArray | None = None,
    response: str | None = None,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Largest |H| (s,) in each state, and its error; infinite on an undamped resonance."""
    chosen = problem.states if states is None else states
    system, what = problem.systems(stiffness, damping, chosen), response or problem.response
    return highest(system, problem.excitation, what, problem.low, problem.high)[:2]


def largest_alone(problem: BandProblem) -> tuple[float, float]:
    """Largest |H| in any state without the absorber, and its error."""
    value, error = largest_in(problem._replace(mass=0.0), 1.0, 0.0)
    return float(np.max(value)), float(np.max(error))


#: systems, pairs times states, of which all maxima are computed at once, and at most
_AT_ONCE, _MOST = 2000, 40_000


def largest_of_pairs(
    problem: BandProblem, stiffness: FloatArray, damping: FloatArray, response: str
) -> tuple[FloatArray, FloatArray]:
    """Largest |H| of each pair of k and z2 (they broadcast) in its worst state, and its error.

    Raises NumericalFailure where there are more pairs and states than can be computed.
    """
    k, z = np.broadcast_arrays(stiffness, damping)
    states = len(problem.states)
    if k.size * states > _MOST:
        raise NumericalFailure(
            f"{k.size} pairs of stock parts in {states} states of tolerances are too many, at most "
            f"{_MOST} together"
        )
    value, error = np.zeros(k.size), np.zeros(k.size)
    step = max(1, _AT_ONCE // states)
    for start in range(0, k.size, step):
        some = slice(start, start + step)
        count = len(k.ravel()[some])
        spring, drag = (np.repeat(part.ravel()[some], states) for part in (k, z))
        system = problem.systems(spring, drag, np.tile(problem.states, (count, 1)))
        top, slack, _ = highest(system, problem.excitation, response, problem.low, problem.high)
        value[some] = np.max(top.reshape(count, states), axis=1)
        error[some] = np.max(slack.reshape(count, states), axis=1)
    return value.reshape(k.shape), error.reshape(k.shape)
