"""Readings of a rigid body's motion: forces of the mounts on the ground."""

import numpy as np

from vibecalc.isolation.readout import Readout
from vibecalc.isolation.rigid_body import displacement_at
from vibecalc.numerics.rounding import DATA_ROUNDINGS, UNIT_ROUNDOFF


def mount_readout(
    position: np.ndarray, stiffness: np.ndarray, damping: np.ndarray, structural: np.ndarray
) -> Readout:
    """Force of each mount on the ground, rows of three components, for a rigid body."""
    transform = displacement_at(position)
    rounding = (8 + DATA_ROUNDINGS) * UNIT_ROUNDOFF
    return Readout((stiffness + 1j * structural) @ transform, damping @ transform, rounding)
