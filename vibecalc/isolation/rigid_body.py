"""A rigid body on mounts: matrices, rest under gravity, motions and forces of its mounts."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.isolation.rows import Readout
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.matrices import Matrices
from vibecalc.numerics.rounding import DATA_ROUNDINGS, SINGULAR, UNIT_ROUNDOFF
from vibecalc.parts.matrices import displacement_at

# ----------------------------------------------------------------------------
# A rigid body on mounts as 6x6 matrices, in the order x y z rx ry rz about its reference point.
# ----------------------------------------------------------------------------


# ----------------------------------------------------------------------------
# A rigid body of which some of the six motions are left out, because nothing drives them.
#
# The kept ones are indices (f,) into x y z rx ry rz. What is left out is zero, not free: the caller
# has made sure that neither masses nor mounts nor forces couple it with what is kept.
# ----------------------------------------------------------------------------


def restricted(matrices: Matrices, dofs: np.ndarray) -> Matrices:
    """The rows and columns (..., f, f) of the kept motions."""
    return Matrices(*(matrix[..., dofs[:, None], dofs] for matrix in matrices))


def held(matrices: Matrices, dofs: np.ndarray) -> Matrices:
    """All six, those left out held by springs of their own that nothing loads.

    Each has the stiffness that gives it the largest frequency of the kept ones, so that nothing is
    lost to rounding. With all six kept the matrices are as they were.
    """
    out = np.flatnonzero(~np.isin(np.arange(6), dofs))
    if not len(out):
        return matrices
    mass, stiffness = np.diagonal(matrices.mass), np.diagonal(matrices.stiffness)
    spring = mass[out] * float(np.max(stiffness[dofs] / mass[dofs]))
    copies = [np.array(matrix) for matrix in matrices]
    for matrix in copies:
        matrix[out], matrix[:, out] = 0.0, 0.0
    made = Matrices(*copies)
    made.mass[out, out], made.stiffness[out, out] = mass[out], spring
    return made


# ----------------------------------------------------------------------------
# A rigid body at rest on its mounts under gravity.
# ----------------------------------------------------------------------------


class Static(NamedTuple):
    """Small displacements at rest, errors absolute; leading axes as of the matrices.

    `body` (6,) in m and rad; `sag` (mounts,) in m, positive against `up`; `force` (mounts, 3) of
    each mount on the ground, N; `share` (mounts,) its part against `up`, N: the shares add up to
    the weight.
    """

    body: np.ndarray
    body_error: np.ndarray
    sag: np.ndarray
    sag_error: np.ndarray
    force: np.ndarray
    force_error: np.ndarray
    share: np.ndarray
    share_error: np.ndarray


def weight_load(
    mass: ArrayLike,
    centre: np.ndarray,
    gravity: ArrayLike,
    up: np.ndarray,
    centre_error: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Weight as force and couple (..., 6) about the reference point, its error; `up` is unit."""
    pull = np.multiply(-np.asarray(mass), gravity)[..., None] * np.asarray(up, dtype=float)
    load = np.concatenate(np.broadcast_arrays(pull, np.cross(centre, pull)), axis=-1)
    terms = _times(np.abs(displacement_at(centre)).mT, np.abs(pull))
    error = (4 + DATA_ROUNDINGS) * UNIT_ROUNDOFF * terms
    if centre_error is not None:
        error[..., 3:] += _times(np.abs(displacement_at(centre_error)).mT, np.abs(pull))[..., 3:]
    return load, error


