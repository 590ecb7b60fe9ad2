"""Kernel: a machine on mounts and what these stand on, as one system in the coordinates of both.

The six coordinates of the machine about its reference point come first. Those of a foundation are
about its own, which is at `position` from the first; a mount at p is deflected by

    u = G(p) X - G(p - position) Y,   a spring of the foundation at s by   G(s) Y,

so that K = sum B^T k B with B (3, coordinates) of each. Moving with the ground all have X = U and
Y = (G(position) U, rotation of U).
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.isolation.at_mounts import Resting
from vibecalc.isolation.on_mounts import OnMounts, assembled, in_direction, resting_on
from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.numerics.leading import side_by_side
from vibecalc.numerics.linear import Linear, added_up
from vibecalc.numerics.rounding import DATA_ROUNDINGS, UNIT_ROUNDOFF, ComplexArray, FloatArray
from vibecalc.parts.body import RigidBody
from vibecalc.parts.matrices import displacement_at, on_springs
from vibecalc.parts.mounts import Mounts
from vibecalc.response.modes import Modes
from vibecalc.response.spectral import spectral_system

# ----------------------------------------------------------------------------
# A second mass, up and down; a second rigid body.
# ----------------------------------------------------------------------------


def on_second_mass(
    body: RigidBody, mounts: Mounts, up: int, below: ArrayLike, spring: tuple[ArrayLike, ...]
) -> tuple[OnMounts, OnMounts]:
    """Machine and foundation as two masses that move along the axis `up`; the machine alone.

    The mass `below` in kg and the `spring` under it (stiffness, damping and structural in N/m,
    N s/m and N/m) may have leading axes as the mounts. Source: J. P. Den Hartog, Mechanical
    Vibrations, 4th ed., section 3.2.
    """
    few = in_direction(mounts, up)
    mass = rounded(side_by_side([body.mass, below])[..., None] * np.eye(2), DATA_ROUNDINGS)
    each = (np.asarray(part)[..., None, None, None] for part in spring)
    ground = added_up(mass, np.array([[[0.0, 1.0]]]), *each)
    stretch = np.tile([1.0, -1.0], (len(mounts.names), 1, 1))
    matrices = ground.with_springs(on_springs(mass, stretch, few))
    reach = np.eye(6)[:, [up, up]] * [1.0, 0.0]

    def moving(count: int) -> OnMounts:
        kept = np.arange(count)
        given = matrices.reduced(kept), reach[:, kept], stretch[..., kept]
        resting = Resting(*given, few.stiffness)
        return assembled(few, up + 6 * kept, *given, resting, np.ones((count, 1)))

    return moving(2), moving(1)


def on_guided_mass(
    body: RigidBody,
    mounts: Mounts,
    freedoms: np.ndarray,
    up: int,
    below: float,
    spring: tuple[float, ...],
) -> OnMounts:
    """A machine in its `freedoms` on its mounts, on a mass that moves along the axis `up` only.

    The mass in kg and its spring as in `on_second_mass`. Its guides bear what the mounts do to it
    in other directions. What is constant deflects the mounts as it does those on rigid ground.
    """
    floor = 6 + up
    mass = _masses(12, body)
    mass.value[floor, floor] = below
    mass.error[floor, floor] = DATA_ROUNDINGS * UNIT_ROUNDOFF * below
    kept, carried = np.append(freedoms, floor), _carried(np.zeros(3))
    ground = added_up(mass, np.eye(12)[floor][None, None], *(np.full((1, 1, 1), s) for s in spring))
    stretch = _stretch(mounts, np.zeros(3))
    return assembled(
        mounts,
        kept,
        ground.with_springs(on_springs(mass, stretch, mounts)).reduced(kept),
        np.eye(6, 12)[:, kept],
        stretch[..., kept],
        resting_on(body, mounts, freedoms),
        carried[np.ix_(kept, freedoms)],
        below=ground.reduced(kept),
    )


def on_second_body(
    body: RigidBody, mounts: Mounts, second: RigidBody, position: FloatArray, springs: Mounts
) -> OnMounts:
    """A machine on its mounts on a second body on springs, as one system of twelve coordinates.

    The reference point of that body is at the `position` (3,). What is constant deflects the mounts
    as it does those on rigid ground.
    """
    below = displacement_at(springs.position)
    lower = np.concatenate([np.zeros_like(below), below], axis=-1)
    mass = _masses(12, body, second)
    ground, stretch = on_springs(mass, lower, springs), _stretch(mounts, position)
    return assembled(
        mounts,
        np.arange(12),
        ground.with_springs(on_springs(mass, stretch, mounts)),
        np.eye(6, 12),
        stretch,
        resting_on(body, mounts, np.arange(6)),
        _carried(position),
        below=ground,
    )


def _masses(size: int, *bodies: RigidBody) -> Bounded:
    """Mass matrix (size, size) of bodies in six coordinates each; others have none."""
    mass = Bounded(*np.zeros((2, size, size)))
    for number, one in enumerate(bodies):
        own = (slice(6 * number, 6 * number + 6),) * 2
        mass.value[own], mass.error[own] = one.bounded_mass()
    return mass


def _stretch(mounts: Mounts, position: FloatArray) -> FloatArray:
    """Rows (mounts, 3, 12) of the deflections of mounts between machine and foundation."""
    upper = displacement_at(mounts.position)
    return np.concatenate([upper, -displacement_at(mounts.position - position)], axis=-1)


def _carried(position: FloatArray) -> FloatArray:
    """Motion (12, 6) of both bodies with the ground, as if all were one."""
    below = np.eye(6)
    below[:3] = displacement_at(position)
    return np.concatenate([np.eye(6), below])


# ----------------------------------------------------------------------------
# A foundation of which tables over frequency say the dynamic stiffness.
# ----------------------------------------------------------------------------


class Curve(NamedTuple):
    """Complex dynamic stiffness (rows,), or impedance, at ascending frequencies in rad/s."""

    frequency: FloatArray
    value: ComplexArray
    by_velocity: bool

    def at(self, frequency: FloatArray) -> ComplexArray:
        """Dynamic stiffness, straight between rows, real and imaginary part each; ends hold."""
        found = np.interp(frequency, self.frequency, self.value)
        return np.asarray(1j * frequency * found if self.by_velocity else found)


class FlexibleFoundation(NamedTuple):
    """Curves below the feet by (mount, direction), and of the plate by direction.

    `position` (3,) of the plate's reference point from that of the machine, m.
    """

    feet: dict[tuple[int, int], Curve]
    plate: dict[int, Curve]
    position: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class OnTables(OnMounts):
    """A machine whose mounts stand on feet, and these on a plate: neither has a mass of its own.

    Behind the coordinates of the machine stand those of the `plate`, as indices into x y z rx ry
    rz, then how far each foot with a curve gives below its mount. Feet do not feel each other but
    through the plate. The `curves`, one for each of these coordinates, stand on the diagonal. There
    are no modes.
    """

    plate: tuple[int, ...] = ()
    curves: tuple[Curve, ...] = ()

    def at(self, frequency: FloatArray) -> Linear:
        """With the dynamic stiffness of plate and feet."""
        given = super().at(frequency)
        curves = np.stack([one.at(frequency) for one in self.curves], axis=-1)
        if np.any(zero := curves[..., len(self.plate) :] == 0.0):
            met = np.broadcast_to(frequency[..., None], zero.shape)[zero][0]
            raise NumericalFailure(
                f"the dynamic stiffness below a mount is zero at {met / (2.0 * np.pi):.6g} Hz: "
                "nothing carries it there; give the table an imaginary part"
            )
        free = np.zeros((*np.shape(frequency), 6))
        own = np.concatenate([free, curves], axis=-1)[..., None] * np.eye(6 + len(self.curves))
        return given._replace(
            stiffness=given.stiffness + own.real,
            structural=given.structural + own.imag,
            stiffness_error=given.stiffness_error + 4.0 * UNIT_ROUNDOFF * np.abs(own),
        )


def on_tables(body: RigidBody, mounts: Mounts, foundation: FlexibleFoundation) -> OnTables:
    """A machine on its mounts on a flexible foundation."""
    plate = sorted(foundation.plate)
    curves = (*(foundation.plate[one] for one in plate), *foundation.feet.values())
    kept, size = [*range(6), *(6 + one for one in plate)], 6 + len(curves)
    stretch, carried = np.zeros((len(mounts.names), 3, size)), np.zeros((size, 6))
    stretch[..., : len(kept)] = _stretch(mounts, foundation.position)[..., kept]
    carried[: len(kept)] = _carried(foundation.position)[kept]
    for place, (mount, direction) in enumerate(foundation.feet, start=len(kept)):
        stretch[mount, direction, place] = -1.0
    matrices = on_springs(_masses(size, body), stretch, mounts)
    follows = mounts.spectrum is not None
    spectral = spectral_system(matrices.free(), mounts, stretch) if follows else None
    none, shapes = np.zeros(0), np.zeros((size, 0))
    return OnTables(
        matrices=matrices,
        shapes=Modes(none, none, shapes, shapes, none, none),
        spectral=spectral,
        mounts=mounts,
        freedoms=np.arange(size),
        reach=np.eye(6, size),
        stretch=stretch,
        resting=resting_on(body, mounts, np.arange(6)),
        carried=carried,
        plate=tuple(plate),
        curves=curves,
    )
