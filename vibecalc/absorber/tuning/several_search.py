"""Search for the minimax of several absorbers: problem, starts, descent, last Newton steps."""

from typing import NamedTuple

import numpy as np

from vibecalc.absorber.several import Several
from vibecalc.absorber.several_peaks import several_peaks, several_slopes
from vibecalc.absorber.transfer import transfer_of
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.least_norm import nonnegative_least_squares

# ----------------------------------------------------------------------------
# What is made small with several absorbers, its limits, and all peaks at a point with slopes.
# ----------------------------------------------------------------------------

#: peaks lower than the largest by this share of it are left out
_LOW = 1e-3


class Travel(NamedTuple):
    """The motion of `absorber` (from 1) against what it hangs on may not exceed `limit`."""

    absorber: int
    limit: float


class TuningProblem(NamedTuple):
    """min over k (n) and z (n) within bounds of the largest |H| over frequency.

    `lower`, `upper` (q,): k first, then z; infinite for none. `travel`: largest spring travels,
    in the unit in which displacement is measured (see `transfer_of`). With `shares` the unknowns
    go on with the shares of the first n - 1 masses in the sum of `mass_ratio`. Absorbers marked in
    `locked` are fastened rigidly; their k and z count for nothing.
    """

    primary_damping: float
    mass_ratio: np.ndarray
    parent: tuple[int, ...]
    excitation: str
    response: str
    lower: np.ndarray
    upper: np.ndarray
    travel: tuple[Travel, ...] = ()
    absorber: int = 1
    shares: bool = False
    locked: tuple[bool, ...] = ()

    def system(self, ratios: np.ndarray) -> Several:
        """The system at a point (q,)."""
        count = len(self.mass_ratio)
        k, z = ratios[:count], ratios[count : 2 * count]
        if any(self.locked):
            k = np.where(self.locked, np.inf, k)
        return Several(self.primary_damping, self.masses(ratios), k, z, self.parent)

    def masses(self, ratios: np.ndarray) -> np.ndarray:
        """Mass ratios (n,) at a point. Raises NumericalFailure where the last is used up."""
        if not self.shares:
            return self.mass_ratio
        part = ratios[2 * len(self.mass_ratio) :]
        if np.sum(part) >= 1.0:
            raise NumericalFailure("the shares of the masses leave nothing for the last")
        return np.asarray(np.sum(self.mass_ratio) * np.append(part, 1.0 - np.sum(part)))

    def onto(self) -> np.ndarray:
        """(q, 3 n + 1): which ratios, in the order of `several_slopes`, each unknown moves."""
        count = len(self.mass_ratio)
        table = np.eye(3 * count + 1)[: 2 * count]
        if not self.shares:
            return table
        masses = np.eye(3 * count + 1)[2 * count + 1 :]
        return np.concatenate([table, np.sum(self.mass_ratio) * (masses[:-1] - masses[-1])])


class Rows(NamedTuple):
    """Levels log |H|^2 (r,) with slopes (r, q) and second derivatives; kind 0 is the objective.

    Kind j > 0 is travel limit j, its level taken against the limit. An end of the frequency range
    (x zero or infinite) has no slope. `shoulder` rows are points of a curve next to its peaks where
    a peak may arise; their frequency stays. `frequency` (r,).
    """

    level: np.ndarray
    slope: np.ndarray
    bend: np.ndarray
    kind: np.ndarray
    frequency: np.ndarray
    error: np.ndarray
    shoulder: np.ndarray

    @property
    def moves(self) -> np.ndarray:
        """Peaks, which a change of ratios moves, against the ends of the frequency range."""
        return np.asarray((self.frequency > 0.0) & np.isfinite(self.frequency))

    def some(self, chosen: np.ndarray) -> "Rows":
        """The chosen rows."""
        return Rows(*(part[chosen] for part in self))


