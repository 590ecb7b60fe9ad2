"""Minimax tuning within a band of frequencies: absorbers on modes, over states of their parts."""

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
# What is tuned: absorbers on modes, the band, and the states in which they have to do well.
# ----------------------------------------------------------------------------


class BandProblem(NamedTuple):
    """Find k and z (a,) that make the largest |H| from `low` to `high` least over all `states`.

    `mass` (a,) and `carrier` as in `Fitted`. `states` (s, 4): relative deviations of natural
    frequencies of the primary at constant mass, masses of the absorbers, their stiffness, their
    damping; the first row zeros. `stiffness` and `damping` bound the nominal ratios, `travel` the
    largest motion of each absorber against what carries it within the band, in every state.
    """

    modes: Modes
    mass: FloatArray
    excitation: str
    response: str
    low: float
    high: float
    states: FloatArray
    stiffness: tuple[float, float] = (0.0, np.inf)
    damping: tuple[float, float] = (0.0, np.inf)
    travel: float = np.inf
    carrier: tuple[int, ...] = ()

    @property
    def readings(self) -> list[tuple[str, int, float]]:
        """What is read, of which absorber and over what: the response, each travel with a limit."""
        bounded = range(len(self.mass)) if np.isfinite(self.travel) else ()
        return [(self.response, 0, 1.0), *(("travel", place, self.travel) for place in bounded)]

    def systems(
        self, stiffness: FloatArray, damping: FloatArray, states: FloatArray | None = None
    ) -> Fitted:
        """The absorbers with nominal ratios (a,), or (s, a), in every state (s, 4): a row each."""
        off = 1.0 + (self.states if states is None else states)
        modes = self.modes._replace(frequency=off[:, :1] * self.modes.frequency)
        ratios = (self.mass * off[:, 1:2], stiffness * off[:, 2:3], damping * off[:, 3:])
        return fitted(modes, *ratios, self.carrier)


def states_of(tolerances: tuple[float, float, float, float]) -> FloatArray:
    """Lowest, nominal and highest of all four in every combination (s, 4), nominal ones first."""
    each = [(0.0, -share, share) if share else (0.0,) for share in tolerances]
    return np.array(list(itertools.product(*each)))


# ----------------------------------------------------------------------------
# Levels: all maxima within the band over all states, with slopes by k and z.
# ----------------------------------------------------------------------------


class Levels(NamedTuple):
    """Maxima (p,): state, place, ln |H|, error of it, and its gradient (p, 2 a) by (ln k, z).

    `limit` is 0 for the response, j for a travel of absorber j, whose level is over its limit.
    """

    state: IntArray
    place: FloatArray
    level: FloatArray
    error: FloatArray
    slope: FloatArray
    limit: IntArray

    def some(self, which: BoolArray | IntArray) -> "Levels":
        """The maxima that an index names."""
        state, place, level, error, slope, limit = self
        return Levels(
            state[which], place[which], level[which], error[which], slope[which], limit[which]
        )

    @property
    def top(self) -> float:
        """The highest response."""
        return float(np.max(self.level[self.limit == 0]))

    @property
    def merit(self) -> float:
        """The highest response, and what travels exceed their limits by, many times."""
        return self.top + _PENALTY * max(0.0, float(np.max(self.level[self.limit > 0], initial=0)))

    @property
    def depth(self) -> FloatArray:
        """How far each lies below the highest response, or below its limit."""
        return np.where(self.limit == 0, self.top, 0.0) - self.level


def levels_at(problem: BandProblem, point: FloatArray) -> Levels:
    """All maxima at (ln k, z); how their places move counts for nothing to first order."""
    stiffness, damping = np.split(point, 2)
    stiffness, damping = np.exp(stiffness), np.maximum(damping, 0.0)
    system, found = problem.systems(stiffness, damping), []
    for limit, (what, absorber, size) in enumerate(problem.readings):
        asked = problem.excitation, what
        tops = tops_within(system, *asked, problem.low, problem.high, absorber)
        here = response_at(system.some(tops.row), tops.place.value, *asked, absorber)
        off = 1.0 + problem.states[tops.row]
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = np.concatenate([
                np.real(here.by_stiffness / here.value[:, None]) * stiffness * off[:, 2:3],
                np.real(here.by_damping / here.value[:, None]) * off[:, 3:],
            ], axis=1)  # fmt: skip
            level = np.log(tops.height.value / size)
            error = tops.height.error / tops.height.value
        usable = tops.height.value > 0.0
        slope = np.where(np.isfinite(slope), slope, 0.0)
        which = np.full(len(level), limit)
        whole = Levels(tops.row, tops.place.value, level, error + 2.0 * EPSILON, slope, which)
        found.append(whole.some(usable))
    return Levels(*(np.concatenate(parts) for parts in zip(*found, strict=True)))


