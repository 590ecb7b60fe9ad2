"""Where strong damping moves resonances to, and how narrow they are there."""

import numpy as np

from vibecalc.numerics.rounding import WithError
from vibecalc.response.matrices import Matrices
from vibecalc.response.modes import Modes
from vibecalc.response.resonance import Resonances

#: a wider resonance is seen by any grid of speeds
_WIDE = 0.7


def with_damped_poles(
    resonances: Resonances, matrices: Matrices, shapes: Modes, force: WithError
) -> Resonances:
    """Tell a search of the resonances that stand beside the undamped natural frequencies.

    A mount with a strong damper hardly moves, and the body swings about it: lightly damped, at
    frequencies that no undamped mode has. They are the roots s of
    (s^2 M + s C + K + iH) v = 0 with a positive imaginary part, solved in modal coordinates.
    `force` (orders, 6) is that of `resonances`. A root without damping to speak of, whose nearest
    mode seems damped, takes that mode's place: damping leaves a combination of close modes alone.
    """
    scale = float(np.max(shapes.natural_frequency))
    vector = shapes.shape
    stiffness = vector.T @ (matrices.stiffness + 1j * matrices.structural) @ vector / scale**2
    damping = vector.T @ matrices.damping @ vector / scale
    unit = np.eye(len(stiffness))
    roots, states = np.linalg.eig(np.block([[0.0 * unit, unit], [-stiffness, -damping]]))
    swinging = np.flatnonzero(roots.imag > 1e-9 * np.abs(roots))
    swinging = swinging[np.argsort(roots.imag[swinging], kind="stable")]
    roots, swing = roots[swinging], vector @ states[: len(unit), swinging]
    frequency, ratio = scale * roots.imag, np.abs(roots.real) / np.abs(roots)
    away = np.abs(frequency[:, None] - resonances.frequency)

    nearest = np.argmin(away, axis=1)
    bare = ratio < resonances.half_width[nearest]
    bare &= resonances.damping_ratio[nearest] >= resonances.half_width[nearest]
    place, which = nearest[bare], np.flatnonzero(bare)
    found = resonances._replace(
        frequency=resonances.frequency.copy(),
        damping_ratio=resonances.damping_ratio.copy(),
        idle=resonances.idle.copy(),
    )
    found.frequency[place], found.damping_ratio[place] = frequency[which], ratio[which]
    driven = np.abs(force.value @ swing[:, which])
    found.idle[:, place] = driven <= 4.0 * (force.error @ np.abs(swing[:, which]))

    # closer than half its width to a natural frequency, it is seen from there
    new = ~bare & (ratio < _WIDE) & np.all(away > 0.5 * (ratio * frequency)[:, None], axis=1)
    return found._replace(moved_frequency=frequency[new], moved_ratio=ratio[new])
