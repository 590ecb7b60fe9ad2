"""Minimax tuning of absorbers on modes, in a band or over all frequencies, over states of parts."""

from typing import NamedTuple

import numpy as np

from vibecalc.absorber.modal import driven, poles
from vibecalc.absorber.tuning.levels import BandProblem, Levels, levels_at
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.least_norm import nonnegative_least_squares
from vibecalc.numerics.rounding import EPSILON, BoolArray, FloatArray, IntArray

# ----------------------------------------------------------------------------
# Where to start: the best of many places spread evenly, no two of them next to each other.
# ----------------------------------------------------------------------------

#: points of the grid: stiffness, damping on the absorber's own frequency; of several absorbers
_ALONG, _DAMPINGS, _SPREAD_OUT = 22, np.geomspace(2e-3, 1.2, 12), 1500


def _grid(problem: BandProblem) -> FloatArray:
    """Points (n, 2 a) from which the starts are chosen.

    One absorber has a grid. Ratios of several are spread evenly (M. Roberts), their frequencies
    in one half of them close to those of the modes.
    """
    low, high = problem.span
    ends, count = (0.5 * low, 1.7 * high), len(problem.mass)
    if count == 1:
        along = np.geomspace(*ends, _ALONG)
        frequency, own = (
            part.reshape(-1, 1) for part in np.meshgrid(along, _DAMPINGS, indexing="ij")
        )
    else:
        unit = spread(_SPREAD_OUT, 2 * count)
        frequency = ends[0] * (ends[1] / ends[0]) ** unit[:, :count]
        modes = problem.modes.frequency
        near = modes[(modes > ends[0]) & (modes < ends[1])]
        if len(near):
            which = (len(near) * unit[::2, :count]).astype(int)
            part = (len(near) * unit[::2, :count]) % 1.0
            frequency[::2] = near[which] * (0.8 + 0.35 * part)
        own = _DAMPINGS[0] * (0.5 / _DAMPINGS[0]) ** unit[:, count:]
    points = np.concatenate([problem.mass * frequency**2, own * problem.mass * frequency], axis=1)
    return np.asarray(np.clip(points, *problem.bounds()))


def spread(points: int, axes: int) -> FloatArray:
    """Points (n, d) that fill the unit cube evenly: powers of the root of x^(d+1) = x + 1."""
    root = 2.0
    for _ in range(60):
        root = (1.0 + root) ** (1.0 / (axes + 1))
    return np.outer(np.arange(1, points + 1), root ** -np.arange(1.0, axes + 1.0)) % 1.0


def _starts(problem: BandProblem, many: int) -> list[FloatArray]:
    """The best few points of a coarse grid, no two of them next to each other."""
    table, scale = _grid(problem), problem.usual()
    k, z = np.split(table, 2, axis=1)
    low, high = problem.low, min(problem.high, 3.0 * float(np.max(problem.modes.frequency)))
    height, over = np.zeros(len(k)), np.zeros(len(k))
    states = problem.states[np.unique(np.linspace(0, len(problem.states) - 1, 9).astype(int))]
    for state in states:
        system = problem.systems(k, z, np.tile(state, (len(k), 1)))
        grid = np.broadcast_to(np.linspace(low, high, 25), (len(k), 25))
        x = np.concatenate([np.clip(np.abs(poles(system).imag), low, high), grid], axis=1)
        row = np.repeat(np.arange(len(k)), x.shape[1])
        for limit, (what, absorber, size) in enumerate(problem.readings):
            found = driven(system, problem.excitation, what, absorber).at(row, x.ravel()).value
            top = np.max(np.abs(found).reshape(x.shape), axis=1) / size
            if limit:
                over = np.maximum(over, 2.0 * np.log(top))
            else:
                height = np.maximum(height, 2.0 * np.log(top))
    starts: list[FloatArray] = []
    for place in np.argsort(height + _PENALTY * over):
        apart = [np.abs(table[place] - one) > 0.3 * scale for one in starts]
        if all(np.any(one) for one in apart):
            starts.append(table[place])
        if len(starts) == many:
            break
    return starts