def _bends(problem: BandProblem, point: FloatArray, here: Levels, step: FloatArray) -> FloatArray:
    """Second derivatives (p, q, q) of each level, by differences of its slope."""
    size = len(point)
    bend = np.zeros((len(here.level), size, size))
    # of states far below the highest one the slopes are enough
    near = np.unique(here.state[here.depth < _NEAR])
    some = problem._replace(states=problem.states[near])
    for i in range(size):
        there = point.copy()
        there[i] += step[i]
        found = levels_at(some, there)
        moved = _matched(here, found._replace(state=near[found.state]))
        bend[:, i] = (moved - here.slope) / (there[i] - point[i])
    return np.asarray(0.5 * (bend + np.swapaxes(bend, 1, 2)))


def _matched(here: Levels, there: Levels) -> FloatArray:
    """Slopes (p, q) of the maxima of `there` that are those of `here`."""
    slope = here.slope.copy()
    for i, (state, place, limit) in enumerate(zip(here.state, here.place, here.limit, strict=True)):
        same = np.flatnonzero((there.state == state) & (there.limit == limit))
        if len(same):
            slope[i] = there.slope[same[np.argmin(np.abs(there.place[same] - place))]]
    return slope


# ----------------------------------------------------------------------------
# The search: a grid for the start, quadratic models of all levels, then Newton's method.
# ----------------------------------------------------------------------------

_ACTIVE, _NEAR, _WATCHED = 1e-7, 0.15, 1.0
#: worth of what a travel exceeds its limit by; what is left of it where the limit is kept
_PENALTY, _KEPT = 100.0, 1e-7
_ROUNDS, _POLISHES = 60, 6
#: points of the first grid: stiffness, damping on the absorber's own frequency
_ALONG, _DAMPINGS = 22, np.geomspace(2e-3, 1.2, 12)
_STARTS = 3
#: steps at which the descents of all starts end, and those of the best of them
_ROUGH, _FINE, _FINALISTS = 3e-2, 1e-7, 2
#: points of the grid of several absorbers, spread over all their ratios
_SPREAD_OUT = 1500
#: height over the least of the grid from which on a start leads nowhere better
_HOPELESS = 1.3
#: what may be left of weighted slopes of ln |H| by ln k, and by z over its usual size
_SETTLED = 1e-6


class BandTuning(NamedTuple):
    """k, z (a,), the largest |H| within the band over all states, absolute errors of the three.

    Active maxima (p,): state, frequency ratio, height, weight with which their slopes cancel, and
    `limit`, 0 for the response, j for the travel of absorber j; `residual` what is left of the
    slopes. `evaluations` counts sets of maxima. `edge` of each absorber: "free" where a spring
    hardly helps, the softest that was examined.
    """

    stiffness_ratio: FloatArray
    secondary_damping: FloatArray
    largest: float
    stiffness_error: FloatArray
    damping_error: FloatArray
    largest_error: float
    state: IntArray
    frequency: FloatArray
    height: FloatArray
    weight: FloatArray
    limit: IntArray
    residual: float
    evaluations: int
    edge: tuple[str, ...] = ()


