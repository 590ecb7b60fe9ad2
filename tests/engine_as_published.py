"""The published engine with the slips of its source, on quadrature and eigenvalues of its own.

Harmonics come from a Gauss rule on each 10 degrees of the pressure card, on which torque times
cosine is smooth; modes from the symmetric eigenvalue problem. Nothing here uses the package.
"""

from functools import lru_cache

import engine_source as source
import numpy as np

RATIO = source.CRANK_RADIUS / source.ROD_LENGTH
AREA = np.pi * source.BORE**2 / 4.0
HALF_ORDER = np.array(source.HALF_ORDERS)
ORDER = HALF_ORDER / 2.0


def lever(angle):
    """Piston speed over crank speed, in m: the bracket of eq. 4.1 times the crank radius."""
    root = np.sqrt(1.0 - (RATIO * np.sin(angle)) ** 2)
    return source.CRANK_RADIUS * np.sin(angle) * (1.0 + RATIO * np.cos(angle) / root)


def piston_acceleration(angle, slip=False):
    """Over speed squared, in m; with the sign of the bracket of eq. 4.4 as printed if `slip`."""
    s, c = np.sin(angle), np.cos(angle)
    root = np.sqrt(1.0 - (RATIO * s) ** 2)
    bracket = (RATIO**2 * s * c) ** 2 / root**3 + RATIO**2 * (c**2 - s**2) / root
    crank = source.CRANK_RADIUS * c
    return crank + source.ROD_LENGTH * (-bracket if slip else bracket)


def gas_torque(angle):
    pressure = np.interp(np.mod(angle, 4.0 * np.pi), source.CARD_ANGLE, source.CARD_PRESSURE)
    return pressure * AREA * lever(angle)


def inertia_torque(angle, speed, slip_44=False, slip_43=False):
    """Right: the reciprocating mass alone. Eq. 4.3 adds a torque of a centrifugal force."""
    force = source.RECIPROCATING_MASS * speed**2 * piston_acceleration(angle, slip_44)
    centrifugal = source.ROTATING_MASS * (speed * lever(angle)) ** 2
    return -force * lever(angle) - (centrifugal if slip_43 else 0.0)


@lru_cache(maxsize=1)
def _nodes():
    node, weight = np.polynomial.legendre.leggauss(12)
    edge = np.array(source.CARD_ANGLE)
    half = 0.5 * np.diff(edge)
    angle = (edge[:-1] + half)[:, None] + half[:, None] * node
    return angle.ravel(), (half[:, None] * weight).ravel()


def mean_and_harmonics(torque):
    """Mean and complex amplitudes a - i b of orders 1/2 to 15 of torque(angle) over 720 degrees."""
    angle, weight = _nodes()
    value = torque(angle) * weight
    wave = np.exp(-1j * ORDER[:, None] * angle)
    return value.sum() / (4.0 * np.pi), wave @ value / (2.0 * np.pi)


def station_torque(speed, slip_44=False, slip_43=False, phases=1):
    """(30, 6) complex in N m, one column a cylinder, the firing phase applied `phases` times."""
    _, one = mean_and_harmonics(
        lambda angle: gas_torque(angle) + inertia_torque(angle, speed, slip_44, slip_43)
    )
    turn = np.exp(-1j * phases * ORDER[:, None] * np.array(source.FIRING_ANGLE))
    return one[:, None] * turn


@lru_cache(maxsize=2)
def modes(freedoms):
    """Frequencies (n,) and shapes (n, n) by rows, one at the first station; inertia (n,)."""
    damped = freedoms == 8
    inertia = np.array(source.DAMPED_INERTIA if damped else source.INERTIA)
    spring = np.array(source.DAMPED_STIFFNESS if damped else source.STIFFNESS)
    link = np.diff(np.eye(freedoms), axis=0)
    root = np.sqrt(inertia)
    square, vector = np.linalg.eigh(link.T @ (spring[:, None] * link) / np.outer(root, root))
    shape = (vector / root[:, None]).T
    return np.sqrt(np.maximum(square, 0.0)), shape / shape[:, :1], inertia


def full_torque(freedoms, **case):
    """`station_torque` with columns of zero for the flywheel and the damper."""
    torque = station_torque(**case)
    before = freedoms - 7
    return np.pad(torque, ((0, 0), (before, 1)))
