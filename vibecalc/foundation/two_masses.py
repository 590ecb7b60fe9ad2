"""Kernel: a force on a mass, whose mounts stand on a second mass on a spring; up and down only.

With K = k + i (loss + w c) of mounts and of foundation, u of the machine and v of the foundation::

    (K1 - w^2 m1) u - K1 v = F            (K1 + K2 - w^2 m2) v - K1 u = 0

so that with p = K1 - w^2 m1 and q = K2 - w^2 m2 the determinant is p q - w^2 m1 K1. On a rigid
foundation v = 0 and the force K1 u on it is F K1 / p.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, SINGULAR, BoolArray, ComplexArray, FloatArray

#: roundings of a few products and one difference
_ROUNDINGS = 8.0


class TwoMasses(NamedTuple):
    """Masses in kg, stiffness in N/m, damping in N s/m; all may carry leading axes.

    `structural` is loss factor times stiffness.
    """

    machine_mass: FloatArray
    mount_stiffness: FloatArray
    mount_damping: FloatArray
    mount_structural: FloatArray
    foundation_mass: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    structural: FloatArray


class TwoMassMotion(NamedTuple):
    """Complex amplitudes (..., orders), 0 to peak, with absolute errors; N and m.

    `machine` and `foundation` are displacements, `ground_force` acts on what carries the
    foundation, `rigid_force` is what the mounts would pass to a rigid one.
    """

    machine: Bounded
    foundation: Bounded
    ground_force: Bounded
    rigid_force: Bounded


def motion(
    system: TwoMasses, force: ComplexArray, force_error: FloatArray, frequency: FloatArray
) -> TwoMassMotion:
    """Steady motion under a force (..., orders) in N at `frequency` (..., orders) in rad/s.

    Leading axes are those of the masses.

    Raises NumericalFailure where a force acts at an undamped natural frequency, of both masses or
    of the machine on a rigid foundation.
    """
    w, one = frequency, TwoMasses(*(np.asarray(part)[..., None] for part in system))
    acts = np.abs(force) > 0.0
    mounts = one.mount_stiffness + 1j * (one.mount_structural + w * one.mount_damping)
    below = one.stiffness + 1j * (one.structural + w * one.damping)
    inertia = w**2 * one.machine_mass
    p, q = mounts - inertia, below - w**2 * one.foundation_mass
    whole = p * q - inertia * mounts
    # a difference loses the digits that its terms have in common
    terms = (np.abs(mounts) + inertia) * (np.abs(below) + w**2 * one.foundation_mass)
    terms = terms + inertia * np.abs(mounts)
    lost = _lost(whole, terms, acts, w, "machine and foundation")
    lost_rigid = _lost(p, np.abs(mounts) + inertia, acts, w, "the machine on a rigid foundation")
    whole, p = np.where(acts, whole, 1.0), np.where(acts, p, 1.0)

    def answer(factor: ComplexArray, share: FloatArray) -> Bounded:
        value = factor * force
        return Bounded(value, np.abs(factor) * force_error + share * np.abs(value))

    return TwoMassMotion(
        machine=answer(np.asarray((mounts + q) / whole), lost + _ROUNDINGS * EPSILON),
        foundation=answer(np.asarray(mounts / whole), lost),
        ground_force=answer(np.asarray(mounts * below / whole), lost),
        rigid_force=answer(np.asarray(mounts / p), lost_rigid),
    )


def _lost(
    difference: NDArray[Any], terms: FloatArray, acts: BoolArray, frequency: FloatArray, what: str
) -> FloatArray:
    """Relative rounding of a difference `difference` of `terms`; 0 where no force acts."""
    rounding = _ROUNDINGS * EPSILON * terms
    lost = acts & (SINGULAR * np.abs(difference) <= rounding)
    if lost.any():
        at = float(np.broadcast_to(frequency, lost.shape)[lost][0])
        raise NumericalFailure(
            f"{what}: a force acts at an undamped natural frequency, {at:.6g} rad/s; give mounts "
            "or foundation some damping, or another speed"
        )
    return np.asarray(np.where(acts, rounding / np.where(acts, np.abs(difference), 1.0), 0.0))


def natural_frequencies(system: TwoMasses) -> FloatArray:
    """Undamped natural frequencies (..., 2) in rad/s, the lower first.

    Roots of m1 m2 x^2 - (m1 (k1 + k2) + m2 k1) x + k1 k2 in x = w^2; the smaller one from the
    product of both, which loses no digits.
    """
    m1, m2 = system.machine_mass, system.foundation_mass
    k1, k2 = system.mount_stiffness, system.stiffness
    middle = 0.5 * (m1 * (k1 + k2) + m2 * k1)
    apart = np.hypot(0.5 * (m1 * (k1 + k2) - m2 * k1), np.sqrt(m1 * m2) * k1)
    upper = (middle + apart) / (m1 * m2)
    return np.sqrt(np.stack([k1 * k2 / (m1 * m2 * upper), upper], axis=-1))
