"""A body whose mounts have a stiffness of their own at each frequency: matrices, modes, resonances.

A mode is one of the body with the stiffness of its own natural frequency, which solves

    w^2 = (r-th eigenvalue of M^-1 K(w))

for each r. The left side outgrows the right one, so that there is a lowest solution; it is
bracketed between rows of the curves and closed by Brent's method.
"""

from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibecalc.numerics.linear import Linear
from vibecalc.numerics.rounding import EPSILON, UNIT_ROUNDOFF
from vibecalc.parts.mounts import Mounts
from vibecalc.response.modes import Modes, modes

if TYPE_CHECKING:
    from vibecalc.parts.mount_curves import Spectrum

# ----------------------------------------------------------------------------
# The matrices at any frequency: each mount has a block, and its factor at the frequency.
# ----------------------------------------------------------------------------


class SpectralSystem(NamedTuple):
    """Matrices (f, f) of bodies, part of whose stiffness is `blocks` (n, f, f) times a `spectrum`.

    `constant` has mass, damping and the rest of the stiffness; errors of the blocks are absolute.
    """

    constant: Linear
    blocks: np.ndarray
    errors: np.ndarray
    spectrum: "Spectrum"

    def at(self, rate: Any) -> Linear:
        """Matrices (..., f, f) of vibration at rates (...), rad/s."""
        factor = self.spectrum(rate)
        total, size = self._sum(factor), np.abs(factor)
        rounding = 4.0 * UNIT_ROUNDOFF * np.abs(self.blocks)
        error = np.tensordot(size, self.errors + rounding, 1)
        lost = np.tensordot(np.abs(factor.imag), self.errors + rounding, 1)
        whole = Linear(*(np.broadcast_to(part, error.shape) for part in self.constant))
        return whole._replace(
            stiffness=whole.stiffness + total.real,
            structural=whole.structural + total.imag,
            stiffness_error=whole.stiffness_error + error,
            structural_error=whole.structural_error + lost,
        )

    def slope(self, rate: Any, derivative: int) -> np.ndarray:
        """Derivative of K + iH (..., f, f) by the rate."""
        return self._sum(self.spectrum(rate, derivative))

    def _sum(self, factor: np.ndarray) -> np.ndarray:
        return np.asarray(np.tensordot(factor, self.blocks, 1))


def spectral_system(constant: Linear, mounts: Mounts, stretch: np.ndarray) -> SpectralSystem:
    """Of bodies on mounts with a spectrum, whose deflections are `stretch` (mounts, 3, f).

    `constant` (f, f) are their matrices without the stiffness of the mounts.
    """
    if mounts.spectrum is None:
        raise ValueError("the stiffness of these mounts is constant")
    blocks = stretch.mT @ mounts.stiffness @ stretch
    share: Any = 16.0 * UNIT_ROUNDOFF
    if mounts.relative_error is not None:
        share = share + mounts.relative_error[:, None, None]
    errors = share * (np.abs(stretch).mT @ np.abs(mounts.stiffness) @ np.abs(stretch))
    return SpectralSystem(constant, 0.5 * (blocks + blocks.mT), errors, mounts.spectrum)


# ----------------------------------------------------------------------------
# Modes, each of the matrices at its own natural frequency.
# ----------------------------------------------------------------------------

#: parts of an interval between two rows in which a crossing is looked for
_PARTS = 8


def own_modes(system: SpectralSystem) -> Modes:
    """Modes, each of the matrices at its own frequency, so that shapes are not orthogonal."""
    from scipy.optimize import brentq

    rows = system.spectrum.rows()
    between = [np.linspace(*ends, _PARTS, endpoint=False) for ends in pairwise(rows)]
    grid = np.unique(np.concatenate([[0.0], *between, rows[-1:]]))
    levels = _eigenvalues(system.at(grid))
    below = levels <= np.square(grid)[:, None]
    found = []
    for place, first in enumerate(np.argmax(below, axis=0)):

        def gap(rate: float, place: int = place) -> float:
            return float(_eigenvalues(system.at(rate))[place]) - rate * rate

        rate = grid[first] if below[first, place] else np.sqrt(levels[-1, place])
        if first and gap(grid[first - 1]) > 0.0 > gap(rate):
            ends = grid[first - 1], rate
            rate = brentq(gap, *ends, xtol=EPSILON * rate, rtol=8.0 * EPSILON)
        one = Modes(*(part[..., place] for part in modes(system.at(rate))))
        slope = one.shape @ system.slope(rate, 1).real @ one.shape
        growth = slope / max(2.0 * one.natural_frequency, 1e-300)
        off = one.natural_frequency_error + np.abs(one.natural_frequency - rate)
        error = off / np.abs(1.0 - growth) if growth != 1.0 else np.inf
        found.append(one._replace(natural_frequency_error=np.asarray(error)))
    return Modes(*(np.stack(parts, axis=-1) for parts in zip(*found, strict=True)))


def _eigenvalues(matrices: Linear) -> np.ndarray:
    """Eigenvalues (..., f) of M^-1 K, ascending."""
    lower = np.linalg.cholesky(matrices.mass)
    half = np.linalg.solve(lower, matrices.stiffness)
    reduced = np.linalg.solve(lower, half.mT)
    return np.asarray(np.linalg.eigvalsh(0.5 * (reduced + reduced.mT)))
