"""Is a response known to four digits at least?"""

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import SINGULAR, WithError
from vibecalc.response.direct import Dynamics
from vibecalc.response.matrices import Matrices


def require_digits(
    matrices: Matrices,
    system: Dynamics,
    force: WithError,
    motion: WithError,
    orders: np.ndarray,
    speed: float,
) -> None:
    """Refuse a response that the rounding of stiffness, damping and mass alone may change.

    `system` and `force`, `motion` (orders, 6) belong to the crank speed. The undamped modes have
    been looked at before; this also meets nearly coinciding modes whose damping acts on a
    combination of them only. A force that is zero to rounding is not judged.

    Raises
    ------
    NumericalFailure
        If fewer than four digits remain in the response to a driven order.
    """
    weight = np.sqrt(np.diagonal(matrices.mass))
    size = np.abs(motion.value)
    doubt = (np.abs(system.inverse) @ (system.error @ size[..., None]))[..., 0]
    driven = np.any(np.abs(force.value) > 4.0 * force.error, axis=-1)
    largest = np.max(weight * size, axis=-1)
    lost = driven & ~(np.max(weight * doubt, axis=-1) < SINGULAR * largest)
    if np.any(lost):
        order = float(orders[int(np.argmax(lost))])
        raise NumericalFailure(
            f"order {order:g} at {speed:.9g} rad/s meets an undamped resonance at "
            f"{order * speed:.9g} rad/s: of the response fewer than four digits would be certain. "
            "Give the mounts damping or a loss factor in every direction, or move the speed or "
            "the stiffness"
        )
