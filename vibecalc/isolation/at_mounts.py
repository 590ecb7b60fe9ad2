"""What loads and motions of a body do at its mounts: deflections, and forces on the ground."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.isolation.rows import Readout
from vibecalc.numerics.bounded import Bounded, reshaped, rounded
from vibecalc.numerics.linear import Dynamics, Linear, law, resisting, response, uncertain
from vibecalc.numerics.rounding import DATA_ROUNDINGS, UNIT_ROUNDOFF
from vibecalc.parts.matrices import displacement_at
from vibecalc.parts.mounts import Mounts

# ----------------------------------------------------------------------------
# A body at rest on its mounts, under its weight or whatever else is constant.
# ----------------------------------------------------------------------------


class Resting(NamedTuple):
    """How a constant load at the reference point is borne, in coordinates (f,).

    `matrices` (..., f, f) with the stiffness against loads that stay; `reach` (..., 6, f) takes the
    coordinates to the motion of the reference point, `stretch` (..., mounts, d, f) to the
    deflections of the mounts, whose `stiffness` is (..., mounts, d, d).
    """

    matrices: Linear
    reach: np.ndarray
    stretch: np.ndarray
    stiffness: np.ndarray


class AtMounts(NamedTuple):
    """Of each mount (..., mounts, d): displacement of the body in m, force on the ground in N."""

    displacement: Bounded
    force: Bounded


def weight_load(
    mass: ArrayLike,
    centre: np.ndarray,
    gravity: ArrayLike,
    up: np.ndarray,
    centre_error: np.ndarray | None = None,
) -> Bounded:
    """Weight as force and couple (..., 6) about the reference point; `up` is a unit vector (3,)."""
    pull = np.multiply(-np.asarray(mass), gravity)[..., None] * np.asarray(up, dtype=float)
    arm, off = displacement_at(centre).mT, np.zeros(())
    if centre_error is not None:
        off = np.abs(displacement_at(centre_error)).mT
        off[..., :3, :] = 0.0
    return (Bounded(arm, off) @ rounded(pull, 2 + DATA_ROUNDINGS)[..., None])[..., 0]


def deflected(rest: Resting, load: Bounded) -> AtMounts:
    """Linear deflection of the mounts under a constant load (..., 6) at the reference point.

    Raises NumericalFailure if the mounts do not restrain the body, to rounding.
    """
    stiffness, felt = rest.matrices.stiffness, (load[..., None, :] @ rest.reach)[..., 0, :]
    system = Dynamics(stiffness, rest.matrices.stiffness_error, _flexibility(rest.matrices))
    body, mass = response(system, *felt), rest.matrices.mass
    if np.any(uncertain(mass, body)):
        # a load that is nothing but rounding is no fault of the mounts
        of_known = response(system, felt.value, np.zeros_like(felt.value))
        if np.any(uncertain(mass, of_known)):
            raise NumericalFailure(_free("to rounding"))
    motion = (rest.stretch @ body[..., None, :, None])[..., 0]
    force = rounded(rest.stiffness, 4 + DATA_ROUNDINGS) @ motion[..., None]
    return AtMounts(motion, force[..., 0])


def require_weight(share: Bounded, load: Bounded) -> None:
    """Refuse shares (..., mounts) of a weight, a `load` (..., 6), that they do not add up to.

    Raises NumericalFailure: the stiffness matrices of the mounts are not symmetric.
    """
    total, weight = share.value.sum(-1), np.linalg.norm(load.value[..., :3], axis=-1)
    uncertainty = 10.0 * (share.error.sum(-1) + load.error[..., :3].sum(-1))
    if not np.all(np.abs(total - weight) <= uncertainty):
        raise NumericalFailure(
            f"the static forces of the mounts add up to {np.ravel(total)[0]:.12g} N and the weight "
            f"is {np.ravel(weight)[0]:.12g} N: the stiffness matrices of the mounts are not "
            "symmetric"
        )


def _flexibility(matrices: Linear) -> np.ndarray:
    """Inverse of the stiffness, formed in coordinates of unit mass."""
    scale = 1.0 / np.sqrt(np.linalg.diagonal(matrices.mass))
    weight = scale[..., :, None] * scale[..., None, :]
    try:
        inverse: np.ndarray = np.linalg.inv(matrices.stiffness * weight) * weight
    except np.linalg.LinAlgError:
        inverse = np.full(weight.shape, np.inf)
    if not np.all(np.isfinite(inverse)):
        raise NumericalFailure(_free("exactly"))
    return inverse


def _free(how: str) -> str:
    return (
        f"the mounts do not restrain the body in some direction ({how}): its stiffness matrix "
        "cannot be inverted; add a mount or give the mounts stiffness in the missing direction"
    )


# ----------------------------------------------------------------------------
# What a moving body does at its mounts: displacements, and forces on the ground.
# ----------------------------------------------------------------------------


def displacement(stretch: np.ndarray, motion: Bounded) -> Bounded:
    """Displacement (..., mounts, d, orders) in m by a motion X (..., orders, f)."""
    found = stretch[..., None, :, :, :] @ motion[..., :, None, :, None]
    return reshaped(found[..., 0], lambda part: np.moveaxis(part, -3, -1))


def mount_stiffness(mounts: Mounts, frequency: np.ndarray) -> Bounded:
    """What each mount passes on (..., mounts, orders, d, d) in N/m, at rad/s (..., orders).

    Its error is rounding, and what the load at rest leaves uncertain of the stiffness.
    """
    rate = np.asarray(frequency)[..., None, :, None, None]
    stiffness, structural, damping = (
        part[..., :, None, :, :] for part in (mounts.stiffness, mounts.structural, mounts.damping)
    )
    if mounts.spectrum is not None:
        by_order = np.moveaxis(mounts.spectrum(frequency), -1, -2)[..., None, None] * stiffness
        stiffness, structural = by_order.real, by_order.imag
    value = resisting(stiffness, structural, damping, rate)
    error = (6.0 + DATA_ROUNDINGS) * UNIT_ROUNDOFF * np.abs(value)
    if mounts.relative_error is not None:
        still, _ = law(stiffness, structural, damping)
        error = error + mounts.relative_error[:, None, None, None] * np.abs(still)
    return Bounded(value, error)


def mount_readout(
    stretch: np.ndarray, stiffness: np.ndarray, damping: np.ndarray, structural: np.ndarray
) -> Readout:
    """Force of each mount on what it stands on, rows of d components, by its `stretch`."""
    rounding = (8 + DATA_ROUNDINGS) * UNIT_ROUNDOFF
    still, rising = law(stiffness, structural, damping)
    return Readout(still @ stretch, rising @ stretch, rounding)