# ----------------------------------------------------------------------------
# From a start towards a minimax: sequential quadratic programming on the levels of the peaks.
#
# Near a point every peak is its level plus slope times step; the multipliers of the peaks that hold
# each other up weigh their second derivatives (J. Nocedal and S. J. Wright, Numerical Optimization,
# 2nd ed. 2006, ch. 18). The step is kept inside a box that shrinks when the peaks disappoint.
# ----------------------------------------------------------------------------

_PENALTY, _STEPS = 20.0, 100
#: curvature given to the unknown level, so that the step is a least distance
_SOFT = 1e-3


class Descent(NamedTuple):
    """Where a descent ended: k, then z (2 a,), the levels there, how many points were evaluated."""

    point: FloatArray
    levels: Levels
    evaluations: int

    @property
    def merit(self) -> float:
        """The highest response, and what travels exceed their limits by, many times."""
        return self.levels.top + 100.0 * self.levels.over


def _descend(problem: BandProblem, start: FloatArray, least: float) -> Descent | None:
    """Descend until the box is smaller than `least` (relative); None from an infinite response."""
    scale = problem.usual()
    lower, upper = (part / scale for part in problem.bounds())
    point, reach, used = np.clip(start / scale, lower, upper), 0.3, 1
    try:
        here = levels_at(problem, point * scale)
    except NumericalFailure:
        return None
    for _ in range(_STEPS):
        size = reach * np.maximum(np.abs(point), 0.05)
        box = np.maximum(lower, point - size) - point, np.minimum(upper, point + size) - point
        step, promised = _quadratic_step(_scaled(here, scale), box)
        if promised <= 1e-13:
            break
        trial = np.clip(point + step, lower, upper)
        used += 1
        try:
            there = levels_at(problem, trial * scale)
            gain = here.top + _PENALTY * here.over - there.top - _PENALTY * there.over
        except NumericalFailure:
            gain = -1.0
        if gain > 0.1 * promised:
            point, here = trial, there
            if gain > 0.7 * promised:
                reach = min(2.0 * reach, 1.0)
        else:
            reach *= 0.3
        if reach < least:
            break
    return Descent(point * scale, here, used)


def _scaled(here: Levels, scale: FloatArray) -> Levels:
    return here._replace(slope=here.slope * scale, bend=here.bend * scale[:, None] * scale)


def _multipliers(rows: Levels, lower: np.ndarray, upper: np.ndarray) -> tuple[np.ndarray, float]:
    """Weights of the rows (objective rows add to one) that best cancel their slopes, and the rest.

    `lower`, `upper`: masks of ratios that stand on a bound, which may hold against the slope.
    """
    size = rows.slope.shape[1]
    unit = np.eye(size)
    walls = np.concatenate([-unit[lower], unit[upper]])
    heavy = 1e3 * max(float(np.max(np.abs(rows.slope), initial=0.0)), 1.0)
    table = np.concatenate([rows.slope, walls])
    sums = np.concatenate([heavy * (rows.limit == 0), np.zeros(len(walls))])
    found = nonnegative_least_squares(
        np.concatenate([table.T, sums[None]]), np.append(np.zeros(size), heavy)
    )
    return found[: len(rows.level)], float(np.linalg.norm(found @ table))


def _quadratic_step(rows: Levels, box: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, float]:
    """Step that lowers the model most, and by how much it does."""
    level, over, close = rows.top, rows.over, rows.depth < 0.3
    weight, _ = _multipliers(rows.some(close), box[0] >= 0.0, box[1] <= 0.0)
    bend = np.tensordot(weight, rows.bend[close], 1)
    values, vectors = np.linalg.eigh(0.5 * (bend + bend.T))
    floor = 1e-3 * max(float(np.max(np.abs(values))), 1e-3)
    values = np.maximum(np.abs(values), floor)
    step = np.clip(_least_distance(rows, level, (values, vectors), box), *box)
    on_curve = rows.limit == 0
    moved = rows.level + rows.slope @ step
    bent = 0.5 * float(values @ (step @ vectors) ** 2)
    model = float(np.max(moved[on_curve])) + bent
    excess = max(float(np.max(moved[~on_curve], initial=0.0)), 0.0)
    return step, level + _PENALTY * over - model - _PENALTY * excess


