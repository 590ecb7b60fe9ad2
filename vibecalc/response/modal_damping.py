"""What a mode is made of, what damps it, and which resonances that makes."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.leading import leave_alone
from vibecalc.numerics.linear import Linear
from vibecalc.numerics.rounding import SINGULAR, UNIT_ROUNDOFF
from vibecalc.response.modes import Modes, clusters, largest_positive, repeated
from vibecalc.response.resonances import Resonances

# ----------------------------------------------------------------------------
# What a mode is made of, and what damps it.
# ----------------------------------------------------------------------------


def energy_fraction(matrices: Linear, shapes: Modes, translations: int = 0) -> Bounded:
    """Share of each coordinate in the kinetic energy of each mode, and its error.

    The first `translations` coordinates are those of a point of the body, with a diagonal block of
    mass. Shares are about the mass centre, whichever the point: (M v)_i^2 / M_ii of a translation,
    v_i (S v)_i of a rotation, with the Schur complement S of the translations, the inertia about
    the mass centre. Without translations they are v_i (M v)_i. Value and error are (..., modes, f).
    Each row sums to 1; with products of inertia an entry can be slightly negative.
    """
    along, about = slice(None, translations), slice(translations, None)
    mass, mass_error = matrices.mass, matrices.mass_error
    vector, off = shapes.shape, shapes.shape_error
    weight = np.diagonal(mass[..., along, along], axis1=-2, axis2=-1)[..., None]
    levers = mass[..., along, about] / weight
    turning = mass[..., about, about] - mass[..., about, along] @ levers
    size = np.abs(mass)
    # as large as what cancels in it
    terms = size[..., about, about] + size[..., about, along] @ np.abs(levers)
    turning_error = mass_error[..., about, about] + 2.0 * (
        np.abs(levers.mT) @ mass_error[..., along, about]
    )
    rounding = 10.0 * UNIT_ROUNDOFF
    pushed = mass[..., along, :] @ vector
    pushed_error = size[..., along, :] @ (off + rounding * np.abs(vector)) + (
        mass_error[..., along, :] @ np.abs(vector)
    )
    turned, spin, spin_off = (one[..., about, :] for one in (vector, np.abs(vector), off))
    carried = turning @ turned
    carried_error = terms @ (spin_off + rounding * spin) + turning_error @ spin
    energy = np.concatenate([pushed * pushed / weight, turned * carried], axis=-2)
    error = np.concatenate(
        [
            2.0 * np.abs(pushed) * pushed_error / weight,
            spin_off * np.abs(carried) + spin * carried_error,
        ],
        axis=-2,
    )
    total = np.sum(energy, axis=-2, keepdims=True)
    return Bounded((energy / total).mT, (error / total).mT)


def damping_ratio(matrices: Linear, shapes: Modes) -> Bounded:
    """Damping ratio of each mode (..., modes), and its error: v C v / (2 w) + v H v / (2 w^2).

    Exact for proportional damping, the usual estimate otherwise; the structural part is half the
    loss factor that the mode sees at its own frequency. Raises NumericalFailure for a mode that
    nothing holds, whose ratio has no meaning.
    """
    free = shapes.eigenvalue <= shapes.eigenvalue_error
    if np.any(free):
        number = int(np.argwhere(free)[0, -1]) + 1
        raise NumericalFailure(
            f"mode {number} has no damping ratio: nothing holds the body in it (its stiffness is "
            f"zero to rounding); give the mounts stiffness in that direction"
        )
    frequency = shapes.natural_frequency
    vector, size = shapes.shape, np.abs(shapes.shape)
    viscous = np.sum(vector * (matrices.damping @ vector), axis=-2) / (2.0 * frequency)
    loss = np.sum(vector * (matrices.structural @ vector), axis=-2) / (2.0 * shapes.eigenvalue)
    rounding = 14.0 * UNIT_ROUNDOFF

    def uncertainty(matrix: np.ndarray, matrix_error: np.ndarray) -> np.ndarray:
        spread = matrix_error + rounding * np.abs(matrix)
        moved = np.abs(matrix @ vector)
        total: np.ndarray = np.sum(
            size * (spread @ size) + 2.0 * shapes.shape_error * moved, axis=-2
        )
        return total

    relative = shapes.eigenvalue_error / shapes.eigenvalue + 4.0 * UNIT_ROUNDOFF
    error = (
        uncertainty(matrices.damping, matrices.damping_error) / (2.0 * frequency)
        + uncertainty(matrices.structural, matrices.structural_error) / (2.0 * shapes.eigenvalue)
        + relative * (np.abs(viscous) + np.abs(loss))
    )
    return Bounded(viscous + loss, error)


def modal_force(shapes: Modes, force: np.ndarray, force_error: np.ndarray) -> Bounded:
    """Force (..., 6) on each mode (..., modes), with the error up to which it may be zero."""
    size = np.abs(shapes.shape)
    value = force @ shapes.shape
    error = force_error @ size + np.abs(force) @ (shapes.shape_error + 8.0 * UNIT_ROUNDOFF * size)
    return Bounded(value, error)


# ----------------------------------------------------------------------------
# Damping that is given mode by mode, as a matrix.
# ----------------------------------------------------------------------------


def modal_damping(matrices: Linear, shapes: Modes, ratio: np.ndarray) -> Bounded:
    """Damping matrix C (6, 6) that gives each mode its ratio zeta (6,), and its absolute error.

    C = M V diag(2 zeta w) V^T M with unit modal mass, in N s/m, N s, N m s; it couples no modes.
    A mode without stiffness stays without damping. Of repeated modes the shapes are a choice (see
    `Modes`): the matrix depends on it unless their ratios agree. The ratios count as exact.

    Source: W. T. Thomson, Theory of Vibration with Applications, 5th ed., chapter 6.
    """
    zeta = np.asarray(ratio, dtype=float)
    frequency = shapes.natural_frequency
    size_of_mass, size = np.abs(matrices.mass), np.abs(shapes.shape)
    momentum = matrices.mass @ shapes.shape
    momentum_error = (
        size_of_mass @ (shapes.shape_error + 6.0 * UNIT_ROUNDOFF * size)
        + matrices.mass_error @ size
    )
    rate = 2.0 * zeta * frequency
    rate_error = 2.0 * np.abs(zeta) * shapes.natural_frequency_error
    value = (momentum * rate[..., None, :]) @ momentum.mT
    large = np.abs(momentum)
    rounding = 10.0 * UNIT_ROUNDOFF * np.abs(rate) + rate_error
    one_side = (momentum_error * np.abs(rate)[..., None, :]) @ (large + 0.5 * momentum_error).mT
    error = (large * rounding[..., None, :]) @ large.mT + one_side + one_side.mT
    return Bounded(0.5 * (value + value.mT), error)


# ----------------------------------------------------------------------------
# Repeated modes as the damping sees them: each with a damping of its own.
# ----------------------------------------------------------------------------

#: a smaller coupling, relative to the largest loss, is round-off
_COUPLED = 1e-13


def damped_basis(matrices: Linear, shapes: Modes) -> Modes:
    """The same modes, with repeated ones turned until the damping does not couple them.

    Modes of one frequency may be combined at will. Where some combination has no damping, an order
    on that frequency has no bound, though each mode of another basis seems damped. The loss that
    counts is H + w C at their own frequency w. A basis that it does not couple stays as it is.
    """
    groups = list(repeated(clusters(shapes.eigenvalue, shapes.eigenvalue_error)))
    if not groups:
        return shapes
    turned, uncertainty = shapes.shape.copy(), shapes.shape_error.copy()
    structural, damping = (
        np.broadcast_to(part, turned.shape) for part in (matrices.structural, matrices.damping)
    )
    for place, members in groups:
        basis = shapes.shape[place][:, members]
        frequency = float(np.mean(shapes.natural_frequency[place][members]))
        loss = basis.T @ (structural[place] + frequency * damping[place]) @ basis
        coupling = np.max(np.abs(loss - np.diag(np.diagonal(loss))))
        if not coupling > _COUPLED * np.max(np.diagonal(loss)):
            continue
        _, turn = np.linalg.eigh(0.5 * (loss + loss.T))
        turned[place][:, members] = basis @ turn
        spread = shapes.shape_error[place][:, members] + 8.0 * UNIT_ROUNDOFF * np.abs(basis)
        uncertainty[place][:, members] = spread @ np.abs(turn)
    signs = largest_positive(matrices.mass, turned)[..., None, :]
    return shapes._replace(shape=turned * signs, shape_error=uncertainty)


# ----------------------------------------------------------------------------
# Where an order may meet a natural frequency of a rigid body, and how close it may come.
# ----------------------------------------------------------------------------


def body_resonances(matrices: Linear, shapes: Modes, force: Bounded) -> Resonances:
    """Resonances of a rigid body under forces (..., orders, 6) in complex amplitude, any scale."""
    ratio = damping_ratio(matrices, shapes).value
    size = np.abs(shapes.shape)
    uncertainty_k = matrices.stiffness_error + 2.0 * UNIT_ROUNDOFF * np.abs(matrices.stiffness)
    uncertainty_m = matrices.mass_error + 4.0 * UNIT_ROUNDOFF * np.abs(matrices.mass)
    loss = np.sum(size * (uncertainty_k @ size), axis=-2) / shapes.eigenvalue
    loss = loss + np.sum(size * (uncertainty_m @ size), axis=-2)
    return Resonances(
        shapes.natural_frequency, np.abs(ratio), 0.5 * loss / SINGULAR, idle_modes(shapes, force)
    )


def idle_modes(shapes: Modes, force: Bounded) -> np.ndarray:
    """Pairs (..., orders, modes) of which forces (..., orders, 6) do not drive the mode."""
    driven = modal_force(shapes, force.value, force.error)
    return np.asarray(np.abs(driven.value) <= 4.0 * driven.error)


# ----------------------------------------------------------------------------
# Where strong damping moves resonances to, and how narrow they are there.
# ----------------------------------------------------------------------------

#: a wider resonance is seen by any grid of speeds
_WIDE = 0.7


class DampedPoles(NamedTuple):
    """Roots s of (s^2 M + s C + K + iH) v = 0, each of a system (..., f, f).

    `root` (..., 2 f) in rad/s times `scale` (...); `state` (..., 2 f, 2 f) has in its upper half
    the motions in modal coordinates, in columns, and below them their derivatives.
    """

    root: np.ndarray
    state: np.ndarray
    scale: np.ndarray


def damped_poles(matrices: Linear, shapes: Modes) -> DampedPoles:
    """Poles with damping, solved in modal coordinates; leading axes as of matrices and shapes."""
    scale = np.max(shapes.natural_frequency, axis=-1)
    per_scale = (1.0 / scale)[..., None, None]
    vector = shapes.shape
    hysteretic = matrices.stiffness + 1j * matrices.structural
    stiffness = vector.mT @ hysteretic @ vector * np.square(per_scale)
    damping = vector.mT @ matrices.damping @ vector * per_scale
    size = stiffness.shape[-1]
    system = np.zeros((*stiffness.shape[:-2], 2 * size, 2 * size), dtype=complex)
    system[..., range(size), range(size, 2 * size)] = 1.0
    system[..., size:, :size], system[..., size:, size:] = -stiffness, -damping
    return DampedPoles(*np.linalg.eig(system), scale)


def with_damped_poles(
    resonances: Resonances,
    matrices: Linear,
    shapes: Modes,
    force: Bounded,
    poles: DampedPoles | None = None,
) -> Resonances:
    """Tell a search of the resonances that stand next to the undamped natural frequencies.

    A mount with a strong damper hardly moves, and the body swings about it: lightly damped, at
    frequencies that no undamped mode has. They are the `poles` with a positive imaginary part.
    `force` (orders, 6) is that of `resonances`. A root without damping to speak of, whose nearest
    mode seems damped, takes that mode's place: damping leaves a combination of close modes alone.

    Of many machines (..., modes), which have no such root or are run alone, the moved resonances
    are (..., 2 f), NaN for none.
    """
    roots, states, scale = poles or damped_poles(matrices, shapes)
    swings = roots.imag > 1e-9 * np.abs(roots)
    frequency = np.where(swings, np.asarray(scale)[..., None] * roots.imag, np.inf)
    ratio = np.abs(roots.real) / np.where(swings, np.abs(roots), 1.0)
    away = np.abs(frequency[..., None] - resonances.frequency[..., None, :])
    nearest = np.argmin(away, axis=-1)
    seeming = np.take_along_axis(resonances.damping_ratio, nearest, -1)
    negligible = np.take_along_axis(resonances.half_width, nearest, -1)
    bare = swings & (ratio < negligible) & (seeming >= negligible)
    # closer than half its width to a natural frequency, it is seen from there
    new = swings & ~bare & (ratio < _WIDE)
    new &= np.all(away > 0.5 * (ratio * np.where(swings, frequency, 0.0))[..., None], axis=-1)
    if roots.ndim > 1:
        leave_alone(np.any(bare, axis=-1))
        absent = np.where(new, 0.0, np.nan)
        return resonances._replace(
            moved_frequency=np.where(new, frequency, 0.0) + absent, moved_ratio=ratio + absent
        )
    which = np.flatnonzero(bare)
    which = which[np.argsort(frequency[which], kind="stable")]
    place = nearest[which]
    replaced = resonances._replace(
        frequency=resonances.frequency.copy(),
        damping_ratio=resonances.damping_ratio.copy(),
        idle=resonances.idle.copy(),
    )
    replaced.frequency[place], replaced.damping_ratio[place] = frequency[which], ratio[which]
    swing = shapes.shape @ states[: shapes.shape.shape[-1], which]
    replaced.idle[:, place] = np.abs(force.value @ swing) <= 4.0 * (force.error @ np.abs(swing))

    moved = np.flatnonzero(new)
    moved = moved[np.argsort(frequency[moved], kind="stable")]
    return replaced._replace(moved_frequency=frequency[moved], moved_ratio=ratio[moved])
