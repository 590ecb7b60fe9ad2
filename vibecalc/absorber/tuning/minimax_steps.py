"""Steps of the minimax tuning: peaks with derivatives, descent, Newton, optimality."""

import math
from typing import NamedTuple

import numpy as np

from vibecalc.absorber.peaks import Peaks, maxima, peaks
from vibecalc.absorber.squared_magnitude import Measure, Term, columns, excess_derivatives, measure
from vibecalc.absorber.transfer import Absorber, Coupling, Transfer, transfer_of
from vibecalc.numerics.least_norm import nonnegative_least_squares
from vibecalc.numerics.rounding import UNIT_ROUNDOFF

# ----------------------------------------------------------------------------
# A peak of the response in logarithms, with all derivatives that a tuning needs.
# ----------------------------------------------------------------------------


class Tunings(NamedTuple):
    """Points (n,) to be tuned: ratios that stay, and the weights of the response made small."""

    primary_damping: np.ndarray
    mass_ratio: np.ndarray
    weights: Measure

    def some(self, rows: np.ndarray) -> "Tunings":
        """The chosen points."""
        return Tunings(
            self.primary_damping[rows], self.mass_ratio[rows],
            Measure(*(a[rows] for a in self.weights)),
        )  # fmt: skip

    def parts(self, place: np.ndarray) -> Coupling:
        """The system at place (2, n): logarithms of k and of 2 z2."""
        z1, m = self.primary_damping, self.mass_ratio
        g0, g1 = np.exp(place)
        return Coupling(z1, m, m, g0, g1, np.zeros(m.shape, dtype=int))


def tunings(primary_damping: np.ndarray, mass_ratio: np.ndarray, transfer: Transfer) -> Tunings:
    """Points for arrays (n,)."""
    zero = np.zeros(mass_ratio.shape)
    parts = Coupling(primary_damping, mass_ratio, mass_ratio, zero, zero, zero.astype(int))
    return Tunings(primary_damping, mass_ratio, measure(parts, transfer))


class Terms(NamedTuple):
    """What `log_slopes` needs of a point besides its place: arrays (n,), or single numbers.

    `weights`: see `squared_magnitude.columns`.
    """

    primary_damping: Term
    mass_ratio: Term
    floor_squared: Term
    weights: tuple[tuple[Term, ...], ...]

    def at(self, rows: np.ndarray) -> "Terms":
        """The chosen points."""
        z1, m, floor, weights = self
        some = tuple(tuple(column[rows] for column in weight) for weight in weights)
        return Terms(z1[rows], m[rows], floor[rows], some)

    def alone(self, row: int) -> "Terms":
        """One point, in plain numbers."""
        z1, m, floor, weights = self
        some = tuple(tuple(float(column[row]) for column in weight) for weight in weights)
        return Terms(float(z1[row]), float(m[row]), float(floor[row]), some)


def terms_of(points: Tunings) -> Terms:
    """The same points, entry by entry."""
    floor, *weights = points.weights
    return Terms(points.primary_damping, points.mass_ratio, floor, tuple(map(columns, weights)))


class Slopes(NamedTuple):
    """w = ln(A / Q) at y = ln u with derivatives by y and by ln k and ln z2; each (...)."""

    level: Term
    y: Term
    yy: Term
    k: Term
    z: Term
    yk: Term
    yz: Term
    kk: Term
    kz: Term
    zz: Term


def slopes(points: Tunings, place: np.ndarray, y: np.ndarray) -> Slopes:
    """Derivatives at `place` (2, n) and `y` (..., n). NaN where A is not positive."""
    if place.shape[1] == 1:
        alone, (log_k, log_z) = terms_of(points).alone(0), place[:, 0].tolist()
        try:
            each = [log_slopes(alone, log_k, log_z, one) for one in y.ravel().tolist()]
            return Slopes(*(np.reshape(part, y.shape) for part in zip(*each, strict=True)))
        except (ArithmeticError, ValueError):
            pass
    with np.errstate(invalid="ignore"):
        return log_slopes(terms_of(points), place[0], place[1], y)


