"""The running gear of one cylinder with play: drive, gas force, joints, force law of a contact."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.kinematics.harmonics import motion_harmonics
from vibecalc.kinematics.rod_angle import rod_angle_harmonics
from vibecalc.numerics.rounding import ComplexArray, FloatArray, IntArray

# ----------------------------------------------------------------------------
# What a run with play in its joints is given: pin motion, gas force, joints.
#
# Displacements count along the cylinder axis from top dead centre towards the crank ("down"). Y is
# the prescribed place of the crank-side pin, X the piston, W the rod's reciprocating point mass:
#
#     one gap     z1 = Y - X
#     two gaps    z1 = W - X at the wrist pin, z2 = Y - W at the crank pin
#
# and the bore is a gap of its own, z = y + clearance/2, where y is the lateral place of the piston,
# positive on the side on which the crank pin is at a crank angle of 90 degrees. A gap z is free for
# 0 < z < clearance. Its force F is positive when it pulls its two ends together, that is when z is
# beyond the clearance: F pulls the piston down, and F of the bore presses the piston against the
# wall on the positive side.
#
#     m X'' = F1 + gas,   m_rod W'' = F2 - F1,   m y'' = F1 tan(rod angle) - F_bore
#
# The lateral motion is too small to act back on the axial one (one-way coupling).
# Source: J. W. Ong's model (2000, eq. 5.1), with the extensions of his section 9.2.1.
# ----------------------------------------------------------------------------


class Drive(NamedTuple):
    """Motion of the crank-side pin, Y(theta) = Re sum Y_n exp(i n theta), theta = speed * time.

    `speed` rad/s, not zero; `orders` (n,) and `displacement` (n,) in m, complex 0-to-peak, from
    top dead centre downwards. `tangent_orders` (k,) and `rod_tangent` (k,) are the same for the
    tangent of the rod angle, positive with the crank pin at 90 degrees; only a bore needs them.
    """

    speed: float
    orders: IntArray
    displacement: ComplexArray
    tangent_orders: IntArray | None = None
    rod_tangent: ComplexArray | None = None


class GasForce(NamedTuple):
    """Force on the piston, N, positive downwards, straight between its angles, periodic.

    `angle` (m,) in rad ascends within one turn; a last entry one turn after the first may be
    there, with the same force. Both arrays may be empty: no gas.
    """

    angle: FloatArray
    force: FloatArray


class Joint(NamedTuple):
    """A gap between two contacts; every array (B,) or a number.

    `clearance` m, `stiffness` N/m of a contact, `contact_damping` N*s/m while in contact,
    `film_damping` N*s/m in the gap (a linearised squeeze film). `law`: "continuous", K (z -
    clearance) beyond the clearance; "full_deflection", K z there, which jumps by K clearance at
    the face. Below zero it is K z in both. Contact ends where z crosses the face, so the damper
    of a contact may pull a little before it does.
    """

    clearance: FloatArray
    stiffness: FloatArray
    contact_damping: FloatArray
    film_damping: FloatArray
    law: str = "continuous"


class Linkage(NamedTuple):
    """One cylinder with play: masses in kg, numbers or (B,).

    `mass` is what lies beyond the wrist pin's play. `crank_pin` and `rod_mass` (the rod's
    reciprocating point mass, between the two gaps) are there together or not at all. The
    clearance of `bore` is the whole lateral play of the piston.
    """

    drive: Drive
    gas: GasForce
    mass: FloatArray | float
    wrist_pin: Joint
    crank_pin: Joint | None = None
    rod_mass: FloatArray | float | None = None
    bore: Joint | None = None

    @property
    def joints(self) -> dict[str, Joint]:
        """The joints with play under their names, in the order of all arrays of gaps."""
        every = {"wrist_pin": self.wrist_pin, "crank_pin": self.crank_pin, "bore": self.bore}
        return {name: joint for name, joint in every.items() if joint is not None}

    def with_clearance(self, clearance: FloatArray) -> "Linkage":
        """The same with clearances (B,) of the wrist pin."""
        return self._replace(wrist_pin=self.wrist_pin._replace(clearance=clearance))


class GapForces(NamedTuple):
    """The forces of G gaps over single revolutions; arrays (G, ..., R), `harmonics` one axis more.

    harmonics : complex (G, ..., R, N + 1), N
        One-sided 0-to-peak amplitudes over each revolution, F = Re sum F_n exp(i n theta);
        order 0 is the mean.
    mean, peak : N, mean and maximum over time of |F|, film included.
    contacts : contacts made. contact_time : s.
    """

    harmonics: ComplexArray
    mean: FloatArray
    peak: FloatArray
    contacts: FloatArray
    contact_time: FloatArray


class Gaps(NamedTuple):
    """Joints of one batch (G, B); the upper spring has no force at `upper_free_position`."""

    clearance: FloatArray
    stiffness: FloatArray
    contact_damping: FloatArray
    film_damping: FloatArray
    upper_free_position: FloatArray


class Train(NamedTuple):
    """A batch of B runs with G gaps in the order wrist pin, crank pin, bore (those that exist).

    `couple` (G, G, B), 1/kg: z_g'' = push_g - sum_j couple_gj F_j. `pin` is the gap that the
    crank drives, `bore` the index of the bore or None. `mass` and `rod_mass` (B,), kg.
    """

    gaps: Gaps
    couple: FloatArray
    mass: FloatArray
    rod_mass: FloatArray | None
    pin: int
    bore: int | None


def assemble_train(linkage: Linkage, members: int) -> Train:
    """Arrays of a batch of so many runs."""
    joints = list(linkage.joints.values())

    def batch(value: ArrayLike) -> FloatArray:
        return np.broadcast_to(np.asarray(value, dtype=np.float64), (members,))

    piston, rod = batch(linkage.mass), None
    couple = np.zeros((len(joints), len(joints), members))
    couple[0, 0] = 1.0 / piston
    if linkage.rod_mass is not None:
        rod = batch(linkage.rod_mass)
        couple[0, 0] = 1.0 / piston + 1.0 / rod
        couple[0, 1] = couple[1, 0] = -1.0 / rod
        couple[1, 1] = 1.0 / rod
    if linkage.bore is not None:
        couple[-1, -1] = 1.0 / piston
    *sizes, laws = zip(*joints, strict=True)
    columns = [np.array([batch(one) for one in size]) for size in sizes]
    continuous = np.array([[law == "continuous"] for law in laws])
    return Train(
        Gaps._make([*columns, np.where(continuous, columns[0], 0.0)]),
        couple,
        piston,
        rod,
        pin=0 if linkage.crank_pin is None else 1,
        bore=None if linkage.bore is None else len(joints) - 1,
    )


# ----------------------------------------------------------------------------
# Which contact a gap is in, and the straight-line force law that holds there.
# ----------------------------------------------------------------------------

#: sides of a gap: in the lower contact (z < 0), free, in the upper contact (z > clearance)
LOWER, FREE, UPPER = -1, 0, 1


class Law(NamedTuple):
    """F = spring (z - free_position) + damper z' for lower < z < upper; arrays (G, B)."""

    spring: FloatArray
    free_position: FloatArray
    damper: FloatArray
    lower: FloatArray
    upper: FloatArray


