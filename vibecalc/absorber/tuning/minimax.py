"""Minimax (H-infinity) tuning of one absorber for any primary damping."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.absorber.squared_magnitude import damping_excess, excess
from vibecalc.absorber.transfer import Transfer, fixed_points, transfer_of
from vibecalc.absorber.tuning.closed_forms import nishihara_asami, warburton_acceleration
from vibecalc.absorber.tuning.minimax_steps import (
    Balance,
    Tunings,
    descend,
    slopes,
    tunings,
    two_peaks,
)
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF

# ----------------------------------------------------------------------------
# Where the search for a tuning begins: near the optimum of an undamped primary system.
# ----------------------------------------------------------------------------


def undamped_start(mass_ratio: np.ndarray, transfer: Transfer) -> tuple[np.ndarray, np.ndarray]:
    """Place (2, n) (ln k, ln 2 z2) and ln u of the two peaks (2, n) at z1 = 0.

    Exact for |N1 / D|; for x and x^2 times that, and for what passes from the ground to the
    ground, formulas close enough for Newton's method at mass ratios of 1e-4 to 10. The peaks are
    sought at the fixed points, which no power of x moves.
    """
    m = mass_ratio
    if transfer.motion == "primary" and transfer.power == 0:
        k, z2, _ = nishihara_asami(m)
    elif transfer.motion == "primary" and transfer.power == 2:
        k, z2, _ = warburton_acceleration(m)
    else:
        # between the two: fixed points of equal height in x H
        k = m * (1.0 + m / 2.0) / np.square(1.0 + m)
        z2 = m * np.sqrt(3.0 * m / 8.0) / (1.0 + m) ** 1.125
    marks = fixed_points(m, k)
    return (
        np.log(np.stack([k, 2.0 * z2])),
        2.0 * np.log(np.stack([marks.frequency_p, marks.frequency_q])),
    )


# ----------------------------------------------------------------------------
# From the tuning for an undamped primary to that for any damping, in steps that adapt.
# ----------------------------------------------------------------------------

#: first and shortest step, in logarithms; what needs a shorter one is left to the search
_FIRST, _SHORTEST = 0.8, 0.02
#: Newton iterations granted to one step of the path
_ITERATIONS = 11
#: last step of Newton's method at a place that is only passed
_ALONG_PATH = 1e-2


class PathEnd(NamedTuple):
    """Where the path ended (place, ln u as in `Balance`), whether at its end, evaluations (n,)."""

    balance: Balance
    reached: np.ndarray
    evaluations: np.ndarray


def sound(balance: Balance, enough: float | np.ndarray = 1e-6) -> np.ndarray:
    """Two equal peaks that oppose each other, on a floor of positive curvature."""
    with np.errstate(invalid="ignore"):
        good: np.ndarray = (
            (balance.step <= enough) & (balance.curvature > 0.0)
            & (balance.weight > 0.02) & (balance.weight < 0.98)
            & (np.abs(balance.y[0] - balance.y[1]) > 1e-6)
        )  # fmt: skip
    return good


def follow(points: Tunings, transfer: Transfer) -> PathEnd:
    """The optimum that z1 = 0 leads to (n,): at once where that is near, else along the path."""
    z1, m = points.primary_damping, points.mass_ratio
    balance = two_peaks(points, *undamped_start(m, transfer), _ITERATIONS)
    reached, used = sound(balance) & (_distance(z1, m, transfer) <= _FIRST), balance.evaluations
    far = np.flatnonzero(~reached)
    if len(far):
        rest = _along_path(z1[far], m[far], transfer)
        balance = merged(balance, far, rest.balance)
        reached[far] = rest.reached
        used[far] += rest.evaluations
    return PathEnd(balance, reached, used)


def _along_path(primary_damping: np.ndarray, mass_ratio: np.ndarray, transfer: Transfer) -> PathEnd:
    """Follow the optimum from z1 = 0 to z1 (n,) in steps that adapt.

    The step is halved where the optimum is not found and doubled where it is; the prediction
    runs on in logarithms, so that no ratio becomes negative. What has a threshold (force and
    displacement) is followed in the logarithm of the distance to it. Close to sqrt m of damping a
    light absorber's tuning changes quickly, hence the logarithm of z1 too.
    """
    light, threshold = np.sqrt(mass_ratio), _has_threshold(transfer)
    whole = _distance(primary_damping, mass_ratio, transfer)
    count = len(mass_ratio)
    zero = np.zeros(count)
    place, y = undamped_start(mass_ratio, transfer)
    points = tunings(zero, mass_ratio, transfer)
    passed = whole > 0.0
    now = two_peaks(points, place, y, _ITERATIONS, np.where(passed, _ALONG_PATH, 1e-9))
    used = now.evaluations.copy()
    lost = np.flatnonzero(~sound(now, np.where(passed, _ALONG_PATH, 1e-6)))
    if len(lost):
        some = points.some(lost)
        lower = descend(some, place[:, lost])
        again = two_peaks(some, lower.place, lower.y, _ITERATIONS)
        used[lost] += lower.evaluations + again.evaluations
        now = merged(now, lost, again)
        still = lost[~sound(again)]
        now.place[:, still] = lower.place[:, ~sound(again)]
    began = sound(now, np.where(passed, _ALONG_PATH, 1e-6))
    here, before = zero.copy(), zero.copy()
    last = now
    path = np.where(began & (whole > 0.0), whole, 0.0)
    stride = np.minimum(path, _FIRST)
    live = np.flatnonzero(path > 0.0)
    while len(live):
        goal = np.minimum(here[live] + stride[live], path[live])
        ended = goal >= path[live]
        target = np.where(ended, primary_damping[live], _damping(goal, light[live], threshold))
        share = np.where(
            here[live] > before[live],
            (goal - here[live]) / np.maximum(here[live] - before[live], 1e-300), 0.0,
        )  # fmt: skip
        guess = [
            a[:, live] + np.clip(share * (a[:, live] - b[:, live]), -3.0, 3.0)
            for a, b in ((now.place, last.place), (now.y, last.y))
        ]
        trial = two_peaks(
            tunings(target, mass_ratio[live], transfer), guess[0], guess[1], _ITERATIONS,
            np.where(ended, 1e-9, _ALONG_PATH),
        )  # fmt: skip
        used[live] += trial.evaluations
        good = sound(trial, np.where(ended, 1e-6, _ALONG_PATH))
        won = live[good]
        last = merged(last, won, some_of(now, won))
        now = merged(now, won, Balance(*(a[..., good] for a in trial)))
        before[won] = here[won]
        here[won] = goal[good]
        stride[live] = np.where(good, 2.0 * stride[live], 0.5 * stride[live])
        live = live[(here[live] < path[live]) & (stride[live] > np.minimum(_SHORTEST, path[live]))]
    reached = began & (here >= path) & (np.isfinite(whole))
    return PathEnd(now, reached, used)


def merged(old: Balance, rows: np.ndarray, new: Balance) -> Balance:
    """The old points with some rows replaced."""
    result = Balance(*(a.copy() for a in old))
    for whole, part in zip(result, new, strict=True):
        whole[..., rows] = part
    return result


def some_of(balance: Balance, rows: np.ndarray) -> Balance:
    """Some rows."""
    return Balance(*(a[..., rows] for a in balance))


def _distance(
    primary_damping: np.ndarray, mass_ratio: np.ndarray, transfer: Transfer
) -> np.ndarray:
    """Length of the path to z1."""
    # a light absorber's tuning changes as soon as z1 is of the order of sqrt m
    whole: np.ndarray = np.log1p(primary_damping / np.sqrt(mass_ratio))
    if _has_threshold(transfer):
        with np.errstate(divide="ignore", invalid="ignore"):
            whole = whole - np.log(-damping_excess(primary_damping) / 2.0)
    return whole


def _has_threshold(transfer: Transfer) -> bool:
    return transfer.power == 0 and transfer.ground == 0


def _damping(path: np.ndarray, light: np.ndarray, threshold: bool) -> np.ndarray:
    """z1 at a place of the path, e^path = 1 + z1 / light, over 1 - 2 z1^2 towards a threshold."""
    z1: np.ndarray = light * np.expm1(path)
    if threshold:
        z1 = 2.0 * z1 / (1.0 + np.sqrt(1.0 + 8.0 * light * np.exp(path) * z1))
    return z1


# ----------------------------------------------------------------------------
# The tuning that makes the largest response as small as it can be, for any primary damping.
# ----------------------------------------------------------------------------

#: what an answer is, see `Tuning`
BALANCED, SET, NO_HELP, UNBOUNDED = range(4)

#: rounding errors granted to an evaluation of a peak and of its slopes
_ROUNDINGS = 2.0


class Tuning(NamedTuple):
    """Optimal tunings (...), with errors; frequencies, weights of the two peaks (..., 2).

    `outcome`, one of the four above:
    balanced: one tuning, held by two equal peaks at `frequency` that no change lowers together;
    set: the largest |H| is the limit at zero or infinite frequency, which the primary system fixes,
    and many tunings reach it; the one returned is one of them;
    no_help: that limit is reached without any absorber, k = z2 = 0;
    unbounded: |H| grows without bound with frequency, whatever the absorber; `largest` infinite.
    `largest` sup |H|; `excess` largest^2 - floor^2 to full relative precision, so that
    `above_floor` = largest - floor is too. `evaluations` of one peak with its derivatives, or of
    all peaks of one tuning.
    """

    stiffness_ratio: np.ndarray
    secondary_damping: np.ndarray
    largest: np.ndarray
    stiffness_error: np.ndarray
    damping_error: np.ndarray
    largest_error: np.ndarray
    floor: np.ndarray
    excess: np.ndarray
    excess_error: np.ndarray
    frequency: np.ndarray
    weight: np.ndarray
    outcome: np.ndarray
    evaluations: np.ndarray

    @property
    def above_floor(self) -> np.ndarray:
        """largest - floor, without cancellation: the peak less 1 for force and displacement."""
        with np.errstate(invalid="ignore"):
            share: np.ndarray = self.excess / (self.largest + self.floor)
        return np.where(np.isinf(self.largest), np.inf, share)


def minimax(
    primary_damping: ArrayLike, mass_ratio: ArrayLike, excitation: str = "force",
    response: str = "displacement",
) -> Tuning:  # fmt: skip
    """Minimise over k >= 0 and z2 >= 0 the largest |H| over all frequencies.

    z1 and m broadcast; all points are solved together. The two peaks and the tuning are the
    unknowns of one Newton iteration, followed from the undamped primary (Nishihara and Asami's
    closed form, or one near it); points that leave this path are searched with exact peaks.
    Raises NumericalFailure for ratios out of range, for responses of the secondary, and where no
    optimum is found. Tested for m from 1e-4 to 10 and z1 from 0 to 2.
    """
    transfer = transfer_of(excitation, response)
    if transfer.motion not in ("primary", "ground"):
        raise NumericalFailure(
            f"no tuning makes {response} least: it vanishes with the absorber; "
            "bound it instead while a response of the primary is made small"
        )
    z1, m = np.broadcast_arrays(
        np.asarray(primary_damping, dtype=float), np.asarray(mass_ratio, dtype=float)
    )
    if not np.all((m > 0.0) & np.isfinite(m) & (z1 >= 0.0) & np.isfinite(z1)):
        raise NumericalFailure("a tuning needs 0 < mass ratio < infinity and 0 <= primary damping")
    shape = m.shape
    z1, m = np.array(z1).reshape(-1), np.array(m).reshape(-1)
    points = tunings(z1, m, transfer)
    outcome = _without_absorber(points, transfer)
    asked = np.flatnonzero(outcome == BALANCED)
    balance, place, used = _solve(z1[asked], m[asked], points.some(asked), transfer)
    held = sound(balance)
    outcome[asked[~held]] = SET
    return _record(points, outcome, asked, balance, place, used, shape)


def _without_absorber(points: Tunings, transfer: Transfer) -> np.ndarray:
    """NO_HELP where the primary alone stays at the floor, UNBOUNDED where nothing bounds |H|."""
    z1, alone = points.primary_damping, points.weights.motion
    outcome = np.full(len(z1), BALANCED)
    # A = -alone(u), a parabola: below zero for all u > 0 exactly where its slope at least is
    floor = points.weights.floor_squared
    outcome[(floor > 0.0) & np.all(alone[:, :3] >= 0.0, axis=1)] = NO_HELP
    degree = transfer.power + transfer.ground * (z1 > 0.0) - 2
    outcome[degree > 0] = UNBOUNDED
    return outcome


def _solve(
    z1: np.ndarray, m: np.ndarray, points: Tunings, transfer: Transfer
) -> tuple[Balance, np.ndarray, np.ndarray]:
    """Balances (not sound where the floor is reached), a place each (2, n), evaluations."""
    if not len(m):
        empty = np.zeros((2, 0))
        none = np.zeros(0)
        return Balance(empty, empty, none, none, none, none, none.astype(int)), empty, none
    path = follow(points, transfer)
    balance, used, place = path.balance, path.evaluations.copy(), path.balance.place.copy()
    lost = np.flatnonzero(~path.reached)
    for short in (0.02, 1e-3, 1e-5):
        if not len(lost):
            break
        some = points.some(lost)
        lower = descend(some, place[:, lost], short=short)
        again = two_peaks(some, lower.place, lower.y)
        used[lost] += lower.evaluations + again.evaluations
        place[:, lost] = lower.place
        on_floor = np.max(lower.excess, axis=0) <= 0.0
        # a tuning that is no better than the place it was sought from is another stationary one
        with np.errstate(all="ignore"):
            level = np.exp(slopes(some, again.place, again.y).level[0])
            good = sound(again) & (level <= np.max(lower.excess, axis=0) * (1.0 + 1e-9))
        good &= ~on_floor
        balance = merged(balance, lost[good], some_of(again, np.flatnonzero(good)))
        balance.step[lost[on_floor]] = np.inf
        lost = lost[~(on_floor | good)]
    if len(lost):
        raise NumericalFailure(
            f"no optimal tuning found at primary damping {z1[lost[0]]:.6g} and mass ratio "
            f"{m[lost[0]]:.6g} ({len(lost)} of {len(m)} points)"
        )
    done = sound(balance)
    place[:, done] = balance.place[:, done]
    return balance, place, used


def _record(
    points: Tunings, outcome: np.ndarray, asked: np.ndarray, balance: Balance, place: np.ndarray,
    used: np.ndarray, shape: tuple[int, ...],
) -> Tuning:  # fmt: skip
    count = len(outcome)
    k, z2, level, level_error = (np.zeros(count) for _ in range(4))
    k_error, z2_error = np.zeros(count), np.zeros(count)
    frequency, weight = np.zeros((count, 2)), np.zeros((count, 2))
    evaluations = np.ones(count, dtype=int)
    k[asked], z2[asked] = np.exp(place[0]), np.exp(place[1]) / 2.0
    evaluations[asked] = used
    held = outcome[asked] == BALANCED
    rows, held_place = asked[held], np.flatnonzero(held)
    value, value_error, spread = _level(points.some(rows), some_of(balance, held_place))
    level[rows], level_error[rows] = value, value_error
    k_error[rows], z2_error[rows] = k[rows] * spread, z2[rows] * spread
    frequency[rows] = np.exp(balance.y[:, held_place] / 2.0).T
    weight[rows] = np.stack([balance.weight[held_place], 1.0 - balance.weight[held_place]], axis=-1)
    floor = np.sqrt(points.weights.floor_squared)
    largest = np.where(outcome == UNBOUNDED, np.inf, np.sqrt(floor * floor + level))
    with np.errstate(divide="ignore", invalid="ignore"):
        error = np.where(level_error > 0.0, level_error / (2.0 * largest), 0.0)
    error += np.where(np.isinf(largest), 0.0, 4.0 * UNIT_ROUNDOFF * np.minimum(largest, 1e300))
    columns = (
        k, z2, largest, k_error, z2_error, error, floor, level, level_error, frequency, weight,
        outcome, evaluations,
    )  # fmt: skip
    return Tuning(*(a.reshape((*shape, *a.shape[1:])) for a in columns))


def _level(points: Tunings, balance: Balance) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Common excess of both peaks, its error, and the relative error of k and z2."""
    value_at = excess(points.parts(balance.place), points.weights, np.exp(balance.y))
    value = value_at.above[0] / value_at.below[0]
    noise = _ROUNDINGS * UNIT_ROUNDOFF * (
        value_at.above_size / np.abs(value_at.above[0]) + value_at.below_size / value_at.below[0]
    )  # fmt: skip
    share = np.stack([balance.weight, 1.0 - balance.weight])
    level = np.sum(share * value, axis=0)
    # the mean with these weights is stationary in the tuning; the gap is all of first order
    relative = np.sum(share * noise, axis=0)
    steep = slopes(points, balance.place, balance.y)
    slope = np.stack([steep.k, steep.z])
    apart = np.hypot(*(slope[:, 0] - slope[:, 1]))
    size = 1.0 + np.max(np.abs(slope), axis=(0, 1))
    worst = np.max(noise, axis=0)
    # across: the levels are equal to their noise; along: the slopes are, over the curvature
    # (two fifths of each bound: roundings do not all point one way, as random machines show)
    spread = 0.4 * (worst / apart + worst * size / balance.curvature)
    spread += balance.step**2 + 2.0 * UNIT_ROUNDOFF * np.max(np.abs(balance.place), axis=0)
    return level, level * (relative + 2.0 * UNIT_ROUNDOFF), spread
