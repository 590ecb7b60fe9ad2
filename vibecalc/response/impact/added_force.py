"""What play adds to the force that shakes the body.

The body feels minus the inertia force of all that moves along the cylinder: the force F of the
joint that the crank drives, that of what the crank drives without play, and the gas on the head,
which is equal and opposite to that on the piston. M is the mass beyond that joint: piston and pin,
and the rod's reciprocating share if the crank pin has play. So M X'' = F + gas, and what play adds
is F less the force M Y'' - gas that the joint would carry without play. A rod's share that the
crank drives has its inertia force whatever the play is, and adds nothing. In F itself most of the
lower orders is the load that is carried anyway.
"""

import numpy as np

from vibecalc.numerics.typing import ComplexArray
from vibecalc.response.impact.linkage import Linkage
from vibecalc.response.impact.model import Drive, GasForce
from vibecalc.response.impact.runs import Forces


def added_force(linkage: Linkage, forces: Forces) -> ComplexArray:
    """Harmonics (C, M, R, N + 1), N, 0-to-peak, of the crank-side joint's force less `carried`."""
    runs = forces.wrist_pin if forces.crank_pin is None else forces.crank_pin
    return runs.harmonics - carried_force(linkage, runs.harmonics.shape[-1] - 1)


def carried_force(linkage: Linkage, highest: int) -> ComplexArray:
    """Harmonics (highest + 1,), N, of the crank-side joint's force if no joint had play."""
    mass = linkage.mass + (linkage.rod_mass or 0.0)
    pin = mass * pin_acceleration(linkage.drive, highest)
    return np.asarray(pin - gas_harmonics(linkage.gas, highest))


def pin_acceleration(drive: Drive, highest: int) -> ComplexArray:
    """Harmonics (highest + 1,) of Y'', m/s^2, positive towards the crank."""
    found = np.zeros(highest + 1, dtype=np.complex128)
    orders = np.asarray(drive.orders)
    kept = orders <= highest
    values = -np.square(orders * drive.speed) * np.asarray(drive.displacement)
    found[orders[kept]] = values[kept]
    return found


def gas_harmonics(gas: GasForce, highest: int) -> ComplexArray:
    """Harmonics (highest + 1,), N, of a force that is straight between its angles: exact integrals.

    Integrating by parts twice leaves the slopes: pi n^2 G_n = sum slope (e^-inb - e^-ina) over
    the pieces [a, b].
    """
    found = np.zeros(highest + 1, dtype=np.complex128)
    angle, force = np.asarray(gas.angle), np.asarray(gas.force)
    if not angle.size:
        return found
    turn = 2.0 * np.pi
    if angle[-1] - angle[0] < turn * (1.0 - 1e-12):
        angle, force = np.append(angle, angle[0] + turn), np.append(force, force[0])
    found[0] = np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(angle)) / turn
    order = np.arange(1, highest + 1)
    wave = np.exp(-1j * order[:, None] * angle)
    slope = np.diff(force) / np.diff(angle)
    found[1:] = (np.diff(wave, axis=1) @ slope) / (np.pi * order**2)
    return found
