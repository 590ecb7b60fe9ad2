"""The free motion of damped modes in closed form, below, at and above critical damping."""

from typing import NamedTuple

import numpy as np

from vibecalc.response.switching.system import ModalSystem

#: from here to `_OVERDAMPED` the two poles are too close to bound each by itself
_NEAR_CRITICAL, _OVERDAMPED = 0.9, 1.2


class Propagator(NamedTuple):
    """Displacement and velocity after a time from those before: two rows of two, (..., modes)."""

    from_displacement: np.ndarray
    from_velocity: np.ndarray
    rate_from_displacement: np.ndarray
    rate_from_velocity: np.ndarray

    def __call__(self, state: np.ndarray) -> np.ndarray:
        """States (..., modes, 2), displacement and velocity, moved on."""
        displacement, velocity = state[..., 0], state[..., 1]
        moved: np.ndarray = np.stack(
            [
                self.from_displacement * displacement + self.from_velocity * velocity,
                self.rate_from_displacement * displacement + self.rate_from_velocity * velocity,
            ],
            axis=-1,
        )
        return moved


def propagator(system: ModalSystem, time: np.ndarray) -> Propagator:
    """Free motion over times (...) >= 0 of q'' + 2 zeta w q' + w^2 q = 0, for every mode.

    With s = zeta w and d^2 = w^2 |1 - zeta^2| the entries are exp(-s t) times cosines and sines
    of d t, or hyperbolic ones in a form without overflow or cancelling rates; at d = 0 both give
    exp(-s t) and t exp(-s t). A mode with w = 0 moves on at its velocity.
    """
    frequency, ratio = system.frequency, system.damping_ratio
    after = np.asarray(time, dtype=float)[..., None]
    split = frequency * np.sqrt(np.abs((1.0 - ratio) * (1.0 + ratio)))
    wave, swing = np.empty((2, *after.shape[:-1], len(frequency)))
    under = ratio < 1.0
    if np.any(under):
        turn = split[under] * after
        fall = np.exp(-(ratio * frequency)[under] * after)
        wave[..., under] = fall * np.cos(turn)
        still = split[under] == 0.0
        swing[..., under] = fall * np.where(
            still, after, np.sin(turn) / np.where(still, 1.0, split[under])
        )
    if not np.all(under):
        gap, held = split[~under], frequency[~under] > 0.0
        slow = np.where(held, frequency[~under], 0.0) ** 2 / np.where(
            held, ratio[~under] * frequency[~under] + gap, 1.0
        )
        fall, shrink = np.exp(-slow * after), np.expm1(-2.0 * gap * after)
        wave[..., ~under] = fall * (1.0 + 0.5 * shrink)
        still = gap == 0.0
        swing[..., ~under] = fall * np.where(
            still, after, -shrink / np.where(still, 1.0, 2.0 * gap)
        )
    lean = ratio * frequency * swing
    return Propagator(wave + lean, swing, -(frequency**2) * swing, wave - lean)


def fastest_rate(system: ModalSystem) -> float:
    """Largest magnitude of a pole, rad/s."""
    beyond = np.sqrt(np.maximum(system.damping_ratio**2 - 1.0, 0.0))
    rate = system.frequency * np.where(
        system.damping_ratio > 1.0, system.damping_ratio + beyond, 1.0
    )
    return float(np.max(rate, initial=0.0))


def decay_bound(system: ModalSystem) -> tuple[np.ndarray, np.ndarray]:
    """Factor k and rate s (modes,): free motion keeps at most min(1, k exp(-s t)) of its size.

    The size is sqrt(q'^2 + w^2 q^2), which no damping lets grow. Below critical damping k is the
    condition of the two poles' directions; elsewhere it follows from the Schur form of the mode's
    matrix, whose part off the diagonal is 2 w at most.
    """
    frequency, ratio = system.frequency, system.damping_ratio
    beyond = np.sqrt(np.maximum(ratio**2 - 1.0, 0.0))
    slow = frequency * np.where(ratio > 1.0, 1.0 / np.maximum(ratio + beyond, 1.0), ratio)
    below, above = ratio < _NEAR_CRITICAL, ratio > _OVERDAMPED
    safe = np.where(below, ratio, 0.0)
    factor = np.where(
        below,
        np.sqrt((1.0 + safe) / (1.0 - safe)),
        np.where(
            above,
            1.0 + 1.0 / np.where(above, beyond, 1.0),
            1.0 + 4.0 / np.e * frequency / np.where(slow > 0.0, slow, 1.0),
        ),
    )
    return factor, np.where(below | above, slow, 0.5 * slow)


def memory(system: ModalSystem, duration: float) -> np.ndarray:
    """For how long (modes,) at most, in s, loads are remembered within `duration`."""
    factor, rate = decay_bound(system)
    lasting = factor / np.where(rate > 0.0, rate, 1.0)
    return np.where(rate > 0.0, np.minimum(lasting, duration), duration)


def modal_size(system: ModalSystem, state: np.ndarray) -> np.ndarray:
    """Size sqrt(q'^2 + w^2 q^2) (..., modes) of states; half its square is the energy."""
    size: np.ndarray = np.hypot(system.frequency * state[..., 0], state[..., 1])
    return size
