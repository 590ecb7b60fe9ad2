"""Kernel: a machine on mounts on a flexible foundation, its dynamic stiffness given by tables.

A foot under the force f moves by A f, A (3, 3) diagonal with 1 over the dynamic stiffness of each
direction, 0 where it is rigid. Mount and foot in series pass (1 + k A)^-1 k. A plate moves by
Y (6,) about its reference point, against its own dynamic stiffness Z, and not in the directions in
which it is rigid; it has no mass but that in Z:

    (sum B^T (1 + k A)^-1 k B + Z - w^2 M) (X, Y) = (F, 0)

Feet do not feel each other but through the plate. An impedance Z_v counts as the dynamic stiffness
i w Z_v.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.foundation.two_bodies import mount_stretch
from vibecalc.isolation.at_mounts import mount_stiffness
from vibecalc.numerics.bounded import Bounded, reshaped
from vibecalc.numerics.linear import Dynamics, response
from vibecalc.numerics.rounding import SINGULAR, UNIT_ROUNDOFF, ComplexArray, FloatArray
from vibecalc.parts.body import RigidBody
from vibecalc.parts.mounts import Mounts

_ROUNDINGS = 64.0


class Curve(NamedTuple):
    """Complex dynamic stiffness (rows,), or impedance, at ascending frequencies in rad/s."""

    frequency: FloatArray
    value: ComplexArray
    by_velocity: bool

    def at(self, frequency: FloatArray) -> ComplexArray:
        """Dynamic stiffness, straight between rows, real and imaginary part each; ends hold."""
        found = np.interp(frequency, self.frequency, self.value.real) + 1j * np.interp(
            frequency, self.frequency, self.value.imag
        )
        return np.asarray(1j * frequency * found if self.by_velocity else found)


class FlexibleFoundation(NamedTuple):
    """Curves below the feet by (mount, direction), and of the plate by direction.

    `position` (3,) of the plate's reference point from that of the machine, m.
    """

    feet: dict[tuple[int, int], Curve]
    plate: dict[int, Curve]
    position: FloatArray


class CoupledMotion(NamedTuple):
    """Complex amplitudes (frequencies, ...), with absolute errors.

    `machine` (6) and `plate` (6) about their reference points, `force` (mounts, 3) of each mount
    on its foot, `foot` (mounts, 3) its motion, `ground` (6) force and couple on the foundation
    about the reference point of the machine. `power` is the mean power into the foundation, W.
    """

    machine: Bounded
    plate: Bounded
    force: Bounded
    foot: Bounded
    ground: Bounded
    power: Bounded


def on_flexible_foundation(
    body: RigidBody,
    mounts: Mounts,
    foundation: FlexibleFoundation,
    frequency: FloatArray,
    load: Bounded,
) -> CoupledMotion:
    """Motion of machine and foundation under loads (frequencies, ..., 6) at rad/s.

    Raises NumericalFailure where of a response fewer than four digits are certain, or where a
    dynamic stiffness is zero.
    """
    own = reshaped(mount_stiffness(mounts, frequency), lambda one: np.moveaxis(one, 0, 1))
    compliance = _feet(len(mounts.names), foundation, frequency)
    share = np.linalg.inv(np.eye(3) + own.value @ compliance)  # of the deflection, in the mount
    value = share @ own.value
    error = np.abs(share) @ own.error @ np.abs(share).mT
    series = Bounded(value, error + _ROUNDINGS * UNIT_ROUNDOFF * np.abs(value))
    stretch = mount_stretch(mounts, foundation.position)
    size = np.abs(stretch)
    kept = np.array([*range(6), *(6 + direction for direction in sorted(foundation.plate))])
    whole = np.einsum("mai,fmab,mbj->fij", stretch, series.value, stretch)
    terms = np.einsum("mai,fmab,mbj->fij", size, np.abs(series.value), size)
    error = np.einsum("mai,fmab,mbj->fij", size, error, size)
    squared = np.square(frequency)[:, None, None]
    mass = body.bounded_mass()
    whole[:, :6, :6] -= squared * mass.value
    terms[:, :6, :6] += squared * np.abs(mass.value)
    error[:, :6, :6] += squared * mass.error
    for direction, curve in foundation.plate.items():
        place = 6 + direction
        whole[:, place, place] += curve.at(frequency)
        terms[:, place, place] += np.abs(curve.at(frequency))
    error += _ROUNDINGS * UNIT_ROUNDOFF * terms
    whole, terms, error = (part[:, kept[:, None], kept] for part in (whole, terms, error))
    found = _solved(whole, terms, error, load, frequency)
    both = Bounded(
        np.zeros((*found.shape[:-1], 12), dtype=complex), np.zeros((*found.shape[:-1], 12))
    )
    both.value[..., kept], both.error[..., kept] = found.value, found.error
    return _read(both, stretch, series, compliance, frequency)


def _feet(count: int, foundation: FlexibleFoundation, frequency: FloatArray) -> ComplexArray:
    """Compliance (frequencies, mounts, 3, 3) of the feet, m/N."""
    found = np.zeros((len(frequency), count, 3, 3), dtype=complex)
    for (mount, direction), curve in foundation.feet.items():
        stiffness = curve.at(frequency)
        if np.any(stiffness == 0.0):
            at = float(frequency[stiffness == 0.0][0]) / (2.0 * np.pi)
            raise NumericalFailure(
                f"the dynamic stiffness below mount {mount + 1} is zero at {at:.6g} Hz: nothing "
                "carries it there; give the table an imaginary part"
            )
        found[:, mount, direction, direction] = 1.0 / stiffness
    return found


def _solved(
    whole: ComplexArray,
    terms: FloatArray,
    error: FloatArray,
    load: Bounded,
    frequency: FloatArray,
) -> Bounded:
    """Motion (frequencies, ..., kept) of all coordinates."""
    scale = 1.0 / np.sqrt(np.maximum(np.einsum("fii->fi", terms), np.finfo(float).tiny))
    weight = scale[:, :, None] * scale[:, None, :]
    try:
        inverse = np.linalg.inv(whole * weight) * weight
    except np.linalg.LinAlgError:
        raise NumericalFailure(_singular(frequency[0])) from None
    more, count = load.value.ndim - 2, whole.shape[-1]
    shape = (len(frequency), *(1,) * more, count, count)
    system = Dynamics(*(part.reshape(shape) for part in (whole, error, inverse)))
    pad = [(0, 0)] * (load.value.ndim - 1) + [(0, count - 6)]
    value, spread = (np.pad(part, pad) for part in (load.value, load.error))
    found = response(system, value, spread)
    size = np.abs(found.value) / scale.reshape(len(frequency), *(1,) * more, count)
    # of the matrices alone: a load that is rounding of zero is not judged
    driven = np.any(np.abs(value) > 4.0 * spread, axis=-1)
    carried = (np.abs(system.inverse) @ (system.error @ np.abs(found.value)[..., None]))[..., 0]
    lost = np.max(carried / scale.reshape(len(frequency), *(1,) * more, count), axis=-1)
    poor = driven & ~(lost < SINGULAR * np.max(size, axis=-1))
    if np.any(poor):
        raise NumericalFailure(_singular(float(frequency[np.argwhere(poor)[0][0]])))
    return found


def _singular(frequency: float) -> str:
    return (
        f"machine and foundation have no steady motion at {frequency / (2.0 * np.pi):.6g} Hz: mass "
        "and stiffness cancel there and nothing damps; give the mounts damping or a loss factor, "
        "or the tables of the foundation a part that takes energy"
    )


def _read(
    both: Bounded,
    stretch: FloatArray,
    series: Bounded,
    compliance: ComplexArray,
    frequency: FloatArray,
) -> CoupledMotion:
    """Forces, feet, ground and power of a motion (frequencies, ..., 12)."""
    more = both.value.ndim - 2
    shape = (len(frequency), *(1,) * more, *series.shape[1:])
    series = reshaped(series, lambda one: one.reshape(shape))
    compliance = compliance.reshape(shape)
    column = Bounded(both.value[..., None, :, None], both.error[..., None, :, None])
    force = (series @ stretch.astype(complex) @ column)[..., 0]
    arms = stretch[..., :6].mT
    bent = Bounded(force.value[..., None], force.error[..., None])
    ground = (arms @ bent)[..., 0].sum(-2)
    carried = (-stretch[..., 6:].astype(complex) @ Bounded(
        both.value[..., None, 6:, None], both.error[..., None, 6:, None]
    ))[..., 0]  # fmt: skip
    give = (compliance @ bent)[..., 0]
    foot = give + carried
    rate = frequency.reshape(-1, *(1,) * (more + 2))
    speed = Bounded(1j * rate * foot.value, rate * foot.error)
    conjugate = Bounded(np.conj(force.value), force.error)
    power = (speed * conjugate).real.sum(-1).sum(-1) * 0.5
    return CoupledMotion(both[..., :6], both[..., 6:], force, foot, ground, power)