def log_slopes(terms: Terms, log_k: Term, log_z: Term, y: Term) -> Slopes:
    """The same for arrays, or for one point in plain numbers, which is ten times faster.

    Plain numbers raise ArithmeticError or ValueError where arrays become infinite or NaN.
    """
    z1, m, floor, weights = terms
    exp, log = (math.exp, math.log) if isinstance(y, float) else (np.exp, np.log)
    g0, g1, u = exp(log_k), exp(log_z), exp(y)
    above, below = excess_derivatives(z1, m, m, g0, g1, u, floor, weights)
    scale = (u, u * u, g0, g1, u * g0, u * g1, g0 * g0, g0 * g1, g1 * g1)
    a_u, a_uu, a_k, a_z, a_uk, a_uz, a_kk, a_kz, a_zz = (
        slot * by / above[0] for slot, by in zip(above[1:], scale, strict=True)
    )
    q_u, q_uu, q_k, q_z, q_uk, q_uz, q_kk, q_kz, q_zz = (
        slot * by / below[0] for slot, by in zip(below[1:], scale, strict=True)
    )
    by_y, by_k, by_z = a_u - q_u, a_k - q_k, a_z - q_z
    level = log(above[0] / below[0])
    # in logarithms a second derivative by one variable gains the first
    return Slopes(
        level, by_y, a_uu - a_u * a_u - q_uu + q_u * q_u + by_y, by_k, by_z,
        a_uk - a_u * a_k - q_uk + q_u * q_k, a_uz - a_u * a_z - q_uz + q_u * q_z,
        a_kk - a_k * a_k - q_kk + q_k * q_k + by_k, a_kz - a_k * a_z - q_kz + q_k * q_z,
        a_zz - a_z * a_z - q_zz + q_z * q_z + by_z,
    )  # fmt: skip


class ReducedPeak(NamedTuple):
    """The level of a peak as a function of ln k and ln z2 alone, its frequency following."""

    level: Term
    k: Term
    z: Term
    kk: Term
    kz: Term
    zz: Term

    @property
    def p(self) -> np.ndarray:
        """Slopes (2, ...)."""
        return np.stack([self.k, self.z])

    @property
    def pp(self) -> np.ndarray:
        """Second derivatives (3, ...)."""
        return np.stack([self.kk, self.kz, self.zz])


def reduced(at: Slopes) -> ReducedPeak:
    """Eliminate y: the peak of the parabola through the point (to second order)."""
    step, by_k, by_z = at.y / at.yy, at.yk / at.yy, at.yz / at.yy
    return ReducedPeak(
        at.level - 0.5 * at.y * step, at.k - at.yk * step, at.z - at.yz * step,
        at.kk - at.yk * by_k, at.kz - at.yk * by_z, at.zz - at.yz * by_z,
    )  # fmt: skip


