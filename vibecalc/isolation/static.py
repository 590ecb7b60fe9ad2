"""A rigid body at rest on its mounts under gravity."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.isolation.rigid_body import displacement_at
from vibecalc.numerics.rounding import DATA_ROUNDINGS, SINGULAR, UNIT_ROUNDOFF
from vibecalc.response.matrices import Matrices


class Static(NamedTuple):
    """Small displacements at rest, errors absolute.

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
    mass: float, centre: np.ndarray, gravity: float, up: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Weight as force and couple (6,) about the reference point, and its error; `up` is unit."""
    pull = -mass * gravity * np.asarray(up, dtype=float)
    load = np.concatenate([pull, np.cross(centre, pull)])
    terms = np.abs(displacement_at(np.asarray(centre))).T @ np.abs(pull)
    return load, (4 + DATA_ROUNDINGS) * UNIT_ROUNDOFF * terms


def static_deflection(
    matrices: Matrices,
    position: np.ndarray,
    stiffness: np.ndarray,
    mass: float,
    centre: np.ndarray,
    gravity: float,
    up: np.ndarray,
) -> Static:
    """Linear deflection under the body's own weight.

    Parameters
    ----------
    matrices : from `assemble`, with the same mounts.
    position, stiffness : (mounts, 3) m and (mounts, 3, 3) N/m.
    mass, centre : kg and (3,) m, mass centre from the reference point.
    gravity, up : m/s^2 and unit vector (3,) against which it acts.

    Raises NumericalFailure if the mounts leave the body free, to rounding, or if the shares do
    not add up to the weight within their error.
    """
    load, load_error = weight_load(mass, centre, gravity, up)
    inverse = _flexibility(matrices)
    body = inverse @ load
    body = body + inverse @ (load - matrices.stiffness @ body)
    spread = matrices.stiffness_error + 8.0 * UNIT_ROUNDOFF * np.abs(matrices.stiffness)
    body_error = np.abs(inverse) @ (spread @ np.abs(body) + load_error)
    _require_digits(matrices, body, body_error)

    transform = displacement_at(position)
    motion = transform @ body
    motion_error = np.abs(transform) @ (body_error + 8.0 * UNIT_ROUNDOFF * np.abs(body))
    force = (stiffness @ motion[..., None])[..., 0]
    size = np.abs(stiffness)
    rounding = (4.0 + DATA_ROUNDINGS) * UNIT_ROUNDOFF
    force_error = (size @ (motion_error + rounding * np.abs(motion))[..., None])[..., 0]
    share, share_error = -force @ up, force_error @ np.abs(up)
    doubt = 10.0 * (np.sum(share_error) + load_error[:3] @ np.abs(up))
    if not abs(np.sum(share) - mass * gravity) <= doubt:
        raise NumericalFailure(
            f"the static forces of the mounts add up to {np.sum(share):.12g} N and the weight is "
            f"{mass * gravity:.12g} N: the stiffness matrices of the mounts are not symmetric"
        )
    return Static(
        body, body_error, -motion @ up, motion_error @ np.abs(up), force, force_error,
        share, share_error,
    )  # fmt: skip


def _flexibility(matrices: Matrices) -> np.ndarray:
    """Inverse of the stiffness, formed in coordinates of unit mass."""
    scale = 1.0 / np.sqrt(np.diagonal(matrices.mass))
    scaled = matrices.stiffness * np.outer(scale, scale)
    try:
        inverse: np.ndarray = np.linalg.inv(scaled) * np.outer(scale, scale)
    except np.linalg.LinAlgError:
        raise NumericalFailure(_free("exactly")) from None
    if not np.all(np.isfinite(inverse)):
        raise NumericalFailure(_free("exactly"))
    return inverse


def _require_digits(matrices: Matrices, body: np.ndarray, error: np.ndarray) -> None:
    """Refuse a deflection of which fewer than four digits are certain."""
    weight = np.sqrt(np.diagonal(matrices.mass))
    loss = np.max(weight * error)
    if not loss < SINGULAR * max(np.max(weight * np.abs(body)), np.finfo(float).tiny):
        raise NumericalFailure(_free("to rounding"))


def _free(how: str) -> str:
    return (
        f"the mounts leave the body free in some direction ({how}): its stiffness matrix cannot "
        f"be inverted; add a mount or give the mounts stiffness in the missing direction"
    )
