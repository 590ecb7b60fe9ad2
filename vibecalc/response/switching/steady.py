"""The steady motion of each mode at a constant crank speed."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.response.switching.orders import order_waves, real_rows
from vibecalc.response.switching.system import ModalLoads, ModalSystem


class Steady(NamedTuple):
    """Modal amplitudes (orders, modes), complex 0-peak in q = Re sum Q_n exp(i n theta).

    `error` (modes,) bounds the error of the size sqrt(q'^2 + w^2 q^2) at any instant.
    """

    amplitude: np.ndarray
    error: np.ndarray


def steady_motion(system: ModalSystem, loads: ModalLoads, operation: int, speed: float) -> Steady:
    """Q_n = W^2 p_n / (w^2 - n^2 W^2 + 2 i zeta w n W) at the crank speed W, of either sign."""
    rate = (loads.orders * speed)[:, None]
    frequency, push = system.frequency, loads.amplitude[operation] * speed**2
    stiffness = frequency**2 - rate**2 + 2j * system.damping_ratio * frequency * rate
    # a mode at rest may stand on its resonance
    stiffness = np.where(loads.driven, stiffness, 1.0)
    amplitude = push / stiffness
    magnitude = np.maximum(frequency, np.abs(rate))
    lost = 2.0 + (frequency**2 + rate**2) / np.abs(stiffness)
    noise = loads.noise[operation] * speed**2 / np.abs(stiffness)
    doubt = np.sum((4.0 * EPSILON * lost * np.abs(amplitude) + noise) * magnitude, axis=0)
    doubt = doubt + _size_of_dropped(system, loads, operation, speed)
    # what is left out: static, or at its worst on the resonance
    stiffest = frequency * np.minimum(2.0 * system.damping_ratio, 1.0)
    left_out = loads.left_out[operation] * speed**2 * loads.driven
    left_out = 2.0 * left_out / np.where(loads.driven, stiffest, 1.0)
    return Steady(amplitude, doubt + left_out)


def _size_of_dropped(
    system: ModalSystem, loads: ModalLoads, operation: int, speed: float
) -> np.ndarray:
    """Size (modes,) of the steady motion under the dropped orders, all at their worst together."""
    rate = (loads.dropped_orders * speed)[:, None]
    frequency = system.frequency
    stiffness = frequency**2 - rate**2 + 2j * system.damping_ratio * frequency * rate
    moved = np.abs(loads.dropped[operation]) * speed**2
    moved = moved / np.abs(np.where(loads.driven, stiffness, 1.0))
    size: np.ndarray = np.sum(moved * np.maximum(frequency, np.abs(rate)), axis=0)
    return size


def steady_state(steady: Steady, orders: np.ndarray, speed: float, angle: np.ndarray) -> np.ndarray:
    """Displacement and velocity (..., modes, 2) at crank angles (...)."""
    rates = 1j * (orders * speed)[:, None] * steady.amplitude
    modes = steady.amplitude.shape[1]
    rows = real_rows(np.concatenate([steady.amplitude, rates], axis=1))
    both = order_waves(np.asarray(angle, dtype=float).ravel(), orders) @ rows
    shape = (*np.shape(angle), modes)
    return np.stack([both[:, :modes].reshape(shape), both[:, modes:].reshape(shape)], axis=-1)