def times(bend: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Symmetric 2 x 2 matrices (3, n) times vectors (2, n)."""
    kk, kz, zz = bend
    return np.stack([kk * vector[0] + kz * vector[1], kz * vector[0] + zz * vector[1]])


# ----------------------------------------------------------------------------
# Descent of the largest peak, with all peaks found afresh, to where Newton takes over.
# ----------------------------------------------------------------------------

#: first and largest change of ln k and ln z2 in one step
_FIRST, _LARGEST = 0.5, 1.5
#: a step this short leaves the rest to Newton's method
_SHORT = 0.02


class PeakPair(NamedTuple):
    """Best place (2, n), ln u of its two highest peaks (2, n) and their excess (2, n).

    A place without a second peak has its excess as zero; without any peak above the floor, both.
    """

    place: np.ndarray
    y: np.ndarray
    excess: np.ndarray
    evaluations: np.ndarray


def two_highest(points: Tunings, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """ln u and excess (2, n) of the two highest maxima above the floor, by rising frequency."""
    count = place.shape[1]
    tops = maxima(points.parts(place), points.weights)
    rows, u, value = tops.row, tops.place.value, tops.height.value
    high = value > 0.0
    rows, u, value = rows[high], u[high], value[high]
    order = np.lexsort((-value, rows))
    rows, u, value = rows[order], u[order], value[order]
    rank = np.arange(len(rows)) - np.searchsorted(rows, rows)
    y, level = np.zeros((2, count)), np.zeros((2, count))
    two = rank < 2
    y[rank[two], rows[two]] = np.log(u[two])
    level[rank[two], rows[two]] = value[two]
    swap = (level[1] > 0.0) & (y[1] < y[0])
    y[:, swap], level[:, swap] = y[::-1, swap], level[::-1, swap]
    return y, level


def descend(
    points: Tunings, place: np.ndarray, rounds: int = 60, short: float = _SHORT
) -> PeakPair:
    """Lower the largest peak from `place` (2, n) until the step is `short` or no peak is left."""
    best = place.copy()
    y, level = two_highest(points, best)
    used = np.ones(place.shape[1], dtype=int)
    reach = np.full(place.shape[1], _FIRST)
    live = np.flatnonzero(np.max(level, axis=0) > 0.0)
    for _ in range(rounds):
        if not len(live):
            break
        now = points.some(live)
        step = _step(now, best[:, live], y[:, live], level[:, live], reach[live])
        size = np.max(np.abs(step), axis=0)
        trial_y, trial_level = two_highest(now, best[:, live] + step)
        used[live] += 1
        top, old = np.max(trial_level, axis=0), np.max(level[:, live], axis=0)
        better = top < old
        moved = live[better]
        best[:, moved] += step[:, better]
        y[:, moved], level[:, moved] = trial_y[:, better], trial_level[:, better]
        full = size > 0.9 * reach[live]
        grown = np.where(full, np.minimum(2.0 * reach[live], _LARGEST), reach[live])
        reach[live] = np.where(better, grown, 0.3 * size)
        ended = (better & (size < short) & np.all(trial_level > 0.0, axis=0)) | (
            reach[live] < 1e-3 * short
        )
        live = live[~(ended | (better & (top <= 0.0)))]
    return PeakPair(best, y, level, used)


def _step(
    points: Tunings, place: np.ndarray, y: np.ndarray, level: np.ndarray, reach: np.ndarray
) -> np.ndarray:
    """Step (2, n) of the model of one or two peaks, no longer than `reach` in either logarithm."""
    with np.errstate(all="ignore"):
        flat = reduced(slopes(points, place, y))
        main = np.argmax(level, axis=0)
        chosen = np.arange(place.shape[1])
        alone = _downhill(flat, main, chosen, reach)
        both = _balanced(flat, reach)
        usable = np.all(level > 0.0, axis=0) & np.all(np.isfinite(both), axis=0)
    step = np.where(usable, both, alone)
    return np.where(np.isfinite(step), step, 0.0)


def _downhill(
    flat: ReducedPeak, main: np.ndarray, chosen: np.ndarray, reach: np.ndarray
) -> np.ndarray:
    """Newton's step of the higher peak where it bends upwards, else along its slope."""
    slope, bend = flat.p[:, main, chosen], flat.pp[:, main, chosen]
    kk, kz, zz = bend
    whole = kk * zz - kz * kz
    newton = -np.stack([zz * slope[0] - kz * slope[1], kk * slope[1] - kz * slope[0]]) / whole
    convex = (whole > 0.0) & (kk > 0.0)
    step = np.where(convex, newton, -slope * reach / np.max(np.abs(slope), axis=0))
    return _within(step, reach)


def _balanced(flat: ReducedPeak, reach: np.ndarray) -> np.ndarray:
    """Step to equal peaks and down along them; NaN where one peak would carry all the weight."""
    apart = flat.p[:, 0] - flat.p[:, 1]
    length = np.hypot(*apart)
    across = apart / length
    along = np.stack([-across[1], across[0]])
    close = -across * (flat.level[0] - flat.level[1]) / length
    weight = -np.sum(apart * flat.p[:, 1], axis=0) / length**2
    share = np.clip(weight, 0.0, 1.0)
    bend = share * flat.pp[:, 0] + (1.0 - share) * flat.pp[:, 1]
    pull = np.sum(along * (flat.p[:, 1] + times(bend, close)), axis=0)
    curve = np.abs(np.sum(along * times(bend, along), axis=0))
    step = _within(close, reach) - along * np.clip(pull / curve, -reach, reach)
    return np.where((weight > 0.0) & (weight < 1.0), _within(step, reach), np.nan)


def _within(step: np.ndarray, reach: np.ndarray) -> np.ndarray:
    shorter: np.ndarray = step * np.minimum(1.0, reach / np.max(np.abs(step), axis=0))
    return shorter


# ----------------------------------------------------------------------------
# Newton's method on the conditions that hold the two peaks at the optimum.
# ----------------------------------------------------------------------------

#: largest change of a logarithm in one step
_REACH = 0.7


class Balance(NamedTuple):
    """Where two peaks hold each other: place (2, n), ln u of the peaks (2, n), weight of the first.

    `curvature` (n,) of the common level along the line on which the peaks stay equal; `gap` of
    the two levels; `step` the size of the last step; `evaluations` of a peak, (n,).
    """

    place: np.ndarray
    y: np.ndarray
    weight: np.ndarray
    curvature: np.ndarray
    gap: np.ndarray
    step: np.ndarray
    evaluations: np.ndarray


def two_peaks(
    points: Tunings, place: np.ndarray, y: np.ndarray, most: int = 14,
    enough: float | np.ndarray = 1e-9,
) -> Balance:  # fmt: skip
    """Solve for equal peaks whose slopes oppose each other.

    Unknowns are ln k, ln z2, the two ln u and the weight w of the first peak; equations: both
    peaks stationary, their levels equal, w grad_1 + (1 - w) grad_2 = 0. The frequencies are
    eliminated, then the step along the difference of the gradients, so that only the curvature
    along equal peaks is divided by; where it is not positive the step goes downhill instead.
    `enough` (n,): step after which a point is done; convergence is quadratic.
    Points that leave the region where there are two peaks come back as NaN.
    """
    count = place.shape[1]
    state = np.concatenate([place, y, np.full((1, count), 0.5)])
    last = np.full((3, count), np.nan)
    last[2] = np.inf
    used = np.zeros(count, dtype=int)
    live = np.arange(count)
    goal = np.broadcast_to(enough, (count,))
    terms = terms_of(points)
    with np.errstate(all="ignore"):
        for _ in range(most):
            moved = _moved(terms, state, live)
            used[live] += 2
            change = moved[:4]
            change[:2, moved[7] >= 0.0] = np.nan
            state[:4, live] += change
            state[4, live] = moved[4]
            size = np.max(np.abs(change), axis=0)
            last[:2, live], last[2, live] = moved[5:7], size
            live = live[np.isfinite(size) & (size > goal[live])]
            if not len(live):
                break
    return Balance(state[:2], state[2:4], state[4], last[0], last[1], last[2], used)


def _moved(terms: Terms, state: np.ndarray, live: np.ndarray) -> np.ndarray:
    """What `_newton` finds for the rows of `state` (5, n) that are `live`: (8, live)."""
    if len(live) > 1:
        return np.stack(_newton(terms.at(live), *state[:, live]))
    try:
        alone = _newton(terms.alone(live[0]), *state[:, live[0]].tolist())
    except (ArithmeticError, ValueError):
        alone = (math.nan,) * 8
    return np.array(alone)[:, None]


def _clipped(value: Term, low: float, high: float) -> Term:
    """As `np.clip`; a plain number stays one, NaN stays NaN."""
    if isinstance(value, float):
        return min(max(value, low), high)
    return np.clip(value, low, high)


def _newton(
    terms: Terms, log_k: Term, log_z: Term, y_first: Term, y_second: Term, w: Term
) -> tuple[Term, ...]:
    """Changes of ln k, ln z2 and of both y, the new weight, curvature, gap, larger bend by y."""
    first, second = (log_slopes(terms, log_k, log_z, y) for y in (y_first, y_second))
    one, two = reduced(first), reduced(second)
    v = 1.0 - w
    kk, kz, zz = w * one.kk + v * two.kk, w * one.kz + v * two.kz, w * one.zz + v * two.zz
    apart_k, apart_z = one.k - two.k, one.z - two.z
    square = apart_k * apart_k + apart_z * apart_z
    gap = one.level - two.level
    # across to equal levels, and along them
    close_k, close_z = -apart_k * gap / square, -apart_z * gap / square
    pull = apart_k * (two.z + kz * close_k + zz * close_z) - apart_z * (
        two.k + kk * close_k + kz * close_z
    )
    curve = apart_z * (kk * apart_z - 2.0 * kz * apart_k) + zz * apart_k * apart_k
    along = pull / abs(curve)
    step_k, step_z = close_k + apart_z * along, close_z - apart_k * along
    larger = max if isinstance(step_k, float) else np.maximum
    shrink = _clipped(_REACH / larger(abs(step_k), abs(step_z)), 0.0, 1.0)
    step_k, step_z = step_k * shrink, step_z * shrink
    turned = apart_k * (two.k + kk * step_k + kz * step_z)
    turned += apart_z * (two.z + kz * step_k + zz * step_z)
    weight = _clipped(-turned / square, 0.02, 0.98)
    # a frequency moves with the tuning and to the top of its own parabola
    shifts = (
        _clipped(-(p.y + p.yk * step_k + p.yz * step_z) / p.yy, -_REACH, _REACH)
        for p in (first, second)
    )
    bend = larger(first.yy, second.yy)
    return step_k, step_z, *shifts, weight, curve / square, gap, bend


# ----------------------------------------------------------------------------
# Is a tuning optimal: which peaks are active, and is there a direction that lowers them all?
# ----------------------------------------------------------------------------

#: peaks this close, relative to the excess over the floor, are one height
_EQUAL = 1e-9
#: slopes of ln (excess) that balance to this are balanced
_BALANCED = 1e-6

#: what was found: `VERDICTS[certificate.verdict]`
VERDICTS = ("isolated", "boundary", "set", "not_optimal")
ISOLATED, BOUNDARY, SET, NOT_OPTIMAL = range(4)


class Certificate(NamedTuple):
    """All (...), or (..., 4) per peak in the order of `peaks`.

    `largest`: the true supremum of |H|, from all stationary points and both ends. `active`: peaks
    that reach it; `weight`: their weights in the balance. `residual`: length of the shortest
    convex combination of their slopes by (ln k, ln z2), over the longest slope: zero where no
    small change of k and z2 lowers them all; at k = 0 or z2 = 0 only changes inwards count, by
    k / m or z2 / m. `curvature` of the common level along the line of equal heights, positive
    where the optimum is isolated; for a single active peak the smaller curvature of its level;
    infinite where the boundary leaves no direction. `verdict`: index into `VERDICTS`;
    set: the supremum is a limit at x = 0 or infinity that no absorber changes.
    """

    largest: np.ndarray
    active: np.ndarray
    weight: np.ndarray
    residual: np.ndarray
    curvature: np.ndarray
    verdict: np.ndarray


def certify(
    absorber: Absorber, excitation: str = "force", response: str = "displacement",
    equal: float = _EQUAL,
) -> Certificate:  # fmt: skip
    """Check tunings (...) against the first- and second-order conditions of the minimax.

    Independent of how the tuning was found: peaks come from the stationarity polynomial. `equal`
    is the relative difference in excess below which peaks count as equal. The check is local in
    (k, z2) and complete in frequency. Infinite k or z2 are not judged: not_optimal.
    """
    transfer = transfer_of(excitation, response)
    z1, m, k, z2 = np.broadcast_arrays(*(np.asarray(a, dtype=float) for a in absorber))
    shape = m.shape
    tops = peaks(Absorber(z1, m, k, z2), excitation, response)
    z1, m, k, z2 = (np.array(a).reshape(-1) for a in (z1, m, k, z2))
    flat = Peaks(*(np.reshape(a, (m.size, *a.shape[len(shape) :])) for a in tops))
    points = tunings(z1, m, transfer)
    floor = np.sqrt(points.weights.floor_squared)
    top = np.max(np.where(flat.present, flat.excess, -np.inf), axis=1)
    usable = np.isfinite(k) & np.isfinite(z2) & np.isfinite(flat.largest) & (k + z2 > 0.0)
    on_floor = (top <= 0.0) & (floor > 0.0) & (flat.largest <= floor * (1.0 + 8.0 * UNIT_ROUNDOFF))
    usable &= ~on_floor & np.isfinite(top) & (top > 0.0)
    active = flat.present & (flat.excess >= top[:, None] * (1.0 - equal)) & usable[:, None]

    weight = np.zeros(active.shape)
    residual, curvature = np.full(m.size, np.inf), np.full(m.size, -np.inf)
    for row in np.flatnonzero(usable):
        which = np.flatnonzero(active[row])
        y = 2.0 * np.log(flat.frequency[row, which])
        slope, bend = _peak_derivatives(z1[row], m[row], k[row], z2[row], y, transfer)
        inward = np.array([k[row] == 0.0, z2[row] == 0.0])
        shares, residual[row] = _shortest(slope, inward)
        weight[row, which] = shares
        curvature[row] = _curvature(slope, bend, shares, inward)
    verdict = np.where(residual <= _BALANCED, ISOLATED, NOT_OPTIMAL)
    edge = (k == 0.0) | (z2 == 0.0)
    verdict = np.where((verdict == ISOLATED) & edge, BOUNDARY, verdict)
    verdict = np.where((verdict != NOT_OPTIMAL) & ~(curvature > 0.0), NOT_OPTIMAL, verdict)
    verdict = np.where(on_floor, SET, verdict)
    residual, curvature = np.where(on_floor, 0.0, residual), np.where(on_floor, 0.0, curvature)
    columns = (flat.largest, active, weight, residual, curvature, verdict)
    return Certificate(*(a.reshape((*shape, *a.shape[1:])) for a in columns))


def _peak_derivatives(
    z1: float, m: float, k: float, z2: float, y: np.ndarray, transfer: Transfer
) -> tuple[np.ndarray, np.ndarray]:
    """Slopes (peaks, 2) and curvatures (peaks, 3) of ln (excess), the frequencies following.

    By ln k and ln z2; by k / m and z2 / m where these are zero.
    """
    terms = terms_of(tunings(np.full(len(y), z1), np.full(len(y), m), transfer))
    g1 = 2.0 * z2
    u = np.exp(y)
    above, below = excess_derivatives(z1, m, m, k, g1, u, terms.floor_squared, terms.weights)
    unit = [k if k > 0.0 else m, g1 if g1 > 0.0 else 2.0 * m]
    scale = [1.0, u, u * u, unit[0], unit[1], u * unit[0], u * unit[1],
             unit[0] ** 2, unit[0] * unit[1], unit[1] ** 2]  # fmt: skip
    a, q = (
        np.stack([part / side[0] * factor for part, factor in zip(side, scale, strict=True)])
        for side in (above, below)
    )
    first = a - q
    pairs = ((2, 1, 1), (5, 1, 3), (6, 1, 4), (7, 3, 3), (8, 3, 4), (9, 4, 4))
    second = [a[i] - a[j] * a[n] - q[i] + q[j] * q[n] for i, j, n in pairs]
    # only a derivative by a logarithm gains the first one
    log_k, log_z = float(k > 0.0), float(g1 > 0.0)
    whole = reduced(
        Slopes(
            first[0], first[1], second[0] + first[1], first[3], first[4], second[1], second[2],
            second[3] + log_k * first[3], second[4], second[5] + log_z * first[4],
        )
    )  # fmt: skip
    return whole.p.T, whole.pp.T


def _shortest(slope: np.ndarray, inward: np.ndarray) -> tuple[np.ndarray, float]:
    """Weights (sum 1) of the shortest convex combination of slopes, and its relative length.

    A component along which only inward changes are allowed counts where it falls inwards.
    """
    size = max(float(np.max(np.linalg.norm(slope, axis=1))), 1e-300)
    columns = [slope.T / size, -np.eye(2)[:, inward]]
    table = np.concatenate(columns, axis=1)
    heavy = 1e6
    table = np.vstack([table, heavy * (np.arange(table.shape[1]) < len(slope))])
    solved = nonnegative_least_squares(table, np.array([0.0, 0.0, heavy]))
    shares = _settled(np.concatenate(columns, axis=1), solved > 0.0, len(slope))
    if shares is None:
        shares = solved[: len(slope)] / np.sum(solved[: len(slope)])
    left = slope.T @ shares / size
    left = np.where(inward, np.minimum(left, 0.0), left)
    return shares, float(np.linalg.norm(left))


def _settled(columns: np.ndarray, held: np.ndarray, count: int) -> np.ndarray | None:
    """Weights with the sum 1 on the columns that are `held`, to full precision.

    The heavy row that keeps the sum costs digits; with the right columns known one weight follows
    from the others. None where these would be negative.
    """
    which = np.flatnonzero(held[:count])
    if not len(which):
        return None
    last, others = which[-1], [*which[:-1], *(count + np.flatnonzero(held[count:]))]
    shares = np.zeros(columns.shape[1])
    if others:
        base = np.where(np.array(others) < count, 1.0, 0.0) * columns[:, last, None]
        shares[others] = np.linalg.lstsq(columns[:, others] - base, -columns[:, last], rcond=None)[
            0
        ]
    shares[last] = 1.0 - np.sum(shares[which[:-1]])
    return shares[:count] if np.all(shares >= 0.0) else None


def _curvature(
    slope: np.ndarray, bend: np.ndarray, shares: np.ndarray, inward: np.ndarray
) -> float:
    """Curvature of the weighted level along what the active peaks and the boundary leave free."""
    kk, kz, zz = shares @ bend
    table = np.array([[kk, kz], [kz, zz]])
    held = [slope[i] - slope[0] for i in range(1, len(slope))]
    pull = slope.T @ shares
    # a boundary that is pressed against leaves no direction of its own
    held += [np.eye(2)[i] for i in range(2) if inward[i] and pull[i] > 1e-6]
    if not held:
        return float(np.min(np.linalg.eigvalsh(table)))
    _, sizes, rows = np.linalg.svd(np.array(held))
    rank = int(np.sum(sizes > 1e-10 * max(float(sizes[0]), 1e-300)))
    free = rows[rank:]
    if not len(free):
        return float("inf")
    return float(np.min(np.linalg.eigvalsh(free @ table @ free.T)))
