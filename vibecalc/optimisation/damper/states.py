"""Complex amplitudes of a line with its damper, with all first derivatives, by direct solution."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.optimisation.damper.problem import Damper
from vibecalc.optimisation.damper.relative import System
from vibecalc.optimisation.damper.speed_torque import torque_at

#: roundings granted to each entry of the matrix; elimination of so few unknowns adds as many
_ROUNDINGS = 4


class States(NamedTuple):
    """Unknowns (s, m, n + 1) of `System` at s speeds, and derivatives (4, s, m, n + 1).

    Derivatives by the logarithms of ring inertia, stiffness and damping, then by speed in rad/s.
    """

    speed: FloatArray
    value: ComplexArray
    slope: ComplexArray


def solve(matrix: ComplexArray, right: ComplexArray) -> ComplexArray:
    """Solutions (..., n, r), with rows and columns brought to equal size first."""
    size = 1.0 / np.sqrt(np.abs(np.diagonal(matrix, axis1=-2, axis2=-1)) + 1e-300)
    # a resonating diagonal says nothing of its row
    size = np.minimum(size, 1.0 / np.sqrt(np.max(np.abs(matrix), axis=-1)) * 1e3)
    try:
        found = np.linalg.solve(
            size[..., :, None] * matrix * size[..., None, :], size[..., :, None] * right
        )
    except np.linalg.LinAlgError:
        found = np.full_like(right, np.nan)
    found = size[..., :, None] * found
    if not np.all(np.isfinite(found)):
        raise NumericalFailure(
            "an order meets an undamped natural frequency of the line with its damper"
        )
    return np.asarray(found)


def states(system: System, damper: Damper, speed: FloatArray) -> States:
    """Solve at speeds (s,) in rad/s; raises NumericalFailure on an undamped resonance."""
    order = np.asarray(system.problem.order, dtype=float)
    w = speed[:, None] * order
    torque, torque_slope = torque_at(system.problem.torque, speed)
    matrix = system.dynamic(damper, w)
    unknowns = matrix.shape[-1]
    right = np.zeros((*w.shape, unknowns, 3), dtype=complex)
    right[..., 0] = torque @ system.angle
    right[..., -1, 1] = 1.0
    right[..., 2] = system.ring
    found = solve(matrix, right)
    u, spring, ring = np.moveaxis(found, -1, 0)
    mass = system.mass + damper.inertia * np.outer(system.ring, system.ring)
    by_frequency = u @ (1j * system.loss) - 2.0 * w[..., None] * (u @ mass)
    by_frequency[..., -1] += 1j * damper.damping * u[..., -1]
    pushed = torque_slope @ system.angle - order[:, None] * by_frequency
    relative = u[..., -1:]
    slope = np.stack([
        damper.inertia * w[..., None] ** 2 * ring * (u @ system.ring)[..., None],
        -damper.stiffness * spring * relative,
        -1j * damper.damping * w[..., None] * spring * relative,
        solve(matrix, pushed[..., None])[..., 0],
    ])  # fmt: skip
    return States(speed, u, slope)


def solution_error(system: System, damper: Damper, speed: FloatArray) -> FloatArray:
    """Bound (s, m, n + 1) on round-off of `states`: |A^-1| (|A| |u| + |b|) times a few roundings.

    R. D. Skeel's componentwise bound (1979), with the inverse as computed.
    """
    w = speed[:, None] * np.asarray(system.problem.order, dtype=float)
    matrix = system.dynamic(damper, w)
    torque = torque_at(system.problem.torque, speed)[0] @ system.angle
    inverse = solve(matrix, np.broadcast_to(np.eye(matrix.shape[-1], dtype=complex), matrix.shape))
    u = np.einsum("...ij,...j->...i", inverse, torque)
    # the sums that form an entry may cancel: w^2 J against the stiffness
    mass = system.mass + damper.inertia * np.outer(system.ring, system.ring)
    size = np.abs(system.spring) + w[..., None, None] * np.abs(system.loss)
    size = size + w[..., None, None] ** 2 * mass
    size[..., -1, -1] += damper.stiffness + w * damper.damping
    load = np.einsum("...ij,...j->...i", size, np.abs(u)) + np.abs(torque)
    grown = np.einsum("...ij,...j->...i", np.abs(inverse), load)
    bound: FloatArray = _ROUNDINGS * UNIT_ROUNDOFF * np.asarray(grown)
    return bound
