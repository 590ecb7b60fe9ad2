"""The running gear of one cylinder with its joints, and the states that its runs start from.

The start of an ensemble is spread evenly over the clearance and over the velocities that a piston
can have in it, by an additive recurrence that is written out here: it is the same on every
machine and in every version of every library.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import FloatArray
from vibecalc.response.impact.model import Drive, GasForce, Joint


class Linkage(NamedTuple):
    """One cylinder: masses in kg; the joints hold plain numbers, see `model.py`.

    `mass` is what lies beyond the wrist pin's play. `crank_pin` and `rod_mass` (the rod's
    reciprocating point mass, between the two gaps) are there together or not at all. The
    clearance of `bore` is the whole lateral play.
    """

    drive: Drive
    gas: GasForce
    mass: float
    wrist_pin: Joint
    crank_pin: Joint | None = None
    rod_mass: float | None = None
    bore: Joint | None = None


class Starts(NamedTuple):
    """Gaps, m, and their velocities, m/s, (..., G) in the order wrist pin, crank pin, bore."""

    gap: FloatArray
    velocity: FloatArray


def low_discrepancy(points: int, dimensions: int) -> FloatArray:
    """Points (points, dimensions) of the unit cube, the first one its centre.

    x_k = frac(1/2 + k a) with a_i = g^-i, g the root of g^(dimensions + 1) = g + 1 above 1: the
    golden ratio for one dimension, the plastic number for two. Source: the additive recurrences
    of H. Niederreiter (1992, ch. 3), with the numbers of M. Roberts (2018).
    """
    root = 1.5
    for _ in range(100):
        root = (1.0 + root) ** (1.0 / (dimensions + 1.0))
    step = root ** -np.arange(1.0, dimensions + 1.0)
    return np.asarray(np.mod(0.5 + np.arange(points)[:, None] * step, 1.0))


def clearances(linkage: Linkage, clearance: FloatArray) -> FloatArray:
    """Clearances (..., G) of all gaps where the wrist pin has `clearance` (...)."""
    wrist_pin = np.asarray(clearance, dtype=np.float64)
    others = [joint for joint in (linkage.crank_pin, linkage.bore) if joint is not None]
    columns = [wrist_pin, *(np.full_like(wrist_pin, joint.clearance) for joint in others)]
    return np.stack(columns, axis=-1)


def velocity_scale(linkage: Linkage, clearance: FloatArray) -> FloatArray:
    """Velocity (..., G) with which a gap is crossed from rest, m/s: sqrt(2 a clearance).

    a is the sum of the sizes of all harmonics of the pin's acceleration and of the largest gas
    force over the mass; in the bore, as much of it as the rod's angle can turn sidewards.
    """
    drive = linkage.drive
    pin = np.sum(np.square(drive.orders * drive.speed) * np.abs(drive.displacement))
    gas = float(np.max(np.abs(linkage.gas.force), initial=0.0))
    acceleration = np.full(gaps_of(linkage), pin + gas / linkage.mass)
    if linkage.bore is not None and drive.rod_tangent is not None:
        acceleration[-1] *= np.sum(np.abs(drive.rod_tangent))
    return np.asarray(np.sqrt(2.0 * acceleration * clearances(linkage, clearance)))


def gaps_of(linkage: Linkage) -> int:
    """Number of gaps."""
    return 1 + (linkage.crank_pin is not None) + (linkage.bore is not None)


def spread_starts(linkage: Linkage, clearance: FloatArray, members: int) -> Starts:
    """States (C, members, G) at crank angle 0 for clearances (C,) of the wrist pin.

    Each gap lies anywhere between its faces and opens or closes with up to `velocity_scale`; the
    first member is `central_start`.
    """
    gaps = gaps_of(linkage)
    point = low_discrepancy(members, 2 * gaps)
    width = clearances(linkage, clearance)[:, None]
    fastest = velocity_scale(linkage, clearance)[:, None]
    return Starts(width * point[:, :gaps], fastest * (2.0 * point[:, gaps:] - 1.0))


def central_start(linkage: Linkage, clearance: FloatArray) -> Starts:
    """States (C, G) with every gap in its middle and at rest: the pin is in the piston's middle."""
    middle = 0.5 * clearances(linkage, clearance)
    return Starts(middle, np.zeros_like(middle))
