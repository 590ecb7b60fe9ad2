"""The shipped cases of the published engine, computed without the package.

Response by openTorsion's `ss_response`, torques of the cylinders by quadrature of the card.
"""

from typing import NamedTuple

import engine_source as source
import numpy as np
from engine_as_published import gas_torque, inertia_torque, mean_and_harmonics

#: what the cases write: dashpots of the throws, of the last shaft, of cylinders and flywheel, ring
THROW, LAST, CYLINDER, FLYWHEEL, RING = 1082.9, 911.55, 34.21, 4873.0, 2131.976
ORDER = 0.5 * np.arange(1, 31)


class Matrices(NamedTuple):
    """Of the seven stations, then the ring; sections are the shafts, then the ring's spring."""

    inertia: np.ndarray
    link: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    absolute: np.ndarray

    @property
    def k(self) -> np.ndarray:
        return self.link.T @ (self.stiffness[:, None] * self.link)

    @property
    def c(self) -> np.ndarray:
        return self.link.T @ (self.damping[:, None] * self.link) + np.diag(self.absolute)


def engine(ring: bool) -> Matrices:
    inertia, stiffness = list(source.INERTIA), list(source.STIFFNESS)
    damping, absolute = [THROW] * 5 + [LAST], [CYLINDER] * 6 + [FLYWHEEL]
    link = -np.diff(np.eye(7 + ring), axis=0)[:6]
    if ring:
        inertia, absolute = [*inertia, source.DAMPER_INERTIA], [*absolute, 0.0]
        stiffness, damping = [*stiffness, source.DAMPER_STIFFNESS], [*damping, RING]
        link = np.vstack([link, np.eye(8)[0] - np.eye(8)[7]])
    return Matrices(*map(np.array, (inertia, link, stiffness, damping, absolute)))


def torques(speed: float, orders: int, silent: int = -1) -> tuple[np.ndarray, np.ndarray]:
    """Amplitudes (orders, 6) and means (6,) of the cylinders; `silent` has no gas."""
    _, inertia = mean_and_harmonics(lambda a: inertia_torque(a, speed))
    mean, gas = mean_and_harmonics(gas_torque)
    works = np.arange(6) != silent
    turn = np.exp(-1j * ORDER[:orders, None] * np.array(source.FIRING_ANGLE))
    value = (gas[:orders, None] * works + inertia[:orders, None]) * turn
    return value, mean * works


def twists(matrices: Matrices, speed: float, torque: np.ndarray) -> np.ndarray:
    """Twists (sections, orders) by openTorsion."""
    import opentorsion as ot

    orders = len(torque)
    shafts = [
        ot.Shaft(int(np.argmax(row)), int(np.argmin(row)), k=k, c=c)
        for row, k, c in zip(matrices.link, matrices.stiffness, matrices.damping, strict=True)
    ]
    discs = [
        ot.Disk(i, j, c=c)
        for i, (j, c) in enumerate(zip(matrices.inertia, matrices.absolute, strict=True))
    ]
    load = np.zeros((len(matrices.inertia), orders), dtype=complex)
    load[:6] = torque.T
    angle, _ = ot.Assembly(shafts, disk_elements=discs).ss_response(load, speed * ORDER[:orders])
    return matrices.link @ angle


def section_torques(matrices: Matrices, speed: float, twist: np.ndarray) -> np.ndarray:
    """Stiffness and damping part (sections, orders)."""
    w = speed * ORDER[: twist.shape[1]]
    return (matrices.stiffness[:, None] + 1j * w * matrices.damping[:, None]) * twist