def side_of(gaps: Gaps, gap: FloatArray) -> IntArray:
    """Side of each gap (G, B) from its place alone; a gap on a face counts as free."""
    return (gap > gaps.clearance).astype(np.int64) - (gap < 0.0).astype(np.int64)


def law_of(gaps: Gaps, side: IntArray) -> Law:
    """Force law and its limits (G, B) on the given sides."""
    free, above = side == FREE, side == UPPER
    return Law(
        spring=np.where(free, 0.0, gaps.stiffness),
        free_position=np.where(above, gaps.upper_free_position, 0.0),
        damper=np.where(free, gaps.film_damping, gaps.contact_damping),
        lower=np.where(above, gaps.clearance, np.where(free, 0.0, -np.inf)),
        upper=np.where(above, np.inf, np.where(free, gaps.clearance, 0.0)),
    )


def contact_force(train: Train, gap: FloatArray, velocity: FloatArray) -> FloatArray:
    """Force of each gap (G, B), N, for its place and velocity."""
    law = law_of(train.gaps, side_of(train.gaps, gap))
    return law.spring * (gap - law.free_position) + law.damper * velocity


def spring_energy(gaps: Gaps, gap: FloatArray) -> FloatArray:
    """Energy in the contact springs, J, arrays (G, B); continuous at the faces by definition."""
    over = np.maximum(gap - gaps.clearance, 0.0)
    # (z - r)^2 - (c - r)^2 as a product, which keeps its digits near the face
    beyond = over * (over + 2.0 * (gaps.clearance - gaps.upper_free_position))
    energy = 0.5 * gaps.stiffness * (beyond + np.square(np.minimum(gap, 0.0)))
    return np.asarray(energy)


