"""How mounts along the crankshaft share the weight: heave and pitch, nothing else."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import DATA_ROUNDINGS, UNIT_ROUNDOFF


class PitchStatic(NamedTuple):
    """Sag (..., mounts) in m, positive down, and share of the weight (..., mounts) in N."""

    sag: np.ndarray
    sag_error: np.ndarray
    share: np.ndarray
    share_error: np.ndarray


def pitch_static(
    weight: np.ndarray | float,
    centre: np.ndarray | float,
    position: np.ndarray,
    stiffness: np.ndarray,
) -> PitchStatic:
    """Vertical equilibrium and moments about the pitch axis; equal sag across the crankshaft.

    Parameters
    ----------
    weight, centre : (...) in N and m along the crankshaft.
    position, stiffness : (..., mounts) in m and N/m, vertical.

    About the stiffness-weighted mean position the two freedoms part: all mounts sink by
    W / sum k, and turn by the moment of the weight over the pitch stiffness about that point.
    Raises NumericalFailure if all mounts stand at one position and the weight does not.
    """
    load = np.asarray(weight, dtype=float)[..., None]
    total = np.sum(stiffness, axis=-1, keepdims=True)
    mean = np.sum(stiffness * position, axis=-1, keepdims=True) / total
    arm = position - mean
    turning = np.sum(stiffness * np.square(arm), axis=-1, keepdims=True)
    offset = np.asarray(centre, dtype=float)[..., None] - mean
    extent = np.sum(stiffness * np.abs(position), axis=-1, keepdims=True) / total
    rounding = (np.shape(position)[-1] + 4 + DATA_ROUNDINGS) * UNIT_ROUNDOFF
    doubt = rounding * (np.abs(np.asarray(centre))[..., None] + 2.0 * extent)
    flat = turning <= np.square(doubt) * total
    if np.any(flat & (np.abs(offset) > doubt)):
        raise NumericalFailure(
            "all mounts stand at one position along the crankshaft and the mass centre does not: "
            "the machine would tip; move a mount"
        )
    tilt = np.where(flat, 0.0, offset / np.where(flat, 1.0, turning))
    sag = load / total + load * tilt * arm
    share = stiffness * sag
    size = load / total + np.abs(load * tilt * arm)
    slope = np.where(flat, 0.0, load / np.where(flat, 1.0, turning))
    extent_doubt = doubt * (np.abs(arm) + np.abs(offset))
    error = rounding * 3.0 * size + slope * extent_doubt
    # the error of the mean position enters the pitch stiffness in second order only
    return PitchStatic(sag, error, share, stiffness * error + UNIT_ROUNDOFF * np.abs(share))