def rows_at(problem: TuningProblem, ratios: np.ndarray) -> Rows:
    """Every peak that counts, of the response and of each limited travel.

    Raises NumericalFailure where a peak is infinite.
    """
    parts = [_of(problem, ratios, problem.response, problem.absorber, 1.0, 0)]
    for number, travel in enumerate(problem.travel, start=1):
        parts.append(
            _of(problem, ratios, "relative_displacement", travel.absorber, travel.limit, number)
        )
    return Rows(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _of(
    problem: TuningProblem, ratios: np.ndarray, response: str, absorber: int, unit: float, kind: int
) -> Rows:
    system, size = problem.system(ratios), len(ratios)
    tops = several_peaks(system, problem.excitation, response, absorber)
    if not np.isfinite(tops.largest):
        raise NumericalFailure(
            f"the largest {response} under {problem.excitation!r} is infinite: it grows with "
            "frequency without bound"
        )
    transfer = transfer_of(problem.excitation, response)
    high = tops.magnitude > _LOW * tops.largest
    x, nearby = tops.frequency[high], tops.shoulder
    top = several_slopes(system, x, transfer, absorber)
    side = several_slopes(system, nearby, transfer, absorber, follow=False)
    ends = [
        (height, where)
        for height, where in ((tops.at_zero, 0.0), (tops.at_infinity, np.inf))
        if height > _LOW * tops.largest
    ]
    flat = len(ends)
    level = np.concatenate(
        [2.0 * np.log(tops.magnitude[high]), side.level, [2.0 * np.log(h) for h, _ in ends]]
    )
    onto = problem.onto()
    slope = np.concatenate([top.first @ onto.T, side.first @ onto.T, np.zeros((flat, size))])
    bend = np.concatenate(
        [onto @ top.second @ onto.T, onto @ side.second @ onto.T, np.zeros((flat, size, size))]
    )
    uncertainty = 2.0 * tops.error[high] / tops.magnitude[high]
    count = len(level)
    return Rows(
        level - 2.0 * np.log(unit), slope, bend, np.full(count, kind),
        np.concatenate([x, nearby, [place for _, place in ends]]),
        np.concatenate([uncertainty, np.full(count - len(x), 1e-15)]),
        (np.arange(count) >= len(x)) & (np.arange(count) < len(x) + len(nearby)),
    )  # fmt: skip


def largest(rows: Rows) -> tuple[float, float]:
    """Level of the objective, and by how much the worst travel exceeds its limit (0 if none)."""
    over = float(np.max(rows.level[rows.kind > 0], initial=0.0))
    return float(np.max(rows.level[rows.kind == 0])), max(over, 0.0)


# ----------------------------------------------------------------------------
# Where to start: a few tunings made by rule, then points that fill the usual range evenly.
# ----------------------------------------------------------------------------

_PRIMES = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37)


def usual_size(problem: TuningProblem) -> np.ndarray:
    """Size (q,) of stiffness, damping and share: m, m sqrt(sum m), 1, within finite bounds."""
    m = problem.mass_ratio
    whole = float(np.sum(m))
    # an absorber far heavier than the primary system is stopped by stiffness of order one
    soft = m / (1.0 + whole) ** 2
    drag = m * np.sqrt(whole / (1.0 + whole) ** 3)
    shares = np.ones(len(problem.lower) - 2 * len(m))
    size = np.concatenate([soft, drag, shares])
    upper = np.where(problem.upper > 0.0, problem.upper, np.inf)
    return np.asarray(np.minimum(np.maximum(size, problem.lower), upper))


