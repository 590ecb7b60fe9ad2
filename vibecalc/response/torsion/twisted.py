"""Mode shapes of a row of inertias by a twisted factorisation, all modes at once.

At a frequency of its own, the ratio Z of torque to angle runs from both ends of the row. The two
meet at a station r where Z from the left and Z from the right, its own inertia counted once, add
up to almost nothing; from there the angles follow outwards as products of k / (k + Z), which
neither overflow nor cancel (Fernando 1997, Dhillon and Parlett 2004).
"""

import numpy as np

from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.response.torsion.bidiagonal import Row


def row_shapes(row: Row, frequency: FloatArray) -> FloatArray:
    """Shapes (m, n), largest component of each at angle about 1, at natural frequencies (m,)."""
    count, modes = len(row.inertia), len(frequency)
    if count == 1:
        return np.ones((modes, 1))
    # one piece of memory for all that is needed on the way: the system keeps it for the next call,
    # and handing it out anew takes longer than the arithmetic
    scratch = np.empty((6, count, modes))
    own, other = scratch[:2]
    hanging, ratio = scratch[2:].reshape(2, count, 2, modes)
    ratio = ratio[1:]
    np.multiply(-row.inertia[:, None], frequency**2, out=own)
    own += row.ground[:, None]
    springs = np.stack([row.stiffness, row.stiffness[::-1]], axis=1)
    with np.errstate(all="ignore"):
        _march(own, springs, hanging, ratio, 0.0)
    if not np.isfinite(ratio).all():
        _march(own, springs, hanging, ratio, 2.0**-60)
    np.add(hanging[:, 0], hanging[::-1, 1], out=other)
    other -= own
    np.abs(other, out=other)
    other /= row.inertia[:, None]
    leftward, rightward = ratio[:, 0], ratio[::-1, 1]
    best = np.argmin(other, axis=0)
    shape = _outwards(leftward, rightward, best)
    # a start of little energy magnifies roundings: begin again at the station of most
    energy = np.multiply(shape, shape, out=other)
    energy *= row.inertia[:, None]
    better = np.argmax(energy, axis=0)
    every = np.arange(modes)
    moved = np.flatnonzero(energy[best, every] < 0.05 * energy[better, every])
    if moved.size:
        shape[:, moved] = _outwards(leftward[:, moved], rightward[:, moved], better[moved])
    return shape.T


def _march(
    own: FloatArray, springs: FloatArray, hanging: FloatArray, ratio: FloatArray, nudge: float
) -> None:
    """From the left and from the right, in place: Z with the station's own, `hanging` (n, 2, m),
    and its angle over that of the next station, `ratio` (n - 1, 2, m)."""
    hanging[:, 0], hanging[:, 1] = own, own[::-1]
    ratio[:] = springs[:, :, None]
    pivot = np.empty_like(hanging[0])
    for share, here, there in zip(list(ratio), list(hanging[:-1]), list(hanging[1:]), strict=True):
        np.add(here, share, pivot)
        if nudge:
            pivot = np.where(pivot == 0.0, share * nudge, pivot)
        np.divide(share, pivot, share)
        np.multiply(share, here, pivot)
        np.add(there, pivot, there)


def _outwards(leftward: FloatArray, rightward: FloatArray, start: IntArray) -> FloatArray:
    """Angles (n, m), 1 at the station `start` (m,) of each mode, by products of ratios."""
    count = len(leftward) + 1
    left = np.arange(count - 1)[:, None] < start
    # beyond the start each product is of ones
    shape, right = np.ones((2, count, len(start)))
    np.copyto(shape[:-1], leftward, where=left)
    np.copyto(right[1:], rightward, where=~left)
    rows = list(shape)
    for here, there in zip(rows[-2::-1], rows[:0:-1], strict=True):
        np.multiply(here, there, here)
    rows = list(right)
    for here, there in zip(rows[1:], rows[:-1], strict=True):
        np.multiply(here, there, here)
    shape *= right
    return shape