def _least_distance(
    rows: Levels, level: float, bend: tuple[np.ndarray, np.ndarray],
    box: tuple[np.ndarray, np.ndarray],
) -> np.ndarray:  # fmt: skip
    """min t + penalty s + d' B d / 2 over steps d, rows below t (travels below s >= 0), d in a box.

    With a little curvature given to t and s it is the point of a polyhedron nearest to the origin
    (C. L. Lawson and R. J. Hanson, Solving Least Squares Problems, 1974, ch. 23).
    """
    values, vectors = bend
    size, count = len(values), len(rows.level)
    back = vectors / np.sqrt(values)  # step from the scaled unknowns
    on_curve = (rows.limit == 0).astype(float)
    root = np.sqrt(_SOFT)
    table = np.zeros((count + 1 + 2 * size, size + 2))
    right = np.zeros(len(table))
    table[:count, :size] = -rows.slope @ back
    table[:count, size], table[:count, size + 1] = on_curve / root, (1.0 - on_curve) / root
    right[:count] = rows.level - on_curve * level + np.where(on_curve > 0.0, 1.0, _PENALTY) / _SOFT
    table[count, size + 1], right[count] = 1.0 / root, _PENALTY / _SOFT
    table[count + 1 : count + 1 + size, :size], right[count + 1 : count + 1 + size] = back, box[0]
    table[count + 1 + size :, :size], right[count + 1 + size :] = -back, -box[1]
    # rows of length one, and distances of order one
    length = np.linalg.norm(table, axis=1)
    far = _PENALTY / root
    table, right = table / length[:, None], right / length / far
    goal = np.zeros(size + 3)
    goal[-1] = 1.0
    matrix = np.concatenate([table.T, right[None]])
    multipliers = nonnegative_least_squares(matrix, goal)
    gap = matrix @ multipliers - goal
    step: np.ndarray = back @ (-gap[:size] / gap[-1] * far)
    return step


# ----------------------------------------------------------------------------
# The last digits of a minimax: Newton's method on the conditions that hold the peaks.
# ----------------------------------------------------------------------------

_NEWTON_STEPS = 15
_TIE = (1e-7, 1e-4, 1e-2, 1e-1)


class Held(NamedTuple):
    """A point (2 a,) that meets the conditions, with its levels.

    `weight` (p,) of the levels that hold it (those of the response add to one), `lower`, `upper`
    (2 a,) the bounds that do, `residual` what is left of the weighted slopes, `curvature` the least
    second derivative along directions that leave all active levels alone (infinite if there are
    none), `step` the last step, all in units of `usual`.
    """

    point: FloatArray
    levels: Levels
    weight: FloatArray
    lower: BoolArray
    upper: BoolArray
    residual: float
    curvature: float
    step: float


def _hold(problem: BandProblem, start: FloatArray, count: list[int]) -> Held | None:
    """Newton from near a minimax; None where no set of levels and bounds holds a point nearby."""
    for tie in _TIE:
        try:
            found = _with(problem, start, tie, count)
        except NumericalFailure:
            continue
        if found is not None:
            return found
    return None


def _with(problem: BandProblem, start: FloatArray, tie: float, count: list[int]) -> Held | None:
    scale, (lower, upper) = problem.usual(), problem.bounds()
    point, first, length, before = start, np.inf, 0.0, 1.0
    for _ in range(_NEWTON_STEPS):
        here = _scaled(levels_at(problem, point), scale)
        count[0] += 1
        first = min(first, here.top + here.over)
        wall = min(tie, 1e-3) * scale
        on_lower, on_upper = point <= lower + wall, point >= upper - wall
        near = here.depth <= np.where(here.still, 1e-9, max(tie, min(4.0 * length, 0.1)))
        weight = np.zeros(len(here.level))
        weight[near] = _multipliers(here.some(near), on_lower, on_upper)[0]
        pull = weight @ here.slope
        # what presses against a bound is held by it
        free = ~(on_lower & (pull > 1e-9)) & ~(on_upper & (pull < -1e-9)) & (upper > lower)
        solved = _solve(here, weight, free)
        if solved is None:
            return None
        step, curvature = solved
        length = float(np.max(np.abs(step), initial=0.0))
        if length > 0.5:
            step *= 0.5 / length
        moved = np.clip(point + scale * step, lower, upper)
        moved = np.where(free, moved, np.where(on_lower, lower, upper))
        # a short step squares in the next one
        if length < 1e-13 or (length < 1e-9 and before < 1e-9):
            break
        point, before = moved, length
    else:
        return None
    active, far = weight > 1e-9, 1e-9 + 1e2 * float(np.max(here.error))
    curve = active & (here.limit == 0)
    residual = float(np.linalg.norm((weight @ here.slope)[free]))
    fine = residual < 1e-6 and float(np.ptp(here.level[curve])) < far and here.over < far
    fine &= abs(float(np.sum(weight[curve])) - 1.0) < 1e-6
    if not (fine and curvature > -1e-7 and here.top <= first + 1e-7):
        return None
    point = np.where(on_lower & ~free, lower, np.where(on_upper & ~free, upper, point))
    return Held(
        point, here, np.where(active, weight, 0.0), on_lower & ~free, on_upper & ~free, residual,
        curvature, length,
    )  # fmt: skip