def starts(problem: TuningProblem, count: int) -> list[np.ndarray]:
    """`count` points (q,) in units of `usual_size`."""
    n, size = len(problem.mass_ratio), len(problem.lower)
    equal = np.full(size - 2 * n, 1.0 / n)
    whole = float(np.sum(problem.mass_ratio))
    points = []
    middle = np.arange(n) - 0.5 * (n - 1)
    for sense in (1.0, -1.0)[: 1 if n == 1 else 2]:
        # neighbours a bandwidth apart, each with its part of the damping
        apart = 1.0 + sense * 1.2 * np.sqrt(whole / (1.0 + whole)) / n * middle
        points.append(np.concatenate([apart**2, np.full(n, 0.61 / np.sqrt(n)), equal]))
    if n > 1:  # one does the work, the others hang on as a stiff or a heavily damped rest
        points.append(np.concatenate([np.ones(n), np.geomspace(0.1, 0.6, n), equal]))
        points.append(np.concatenate([np.ones(n), np.geomspace(0.6, 0.1, n), equal]))
    index = 1
    while len(points) < count:
        unit = np.array([_radical_inverse(index, _PRIMES[i % 12]) for i in range(size)])
        stiff = 0.2 * 10.0 ** unit[:n]
        drag = 0.05 * 30.0 ** unit[n : 2 * n]
        share = unit[2 * n :] / max(float(np.sum(unit[2 * n :])) * 1.05, 1.0)
        points.append(np.concatenate([stiff, drag, np.clip(share, 0.05, 0.95)]))
        index += 1
    return points[:count]


def _radical_inverse(index: int, base: int) -> float:
    """Digits of `index` mirrored at the point (J. H. Halton, 1960)."""
    result, part = 0.0, 1.0 / base
    while index:
        index, digit = divmod(index, base)
        result += digit * part
        part /= base
    return result


# ----------------------------------------------------------------------------
# From a start towards a minimax: sequential quadratic programming on the levels of the peaks.
#
# Near a point every peak is its level plus slope times step; the multipliers of the peaks that hold
# each other up weigh their second derivatives (J. Nocedal and S. J. Wright, Numerical Optimization,
# 2nd ed. 2006, ch. 18). The step is kept inside a box that shrinks when the peaks disappoint.
# ----------------------------------------------------------------------------

_PENALTY = 20.0
_STEPS = 100
#: curvature given to the unknown level, so that the step is a least distance
_SOFT = 1e-3


class Descent(NamedTuple):
    """Where a descent ended: ratios (q,), the peaks there, how many points were evaluated."""

    ratios: np.ndarray
    rows: Rows
    evaluations: int


def descend(problem: TuningProblem, start: np.ndarray, scale: np.ndarray, least: float) -> Descent:
    """Descend until the box is smaller than `least` (relative); `scale` (q,) is a usual size.

    Raises NumericalFailure where the peaks at the start are infinite.
    """
    lower, upper = problem.lower / scale, problem.upper / scale
    point = np.clip(start / scale, lower, upper)
    rows = rows_at(problem, point * scale)
    reach, used = 0.3, 1
    for _ in range(_STEPS):
        size = reach * np.maximum(np.abs(point), 0.05)
        box = np.maximum(lower, point - size) - point, np.minimum(upper, point + size) - point
        level, over = largest(rows)
        step, promised = _quadratic_step(_scaled(rows, scale), box)
        if promised <= 1e-13:
            break
        trial = np.clip(point + step, lower, upper)
        used += 1
        try:
            there = rows_at(problem, trial * scale)
            new, beyond = largest(there)
            gain = (level + _PENALTY * over) - (new + _PENALTY * beyond)
        except NumericalFailure:
            gain = -1.0
        if gain > 0.1 * promised:
            point, rows = trial, there
            if gain > 0.7 * promised:
                reach = min(2.0 * reach, 1.0)
        else:
            reach *= 0.3
        if reach < least:
            break
    return Descent(point * scale, rows, used)


def _scaled(rows: Rows, scale: np.ndarray) -> Rows:
    return rows._replace(slope=rows.slope * scale, bend=rows.bend * scale[:, None] * scale[None, :])


