"""The pitch model: a rigid machine that only turns about the axis across its crankshaft."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, rounded, where
from vibecalc.numerics.rounding import DATA_ROUNDINGS, SINGULAR, UNIT_ROUNDOFF
from vibecalc.response.resonances import Resonances

# ----------------------------------------------------------------------------
# The pitch model: a rigid machine that only turns about the axis across its crankshaft.
#
# With x along the crankshaft, z up and the angle right-handed about y, a mount at x moves by
# -x * angle along z. Source: N. Gibson, Dynamics 3 assignment (2008), equations 13 to 19, whose
# "4 L^2 k" is the sum of k x^2 over four mounts at x = +L and -L.
# ----------------------------------------------------------------------------


class Pitch(NamedTuple):
    """One freedom, all fields broadcastable over leading axes; errors are absolute.

    `inertia` (kg m^2), `stiffness`, `structural` (loss factor times stiffness; both N m/rad),
    `damping` (N m s/rad), undamped `natural_frequency` (rad/s), `damping_ratio` (viscous share
    plus half the loss factor, exact at the natural frequency), and `rounding`, the relative error
    that stiffness, structural and damping share as sums of positive terms.
    """

    inertia: np.ndarray
    stiffness: np.ndarray
    structural: np.ndarray
    damping: np.ndarray
    natural_frequency: np.ndarray
    natural_frequency_error: np.ndarray
    damping_ratio: np.ndarray
    damping_ratio_error: np.ndarray
    rounding: float


def pitch_model(
    inertia: np.ndarray | float,
    position: np.ndarray,
    stiffness: np.ndarray,
    damping: np.ndarray,
    structural: np.ndarray,
) -> Pitch:
    """Sums over the mounts (last axis) of what resists pitching.

    Parameters
    ----------
    inertia : (...) about the pitch axis, kg m^2.
    position : (..., mounts) along the crankshaft from the pitch axis, m.
    stiffness, damping, structural : (..., mounts) vertical, N/m, N s/m and N/m (loss factor
        times stiffness), none negative. The total stiffness has to be positive.

    Source: Gibson (2008), equations 13 to 15.
    """
    moment_of_inertia = np.asarray(inertia, dtype=float)
    lever_squared = np.square(position)
    total_stiffness = np.sum(stiffness * lever_squared, axis=-1)
    total_damping = np.sum(damping * lever_squared, axis=-1)
    total_structural = np.sum(structural * lever_squared, axis=-1)
    frequency = np.sqrt(total_stiffness / moment_of_inertia)
    ratio = 0.5 * (
        total_damping / (frequency * moment_of_inertia) + total_structural / total_stiffness
    )
    rounding = (np.shape(position)[-1] + 2 + DATA_ROUNDINGS) * UNIT_ROUNDOFF
    return Pitch(
        moment_of_inertia,
        total_stiffness,
        total_structural,
        total_damping,
        frequency,
        rounding * frequency,
        ratio,
        2.0 * rounding * ratio,
        rounding,
    )


def pitch_dynamic_stiffness(pitch: Pitch, frequency: np.ndarray) -> Bounded:
    """K (1 + i loss) + i w C - w^2 I at excitation frequencies (..., orders), in N m/rad.

    The error holds what is left of the digits where stiffness and inertia cancel.
    """
    stiffness = pitch.stiffness[..., None]
    inertial = np.square(frequency) * pitch.inertia[..., None]
    lagging = pitch.structural[..., None] + frequency * pitch.damping[..., None]
    value = (stiffness - inertial) + 1j * lagging
    loss = (pitch.rounding + 2.0 * UNIT_ROUNDOFF) * np.hypot(stiffness + inertial, lagging)
    return Bounded(value, loss)


def angle_harmonics(
    pitch: Pitch,
    couple: Bounded,
    frequency: np.ndarray,
    left_out: np.ndarray | bool = False,
) -> Bounded:
    """Complex pitch angle (rad, 0-pk) under couples about +y, per order.

    Parameters
    ----------
    couple : (..., orders) N m, complex 0-pk at each order.
    frequency : (..., orders) rad/s, order times crank speed.
    left_out : (..., orders) orders that do not drive the undamped machine: their angle is zero.

    Source: Gibson (2008), equation 17, with the phase kept. Trusts that no driven order stands on
    an undamped resonance: `vibecalc.response.resonances` refuses that before.
    """
    resisting = pitch_dynamic_stiffness(pitch, frequency)
    return couple * where(left_out, 0.0, 1.0 / where(left_out, 1.0, resisting))


def _passing(pitch: Pitch, frequency: np.ndarray) -> Bounded:
    """K (1 + i loss) + i w C (..., orders): couple on the ground per angle, in N m/rad."""
    lagging = pitch.structural[..., None] + frequency * pitch.damping[..., None]
    value = pitch.stiffness[..., None] + 1j * lagging
    return Bounded(value, (pitch.rounding + 5.0 * UNIT_ROUNDOFF) * np.abs(value))


def transmissibility(pitch: Pitch, frequency: np.ndarray) -> Bounded:
    """Complex couple on the ground over couple on the body, at frequencies (..., orders).

    Infinite on an undamped natural frequency, where the order must not be driven. Source: Gibson
    (2008), equation 18, with the phase kept.
    """
    resisting = pitch_dynamic_stiffness(pitch, frequency)
    lost = resisting.error >= SINGULAR * np.abs(resisting.value)
    ratio = _passing(pitch, frequency) / where(lost, 1.0, resisting)
    return where(lost, Bounded(np.asarray(np.inf), np.zeros(())), ratio)


def transmitted_couple(pitch: Pitch, angle: Bounded, frequency: np.ndarray) -> Bounded:
    """Complex couple of all mounts on the ground (..., orders), in N m, from the pitch angle."""
    return _passing(pitch, frequency) * angle


def support_displacement(angle: Bounded, position: np.ndarray) -> Bounded:
    """Vertical displacement (..., mounts, orders) of the body at mounts along x, in m, z up."""
    return angle[..., None, :] * -np.asarray(position)[..., :, None]


def support_force(
    displacement: Bounded,
    frequency: np.ndarray,
    stiffness: np.ndarray,
    damping: np.ndarray,
    structural: np.ndarray,
) -> Bounded:
    """Vertical force of each mount on the ground (..., mounts, orders), N, positive up.

    A mount that is pressed down presses the ground down: the force has the sign of the
    displacement. `frequency` is (..., orders), the properties are (..., mounts).
    """
    spring = np.asarray(stiffness)[..., :, None] + 1j * np.asarray(structural)[..., :, None]
    damper = np.asarray(damping)[..., :, None] * np.asarray(frequency)[..., None, :]
    return rounded(spring + 1j * damper, 1.0 + DATA_ROUNDINGS) * displacement


def support_share(position: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
    """Force of each mount on the ground per unit couple about +y, body held still, in 1/m.

    The quasi-static share -k x / sum of k x^2: what `support_force` tends to at low frequency, and
    in stiff mounts of the same stiffness ratios at any frequency.
    """
    moment = np.asarray(stiffness) * position
    share: np.ndarray = -moment / np.sum(moment * position, axis=-1, keepdims=True)
    return share


def lever_force(couple: Bounded, lever: np.ndarray | float) -> Bounded:
    """Couple over a lever, in N: the source's own reading of "the force on a support".

    It is the force of one pair of supports a distance `lever` from the pitch axis if that pair
    alone resisted; four equal supports carry a quarter each. Source: Gibson, equations 11, 12.
    """
    return couple / lever


# ----------------------------------------------------------------------------
# How mounts along the crankshaft share the weight: heave and pitch, nothing else.
# ----------------------------------------------------------------------------


class PitchStatic(NamedTuple):
    """Sag (..., mounts) in m, positive down, and share of the weight (..., mounts) in N."""

    sag: np.ndarray
    sag_error: np.ndarray
    share: np.ndarray
    share_error: np.ndarray


def pitch_static(
    weight: np.ndarray | float,
    centre: np.ndarray | float,
    position: np.ndarray,
    stiffness: np.ndarray,
) -> PitchStatic:
    """Vertical equilibrium and moments about the pitch axis; equal sag across the crankshaft.

    Parameters
    ----------
    weight, centre : (...) in N and m along the crankshaft.
    position, stiffness : (..., mounts) in m and N/m, vertical.

    About the stiffness-weighted mean position the two freedoms part: all mounts sink by
    W / sum k, and turn by the moment of the weight over the pitch stiffness about that point.
    Raises NumericalFailure if all mounts stand at one position and the weight does not.
    """
    load = np.asarray(weight, dtype=float)[..., None]
    total = np.sum(stiffness, axis=-1, keepdims=True)
    mean = np.sum(stiffness * position, axis=-1, keepdims=True) / total
    arm = position - mean
    turning = np.sum(stiffness * np.square(arm), axis=-1, keepdims=True)
    offset = np.asarray(centre, dtype=float)[..., None] - mean
    extent = np.sum(stiffness * np.abs(position), axis=-1, keepdims=True) / total
    rounding = (np.shape(position)[-1] + 4 + DATA_ROUNDINGS) * UNIT_ROUNDOFF
    uncertainty = rounding * (np.abs(np.asarray(centre))[..., None] + 2.0 * extent)
    flat = turning <= np.square(uncertainty) * total
    if np.any(flat & (np.abs(offset) > uncertainty)):
        raise NumericalFailure(
            "all mounts stand at one position along the crankshaft and the mass centre does not: "
            "the machine would tip; move a mount"
        )
    tilt = np.where(flat, 0.0, offset / np.where(flat, 1.0, turning))
    sag = load / total + load * tilt * arm
    share = stiffness * sag
    size = load / total + np.abs(load * tilt * arm)
    slope = np.where(flat, 0.0, load / np.where(flat, 1.0, turning))
    extent_uncertainty = uncertainty * (np.abs(arm) + np.abs(offset))
    error = rounding * 3.0 * size + slope * extent_uncertainty
    # the error of the mean position enters the pitch stiffness in second order only
    return PitchStatic(sag, error, share, stiffness * error + UNIT_ROUNDOFF * np.abs(share))


# ----------------------------------------------------------------------------
# Where an order may meet the natural frequency of a pitching body.
# ----------------------------------------------------------------------------


def pitch_resonances(pitch: Pitch, couple: Bounded) -> Resonances:
    """The one resonance of a pitch model (...), for couples (..., orders) at any scale."""
    loss = 2.0 * (pitch.rounding + 2.0 * UNIT_ROUNDOFF)
    return Resonances(
        np.asarray(pitch.natural_frequency)[..., None],
        np.asarray(pitch.damping_ratio)[..., None],
        np.array([0.5 * loss / SINGULAR]),
        (np.abs(couple.value) <= 4.0 * couple.error)[..., None],
    )