def band_tuning(problem: BandProblem) -> BandTuning:
    """The tuning with the least largest response within the band.

    Raises NumericalFailure where the search does not settle, nothing keeps the response finite or
    the travel within its limit, or a mass fastened rigidly does more than any spring.
    """
    count = [0]

    def levels(point: FloatArray) -> Levels | None:
        count[0] += 1
        try:
            found = levels_at(problem, point)
        except NumericalFailure:
            return None
        return found if len(found.level) and np.all(np.isfinite(found.level)) else None

    found, over = None, 0.0
    # where the best starts end in a corner that is no optimum, more of them
    several = len(problem.mass)
    for many, hopeless in ((_STARTS, _HOPELESS), (4 * _STARTS, np.inf)):
        starts = _starts(problem, many * several, hopeless)
        rough = [_descend(problem, levels, start, _ROUGH) for start in starts]
        ended = sorted((one for one in rough if one is not None), key=lambda one: one[1].merit)
        if not ended:
            raise NumericalFailure("no spring and damper keep the response within the band finite")
        fine = [_descend(problem, levels, one[0], _FINE) for one in ended[:_FINALISTS]]
        best = min((one for one in fine if one is not None), key=lambda one: one[1].merit)
        over = best[1].merit - best[1].top
        found = _finish(problem, *best, levels, count)
        if "locked" in found.edge and over <= _KEPT:
            raise NumericalFailure(
                "within this band a mass fastened rigidly does more than any absorber"
            )
        if found.residual <= _SETTLED and over <= _KEPT:
            return found
    if over > _KEPT:
        factor = float(np.exp(over / _PENALTY))
        raise NumericalFailure(
            "no stiffness and damping within the bounds keep the travel within its limit in the "
            f"band: the closest found exceeds it by the factor {factor:.6g}; the least travel "
            f"found is {factor * problem.travel:.6g}"
        )
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
    stiffness, damping = problem.mass * frequency**2, np.full(1, problem.damping[0])
    here = levels_at(problem, np.concatenate([np.log(stiffness), damping]))
    active = here.some(here.depth < _ACTIVE)
    largest = float(np.exp(here.top))
    off = 8.0 * EPSILON * stiffness
    slope = float(np.max(np.abs(active.slope[:, 0])))
    error = largest * (float(np.max(active.error)) + 16.0 * EPSILON * slope)
    return BandTuning(
        stiffness, damping, largest, off, 4.0 * EPSILON * damping, error, active.state,
        active.place, np.exp(active.level), np.zeros(len(active.level)), active.limit, 0.0, 1,
        ("",),
    )  # fmt: skip


def _limits(problem: BandProblem) -> tuple[FloatArray, FloatArray]:
    """Bounds of (ln k, z): those given, and ones that no optimum reaches."""
    reach = np.array([problem.low, problem.high])
    wide = np.square(np.array([0.002, 8.0]) * np.array([
        max(reach[0], 0.05 * reach[1]), max(reach[1], float(np.max(problem.modes.frequency)))
    ]))  # fmt: skip
    none = np.zeros_like(problem.mass)
    low = np.concatenate([
        np.log(np.maximum(wide[0] * problem.mass, problem.stiffness[0])),
        none + problem.damping[0],
    ])  # fmt: skip
    high = np.concatenate([
        np.log(np.minimum(wide[1] * problem.mass, problem.stiffness[1])),
        np.minimum(problem.damping[1], 40.0 * problem.mass * reach[1]),
    ])  # fmt: skip
    if np.any(low > high):
        raise NumericalFailure("no spring within the bounds acts within the band")
    return low, high


def _grid(problem: BandProblem) -> tuple[FloatArray, FloatArray]:
    """Stiffness and damping (n, a) of the points from which the starts are chosen.

    One absorber has a grid. Ratios of several are spread evenly (M. Roberts), their frequencies
    in one half of them close to those of the modes.
    """
    ends = np.array([0.5 * max(problem.low, 0.2 * problem.high), 1.7 * problem.high])
    count = len(problem.mass)
    if count == 1:
        low, high = _limits(problem)
        logs = np.clip(np.log(problem.mass * np.square(ends)), low[0], high[0])
        along = np.exp(np.linspace(logs[0], logs[1], _ALONG))
        k, own = (part.reshape(-1, 1) for part in np.meshgrid(along, _DAMPINGS, indexing="ij"))
        return k, own * np.sqrt(problem.mass * k)
    unit = spread(_SPREAD_OUT, 2 * count)
    frequency = ends[0] * (ends[1] / ends[0]) ** unit[:, :count]
    inside = (problem.modes.frequency > ends[0]) & (problem.modes.frequency < ends[1])
    near = problem.modes.frequency[inside]
    if len(near):
        which = (len(near) * unit[::2, :count]).astype(int)
        part = (len(near) * unit[::2, :count]) % 1.0
        frequency[::2] = near[which] * (0.8 + 0.35 * part)
    own = _DAMPINGS[0] * (0.5 / _DAMPINGS[0]) ** unit[:, count:]
    k = problem.mass * np.square(frequency)
    return k, own * np.sqrt(problem.mass * k)


