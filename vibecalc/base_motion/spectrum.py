"""Kernel: mean squares of the responses to a motion of the base that is a spectrum."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.gauss import GaussRule, gauss_rule
from vibecalc.numerics.rounding import EPSILON, FloatArray

# ----------------------------------------------------------------------------
# With the one-sided density S(f) of the acceleration of the base and the response H(f) to a unit
# of it, the mean square is the integral of |H|^2 S over the table. |H|^2 is rational in f and S is
# smooth between two rows of the table: Gauss rules of 12 and 20 points on panels that end at the
# rows and stand densely around each resonance; a panel where both differ is cut in halves.
# ----------------------------------------------------------------------------

_FEW, _MANY = 12, 20
_ROUNDS, _PANELS = 40, 4000
#: of the largest of its kind: the square of what rounding leaves where nothing moves
_NOTHING = 1e-24
#: in half widths of a resonance, where panels end on either side of it
_STEPS = np.array([0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0])


class Density(NamedTuple):
    """One-sided density (rows,) for each hertz at frequencies (rows,) in rad/s, both ascending.

    It is that of the acceleration, or of the velocity.
    """

    frequency: FloatArray
    density: FloatArray
    logarithmic: bool
    by_velocity: bool

    def at(self, frequency: FloatArray) -> FloatArray:
        """Densities of the acceleration at frequencies in rad/s, zero outside of the table."""
        if self.logarithmic:
            drawn = np.interp(np.log(frequency), np.log(self.frequency), np.log(self.density))
            found = np.exp(drawn)
        else:
            found = np.interp(frequency, self.frequency, self.density)
        inside = (frequency >= self.frequency[0]) & (frequency <= self.frequency[-1])
        return np.where(inside, found * frequency**2 if self.by_velocity else found, 0.0)


def panel_ends(densities: list[Density], natural: FloatArray, ratio: FloatArray) -> FloatArray:
    """First ends of panels in rad/s: rows of the tables, and steps around the resonances."""
    rows = np.concatenate([one.frequency for one in densities])
    low, high = rows.min(), rows.max()
    width = np.maximum(ratio, 1e-7)[:, None] * _STEPS
    around = natural[:, None] * np.concatenate([1.0 - width, 1.0 + width], axis=1)
    inside = around[(around > low) & (around < high)]
    even = np.geomspace(low, high, 9)
    ends = np.sort(np.concatenate([rows, inside, even]))
    apart = np.concatenate([[True], np.diff(ends) > 1e-12 * ends[1:]])
    return np.asarray(ends[apart])


#: of frequencies (n,) in rad/s to what is integrated, each (n, its own axes)
Powers = Callable[[FloatArray], Mapping[str, FloatArray]]


def mean_squares(powers: Powers, ends: FloatArray, tolerance: float) -> dict[str, Bounded]:
    """Integral over f (Hz) of each of the `powers`.

    `ends` (panels + 1,) in rad/s. Each entry is good to `tolerance` of itself, or to what rounding
    leaves of the largest in its array.

    Raises NumericalFailure where that takes too many panels.
    """
    shapes = {name: part.shape[1:] for name, part in powers(ends[:1]).items()}
    sizes = [int(np.prod(shape)) for shape in shapes.values()]
    alike = np.repeat(np.arange(len(sizes)), sizes)
    few, many = gauss_rule(_FEW), gauss_rule(_MANY)
    low, high = ends[:-1], ends[1:]
    total: FloatArray | None = None
    lost: FloatArray = np.zeros(())
    for _ in range(_ROUNDS):
        rough, fine = (_panels(powers, rule, low, high) for rule in (few, many))
        off = np.abs(fine - rough)
        first = fine.sum(axis=0)
        whole = first if total is None else total + first
        # a panel may leave its share of the tolerance, or what rounding leaves of the whole
        largest = np.zeros(int(alike.max()) + 1)
        np.maximum.at(largest, alike, whole)
        allowed = np.maximum(tolerance / 32.0, 4.0 * EPSILON) * whole + _NOTHING * largest[alike]
        poor = np.any(off > allowed / len(ends) ** 0.5, axis=1) & (high - low > 1e-13 * high)
        good = fine[~poor].sum(axis=0)
        total = good if total is None else total + good
        lost = lost + off[~poor].sum(axis=0)
        if not np.any(poor):
            error = lost + 64.0 * EPSILON * total + _NOTHING * largest[alike]
            each = np.split(np.stack([total, error]), np.cumsum(sizes)[:-1], axis=-1)
            named = zip(shapes.items(), each, strict=True)
            return {name: Bounded(*part.reshape(2, *shape)) for (name, shape), part in named}
        middle = 0.5 * (low[poor] + high[poor])
        low, high = np.concatenate([low[poor], middle]), np.concatenate([middle, high[poor]])
        if len(low) > _PANELS:
            break
    raise NumericalFailure(
        "the mean squares of the responses to the spectrum of the base do not settle: a resonance "
        "within the spectrum has next to no damping; give the mounts damping or a loss factor"
    )


def _panels(powers: Powers, rule: GaussRule, low: FloatArray, high: FloatArray) -> FloatArray:
    """Integral over each panel (panels, entries), per hertz."""
    width = high - low
    at = low[:, None] + width[:, None] * rule.nodes
    every = [part.reshape(*at.shape, -1) for part in powers(at.ravel()).values()]
    found = np.concatenate(every, axis=-1)
    return np.asarray(np.einsum("pqr,q->pr", found, rule.weights) * width[:, None] / (2.0 * np.pi))