def multipliers(rows: Rows, lower: np.ndarray, upper: np.ndarray) -> tuple[np.ndarray, float]:
    """Weights of the rows (objective rows add to one) that best cancel their slopes, and the rest.

    `lower`, `upper`: masks of ratios that stand on a bound, which may hold against the slope.
    """
    size = rows.slope.shape[1]
    unit = np.eye(size)
    walls = np.concatenate([-unit[lower], unit[upper]])
    heavy = 1e3 * max(float(np.max(np.abs(rows.slope), initial=0.0)), 1.0)
    table = np.concatenate([rows.slope, walls])
    sums = np.concatenate([heavy * (rows.kind == 0), np.zeros(len(walls))])
    found = nonnegative_least_squares(
        np.concatenate([table.T, sums[None]]), np.append(np.zeros(size), heavy)
    )
    return found[: len(rows.level)], float(np.linalg.norm(found @ table))


def _quadratic_step(rows: Rows, box: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, float]:
    """Step that lowers the model most, and by how much it does."""
    level, over = largest(rows)
    close = rows.level > np.where(rows.kind == 0, level, 0.0) - 0.3
    weight, _ = multipliers(rows.some(close), box[0] >= 0.0, box[1] <= 0.0)
    bend = np.tensordot(weight, rows.bend[close], 1)
    values, vectors = np.linalg.eigh(0.5 * (bend + bend.T))
    floor = 1e-3 * max(float(np.max(np.abs(values))), 1e-3)
    values = np.maximum(np.abs(values), floor)
    step = np.clip(_least_distance(rows, level, (values, vectors), box), *box)
    on_curve = rows.kind == 0
    moved = rows.level + rows.slope @ step
    bent = 0.5 * float(values @ (step @ vectors) ** 2)
    model = float(np.max(moved[on_curve])) + bent
    excess = max(float(np.max(moved[~on_curve], initial=0.0)), 0.0)
    return step, level + _PENALTY * over - model - _PENALTY * excess


def _least_distance(
    rows: Rows, level: float, bend: tuple[np.ndarray, np.ndarray],
    box: tuple[np.ndarray, np.ndarray],
) -> np.ndarray:  # fmt: skip
    """min t + penalty s + d' B d / 2 over steps d, rows below t (travels below s >= 0), d in a box.

    With a little curvature given to t and s it is the point of a polyhedron nearest to the origin
    (C. L. Lawson and R. J. Hanson, Solving Least Squares Problems, 1974, ch. 23).
    """
    values, vectors = bend
    size, count = len(values), len(rows.level)
    back = vectors / np.sqrt(values)  # step from the scaled unknowns
    on_curve = (rows.kind == 0).astype(float)
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


class OptimalPoint(NamedTuple):
    """A point that meets the conditions.

    `active` marks the rows that hold it, `weight` (r,) their multipliers (those of the objective
    add to one), `on_lower`, `on_upper` (q,) the bounds that do, `residual` what is left of the
    weighted slopes, `curvature` the least second derivative along directions that leave all active
    peaks alone (infinite if there are none), `step` the last step, all in units of `scale`.
    """

    ratios: np.ndarray
    rows: Rows
    active: np.ndarray
    weight: np.ndarray
    on_lower: np.ndarray
    on_upper: np.ndarray
    residual: float
    curvature: float
    step: float
    evaluations: int


def hold(problem: TuningProblem, start: np.ndarray, scale: np.ndarray) -> OptimalPoint | None:
    """Newton from near a minimax; None where no set of peaks and bounds holds a point nearby."""
    used = 0
    for tie in _TIE:
        found, more = _with(problem, start, scale, tie)
        used += more
        if found is not None:
            return found._replace(evaluations=used)
    return None