def _solve(here: Levels, weight: FloatArray, free: BoolArray) -> tuple[FloatArray, float] | None:
    """Newton's step (2 a,), and the least curvature left free."""
    active = weight > 1e-9
    held = here.some(active)
    bend = np.tensordot(weight[active], held.bend, 1)[np.ix_(free, free)]
    slope, on_curve = held.slope[:, free], (held.limit == 0).astype(float)
    count, width = len(held.level), int(np.sum(free))
    if not np.any(on_curve):
        return None
    table, right = np.zeros((width + count + 1, width + count + 1)), np.zeros(width + count + 1)
    table[:width, :width] = bend
    table[:width, width:-1], table[width:-1, :width] = slope.T, slope
    table[width:-1, -1], table[-1, width:-1] = -on_curve, on_curve
    right[width:-1], right[-1] = held.depth, 1.0
    step = np.zeros(len(free))
    step[free] = np.linalg.lstsq(table, right, rcond=1e-13)[0][:width]
    # directions in which all active levels stay together
    differences = slope - np.outer(on_curve, on_curve @ slope / np.sum(on_curve))
    _, singular, turned = np.linalg.svd(differences, full_matrices=True)
    rank = int(np.sum(singular > 1e-9 * max(float(np.max(singular, initial=0.0)), 1e-300)))
    loose = turned[rank:]
    if not len(loose):
        return step, np.inf
    return step, float(np.min(np.linalg.eigvalsh(loose @ bend @ loose.T)))


# ----------------------------------------------------------------------------
# Least largest response: from many starts to one certified optimum.
# ----------------------------------------------------------------------------

#: starts of one absorber and of several; descents that go on to the last digits, and how small
#: their box gets before and after
STARTS, _FINALISTS, _ROUGH, _FINE = (4, 12), 3, 3e-2, 1e-6
#: levels that count as the same optimum; what is left of a level where a travel is kept
_SAME, _KEPT = 1e-8, 1e-7
#: stiffness, in units of `usual`, beyond which the rigidly fastened limit is tried as well
_STIFF = 4.0
#: roundings of a place or a weight, and of a slope
_PLACE, _ROUNDINGS = 16.0 * EPSILON, 64.0 * EPSILON


class BandTuning(NamedTuple):
    """k, z (a,), the largest |H| within the band over all states, absolute errors of the three.

    Active maxima (p,): state, frequency ratio, height, weight with which their slopes cancel (those
    of the response add to one), and `limit`, 0 for the response, j for the travel of absorber j;
    `residual` the length of what is left of the slopes. `lower`, `upper` (2 a,): k, then z, that a
    bound holds. `is_set`: the response at rest or at infinite frequency is largest, so that the
    optimum is a set, of which one is given. `unsprung`: the softest spring examined is best.
    `agreeing` of the best descents ended here. `evaluations` counts sets of maxima. An infinite
    stiffness: that absorber does best when fastened rigidly to what it hangs on.
    """

    stiffness_ratio: FloatArray
    secondary_damping: FloatArray
    largest: float
    stiffness_error: FloatArray
    damping_error: FloatArray
    largest_error: float
    state: IntArray
    frequency: FloatArray
    frequency_error: FloatArray
    height: FloatArray
    weight: FloatArray
    weight_error: FloatArray
    limit: IntArray
    residual: float
    evaluations: int
    lower: BoolArray
    upper: BoolArray
    agreeing: int = 1
    is_set: bool = False
    unsprung: bool = False


