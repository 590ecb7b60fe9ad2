"""Damping of modes: given by a ratio for each, or so strong that it moves their resonances."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.bounded import Bounded, reshaped
from vibecalc.numerics.leading import leave_alone
from vibecalc.numerics.linear import Linear
from vibecalc.response.modes import Modes
from vibecalc.response.resonances import Resonances

# ----------------------------------------------------------------------------
# Damping that is given mode by mode, as a matrix.
# ----------------------------------------------------------------------------


def with_modal_damping(matrices: Linear, shapes: Modes, ratio: float) -> Linear:
    """The same with a damping that gives each mode the ratio zeta, 1 is critical.

    C = M V diag(2 zeta w) V^T M with unit modal mass, in N s/m, N s, N m s; it couples no modes.
    A mode without stiffness stays without damping. The ratio counts as exact.

    Source: W. T. Thomson, Theory of Vibration with Applications, 5th ed., chapter 6.
    """
    momentum = Bounded(matrices.mass, matrices.mass_error) @ shapes.bounded_shape
    rate = 2.0 * ratio * shapes.bounded_frequency
    added = (momentum * rate[..., None, :]) @ reshaped(momentum, np.matrix_transpose)
    return matrices._replace(
        damping=matrices.damping + 0.5 * (added.value + added.value.mT),
        damping_error=matrices.damping_error + added.error,
    )


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
    `force` (..., orders, 6) are those of `resonances`. A root without damping to speak of, whose
    nearest mode seems damped, takes that mode's place: damping leaves a combination of close modes
    alone.

    Of many machines (..., modes), which have no such root or are run alone, the moved resonances
    have as many places as the machine with the most of them, NaN for none.
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
    leave_alone(np.any(bare, axis=-1))
    moved = np.where(new, frequency, np.nan)
    rising = np.argsort(moved, axis=-1)[..., : np.max(np.sum(new, axis=-1))]
    replaced = resonances._replace(
        frequency=resonances.frequency.copy(),
        damping_ratio=resonances.damping_ratio.copy(),
        idle=resonances.idle.copy(),
        moved_frequency=np.take_along_axis(moved, rising, -1),
        moved_ratio=np.take_along_axis(np.where(new, ratio, np.nan), rising, -1),
    )
    which = np.flatnonzero(bare)
    for pole in which[np.argsort(frequency[which], kind="stable")] if len(which) else ():
        place = nearest[pole]
        replaced.frequency[place], replaced.damping_ratio[place] = frequency[pole], ratio[pole]
        swing = shapes.shape @ states[: len(shapes.shape), pole]
        drives = np.abs(force.value @ swing) > 4.0 * (force.error @ np.abs(swing))
        replaced.idle[..., place] = ~np.any(drives, axis=tuple(range(drives.ndim - 1)))
    return replaced
