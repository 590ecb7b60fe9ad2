"""From the tuning for an undamped primary to that for any damping, in steps that adapt."""

from typing import NamedTuple

import numpy as np

from vibecalc.optimisation.absorber.minimax_newton import Balance, two_peaks
from vibecalc.optimisation.absorber.minimax_points import tunings
from vibecalc.optimisation.absorber.minimax_search import descend
from vibecalc.optimisation.absorber.minimax_starts import undamped_start
from vibecalc.response.absorber.measure import damping_excess
from vibecalc.response.absorber.model import Transfer

#: first and shortest step, in logarithms; what needs a shorter one is left to the search
_FIRST, _SHORTEST = 0.8, 0.02
#: Newton iterations granted to one step of the way
_ITERATIONS = 11
#: last step of Newton's method at a place that is only passed
_ON_THE_WAY = 1e-2


class Followed(NamedTuple):
    """Where the way ended (place, ln u as in `Balance`), whether at its end, evaluations (n,)."""

    balance: Balance
    reached: np.ndarray
    evaluations: np.ndarray


def sound(found: Balance, enough: float | np.ndarray = 1e-6) -> np.ndarray:
    """Two equal peaks that oppose each other, on a floor of positive curvature."""
    with np.errstate(invalid="ignore"):
        good: np.ndarray = (
            (found.step <= enough) & (found.curvature > 0.0)
            & (found.weight > 0.02) & (found.weight < 0.98)
            & (np.abs(found.y[0] - found.y[1]) > 1e-6)
        )  # fmt: skip
    return good


def follow(primary_damping: np.ndarray, mass_ratio: np.ndarray, transfer: Transfer) -> Followed:
    """Follow the optimum from z1 = 0 to z1 (n,), the whole way at once where Newton allows it.

    The step is halved where the optimum is not found and doubled where it is; the prediction
    runs on in logarithms, so that no ratio becomes negative. What has a threshold (force and
    displacement) is followed in the logarithm of the distance to it. Close to sqrt m of damping a
    light absorber's tuning changes quickly, hence the logarithm of z1 too.
    """
    threshold = transfer.power == 0 and transfer.ground == 0
    # a light absorber's tuning changes as soon as z1 is of the order of sqrt m
    light = np.sqrt(mass_ratio)
    whole = np.log1p(primary_damping / light)
    if threshold:
        with np.errstate(divide="ignore", invalid="ignore"):
            whole = whole - np.log(-damping_excess(primary_damping) / 2.0)
    count = len(mass_ratio)
    zero = np.zeros(count)
    place, y = undamped_start(mass_ratio, transfer)
    points = tunings(zero, mass_ratio, transfer)
    now = two_peaks(points, place, y, _ITERATIONS)
    used = now.evaluations.copy()
    lost = np.flatnonzero(~sound(now))
    if len(lost):
        some = points.some(lost)
        lower = descend(some, place[:, lost])
        again = two_peaks(some, lower.place, lower.y, _ITERATIONS)
        used[lost] += lower.evaluations + again.evaluations
        now = merged(now, lost, again)
        still = lost[~sound(again)]
        now.place[:, still] = lower.place[:, ~sound(again)]
    began = sound(now)
    here, before = zero.copy(), zero.copy()
    last = now
    way = np.where(began & (whole > 0.0), whole, 0.0)
    stride = np.minimum(way, _FIRST)
    live = np.flatnonzero(way > 0.0)
    while len(live):
        goal = np.minimum(here[live] + stride[live], way[live])
        ended = goal >= way[live]
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
            np.where(ended, 1e-9, _ON_THE_WAY),
        )  # fmt: skip
        used[live] += trial.evaluations
        good = sound(trial, np.where(ended, 1e-6, _ON_THE_WAY))
        won = live[good]
        last = merged(last, won, some_of(now, won))
        now = merged(now, won, Balance(*(a[..., good] for a in trial)))
        before[won] = here[won]
        here[won] = goal[good]
        stride[live] = np.where(good, 2.0 * stride[live], 0.5 * stride[live])
        live = live[(here[live] < way[live]) & (stride[live] > np.minimum(_SHORTEST, way[live]))]
    reached = began & (here >= way) & (np.isfinite(whole))
    return Followed(now, reached, used)


def merged(old: Balance, rows: np.ndarray, new: Balance) -> Balance:
    """The old points with some rows replaced."""
    result = Balance(*(a.copy() for a in old))
    for whole, part in zip(result, new, strict=True):
        whole[..., rows] = part
    return result


def some_of(found: Balance, rows: np.ndarray) -> Balance:
    """Some rows."""
    return Balance(*(a[..., rows] for a in found))


def _damping(way: np.ndarray, light: np.ndarray, threshold: bool) -> np.ndarray:
    """z1 at a place of the way, e^way = 1 + z1 / light, over 1 - 2 z1^2 towards a threshold."""
    z1: np.ndarray = light * np.expm1(way)
    if threshold:
        z1 = 2.0 * z1 / (1.0 + np.sqrt(1.0 + 8.0 * light * np.exp(way) * z1))
    return z1