def band_tuning(problem: BandProblem, starts: int = 0) -> BandTuning:
    """The tuning with the least largest response within the band.

    A minimax has no convexity here: the global optimum is as sure as the number of starts (0: the
    usual one). Raises NumericalFailure where the search does not settle, nothing keeps the response
    finite or the travel within its limit, or a mass fastened rigidly does more than any spring.
    """
    few = starts or STARTS[len(problem.mass) > 1]
    count, best = [0], None
    # where the best starts end in a corner that is no optimum, more of them
    for many in (few,) if starts else (few, 4 * few):
        found = [_descend(problem, start, _ROUGH) for start in _starts(problem, many)]
        rough = sorted((one for one in found if one is not None), key=lambda one: one.merit)
        if not rough:
            if np.isinf(problem.high):
                levels_at(problem, problem.usual())
            raise NumericalFailure("no spring and damper keep the response within the band finite")
        fine = [_descend(problem, one.point, _FINE) for one in rough[:_FINALISTS]]
        ends = sorted((one for one in fine if one is not None), key=lambda one: one.merit)
        count[0] += sum(one.evaluations for one in (*rough, *ends))
        best = ends[0]
        agreeing = sum(one.merit < best.merit + 1e-5 for one in ends)
        if best.levels.over > _KEPT:
            continue
        top = best.levels.level >= best.levels.top - 1e-9
        if np.any(top & best.levels.still & (best.levels.limit == 0)):
            return _set_of_optima(best, agreeing, count[0])
        settled = _settled(problem, ends, best.levels.top + _SAME, count)
        if settled is not None:
            return _certified(*settled, agreeing, count[0])
    assert best is not None
    if best.levels.over > _KEPT:
        factor = float(np.exp(0.5 * best.levels.over))
        banded = np.isfinite(problem.high)
        what = "travel within its limit in the band" if banded else "spring travel within its limit"
        raise NumericalFailure(
            f"no stiffness and damping within the bounds keep the {what}: the closest found "
            f"exceeds it by the factor {factor:.6g}; the least travel found is "
            f"{factor * problem.travel:.6g}"
        )
    raise NumericalFailure(
        f"the search for a tuning of {len(problem.mass)} absorber{'s' * (len(problem.mass) > 1)} "
        f"has not settled: the lowest peak found, {np.exp(0.5 * best.levels.top):.9g}, is not held "
        "by its peaks"
    )


def _settled(
    problem: BandProblem, ends: list[Descent], most: float, count: list[int]
) -> tuple[BandProblem, Held] | None:
    """The optimum at one of the ends, or that with absorbers fastened which they made very stiff.

    Where a finite tuning and its limit are as good, the finite one.
    """
    choices = []
    for end in ends:
        held = _hold(problem, _in_order(problem, end.point), count)
        if held is not None:
            choices.append((problem, held))
            break
    n = len(problem.mass)
    size = [end.point / problem.usual() for end in ends]
    masks = {tuple((one[:n] > _STIFF) | (one[n:] > 2.0 * _STIFF)) for one in size}
    for mask in masks if np.isinf(problem.stiffness[1]) else ():
        if any(mask) and not all(mask):
            limit = problem._replace(locked=tuple(bool(one) for one in mask))
            last = _descend(limit, ends[0].point, _FINE)
            held = None if last is None else _hold(limit, last.point, count)
            if held is not None:
                choices.append((limit, held))
    choices = [one for one in choices if one[1].levels.top <= most]
    return min(choices, key=lambda one: one[1].levels.top, default=None)


def _in_order(problem: BandProblem, point: FloatArray) -> FloatArray:
    """The point with absorbers that nothing tells apart by rising stiffness."""
    count = len(problem.mass)
    if any(carrier >= 0 for carrier in problem.carrier):
        return point
    shapes = np.swapaxes(problem.modes.at_absorber, -1, -2).tolist()
    apart = [(m, *one) for m, one in zip(problem.mass, shapes, strict=True)]
    order = np.arange(count)
    for one in set(apart):
        alike = [place for place in range(count) if apart[place] == one]
        order[alike] = sorted(alike, key=lambda place: point[place])
    return np.asarray(point[np.concatenate([order, order + count])])


