"""Kernel: a rigid body at rest on mounts whose load is no straight line of their deflection.

The energy of mounts whose curves rise is convex, so that there is one equilibrium; Newton's steps
are shortened until the energy falls, which finds it from anywhere, also across the corners that
stops make (J.-S. Pang and L. Qi (1995), A globally convergent Newton method for convex SC1
minimization problems, J. Optim. Theory Appl. 85).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, UNIT_ROUNDOFF, FloatArray
from vibecalc.parts.body import cross_matrix
from vibecalc.parts.mount_curves import Law


class Rest(NamedTuple):
    """A body at rest; all of small displacements.

    `body` (6,) in m and rad of the point that couples are about; `motion` (n, 3) of the body at the
    mounts, m; `force` (n, 3) of each mount on the ground, N; `deflection` (n,) in m and `load` (n,)
    in N along the axis of each, positive in compression; `slope` and `stop` (n,) are the tangent
    stiffness there of the mount and of the stop that it stands on, N/m. `tangent` (n, 3, 3) is the
    static stiffness about this rest, stops included.
    """

    body: Bounded
    motion: Bounded
    force: Bounded
    deflection: Bounded
    load: Bounded
    slope: Bounded
    stop: FloatArray
    tangent: FloatArray


_STEPS, _HALVINGS = 200, 60
#: share of the fall that the slope of the energy promises
_ENOUGH = 1e-4
#: of the largest stiffness, added where there is none yet
_SOFT = 1e-3


def equilibrium(
    position: FloatArray,
    axis: FloatArray,
    across: FloatArray,
    laws: Sequence[Law],
    load: FloatArray,
    load_error: FloatArray,
    freedoms: NDArray[np.intp],
) -> Rest:
    """Rest under a constant load (6,) in N and N m, its error absolute.

    Parameters
    ----------
    position, axis : (n, 3) m from the point that couples are about; unit vectors that point
        against compression.
    across : (n, 3, 3) static stiffness square to the axis, N/m.
    laws : of each mount along its axis.
    freedoms : indices into x y z rx ry rz of the motions that are not held.

    Raises NumericalFailure if the mounts do not restrain the body to rounding, or no rest is found.
    """
    free = np.asarray(freedoms)
    turn = np.concatenate(
        [np.broadcast_to(np.eye(3), across.shape), -cross_matrix(position)], axis=-1
    )
    outer = axis[:, :, None] * axis[:, None, :]

    def each(name: str, deflection: FloatArray) -> FloatArray:
        pairs = zip(laws, deflection.tolist(), strict=True)
        return np.array([getattr(law, name)(u) for law, u in pairs])

    def energy(body: FloatArray) -> tuple[float, float]:
        motion = turn @ body
        stored = 0.5 * np.einsum("ni,nij,nj->n", motion, across, motion)
        work = each("work", -np.einsum("ni,ni->n", axis, motion))
        terms = np.concatenate([stored, work, -load * body])
        return float(terms.sum()), float(np.abs(terms).sum())

    def state(body: FloatArray) -> tuple[FloatArray, ...]:
        motion = turn @ body
        deflection = -np.einsum("ni,ni->n", axis, motion)
        pressed, slope, stop = (each(name, deflection) for name in ("load", "slope", "touched"))
        force = np.einsum("nij,nj->ni", across, motion) - pressed[:, None] * axis
        tangent = across + (slope + stop)[:, None, None] * outer
        return motion, deflection, pressed, slope, stop, force, tangent

    def lost(body: FloatArray, found: tuple[FloatArray, ...]) -> FloatArray:
        """What rounding may leave of the sum of all loads (6,)."""
        _, _, pressed, slope, stop, _, _ = found
        off = UNIT_ROUNDOFF * (
            8.0 * np.abs(pressed) + 16.0 * (slope + stop) * _size(turn, axis, body)
        )
        terms = np.einsum("nij,nj->ni", np.abs(across), np.abs(turn) @ np.abs(body))
        each = 16.0 * UNIT_ROUNDOFF * terms + off[:, None] * np.abs(axis)
        each = each + 8.0 * UNIT_ROUNDOFF * np.abs(found[5])
        return np.asarray(np.einsum("nik,ni->k", np.abs(turn), each))

    body = np.zeros(6)
    (height, terms), best = energy(body), np.inf
    for _ in range(_STEPS):
        found = state(body)
        left = (np.einsum("nik,ni->k", turn, found[5]) - load)[free]
        stiffness = np.einsum("nik,nij,njl->kl", turn, found[6], turn)[np.ix_(free, free)]
        inverse = _inverse(stiffness)
        if inverse is None:  # held by stops that it does not touch yet, or by a cube from zero on
            step = -np.linalg.solve(stiffness + _SOFT * np.diag(_softly(stiffness, free)), left)
        else:
            step = -inverse @ left
        fall = float(-left @ step)
        rounding = (lost(body, found) + UNIT_ROUNDOFF * np.abs(load))[free]
        met = inverse is not None and np.all(np.abs(left) <= rounding)
        if met or fall <= 0.0 or (fall >= 0.25 * best and fall <= 1e-24 * terms):
            break
        best, share = min(best, fall), 1.0
        for _ in range(_HALVINGS):
            moved = body.copy()
            moved[free] += share * step
            there, terms = energy(moved)
            if there <= height - _ENOUGH * share * fall + 8.0 * EPSILON * terms:
                break
            share *= 0.5
        body, height = moved, there
    else:
        raise NumericalFailure(
            f"no rest of the body on its mounts is found in {_STEPS} steps: a load of "
            f"{float(np.abs(left).max()):.3g} is left; are stops or curves of mounts very stiff?"
        )
    if inverse is None:
        raise NumericalFailure(
            "the mounts do not restrain the body in some direction, to rounding: no rest can be "
            "found; add a mount or give the mounts stiffness in the missing direction"
        )
    size = np.abs(inverse)
    error = np.zeros(6)
    error[free] = size @ (np.abs(left) + rounding + load_error[free])
    error += 4.0 * UNIT_ROUNDOFF * np.abs(body)
    _, pressed_in, pressed, slope, stop, _, tangent = found
    place = Bounded(body, error)
    motion = turn @ place
    deflection = -(motion * axis).sum()
    carried = Bounded(
        pressed, (slope + stop) * deflection.error + 8.0 * UNIT_ROUNDOFF * np.abs(pressed)
    )
    return Rest(
        place,
        motion,
        (across @ motion[..., None])[..., 0] - carried[:, None] * axis,
        deflection,
        carried,
        Bounded(slope, each("bend", pressed_in) * deflection.error + 8.0 * UNIT_ROUNDOFF * slope),
        stop,
        tangent,
    )


def _size(turn: FloatArray, axis: FloatArray, body: FloatArray) -> FloatArray:
    """Sum of the magnitudes (n,) that a deflection is made of."""
    return np.asarray(np.einsum("ni,nik,k->n", np.abs(axis), np.abs(turn), np.abs(body)))


def _softly(stiffness: FloatArray, free: NDArray[np.intp]) -> FloatArray:
    """A stiffness (f,) for each motion as large as that of the stiffest of its kind."""
    diagonal, turning = np.diagonal(stiffness), free > 2
    shift = diagonal[~turning].max(initial=1.0)
    return np.asarray(np.where(turning, diagonal[turning].max(initial=shift), shift))


def _inverse(stiffness: FloatArray) -> FloatArray | None:
    """Inverse in coordinates of equal stiffness; None where there is none."""
    diagonal = np.diagonal(stiffness)
    if np.all(diagonal > 0.0):
        scale = 1.0 / np.sqrt(diagonal)
        scaled = stiffness * scale[:, None] * scale
        if np.linalg.cond(scaled) < 1e12:
            return np.asarray(np.linalg.inv(scaled) * scale[:, None] * scale)
    return None
