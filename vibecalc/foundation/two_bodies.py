"""Kernel: a machine on mounts on a second rigid body, whose springs stand on the ground.

Coordinates (12,): the six of the machine about its reference point, then the six of the foundation
about its own, which is at `position` from the first. A mount at p is deflected by

    u = G(p) X - G(p - position) Y,   a spring of the foundation at s by   G(s) Y,

so that K = sum B^T k B with B (3, 12) of each. Moving with the ground both bodies have X = U and
Y = (G(position) U, rotation of U).
"""

from typing import NamedTuple

import numpy as np

from vibecalc.isolation.on_mounts import OnMounts, assembled, resting_on
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import FloatArray
from vibecalc.parts.body import RigidBody
from vibecalc.parts.matrices import displacement_at, on_springs
from vibecalc.parts.mounts import Mounts


class Second(NamedTuple):
    """The foundation: the body, the place (3,) of its reference point, its springs."""

    body: RigidBody
    position: FloatArray
    springs: Mounts


def mount_stretch(mounts: Mounts, position: FloatArray) -> FloatArray:
    """Rows (mounts, 3, 12) of the deflections of mounts between machine and foundation."""
    upper = displacement_at(mounts.position)
    return np.concatenate([upper, -displacement_at(mounts.position - position)], axis=-1)


def carried_along(position: FloatArray) -> FloatArray:
    """Motion (12, 6) of both bodies with the ground, as if all were one."""
    below = np.eye(6)
    below[:3] = displacement_at(position)
    return np.concatenate([np.eye(6), below])


def on_second_body(body: RigidBody, mounts: Mounts, second: Second) -> OnMounts:
    """A machine on its mounts on a second body, as one system of twelve coordinates.

    What is constant deflects the mounts as it does those on rigid ground.
    """
    upper = mount_stretch(mounts, second.position)
    below = displacement_at(second.springs.position)
    lower = np.concatenate([np.zeros_like(below), below], axis=-1)
    mass = Bounded(np.zeros((12, 12)), np.zeros((12, 12)))
    for place, one in ((slice(6), body), (slice(6, 12), second.body)):
        mass.value[place, place], mass.error[place, place] = one.bounded_mass()
    on_ground = on_springs(mass, lower, second.springs)
    matrices = on_ground.with_springs(on_springs(mass, upper, mounts))
    resting = resting_on(body, mounts, np.arange(6))
    reach, carried = np.eye(6, 12), carried_along(second.position)
    return assembled(
        mounts, np.arange(12), matrices, reach, upper, resting, carried, below=on_ground
    )
