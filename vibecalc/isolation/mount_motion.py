"""What a moving body does at its mounts: displacements, and forces on the ground."""

import numpy as np

from vibecalc.isolation.rigid_body import displacement_at
from vibecalc.numerics.rounding import DATA_ROUNDINGS, UNIT_ROUNDOFF, WithError


def displacement(body: WithError, position: np.ndarray) -> WithError:
    """Displacement (..., mounts, 3, orders) in m at points (mounts, 3), from X (..., orders, 6)."""
    transform = displacement_at(position)[..., None, :, :, :]
    value = (transform @ body.value[..., :, None, :, None])[..., 0]
    terms = np.abs(transform) @ np.abs(body.value)[..., :, None, :, None]
    error = np.abs(transform) @ body.error[..., :, None, :, None]
    total = (error + 4.0 * UNIT_ROUNDOFF * terms)[..., 0]
    return WithError(np.moveaxis(value, -3, -1), np.moveaxis(total, -3, -1))


def mount_force(
    motion: WithError,
    frequency: np.ndarray,
    stiffness: np.ndarray,
    damping: np.ndarray,
    structural: np.ndarray,
) -> WithError:
    """Force of each mount on the ground (..., mounts, 3, orders) in N, in complex amplitude.

    `motion` as `displacement` returns it, `frequency` (..., orders) rad/s, properties
    (mounts, 3, 3). The force has the direction of the displacement for a stiff mount.
    """
    rate = np.asarray(frequency)[..., None, :, None, None]
    passing = (stiffness + 1j * structural)[:, None] + 1j * (rate * damping[:, None])
    value = (passing @ np.moveaxis(motion.value, -1, -2)[..., None])[..., 0]
    rounding = (6.0 + DATA_ROUNDINGS) * UNIT_ROUNDOFF
    spread = motion.error + rounding * np.abs(motion.value)
    error = (np.abs(passing) @ np.moveaxis(spread, -1, -2)[..., None])[..., 0]
    return WithError(np.moveaxis(value, -2, -1), np.moveaxis(error, -2, -1))
