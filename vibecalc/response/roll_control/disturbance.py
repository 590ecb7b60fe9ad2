"""What gas, inertia and friction do to a rotor at constant speed: the load of the reduced model."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.gauss import gauss_rule
from vibecalc.numerics.rounding import EPSILON, WithError
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.roll.machine import RollDrive, RollMachine
from vibecalc.response.roll.rates import Place, place_at
from vibecalc.response.roll.torques import smooth_angles

#: Gauss points on a panel beside those that the highest order needs, and on the finer look
_POINTS, _MORE = 10, 4
_WIDEST = np.pi / 18.0


class Disturbance(NamedTuple):
    """Torque on the rotor of one machine, N m, and what it turns against.

    `mean` d_0 is negative where the machine takes power, without viscous friction; `gas` and
    `inertia` (orders,) are harmonics of order 1 and up, complex 0-pk with t = 0 at crank angle 0,
    the second for a crank speed of 1 rad/s. `whole`, `coupling` and `crank` are the means over the
    turn of J, N and Q, kg m^2.
    """

    mean: WithError
    gas: WithError
    inertia: WithError
    whole: float
    coupling: float
    crank: float

    def at(self, speed: float) -> WithError:
        """Harmonics (orders,) in N m at a crank speed in rad/s; what rounding leaves is zero."""
        value = self.gas.value + speed**2 * self.inertia.value
        error = self.gas.error + speed**2 * self.inertia.error
        return WithError(np.where(np.abs(value) > error, value, 0.0), error)


def disturbance(machine: RollMachine, drive: RollDrive, orders: int) -> Disturbance:
    """Load of one machine (B = 1): d(t) = gas and dry friction - Q'(W t) W^2 / 2.

    Source: Herold 1977, section 7.1, the torque f of Fig. 24 at a speed that does not vary; here
    with the exact motion of the pistons. The integrals stop at every node of the gas tables.
    """
    edges = smooth_angles(machine, drive)
    points = _POINTS + int(np.ceil(0.5 * orders * _WIDEST))
    plain, finer = (_sums(machine, drive, edges, n, orders) for n in (points, points + _MORE))
    load, inertia, place = finer
    errors = [
        np.abs(one - other) + 64.0 * EPSILON * float(np.max(np.abs(size)))
        for one, other, size in zip(plain[:2], finer[:2], (place.load, place.moved.crank_slope),
                                    strict=True)
    ]  # fmt: skip
    weight = _weights(edges, points + _MORE)
    whole, coupling, crank = (
        float(np.sum(np.broadcast_to(part, (1, len(weight))) * weight))
        for part in (place.moved.shell, place.moved.coupling, place.moved.crank)
    )
    return Disturbance(
        WithError(load[0].real, errors[0][0]),
        WithError(2.0 * load[1:], 2.0 * errors[0][1:]),
        # Q' / 2, and twice the mean for an amplitude
        WithError(-inertia[1:], errors[1][1:]),
        whole,
        coupling,
        crank,
    )


def _sums(
    machine: RollMachine, drive: RollDrive, edges: FloatArray, points: int, orders: int
) -> tuple[np.ndarray, np.ndarray, Place]:
    """Means over the turn of load and Q' times exp(-i n b), n from 0, and what they are made of."""
    nodes = gauss_rule(points).nodes
    angle = (edges[:-1, None] + np.diff(edges)[:, None] * nodes).ravel()
    place = place_at(machine, drive, angle[None])
    wave = _weights(edges, points) * np.exp(-1j * np.arange(orders + 1)[:, None] * angle)
    return wave @ place.load[0], wave @ place.moved.crank_slope[0], place


def _weights(edges: FloatArray, points: int) -> FloatArray:
    """Weights of the mean over the turn."""
    weight = np.diff(edges)[:, None] * gauss_rule(points).weights / (2.0 * np.pi)
    return np.asarray(weight.ravel())
