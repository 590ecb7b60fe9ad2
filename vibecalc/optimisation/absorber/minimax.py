"""The tuning that makes the largest response as small as it can be, for any primary damping."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.optimisation.absorber.minimax_continuation import follow, merged, some_of, sound
from vibecalc.optimisation.absorber.minimax_newton import Balance, two_peaks
from vibecalc.optimisation.absorber.minimax_points import Tunings, slopes, tunings
from vibecalc.optimisation.absorber.minimax_search import descend
from vibecalc.response.absorber.excess import excess
from vibecalc.response.absorber.model import Transfer, transfer_of

#: what an answer is: `OUTCOMES[tuning.outcome]`
OUTCOMES = ("balanced", "set", "no_help", "unbounded")
BALANCED, SET, NO_HELP, UNBOUNDED = range(4)

#: rounding errors granted to an evaluation of a peak and of its slopes
_ROUNDINGS = 2.0


class Tuning(NamedTuple):
    """Optimal tunings (...), with errors; frequencies, weights of the two peaks (..., 2).

    `outcome`, an index into `OUTCOMES`:
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
    closed form, or one near it); points that leave this way are searched with exact peaks.
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
    found, place, used = _solve(z1[asked], m[asked], points.some(asked), transfer)
    held = sound(found)
    outcome[asked[~held]] = SET
    return _record(points, outcome, asked, found, place, used, shape)


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
    way = follow(z1, m, transfer)
    found, used, place = way.balance, way.evaluations.copy(), way.balance.place.copy()
    lost = np.flatnonzero(~way.reached)
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
        found = merged(found, lost[good], some_of(again, np.flatnonzero(good)))
        found.step[lost[on_floor]] = np.inf
        lost = lost[~(on_floor | good)]
    if len(lost):
        raise NumericalFailure(
            f"no optimal tuning found at primary damping {z1[lost[0]]:.6g} and mass ratio "
            f"{m[lost[0]]:.6g} ({len(lost)} of {len(m)} points)"
        )
    done = sound(found)
    place[:, done] = found.place[:, done]
    return found, place, used


def _record(
    points: Tunings, outcome: np.ndarray, asked: np.ndarray, found: Balance, place: np.ndarray,
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
    rows, own = asked[held], np.flatnonzero(held)
    value, value_error, spread = _level(points.some(rows), some_of(found, own))
    level[rows], level_error[rows] = value, value_error
    k_error[rows], z2_error[rows] = k[rows] * spread, z2[rows] * spread
    frequency[rows] = np.exp(found.y[:, own] / 2.0).T
    weight[rows] = np.stack([found.weight[own], 1.0 - found.weight[own]], axis=-1)
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


def _level(points: Tunings, found: Balance) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Common excess of both peaks, its error, and the relative error of k and z2."""
    seen = excess(points.parts(found.place), points.weights, np.exp(found.y))
    value = seen.above[0] / seen.below[0]
    noise = _ROUNDINGS * UNIT_ROUNDOFF * (
        seen.above_size / np.abs(seen.above[0]) + seen.below_size / seen.below[0]
    )  # fmt: skip
    share = np.stack([found.weight, 1.0 - found.weight])
    level = np.sum(share * value, axis=0)
    # the mean with these weights is stationary in the tuning; the gap is all of first order
    relative = np.sum(share * noise, axis=0)
    steep = slopes(points, found.place, found.y)
    apart = np.hypot(*(steep.p[:, 0] - steep.p[:, 1]))
    size = 1.0 + np.max(np.abs(steep.p), axis=(0, 1))
    worst = np.max(noise, axis=0)
    # across: the levels are equal to their noise; along: the slopes are, over the curvature
    # (two fifths of each bound: roundings do not all point one way, as random machines show)
    spread = 0.4 * (worst / apart + worst * size / found.curvature)
    spread += found.step**2 + 2.0 * UNIT_ROUNDOFF * np.max(np.abs(found.place), axis=0)
    return level, level * (relative + 2.0 * UNIT_ROUNDOFF), spread
