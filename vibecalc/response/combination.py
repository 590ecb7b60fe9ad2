"""Operating modes combined with balances: motions add as phasors, and only then become energies.

Two forces of one frequency do not have energies that add: what counts is how one leads the other.
So each pair of an operation and a balance is one motion, and turning the balance weight against
the crank by an angle p turns the phasors of its residual force by exp(i p).
"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import EPSILON, UNIT_ROUNDOFF, WithError
from vibecalc.response.direct import Dynamics, Undriven, dynamics, response
from vibecalc.response.matrices import Matrices


class Superposed(NamedTuple):
    """Motions of the parts, complex amplitudes in m and rad.

    `shaking` (operations, orders, 6) by the pistons; `residual` (operations, balances, 6) of order
    1 by what turns and is not balanced, its weight at the nominal phase; `first` is the place of
    order 1 among the orders.
    """

    shaking: WithError
    residual: WithError
    first: int


def superpose(
    matrices: Matrices,
    orders: np.ndarray,
    speed: float,
    shaking: WithError,
    residual: WithError,
    undriven: Undriven | None = None,
) -> Superposed:
    """Respond to the loads of all operations and balances at once.

    Parameters
    ----------
    orders : (orders,) with 1 among them; speed in rad/s.
    shaking : (operations, orders, 6) forces and couples on the body in N and N m, at speed.
    residual : (operations, balances, 6) rotating ones of order 1, about the same point.
    undriven : pairs (orders, modes) that no load drives, to leave out; as for `direct.dynamics`.

    Raises
    ------
    NumericalFailure
        An order is exactly on an undamped natural frequency. Close to one, the errors grow;
        `singular.check_operating_point` and `trust.require_digits` say when that is too close.
    """
    first = int(np.flatnonzero(np.asarray(orders) == 1)[0])
    count, balances = len(orders), residual.value.shape[-2]
    system = dynamics(matrices, np.asarray(orders) * speed, undriven)
    rows = np.concatenate([np.arange(count), np.full(balances, first)])
    repeated = Dynamics(*(part[rows] for part in system))
    motion = response(
        repeated,
        np.concatenate([shaking.value, residual.value], axis=-2),
        np.concatenate([shaking.error, residual.error], axis=-2),
    )
    return Superposed(
        WithError(motion.value[..., :count, :], motion.error[..., :count, :]),
        WithError(motion.value[..., count:, :], motion.error[..., count:, :]),
        first,
    )


def at_phase(parts: Superposed, phase: np.ndarray | float = 0.0) -> WithError:
    """Motion (operations, balances, orders, 6) with the weights turned by a phase in rad.

    `phase` broadcasts with (operations, balances).
    """
    angle = np.asarray(phase, dtype=float)[..., None]
    turned = parts.residual.value * (np.cos(angle) + 1j * np.sin(angle))
    shape = (*turned.shape[:-1], *parts.shaking.value.shape[-2:])
    value = np.broadcast_to(parts.shaking.value[..., None, :, :], shape).copy()
    error = np.broadcast_to(parts.shaking.error[..., None, :, :], shape).copy()
    value[..., parts.first, :] += turned
    rounding = 3.0 * EPSILON * np.abs(turned) + UNIT_ROUNDOFF * np.abs(value[..., parts.first, :])
    error[..., parts.first, :] += parts.residual.error + rounding
    return WithError(value, error)