def spread(points: int, axes: int) -> FloatArray:
    """Points (n, d) that fill the unit cube evenly: powers of the root of x^(d+1) = x + 1."""
    root = 2.0
    for _ in range(60):
        root = (1.0 + root) ** (1.0 / (axes + 1))
    return np.outer(np.arange(1, points + 1), root ** -np.arange(1.0, axes + 1.0)) % 1.0


def _starts(problem: BandProblem, many: int, hopeless: float) -> list[FloatArray]:
    """The best few points of a coarse grid, no two of them next to each other."""
    low, high = _limits(problem)
    k, z = _grid(problem)
    table = np.clip(np.concatenate([np.log(k), z], axis=1), low, high)
    k, z = np.exp(table[:, : k.shape[1]]), table[:, k.shape[1] :]
    height, over = np.zeros(len(k)), np.zeros(len(k))
    for state in problem.states[_few(len(problem.states))]:
        system = problem.systems(k, z, np.tile(state, (len(k), 1)))
        roots = np.abs(poles(system).imag)
        grid = np.broadcast_to(np.linspace(problem.low, problem.high, 25), (len(k), 25))
        x = np.concatenate([np.clip(roots, problem.low, problem.high), grid], axis=1)
        row = np.repeat(np.arange(len(k)), x.shape[1])
        for limit, (what, absorber, size) in enumerate(problem.readings):
            asked = problem.excitation, what, absorber
            found = np.abs(response_at(system.some(row), x.ravel(), *asked).value)
            top = np.max(found.reshape(x.shape), axis=1) / size
            if limit:
                over = np.maximum(over, np.log(top))
            else:
                height = np.maximum(height, top)
    height = height * np.exp(np.minimum(_PENALTY * over, 300.0))
    starts: list[FloatArray] = []
    for place in np.argsort(height):
        near = [np.all(np.abs(table[place] - one)[: k.shape[1]] < 0.15) for one in starts]
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
    k = np.exp(point[: len(problem.mass)])
    return np.concatenate([np.ones(len(k)), 0.3 * np.sqrt(problem.mass * k)])


def _descend(
    problem: BandProblem, levels: _Found, start: FloatArray, enough: float
) -> tuple[FloatArray, Levels, float] | None:
    """Steps to the least of quadratic models of all levels, in a region that adapts."""
    low, high = _limits(problem)
    point, radius = np.clip(start, low, high), 0.3
    here = levels(point)
    if here is None:
        drag = np.repeat([0.0, 0.1], len(problem.mass))
        point = np.clip(point + drag * _scale(problem, point), low, high)
        here = levels(point)
    if here is None:
        return None
    moved = np.inf
    for _ in range(_ROUNDS):
        scale = _scale(problem, point)
        try:
            bend = _bends(problem, point, here, 1e-5 * scale)
        except NumericalFailure:
            bend = np.zeros((len(here.level), len(point), len(point)))
        step = _model_step(here, bend, scale, radius, low - point, high - point)
        there = None if step is None else levels(point + step)
        size = np.inf if step is None else float(np.max(np.abs(step / scale)))
        better = there is not None and there.merit < here.merit
        if better:
            assert step is not None and there is not None
            point, here, moved = point + step, there, size
            radius = min(2.0 * radius, 0.5) if size > 0.5 * radius else radius
        else:
            radius = 0.25 * min(radius, size)
        if (better and size < enough) or radius < 1e-2 * enough:
            break
    return point, here, moved


