"""What a run with play in its joints is given: pin motion, gas force, joints.

Displacements count along the cylinder axis from top dead centre towards the crank ("down"). Y is
the prescribed place of the crank-side pin, X the piston, W the rod's reciprocating point mass:

    one gap     z1 = Y - X
    two gaps    z1 = W - X at the wrist pin, z2 = Y - W at the crank pin

and the bore is a gap of its own, z = y + clearance/2, where y is the lateral place of the piston,
positive on the side on which the crank pin is at a crank angle of 90 degrees. A gap z is free for
0 < z < clearance. Its force F is positive when it pulls its two ends together, that is when z is
beyond the clearance: F pulls the piston down, and F of the bore presses the piston against the
wall on the positive side.

    m X'' = F1 + gas,   m_rod W'' = F2 - F1,   m y'' = F1 tan(rod angle) - F_bore

The lateral motion is too small to act back on the axial one (one-way coupling).
Source: J. W. Ong's model (2000, eq. 5.1), with the extensions of his section 9.2.1.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import UsageError
from vibecalc.numerics.typing import ComplexArray, FloatArray, IntArray

#: laws of a contact spring; the source prints the second
LAWS = ("continuous", "full_deflection")


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


class Gaps(NamedTuple):
    """Joints of one batch as arrays (G, B); `upper_rest` is where the upper spring has no force."""

    clearance: FloatArray
    stiffness: FloatArray
    contact_damping: FloatArray
    film_damping: FloatArray
    upper_rest: FloatArray


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


def assemble_train(
    members: int,
    mass: FloatArray,
    joint: Joint,
    crank_joint: Joint | None,
    rod_mass: FloatArray | None,
    wall: Joint | None,
) -> Train:
    """Arrays of the batch from its joints; UsageError for an unknown law or a missing mass."""
    joints = [each for each in (joint, crank_joint, wall) if each is not None]
    if (crank_joint is None) != (rod_mass is None):
        raise UsageError("a crank joint with play and a rod mass belong together")
    for each in joints:
        if each.law not in LAWS:
            raise UsageError(f"no contact law {each.law!r}; there are {', '.join(LAWS)}")
    piston = np.broadcast_to(np.asarray(mass, dtype=np.float64), (members,))
    rod = None
    couple = np.zeros((len(joints), len(joints), members))
    couple[0, 0] = 1.0 / piston
    if rod_mass is not None:
        rod = np.broadcast_to(np.asarray(rod_mass, dtype=np.float64), (members,))
        couple[0, 0] = 1.0 / piston + 1.0 / rod
        couple[0, 1] = couple[1, 0] = -1.0 / rod
        couple[1, 1] = 1.0 / rod
    if wall is not None:
        couple[-1, -1] = 1.0 / piston

    def column(name: str) -> FloatArray:
        values = [np.asarray(getattr(each, name), dtype=np.float64) for each in joints]
        return np.array([np.broadcast_to(value, (members,)) for value in values])

    clearance = column("clearance")
    continuous = np.array([[each.law == "continuous"] for each in joints])
    gaps = Gaps(
        clearance,
        column("stiffness"),
        column("contact_damping"),
        column("film_damping"),
        np.where(continuous, clearance, 0.0),
    )
    return Train(
        gaps,
        couple,
        piston,
        rod,
        pin=0 if crank_joint is None else 1,
        bore=None if wall is None else len(joints) - 1,
    )


def starts(values: ArrayLike) -> FloatArray:
    """Starting values (B,), of one gap, or (B, G) as a new array (G, B)."""
    array = np.asarray(values, dtype=np.float64)
    return np.array(array[None, :] if array.ndim == 1 else array.T, order="C")
