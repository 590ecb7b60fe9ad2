"""Rows of many rigid bodies on their mounts as sums over poles: a quick look for their run-ups."""

from typing import NamedTuple

import numpy as np

from vibecalc.isolation.rows import EMPTY, Jet, Readout
from vibecalc.numerics.bounded import Bounded
from vibecalc.response.modal_damping import DampedPoles
from vibecalc.response.modes import Modes

# ----------------------------------------------------------------------------
# With the poles s and their motions v the response of a body at w = n W is
#
#     X = W^2 sum_p v_p (u_p F_n) / (i w - s_p),   sum_p v_p u_p = 0
#
# and (still + w rising) v_p may be read at the pole instead, w = -i s. Slopes by W come with powers
# of the same fractions. That is as good as the motions are independent of each other, for all
# speeds.
# ----------------------------------------------------------------------------

#: norms of the motions and of their inverse, multiplied, up to which a sum is good to some 1e-9
MOST_DEPENDENT = 1e6
#: fractions over speeds, orders and poles that are worked on at once
_MOST_AT_ONCE = 400_000


class PoleSums(NamedTuple):
    """Of each machine: poles (machines, p) in rad/s, what each of them shows in the rows `reading`
    (machines, p, rows, components), and how the `orders` (n,) drive it, (machines, n, p).
    """

    pole: np.ndarray
    reading: np.ndarray
    drive: np.ndarray
    orders: np.ndarray

    def values(self, machine: np.ndarray, speed: np.ndarray) -> np.ndarray:
        """Harmonics (k, rows, components, n) of machines (k,) at crank speeds (k,), rad/s."""
        *_, rows, components = self.reading.shape
        found = np.empty((len(speed), len(self.orders), rows * components), dtype=complex)
        reading = self.reading.reshape(*self.reading.shape[:2], rows * components)
        step = max(_MOST_AT_ONCE // self.drive[0].size, 1)
        for first in range(0, len(speed), step):
            part = slice(first, first + step)
            own, rate = machine[part], speed[part]
            share = self.drive[own] * self._fractions(own, rate)
            found[part] = np.square(rate)[:, None, None] * (share @ reading[own])
        return found.swapaxes(1, 2).reshape(len(speed), rows, components, len(self.orders))

    def jets(self, machine: np.ndarray, speed: np.ndarray, row: np.ndarray) -> Jet:
        """One row each (k,), with slopes: parts (k, components, n)."""
        reading, rate = self.reading[machine, :, row], speed[:, None, None]
        fraction = self._fractions(machine, speed)
        turning = -1j * self.orders[:, None] * fraction
        share = self.drive[machine] * fraction
        steeper = share * turning
        level, slope, bend = (
            (one @ reading).swapaxes(1, 2) for one in (share, steeper, 2.0 * steeper * turning)
        )
        value = rate * rate * level
        curvature = 2.0 * level + 4.0 * rate * slope + rate * rate * bend
        return Jet(value, EMPTY, 2.0 * rate * level + rate * rate * slope, EMPTY, curvature)

    def _fractions(self, machine: np.ndarray, speed: np.ndarray) -> np.ndarray:
        frequency = 1j * speed[:, None] * self.orders
        return np.asarray(1.0 / (frequency[..., None] - self.pole[machine][:, None, :]))


def pole_sums(
    poles: DampedPoles, shapes: Modes, readout: Readout, orders: np.ndarray, force: Bounded
) -> tuple[PoleSums, np.ndarray]:
    """The sums of machines, and which of them (machines,) have motions too dependent for them.

    All have machines as first axis; forces (machines, n, f) are per squared crank speed.
    """
    states, size = poles.state, shapes.shape.shape[-1]
    scale = np.asarray(poles.scale)[..., None]
    try:
        inverse = np.linalg.inv(states)
    except np.linalg.LinAlgError:
        dependent = np.linalg.cond(states) > MOST_DEPENDENT
        states = np.where(dependent[:, None, None], np.eye(2 * size), states)
        inverse = np.linalg.inv(states)
    else:
        dependent = np.linalg.norm(states, axis=(1, 2)) * np.linalg.norm(inverse, axis=(1, 2))
        dependent = ~(dependent <= MOST_DEPENDENT)
    pole = poles.root * scale
    motion = (shapes.shape @ states[:, :size]).mT
    drive = (force.value @ shapes.shape) @ inverse[:, :, size:].mT / scale[..., None]
    still, rising = (
        np.einsum("mpf,mrcf->mprc", motion, part) for part in (readout.still, readout.rising)
    )
    reading = still - 1j * pole[:, :, None, None] * rising
    return PoleSums(pole, reading, drive, np.asarray(orders, dtype=float)), dependent