def _model_step(
    here: Levels, bend: FloatArray, scale: FloatArray, radius: float, low: FloatArray,
    high: FloatArray,
) -> FloatArray | None:  # fmt: skip
    """The step within a region that makes the highest of the quadratic models least.

    Unknowns: the step, the highest response, and what travels exceed their limits by.
    """
    from scipy.optimize import minimize

    top, size = here.top, len(scale)
    seen = here.depth < _WATCHED
    some = here.some(seen)
    of_response = (some.limit == 0).astype(float)
    level = (some.level - top * of_response) / radius
    slope = some.slope * scale
    curve = scale[:, None] * bend[seen] * scale * radius
    floor = np.maximum(low / (scale * radius), -1.0)
    ceiling = np.minimum(high / (scale * radius), 1.0)
    bounded = bool(np.any(here.limit))
    cost = np.concatenate([np.zeros(size), [1.0], [_PENALTY] * bounded])
    rise = np.stack([of_response, 1.0 - of_response][: 1 + bounded], axis=1)

    def models(u: FloatArray) -> FloatArray:
        bent = 0.5 * np.einsum("i,pij,j->p", u[:size], curve, u[:size])
        return np.asarray(rise @ u[size:] - (level + slope @ u[:size] + bent))

    def rates(u: FloatArray) -> FloatArray:
        return np.concatenate([-(slope + curve @ u[:size]), rise], axis=1)

    limits = [*zip(floor, ceiling, strict=True), (None, None), *([(0.0, None)] * bounded)]
    found = minimize(
        lambda u: cost @ u, np.zeros(len(cost)), jac=lambda u: cost, method="SLSQP", bounds=limits,
        constraints={"type": "ineq", "fun": models, "jac": rates},
        options={"ftol": 1e-14, "maxiter": 100},
    )  # fmt: skip
    step = np.clip(found.x[:size], floor, ceiling) * scale * radius
    return np.clip(step, low, high) if np.all(np.isfinite(step)) else None


def _finish(
    problem: BandProblem, point: FloatArray, here: Levels, moved: float, levels: _Found,
    count: list[int],
) -> BandTuning:  # fmt: skip
    """Newton's method on equal levels whose weighted slopes cancel; errors from its last step."""
    low, high = _limits(problem)
    ordered = _in_order(problem, point)
    again = levels(ordered) if np.any(ordered != point) else None
    if again is not None:
        point, here = ordered, again
    scale = _scale(problem, point)
    weight, active, residual = _weights(here, scale, point, low, high)
    last = min(moved, 1e-6) * scale
    for _ in range(_POLISHES):
        step = _newton(problem, point, here, active, weight, scale, low, high)
        if step is None or np.max(np.abs(step / scale)) > 1e-3:
            break
        target = np.clip(point + step, low, high)
        there = levels(target)
        if there is None or there.merit > here.merit + 1e-9:
            break
        point, here, last = target, there, np.abs(step)
        weight, active, residual = _weights(here, scale, point, low, high)
        if np.max(np.abs(step / scale)) < 1e-13:
            break
    largest, noise = float(np.exp(here.top)), float(np.max(here.error[active], initial=EPSILON))
    # slopes and levels are rounded, what holds the place is of order one in these units
    off = 4.0 * last + 64.0 * noise * scale
    # what a bound holds is that bound
    at = np.where(point <= low + 1e-12 * scale, low, np.where(
        point >= high - 1e-12 * scale, high, np.nan))  # fmt: skip
    off = np.where(np.isnan(at), off, 4.0 * EPSILON * np.abs(at))
    point = np.where(np.isnan(at), point, at)
    softest, stiffest = (np.split(part, 2)[0] for part in (low, high))
    logs, damping = np.split(point, 2)
    stiffness, stiff_off = np.exp(logs), np.split(off, 2)[0]
    free = (logs < softest + 1e-9) & (stiffness > 2.0 * problem.stiffness[0])
    locked = (logs > stiffest - 1e-9) & (stiffness < problem.stiffness[1] * (1.0 - 1e-9))
    return BandTuning(
        stiffness, damping, largest, stiffness * stiff_off, np.split(off, 2)[1],
        largest * (noise + float(np.sum((off / scale) ** 2)) + residual * float(
            np.max(off / scale))), here.state[active], here.place[active],
        np.exp(here.level[active]) * np.where(here.limit[active] > 0, problem.travel, 1.0), weight,
        here.limit[active], residual, count[0],
        tuple(np.where(locked, "locked", np.where(free, "free", ""))),
    )  # fmt: skip


def _in_order(problem: BandProblem, point: FloatArray) -> FloatArray:
    """The point with absorbers that nothing tells apart by rising stiffness."""
    count = len(problem.mass)
    if any(carrier >= 0 for carrier in problem.carrier):
        return point
    apart = [
        (m, *shapes)
        for m, shapes in zip(
            problem.mass, np.swapaxes(problem.modes.at_absorber, -1, -2).tolist(), strict=True
        )
    ]
    order = np.arange(count)
    for one in set(apart):
        alike = [place for place in range(count) if apart[place] == one]
        order[alike] = sorted(alike, key=lambda place: point[place])
    return np.asarray(point[np.concatenate([order, order + count])])


