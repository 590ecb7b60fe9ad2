"""What a transient needs to know: the modes of the body, the loads of each operation, the course.

Loads and speed are known functions of time; the body does not act back on the crank.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON

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
    `kept` is the number of orders that move the body; without it all do. Those behind them are
    dropped from the motion, and what they would add stands in its errors.
    """

    orders: np.ndarray
    per_speed_squared: np.ndarray
    per_acceleration: np.ndarray
    kept: int | None = None


class Piece(NamedTuple):
    """A part of the course: the crank's speed is linear in time, one operation works.

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

    kept_orders = loads.orders[: loads.kept]
    dropped_orders, dropped = loads.orders[len(kept_orders) :], amplitude[:, len(kept_orders) :]
    order = np.argsort(kept_orders, kind="stable")
    sorted_size = np.max(np.abs(amplitude[:, order]), axis=0)
    rest = np.cumsum(sorted_size[::-1], axis=0)[::-1]
    needed = np.any(rest > _NEGLIGIBLE * np.sum(sorted_size, axis=0), axis=1)
    kept = order[needed & np.any(sorted_size > 0.0, axis=1)]
    rest_of_them = np.sum(np.abs(amplitude[:, order[~needed]]), axis=1)
    noise = noise[:, kept] * driven
    return ModalLoads(
        loads.orders[kept],
        amplitude[:, kept],
        noise,
        push,
        rest_of_them,
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