def _with(
    problem: TuningProblem, start: np.ndarray, scale: np.ndarray, tie: float
) -> tuple[OptimalPoint | None, int]:
    ratios, used = start, 0
    first = np.inf
    length, before = 0.0, 1.0
    for _ in range(_NEWTON_STEPS):
        try:
            rows = rows_at(problem, ratios)
            rows = rows.some(~rows.shoulder)
        except NumericalFailure:
            return None, used
        used += 1
        wall = min(tie, 1e-3) * scale
        on_lower, on_upper = ratios <= problem.lower + wall, ratios >= problem.upper - wall
        top, over = largest(rows)
        first = min(first, top + over)
        gap = np.where(rows.kind == 0, top - rows.level, -rows.level)
        near = gap <= np.where(rows.moves, max(tie, min(4.0 * length, 0.1)), 1e-9)
        local = rows._replace(slope=rows.slope * scale)
        weight, _ = multipliers(local.some(near), on_lower, on_upper)
        weight_all = np.zeros(len(rows.level))
        weight_all[near] = weight
        active = weight_all > 1e-9
        free = ~(on_lower & _holds(weight_all @ local.slope, 1.0)) & ~(
            on_upper & _holds(weight_all @ local.slope, -1.0)
        )
        free &= problem.upper > problem.lower
        solved = _solve(rows, scale, active, weight_all, free)
        if solved is None:
            return None, used
        step, curvature = solved
        length = float(np.max(np.abs(step), initial=0.0))
        if length > 0.5:
            step *= 0.5 / length
        moved = np.clip(ratios + scale * step, problem.lower, problem.upper)
        moved = np.where(free, moved, np.where(on_lower, problem.lower, problem.upper))
        moved = np.where(free | on_lower | on_upper, moved, ratios)
        # a short step squares in the next one
        if length < 1e-13 or (length < 1e-9 and before < 1e-9):
            break
        ratios, before = moved, length
    else:
        return None, used
    residual_slope = weight_all @ local.slope
    residual = float(np.linalg.norm(residual_slope[free]))
    far = 1e-9 + 1e2 * float(np.max(rows.error))
    spread = float(np.ptp(rows.level[active & (rows.kind == 0)]))
    curve_weight = float(np.sum(weight_all[active & (rows.kind == 0)]))
    fine = residual < 1e-6 and spread < far and abs(curve_weight - 1.0) < 1e-6
    fine &= bool(np.max(rows.level[rows.kind > 0], initial=0.0) < far)
    fine &= curvature > -1e-7 and top <= first + 1e-7
    if not fine:
        return None, used
    return (
        OptimalPoint(ratios, rows, active, weight_all, on_lower & ~free, on_upper & ~free, residual,
             curvature, length, used),
        used,
    )  # fmt: skip


def _holds(pull: np.ndarray, sign: float) -> np.ndarray:
    """Where the weighted slope presses against the bound."""
    pressed: np.ndarray = sign * pull > 1e-9
    return pressed


def _solve(
    rows: Rows, scale: np.ndarray, active: np.ndarray, weight: np.ndarray, free: np.ndarray
) -> tuple[np.ndarray, float] | None:
    """Newton's step (q,) in units of scale, and the least curvature left free."""
    held = rows.some(active)
    bend = np.tensordot(weight[active], held.bend, 1) * scale[:, None] * scale[None, :]
    bend = bend[np.ix_(free, free)]
    slope = (held.slope * scale)[:, free]
    on_curve = (held.kind == 0).astype(float)
    count, width = len(held.level), int(np.sum(free))
    if not count or not np.any(on_curve):
        return None
    level = float(np.max(held.level[held.kind == 0]))
    table = np.zeros((width + count + 1, width + count + 1))
    table[:width, :width] = bend
    table[:width, width:-1] = slope.T
    table[width:-1, :width] = slope
    table[width:-1, -1] = -on_curve
    table[-1, width:-1] = on_curve
    right = np.zeros(width + count + 1)
    right[width:-1] = on_curve * level - held.level
    right[-1] = 1.0
    solution = np.linalg.lstsq(table, right, rcond=1e-13)[0]
    step = np.zeros(len(free))
    step[free] = solution[:width]
    # directions in which all active levels stay together
    differences = slope - np.outer(on_curve, on_curve @ slope / np.sum(on_curve))
    _, singular, turned = np.linalg.svd(differences, full_matrices=True)
    rank = int(np.sum(singular > 1e-9 * max(float(np.max(singular, initial=0.0)), 1e-300)))
    loose = turned[rank:]
    curvature = np.inf
    if len(loose):
        curvature = float(np.min(np.linalg.eigvalsh(loose @ bend @ loose.T)))
    return step, curvature