def _weights(
    here: Levels, scale: FloatArray, point: FloatArray, low: FloatArray, high: FloatArray
) -> tuple[FloatArray, IntArray, float]:
    """Weights of the active levels, no less than zero, whose slopes cancel best; those of the
    response are one in sum."""
    from scipy.optimize import nnls

    active = np.flatnonzero(here.depth < _ACTIVE)
    slope = here.slope[active] * scale
    # what pushes against a bound is held by it
    sides = np.eye(len(scale))
    walls = np.concatenate([
        -sides[point <= low + 1e-12 * scale], sides[point >= high - 1e-12 * scale]
    ])  # fmt: skip
    size = max(float(np.max(np.abs(slope), initial=0.0)), 1e-300)
    rows = np.concatenate([slope / size, walls])
    of_response = here.limit[active] == 0
    heavy = np.concatenate([of_response, np.zeros(len(walls))])
    found, _ = nnls(np.vstack([rows.T, 1e3 * heavy]), np.append(np.zeros(len(scale)), 1e3))
    weight = found[: len(active)]
    share = float(np.sum(weight[of_response]))
    weight = weight / share if share else weight
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
    of_response = (some.limit == 0).astype(float)
    table = np.zeros((n + a + 1, n + a + 1))
    table[:n, :n] = curve[np.ix_(free, free)]
    table[:n, n : n + a], table[n : n + a, :n] = slope.T, slope
    table[n : n + a, -1], table[-1, n : n + a] = -of_response, of_response
    right = np.zeros(n + a + 1)
    right[:n] = -slope.T @ weight
    right[n : n + a] = some.depth
    if np.linalg.cond(table) > 1e12:
        return None
    solved = np.linalg.solve(table, right)
    step = np.zeros(len(point))
    step[free] = solved[:n] * scale[free]
    return step


# ----------------------------------------------------------------------------
# Next to a tuning: without absorbers, in other states, with a part off.
# ----------------------------------------------------------------------------


def largest_in(
    problem: BandProblem, stiffness: FloatArray, damping: FloatArray,
    states: FloatArray | None = None, response: str | None = None, absorber: int = 0,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Largest |H| (s,) in each state, and its error; infinite on an undamped resonance."""
    chosen = problem.states if states is None else states
    system, what = problem.systems(stiffness, damping, chosen), response or problem.response
    return highest(system, problem.excitation, what, problem.low, problem.high, absorber)[:2]


def largest_alone(problem: BandProblem) -> tuple[float, float]:
    """Largest |H| in any state without the absorbers, and its error."""
    none = np.zeros_like(problem.mass)
    value, error = largest_in(problem._replace(mass=none), none + 1.0, none)
    return float(np.max(value)), float(np.max(error))


def at_least(
    problem: BandProblem, stiffness: FloatArray, damping: FloatArray, state: IntArray,
    place: FloatArray,
) -> FloatArray:  # fmt: skip
    """What the largest |H| of pairs (n,) of k and z is not below: |H| at places (p,) in states."""
    least, asked = np.zeros(len(stiffness)), (problem.excitation, problem.response)
    for which, x in zip(state, place, strict=True):
        rows = np.tile(problem.states[which], (len(stiffness), 1))
        system = problem.systems(stiffness[:, None], damping[:, None], rows)
        found = response_at(system, np.full(len(stiffness), x), *asked)
        least = np.maximum(least, np.abs(found.value))
    return least


#: systems, pairs times states, of which all maxima are computed at once, and at most
_AT_ONCE, _MOST = 2000, 150_000


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
        spring, drag = (np.repeat(part.ravel()[some], states)[:, None] for part in (k, z))
        system = problem.systems(spring, drag, np.tile(problem.states, (count, 1)))
        top, slack, _ = highest(system, problem.excitation, response, problem.low, problem.high)
        value[some] = np.max(top.reshape(count, states), axis=1)
        error[some] = np.max(slack.reshape(count, states), axis=1)
    return value.reshape(k.shape), error.reshape(k.shape)
