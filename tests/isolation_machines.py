"""Machines on mounts for the isolation tests: the source's, seeded random ones, exact algebra."""

from typing import NamedTuple

import mpmath
import numpy as np

from vibecalc.isolation.on_mounts import OnMounts, pitching
from vibecalc.isolation.rows import HarmonicsAt, Readout, body_rows, joined_rows
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.linear import Linear
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.parts import mounts as parts
from vibecalc.parts.body import RigidBody
from vibecalc.parts.matrices import assemble

SPEED = 4900.0 * np.pi / 30.0
LEVER = 0.4
ORDERS = np.array([1, 2])
RADIUS_TO_ROD = 0.06 / 0.2
INERTIA = 100.0 / 12.0 * (0.35**2 + 0.8**2)
#: couple of the three throws per squared speed, order 1: 0.3 sqrt(3) m R
COUPLE = 0.3 * np.sqrt(3.0) * 0.4 * 0.06
ROUNDING = 2.0**-52


class Mounts(NamedTuple):
    """Positions (m, 3) and matrices (m, 3, 3)."""

    position: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    structural: np.ndarray


class Body(NamedTuple):
    """A body on mounts, with its matrices."""

    mass_matrix: np.ndarray
    mounts: Mounts
    matrices: Linear


def gibson_couple() -> Bounded:
    """Couples +sin and -lambda sin of orders 1 and 2 about y, per squared speed."""
    value = COUPLE * np.array([-1j, 1j * RADIUS_TO_ROD])
    return Bounded(value, 4.0 * ROUNDING * np.abs(value))


def gibson_supports(damping: float = 50.0) -> tuple[np.ndarray, ...]:
    """x, k, c, h of the four supports."""
    return np.array([-0.4, -0.4, 0.4, 0.4]), np.full(4, 1e4), np.full(4, damping), np.zeros(4)


def pitch_of(
    inertia: float, x: np.ndarray, k: np.ndarray, c: np.ndarray, h: np.ndarray
) -> OnMounts:
    """A body of 100 kg with its crankshaft along x, its mounts along z at x from its centre."""
    place, only = np.zeros((len(x), 3)), np.diag([0.0, 0.0, 1.0])
    place[:, 0] = x
    mounts = parts.Mounts(
        names=tuple(str(number + 1) for number in range(len(x))),
        position=place,
        stiffness=np.asarray(k)[:, None, None] * only,
        damping=np.asarray(c)[:, None, None] * only,
        structural=np.asarray(h)[:, None, None] * only,
    )
    body = RigidBody(
        mass=100.0,
        centre=np.zeros(3),
        mass_matrix=np.diag([100.0, 100.0, 100.0, inertia, inertia, inertia]),
        inertia=inertia * np.eye(3),
    )
    return pitching(body, mounts, "x", "z")


def gibson(damping: float = 50.0) -> tuple[OnMounts, Readout]:
    """Pitch model of the source's machine, and its five rows: lever force and four supports."""
    system = pitch_of(INERTIA, *gibson_supports(damping))
    return system, joined_rows(system.couple_over(LEVER), system.forces())


def rows_of(
    system: OnMounts, readout: Readout, orders: np.ndarray, couple: Bounded, left_out: bool = False
) -> HarmonicsAt:
    """Rows over crank speed under couples (orders,) per squared speed."""
    load = couple[:, None]
    undriven = system.undriven(system.resonances(load)) if left_out else None
    return body_rows(system.matrices, readout, orders, load, undriven)


def gibson_body(damping: float = 50.0) -> Body:
    """The same machine with six degrees of freedom; widths across are ours."""
    width = 0.5
    own = 100.0 / 12.0 * np.array([width**2 + 0.35**2, 0.35**2 + 0.8**2, 0.8**2 + width**2])
    position = np.array([[x, y, 0.0] for x in (-0.4, 0.4) for y in (-0.2, 0.2)])
    each = np.broadcast_to(np.eye(3), (4, 3, 3))
    mounts = Mounts(position, 1e4 * each, damping * each, 0.0 * each)
    mass_matrix = np.diag([100.0, 100.0, 100.0, *own])
    return Body(mass_matrix, mounts, assemble(mass_matrix, *mounts))


def _spread(generator: np.random.Generator, low: float, high: float, shape: object) -> np.ndarray:
    return np.asarray(np.exp(generator.uniform(np.log(low), np.log(high), shape)))


def random_body(seed: int) -> Body:
    """A body of 1 to 1e4 kg, its centre off the reference point, on 3 to 7 skewed mounts."""
    generator = np.random.default_rng(seed)
    mass = float(_spread(generator, 1.0, 1e4, ()))
    size = float(_spread(generator, 0.1, 3.0, ()))
    centre = 0.2 * size * generator.normal(size=3)
    points = size * generator.normal(size=(8, 3))
    inertia = sum(np.dot(p, p) * np.eye(3) - np.outer(p, p) for p in points) * mass / 8.0
    x, y, z = centre
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    mass_matrix = np.block(
        [[mass * np.eye(3), -mass * skew], [mass * skew, inertia - mass * skew @ skew]]
    )
    mass_matrix = 0.5 * (mass_matrix + mass_matrix.T)
    count = int(generator.integers(3, 8))
    position = size * generator.normal(size=(count, 3))
    turn = np.linalg.qr(generator.normal(size=(count, 3, 3)))[0]

    def blocks(low: float, high: float) -> np.ndarray:
        principal = _spread(generator, low, high, (count, 3))
        matrix = (turn * principal[:, None, :]) @ turn.swapaxes(-1, -2)
        return 0.5 * (matrix + matrix.swapaxes(-1, -2))

    level = mass * float(_spread(generator, 10.0, 1e5, ()))
    stiffness = blocks(level / 10.0, level)
    damping = blocks(1e-3, 0.1) * np.sqrt(level * mass)
    structural = blocks(1e-3, 0.1) * level
    mounts = Mounts(position, stiffness, damping, structural)
    return Body(mass_matrix, mounts, assemble(mass_matrix, *mounts))


def exact(values: np.ndarray) -> np.ndarray:
    """Doubles, real or complex, as an array of mpmath numbers."""
    number = mpmath.mpc if np.iscomplexobj(values) else mpmath.mpf
    flat = [number(value) for value in np.ravel(values).tolist()]
    return np.array([*flat, None], dtype=object)[:-1].reshape(np.shape(values))


def shows(readout: Readout, shape: np.ndarray, frequency: np.ndarray) -> np.ndarray:
    """Which modes, `shape` (coordinates, modes), can be seen in which rows: (modes, rows).

    A mode with a node at a mount does not show in it: its reading cancels to rounding.
    """
    rate = np.asarray(frequency)[:, None, None]
    passing = readout.still + rate[..., None] * readout.rising
    reading = np.abs((passing @ shape.T[:, None, :, None])[..., 0])
    terms = (np.abs(passing) @ np.abs(shape.T)[:, None, :, None])[..., 0]
    return np.any(reading > 1e3 * UNIT_ROUNDOFF * terms, axis=-1)
