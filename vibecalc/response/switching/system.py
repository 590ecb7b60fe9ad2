"""Modes of the body under the loads of its operations: free motion and steady motion."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, Operand, bounded
from vibecalc.numerics.rounding import EPSILON

# ----------------------------------------------------------------------------
# What a transient needs to know: the modes of the body, the loads of each operation, the course.
#
# Loads and speed are known functions of time; the body does not act back on the crank.
# ----------------------------------------------------------------------------


class ModalSystem(NamedTuple):
    """Modes of a body: `shape` (coordinates, modes) square and mass-normalised, any sign.

    `frequency` (modes,) undamped, rad/s; 0 for a mode that nothing holds. `damping_ratio`
    (modes,), 1 is critical. The modes are taken as exact and as not coupled by the damping.
    """

    shape: np.ndarray
    frequency: np.ndarray
    damping_ratio: np.ndarray


class SpeedSegment(NamedTuple):
    """A part of a speed profile: the crank's speed is linear in time, one operation works.

    `duration` in s, speeds in rad/s (negative: the other sense), `operation` an index. A segment
    may begin or end at rest, but does not pass through it.
    """

    duration: float
    start_speed: float
    end_speed: float
    operation: int


class ModalLoads(NamedTuple):
    """What the crank train does to each mode in each operation (a set of working cylinders).

    `orders` (orders,), integers from 1. `amplitude` (operations, orders, modes) is complex 0-peak,
    p_n in Re sum p_n w^2 exp(i n theta) at a constant speed w, zero where it is rounding. At a
    varying speed an order is p_n (w^2 - i w'/n) exp(i n theta), exactly: a part moves with
    x(theta) = Re X_n exp(i n theta), so that x'' = Re (i n w' - n^2 w^2) X_n exp(i n theta), and
    its load -m x'' has m n^2 X_n. This holds for pistons, rods and weights that turn in proportion
    to the crank; not for the torque that a driven machine off the body keeps.
    `retained` is the number of orders that move the body. Those behind them are dropped from the
    motion, and what they would add stands in its errors.
    """

    orders: np.ndarray
    amplitude: Bounded
    retained: int

    def some(self, which: slice) -> "ModalLoads":
        """Some of the orders."""
        return self._replace(orders=self.orders[which], amplitude=self.amplitude[:, which])


def modal_loads(
    system: ModalSystem, orders: np.ndarray, per_speed_squared: Bounded, retained: int
) -> ModalLoads:
    """Loads (operations, orders, coordinates) in kg m and kg m^2 on the modes.

    Raises
    ------
    NumericalFailure
        If a mode is driven that nothing holds, or that has no positive damping ratio.
    """
    amplitude = per_speed_squared @ system.shape
    felt = np.abs(amplitude.value) > amplitude.error
    driven = np.any(felt, axis=(0, 1))
    for which, words in (
        (driven & ~(system.frequency > 0.0), _NOT_HELD),
        (driven & ~(system.damping_ratio > 0.0), _NOT_DAMPED),
    ):
        if np.any(which):
            raise NumericalFailure(words.format(int(np.argmax(which)) + 1))
    value, error = np.where(felt, amplitude.value, 0.0), amplitude.error * driven
    return ModalLoads(orders, Bounded(value, error), retained)


_NOT_HELD = (
    "mode {0} is driven, but nothing holds the body in it (its natural frequency is 0): after a "
    "change it would drift away; give the mounts stiffness in that direction"
)
_NOT_DAMPED = (
    "mode {0} is driven, but has no damping: after a change it would never settle; the case must "
    "state a damping of the mounts or of the modes"
)


# ----------------------------------------------------------------------------
# The free motion of damped modes in closed form, below, at and above critical damping.
# ----------------------------------------------------------------------------


def poles(system: ModalSystem) -> tuple[np.ndarray, np.ndarray]:
    """The slower pole of each mode and the gap to the other one, which lies that far below it.

    Both (modes,) complex in rad/s; the gap is imaginary below critical damping, real above.
    """
    ratio, frequency = system.damping_ratio, system.frequency
    split = np.sqrt((ratio - 1.0) * (ratio + 1.0) + 0j)
    return -frequency / (ratio + split), 2.0 * frequency * split


def free_motion(system: ModalSystem, time: np.ndarray, state: np.ndarray) -> np.ndarray:
    """States (..., modes, 2), displacement and velocity, after times (...) >= 0.

    Of q'' + 2 zeta w q' + w^2 q = 0 for every mode. With the slower pole s and the gap g to the
    other one the entries are made of exp(s t) (1 + exp(-g t)) / 2 and exp(s t) (1 - exp(-g t)) / g,
    which is t exp(s t) at critical damping. A mode with w = 0 moves on at its velocity.
    """
    frequency, after = system.frequency, np.asarray(time, dtype=float)[..., None]
    slow, gap = poles(system)
    fall, turn = np.exp(slow.real * after), 0.5 * gap.imag * after
    shrink, apart = np.expm1(-gap.real * after), np.abs(gap)
    swing = (2.0 * np.sin(turn) - shrink) / np.where(apart > 0.0, apart, 1.0)
    swing = fall * np.where(apart > 0.0, swing, after)
    wave = fall * (np.cos(turn) + 0.5 * shrink)
    lean = system.damping_ratio * frequency * swing
    displacement, velocity = state[..., 0], state[..., 1]
    moved: np.ndarray = np.stack(
        [
            (wave + lean) * displacement + swing * velocity,
            (wave - lean) * velocity - frequency**2 * swing * displacement,
        ],
        axis=-1,
    )
    return moved


def modal_size(system: ModalSystem, state: np.ndarray) -> np.ndarray:
    """Size sqrt(|q'|^2 + w^2 |q|^2) (..., modes) of states; free motion lets none grow."""
    size: np.ndarray = np.hypot(system.frequency * np.abs(state[..., 0]), np.abs(state[..., 1]))
    return size


# ----------------------------------------------------------------------------
# The steady motion of each mode at a constant crank speed.
# ----------------------------------------------------------------------------


def steady_amplitude(
    system: ModalSystem, orders: np.ndarray, amplitude: Operand, speed: np.ndarray | float
) -> Bounded:
    """Q_n = W^2 p_n / (w^2 - n^2 W^2 + 2 i zeta w n W) at crank speeds W (...).

    They are (..., orders, modes), complex 0-peak in q = Re sum Q_n exp(i n theta), for loads p_n
    (orders, modes).
    """
    pace = np.asarray(speed, dtype=float)[..., None, None]
    load, rate = bounded(amplitude), orders[:, None] * pace
    square = system.frequency**2
    stiffness = square - rate**2 + 2j * system.damping_ratio * system.frequency * rate
    # a mode at rest may stand on its resonance
    stiffness = np.where(load.value == 0.0, 1.0, stiffness)
    return load * pace**2 / Bounded(stiffness, 2.0 * EPSILON * (square + rate**2))


def steady_state(
    amplitude: np.ndarray, orders: np.ndarray, speed: float, angle: np.ndarray | float
) -> np.ndarray:
    """Displacement and velocity (..., modes, 2) at crank angles (...)."""
    wave = np.exp(1j * orders * np.asarray(angle)[..., None])
    rates = 1j * (orders * speed)[:, None]
    return np.stack([(wave @ amplitude).real, (wave @ (rates * amplitude)).real], axis=-1)


class SteadyMotion(NamedTuple):
    """Steady motion (orders, modes) of the retained orders, and the error (modes,) of its size.

    The size sqrt(q'^2 + w^2 q^2) is meant at any instant. Dropped orders count at their worst.
    """

    amplitude: np.ndarray
    error: np.ndarray


def steady_motion(
    system: ModalSystem, loads: ModalLoads, operation: int, speed: float
) -> SteadyMotion:
    """The steady motion of an operation at a crank speed, of either sign."""
    every = steady_amplitude(system, loads.orders, loads.amplitude[operation], speed)
    kept = np.arange(len(loads.orders))[:, None] < loads.retained
    size = np.maximum(system.frequency, np.abs(loads.orders * speed)[:, None])
    error = np.sum((every.error + np.where(kept, 0.0, np.abs(every.value))) * size, axis=0)
    return SteadyMotion(every.value[: loads.retained], error)
