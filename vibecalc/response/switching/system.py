"""Modes of the body under the loads of its operations: free motion and steady motion."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON

# ----------------------------------------------------------------------------
# What a transient needs to know: the modes of the body, the loads of each operation, the course.
#
# Loads and speed are known functions of time; the body does not act back on the crank.
# ----------------------------------------------------------------------------

#: orders whose loads together are a smaller share than this of a mode's load are left out
_NEGLIGIBLE = 1e-17


class ModalSystem(NamedTuple):
    """Modes of a body: `shape` (coordinates, modes) square and mass-normalised, any sign.

    `frequency` (modes,) undamped, rad/s; 0 for a mode that nothing holds. `damping_ratio`
    (modes,), 1 is critical. The modes are taken as exact and as not coupled by the damping.
    """

    shape: np.ndarray
    frequency: np.ndarray
    damping_ratio: np.ndarray


class Loads(NamedTuple):
    """What the crank train does to the body in each operation (a set of working cylinders).

    `orders` (orders,), integers from 1. `per_speed_squared` (operations, orders, coordinates) is
    complex 0-peak, P_n in Re sum P_n w^2 exp(i n theta) at a constant speed w, in kg m and kg m^2.
    At a varying speed an order is P_n (w^2 - i w'/n) exp(i n theta), exactly: a part moves with
    x(theta) = Re X_n exp(i n theta), so that x'' = Re (i n w' - n^2 w^2) X_n exp(i n theta), its
    load is -m x'', and P_n = m n^2 X_n. This holds for pistons, rods and weights that turn in
    proportion to the crank; not for the torque that a driven machine off the body keeps.
    `per_acceleration` (operations, coordinates), real, is a load G w' without an order, such as
    the couple -J w' about the shaft of a rotor J that is driven from the body; often 0.
    `retained` is the number of orders that move the body; without it all do. Those behind them are
    dropped from the motion, and what they would add stands in its errors.
    """

    orders: np.ndarray
    per_speed_squared: np.ndarray
    per_acceleration: np.ndarray
    retained: int | None = None


class SpeedSegment(NamedTuple):
    """A part of a speed profile: the crank's speed is linear in time, one operation works.

    `duration` in s, speeds in rad/s (negative: the other sense), `operation` an index.
    """

    duration: float
    start_speed: float
    end_speed: float
    operation: int


class ModalLoads(NamedTuple):
    """`Loads` on each mode, orders without a share left out.

    `amplitude` and its rounding `noise` (operations, orders, modes), `push` (operations, modes);
    `left_out` (operations, modes) is the sum of the negligible orders left out; `dropped_orders`
    with `dropped` (operations, dropped orders, modes) are those that the errors count. `driven`
    (modes,): any load at all; the others are taken to be at rest.
    """

    orders: np.ndarray
    amplitude: np.ndarray
    noise: np.ndarray
    push: np.ndarray
    left_out: np.ndarray
    driven: np.ndarray
    dropped_orders: np.ndarray
    dropped: np.ndarray


def modal_loads(system: ModalSystem, loads: Loads) -> ModalLoads:
    """Loads on the modes; a load that is zero to rounding is set to zero.

    Raises
    ------
    NumericalFailure
        If a mode is driven that nothing holds, or that has no positive damping ratio.
    """
    shape, size = system.shape, np.abs(system.shape)
    amplitude = loads.per_speed_squared @ shape
    noise = 4.0 * EPSILON * (np.abs(loads.per_speed_squared) @ size)
    amplitude = np.where(np.abs(amplitude) > noise, amplitude, 0.0)
    push = loads.per_acceleration @ shape
    push_noise = 4.0 * EPSILON * (np.abs(loads.per_acceleration) @ size)
    push = np.where(np.abs(push) > push_noise, push, 0.0)
    driven = np.any(amplitude != 0.0, axis=(0, 1)) | np.any(push != 0.0, axis=0)
    _refuse(driven & ~(system.frequency > 0.0), _NOT_HELD)
    _refuse(driven & ~(system.damping_ratio > 0.0), _NOT_DAMPED)

    retained_orders = loads.orders[: loads.retained]
    dropped_orders, dropped = (
        loads.orders[len(retained_orders) :],
        amplitude[:, len(retained_orders) :],
    )
    order = np.argsort(retained_orders, kind="stable")
    sorted_size = np.max(np.abs(amplitude[:, order]), axis=0)
    remainder = np.cumsum(sorted_size[::-1], axis=0)[::-1]
    needed = np.any(remainder > _NEGLIGIBLE * np.sum(sorted_size, axis=0), axis=1)
    used = order[needed & np.any(sorted_size > 0.0, axis=1)]
    left_out = np.sum(np.abs(amplitude[:, order[~needed]]), axis=1)
    noise = noise[:, used] * driven
    return ModalLoads(
        loads.orders[used],
        amplitude[:, used],
        noise,
        push,
        left_out,
        driven,
        dropped_orders,
        dropped,
    )


_NOT_HELD = (
    "mode {0} is driven, but nothing holds the body in it (its natural frequency is 0): after a "
    "change it would drift away; give the mounts stiffness in that direction"
)
_NOT_DAMPED = (
    "mode {0} is driven, but has no damping: after a change it would never settle; the case must "
    "state a damping of the mounts or of the modes"
)


def _refuse(which: np.ndarray, words: str) -> None:
    if np.any(which):
        raise NumericalFailure(words.format(int(np.argmax(which)) + 1))


# ----------------------------------------------------------------------------
# The free motion of damped modes in closed form, below, at and above critical damping.
# ----------------------------------------------------------------------------

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


# ----------------------------------------------------------------------------
# Waves of all orders at many crank angles, for sums by one product of real matrices.
# ----------------------------------------------------------------------------


def order_waves(angle: np.ndarray, orders: np.ndarray) -> np.ndarray:
    """cos and sin (angles, 2 orders) of n theta, side by side; orders are integers from 1.

    Powers of exp(i theta) by doubling, so that hundreds of orders cost one multiplication each;
    the relative error is about n eps, no more than that of the angle itself.
    """
    highest = int(np.max(orders, initial=0))
    power = np.empty((len(angle), highest + 1), dtype=complex)
    power[:, 0] = 1.0
    if highest:
        power[:, 1] = np.cos(angle) + 1j * np.sin(angle)
    known = 1
    while known < highest:
        more = min(known, highest - known)
        power[:, known + 1 : known + 1 + more] = power[:, 1 : 1 + more] * power[:, known, None]
        known += more
    return np.ascontiguousarray(power[:, orders]).view(float)


def real_rows(amplitude: np.ndarray) -> np.ndarray:
    """Rows (2 orders, columns) whose product with the waves is Re sum A_n exp(i n theta)."""
    rows = np.empty((2 * len(amplitude), amplitude.shape[1]))
    rows[0::2], rows[1::2] = amplitude.real, -amplitude.imag
    return rows


# ----------------------------------------------------------------------------
# The steady motion of each mode at a constant crank speed.
# ----------------------------------------------------------------------------


class SteadyMotion(NamedTuple):
    """Modal amplitudes (orders, modes), complex 0-peak in q = Re sum Q_n exp(i n theta).

    `error` (modes,) bounds the error of the size sqrt(q'^2 + w^2 q^2) at any instant.
    """

    amplitude: np.ndarray
    error: np.ndarray


def steady_motion(
    system: ModalSystem, loads: ModalLoads, operation: int, speed: float
) -> SteadyMotion:
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
    uncertainty = np.sum((4.0 * EPSILON * lost * np.abs(amplitude) + noise) * magnitude, axis=0)
    uncertainty = uncertainty + _size_of_dropped(system, loads, operation, speed)
    # what is left out: static, or at its worst on the resonance
    stiffest = frequency * np.minimum(2.0 * system.damping_ratio, 1.0)
    left_out = loads.left_out[operation] * speed**2 * loads.driven
    left_out = 2.0 * left_out / np.where(loads.driven, stiffest, 1.0)
    return SteadyMotion(amplitude, uncertainty + left_out)


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


def steady_state(
    steady: SteadyMotion, orders: np.ndarray, speed: float, angle: np.ndarray
) -> np.ndarray:
    """Displacement and velocity (..., modes, 2) at crank angles (...)."""
    rates = 1j * (orders * speed)[:, None] * steady.amplitude
    modes = steady.amplitude.shape[1]
    rows = real_rows(np.concatenate([steady.amplitude, rates], axis=1))
    both = order_waves(np.asarray(angle, dtype=float).ravel(), orders) @ rows
    shape = (*np.shape(angle), modes)
    return np.stack([both[:, :modes].reshape(shape), both[:, modes:].reshape(shape)], axis=-1)