def _certified(problem: BandProblem, held: Held, agreeing: int, used: int) -> BandTuning:
    """The optimum with its errors, from the last step and what is left of the conditions."""
    n, scale, (lower, upper) = len(problem.mass), problem.usual(), problem.bounds()
    fastened = held.upper[:n] & (upper[:n] > 0.0) & (upper[:n] < problem.stiffness[1])
    if np.any(fastened):
        raise NumericalFailure(
            f"{'within this band ' * bool(np.isfinite(problem.high))}a mass fastened rigidly does "
            "more than any absorber"
        )
    active = held.levels.some(held.weight > 0.0)
    weight, curve = held.weight[held.weight > 0.0], active.limit == 0
    noise = float(np.max(active.error[curve]) + np.ptp(active.level[curve]))
    # the step to the exact conditions is of second order in what is left of them
    curvature = held.curvature if np.isfinite(held.curvature) else 1.0
    stiff = max(float(np.min(np.linalg.norm(active.slope, axis=1))), 1e-300)
    move = held.step**2 + (held.residual + 1e-14) / max(curvature, 1e-12) + noise / stiff
    off = np.where(held.lower | held.upper, 0.0, move) + 4.0 * EPSILON * held.point / scale
    # slopes move with the ratios by their second derivatives, and are rounded
    bent = np.abs(active.bend) @ off + _ROUNDINGS * np.abs(active.slope)
    table = np.linalg.pinv(np.vstack([active.slope.T, curve]))
    peak = float(np.exp(0.5 * held.levels.top))
    k, z = np.split(held.point, 2)
    k_off, z_off = np.split(scale * off, 2)
    if any(problem.locked):
        k = np.where(problem.locked, np.inf, k)
    return BandTuning(
        k, z, peak, k_off, z_off, 0.5 * peak * (noise + held.residual * move),
        active.state, active.place,
        np.abs(active.drift) @ (scale * off) + _PLACE * active.place,
        np.where(curve, 1.0, problem.travel) * np.exp(0.5 * active.level), weight,
        np.abs(table)[:, :-1] @ (bent.T @ weight) + _PLACE, active.limit, held.residual, used,
        held.lower, held.upper, agreeing,
        unsprung=bool(np.any(held.lower[:n] & (lower[:n] > problem.stiffness[0]))),
    )  # fmt: skip


def _set_of_optima(best: Descent, agreeing: int, used: int) -> BandTuning:
    k, z = np.split(best.point, 2)
    peak, none = float(np.exp(0.5 * best.levels.top)), np.zeros(0)
    unknown, no = np.full(len(k), np.inf), np.zeros(2 * len(k), dtype=bool)
    places = np.zeros(0, dtype=int)
    return BandTuning(
        k, z, peak, unknown, unknown, 4e-15 * peak, places, none, none, none, none, none, places,
        0.0, used, no, no, agreeing, True,
    )  # fmt: skip


def tuned_to(problem: BandProblem, frequency: float) -> BandTuning:
    """The absorber that swings at one frequency ratio, with the least damping within its bounds.

    Without damping its mass takes all of a force on the primary there, and the primary rests where
    the absorber is. Its largest response in the band tells what a spread of frequency costs.
    Raises NumericalFailure where a resonance without damping stands in the band.
    """
    point = np.array([problem.mass[0] * frequency**2, problem.damping[0]])
    here = levels_at(problem, point)
    active, off = here.some(here.depth < 2e-7), np.array([8.0, 4.0]) * EPSILON * point
    largest = float(np.exp(0.5 * here.top))
    error = float(np.max(active.error)) + float(np.max(np.abs(active.slope) @ off))
    none, no = np.zeros(len(active.level)), np.zeros(2, dtype=bool)
    return BandTuning(
        point[:1], point[1:], largest, off[:1], off[1:], 0.5 * largest * error, active.state,
        active.place, np.abs(active.drift) @ off + _PLACE * active.place,
        np.exp(0.5 * active.level), none, none, active.limit, 0.0, 1, no, no,
    )  # fmt: skip