def _times(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Matrices (..., m, n) times vectors (..., n)."""
    product: np.ndarray = (matrix @ vector[..., None])[..., 0]
    return product


def static_deflection(
    matrices: Matrices,
    position: np.ndarray,
    stiffness: np.ndarray,
    mass: ArrayLike,
    centre: np.ndarray,
    gravity: ArrayLike,
    up: np.ndarray,
    centre_error: np.ndarray | None = None,
) -> Static:
    """Linear deflection under the body's own weight.

    Parameters
    ----------
    matrices : from `assemble`, with the same mounts.
    position, stiffness : (..., mounts, 3) m and (..., mounts, 3, 3) N/m.
    mass, centre : (...) kg and (..., 3) m, mass centre from the reference point.
    gravity, up : m/s^2 and unit vector (3,) against which it acts.
    centre_error : absolute, in m, where the centre is what is left of larger terms.

    Raises NumericalFailure if the mounts leave the body free, to rounding, or if the shares do
    not add up to the weight within their error.
    """
    load, load_error = weight_load(mass, centre, gravity, up, centre_error)
    inverse = _flexibility(matrices)
    body = _times(inverse, load)
    body = body + _times(inverse, load - _times(matrices.stiffness, body))
    spread = matrices.stiffness_error + 8.0 * UNIT_ROUNDOFF * np.abs(matrices.stiffness)
    body_error = _times(np.abs(inverse), _times(spread, np.abs(body)) + load_error)
    _require_digits(matrices, body, body_error)

    transform = displacement_at(position)
    uncertainty = body_error + 8.0 * UNIT_ROUNDOFF * np.abs(body)
    motion = _times(transform, body[..., None, :])
    motion_error = _times(np.abs(transform), uncertainty[..., None, :])
    force = _times(stiffness, motion)
    rounding = (4.0 + DATA_ROUNDINGS) * UNIT_ROUNDOFF
    force_error = _times(np.abs(stiffness), motion_error + rounding * np.abs(motion))
    share, share_error = -force @ up, force_error @ np.abs(up)
    total, weight = np.sum(share, axis=-1), np.multiply(mass, gravity)
    uncertainty = 10.0 * (np.sum(share_error, axis=-1) + load_error[..., :3] @ np.abs(up))
    if not np.all(np.abs(total - weight) <= uncertainty):
        raise NumericalFailure(
            f"the static forces of the mounts add up to {np.ravel(total)[0]:.12g} N and the weight "
            f"is {np.ravel(weight)[0]:.12g} N: the stiffness matrices of the mounts are not "
            "symmetric"
        )
    return Static(
        body, body_error, -motion @ up, motion_error @ np.abs(up), force, force_error,
        share, share_error,
    )  # fmt: skip


def _flexibility(matrices: Matrices) -> np.ndarray:
    """Inverse of the stiffness, formed in coordinates of unit mass."""
    scale = 1.0 / np.sqrt(np.linalg.diagonal(matrices.mass))
    weight = scale[..., :, None] * scale[..., None, :]
    try:
        inverse: np.ndarray = np.linalg.inv(matrices.stiffness * weight) * weight
    except np.linalg.LinAlgError:
        raise NumericalFailure(_free("exactly")) from None
    if not np.all(np.isfinite(inverse)):
        raise NumericalFailure(_free("exactly"))
    return inverse


def _require_digits(matrices: Matrices, body: np.ndarray, error: np.ndarray) -> None:
    """Refuse a deflection of which fewer than four digits are certain."""
    weight = np.sqrt(np.linalg.diagonal(matrices.mass))
    loss = np.max(weight * error, axis=-1)
    largest = np.maximum(np.max(weight * np.abs(body), axis=-1), np.finfo(float).tiny)
    if not np.all(loss < SINGULAR * largest):
        raise NumericalFailure(_free("to rounding"))


def _free(how: str) -> str:
    return (
        f"the mounts leave the body free in some direction ({how}): its stiffness matrix cannot "
        f"be inverted; add a mount or give the mounts stiffness in the missing direction"
    )


# ----------------------------------------------------------------------------
# What a moving body does at its mounts: displacements, and forces on the ground.
# ----------------------------------------------------------------------------


def displacement(body: Bounded, position: np.ndarray) -> Bounded:
    """Displacement (..., mounts, 3, orders) in m at points (..., mounts, 3).

    `body` is X (..., orders, 6).
    """
    transform = displacement_at(position)[..., None, :, :, :]
    value = (transform @ body.value[..., :, None, :, None])[..., 0]
    terms = np.abs(transform) @ np.abs(body.value)[..., :, None, :, None]
    error = np.abs(transform) @ body.error[..., :, None, :, None]
    total = (error + 4.0 * UNIT_ROUNDOFF * terms)[..., 0]
    return Bounded(np.moveaxis(value, -3, -1), np.moveaxis(total, -3, -1))


def mount_force(
    motion: Bounded,
    frequency: np.ndarray,
    stiffness: np.ndarray,
    damping: np.ndarray,
    structural: np.ndarray,
) -> Bounded:
    """Force of each mount on the ground (..., mounts, 3, orders) in N, in complex amplitude.

    `motion` as `displacement` returns it, `frequency` (..., orders) rad/s, properties
    (..., mounts, 3, 3). The force has the direction of the displacement for a stiff mount.
    """
    rate = np.asarray(frequency)[..., None, :, None, None]
    held, dragged = (part[..., :, None, :, :] for part in (stiffness + 1j * structural, damping))
    return passing_force(motion, held + 1j * (rate * dragged))


def passing_force(motion: Bounded, passing: np.ndarray) -> Bounded:
    """The same of what each mount passes on (..., mounts, orders, 3, 3), complex, in N/m."""
    value = (passing @ np.moveaxis(motion.value, -1, -2)[..., None])[..., 0]
    rounding = (6.0 + DATA_ROUNDINGS) * UNIT_ROUNDOFF
    spread = motion.error + rounding * np.abs(motion.value)
    error = (np.abs(passing) @ np.moveaxis(spread, -1, -2)[..., None])[..., 0]
    return Bounded(np.moveaxis(value, -2, -1), np.moveaxis(error, -2, -1))


# ----------------------------------------------------------------------------
# Readings of a rigid body's motion: forces of the mounts on the ground.
# ----------------------------------------------------------------------------


def mount_readout(
    stretch: np.ndarray, stiffness: np.ndarray, damping: np.ndarray, structural: np.ndarray
) -> Readout:
    """Force of each mount on what it stands on, rows of three components, by its `stretch`."""
    rounding = (8 + DATA_ROUNDINGS) * UNIT_ROUNDOFF
    return Readout((stiffness + 1j * structural) @ stretch, damping @ stretch, rounding)
