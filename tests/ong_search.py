"""Appendix V of Ong (2000) with its slips, all starts of its search advancing as one batch.

The slips, kept here on purpose: displacements are abs(P abs(Y)); a rotating load acts at all 41
harmonics; the pattern move steps back from the old base point instead of ahead of the new one; a
trial that failed stays in the trial point while the next variable is tried. After a pattern move
that failed the trial point is the base point again (in the printed listing this line has slipped
behind the end of its block).
"""

from typing import NamedTuple

import numpy as np
from ong_tables import MASS, ORDERS, SPEED, STIFFNESS

from vibecalc.numerics.linear import Linear
from vibecalc.response.modes import modes

#: what the corrective energy should be, from the literals of the listing and x = 1.253
TARGET = (1.253 * 7.148112661499771e-2 + (2 - 1.253) * 6.368625806814919e-1) / 2
FIRST_STEPS = (0.01, 0.05, 0.05)
LAST_STEP = 1e-4
MOST_LOOPS = 10000
#: signs under which the source's run had its modes, after the largest component was made positive
SIGNS = np.array([1.0, 1.0, 1.0, 1.0, -1.0, 1.0])
_BATCH = 600


class Ends(NamedTuple):
    """End points (3, starts), objectives (starts,), and evaluations as the listing makes them."""

    point: np.ndarray
    objective: np.ndarray
    evaluations: int


def grid() -> np.ndarray:
    """The 9300 starts (3, starts): angle in rad, force in lbf, torque in lbf in."""
    angle = 0.1 * np.arange(1, 63)
    sides = (angle, np.arange(68.0, 78.0), np.arange(71.0, 86.0))
    return np.stack(np.meshgrid(*sides, indexing="ij")).reshape(3, -1)


def corrective_energy(point: np.ndarray) -> np.ndarray:
    """The source's corrective kinetic energy (starts,), in lbf in, at points (3, starts)."""
    parts = [_energy(point[:, i : i + _BATCH]) for i in range(0, point.shape[1], _BATCH)]
    return np.concatenate(parts or [np.empty(0)])


def objective(point: np.ndarray) -> np.ndarray:
    """What the source makes small, (starts,)."""
    return np.abs(TARGET - corrective_energy(point))


def search(starts: np.ndarray) -> Ends:
    """Run the listing from every start (3, starts)."""
    count = 0

    def value(point: np.ndarray) -> np.ndarray:
        nonlocal count
        count += point.shape[1]
        return objective(point)

    base, old, trial = starts.copy(), starts.copy(), starts.copy()
    step = np.multiply.outer(FIRST_STEPS, np.ones(starts.shape[1]))
    running = np.arange(starts.shape[1])
    end, lowest = starts.copy(), np.full(starts.shape[1], np.inf)
    for _ in range(MOST_LOOPS):
        here = value(base)
        count += 3 * base.shape[1]  # the listing forms this value anew for each variable
        for axis in range(3):
            trial[axis] = base[axis] + step[axis]
            there = value(trial)
            better = there < here
            base[:, better], here[better] = trial[:, better], there[better]
            step[axis, better] *= 1.1
            rest = np.flatnonzero(~better)
            step[axis, rest] *= -1.0
            trial[axis, rest] = base[axis, rest] + step[axis, rest]
            there = value(trial[:, rest])
            better = there < here[rest]
            won, lost = rest[better], rest[~better]
            base[:, won], here[won] = trial[:, won], there[better]
            step[axis, lost] *= 0.95
        same = np.all(old == base, axis=0)
        done = same & (np.max(np.abs(step), axis=0) < LAST_STEP)
        moved = np.flatnonzero(~same)
        trial[:, moved] = old[:, moved] + (old[:, moved] - base[:, moved])
        there = value(trial[:, moved])
        count += moved.size + int(np.sum(done))
        better = there < here[moved]
        won, lost = moved[better], moved[~better]
        base[:, won] = trial[:, won]
        old[:, moved] = base[:, moved]
        trial[:, lost] = base[:, lost]
        end[:, running[done]], lowest[running[done]] = base[:, done], here[done]
        base, old, trial, step = (part[:, ~done] for part in (base, old, trial, step))
        running = running[~done]
        if not running.size:
            break
    return Ends(end, lowest, count)


def _modes() -> tuple[np.ndarray, np.ndarray]:
    """Modes of unit modal mass as the source's run had them, and their frequencies squared."""
    nothing = np.zeros((6, 6))
    found = modes(Linear(MASS, STIFFNESS, *[nothing] * 6))
    largest = found.shape[np.argmax(np.abs(found.shape), axis=0), np.arange(6)]
    return found.shape * np.sign(largest) * SIGNS, found.eigenvalue


_SHAPE, _EIGENVALUE = _modes()
_FREQUENCY = ORDERS * SPEED
#: P / |k (1 - (h w)^2 m / k)| for each harmonic, (41 * 6, 6)
_MOTION = (_SHAPE / np.abs(_EIGENVALUE - _FREQUENCY[:, None, None] ** 2)).reshape(-1, 6)


def _energy(point: np.ndarray) -> np.ndarray:
    angle, force, torque = point
    cosine, sine, none = np.cos(angle), np.sin(angle), 0.0 * angle
    with_sine = np.stack([-force * sine, force * cosine, none, -torque * cosine, -torque * sine])
    with_cosine = np.stack([force * cosine, force * sine, none, -torque * sine, torque * cosine])
    parts = [_MOTION @ np.abs(_SHAPE[:5].T @ load) for load in (with_sine, with_cosine)]
    size = np.sqrt(parts[0] ** 2 + parts[1] ** 2).reshape(ORDERS.size, 6, -1)
    # the mass matrix couples the last two coordinates only
    doubled = np.einsum("hib,hib->hb", size * np.diag(MASS)[:, None], size)
    doubled += 2.0 * MASS[4, 5] * size[:, 4] * size[:, 5]
    return 0.5 * _FREQUENCY**2 @ doubled
