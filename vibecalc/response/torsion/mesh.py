"""Gear mesh: mean and alternating torque together, and whether the teeth leave each other."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import BoolArray, FloatArray
from vibecalc.response.torsion.synthesis import synthesis


class MeshTorque(NamedTuple):
    """Arrays (...). `least` and `largest` over the cycle in N m, mean included, error `error`.

    `hammer`: the torque changes its sign within the cycle, so that the teeth lift off and strike
    back. `share` is the half range over the mean's magnitude, infinite for an unloaded mesh that
    vibrates, 0 for one at rest. `uncertain`: an end is zero to within the error.
    """

    least: FloatArray
    largest: FloatArray
    half_range: FloatArray
    share: FloatArray
    hammer: BoolArray
    uncertain: BoolArray
    error: FloatArray


def mesh_torque(
    mean: ArrayLike, order: ArrayLike, amplitude: ArrayLike, error: ArrayLike = 0.0
) -> MeshTorque:
    """From the mean torque (...) that the mesh transmits and orders (m,) of its torque (..., m).

    An order 0 among them would be counted beside `mean`.
    """
    steady = np.asarray(mean, dtype=float)
    found = synthesis(order, amplitude, error)
    least, largest = steady + found.lowest, steady + found.highest
    half_range = np.broadcast_to(found.half_range, least.shape)
    size = np.abs(steady)
    unloaded = np.where(half_range > 0.0, np.inf, 0.0)
    share = np.where(size > 0.0, half_range / np.where(size > 0.0, size, 1.0), unloaded)
    doubt = found.error + EPSILON * (size + half_range)
    hammer = (least < -doubt) & (largest > doubt)
    # the end that the mean keeps away from zero decides
    near = np.minimum(np.abs(least), np.abs(largest)) <= doubt
    return MeshTorque(least, largest, half_range, share, hammer, near & (half_range > 0.0), doubt)
