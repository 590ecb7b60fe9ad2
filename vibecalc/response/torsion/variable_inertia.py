"""A shaft line whose inertias change with the crank angle: its data and what they are at an angle.

The pistons of a cylinder add m (ds/dtheta)^2 to the inertia of their throw, rods likewise. With
theta_i = w t + phi_i the Lagrangian 1/2 sum J_i(theta_i) theta_i'^2 - V gives exactly

    J_i(theta_i) phi_i'' + 1/2 J_i'(theta_i) (w + phi_i')^2 + (C phi' + K phi)_i = T_i,

a dash at J being the derivative by theta.

Source: Pasricha and Carnegie (1976), Effects of variable inertia on the damped torsional
vibrations of diesel engine systems, Journal of Sound and Vibration 46.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.response.torsion.line import Line

_SAMPLES = 16


class VariableLine(NamedTuple):
    """A line, its inertias' variation, who takes up the mean torque, and the length of a cycle.

    `line.inertia` (n,) is the mean over a turn. `variation` (n, H) complex in kg m^2 holds the
    orders 1 .. H: J_i(theta) = J_i + Re sum_h variation_ih exp(i h theta). `load` (n,) is the share
    of every freedom in the mean torque taken up by what is driven, which is whatever keeps the
    speed; it counts on pieces without ground stiffness only. `turns` is 2 for a four-stroke cycle
    (orders k / 2) and 1 for a two-stroke one.
    """

    line: Line
    variation: ComplexArray
    load: FloatArray
    turns: int


class Inertia(NamedTuple):
    """Inertias and their first two derivatives by the angle, (..., n) in kg m^2."""

    value: FloatArray
    slope: FloatArray
    curvature: FloatArray


def variable_line(
    line: Line, variation: ArrayLike, *, turns: int = 2, load: ArrayLike | None = None
) -> VariableLine:
    """A line with variation (n, H); without `load` each freedom takes a share like its inertia.

    Raises
    ------
    NumericalFailure
        An inertia does not stay positive over the turn though it varies.
    """
    change = np.asarray(variation, dtype=np.complex128)
    share = line.inertia if load is None else np.asarray(load, dtype=np.float64)
    system = VariableLine(line, change, np.asarray(share, dtype=np.float64), turns)
    highest = max(change.shape[-1], 1)
    angle = np.arange(_SAMPLES * highest) * (2.0 * np.pi / (_SAMPLES * highest))
    least = inertia_at(system, angle[:, None]).value.min(axis=0)
    wrong = (least <= 0.0) & change.any(axis=-1)
    if wrong.any():
        station = int(np.argmax(wrong))
        raise NumericalFailure(
            f"variable inertia: freedom {station + 1} falls to {least[station]:.4g} kg m^2 over "
            f"the turn, with a mean of {line.inertia[station]:.4g} kg m^2; a mean holds half of "
            "the reciprocating parts' inertia at least"
        )
    return system


def inertia_variation(inertia_torque: ArrayLike) -> ComplexArray:
    """Variation (..., H) in kg m^2 from the inertia torque's harmonics of the orders 1 .. H.

    At constant speed the torque is -1/2 w^2 dJ/dtheta, whence J_h = 2 i T_h / h with T_h complex,
    0-to-peak, in N m per (rad/s)^2: sums over the cylinders of a station, rods included, pass on.
    """
    torque = np.asarray(inertia_torque, dtype=np.complex128)
    return np.asarray(2.0j * torque / np.arange(1, torque.shape[-1] + 1))


def inertia_at(system: VariableLine, angle: FloatArray) -> Inertia:
    """Inertias at the crank angles (..., n) of the freedoms, rad."""
    highest = system.variation.shape[-1]
    order = np.arange(1, highest + 1)
    turned = np.exp(1j * np.asarray(angle)[..., None] * order) * system.variation
    value = system.line.inertia + turned.real.sum(axis=-1)
    slope = -(order * turned.imag).sum(axis=-1)
    curvature = -(order**2 * turned.real).sum(axis=-1)
    return Inertia(value, slope, curvature)


def free_pieces(line: Line) -> FloatArray:
    """Rows (r, n) of ones and zeros: the freedoms of each piece that no ground stiffness holds."""
    n = line.inertia.shape[-1]
    piece = np.arange(n)
    for a, b, k in zip(line.first, line.second, line.stiffness, strict=True):
        if k != 0.0:
            piece[piece == piece[b]] = piece[a]
    rows = [(piece == one).astype(np.float64) for one in np.unique(piece)]
    free = [row for row in rows if not np.any(row * line.ground_stiffness)]
    return np.array(free).reshape(-1, n)
