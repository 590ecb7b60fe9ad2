"""Forced response of a rigid body on mounts as a sum of modes."""

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.bounded import Bounded, reshaped
from vibecalc.numerics.linear import (
    Linear,
    UndrivenModes,
    bounded_parts,
    dynamics,
    require_digits,
    response,
)


def modal_response(
    matrices: Linear,
    shape: np.ndarray,
    order: np.ndarray,
    speed: ArrayLike,
    load: Bounded,
    undriven: UndrivenModes | None = None,
) -> Bounded:
    """Complex amplitudes X (..., orders, 6) of D X = F as X = V q, in m and rad.

    With unit modal mass and modal force f = V^T F,

        q_j = f_j / (w_j^2 - W^2 + i W c_j + i h_j)

    where damping and structural matrices leave the modes apart; then c_j is 2 zeta_j w_j and h_j
    is eta_j w_j^2. Where they couple modes by more than rounding, the coupled modal equations are
    solved. Modes without stiffness and repeated modes are modes like any other.

    Parameters
    ----------
    shape : (..., 6, 6) modes in columns, with the leading axes of the matrices; their signs and
        scales do not matter.
    order, speed : W = order times speed, (orders,) and (...) in rad/s.
    load : F (..., orders, 6) complex in N and N m.
    undriven : undamped modes of these shapes to leave out of some orders.

    Raises
    ------
    NumericalFailure
        Fewer than four digits of the response to an order would be certain: it drives a mode at
        its undamped natural frequency.

    Source: W. T. Thomson, Theory of Vibration with Applications, 5th ed., chapter 6.
    """
    modal = [shape.mT @ part @ shape for part in bounded_parts(matrices)]
    aside = 1.0 - np.eye(shape.shape[-1])
    coupled = any(np.any(np.abs(part.value) * aside > part.error) for part in modal)

    def systems(part: np.ndarray) -> np.ndarray:
        """One system of all modes (..., 1, 6, 6), or one of each mode by itself (..., 6, 1, 1)."""
        return part[..., None, :, :] if coupled else np.linalg.diagonal(part)[..., None, None]

    reduced = Linear(
        *(systems(part.value) for part in modal), *(systems(part.error) for part in modal)
    )
    size = reduced.mass.shape[-1]

    def split(rows: np.ndarray) -> np.ndarray:
        """Of all modes (..., orders, 6) those of each system, (..., systems, orders, size)."""
        return np.moveaxis(rows.reshape(*rows.shape[:-1], -1, size), -2, -3)

    if undriven is not None:
        pairs, _, eigenvalue = undriven
        each = eigenvalue.reshape(*eigenvalue.shape[:-1], -1, size)
        undriven = UndrivenModes(split(pairs), np.eye(size), each)
    drive, rate = reshaped(load @ shape, split), np.asarray(speed)[..., None]
    dynamic = dynamics(reduced, order * rate[..., None], undriven)
    motion = response(dynamic, drive.value, drive.error)
    require_digits(reduced, dynamic, drive, motion, order, rate)
    rows = reshaped(motion, lambda part: np.moveaxis(part, -3, -2))
    return rows[..., 0] @ shape.mT if size == 1 else rows[..., 0, :] @ shape.mT
