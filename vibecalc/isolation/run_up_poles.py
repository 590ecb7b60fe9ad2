"""Run-ups of many rigid bodies on their mounts: sums over poles lead, dynamic stiffness decides."""

from typing import NamedTuple

import numpy as np

from vibecalc.isolation.rows import EMPTY, Jet, Readout, body_rows, with_left_out
from vibecalc.isolation.run_up_peaks import RunUpPeak, highest_peaks
from vibecalc.isolation.run_up_samples import Machines
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.linear import Linear
from vibecalc.numerics.rounding import BoolArray
from vibecalc.response.modal_damping import DampedPoles, damped_poles
from vibecalc.response.modes import Modes
from vibecalc.response.resonances import MaskedSpeeds, Resonances
from vibecalc.response.system import MountedBody

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
        reading = self.reading.reshape(*self.reading.shape[:2], -1)[machine]
        share = self.drive[machine] * self._fractions(machine, speed)
        found = (share @ reading).swapaxes(1, 2) * np.square(speed)[:, None, None]
        return np.asarray(found.reshape(len(speed), *self.reading.shape[2:], len(self.orders)))

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
    size, scale = shapes.shape.shape[-1], np.asarray(poles.scale)[..., None]
    dependent = ~(np.linalg.cond(poles.state, "fro") <= MOST_DEPENDENT)
    states = np.where(dependent[:, None, None], np.eye(2 * size), poles.state)
    pole = poles.root * scale
    motion = (shapes.shape @ states[:, :size]).mT
    drive = (force.value @ shapes.shape) @ np.linalg.inv(states)[:, :, size:].mT / scale[..., None]
    still, rising = (
        np.einsum("mpf,mrcf->mprc", motion, part) for part in (readout.still, readout.rising)
    )
    reading = still - 1j * pole[:, :, None, None] * rising
    return PoleSums(pole, reading, drive, np.asarray(orders, dtype=float)), dependent


# ----------------------------------------------------------------------------
# The highest peaks of many bodies at once.
# ----------------------------------------------------------------------------

#: machines times orders that are worked on at once
_MOST_AT_ONCE = 600


def peaks_of_bodies(
    body: MountedBody, readout: Readout, load: Bounded, tail: np.ndarray | float,
    orders: np.ndarray, used: int, few: np.ndarray, start: float, stop: float, left: BoolArray,
) -> tuple[RunUpPeak, BoolArray]:  # fmt: skip
    """Highest peaks (machines, rows) in a range of speeds in rad/s, and what has to be run alone.

    Arrays have machines as first axis, or lack it where all have the same. Loads `load` (machines,
    orders, f) are per squared crank speed. The first `used` of the `orders` are kept, those at the
    places `few` stand, `tail` (machines,) times, for what is left out. Those `left` (machines,)
    are not looked at, and have to be run alone as have bodies that nothing damps in some mode, and
    those whose motions in free vibration are nearly dependent.
    """

    def each(own: int, part: np.ndarray) -> np.ndarray:
        return np.broadcast_to(part, (len(left), *part.shape[part.ndim - own :]))

    matrices, axes = Linear(*(each(2, part) for part in body.matrices)), (1, 1, 2, 2, 1, 1)
    shapes = Modes(*(each(own, part) for own, part in zip(axes, body.shapes, strict=True)))
    readout = readout._replace(still=each(3, readout.still), rising=each(3, readout.rising))
    load, tail = Bounded(*(each(2, part) for part in load)), np.broadcast_to(tail, len(left))
    first, rows = load[:, :used], readout.still.shape[1]
    system, poles = MountedBody(matrices=matrices, shapes=shapes), damped_poles(matrices, shapes)
    met = system.resonances(first)
    sought = system.with_poles(met, first, poles=poles)
    sums, dependent = pole_sums(poles, shapes, readout, orders[:used], first)
    left = left | np.any(met.exposed() > 0.0, axis=-1) | dependent
    none = np.zeros(0)

    def machines(members: np.ndarray) -> Machines:
        def jets_at(speed: np.ndarray, row: np.ndarray, errors: bool = False) -> Jet:
            machine = members[row // rows]
            own = Linear(*(part[machine] for part in matrices))
            read = readout.rows(machine[:, None], (row % rows)[:, None])
            kept, beyond = (
                body_rows(own, read, orders[which], load[machine][:, which])
                for which in (slice(used), few)
            )
            at = with_left_out(kept, beyond, tail[machine], orders[few])
            jet = at(speed, slopes=True, errors=errors)
            return Jet(*(part[:, 0] if part.size else part for part in jet))

        def look(speed: np.ndarray, row: np.ndarray, errors: bool = False) -> Jet:
            return sums.jets(members[row // rows], speed, row % rows)

        return Machines(
            jets_at, lambda machine, speed: sums.values(members[machine], speed), orders[:used],
            start, stop, Resonances(*(part[members] for part in sought)), rows,
            MaskedSpeeds(none, none, none, none, none), np.zeros((0, len(members) * rows), bool),
            look,
        )  # fmt: skip

    peak = RunUpPeak(*np.zeros((4, len(left), rows)))
    step = max(_MOST_AT_ONCE // used, 1)
    together = np.flatnonzero(~left)
    for place in range(0, len(together), step):
        members = together[place : place + step]
        for whole, part in zip(peak, highest_peaks(machines(members)), strict=True):
            whole[members] = part.reshape(-1, rows)
    return peak, left
