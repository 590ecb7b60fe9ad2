"""How much damping of the primary system leaves nothing to gain from an absorber: mean squares."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.optimisation.absorber.mean_square import mean_square_tuning
from vibecalc.response.absorber.mean_square import weights

_STEPS = 60


class MeanSquareThreshold(NamedTuple):
    """From `primary_damping` (...) on no finite k and z2 are best; `error` is absolute.

    Infinite: there is none. `kind` is "none", "locked" (beyond it a mass fastened rigidly is
    better than any absorber), "no_help" (beyond it any secondary is worse than none).
    """

    primary_damping: np.ndarray
    error: np.ndarray
    kind: str
    why: str


def mean_square_threshold(
    mass_ratio: ArrayLike, excitation: str = "force", response: str = "displacement",
    white: str = "",
) -> MeanSquareThreshold:  # fmt: skip
    """Threshold for a mean square under white noise; depends on the mass ratio (...).

    Raises NumericalFailure where the response has no mean square with a damped primary system.

    Notes
    -----
    Displacement under force: z1 J = (pi / 2) (1 - m^2 z2 (z2 + z1 k) / Delta) with Hurwitz'
    determinant 4 Delta: every secondary helps. Velocity and transmitted force: near the locked
    state z2 -> infinity, k = r z2, the mean square is that of the locked state plus a quadratic in
    r over z2^2; the threshold is where that is nowhere negative for r >= 0.
    """
    m = np.array(mass_ratio, dtype=float)
    chosen = weights(excitation, response, white)
    if chosen.reason or chosen.travel >= 0:
        raise NumericalFailure(
            f"{response} under white noise of {excitation!r} has no threshold: "
            f"{chosen.reason or 'it is least where the secondary is locked'}"
        )
    if chosen.parts == ("motion", ""):
        why = "every secondary lowers it, at any damping, and the locked one leaves it as it is"
        return MeanSquareThreshold(np.full(m.shape, np.inf), np.zeros(m.shape), "none", why)
    if chosen.parts[0].startswith("motion"):
        why = "beyond it the inertia counts for more than what the secondary's motion takes up"
        square = _rate(m) if chosen.parts == ("motion_rate", "") else _force(m)
        value = np.sqrt(square)
        return MeanSquareThreshold(value, 1e-14 * value, "locked", why)
    why = "beyond it the added inertia gathers more from the ground than the damper takes up"
    value, error = _ground(m, excitation, response, white)
    return MeanSquareThreshold(value, error, "no_help", why)


def _rate(m: np.ndarray) -> np.ndarray:
    """z1^2: lower root of 4 c^2 - 4 (1 + m) c + 1 + m."""
    whole = 1.0 + m
    return 0.5 * whole / (whole + np.sqrt(m * whole))


def _force(m: np.ndarray) -> np.ndarray:
    """z1^2: b^2 = 16 c m (16 c^2 - 4 c - 1 - m) with b = 1 + m + 8 c - 16 c^2, by bisection.

    At the lower end the right side is zero, at the upper one b.
    """
    whole = 1.0 + m
    low = (1.0 + np.sqrt(1.0 + 4.0 * whole)) / 8.0
    high = (1.0 + np.sqrt(1.0 + whole)) / 4.0
    for _ in range(_STEPS):
        c = 0.5 * (low + high)
        b = whole + 8.0 * c - 16.0 * c * c
        below = b * b > 16.0 * c * m * (16.0 * c * c - 4.0 * c - whole)
        low, high = np.where(below, c, low), np.where(below, high, c)
    middle: np.ndarray = 0.5 * (low + high)
    return middle


def _ground(
    m: np.ndarray, excitation: str, response: str, white: str
) -> tuple[np.ndarray, np.ndarray]:
    """Without a spring 1 / (2 sqrt(1 + m)); a tuned one may help a light secondary beyond it."""
    shape, flat = m.shape, m.ravel()
    plain = 0.5 / np.sqrt(1.0 + flat)

    def helps(z1: np.ndarray, rows: np.ndarray) -> np.ndarray:
        return ~mean_square_tuning(z1, flat[rows], excitation, response, white).no_help

    value, error = plain.copy(), 1e-15 * plain
    tuned = np.flatnonzero(helps(plain * (1.0 + 1e-6), np.arange(flat.size)))
    if tuned.size:
        low, high = plain[tuned], 2.0 * plain[tuned]
        while np.any(still := helps(high, tuned)):
            low, high = np.where(still, high, low), np.where(still, 2.0 * high, high)
        while np.any(high - low > 1e-7 * low):
            middle = 0.5 * (low + high)
            still = helps(middle, tuned)
            low, high = np.where(still, middle, low), np.where(still, high, middle)
        value[tuned], error[tuned] = 0.5 * (low + high), high - low
    return value.reshape(shape), error.reshape(shape)