# ----------------------------------------------------------------------------
# Motion of the crank-side pin and of the rod angle as harmonics, for a slider-crank.
# ----------------------------------------------------------------------------

#: harmonics below this fraction of the largest acceleration cannot be seen in double precision
_NEGLIGIBLE = 2.0**-58
_HIGHEST_ORDER = 800


def slider_crank_drive(
    crank_radius: float,
    rod_length: float,
    speed: float,
    wrist_pin_offset: float = 0.0,
    *,
    with_rod_tangent: bool = False,
) -> Drive:
    """Harmonics of Y, m, counted from the outermost place of the centred crank downwards.

    Lengths in m, `speed` in rad/s. Every harmonic that double precision can show is kept.
    `with_rod_tangent` adds those of tan(rod angle), see `Drive`.

    Raises NumericalFailure where the harmonics of a rod hardly longer than the crank do not end.
    """
    ratio, offset = crank_radius / rod_length, wrist_pin_offset / crank_radius
    acceleration = np.abs(motion_harmonics(ratio, _HIGHEST_ORDER, offset, derivative=2))
    keep = np.flatnonzero(acceleration > _NEGLIGIBLE * np.max(acceleration))
    if keep[-1] >= _HIGHEST_ORDER - 1:
        raise NumericalFailure(
            f"the harmonics of the piston motion do not end before order {_HIGHEST_ORDER}: the rod "
            f"({rod_length:.9g} m) is hardly longer than the crank ({crank_radius:.9g} m)"
        )
    displacement = -crank_radius * motion_harmonics(ratio, _HIGHEST_ORDER, offset)
    displacement[0] += crank_radius + rod_length
    orders = np.concatenate([[0], keep]).astype(np.int64)
    drive = Drive(float(speed), orders, displacement[orders])
    if not with_rod_tangent:
        return drive
    # its harmonics fall as fast as those of the acceleration, but for a power of the order
    highest = int(orders[-1]) + 4
    angle = rod_angle_harmonics(crank_radius, rod_length, wrist_pin_offset, highest_order=highest)
    tangent = angle.tangent.value
    size = np.abs(tangent)
    keep = np.flatnonzero(size > _NEGLIGIBLE * np.max(size)).astype(np.int64)
    return drive._replace(tangent_orders=keep, rod_tangent=tangent[keep])


# ----------------------------------------------------------------------------
# The states that runs start from.
#
# The start of an ensemble is spread evenly over the clearance and over the velocities that a piston
# can have in it, by an additive recurrence that is written out here: it is the same on every
# machine and in every version of every library.
# ----------------------------------------------------------------------------


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
    joints = linkage.with_clearance(clearance).joints.values()
    return np.stack([np.broadcast_to(one.clearance, np.shape(clearance)) for one in joints], -1)


def velocity_scale(linkage: Linkage, clearance: FloatArray) -> FloatArray:
    """Velocity (..., G) with which a gap is crossed from rest, m/s: sqrt(2 a clearance).

    a is the sum of the sizes of all harmonics of the pin's acceleration and of the largest gas
    force over the mass; in the bore, as much of it as the rod's angle can turn sidewards.
    """
    drive = linkage.drive
    pin = np.sum(np.square(drive.orders * drive.speed) * np.abs(drive.displacement))
    gas = float(np.max(np.abs(linkage.gas.force), initial=0.0))
    acceleration = np.full(len(linkage.joints), pin + gas / linkage.mass)
    if linkage.bore is not None and drive.rod_tangent is not None:
        acceleration[-1] *= np.sum(np.abs(drive.rod_tangent))
    return np.asarray(np.sqrt(2.0 * acceleration * clearances(linkage, clearance)))


def spread_starts(linkage: Linkage, clearance: FloatArray, members: int) -> Starts:
    """States (C, members, G) at crank angle 0 for clearances (C,) of the wrist pin.

    Each gap lies anywhere between its faces and opens or closes with up to `velocity_scale`; the
    first member is `central_start`.
    """
    gaps = len(linkage.joints)
    point = low_discrepancy(members, 2 * gaps)
    width = clearances(linkage, clearance)[:, None]
    fastest = velocity_scale(linkage, clearance)[:, None]
    return Starts(width * point[:, :gaps], fastest * (2.0 * point[:, gaps:] - 1.0))


def central_start(linkage: Linkage, clearance: FloatArray) -> Starts:
    """States (C, G) with every gap in its middle and at rest: the pin is in the piston's middle."""
    middle = 0.5 * clearances(linkage, clearance)
    return Starts(middle, np.zeros_like(middle))
